#include "engine/trials/canonical/canonical_plan.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/devices/light_device.h"
#include "engine/trials/as_printed.h"
#include "engine/trials/canonical/canonical_wall.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/paper_plan.h"
#include "engine/trials/plan.h"
#include "engine/trials/plan_device.h"
#include "engine/trials/plan_operator.h"
#include "engine/trials/shipped_files.h"
#include "engine/trials/strict_json.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr int kDefaultAngles = 7;
constexpr double kDefaultStep_deg = 15.0;
constexpr double kMostAngle_deg = 90.0;

Error plan_error(std::string element, std::string problem, std::string hint = {}) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

// Rounded to 15 decimal digits, which a double always keeps. A limit that is computed from decimal
// numbers is then the decimal number that the error prints, and a plan may have this number.
double in_decimals(double value) {
  std::array<char, 32> text;
  const char* const end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general,
                    std::numeric_limits<double>::digits10)
          .ptr;
  double rounded = value;
  std::from_chars(text.data(), end, rounded);
  return rounded;
}

const ParameterRange& range_of_person(const OperatorFile& person,
                                      double OperatorParameters::*field) {
  std::size_t i = 0;
  while (person_parameters()[i].field != field) ++i;
  return person.ranges[i];
}

void read_device(ObjectReader& reader, RunSettings& settings) {
  const Json* const found = reader.find("device");
  if (!found) return;
  const std::string element = reader.element_of("device");
  auto device = read_plan_device(*found, element);
  if (!device) return reader.fail(device.error());
  settings = std::move(*device);
  for (const char* const key : {"place", "plane_height_m"}) {
    if (!found->contains(key)) continue;
    reader.fail(plan_error(element + "/" + key, "is given; expected no such key",
                           "the angles place the wall of the canonical protocol"));
  }
  const auto setup = make_setup(settings);  // read_plan_device() has checked it
  if (!setup || setup->actuation.actuators() == 1) return;
  const bool has_axes = found->contains("actuated_axes");
  reader.fail(
      plan_error(element + (has_axes ? "/actuated_axes" : "/actuators"),
                 "gives " + std::to_string(setup->actuation.actuators()) + " motors; expected one",
                 "the angles of the canonical protocol are those to the axis of one motor"));
}

void read_display(ObjectReader& reader, CanonicalPlan& plan) {
  reader.number("display_Hz", plan.display_Hz, kDisplayRange_Hz);
  if (!reader.ok()) return;
  const double least_Hz = in_decimals(1.0 / (kPress_s + kHold_s));
  std::string expected;
  if (plan.display_Hz > plan.device.rate_Hz) {
    expected = "at most the rate of the device, " + as_printed(plan.device.rate_Hz) + " Hz";
  } else if (plan.display_Hz < least_Hz) {
    expected = "at least " + as_printed(least_Hz) + " Hz, one picture within " +
               as_printed(kPress_s + kHold_s) + " s of pressing";
  } else {
    return;
  }
  reader.fail(plan_error(reader.element_of("display_Hz"),
                         "is " + as_printed(plan.display_Hz) + "; expected " + expected));
}

void read_angles(ObjectReader& reader, std::vector<double>& angles_deg) {
  const Json* const found = reader.find("angles_deg", ObjectReader::Key::kOptional);
  if (!found) {
    for (int i = 0; i < kDefaultAngles; ++i) angles_deg.push_back(i * kDefaultStep_deg);
    return;
  }
  const std::string element = reader.element_of("angles_deg");
  const std::string expected =
      "a list of 1 to " + std::to_string(kMostAngles) + " ascending angles from 0 to 90";
  if (!found->is_array()) return reader.fail(unexpected_value(element, *found, expected));
  if (found->empty() || found->size() > kMostAngles) {
    return reader.fail(plan_error(
        element, "is a list of " + std::to_string(found->size()) + "; expected " + expected));
  }
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& angle = (*found)[i];
    const std::string at = element + "/" + std::to_string(i);
    const NumberRange range{0.0, kMostAngle_deg};
    if (!angle.is_number() || !range.contains(angle.get<double>())) {
      return reader.fail(unexpected_value(at, angle, text_of(range)));
    }
    const double angle_deg = angle.get<double>() + 0.0;  // not -0
    if (!angles_deg.empty() && !(angle_deg > angles_deg.back())) {
      return reader.fail(plan_error(
          at,
          "is " + angle.dump() + " after " + (*found)[i - 1].dump() + "; expected a larger angle",
          "sort the angles, and leave out repeated ones"));
    }
    angles_deg.push_back(angle_deg);
  }
}

// The hand stays in the workspace if it follows its target in any direction from the origin, where
// the wall is touched.
void check_workspace(ObjectReader& reader, const CanonicalPlan& plan) {
  if (!reader.ok()) return;
  const double outside_m =
      plan.device.haptics.god_object.radius_m +
      kComesFrom * range_of_person(plan.person, &OperatorParameters::press_depth_m).high;
  const double least_m = in_decimals(2.0 * (kStroke_m + outside_m));
  const double extent_m = workspace_extent_m(plan.device.device);
  if (extent_m >= least_m) return;
  reader.fail(plan_error("/device/workspace_m",
                         "is " + as_printed(extent_m) + " m; expected at least " +
                             as_printed(least_m) + " m: " + as_printed(kStroke_m) +
                             " m of the stroke and " + as_printed(in_decimals(outside_m)) +
                             " m, from where the hand comes, on each side of the origin",
                         "enlarge the workspace, or reduce press_depth_m of the operator"));
}

