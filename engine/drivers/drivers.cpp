#include "engine/drivers/drivers.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>
#include <system_error>

#include "engine/devices/stiffness_zones.h"
#include "engine/drivers/hapi_driver.h"
#include "geometry/base/printable.h"
#include "geometry/base/quoted.h"

namespace palpate {
namespace {

constexpr const Driver* kDrivers[] = {&kHapiDriver};

std::string shown(std::string_view text) {
  return in_quotes(printable(text));
}

Error key_error(const std::vector<DriverKey>& keys, std::string_view key) {
  std::string names;
  for (const DriverKey& known : keys) {
    names += (names.empty() ? "" : ", ") + std::string(known.name);
  }
  return invalid_argument("", "key is " + shown(key) + "; expected one of " + names);
}

// The number that is the whole of a text, in every locale.
template <typename Number>
std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failed != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<Error> store_number(const DriverKey& key, std::string_view text,
                                  DriverValues& values) {
  const auto refused = [&](const std::string& expected) {
    return invalid_argument(std::string(key.name), "is " + shown(text) + "; expected " + expected);
  };
  if (key.kind == DriverKeyKind::kWhole) {
    const auto least = static_cast<std::int64_t>(key.least);
    const auto most = static_cast<std::int64_t>(key.most);
    const auto number = number_of<std::int64_t>(text);
    if (!number || *number < least || *number > most) {
      return refused("a whole number from " + std::to_string(least) + " to " +
                     std::to_string(most));
    }
    values.set_number(key.name, static_cast<double>(*number));
    return std::nullopt;
  }
  const auto number = number_of<double>(text);
  if (!number || !std::isfinite(*number)) return refused("a finite number");
  values.set_number(key.name, *number);
  return std::nullopt;
}

std::optional<Error> store_value(const std::vector<DriverKey>& keys, std::string_view key,
                                 std::string_view text, DriverValues& values) {
  const auto known =
      std::find_if(keys.begin(), keys.end(), [&](const DriverKey& k) { return k.name == key; });
  if (known == keys.end()) return key_error(keys, key);
  if (known->kind != DriverKeyKind::kText) return store_number(*known, text, values);
  values.set_text(key, text);
  return std::nullopt;
}

std::string delay_line(const DeviceDescription& device) {
  std::ostringstream line;
  line << "      its delay from a sample to the force: ";
  if (!device.delay.is_known()) {
    line << "unknown";
  } else {
    line << 1e3 * device.delay.least_s << " to " << 1e3 * device.delay.most_s << " ms";
  }
  line << "\n";
  return line.str();
}

// At the device's rate and the initial values of all keys; the start of a run measures the delay.
std::string stiffness_lines(const DeviceDescription& device) {
  std::ostringstream lines;
  const auto zones = stiffness_zones(device, 0.0, 1.0 / device.rate_Hz);
  if (!zones) return lines.str();
  const AssumedMechanics& mechanics = zones->mechanics;
  lines << "      its walls at " << device.rate_Hz << " Hz and a delay of "
        << 1e3 * mechanics.delay.most_s << " ms: ";
  if (zones->passive_N_per_m > 0.0) {
    lines << "passive up to " << std::floor(zones->passive_N_per_m) << " N/m";
  } else {
    lines << "none is passive";
  }
  lines << ", stable below " << std::floor(zones->stable_N_per_m)
        << " N/m, calm by the controller up to " << std::floor(zones->calm_N_per_m) << " N/m\n";
  std::string assumed;
  const auto add = [&](bool is_assumed, const std::string& what) {
    if (is_assumed) assumed += (assumed.empty() ? "" : ", ") + what;
  };
  const auto with_unit = [](double number, const char* unit) {
    std::ostringstream text;
    text << number << unit;
    return text.str();
  };
  add(mechanics.assumes_mass, with_unit(mechanics.mass_kg, " kg"));
  add(mechanics.assumes_damping, with_unit(mechanics.damping_Ns_per_m, " N s/m"));
  add(mechanics.assumes_delay, with_unit(1e3 * mechanics.delay.most_s, " ms"));
  if (!assumed.empty()) lines << "      (of a " << kBareTip.name << ": " << assumed << ")\n";
  return lines.str();
}

std::string key_line(const DriverKey& key) {
  constexpr int kNameWidth = 14;
  std::ostringstream line;
  line << "      " << std::left << std::setw(kNameWidth) << key.name << " " << key.meaning;
  if (key.kind != DriverKeyKind::kText) {
    line << "; " << key.least << " to " << std::setprecision(10) << key.most;
  }
  if (key.initial) line << " (" << *key.initial << ")";
  line << "\n";
  return line.str();
}

}  // namespace

std::span<const Driver* const> drivers() {
  return kDrivers;
}

const Driver* find_driver(std::string_view name) {
  for (const Driver* driver : kDrivers) {
    if (driver->name == name) return driver;
  }
  return nullptr;
}

std::string driver_names() {
  std::string names;
  for (const Driver* driver : kDrivers) {
    names += (names.empty() ? "" : ", ") + std::string(driver->name);
  }
  return names;
}

Result<DriverValues> parse_driver_values(const Driver& driver, std::string_view list) {
  const std::vector<DriverKey> keys = driver.keys();
  DriverValues values;
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
    if (auto error = store_value(keys, key, part.substr(equals + 1), values)) return *error;
  }
  return values;
}

Result<std::unique_ptr<GuardableDevice>> make_device(const std::string& option,
                                                     std::string_view text,
                                                     bool works_without_guard) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view name = text.substr(0, colon);
  const Driver* const driver = find_driver(name);
  if (driver == nullptr) {
    const Driver& first = *kDrivers[0];
    return invalid_argument(
        option, "driver is " + shown(name) + "; expected " + driver_names(),
        "for example " + std::string(first.name) + ":" + std::string(first.example));
  }
  const auto in_option = [&](Error error) {
    error.element = error.element.empty() ? option : option + ": " + error.element;
    return error;
  };
  const auto values = parse_driver_values(*driver, text.substr(std::min(colon + 1, text.size())));
  if (!values) return in_option(values.error());
  auto device = driver->make(*values, works_without_guard);
  if (!device) return in_option(device.error());
  return device;
}

std::string drivers_text() {
  std::string text;
  for (const Driver* driver : kDrivers) {
    const std::string name(driver->name);
    text += name + "  " + std::string(driver->what) + "\n      " + name + ":" +
            std::string(driver->example) + "[,KEY=VALUE...]\n";
    for (const DriverKey& key : driver->keys()) text += key_line(key);
    text += delay_line(driver->describe()) + stiffness_lines(driver->describe());
  }
  return text;
}

}  // namespace palpate
