#include "engine/scene/scene_effects.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <numbers>
#include <set>

#include <Eigen/SVD>

#include "engine/scene/material_parameters.h"
#include "geometry/index/inside.h"
#include "haptics/effects/friction.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/shading.h"
#include "haptics/effects/texture.h"
#include "haptics/effects/vibration.h"
#include "haptics/effects/viscosity.h"

namespace palpate {
namespace {

using Entry = EffectProgramBuilder::Entry;

bool is_of(const Entry& entry, std::string_view effect) {
  return compiled_effects()[entry.effect].name == effect;
}

// Those that are not of a surface but of what is around it.
bool is_of_place(const Entry& entry) {
  return compiled_effects()[entry.effect].stage == EffectStage::kSurroundings;
}

// Parameters are kept as bytes.
template <typename Parameters>
Parameters read(const Entry& entry) {
  Parameters parameters;
  std::memcpy(&parameters, entry.parameters.data(), sizeof parameters);
  return parameters;
}

template <typename Parameters>
void write(const Parameters& parameters, Entry& entry) {
  entry.parameters.resize(sizeof parameters);
  std::memcpy(entry.parameters.data(), &parameters, sizeof parameters);
}

Error limit_error(std::string element, std::string problem) {
  return {ErrorCode::kLimitExceeded, "", std::move(element), std::move(problem),
          "load a part of it with `SceneSettings::node`"};
}

std::string joined(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) (all += part) += '\0';
  return all;
}

// Equal for what is told once.
std::string identity(const HonouredParameter& p) {
  return joined({p.key, p.element, value_text(p.value), p.is_off ? "off" : "on"});
}
std::string identity(const DefaultedParameter& p) {
  return joined({p.key, value_text(p.value)});
}
std::string identity(const IgnoredParameter& p) {
  return joined({p.key, p.element, value_text(p.value), p.why});
}

// Gathers what is told of one material that is felt in several ways, each thing once. There may be
// as many ways as physics materials, so what is known is looked up.
class MergedReport {
 public:
  void append(const MaterialReport& more, MaterialReport& report) {
    append_new(more.honoured, honoured_, report.honoured);
    append_new(more.defaulted, defaulted_, report.defaulted);
    append_new(more.not_understood, not_understood_, report.not_understood);
  }

 private:
  using Known = std::set<std::string>;

  template <typename T>
  static void append_new(const std::vector<T>& more, Known& known, std::vector<T>& list) {
    for (const T& item : more) {
      if (known.insert(identity(item)).second) list.push_back(item);
    }
  }

