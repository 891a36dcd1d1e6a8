#pragma once

// Turns what a scene declares into the effect program of its world.

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

// Of what costs a query in every tick near it.
inline constexpr std::size_t kMostMagnets = 256;
inline constexpr std::size_t kMostMedia = 256;
// Each costs a pass over the surface when a scene is compiled.
inline constexpr std::size_t kMostCreaseAngles = 16;  // of one mesh
// Of materials of the three kinds, and of their parts in the effect program.
inline constexpr std::size_t kMostMaterialCombinations = std::size_t{1} << 16;
inline constexpr std::size_t kMostParts = std::size_t{1} << 16;  // of one mesh

// A part of a file that declares how something feels, and what became of it.
struct DeclarationReport {
  std::string name;
  std::string element;
  std::vector<std::string> effects;  // sorted
  MaterialReport report;
};

struct SceneEffectsReport {
  std::vector<std::string> effects;  // of the scene, sorted
  // As SceneDescription::materials, and one more for triangles without a material if anything is
  // declared for them. Of a material that is felt in several ways, with different physics materials
  // say, all of them together.
  std::vector<DeclarationReport> materials;
  DeclarationReport scene;
  std::vector<DeclarationReport> regions;
};

// Which calls of the effect program are of a material: what material_tuner.h needs.
struct MaterialCalls {
  std::string material;  // its name
  std::vector<std::uint32_t> calls;
};

// What a file declares; all of it must outlive the compiler.
struct EffectDeclarations {
  std::span<const MaterialDescription> materials;
  std::span<const PhysicsMaterialDescription> physics_materials;
  std::span<const HapticMaterialDescription> haptic_materials;
  std::span<const ImageDescription> images;
  const MaterialDescription* scene_parameters;
  std::span<const RegionDescription> regions;  // scaled as the scene is
  double scale = 1.0;                          // of the scene
};

// A surface of a node, as one tick meets it.
struct EffectSurface {
  std::string_view node;     // name, for messages
  std::size_t material_set;  // of SceneEffects::material_set()
  std::size_t shape;         // surfaces of one shape share attributes
  PartedSurface surface;
  RigidTransform T_solver_body;
  double metres_per_unit;  // of the body frame (ContactBody)
};

// Made when they are asked for: a scene has a million, and few of them are felt by an effect.
struct EffectSurfaces {
  std::size_t count;
  std::function<EffectSurface(std::size_t)> at;
};

struct SceneEffectsResult {
  std::shared_ptr<const EffectProgram> program;  // null if nothing is called for
  std::vector<MaterialCalls> calls;
  SceneEffectsReport report;
  std::size_t memory_bytes = 0;
};

// First every node is asked for its material_set, then all is compiled. Load time only. Errors are
// those of material_effects() and of surroundings.h, and name the node where it matters which.
class SceneEffects {
 public:
  SceneEffects(const EffectDeclarations& declarations, std::span<const MeshParts> meshes);

  // How the parts of a mesh are felt on a node with this physics material. The number is the same
  // for nodes that are alike.
  Result<std::size_t> material_set(const std::string& node, std::size_t mesh,
                                   std::optional<std::uint32_t> physics_material);
  // False: the nodes are no bodies, only the medium inside is felt.
  bool is_solid(std::size_t material_set) const { return material_sets_[material_set].is_solid; }

  // bodies: as the world's. media: those that are not solid.
  Result<SceneEffectsResult> compile(const EffectSurfaces& bodies, const EffectSurfaces& media,
                                     const Vec3& anchor_scene_m);

 private:
  // A material in a program: what is felt where these three meet.
  struct Combination {
    std::optional<std::uint32_t> material, physics, haptic;
    MaterialEffects effects;
    std::uint32_t program_material = 0;
    std::vector<std::uint32_t> places;  // its calls among those that are felt in places
  };
  struct MaterialSet {
    std::vector<std::size_t> combinations;  // by part
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

// Null if no vibration of the program has a frequency that ticks at this rate cannot carry; else an
// Error that names material and key.
std::optional<Error> check_tick_rate(const SceneEffectsReport& report, double rate_Hz);

}  // namespace palpate
