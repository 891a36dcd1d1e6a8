#include "engine/scene/material_effects.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "engine/scene/extras_keys.h"
#include "engine/scene/material_parameters.h"

namespace palpate {
namespace {

constexpr const char* kPhysics = "KHR_physics_rigid_bodies";
constexpr const char* kHaptic = "MPEG_haptic_material";
constexpr const char* kFrictionMap = "friction";
constexpr const char* kTextureMap = "vibrotactileTexture";
constexpr const char* kFile = "glTF";
constexpr const char* kNormalMap = "normalTexture";

using Role = ParameterKey::Role;

// The value of a parameter of an effect, given or by default.
struct Value {
  const ParameterKey* key;
  double number;
  MaterialParameter given;
  std::string source;  // empty for a default
};

// Compiles the effects of one material.
class Compiler {
 public:
  explicit Compiler(const MaterialSources& sources)
      : sources_(sources),
        owner_("material " + quoted_text(sources.material->name)),
        values_(compiled_effects().size()) {}

  Result<MaterialEffects> compile() {
    if (auto error = add_physics()) return *error;
    for (const MaterialParameter& parameter : sources_.material->parameters) {
      if (auto error = add(parameter, source_of(parameter))) return *error;
    }
    if (auto error = add_maps()) return *error;
    complete_friction();
    for (std::uint16_t effect = 0; effect < values_.size(); ++effect) {
      if (auto error = finish(effect)) return *error;
    }
    report_unused_maps();
    if (auto error = check_medium()) return *error;
    return std::move(result_);
  }

 private:
  using MaybeError = std::optional<Error>;

  MaybeError add(const MaterialParameter& parameter, const std::string& source) {
    if (parameter.key == kSolidKey) return add_solid(parameter);
    const auto types = compiled_effects();
    for (std::size_t effect = 0; effect < types.size(); ++effect) {
      for (const ParameterKey& key : types[effect].keys) {
        if (key.key != parameter.key) continue;
        const auto number = checked_number(owner_, parameter, key);
        if (!number) return number.error();
        put(effect, {&key, *number, parameter, source});
        return std::nullopt;
      }
    }
    return add_other(parameter, source);
  }

  // A key of no effect in this build.
  MaybeError add_other(const MaterialParameter& parameter, const std::string& source) {
    const auto names = effect_key_names();
    const auto known = std::find_if(names.begin(), names.end(),
                                    [&](const auto& k) { return k.key == parameter.key; });
    if (known == names.end()) {
      if (source == kOverrideSource) return unknown_key(parameter);
      result_.report.not_understood.push_back(
          {parameter.key, parameter.value, parameter.element,
           extras_keys().why_unknown(parameter.key, kOfMaterial)});
      return std::nullopt;
    }
    const double* number = std::get_if<double>(&parameter.value);
    if (known->zero_is_none && number && *number == 0.0) {
      result_.report.honoured.push_back(
          {parameter.key, parameter.value, "", source, parameter.element, true});
      return std::nullopt;
    }
    return not_built_error(owner_, parameter, known->effect);
  }

  // An unknown key in a file may be meant for other programs; an unknown override is an error.
  Error unknown_key(const MaterialParameter& parameter) const {
    std::string keys(kSolidKey);
    for (const EffectKeyName& name : effect_key_names()) keys += ", " + std::string(name.key);
    return error_at(owner_, parameter, quoted_text(parameter.key) + " is an unknown key",
                    "use one of the keys " + keys);
  }

  MaybeError add_solid(const MaterialParameter& parameter) {
    const auto solid = checked_flag(owner_, parameter);
    if (!solid) return solid.error();
    result_.is_solid = *solid;
    solid_ = parameter;
    result_.report.honoured.push_back(
        {parameter.key, parameter.value, "", source_of(parameter), parameter.element});
    return std::nullopt;
  }

  MaybeError add_physics() {
    const PhysicsMaterialDescription* physics = sources_.physics;
    if (!physics) return std::nullopt;
    const std::pair<const char*, std::optional<double>> written[] = {
        {"staticFriction", physics->static_friction},
        {"dynamicFriction", physics->dynamic_friction},
        {"restitution", physics->restitution}};
    for (const auto& [key, number] : written) {
      // A value of the material takes precedence; this value is then not checked.
      if (!number || is_given(key)) continue;
      const MaterialParameter parameter{key, *number, sources_.physics_element + "/" + key};
      if (auto error = add(parameter, kPhysics)) return error;
    }
    return complete_physics(*physics);
  }