  Known honoured_, defaulted_, not_understood_;
};

void append(const std::vector<std::string>& more, std::vector<std::string>& sorted) {
  std::set<std::string> all(sorted.begin(), sorted.end());
  all.insert(more.begin(), more.end());
  sorted.assign(all.begin(), all.end());
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

AffineMap map_index_solver(const EffectSurface& surface) {
  const Quat to_body = surface.T_solver_body.rotation.conjugate();
  AffineMap map{to_body.toRotationMatrix(), -(to_body * surface.T_solver_body.translation_m)};
  const double units_per_metre = 1.0 / surface.metres_per_unit;
  map.linear *= units_per_metre;
  map.translation_m *= units_per_metre;
  if (const Stretch* stretch = surface.surface.stretch) {
    for (int k = 0; k < 3; ++k) map.linear.col(k) = stretch->to_index(Vec3(map.linear.col(k)));
    map.translation_m = stretch->to_index(map.translation_m);
  }
  return map;
}

double largest_stretch(const Mat3& linear) {
  return Eigen::JacobiSVD<Mat3>(linear).singularValues()[0];
}

}  // namespace

SceneEffects::SceneEffects(const EffectDeclarations& declarations,
                           std::span<const MeshParts> meshes)
    : declarations_(declarations), meshes_(meshes) {
  no_material_.name = "default";
  no_material_.element = "default material";
}

const MaterialDescription& SceneEffects::material_of(const Combination& c) const {
  return c.material ? declarations_.materials[*c.material] : no_material_;
}

const HapticMaterialDescription* SceneEffects::haptic_of(const Combination& c) const {
  return c.haptic ? &declarations_.haptic_materials[*c.haptic] : nullptr;
}

// What the declarations do not have is none: a description may be made by hand.
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
    return limit_error("scene", "its materials meet in more than " +
                                    std::to_string(kMostMaterialCombinations) +
                                    " combinations with those of nodes and meshes");
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

Result<std::size_t> SceneEffects::outfit(const std::string& node, std::size_t mesh,
                                         std::optional<std::uint32_t> physics_material) {
  const std::pair key(mesh, physics_material);
  const auto known = outfit_of_.find(key);
  if (known != outfit_of_.end()) return known->second;
  const MeshParts& parts = meshes_[mesh];
  if (parts.materials().size() > kMostParts) {
    return limit_error("node \"" + node + "\"",
                       "its mesh has more than " + std::to_string(kMostParts) + " materials");
  }
  Outfit outfit;
  for (const auto& material : parts.materials()) {
    const auto c = combination(existing({material, physics_material, parts.haptic_material()}));
    if (!c) return c.error();
    outfit.combinations.push_back(*c);
    outfit.is_solid = outfit.is_solid && combinations_[*c].effects.is_solid;
  }
  if (!outfit.is_solid && outfit.combinations.size() > 1) {
    return Error{ErrorCode::kInvalidContent, "", "node \"" + node + "\"",
                 "its mesh has several materials, of which one is not solid; expected one material "
                 "for all faces",
                 ""};
  }
  outfits_.push_back(std::move(outfit));
  outfit_of_.emplace(key, outfits_.size() - 1);
  return outfits_.size() - 1;
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
      auto parameters = read<TextureEffect::Parameters>(entry);
      parameters.map = *map;
      write(parameters, entry);
    }
    const TextureReference* friction = friction_map(haptic_of(c));
    if (friction && is_of(entry, FrictionEffect::kName)) {
      const auto map = maps.grey(*friction);
      if (!map) return failed(map.error());
      auto parameters = read<FrictionEffect::Parameters>(entry);
      parameters.map = *map;
      write(parameters, entry);
    }
  }
  return std::nullopt;
}

// For each shape whose surfaces are felt by anything at all.
SceneEffects::MaybeError SceneEffects::add_attributes(const EffectSurfaces& bodies) {
  std::map<std::size_t, std::vector<std::size_t>> outfits_of_shape;
  std::map<std::size_t, std::size_t> body_of_shape;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    const EffectSurface body = bodies.at(b);
    const auto& combinations = outfits_[body.outfit].combinations;
    const bool is_bare = std::all_of(combinations.begin(), combinations.end(), [&](std::size_t c) {
      return combinations_[c].program_material == 0;
    });
    if (is_bare) continue;
    std::vector<std::size_t>& outfits = outfits_of_shape[body.shape];
    if (std::find(outfits.begin(), outfits.end(), body.outfit) == outfits.end()) {
      outfits.push_back(body.outfit);
    }
    body_of_shape.emplace(body.shape, b);
  }
  // Of which only the parts are asked for: the same however they are stretched.
  std::map<const SurfaceIndex*, const SurfaceAttributes*> plain;
  for (const auto& [shape, outfits] : outfits_of_shape) {
    const EffectSurface body = bodies.at(body_of_shape[shape]);
    const auto needs = needs_of(body.surface, outfits);
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
                                              std::span<const std::size_t> outfits) const {
  AttributeNeeds needs;
  needs.crease_angles_rad.resize(surface.parts->materials().size());
  std::set<double> angles;
  for (const std::size_t outfit : outfits) {
    for (std::size_t part = 0; part < outfits_[outfit].combinations.size(); ++part) {
      const Combination& c = combinations_[outfits_[outfit].combinations[part]];
      needs.texture_uv = needs.texture_uv || c.effects.entry(TextureEffect::kName);
      needs.friction_uv = needs.friction_uv ||
                          (c.effects.entry(FrictionEffect::kName) && friction_map(haptic_of(c)));
      if (const Entry* shading = c.effects.entry(ShadingEffect::kName)) {
        const double angle_rad =
            read<ShadingEffect::Parameters>(*shading).crease_angle_deg * std::numbers::pi / 180.0;
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
                 "its mesh has no texture coordinates for the map that it is to be felt by", ""};
  }
  return needs;
}

void SceneEffects::add_bodies(const EffectSurfaces& bodies) {
  EffectProgram& program = builder_.program;
  std::vector<std::optional<std::uint32_t>> first_of_outfit(outfits_.size());
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
    auto& first = first_of_outfit[body.outfit];
    if (!first) {
      first = static_cast<std::uint32_t>(program.material_of_part.size());
      for (const std::size_t c : outfits_[body.outfit].combinations) {
        program.material_of_part.push_back(combinations_[c].program_material);
      }
    }
    program.bodies.push_back({attributes->second, *first});
  }
}

