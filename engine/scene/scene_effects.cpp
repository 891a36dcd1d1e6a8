#include "engine/scene/scene_effects.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <numbers>
#include <set>
#include <string_view>
#include <tuple>
#include <variant>

#include "engine/scene/entry_parameters.h"
#include "engine/scene/material_parameters.h"
#include "engine/scene/merged_report.h"
#include "haptics/effects/friction.h"
#include "haptics/effects/shading.h"
#include "haptics/effects/texture.h"
#include "haptics/effects/vibration.h"

namespace palpate {
namespace {

using Entry = EffectProgramBuilder::Entry;

bool is_of(const Entry& entry, std::string_view effect) {
  return compiled_effects()[entry.effect].name == effect;
}

// Whether an effect belongs to the surroundings and not to a surface.
bool is_of_place(const Entry& entry) {
  return compiled_effects()[entry.effect].stage == EffectStage::kSurroundings;
}

std::size_t memory_of(const EffectProgram& program) {
  std::size_t bytes = sizeof program + program.calls.size() * sizeof(EffectCall) +
                      program.materials.size() * sizeof(EffectMaterial) +
                      program.bodies.size() * sizeof(EffectBody) +
                      program.material_of_part.size() * sizeof(std::uint32_t) +
                      program.parameters.size() + program.magnets.size() * sizeof(MagneticSurface) +
                      program.media.size() * sizeof(MediumRegion);
  for (const SurfaceAttributes& a : program.attributes) bytes += memory_bytes(a);
  for (const HeightMap& map : program.maps) bytes += map.memory_bytes();
  for (const SurfaceIndex& index : program.indices) bytes += index.memory_bytes();
  return bytes;
}

}  // namespace

SceneEffects::SceneEffects(const EffectDeclarations& declarations,
                           std::span<const MeshParts> meshes)
    : declarations_(declarations), meshes_(meshes) {
  no_material_.name = "default";
  no_material_.element = "default material";
}

Error SceneEffects::limit_error(std::string element, std::string problem) {
  return {ErrorCode::kLimitExceeded, "", std::move(element), std::move(problem),
          "load a part of it with `SceneSettings::node`"};
}

const MaterialDescription& SceneEffects::material_of(const Combination& c) const {
  return c.material ? declarations_.materials[*c.material] : no_material_;
}

const HapticMaterialDescription* SceneEffects::haptic_of(const Combination& c) const {
  return c.haptic ? &declarations_.haptic_materials[*c.haptic] : nullptr;
}

// Removes materials that do not exist in the declarations: a description may be made by hand.
SceneEffects::CombinationKey SceneEffects::existing(CombinationKey key) const {
  const std::array<std::size_t, 3> counts = {declarations_.materials.size(),
                                             declarations_.physics_materials.size(),
                                             declarations_.haptic_materials.size()};
  for (std::size_t i = 0; i < key.size(); ++i) {
    if (key[i] && *key[i] >= counts[i]) key[i].reset();
  }
  return key;
}

Result<std::size_t> SceneEffects::combination(const CombinationKey& key) {
  const auto known = combination_of_.find(key);
  if (known != combination_of_.end()) return known->second;
  if (combinations_.size() == kMostMaterialCombinations) {
    return limit_error("scene", "has more than " + std::to_string(kMostMaterialCombinations) +
                                    " combinations of materials, physics materials and haptic "
                                    "materials");
  }
  Combination c;
  std::tie(c.material, c.physics, c.haptic) = std::tie(key[0], key[1], key[2]);
  MaterialSources sources{&material_of(c)};
  if (c.physics) {
    sources.physics = &declarations_.physics_materials[*c.physics];
    sources.physics_element =
        "/extensions/KHR_physics_rigid_bodies/physicsMaterials/" + std::to_string(*c.physics);
  }
  sources.haptic = haptic_of(c);
  sources.scale = declarations_.scale;
  auto effects = material_effects(sources);
  if (!effects) return effects.error();
  c.effects = std::move(*effects);
  combinations_.push_back(std::move(c));
  combination_of_.emplace(key, combinations_.size() - 1);
  return combinations_.size() - 1;
}

Result<std::size_t> SceneEffects::material_set(const std::string& node, std::size_t mesh,
                                               std::optional<std::uint32_t> physics_material) {
  const std::pair key(mesh, physics_material);
  const auto known = material_set_of_.find(key);
  if (known != material_set_of_.end()) return known->second;
  const MeshParts& parts = meshes_[mesh];
  if (parts.materials().size() > kMostParts) {
    return limit_error("node \"" + node + "\"",
                       "its mesh has more than " + std::to_string(kMostParts) + " materials");
  }
  MaterialSet material_set;
  for (const auto& material : parts.materials()) {
    const auto c = combination(existing({material, physics_material, parts.haptic_material()}));
    if (!c) return c.error();
    material_set.combinations.push_back(*c);
    material_set.is_solid = material_set.is_solid && combinations_[*c].effects.is_solid;
  }
  if (!material_set.is_solid && material_set.combinations.size() > 1) {
    return Error{ErrorCode::kInvalidContent, "", "node \"" + node + "\"",
                 "its mesh has several materials, one of which is not solid; expected one material "
                 "for all faces",
                 "split the mesh by material"};
  }
  material_sets_.push_back(std::move(material_set));
  material_set_of_.emplace(key, material_sets_.size() - 1);
  return material_sets_.size() - 1;
}

Result<SceneEffectsResult> SceneEffects::compile(const EffectSurfaces& bodies,
                                                 const EffectSurfaces& media,
                                                 const Vec3& anchor_scene_m) {
  HeightMapMaker maps(declarations_.images, builder_.program.maps);
  if (auto error = add_materials(maps)) return *error;
  if (auto error = add_attributes(bodies)) return *error;
  if (auto error = add_magnets(bodies)) return *error;
  if (auto error = add_body_media(bodies)) return *error;
  if (auto error = add_through_media(media)) return *error;
  if (auto error = add_surroundings(anchor_scene_m)) return *error;
  report_materials();
  SceneEffectsResult result;
  add_bodies(bodies);
  auto program = std::make_shared<const EffectProgram>(std::move(builder_).finish());
  collect_calls(*program, result.calls);
  result.report = std::move(report_);
  if (program->calls.empty()) return result;
  result.memory_bytes = memory_of(*program);
  result.program = std::move(program);
  return result;
}

// --- Surfaces ------------------------------------------------------------------------------------

SceneEffects::MaybeError SceneEffects::add_materials(HeightMapMaker& maps) {
  for (Combination& c : combinations_) {
    if (c.effects.entries.empty() || !c.effects.is_solid) continue;
    std::vector<Entry> entries;
    std::copy_if(c.effects.entries.begin(), c.effects.entries.end(), std::back_inserter(entries),
                 [](const Entry& e) { return !is_of_place(e); });
    if (auto error = set_maps(c, maps, entries)) return error;
    c.program_material = builder_.add_material(entries);
  }
  return std::nullopt;
}

SceneEffects::MaybeError SceneEffects::set_maps(const Combination& c, HeightMapMaker& maps,
                                                std::vector<Entry>& entries) const {
  const MaterialDescription& material = material_of(c);
  const auto failed = [&](Error error) {
    error.element = material.element;
    error.problem = "material \"" + material.name + "\": " + error.problem;
    return error;
  };
  for (Entry& entry : entries) {
    if (is_of(entry, TextureEffect::kName)) {
      const TextureReference& reference = *texture_map(material, haptic_of(c));
      const bool is_normal_map = material.normal_texture && &reference == &*material.normal_texture;
      const auto map = is_normal_map ? maps.from_normals(reference) : maps.grey(reference);
      if (!map) return failed(map.error());
      auto parameters = read_parameters<TextureEffect::Parameters>(entry);
      parameters.map = *map;
      write_parameters(parameters, entry);
    }
    const TextureReference* friction = friction_map(haptic_of(c));
    if (friction && is_of(entry, FrictionEffect::kName)) {
      const auto map = maps.grey(*friction);
      if (!map) return failed(map.error());
      auto parameters = read_parameters<FrictionEffect::Parameters>(entry);
      parameters.map = *map;
      write_parameters(parameters, entry);
    }
  }
  return std::nullopt;
}

// Computes attributes for each shape whose surfaces have at least one effect.
SceneEffects::MaybeError SceneEffects::add_attributes(const EffectSurfaces& bodies) {
  std::map<std::size_t, std::vector<std::size_t>> material_sets_of_shape;
  std::map<std::size_t, std::size_t> body_of_shape;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    const EffectSurface body = bodies.at(b);
    const auto& combinations = material_sets_[body.material_set].combinations;
    const bool without_effects =
        std::all_of(combinations.begin(), combinations.end(),
                    [&](std::size_t c) { return combinations_[c].program_material == 0; });
    if (without_effects) continue;
    std::vector<std::size_t>& material_sets = material_sets_of_shape[body.shape];
    if (std::find(material_sets.begin(), material_sets.end(), body.material_set) ==
        material_sets.end()) {
      material_sets.push_back(body.material_set);
    }
    body_of_shape.emplace(body.shape, b);
  }
  // Attributes that consist of parts only: they do not depend on the stretch.
  std::map<const SurfaceIndex*, const SurfaceAttributes*> plain;
  for (const auto& [shape, material_sets] : material_sets_of_shape) {
    const EffectSurface body = bodies.at(body_of_shape[shape]);
    const auto needs = needs_of(body.surface, material_sets);
    if (!needs) {
      Error error = needs.error();
      error.element = "node \"" + std::string(body.node) + "\"";
      return error;
    }
    const SurfaceAttributes*& of_shape = attributes_of_shape_[shape];
    if (needs->is_of_parts_alone()) of_shape = plain[body.surface.index];
    if (of_shape) continue;
    auto& attributes = builder_.program.attributes;
    attributes.push_back(surface_attributes(body.surface, *needs));
    of_shape = &attributes.back();
    if (needs->is_of_parts_alone()) plain[body.surface.index] = of_shape;
  }
  return std::nullopt;
}