  // Adds the default of the extension for each missing coefficient, changed if necessary so that it
  // does not contradict the other coefficient.
  MaybeError complete_physics(const PhysicsMaterialDescription& physics) {
    const auto declared = [&](const char* key, std::optional<double> written) {
      const MaterialParameter* parameter = find_given(key);
      const double* number = parameter ? std::get_if<double>(&parameter->value) : nullptr;
      return number ? std::optional(*number) : written;
    };
    const auto sticking = declared("staticFriction", physics.static_friction);
    const auto sliding = declared("dynamicFriction", physics.dynamic_friction);
    if (!physics.static_friction && !is_given("staticFriction")) {
      const double number = std::max(kPhysicsFriction, sliding.value_or(kPhysicsFriction));
      const MaterialParameter unwritten{"staticFriction", number, sources_.physics_element};
      if (auto error = add_default("friction", unwritten)) return error;
    }
    if (!physics.dynamic_friction && !is_given("dynamicFriction")) {
      const double number = std::min(kPhysicsFriction, sticking.value_or(kPhysicsFriction));
      const MaterialParameter unwritten{"dynamicFriction", number, sources_.physics_element};
      return add_default("friction", unwritten);
    }
    return std::nullopt;
  }

  // Chooses the friction map and the texture map, and reports all other maps.
  MaybeError add_maps() {
    if (!sources_.haptic) return std::nullopt;
    for (const HapticMap& map : sources_.haptic->maps) {
      if (map.property != kFrictionMap && map.property != kTextureMap) {
        ignore(map, "no effect uses a map for this property");
        continue;
      }
      const HapticMap*& chosen = map.property == kFrictionMap ? friction_map_ : texture_map_;
      if (chosen) {
        ignore(map, "only the first map for a property is used");
        continue;
      }
      chosen = &map;
    }
    if (texture_map_ && !is_given("textureHeight")) {
      const MaterialParameter height{"textureHeight", kDefaultTextureHeight_m,
                                     texture_map_->element};
      if (auto error = add_default("texture", height, kTextureMap)) return error;
    }
    const bool has_friction = is_given("staticFriction") || is_given("dynamicFriction");
    if (!friction_map_ || has_friction || sources_.physics) return std::nullopt;
    for (const char* key : {"staticFriction", "dynamicFriction"}) {
      const MaterialParameter coefficient{key, kMapFriction, friction_map_->element};
      if (auto error = add_default("friction", coefficient, kFrictionMap)) return error;
    }
    return std::nullopt;
  }

  void ignore(const HapticMap& map, const char* why) {
    result_.report.not_understood.push_back(
        {map.property, texture_text(map.texture), map.element, why});
  }

  static std::string texture_text(const TextureReference& texture) {
    return "texture " + std::to_string(texture.texture);
  }

  // Adds a default value that another part of the file requires. cause: the name of that part, for
  // an error; null if it is the key itself.
  MaybeError add_default(std::string_view effect, const MaterialParameter& parameter,
                         const char* cause = nullptr) {
    const double number = std::get<double>(parameter.value);
    const auto e = effect_number(effect);
    if (!e) {
      if (number == 0.0) return std::nullopt;
      return not_built_error(owner_, {cause ? cause : parameter.key, number, parameter.element},
                             effect);
    }
    for (const ParameterKey& k : compiled_effects()[*e].keys) {
      if (k.key == parameter.key) put(*e, {&k, number, parameter, ""});
    }
    return std::nullopt;
  }

  // If only one coefficient is given, the other one gets the same value.
  void complete_friction() {
    const auto effect = effect_number("friction");
    if (!effect || values_[*effect].size() != 1) return;
    const Value only = values_[*effect].front();
    for (const ParameterKey& key : compiled_effects()[*effect].keys) {
      if (&key == only.key) continue;
      put(*effect, {&key, only.number, {std::string(key.key), only.number, ""}, ""});
    }
  }

  // Sets the value of a key and replaces an earlier value of the same key.
  void put(std::size_t effect, Value value) {
    std::vector<Value>& values = values_[effect];
    const auto same = std::find_if(values.begin(), values.end(),
                                   [&](const Value& v) { return v.key == value.key; });
    if (same != values.end()) {
      *same = std::move(value);
    } else {
      values.push_back(std::move(value));
    }
  }