// --- Magnets -------------------------------------------------------------------------------------

SceneEffects::MaybeError SceneEffects::add_magnets(const EffectSurfaces& bodies) {
  for (std::uint32_t b = 0; b < bodies.count; ++b) {
    const EffectSurface body = bodies.at(b);
    const auto& combinations = outfits_[body.outfit].combinations;
    for (std::size_t part = 0; part < combinations.size(); ++part) {
      Combination& c = combinations_[combinations[part]];
      const Entry* magnet = c.effects.entry(MagnetEffect::kName);
      if (!magnet) continue;
      auto& magnets = builder_.program.magnets;
      if (magnets.size() == kMostMagnets) {
        return place_error(body, c, MagnetEffect::kKeys[0].key,
                           "is one magnetic surface too many; expected at most " +
                               std::to_string(kMostMagnets) + " in a scene",
                           "load a part of it with `SceneSettings::node`");
      }
      magnets.push_back({b, c.program_material, magnet_index(body, part)});
      Entry entry = *magnet;
      auto parameters = read<MagnetEffect::Parameters>(entry);
      parameters.surface = &magnets.back();
      write(parameters, entry);
      add_place(entry, &c);
    }
  }
  return std::nullopt;
}

// Of the faces of one part, shared by all surfaces that share the index of all parts.
const SurfaceIndex* SceneEffects::magnet_index(const EffectSurface& body, std::size_t part) {
  if (body.surface.parts->materials().size() == 1) return body.surface.index;
  const SurfaceIndex*& index = index_of_part_[{body.surface.index, part}];
  if (!index) {
    auto& indices = builder_.program.indices;
    indices.push_back(part_index(body.surface, part));
    index = &indices.back();
  }
  return index;
}

// --- Media ---------------------------------------------------------------------------------------

Error SceneEffects::place_error(const EffectSurface& surface, const Combination& c,
                                std::string_view key, const std::string& problem,
                                const std::string& hint) const {
  std::string element = material_of(c).element;
  for (const HonouredParameter& h : c.effects.report.honoured) {
    if (h.key == key) element = h.element;
  }
  return {ErrorCode::kInvalidContent, "", element,
          "material \"" + name_of(c) + "\", node \"" + std::string(surface.node) + "\": " + problem,
          hint};
}

// The arguments by which a material has no medium; then it must be solid.
std::string SceneEffects::without_medium(const Combination& c) const {
  const auto argument = [&](std::string_view key, const char* value) {
    return "`SceneSettings::overrides` \"" + name_of(c) + "." + std::string(key) + "=" + value +
           "\"";
  };
  const std::string none = argument(ViscosityEffect::kKeys[0].key, "0");
  return c.effects.is_solid ? none : none + " " + argument(kSolidKey, "true");
}

SceneEffects::MaybeError SceneEffects::check_medium_surface(const EffectSurface& surface,
                                                            const Combination& c) {
  const std::string_view key = ViscosityEffect::kKeys[0].key;
  if (surface.surface.parts->materials().size() > 1) {
    return place_error(surface, c, key,
                       "its mesh has other materials, too; viscosity needs one for all faces", "");
  }
  const SurfaceMesh& mesh = *surface.surface.mesh;
  const auto known = is_closed_.find(&mesh);
  const bool closed =
      known != is_closed_.end() ? known->second : (is_closed_[&mesh] = is_closed(mesh));
  if (closed) return std::nullopt;
  const std::size_t boundary = mesh.report().boundary_edges;
  return place_error(surface, c, key,
                     boundary > 0
                         ? "its surface is open: " + std::to_string(boundary) +
                               " boundary edges; viscosity needs a closed one"
                         : std::string("its surface does not close: an edge has an odd number of "
                                       "faces; viscosity needs a closed one"),
                     "close the surface, or load it without the medium: " + without_medium(c));
}