Result<AttributeNeeds> SceneEffects::needs_of(const PartedSurface& surface,
                                              std::span<const std::size_t> material_sets) const {
  AttributeNeeds needs;
  needs.crease_angles_rad.resize(surface.parts->materials().size());
  std::set<double> angles;
  for (const std::size_t material_set : material_sets) {
    for (std::size_t part = 0; part < material_sets_[material_set].combinations.size(); ++part) {
      const Combination& c = combinations_[material_sets_[material_set].combinations[part]];
      needs.texture_uv = needs.texture_uv || c.effects.entry(TextureEffect::kName);
      needs.friction_uv = needs.friction_uv ||
                          (c.effects.entry(FrictionEffect::kName) && friction_map(haptic_of(c)));
      if (const Entry* shading = c.effects.entry(ShadingEffect::kName)) {
        const double angle_rad =
            read_parameters<ShadingEffect::Parameters>(*shading).crease_angle_deg *
            std::numbers::pi / 180.0;
        needs.crease_angles_rad[part] = angle_rad;
        angles.insert(angle_rad);
      }
    }
  }
  if (angles.size() > kMostCreaseAngles) {
    return limit_error("", "its materials have " + std::to_string(angles.size()) +
                               " different values of creaseAngle; expected at most " +
                               std::to_string(kMostCreaseAngles) + " in one mesh");
  }
  const bool lacks_uv = (needs.texture_uv && !surface.parts->has_texture_uv()) ||
                        (needs.friction_uv && !surface.parts->has_friction_uv());
  if (lacks_uv) {
    return Error{ErrorCode::kInvalidContent, "", "",
                 "its mesh has no texture coordinates for the map of its material",
                 "add texture coordinates to the mesh"};
  }
  return needs;
}

