#pragma once

// A scene compiled once from what io read, and immutable afterwards.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/node_placement.h"
#include "engine/scene/scene_effects.h"
#include "engine/scene/seams.h"
#include "engine/scene/shared_indices.h"
#include "engine/scene/surface_attributes.h"
#include "geometry/base/box.h"
#include "geometry/base/memory_breakdown.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"
#include "haptics/proxy/contact_world.h"
#include "io/scene_description.h"

namespace palpate {

// What to make of a description. Of scale and fit_size_m one at most; neither is checked here.
struct SceneSettings {
  double proxy_radius_m = 0.0;  // the largest proxy that will touch the scene
  std::string node = {};        // only this node and what is below it (find_node); empty: all
  double scale = 1.0;           // of everything, about the origin of the scene; > 0
  double fit_size_m = 0.0;      // > 0: the scale is such that the largest extent becomes this
  std::vector<MaterialOverride> overrides = {};  // when a file is loaded, beside what it says
  // When a file is loaded: one of its animations at one time, "NAME@SECONDS" or "#number@SECONDS"
  // (GltfPose::choose); empty: the file's rest pose.
  std::string pose = {};
  // Memory that loading may take; 0: half of what is free (memory_budget.h).
  std::uint64_t max_memory_bytes = 0;
};

// What `palpate info` tells. Triangles are counted per mesh, except instanced_triangles.
struct SceneStatistics {
  std::size_t nodes = 0;
  std::size_t meshes = 0;
  std::size_t instances = 0;
  CleaningReport cleaning;              // summed over meshes
  std::size_t instanced_triangles = 0;  // summed over nodes
  std::size_t indices = 0;              // that were built: see shared_indices.h
  std::size_t seam_vertices = 0;        // of nodes, joined with those of others (seams.h)
  std::size_t seam_places = 0;          // where they are
  std::size_t seam_nodes = 0;           // that have them
  double scale = 1.0;                   // that the scene was given
  Vec3 extent_m = Vec3::Zero();
  Box bounds_scene = {Vec3::Zero(), Vec3::Zero()};  // of the extent
  std::vector<AnimationDescription> animations;     // all of the file
  std::optional<PoseDescription> pose;              // of one of them; nothing: at rest
  double parse_ms = 0.0;
  double mesh_ms = 0.0;
  double index_ms = 0.0;
  MemoryBreakdown memory;  // of meshes and indices
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

// One node of the scene that can be touched. Nodes whose material is not solid are none: they are a
// region with a medium, which stays where the file has it (NodeMotions does not move it).
struct SceneObject {
  std::string name;
  std::uint32_t mesh;           // index for Scene::mesh()
  std::uint32_t tree_node;      // index into Scene::tree()
  RigidTransform T_scene_body;  // the pose of its body, but for the unit (ContactBody)
  std::optional<std::uint32_t> physics_material = {};  // index into Scene::physics_materials()
};

// Surfaces, their indices and their places. The scene frame is that of the file, glTF world
// coordinates in metres, times the scale of its settings. Immutable; any number of haptic loops and
// threads may read it.
class Scene {
 public:
  // Reads and compiles a glTF file. Besides the errors of read_gltf() and compile(): where the
  // system has no more memory, kOutOfMemory, which names the step and what it takes.
  static Result<Scene> load(const std::string& path, const SceneSettings& settings = {});

  // Compiles a description. Nodes with a singular transform have no surface to touch; they are
  // left out with a warning. An error if nothing is left, if the node is not to be found, or if
  // what is declared about how it feels is wrong or contradictory (scene_effects.h). Every step
  // tells what it takes before it does: an error (kLimitExceeded) if that is more than is left of
  // what the settings allow, or (kOutOfMemory) if the system has less.
  static Result<Scene> compile(SceneDescription description, const SceneSettings& settings = {});

  const ContactWorld& world() const { return world_; }
  const SceneStatistics& statistics() const { return statistics_; }
  const std::vector<SceneObject>& objects() const { return objects_; }  // as the world's bodies
  const std::vector<TreeNode>& tree() const { return tree_; }
  const SurfaceMesh& mesh(std::size_t i) const { return meshes_[i]; }

