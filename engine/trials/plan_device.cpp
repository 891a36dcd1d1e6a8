#include "engine/trials/plan_device.h"

#include <algorithm>
#include <array>
#include <iterator>
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

void write_axes(const RunSettings& settings, nlohmann::ordered_json& json) {
  if (settings.actuated_axes.empty()) return;
  auto& axes = json["actuated_axes"] = nlohmann::ordered_json::array();
  for (const Vec3& axis : settings.actuated_axes) axes.push_back({axis.x(), axis.y(), axis.z()});
}

void read_sensors(ObjectReader& reader, RunSettings& settings) {
  reader.whole("sensors", settings.sensors, 1, 3);
  if (!reader.ok() || settings.sensors == 2) return;
  reader.fail(device_error(
      reader.element_of("sensors"), "is " + std::to_string(settings.sensors) + "; expected 2",
      "an experiment with another number is not supported yet", ErrorCode::kUnsupported));
}

void write_sensors(const RunSettings& settings, nlohmann::ordered_json& json) {
  json["sensors"] = settings.sensors;
}

void read_actuators(ObjectReader& reader, RunSettings& settings) {
  std::uint64_t actuators = 3;  // none is stated
  const bool is_required = settings.actuated_axes.empty();
  reader.whole("actuators", actuators, 0, 2, is_required ? Key::kRequired : Key::kOptional);
  if (actuators <= 2) settings.actuators = static_cast<int>(actuators);
}

void write_actuators(const RunSettings& settings, nlohmann::ordered_json& json) {
  if (!settings.actuators && !settings.actuated_axes.empty()) return;
  json["actuators"] = settings.actuators.value_or(settings.default_actuators);
}

void read_place(ObjectReader& reader, RunSettings& settings) {
  std::vector<double> n;
  reader.numbers("place", n, 7, Key::kOptional);
  if (n.empty()) return;
  ScenePose& place = settings.haptics.initial_pose;
  place = {Quat(n[3], n[4], n[5], n[6]), Vec3(n[0], n[1], n[2])};
  if (is_pose(place)) {
    place = unit_pose(place);
    return;
  }
  reader.fail(device_error(
      reader.element_of("place"),
      "has a quaternion of length " + std::to_string(place.rotation.norm()) + "; expected 1",
      "write x y z in metres, then a unit quaternion w x y z"));
}

