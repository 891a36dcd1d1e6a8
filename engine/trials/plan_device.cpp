#include "engine/trials/plan_device.h"

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/devices/light_device.h"
#include "engine/trials/strict_json.h"
#include "haptics/effects/velocity_estimator.h"
#include "haptics/haptic_loop.h"

namespace palpate {
namespace {

using Key = ObjectReader::Key;

// Longer than any useful tick, and small enough that no sum of work overflows.
constexpr std::uint64_t kMostPlanWork = 1'000'000'000'000;

constexpr std::array<std::string_view, 3> kPlanPresets = {"fast", "balanced", "exact"};

constexpr NumberRange kPlanAboveZero{0.0, std::numeric_limits<double>::infinity(), true};
constexpr NumberRange kPlanZeroOrMore{0.0};
constexpr NumberRange kPlanAnyNumber{};

constexpr std::array<std::pair<std::string_view, VelocityMethod>, 3> kPlanEstimators = {
    {{"difference", VelocityMethod::kDifference},
     {"line", VelocityMethod::kLineFit},
     {"adaptive", VelocityMethod::kAdaptive}}};

Error device_error(std::string element, std::string problem, std::string hint = {},
                   ErrorCode code = ErrorCode::kInvalidContent) {
  return {code, "", std::move(element), std::move(problem), std::move(hint)};
}

void read_axes(ObjectReader& reader, RunSettings& settings) {
  const nlohmann::json* const found = reader.find("actuated_axes", Key::kOptional);
  if (!found) return;
  const std::string element = reader.element_of("actuated_axes");
  const auto is_axis = [](const nlohmann::json& axis) {
    return axis.is_array() && axis.size() == 3 && axis[0].is_number() && axis[1].is_number() &&
           axis[2].is_number();
  };
  constexpr const char* kExpected = "a list of one or two directions, each a list of three numbers";
  if (!found->is_array()) return reader.fail(unexpected_value(element, *found, kExpected));
  if (found->empty() || found->size() > 2) {
    return reader.fail(device_error(
        element, "is a list of " + std::to_string(found->size()) + "; expected " + kExpected));
  }
  for (std::size_t i = 0; i < found->size(); ++i) {
    const nlohmann::json& axis = (*found)[i];
    if (!is_axis(axis)) {
      return reader.fail(unexpected_value(element + "/" + std::to_string(i), axis,
                                          "a direction, a list of three numbers"));
    }
    settings.actuated_axes.emplace_back(axis[0], axis[1], axis[2]);
  }
}

// Two sensors, and the motors.
void read_motors(ObjectReader& reader, RunSettings& settings) {
  reader.whole("sensors", settings.sensors, 1, 3);
  if (reader.ok() && settings.sensors != 2) {
    reader.fail(device_error(
        reader.element_of("sensors"), "is " + std::to_string(settings.sensors) + "; expected 2",
        "an experiment with another number is not supported yet", ErrorCode::kUnsupported));
  }
  read_axes(reader, settings);
  std::uint64_t actuators = 3;  // none is stated
  const bool is_required = settings.actuated_axes.empty();
  reader.whole("actuators", actuators, 0, 2, is_required ? Key::kRequired : Key::kOptional);
  if (actuators <= 2) settings.actuators = static_cast<int>(actuators);
}

void read_place(ObjectReader& reader, RunSettings& settings) {
  std::vector<double> n;
  reader.numbers("place", n, 7, Key::kOptional);
  if (n.empty()) return;
  settings.place = {Quat(n[3], n[4], n[5], n[6]), Vec3(n[0], n[1], n[2])};
  if (is_pose(settings.place)) {
    settings.place = unit_pose(settings.place);
    return;
  }
  reader.fail(device_error(reader.element_of("place"),
                           "has a quaternion of length " +
                               std::to_string(settings.place.rotation.norm()) + "; expected 1",
                           "write x y z in metres, then a unit quaternion w x y z"));
}

void read_proxy(ObjectReader& reader, RunSettings& settings) {
  std::size_t preset = 1;
  reader.choice("accuracy", preset, {kPlanPresets.begin(), kPlanPresets.end()}, Key::kOptional);
  settings.accuracy = *accuracy_preset(kPlanPresets[preset]);
  std::uint64_t budget = 0;
  reader.whole("work_budget", budget, 1, kMostPlanWork, Key::kOptional);
  if (budget > 0) settings.work_budget = static_cast<std::int64_t>(budget);
  reader.number("radius_m", settings.radius_m, kPlanZeroOrMore, Key::kOptional);
  reader.number("plane_height_m", settings.plane_height_m, kPlanAnyNumber);
}

void read_coupling(ObjectReader& reader, RunSettings& settings) {
  reader.number("rate_Hz", settings.rate_Hz, kPlanAboveZero);
  reader.number("stiffness_N_per_m", settings.stiffness_N_per_m, kPlanZeroOrMore);
  reader.number("damping_Ns_per_m", settings.damping_Ns_per_m, kPlanZeroOrMore);
  std::size_t estimator = 0;
  std::vector<std::string_view> words;
  for (const auto& [name, method] : kPlanEstimators) words.push_back(name);
  reader.choice("velocity_estimator", estimator, words, Key::kOptional);
  settings.velocity_estimator = kPlanEstimators[estimator].second;
  reader.whole("velocity_window_ticks", settings.velocity_window_ticks, 1,
               VelocityEstimator::kMostTicks, Key::kOptional);
  reader.number("encoder_quantum_m", settings.encoder_quantum_m, kPlanAboveZero);
  reader.number("max_force_N", settings.max_force_N, kPlanAboveZero);
}

void read_a4(ObjectReader& reader, RunSettings& settings) {
  std::size_t table = 0;
  reader.choice("table1", table, {"corrected", "printed"}, Key::kOptional);
  settings.table1 = table == 0 ? Table1Form::kCorrected : Table1Form::kAsPrinted;
  std::size_t step = 0;
  reader.choice("a4_step", step, {"exact", "paper"}, Key::kOptional);
  settings.a4_step = step == 0 ? StepRule::kExact : StepRule::kSpeedByDt;
}

void read_mechanics(ObjectReader& reader, DeviceDescription& device) {
  std::optional<double> workspace_m;
  reader.number("workspace_m", workspace_m, kPlanAboveZero);
  if (workspace_m) set_workspace_extent(device, *workspace_m);
  reader.number("device_mass_kg", device.mass_kg, kPlanAboveZero, Key::kOptional);
  reader.number("device_damping_Ns_per_m", device.damping_Ns_per_m, kPlanZeroOrMore,
                Key::kOptional);
  reader.number("device_friction_N", device.coulomb_friction_N, kPlanZeroOrMore, Key::kOptional);
}

// Fields of settings and the keys of the plan, where they differ.
constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kOtherNames = {{
    {"listed_scene", "scene"},
    {"feels_hidden", "feel_hidden"},
    {"coupling.stiffness_N_per_m", "stiffness_N_per_m"},
    {"coupling.damping_Ns_per_m", "damping_Ns_per_m"},
    {"god_object.radius_m", "radius_m"},
    {"god_object.accuracy.work_budget", "work_budget"},
    {"initial_pose", "place"},
    {"device.workspace", "workspace_m"},
    {"device.mass_kg", "device_mass_kg"},
    {"device.damping_Ns_per_m", "device_damping_Ns_per_m"},
    {"device.coulomb_friction_N", "device_friction_N"},
}};

std::string plan_key(std::string_view field) {
  for (const auto& [name, key] : kOtherNames) {
    if (name == field) return std::string(key);
  }
  if (field.starts_with("actuated axis")) return "actuated_axes";
  return std::string(field);
}

// Every `Struct::field` becomes the key.
std::string with_plan_keys(std::string text) {
  constexpr std::string_view kOfRun = ", the value of `fitting_size_m()`";  // `run --fit auto`
  if (const std::size_t at = text.find(kOfRun); at != std::string::npos) {
    text.erase(at, kOfRun.size());
  }
  for (const std::string_view owner : {"`RunSettings::", "`HapticSettings::", "`SceneSettings::"}) {
    for (std::size_t at = text.find(owner); at != std::string::npos; at = text.find(owner, at)) {
      const std::size_t begin = at + owner.size();
      const std::size_t end = text.find('`', begin);
      if (end == std::string::npos) break;
      const std::string key = plan_key(text.substr(begin, end - begin));
      text.replace(at, end + 1 - at, key);
      at += key.size();
    }
  }
  return text;
}

}  // namespace

Result<RunSettings> read_plan_device(const nlohmann::json& device, const std::string& element) {
  RunSettings settings;
  settings.default_actuators = 1;
  ObjectReader reader(device, element);
  read_motors(reader, settings);
  read_coupling(reader, settings);
  read_proxy(reader, settings);
  read_place(reader, settings);
  read_a4(reader, settings);
  read_mechanics(reader, settings.device);
  if (auto error = reader.finish()) return *error;
  const auto setup = make_setup(settings);
  if (!setup) return as_plan_error(setup.error(), element);
  return settings;
}

nlohmann::ordered_json plan_device_json(const RunSettings& settings) {
  nlohmann::ordered_json json = {{"sensors", settings.sensors}};
  if (!settings.actuated_axes.empty()) {
    auto& axes = json["actuated_axes"] = nlohmann::ordered_json::array();
    for (const Vec3& axis : settings.actuated_axes) axes.push_back({axis.x(), axis.y(), axis.z()});
  }
  if (settings.actuators || settings.actuated_axes.empty()) {
    json["actuators"] = settings.actuators.value_or(settings.default_actuators);
  }
  json["rate_Hz"] = settings.rate_Hz;
  json["stiffness_N_per_m"] = settings.stiffness_N_per_m;
  json["damping_Ns_per_m"] = settings.damping_Ns_per_m;
  for (const auto& [name, method] : kPlanEstimators) {
    if (method == settings.velocity_estimator) json["velocity_estimator"] = name;
  }
  json["velocity_window_ticks"] = settings.velocity_window_ticks;
  if (settings.encoder_quantum_m) json["encoder_quantum_m"] = *settings.encoder_quantum_m;
  if (settings.max_force_N) json["max_force_N"] = *settings.max_force_N;
  for (const std::string_view name : kPlanPresets) {  // the work budget tells the presets apart
    if (accuracy_preset(name)->work_budget == settings.accuracy.work_budget)
      json["accuracy"] = name;
  }
  if (settings.work_budget) json["work_budget"] = *settings.work_budget;
  json["radius_m"] = settings.radius_m;
  if (settings.plane_height_m) json["plane_height_m"] = *settings.plane_height_m;
  const Vec3& p = settings.place.translation_m;
  const Quat& q = settings.place.rotation;
  json["place"] = {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
  json["table1"] = settings.table1 == Table1Form::kCorrected ? "corrected" : "printed";
  json["a4_step"] = settings.a4_step == StepRule::kExact ? "exact" : "paper";
  json["workspace_m"] = workspace_extent_m(settings.device);
  json["device_mass_kg"] = settings.device.mass_kg;
  json["device_damping_Ns_per_m"] = settings.device.damping_Ns_per_m;
  json["device_friction_N"] = settings.device.coulomb_friction_N;
  return json;
}

Error as_plan_error(Error error, const std::string& element) {
  if (!error.element.empty()) error.element = element + "/" + plan_key(error.element);
  return with_plan_keys(std::move(error));
}

Error with_plan_keys(Error error) {
  error.element = with_plan_keys(std::move(error.element));
  error.problem = with_plan_keys(std::move(error.problem));
  error.hint = with_plan_keys(std::move(error.hint));
  return error;
}

}  // namespace palpate