  // What the file declares about how its surfaces feel, as io describes it.
  const std::vector<MaterialDescription>& materials() const { return materials_; }
  const std::vector<PhysicsMaterialDescription>& physics_materials() const {
    return physics_materials_;
  }
  const std::vector<HapticMaterialDescription>& haptic_materials() const {
    return haptic_materials_;
  }
  // What became of it; and the calls of world().effects by material.
  const SceneEffectsReport& effects() const { return effects_; }
  const std::vector<MaterialCalls>& material_calls() const { return material_calls_; }
  // The material of a face of an object's mesh, index into materials(). Of triangles that were
  // merged, the first one's. Logarithmic in the primitives of the mesh.
  std::optional<std::uint32_t> material(std::size_t object, std::size_t face) const;
  // Index into haptic_materials().
  std::optional<std::uint32_t> haptic_material(std::size_t object) const {
    return parts_[objects_[object].mesh].haptic_material();
  }

  // From the frame of an object's mesh to that of its body: the node's stretch and shear, and the
  // unit of the body.
  AffineMap map_body_mesh(std::size_t object) const;
  // The same in metres, with the node's scale and mirror: p_scene = T_scene_body of its deformation
  // of p_mesh.
  AffineMap deformation(std::size_t object) const;
  // All triangles in the scene frame, node by node: for slicing and pictures, not for haptics.
  void append_triangles_scene(std::vector<Vec3>& positions_m,
                              std::vector<Triangle>& triangles) const;

 private:
  // A surface that is no object.
  struct Medium {
    std::string name;
    IndexUse use;
    std::size_t material_set;  // of SceneEffects
    RigidTransform T_scene_body;
  };

  Scene() = default;
  // As compile(), but it may throw where there is no memory.
  static Result<Scene> compile(SceneDescription&& description, const SceneSettings& settings,
                               MemoryLedger& ledger);
  void take_declarations(SceneDescription& description);
  std::optional<Error> weld_meshes(std::vector<MeshDescription>& descriptions);
  std::optional<Error> take_places(const std::vector<NodeDescription>& nodes);
  std::vector<NodePlacement> touchable(std::vector<NodeDescription>& nodes);
  std::optional<Error> add_surfaces(const std::vector<NodeDescription>& nodes,
                                    const std::vector<NodePlacement>& placements,
                                    std::span<const Box> boxes, double proxy_radius_m,
                                    SceneEffects& effects);
  AffineMap map_body_mesh(const IndexUse& use) const;
  std::optional<Error> build_world(const Box& bounds_scene,
                                   const std::vector<NodeDescription>& nodes,
                                   double proxy_radius_m);
  std::optional<Error> take_surfaces(const Seams& seams);
  std::uint64_t corner_bytes(const Seams& seams) const;
  void build_meshes_and_indices();
  void add_bodies();
  void widen_sweeps(const Seams& seams);
  Result<Seams> seams_of(const std::vector<NodeDescription>& nodes) const;
  void report_seams(const Seams& seams);
  void add_corners(Seams& seams, const std::vector<NodeDescription>& nodes);
  std::optional<Error> take_attributes(const std::vector<ImageDescription>& images);
  std::optional<Error> compile_effects(SceneEffects& effects);
  template <typename Visit>
  void visit_shapes_and_stretches(const Visit& visit) const;
  EffectSurface effect_surface(std::string_view node, const IndexUse& use, std::size_t material_set,
                               const RigidTransform& T_scene_body) const;

  MemoryLedger* ledger_ = nullptr;     // while it is compiled
  std::vector<WeldedSurface> welded_;  // by mesh, while it is compiled
  std::vector<SurfaceMesh> meshes_;
  std::vector<MeshParts> parts_;  // by mesh
  std::vector<IndexShape> shapes_;
  std::vector<std::unique_ptr<SurfaceIndex>> indices_;  // by shape
  std::vector<SceneObject> objects_;
  std::vector<IndexUse> use_of_object_;
  std::vector<std::uint32_t> node_of_object_;        // of the description, while it is compiled
  std::vector<std::size_t> material_set_of_object_;  // while it is compiled
  std::vector<Medium> media_;                        // likewise
  std::vector<TreeNode> tree_;
  std::vector<MaterialDescription> materials_;
  std::vector<PhysicsMaterialDescription> physics_materials_;
  std::vector<HapticMaterialDescription> haptic_materials_;
  SceneEffectsReport effects_;
  std::vector<MaterialCalls> material_calls_;
  ContactWorld world_;
  SceneStatistics statistics_;
};

}  // namespace palpate