void write_place(const RunSettings& settings, nlohmann::ordered_json& json) {
  const Vec3& p = settings.haptics.initial_pose.translation_m;
  const Quat& q = settings.haptics.initial_pose.rotation;
  json["place"] = {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
}

void read_work_budget(ObjectReader& reader, RunSettings& settings) {
  const NumberRange range = run_setting("--work-budget").range;
  std::uint64_t budget = 0;
  reader.whole("work_budget", budget, static_cast<std::uint64_t>(range.least),
               static_cast<std::uint64_t>(range.most), Key::kOptional);
  if (budget > 0) settings.work_budget = static_cast<std::int64_t>(budget);
}

void write_work_budget(const RunSettings& settings, nlohmann::ordered_json& json) {
  if (settings.work_budget) json["work_budget"] = *settings.work_budget;
}

void read_workspace(ObjectReader& reader, RunSettings& settings) {
  std::optional<double> workspace_m;
  reader.number("workspace_m", workspace_m, kAboveZero);
  if (workspace_m) set_workspace_extent(settings.device, *workspace_m);
}

void write_workspace(const RunSettings& settings, nlohmann::ordered_json& json) {
  json["workspace_m"] = workspace_extent_m(settings.device);
}

// The keys that are read in a way of their own.
struct OwnKey {
  std::string_view key;
  void (*read)(ObjectReader&, RunSettings&);
  void (*write)(const RunSettings&, nlohmann::ordered_json&);
};

constexpr OwnKey kOwnKeys[] = {
    {"sensors", read_sensors, write_sensors},
    {"actuated_axes", read_axes, write_axes},
    {"actuators", read_actuators, write_actuators},
    {"work_budget", read_work_budget, write_work_budget},
    {"place", read_place, write_place},
    {"workspace_m", read_workspace, write_workspace},
};

// Null if the table says how to read the key.
const OwnKey* own_key(std::string_view key) {
  const auto* const found = std::find_if(std::begin(kOwnKeys), std::end(kOwnKeys),
                                         [&](const OwnKey& own) { return own.key == key; });
  return found == std::end(kOwnKeys) ? nullptr : found;
}

// Reads the value of a setting from a plan.
struct KeyReader {
  ObjectReader& reader;
  const RunSetting& setting;
  RunSettings& settings;

  const char* key() const { return setting.plan.name; }
  Key need() const { return setting.plan.is_required ? Key::kRequired : Key::kOptional; }
  NumberRange range() const { return setting.plan.range.value_or(setting.range); }

  void operator()(const OwnSetting&) const {}
  void operator()(const SettingPlace<bool>& at) const {
    reader.flag(key(), at.of(settings), need());
  }
  void operator()(const SettingPlace<double>& at) const {
    reader.number(key(), at.of(settings), range(), need());
  }
  void operator()(const SettingPlace<std::optional<double>>& at) const {
    reader.number(key(), at.of(settings), range());
  }
  template <class Whole>
  void operator()(const SettingPlace<Whole>& at) const {
    at.of(settings) = static_cast<Whole>(whole(static_cast<int>(at.of(settings))));
  }
  void operator()(const SettingPlace<std::optional<int>>& at) const {
    const int least = static_cast<int>(range().least);
    const int value = whole(at.of(settings).value_or(least - 1));
    if (value >= least) at.of(settings) = value;
  }
  void operator()(const SettingChoice& choice) const {
    std::size_t word = choice.get(settings.haptics);
    reader.choice(key(), word, {choice.words.begin(), choice.words.end()}, need());
    if (word < choice.words.size()) choice.put(settings.haptics, word);
  }

  int whole(int value) const {
    reader.whole(key(), value, static_cast<int>(range().least), static_cast<int>(range().most),
                 need());
    return value;
  }
};

// Writes the value of a setting into a plan.
struct KeyWriter {
  const RunSetting& setting;
  RunSettings& settings;
  nlohmann::ordered_json& json;

  void operator()(const OwnSetting&) const {}
  template <class Value>
  void operator()(const SettingPlace<Value>& at) const {
    json[setting.plan.name] = at.of(settings);
  }
  template <class Value>
  void operator()(const SettingPlace<std::optional<Value>>& at) const {
    if (at.of(settings)) json[setting.plan.name] = *at.of(settings);
  }
  void operator()(const SettingChoice& choice) const {
    const std::size_t word = choice.get(settings.haptics);
    if (word < choice.words.size()) json[setting.plan.name] = choice.words[word];
  }
};

// Fields of settings that are no keys of `device`, and the keys of the plan, where they differ.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kOtherNames = {{
    {"listed_scene", "scene"},
    {"feels_hidden", "feel_hidden"},
    {"god_object.accuracy.work_budget", "work_budget"},
    {"a4.align", "align"},
}};

std::string plan_key(std::string_view field) {
  for (const RunSetting& setting : run_settings()) {
    if (setting.plan.name && setting.field == field) return setting.plan.name;
  }
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

Result<RunSettings> read_plan_device(const nlohmann::json& device, const std::string& element,
                                     RunSettingTable table) {
  RunSettings settings;
  settings.default_actuators = 1;
  ObjectReader reader(device, element);
  for (const RunSetting* setting : by_plan_turn(table)) {
    if (const OwnKey* own = own_key(setting->plan.name)) {
      own->read(reader, settings);
    } else {
      std::visit(KeyReader{reader, *setting, settings}, setting->value);
    }
  }
  if (auto error = reader.finish()) return *error;
  const auto setup = make_setup(settings);
  if (!setup) return as_plan_error(setup.error(), element);
  return settings;
}

nlohmann::ordered_json plan_device_json(RunSettings settings, RunSettingTable table) {
  nlohmann::ordered_json json;
  for (const RunSetting* setting : by_plan_turn(table)) {
    if (const OwnKey* own = own_key(setting->plan.name)) {
      own->write(settings, json);
    } else {
      std::visit(KeyWriter{*setting, settings, json}, setting->value);
    }
  }
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