  // Null if the material does not give the key.
  const MaterialParameter* find_given(std::string_view key) const {
    const auto& parameters = sources_.material->parameters;
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const MaterialParameter& p) { return p.key == key; });
    return found == parameters.end() ? nullptr : &*found;
  }
  bool is_given(std::string_view key) const { return find_given(key) != nullptr; }

  // Adds an effect if it is active.
  MaybeError finish(std::uint16_t effect) {
    const EffectType& type = compiled_effects()[effect];
    std::vector<Value>& values = values_[effect];
    if (values.empty()) return std::nullopt;
    const auto has_role = [](Role role) {
      return [role](const ParameterKey& key) { return key.role == role; };
    };
    const auto find = [&](const ParameterKey& key) {
      return std::find_if(values.begin(), values.end(),
                          [&](const Value& v) { return v.key == &key; });
    };
    const bool has_switch =
        std::any_of(type.keys.begin(), type.keys.end(), has_role(Role::kDeclares));
    const Role switching = has_switch ? Role::kDeclares : Role::kRequired;
    const bool is_switch_given = std::any_of(
        values.begin(), values.end(), [&](const Value& v) { return v.key->role == switching; });
    const bool is_active = std::any_of(values.begin(), values.end(), [&](const Value& v) {
      return v.key->role == switching && (!has_switch || v.number != 0.0);
    });
    if (!is_switch_given) {
      const auto key = std::find_if(type.keys.begin(), type.keys.end(), has_role(switching));
      return error_at(owner_, values.front().given,
                      values.front().given.key + " is given without " + std::string(key->key),
                      "give both keys, or neither");
    }
    for (const ParameterKey& key : type.keys) {
      if (!is_active || key.role != Role::kRequired || find(key) != values.end()) continue;
      const Value& cause = *std::find_if(values.begin(), values.end(), [&](const Value& v) {
        return v.key->role == switching && v.number != 0.0;
      });
      return error_at(owner_, cause.given,
                      cause.given.key + " is given without " + std::string(key.key) +
                          "; expected " + expected_text(key),
                      "give both keys, or neither");
    }
    report(values, !is_active);
    return is_active ? enter(effect, values) : std::nullopt;
  }

  void report(const std::vector<Value>& values, bool is_off) {
    for (const Value& v : values) {
      const std::string unit(v.key->unit);
      if (v.source.empty()) {
        result_.report.defaulted.push_back({std::string(v.key->key), v.given.value, unit});
      } else {
        result_.report.honoured.push_back(
            {std::string(v.key->key), v.given.value, unit, v.source, v.given.element, is_off});
      }
    }
  }

  MaybeError enter(std::uint16_t effect, const std::vector<Value>& values) {
    const EffectType& type = compiled_effects()[effect];
    EffectProgramBuilder::Entry entry{effect, std::vector<std::byte>(type.parameter_bytes)};
    type.begin_parameters(entry.parameters.data());
    for (const ParameterKey& key : type.keys) {
      const auto value =
          std::find_if(values.begin(), values.end(), [&](const Value& v) { return v.key == &key; });
      if (value == values.end()) {
        report_default(key, entry.parameters);
        continue;
      }
      const double number = value->number * (key.scales_as_length ? sources_.scale : 1.0);
      std::memcpy(entry.parameters.data() + key.offset, &number, sizeof number);
    }
    if (const char* contradiction = type.contradiction(entry.parameters.data())) {
      return contradiction_error(contradiction, values);
    }
    if (auto error = check_maps(type, values)) return error;
    result_.entries.push_back(std::move(entry));
    return std::nullopt;
  }

  void report_default(const ParameterKey& key, const std::vector<std::byte>& parameters) {
    double number = 0.0;
    std::memcpy(&number, parameters.data() + key.offset, sizeof number);
    MaterialValue value = number;
    if (key.kind == ParameterKey::Kind::kChoice) {
      value = std::string(key.choices[static_cast<std::size_t>(number)]);
    }
    result_.report.defaulted.push_back({std::string(key.key), value, std::string(key.unit)});
  }

  Error contradiction_error(const char* contradiction, const std::vector<Value>& values) const {
    std::string where;
    const MaterialParameter* first = &values.front().given;
    for (const Value& v : values) {
      if (v.source.empty()) continue;
      if (!where.empty()) where += ", ";
      where += v.given.key + " " + value_text(v.given.value) + " of " + v.given.element;
      if (v.source != kPhysics) first = &v.given;
    }
    return error_at(owner_, *first, std::string(contradiction) + ": " + where);
  }

