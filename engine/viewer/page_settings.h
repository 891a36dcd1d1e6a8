#pragma once

// The settings that a page shows and changes: their names, ranges and values.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/session/material_tuner.h"
#include "engine/viewer/live_settings.h"
#include "engine/viewer/page_request.h"
#include "engine/viewer/state_publisher.h"

namespace palpate {

// One thread owns this object.
class PageSettings {
 public:
  // Lists kLiveSettings, behind the first of them the actuated axes (only with has_axes), and every
  // number that the scene's materials declare. Without has_full_force, the force has no `full`. All
  // references must outlive this object; the session must not have started, because the tuner gets
  // its handles here.
  PageSettings(const Scene& scene, LiveSettings& live, MaterialTuner& tuner, bool has_axes,
               bool has_full_force);

  // Changes a setting. Returns an Error, and changes nothing, if the name is unknown or the value
  // is refused.
  std::optional<Error> set(const std::string& name, const SettingValue& value);

  // A list of objects with name, label, kind, value, low, high, unit, choices and key.
  nlohmann::ordered_json list() const;
  // An object of names and values: those that were set, or for kLiveSettings those of `loop`, if
  // there are any.
  nlohmann::ordered_json values(const std::optional<LoopValues>& loop = {}) const;

 private:
  // Returns the Error of a refused value.
  using Change = std::function<std::optional<Error>(const SettingValue&)>;
  struct Setting {
    std::string name = {}, label = {}, kind = {}, unit = {};
    double low = 0.0, high = 0.0;
    std::vector<std::string> choices = {};
    std::string key = {};  // of the keyboard; may be empty
    Change change = {};
    std::function<nlohmann::ordered_json()> value = {};
  };

  void add_loop_setting(std::size_t place, bool has_full_force);
  void add_axes();
  void add_number(Setting setting, std::function<std::optional<Error>(double)> set,
                  std::function<nlohmann::ordered_json()> value);
  // value: the index of the present choice.
  void add_choice(Setting setting, std::function<std::optional<Error>(double)> set,
                  std::function<double()> value);
  void add_material(const Scene& scene, const std::string& material, std::uint32_t call);
  void add_key(const Scene& scene, const std::string& material, std::uint32_t call,
               const ParameterKey& key);

  LiveSettings& live_;
  MaterialTuner& tuner_;
  std::vector<Setting> settings_;
};

}  // namespace palpate
