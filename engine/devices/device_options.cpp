#include "engine/devices/device_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <system_error>

#include "geometry/base/printable.h"
#include "geometry/base/quoted.h"

namespace palpate {
namespace {

// A key, and how its number is stored.
struct DeviceKey {
  std::string_view name;
  void (*store)(HapiSettings&, double);
};

constexpr std::array kDeviceKeys = {
    DeviceKey{"base", [](HapiSettings& s, double value) { s.links.base_m = value; }},
    DeviceKey{"proximal", [](HapiSettings& s, double value) { s.links.proximal_m = value; }},
    DeviceKey{"distal", [](HapiSettings& s, double value) { s.links.distal_m = value; }},
    DeviceKey{"torque-per-Nm", [](HapiSettings& s, double value) { s.torque_per_Nm = value; }},
    DeviceKey{"peak-torque", [](HapiSettings& s, double value) { s.peak_torque_Nm = value; }},
    DeviceKey{"counts", [](HapiSettings& s,
                           double value) { s.wiring.counts_per_turn = static_cast<float>(value); }},
    DeviceKey{"angle1", [](HapiSettings& s,
                           double value) { s.wiring.rest_deg[0] = static_cast<float>(value); }},
    DeviceKey{"angle2", [](HapiSettings& s,
                           double value) { s.wiring.rest_deg[1] = static_cast<float>(value); }},
    DeviceKey{"rate", [](HapiSettings& s, double value) { s.rate_Hz = value; }},
};

std::string shown(std::string_view text) {
  return in_quotes(printable(text));
}

Error key_error(std::string_view key) {
  std::string names = "port, dev";
  for (const DeviceKey& known : kDeviceKeys) names += ", " + std::string(known.name);
  return invalid_argument("", "key is " + shown(key) + "; expected one of " + names);
}

// A finite decimal number, in every locale.
std::optional<double> finite_number(std::string_view text) {
  double value = 0.0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = failed == std::errc() && end == text.data() + text.size();
  if (!is_whole || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<Error> store_device(HapiSettings& settings, std::string_view text) {
  unsigned number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_whole = failed == std::errc() && end == text.data() + text.size();
  if (!is_whole || number < 1 || number > 127) {
    return invalid_argument("dev", "is " + shown(text) + "; expected a whole number from 1 to 127");
  }
  settings.wiring.device = static_cast<std::uint8_t>(number);
  return std::nullopt;
}

std::optional<Error> store_setting(HapiSettings& settings, std::string_view key,
                                   std::string_view value) {
  if (key == "port") {
    settings.port = value;
    return std::nullopt;
  }
  if (key == "dev") return store_device(settings, value);
  for (const DeviceKey& known : kDeviceKeys) {
    if (known.name != key) continue;
    const auto number = finite_number(value);
    if (!number) {
      return invalid_argument(std::string(key),
                              "is " + shown(value) + "; expected a finite number");
    }
    known.store(settings, *number);
    return std::nullopt;
  }
  return key_error(key);
}

std::optional<Error> store_settings(HapiSettings& settings, std::string_view list) {
  std::set<std::string_view> seen;
  while (!list.empty()) {
    const std::string_view part = list.substr(0, list.find(','));
    list.remove_prefix(std::min(list.size(), part.size() + 1));
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) {
      return invalid_argument("", "part is " + shown(part) + "; expected key=value");
    }
    const std::string_view key = part.substr(0, equals);
    if (!seen.insert(key).second) {
      return invalid_argument(std::string(key), "is given twice; expected it once");
    }
    if (auto error = store_setting(settings, key, part.substr(equals + 1))) return error;
  }
  return check_hapi_settings(settings);
}

}  // namespace

Result<HapiSettings> parse_device(const std::string& option, std::string_view text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view driver = text.substr(0, colon);
  if (driver != "hapi") {
    return invalid_argument(option, "driver is " + shown(driver) + "; expected hapi",
                            "for example hapi:port=/dev/ttyACM0");
  }
  HapiSettings settings;
  auto error = store_settings(settings, text.substr(std::min(colon + 1, text.size())));
  if (!error) return settings;
  error->element = error->element.empty() ? option : option + ": " + error->element;
  return *error;
}

}  // namespace palpate
