#pragma once

// Turns the declarations of a scene into the effect program of its world.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/scene/material_effects.h"
#include "engine/scene/surface_attributes.h"
#include "engine/scene/surroundings.h"
#include "geometry/base/result.h"
#include "haptics/effects/effect_program.h"
#include "io/scene_description.h"

namespace palpate {

// Limits of one scene. A magnet or a medium costs a query in every tick in which the proxy is near
// it.
inline constexpr std::size_t kMostMagnets = 256;
inline constexpr std::size_t kMostMedia = 256;
// Limit of one mesh. Each crease angle costs a pass over the surface while a scene is compiled.
inline constexpr std::size_t kMostCreaseAngles = 16;
// Limit of one scene: combinations of a material, a physics material and a haptic material.
inline constexpr std::size_t kMostMaterialCombinations = std::size_t{1} << 16;
// Limit of one mesh: parts with different materials.
inline constexpr std::size_t kMostParts = std::size_t{1} << 16;

// An element of a file that declares effects, with the report of its declarations.
struct DeclarationReport {
  std::string name;
  std::string element;
  std::vector<std::string> effects;  // sorted
  MaterialReport report;
};

struct SceneEffectsReport {
  std::vector<std::string> effects;  // all active effects of the scene, sorted
  // In the order of SceneDescription::materials. One more element follows if anything is declared
  // for triangles without a material. If a material occurs in several combinations, for example
  // with different physics materials, its report covers all of them.
  std::vector<DeclarationReport> materials;
  DeclarationReport scene;
  std::vector<DeclarationReport> regions;
};

// The calls of the effect program that belong to a material. material_tuner.h uses them.
struct MaterialCalls {
  std::string material;  // name of the material
  std::vector<std::uint32_t> calls;
};

// The declarations of a file. All referenced objects must outlive SceneEffects.
struct EffectDeclarations {
  std::span<const MaterialDescription> materials;
  std::span<const PhysicsMaterialDescription> physics_materials;
  std::span<const HapticMaterialDescription> haptic_materials;
  std::span<const ImageDescription> images;
  const MaterialDescription* scene_parameters;
  std::span<const RegionDescription> regions;  // already scaled by `scale`
  double scale = 1.0;                          // scale of the scene
};

// The surface of a node: its materials, its shape and its pose.
struct EffectSurface {
  std::string_view node;     // name, for messages
  std::size_t material_set;  // SceneEffects::material_set()
  std::size_t shape;         // surfaces with the same number share attributes
  PartedSurface surface;
  RigidTransform T_solver_body;
  double metres_per_unit;  // of the body frame (ContactBody)
};

// Surfaces created on demand: a scene can have a million surfaces, and effects use few of them.
struct EffectSurfaces {
  std::size_t count;
  std::function<EffectSurface(std::size_t)> at;
};

struct SceneEffectsResult {
  std::shared_ptr<const EffectProgram> program;  // null if no effect is active
  std::vector<MaterialCalls> calls;
  SceneEffectsReport report;
  std::size_t memory_bytes = 0;
};

// Compiles the effects of a scene. The caller first calls material_set() for every node and then
// compile(). For load time only. The errors are those of material_effects() and surroundings.h; an
// error names the node if it depends on the node.
class SceneEffects {
 public:
  SceneEffects(const EffectDeclarations& declarations, std::span<const MeshParts> meshes);

  // Follows a change of the list of meshes, whose first elements are as before.
  void set_meshes(std::span<const MeshParts> meshes) { meshes_ = meshes; }

  // Returns the number of the material set of a node. A material set has one entry for each part of
  // the mesh: the combination of the part's materials with this physics material. Equal sets have
  // the same number.
  Result<std::size_t> material_set(const std::string& node, std::size_t mesh,
                                   std::optional<std::uint32_t> physics_material);
  // False: nodes with this material set bound a medium and are not bodies of the world.
  bool is_solid(std::size_t material_set) const { return material_sets_[material_set].is_solid; }

  // bodies: in the order of the world's bodies. media: the surfaces that are not solid.
  Result<SceneEffectsResult> compile(const EffectSurfaces& bodies, const EffectSurfaces& media,
                                     const Vec3& anchor_scene_m);

 private:
  // The effects of one combination of a material, a physics material and a haptic material.
  struct Combination {
    std::optional<std::uint32_t> material, physics, haptic;
    MaterialEffects effects;
    std::uint32_t program_material = 0;
    std::vector<std::uint32_t> places;  // indices of its calls among the calls of surroundings
  };
  struct MaterialSet {
    std::vector<std::size_t> combinations;  // one per part
    bool is_solid = true;
  };
  using MaybeError = std::optional<Error>;
  using CombinationKey = std::array<std::optional<std::uint32_t>, 3>;

  static Error limit_error(std::string element, std::string problem);
  CombinationKey existing(CombinationKey key) const;
  Result<std::size_t> combination(const CombinationKey& key);
  const MaterialDescription& material_of(const Combination& c) const;
  const HapticMaterialDescription* haptic_of(const Combination& c) const;
  std::string name_of(const Combination& c) const { return material_of(c).name; }
  Error place_error(const EffectSurface& surface, const Combination& c, std::string_view key,
                    const std::string& problem, const std::string& hint) const;

  std::string without_medium(const Combination& c) const;

  MaybeError add_materials(HeightMapMaker& maps);
  MaybeError set_maps(const Combination& c, HeightMapMaker& maps,
                      std::vector<EffectProgramBuilder::Entry>& entries) const;
  MaybeError add_attributes(const EffectSurfaces& bodies);
  Result<AttributeNeeds> needs_of(const PartedSurface& surface,
                                  std::span<const std::size_t> material_sets) const;
  void add_bodies(const EffectSurfaces& bodies);
  MaybeError add_magnets(const EffectSurfaces& bodies);
  const SurfaceIndex* magnet_index(const EffectSurface& body, std::size_t part);
  MaybeError add_body_media(const EffectSurfaces& bodies);
  MaybeError add_through_media(const EffectSurfaces& media);
  MaybeError check_medium_surface(const EffectSurface& surface, const Combination& c);
  MaybeError add_medium(const EffectProgramBuilder::Entry& entry, const MediumRegion& region,
                        Combination* owner);
  MaybeError add_surroundings(const Vec3& anchor_scene_m);
  void add_place(const EffectProgramBuilder::Entry& entry, Combination* owner);
  void report_materials();
  void collect_calls(const EffectProgram& program, std::vector<MaterialCalls>& calls) const;

  EffectDeclarations declarations_;
  std::span<const MeshParts> meshes_;
  MaterialDescription no_material_;
  std::vector<Combination> combinations_;
  std::map<CombinationKey, std::size_t> combination_of_;
  std::vector<MaterialSet> material_sets_;
  std::map<std::pair<std::size_t, std::optional<std::uint32_t>>, std::size_t> material_set_of_;

  EffectProgramBuilder builder_;
  std::map<std::size_t, const SurfaceAttributes*> attributes_of_shape_;
  std::map<std::pair<const SurfaceIndex*, std::size_t>, const SurfaceIndex*> index_of_part_;
  std::map<const SurfaceMesh*, bool> is_closed_;
  std::uint32_t place_count_ = 0;
  SceneEffectsReport report_;
};

// Returns an error if the frequency of an active vibration is half of the tick rate or more;
// otherwise no value. The error names the material and the key.
std::optional<Error> check_tick_rate(const SceneEffectsReport& report, double rate_Hz);

}  // namespace palpate