SceneEffects::MaybeError SceneEffects::add_body_media(const EffectSurfaces& bodies) {
  for (std::uint32_t b = 0; b < bodies.count; ++b) {
    const EffectSurface body = bodies.at(b);
    for (const std::size_t i : outfits_[body.outfit].combinations) {
      Combination& c = combinations_[i];
      const Entry* viscosity = c.effects.entry(ViscosityEffect::kName);
      if (!viscosity) continue;
      if (auto error = check_medium_surface(body, c)) return error;
      MediumRegion region;
      region.shape = MediumRegion::Shape::kInside;
      region.body = b;
      if (auto error = add_medium(*viscosity, region, &c)) return error;
    }
  }
  return std::nullopt;
}

SceneEffects::MaybeError SceneEffects::add_through_media(const EffectSurfaces& media) {
  for (std::size_t m = 0; m < media.count; ++m) {
    const EffectSurface surface = media.at(m);
    Combination& c = combinations_[outfits_[surface.outfit].combinations.front()];
    if (auto error = check_medium_surface(surface, c)) return error;
    MediumRegion region;
    region.shape = MediumRegion::Shape::kThrough;
    region.p_region_solver = map_index_solver(surface);
    region.least_scale = 1.0 / largest_stretch(region.p_region_solver.linear);
    region.index = surface.surface.index;
    if (auto error = add_medium(*c.effects.entry(ViscosityEffect::kName), region, &c)) return error;
  }
  return std::nullopt;
}

SceneEffects::MaybeError SceneEffects::add_medium(const Entry& entry, const MediumRegion& region,
                                                  Combination* owner) {
  auto& media = builder_.program.media;
  if (media.size() == kMostMedia) {
    return limit_error("scene", "has more than " + std::to_string(kMostMedia) +
                                    " places with a viscosity, the most that are felt");
  }
  media.push_back(region);
  Entry with_region = entry;
  auto parameters = read<ViscosityEffect::Parameters>(entry);
  parameters.region = &media.back();
  write(parameters, with_region);
  add_place(with_region, owner);
  return std::nullopt;
}

// --- Surroundings --------------------------------------------------------------------------------

// Calls in places are counted, so that those of a material can be found again.
void SceneEffects::add_place(const Entry& entry, Combination* owner) {
  builder_.add_surroundings(entry);
  if (owner) owner->places.push_back(place_count_);
  ++place_count_;
}

SceneEffects::MaybeError SceneEffects::add_surroundings(const Vec3& anchor_scene_m) {
  const MaterialDescription& scene = *declarations_.scene_parameters;
  auto fields = scene_fields(scene);
  if (!fields) return fields.error();
  report_.scene = {scene.name, scene.element, {}, std::move(fields->report)};
  if (fields->gravity) {
    Entry entry{*effect_number(GravityEffect::kName), {}};
    write(*fields->gravity, entry);
    builder_.add_surroundings(entry);
    report_.scene.effects = {std::string(GravityEffect::kName)};
    report_.effects = report_.scene.effects;
  }
  for (const RegionDescription& region : declarations_.regions) {
    auto medium = node_medium(region, anchor_scene_m);
    if (!medium) return medium.error();
    report_.regions.push_back({region.name, region.element, {}, std::move(medium->report)});
    if (medium->viscosity_Ns_per_m == 0.0) continue;
    Entry entry{*effect_number(ViscosityEffect::kName), {}};
    write(ViscosityEffect::Parameters{medium->viscosity_Ns_per_m, nullptr}, entry);
    if (auto error = add_medium(entry, medium->region, nullptr)) return error;
    report_.regions.back().effects = {std::string(ViscosityEffect::kName)};
    append(report_.regions.back().effects, report_.effects);
  }
  return std::nullopt;
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
    append(c.effects.effect_names(), report.effects);
    append(c.effects.effect_names(), report_.effects);
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
