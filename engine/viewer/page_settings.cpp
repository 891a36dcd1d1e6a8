#include "engine/viewer/page_settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/session/run_setting.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const LiveSetting& setting, double value) {
  switch (setting.kind()) {
    case LiveSetting::Kind::kFlag:
      return value != 0.0;
    case LiveSetting::Kind::kChoice:
      return setting.words()[static_cast<std::size_t>(value)];
    case LiveSetting::Kind::kNumber:
      return value;
  }
  return {};
}

Error wrong_kind(const std::string& name, const std::string& expected) {
  return invalid_argument(name, "has another kind of value; expected " + expected);
}

// Calls use(value) if the value has this type.
template <typename Type, typename Use>
std::optional<Error> with(const std::string& name, const char* expected, const SettingValue& value,
                          const Use& use) {
  const Type* const typed = std::get_if<Type>(&value);
  if (typed == nullptr) return wrong_kind(name, expected);
  return use(*typed);
}

Json axes_json(const std::vector<Vec3>& axes) {
  Json list = Json::array();
  for (const Vec3& axis : axes) {
    const Vec3 unit = axis.normalized();
    list.push_back({unit.x(), unit.y(), unit.z()});
  }
  return list;
}

// In the unit of the file.
double initial_value(const Scene& scene, std::uint32_t call, const ParameterKey& key) {
  const EffectProgram& program = *scene.world().effects;
  double number = 0.0;
  std::memcpy(&number, program.parameters.data() + program.calls[call].parameters + key.offset,
              sizeof number);
  return key.scales_as_length ? number / scene.statistics().scale : number;
}

// The index of a word in a list, or the list's size.
template <typename List>
std::size_t index_of(const List& words, const std::string& word) {
  return static_cast<std::size_t>(std::find(words.begin(), words.end(), word) - words.begin());
}

}  // namespace

PageSettings::PageSettings(const Scene& scene, LiveSettings& live, MaterialTuner& tuner,
                           bool has_axes, bool has_full_force)
    : live_(live), tuner_(tuner) {
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    add_loop_setting(i, has_full_force);
    if (i == 0 && has_axes) add_axes();
  }
  for (const MaterialCalls& material : scene.material_calls()) {
    for (const std::uint32_t call : material.calls) add_material(scene, material.material, call);
  }
  std::size_t number = 0;
  for (Setting& setting : settings_) {
    if (setting.key.empty() && number < 9) setting.key = std::to_string(++number);
  }
}

void PageSettings::add_loop_setting(std::size_t place, bool has_full_force) {
  const LiveSetting& row = kLiveSettings[place];
  Setting setting{std::string(row.name), std::string(row.label)};
  setting.key = row.key;
  const auto set = [this, place](double value) { return live_.set(place, value); };
  switch (row.kind()) {
    case LiveSetting::Kind::kFlag:
      setting.kind = "flag";
      setting.change = [name = setting.name, set](const SettingValue& value) {
        return with<bool>(name, "true or false", value,
                          [&](bool on) { return set(on ? 1.0 : 0.0); });
      };
      setting.value = [this, place] { return Json(live_.value(place) != 0.0); };
      settings_.push_back(std::move(setting));
      break;
    case LiveSetting::Kind::kChoice:
      setting.kind = "choice";
      setting.choices.assign(row.words().begin(), row.words().end());
      if (place == live_setting("force") && !has_full_force) setting.choices.pop_back();
      add_choice(std::move(setting), set, [this, place] { return live_.value(place); });
      break;
    case LiveSetting::Kind::kNumber:
      setting.kind = "number";
      setting.unit = row.of_run().unit;
      setting.low = row.least();
      setting.high = live_.most(place);
      add_number(std::move(setting), set, [this, place] { return Json(live_.value(place)); });
      break;
  }
}

void PageSettings::add_axes() {
  using Axes = std::vector<std::array<double, 3>>;
  Setting setting{"axes", "actuated axes", "axes", "", 0.0, 0.0, {}, "x"};
  setting.change = [this](const SettingValue& value) {
    return with<Axes>("axes", "a list of axes", value, [this](const Axes& list) {
      std::vector<Vec3> axes;
      for (const auto& axis : list) axes.emplace_back(axis.data());
      return live_.set_axes(axes);
    });
  };
  setting.value = [this] { return axes_json(live_.axes()); };
  settings_.push_back(std::move(setting));
}

