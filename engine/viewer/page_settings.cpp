#include "engine/viewer/page_settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 3> kForces = {"none", "actuated", "full"};

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

// The index of a word in a list, or the list's size.
template <typename List>
std::size_t index_of(const List& words, const std::string& word) {
  return static_cast<std::size_t>(std::find(words.begin(), words.end(), word) - words.begin());
}

}  // namespace

PageSettings::PageSettings(const Scene& scene, LiveSettings& live, MaterialTuner& tuner,
                           bool has_axes, bool has_full_force)
    : live_(live), tuner_(tuner) {
  add_loop_settings(has_axes, has_full_force);
  for (const MaterialCalls& material : scene.material_calls()) {
    for (const std::uint32_t call : material.calls) add_material(scene, material.material, call);
  }
  std::size_t number = 0;
  for (Setting& setting : settings_) {
    if (setting.key.empty() && number < 9) setting.key = std::to_string(++number);
  }
}

void PageSettings::add_loop_settings(bool has_axes, bool has_full_force) {
  settings_.push_back({"a4",
                       "A4",
                       "flag",
                       "",
                       0,
                       0,
                       {},
                       "a",
                       [this](const SettingValue& value) {
                         return with<bool>("a4", "true or false", value,
                                           [this](bool on) -> std::optional<Error> {
                                             live_.set_a4(on);
                                             return std::nullopt;
                                           });
                       },
                       [this] { return Json(live_.a4()); }});
  if (has_axes) {
    using Axes = std::vector<std::array<double, 3>>;
    settings_.push_back({"axes",
                         "actuated axes",
                         "axes",
                         "",
                         0,
                         0,
                         {},
                         "x",
                         [this](const SettingValue& value) {
                           return with<Axes>("axes", "a list of axes", value,
                                             [this](const Axes& a) {
                                               std::vector<Vec3> axes;
                                               for (const auto& axis : a)
                                                 axes.emplace_back(axis.data());
                                               return live_.set_axes(axes);
                                             });
                         },
                         [this] { return axes_json(live_.axes()); }});
  }
  std::vector<std::string> forces(kForces.begin(), kForces.end() - (has_full_force ? 0 : 1));
  const auto set_force = [this, forces](const SettingValue& value) {
    return with<std::string>("force", "none, actuated or full", value,
                             [&](const std::string& word) -> std::optional<Error> {
                               const std::size_t i = index_of(forces, word);
                               if (i == forces.size())
                                 return wrong_kind("force", "none, actuated or full");
                               live_.set_force(static_cast<ForceMode>(i));
                               return std::nullopt;
                             });
  };
  settings_.push_back({"force", "force", "choice", "", 0, 0, forces, "f", set_force,
                       [this] { return Json(kForces[static_cast<std::size_t>(live_.force())]); }});
  settings_.push_back({"stiffness",
                       "stiffness",
                       "number",
                       "N/m",
                       0.0,
                       live_.most_stiffness_N_per_m(),
                       {},
                       "k",
                       [this](const SettingValue& value) {
                         return with<double>("stiffness", "a number", value,
                                             [this](double k) { return live_.set_stiffness(k); });
                       },
                       [this] { return Json(live_.stiffness_N_per_m()); }});
  settings_.push_back({"damping",
                       "damping",
                       "number",
                       "N s/m",
                       0.0,
                       live_.most_damping_Ns_per_m(),
                       {},
                       "b",
                       [this](const SettingValue& value) {
                         return with<double>("damping", "a number", value,
                                             [this](double b) { return live_.set_damping(b); });
                       },
                       [this] { return Json(live_.damping_Ns_per_m()); }});
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
  const EffectProgram& program = *scene.world().effects;
  double number = 0.0;
  std::memcpy(&number, program.parameters.data() + program.calls[call].parameters + key.offset,
              sizeof number);
  if (key.scales_as_length) number /= scene.statistics().scale;
  const auto now = std::make_shared<double>(number);
  const auto set_number = [this, handle = *handle, now](double value) {
    auto error = tuner_.set(handle, value);
    if (!error) *now = value;
    return error;
  };
  if (key.kind == ParameterKey::Kind::kChoice) {
    setting.kind = "choice";
    setting.choices.assign(key.choices.begin(), key.choices.end());
    setting.change = [name = setting.name, choices = setting.choices,
                      set_number](const SettingValue& value) {
      return with<std::string>(name, "one of its choices", value,
                               [&](const std::string& word) -> std::optional<Error> {
                                 const std::size_t i = index_of(choices, word);
                                 if (i == choices.size())
                                   return wrong_kind(name, "one of its choices");
                                 return set_number(static_cast<double>(i));
                               });
    };
    setting.value = [choices = setting.choices, now] {
      return Json(choices[static_cast<std::size_t>(*now)]);
    };
  } else {
    setting.kind = "number";
    setting.change = [name = setting.name, set_number](const SettingValue& value) {
      return with<double>(name, "a number", value, set_number);
    };
    setting.value = [now] { return Json(*now); };
  }
  settings_.push_back(std::move(setting));
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

Json PageSettings::values() const {
  Json values = Json::object();
  for (const Setting& s : settings_) values[s.name] = s.value();
  return values;
}

}  // namespace palpate