// A stroke ends, and has not too many ticks.
void check_ticks(ObjectReader& reader, const CanonicalPlan& plan) {
  if (!reader.ok()) return;
  OperatorParameters slowest;
  slowest.speed_m_per_s = range_of_person(plan.person, &OperatorParameters::speed_m_per_s).low;
  const double most_s = range_of_person(plan.person, &OperatorParameters::sight_delay_s).high +
                        canonical_duration_s(slowest, CanonicalMotion::kStroked);
  const double ticks = in_decimals(most_s * plan.device.rate_Hz);
  if (ticks <= kMostTrialTicks) return;
  const bool ends = std::isfinite(ticks);
  const std::string takes = ends ? "takes " + as_printed(ticks) + " ticks at the rate of the " +
                                       "device, " + as_printed(plan.device.rate_Hz) + " Hz"
                                 : std::string("never ends");
  const std::string hint = "raise the low end of speed_m_per_s";
  reader.fail(plan_error(reader.element_of("operator"),
                         "strokes along the wall at " + as_printed(slowest.speed_m_per_s) +
                             " m/s, which " + takes + "; expected at most " +
                             as_printed(kMostTrialTicks) + " ticks",
                         ends ? hint + ", or reduce /device/rate_Hz" : hint));
}

void check_count(ObjectReader& reader, const CanonicalPlan& plan) {
  if (!reader.ok()) return;
  const std::uint64_t trials = static_cast<std::uint64_t>(plan.participants) * plan.cells().size();
  if (trials <= kMostTrials) return;
  reader.fail(plan_error("/participants",
                         "gives a plan of " + std::to_string(trials) +
                             " trials; expected at most " + std::to_string(kMostTrials),
                         "reduce the participants or the angles"));
}

void read_keys(ObjectReader& reader, const std::string& folder, CanonicalPlan& plan) {
  reader.find("protocol");  // read_plan() has checked it
  int format = 1;
  reader.whole("palpate_plan", format, 1, 1);
  reader.text("name", plan.name);
  reader.whole("seed", plan.seed, 0, (std::uint64_t{1} << 53) - 1);
  reader.whole("participants", plan.participants, 1, kMostParticipants);
  read_device(reader, plan.device);
  read_display(reader, plan);
  read_angles(reader, plan.angles_deg);
  read_plan_operator(reader, folder, plan.person);
}

std::uint64_t hash_of_content(Json json, const OperatorFile& person) {
  json["operator"] = person.name;
  KeyHash hash;
  hash.add(json.dump(-1, ' ', true, Json::error_handler_t::replace));
  hash.add(kWallHalfLength_m).add(kWallThickness_m).add(kWallHeight_m);
  hash.add(kPress_s).add(kHold_s).add(kStroke_m).add(kComesFrom);
  return hash.value();
}

Result<CanonicalPlan> read_plan(const Json& json, const std::string& path,
                                const std::string& folder) {
  // First, because the keys depend on it.
  if (json.is_object() && json.contains("protocol") && json["protocol"] != kCanonicalPlan) {
    Error error = unexpected_value("/protocol", json["protocol"], std::string(kCanonicalPlan),
                                   "leave out protocol in a plan with objects");
    error.path = path;
    return error;
  }
  CanonicalPlan plan;
  plan.path = path;
  ObjectReader reader(json, "");
  read_keys(reader, folder, plan);
  check_workspace(reader, plan);
  check_ticks(reader, plan);
  check_count(reader, plan);
  if (auto error = reader.finish()) {
    if (error->path.empty()) error->path = path;
    return *error;
  }
  plan.hash = hash_of_content(json, plan.person);
  return plan;
}

}  // namespace

std::vector<CanonicalCell> CanonicalPlan::cells() const {
  std::vector<CanonicalCell> all;
  for (const double angle_deg : angles_deg) {
    for (const CanonicalMotion motion : {CanonicalMotion::kPressed, CanonicalMotion::kStroked}) {
      for (const bool rotates : {false, true}) all.push_back({angle_deg, motion, rotates});
    }
  }
  return all;
}

Result<CanonicalPlan> parse_canonical_plan(std::string_view text, const std::string& path,
                                           const std::string& folder) {
  const auto json = parse_strict_json(text, path);
  if (!json) return json.error();
  return read_plan(*json, path, folder);
}

Result<std::optional<CanonicalPlan>> load_canonical_plan(const std::string& name_or_path) {
  if (is_shipped_plan(name_or_path)) return std::optional<CanonicalPlan>();
  std::string text(shipped_canonical());
  if (name_or_path != kCanonicalPlan) {
    auto read = read_settings_text(name_or_path);
    if (!read) return read.error();
    text = std::move(*read);
  }
  const auto json = parse_strict_json(text, name_or_path);
  if (!json) return json.error();
  if (!json->is_object() || !json->contains("protocol")) return std::optional<CanonicalPlan>();
  auto plan =
      read_plan(*json, name_or_path, std::filesystem::path(name_or_path).parent_path().string());
  if (!plan) return plan.error();
  return std::optional<CanonicalPlan>(std::move(*plan));
}

}  // namespace palpate