void PageSettings::add_number(Setting setting, std::function<std::optional<Error>(double)> set,
                              std::function<Json()> value) {
  setting.change = [name = setting.name, set = std::move(set)](const SettingValue& wanted) {
    return with<double>(name, "a number", wanted, set);
  };
  setting.value = std::move(value);
  settings_.push_back(std::move(setting));
}

void PageSettings::add_choice(Setting setting, std::function<std::optional<Error>(double)> set,
                              std::function<double()> value) {
  setting.change = [name = setting.name, choices = setting.choices,
                    set = std::move(set)](const SettingValue& wanted) {
    return with<std::string>(name, "one of its choices", wanted,
                             [&](const std::string& word) -> std::optional<Error> {
                               const std::size_t i = index_of(choices, word);
                               if (i == choices.size())
                                 return wrong_kind(name, "one of its choices");
                               return set(static_cast<double>(i));
                             });
  };
  setting.value = [choices = setting.choices, value = std::move(value)] {
    return Json(choices[static_cast<std::size_t>(value())]);
  };
  settings_.push_back(std::move(setting));
}

void PageSettings::add_material(const Scene& scene, const std::string& material,
                                std::uint32_t call) {
  for (const ParameterKey& key :
       compiled_effects()[scene.world().effects->calls[call].effect].keys) {
    add_key(scene, material, call, key);
  }
}

void PageSettings::add_key(const Scene& scene, const std::string& material, std::uint32_t call,
                           const ParameterKey& key) {
  Setting setting;
  setting.name = "material/" + material + "/" + std::string(key.key);
  const bool is_known = std::any_of(settings_.begin(), settings_.end(),
                                    [&](const Setting& s) { return s.name == setting.name; });
  if (is_known) return;
  const auto handle = tuner_.add(material, std::string(key.key));
  if (!handle) return;  // fixed when the scene is compiled
  setting.label = material + ": " + std::string(key.key);
  setting.unit = key.unit;
  setting.low = key.least;
  setting.high = key.most;
  const auto now = std::make_shared<double>(initial_value(scene, call, key));
  const auto set = [this, handle = *handle, now](double value) {
    auto error = tuner_.set(handle, value);
    if (!error) *now = value;
    return error;
  };
  if (key.kind == ParameterKey::Kind::kChoice) {
    setting.kind = "choice";
    setting.choices.assign(key.choices.begin(), key.choices.end());
    return add_choice(std::move(setting), set, [now] { return *now; });
  }
  setting.kind = "number";
  add_number(std::move(setting), set, [now] { return Json(*now); });
}

std::optional<Error> PageSettings::set(const std::string& name, const SettingValue& value) {
  const auto found = std::find_if(settings_.begin(), settings_.end(),
                                  [&](const Setting& s) { return s.name == name; });
  if (found == settings_.end()) {
    constexpr std::size_t kShown = 64;
    return invalid_argument(name.substr(0, kShown), "is not a setting");
  }
  return found->change(value);
}

Json PageSettings::list() const {
  Json list = Json::array();
  for (const Setting& s : settings_) {
    Json entry = {{"name", s.name}, {"label", s.label}, {"kind", s.kind}, {"value", s.value()}};
    if (s.kind == "number") {
      entry["low"] = s.low;
      entry["high"] = s.high;
      entry["unit"] = s.unit;
    }
    if (s.kind == "choice") entry["choices"] = s.choices;
    entry["key"] = s.key;
    list.push_back(std::move(entry));
  }
  return list;
}

Json PageSettings::values(const std::optional<LoopValues>& loop) const {
  Json values = Json::object();
  for (const Setting& s : settings_) values[s.name] = s.value();
  if (!loop) return values;
  for (std::size_t i = 0; i < kLiveSettings.size(); ++i) {
    values[std::string(kLiveSettings[i].name)] = json_of(kLiveSettings[i], loop->settings[i]);
  }
  return values;
}

}  // namespace palpate