  // Checks that an effect has the map it needs, and reports this map.
  MaybeError check_maps(const EffectType& type, const std::vector<Value>& values) {
    if (type.needs & kNeedsFrictionMap) report_map(friction_map_);
    if (!(type.needs & kNeedsTextureMap)) return std::nullopt;
    report_map(texture_map_);
    if (texture_map_) return std::nullopt;
    const TextureReference* normals = texture_map(*sources_.material, sources_.haptic);
    if (!normals) {
      return error_at(owner_, values.front().given,
                      values.front().given.key +
                          " is given without a map; expected a normalTexture of the material or "
                          "a vibrotactileTexture of the mesh");
    }
    result_.report.honoured.push_back({kNormalMap, texture_text(*normals), "", kFile,
                                       sources_.material->element + "/" + kNormalMap});
    return std::nullopt;
  }

  // Reports that a map is applied or, with is_off, that its effect is off. map may be null.
  void report_map(const HapticMap* map, bool is_off = false) {
    if (!map) return;
    result_.report.honoured.push_back(
        {map->property, texture_text(map->texture), "", kHaptic, map->element, is_off});
  }

  // Reports the maps whose effects are off.
  void report_unused_maps() {
    if (!result_.entry("friction")) report_map(friction_map_, /*is_off=*/true);
    if (!result_.entry("texture")) report_map(texture_map_, /*is_off=*/true);
  }

  // A material that is not solid needs a viscosity and can have no other effect.
  MaybeError check_medium() {
    if (result_.is_solid) return std::nullopt;
    if (!result_.entry("viscosity")) {
      return error_at(owner_, solid_,
                      "solid is false without a viscosity above 0, so the material has no effect",
                      "give a viscosity, or set solid to true");
    }
    for (std::uint16_t effect = 0; effect < values_.size(); ++effect) {
      const std::string_view name = compiled_effects()[effect].name;
      if (name == "viscosity" || !result_.entry(name)) continue;
      for (const Value& v : values_[effect]) {
        if (v.source != kExtrasSource && v.source != kOverrideSource) continue;
        return error_at(owner_, v.given, v.given.key + " applies to a surface, but solid is false",
                        "remove " + v.given.key + ", or set solid to true");
      }
      leave_out(effect);
    }
    return std::nullopt;
  }

  // Removes an effect that other parts of the file declare for a surface that is not solid.
  void leave_out(std::uint16_t effect) {
    std::set<std::string> keys;
    if (compiled_effects()[effect].needs & kNeedsTextureMap) keys.insert({kTextureMap, kNormalMap});
    if (compiled_effects()[effect].needs & kNeedsFrictionMap) keys.insert(kFrictionMap);
    for (const ParameterKey& key : compiled_effects()[effect].keys) keys.emplace(key.key);
    std::erase_if(result_.entries, [&](const auto& entry) { return entry.effect == effect; });
    std::erase_if(result_.report.defaulted, [&](const auto& d) { return keys.contains(d.key); });
    std::erase_if(result_.report.honoured, [&](const HonouredParameter& h) {
      if (!keys.contains(h.key)) return false;
      result_.report.not_understood.push_back(
          {h.key, h.value, h.element, "the value applies to a surface, but solid is false"});
      return true;
    });
  }

  const MaterialSources& sources_;
  std::string owner_;
  std::vector<std::vector<Value>> values_;  // by effect
  const HapticMap* texture_map_ = nullptr;
  const HapticMap* friction_map_ = nullptr;
  MaterialParameter solid_;
  MaterialEffects result_;
};

}  // namespace

const EffectProgramBuilder::Entry* MaterialEffects::entry(std::string_view effect) const {
  const auto number = effect_number(effect);
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const auto& e) { return number && e.effect == *number; });
  return found == entries.end() ? nullptr : &*found;
}

std::vector<std::string> MaterialEffects::effect_names() const {
  std::vector<std::string> names;
  for (const auto& e : entries) names.emplace_back(compiled_effects()[e.effect].name);
  std::sort(names.begin(), names.end());
  return names;
}

Result<MaterialEffects> material_effects(const MaterialSources& sources) {
  return Compiler(sources).compile();
}

std::optional<std::uint16_t> effect_number(std::string_view name) {
  const auto types = compiled_effects();
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i].name == name) return static_cast<std::uint16_t>(i);
  }
  return std::nullopt;
}

}  // namespace palpate