void SceneEffects::add_bodies(const EffectSurfaces& bodies) {
  EffectProgram& program = builder_.program;
  std::vector<std::optional<std::uint32_t>> first_of_material_set(material_sets_.size());
  for (std::size_t b = 0; b < bodies.count; ++b) {
    if (attributes_of_shape_.empty()) {
      program.bodies.resize(bodies.count);
      return;
    }
    const EffectSurface body = bodies.at(b);
    const auto attributes = attributes_of_shape_.find(body.shape);
    if (attributes == attributes_of_shape_.end()) {
      program.bodies.push_back({});
      continue;
    }
    auto& first = first_of_material_set[body.material_set];
    if (!first) {
      first = static_cast<std::uint32_t>(program.material_of_part.size());
      for (const std::size_t c : material_sets_[body.material_set].combinations) {
        program.material_of_part.push_back(combinations_[c].program_material);
      }
    }
    program.bodies.push_back({attributes->second, *first});
  }
}

// --- Reports -------------------------------------------------------------------------------------

void SceneEffects::report_materials() {
  for (const MaterialDescription& material : declarations_.materials) {
    report_.materials.push_back({material.name, material.element, {}, {}});
  }
  DeclarationReport none{no_material_.name, no_material_.element, {}, {}};
  std::map<DeclarationReport*, MergedReport> merged;
  for (const Combination& c : combinations_) {
    DeclarationReport& report = c.material ? report_.materials[*c.material] : none;
    merged[&report].append(c.effects.report, report.report);
    merge_names(c.effects.effect_names(), report.effects);
    merge_names(c.effects.effect_names(), report_.effects);
  }
  if (!none.report.empty()) report_.materials.push_back(std::move(none));
}

void SceneEffects::collect_calls(const EffectProgram& program,
                                 std::vector<MaterialCalls>& calls) const {
  for (const Combination& c : combinations_) {
    MaterialCalls of_material{name_of(c), {}};
    for (const EffectTable& table : program.materials[c.program_material].tables) {
      for (std::uint32_t i = 0; i < table.count; ++i) {
        of_material.calls.push_back(table.first + i);
      }
    }
    for (const std::uint32_t place : c.places) {
      of_material.calls.push_back(program.places.first + place);
    }
    calls.push_back(std::move(of_material));
  }
}

std::optional<Error> check_tick_rate(const SceneEffectsReport& report, double rate_Hz) {
  constexpr std::string_view kFrequency = VibrationEffect::kKeys[0].key;
  for (const DeclarationReport& material : report.materials) {
    for (const HonouredParameter& p : material.report.honoured) {
      const auto* frequency_Hz = std::get_if<double>(&p.value);
      if (p.key != kFrequency || p.is_off || !frequency_Hz || 2.0 * *frequency_Hz < rate_Hz) {
        continue;
      }
      return parameter_error(
          "material \"" + material.name + "\"", {p.key, p.value, p.element},
          "less than half of `RunSettings::rate_Hz`, " + value_text(rate_Hz / 2.0) + " Hz");
    }
  }
  return std::nullopt;
}

}  // namespace palpate
