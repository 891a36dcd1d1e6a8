#include "engine/trials/operator_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "engine/trials/key_hash.h"
#include "engine/trials/shipped_files.h"
#include "engine/trials/strict_json.h"
#include "engine/trials/trial_order.h"
#include "geometry/base/random.h"

namespace palpate {
namespace {

using Key = ObjectReader::Key;

Error operator_error(std::string element, std::string problem, std::string hint = {}) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

void check_unit(ObjectReader& reader, std::string_view expected) {
  std::string unit;
  reader.text("unit", unit);
  if (!reader.ok() || unit == expected) return;
  reader.fail(operator_error(reader.element_of("unit"),
                             "is \"" + unit + "\"; expected \"" + std::string(expected) + "\"",
                             "convert low and high to this unit"));
}

std::optional<Error> read_range(const nlohmann::json& value, const std::string& element,
                                const PersonParameter& key, ParameterRange& range) {
  ObjectReader reader(value, element);
  const NumberRange valid{key.least, key.most, key.is_least_out};
  reader.number("low", range.low, valid);
  reader.number("high", range.high, valid);
  if (reader.ok() && range.low > range.high) {
    std::ostringstream text;
    text << "is " << range.high << "; expected at least low, " << range.low;
    reader.fail(operator_error(reader.element_of("high"), text.str(),
                               "exchange them; \"falls\": true lets a parameter fall"));
  }
  check_unit(reader, key.unit);
  reader.text("source", range.source, Key::kRequired, kMostProseBytes);
  range.draw = key.name;
  reader.text("draw", range.draw, Key::kOptional);
  reader.flag("falls", range.falls, Key::kOptional);
  return reader.finish();
}

std::optional<Error> read_ranges(const nlohmann::json& value, const std::string& element,
                                 OperatorFile& file) {
  ObjectReader reader(value, element);
  for (std::size_t i = 0; i < kPersonParameterCount; ++i) {
    const PersonParameter& key = person_parameters()[i];
    const nlohmann::json* const found = reader.find(std::string(key.name).c_str());
    if (!found) continue;
    if (auto error =
            read_range(*found, reader.element_of(std::string(key.name)), key, file.ranges[i])) {
      reader.fail(*error);
    }
  }
  return reader.finish();
}

}  // namespace

const std::array<PersonParameter, kPersonParameterCount>& person_parameters() {
  using P = OperatorParameters;
  static constexpr std::array<PersonParameter, kPersonParameterCount> keys = {{
      {"sight_delay_s", "s", &P::sight_delay_s, 0.0, 10.0, true},
      {"replan_s", "s", &P::replan_s, 0.0, 100.0, true},
      {"gain_per_s", "1/s", &P::gain_per_s, 0.0, 1000.0, false},
      {"force_noise", "1", &P::force_noise, 0.0, 10.0, false},
      {"intention_noise_m", "m", &P::intention_noise_m, 0.0, 1.0, false},
      {"intention_noise_Hz", "Hz", &P::intention_noise_Hz, 0.0, 100.0, true},
      {"hand_stiffness_N_per_m", "N/m", &P::hand_stiffness_N_per_m, 0.0, 1e6, true},
      {"hand_damping_Ns_per_m", "N s/m", &P::hand_damping_Ns_per_m, 0.0, 1e4, false},
      {"press_depth_m", "m", &P::press_depth_m, 0.0, 1.0, true},
      {"speed_m_per_s", "m/s", &P::speed_m_per_s, 0.0, 10.0, false},
  }};
  return keys;
}

// A correction at the rate k of an error that is seen after the delay tau: u'(t) = -k u(t - tau) is
// stable if k tau < pi/2.
std::optional<Error> check_operator(const OperatorFile& file) {
  double delay_s = 0.0;
  double gain_per_s = 0.0;
  for (std::size_t i = 0; i < kPersonParameterCount; ++i) {
    const PersonParameter& key = person_parameters()[i];
    if (key.field == &OperatorParameters::sight_delay_s) delay_s = file.ranges[i].high;
    if (key.field == &OperatorParameters::gain_per_s) gain_per_s = file.ranges[i].high;
  }
  if (gain_per_s * delay_s < 0.5 * std::numbers::pi) return std::nullopt;
  std::ostringstream text;
  text << "is " << gain_per_s << " /s, which times the longest delay, " << delay_s << " s, is "
       << gain_per_s * delay_s << "; expected less than pi/2";
  return operator_error("/parameters/gain_per_s/high", text.str(),
                        "lower it, or lower sight_delay_s");
}

std::string_view shipped_operator_text(std::string_view name) {
  if (name == "literature") return shipped_literature();
  if (name == "people2005") return shipped_people2005();
  return {};
}

Result<OperatorFile> parse_operator(std::string_view text, const std::string& path) {
  const auto json = parse_strict_json(text, path);
  if (!json) return json.error();
  OperatorFile file;
  file.hash = KeyHash().add(text).value();
  ObjectReader reader(*json, "");
  int format = 1;
  reader.whole("palpate_operator", format, 1, 1);
  reader.text("name", file.name);
  reader.whole("version", file.version, 1, 1'000'000);
  reader.text("note", file.note, Key::kOptional, kMostProseBytes);
  if (const auto* const ranges = reader.find("parameters")) {
    if (auto error = read_ranges(*ranges, "/parameters", file)) reader.fail(*error);
  }
  auto error = reader.finish();
  if (!error) error = check_operator(file);
  if (!error) return file;
  error->path = path;
  return *error;
}

Result<OperatorFile> load_operator(const std::string& name_or_path) {
  const std::string_view shipped = shipped_operator_text(name_or_path);
  if (!shipped.empty()) return parse_operator(shipped, name_or_path);
  const auto text = read_settings_text(name_or_path);
  if (!text) return text.error();
  return parse_operator(*text, name_or_path);
}

OperatorParameters draw_person(const OperatorFile& file, std::uint64_t seed, int participant) {
  OperatorParameters person;
  person.comfortable_depth_m = file.comfortable_depth_m;
  for (std::size_t i = 0; i < kPersonParameterCount; ++i) {
    const ParameterRange& range = file.ranges[i];
    SeededRandom random(draw_seed(seed, participant, file.name, range.draw));
    const double x = random.uniform(0.0, 1.0);
    const double rise = (range.high - range.low) * x;
    person.*person_parameters()[i].field = range.falls ? range.high - rise : range.low + rise;
  }
  return person;
}

}  // namespace palpate
