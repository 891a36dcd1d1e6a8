#pragma once

// A scene, compiled once from the description that io reads, and immutable afterwards.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/scene_effects.h"
#include "engine/scene/shared_indices.h"
#include "engine/scene/surface_attributes.h"
#include "geometry/base/box.h"
#include "geometry/base/memory_breakdown.h"
#include "geometry/base/result.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"
#include "haptics/proxy/contact_world.h"
#include "io/scene_description.h"

namespace palpate {

// Settings for loading and compiling a scene. The caller sets scale or fit_size_m, not both. The
// caller also checks these two values, because load() and compile() do not.
struct SceneSettings {
  double proxy_radius_m = 0.0;  // radius of the largest proxy that will touch the scene
  std::string node = {};        // compile only this node's subtree (find_node); empty: all nodes
  double scale = 1.0;           // scales the whole scene about its origin; > 0
  double fit_size_m = 0.0;      // if > 0, the scene is scaled to this largest extent
  std::vector<MaterialOverride> overrides = {};  // replace values of the file; used by load() only
  // An animation and a time, "NAME@SECONDS" or "#number@SECONDS" (GltfPose::choose). Empty: the
  // rest pose of the file. Used by load() only.
  std::string pose = {};
  // Whether boundaries are joined that meet within the rounding of the file (join_bound.h): in each
  // mesh, and between nodes at rest. False for recordings of before, which were made without.
  bool joins_within_rounding = true;
  // If > 0, boundaries of a mesh, and surfaces of different nodes, that are at most this far apart
  // are joined, too. Metres in the
  // scene frame, after scaling; less than the extent of the scene.
  double close_gaps_m = 0.0;
  // Whether SceneStatistics::nearest_gap_m is measured, which takes time if boundaries are long.
  bool measures_gaps = false;
  // Limit on the memory used for loading; 0: half of the free memory (memory_budget.h).
  std::uint64_t max_memory_bytes = 0;
  // The number or the name of one of the scenes that the file lists (GltfSceneChoice). Empty: the
  // default scene. This and the next member are used by load() only.
  std::string listed_scene = {};
  bool feels_hidden = false;  // loads nodes that KHR_node_visibility hides like visible ones
};

// What was joined at the boundaries of all meshes (boundary_joins.h).
struct JoinStatistics {
  std::size_t joined_edges = 0;     // pairs of boundary edges
  std::size_t joined_vertices = 0;  // replaced by other vertices
  std::size_t divided_edges = 0;    // at vertices that lie on them
  std::size_t ambiguous_edges = 0;  // stay open because they meet several others
};

// The numbers that `palpate info` prints. Triangles are counted once per mesh, except for
// instanced_triangles.
struct SceneStatistics {
  std::size_t nodes = 0;
  std::size_t meshes = 0;
  std::size_t instances = 0;
  CleaningReport cleaning;        // summed over meshes
  JoinStatistics rounding_joins;  // within the rounding of the file
  JoinStatistics gap_joins;       // SceneSettings::close_gaps_m
  // The smallest close_gaps_m that joins two boundary edges that are still open. No value if it was
  // not measured, or if no two edges are closer than a tenth of the scene's extent.
  std::optional<double> nearest_gap_m;
  std::size_t instanced_triangles = 0;  // summed over nodes
  std::size_t indices = 0;              // number of indices built (shared_indices.h)
  std::size_t seam_vertices = 0;        // vertices joined with vertices of other nodes (seams.h)
  std::size_t seam_places = 0;          // distinct positions of these vertices
  std::size_t seam_nodes = 0;           // nodes that have such vertices
  std::size_t changed_nodes = 0;   // nodes whose surface was made to meet others (conforming.h)
  std::size_t divided_edges = 0;   // edges of these nodes that were divided
  std::size_t apart_vertices = 0;  // near a vertex or an edge of another node, and not joined
  double least_apart_m = 0.0;      // the least and the largest distance of these vertices
  double most_apart_m = 0.0;
  double scale = 1.0;  // the applied scale
  Vec3 extent_m = Vec3::Zero();
  Box bounds_scene = {Vec3::Zero(), Vec3::Zero()};  // bounding box in the scene frame, metres
  std::vector<AnimationDescription> animations;     // all animations of the file
  std::optional<PoseDescription> pose;              // the chosen pose; no value: the rest pose
  double parse_ms = 0.0;
  double mesh_ms = 0.0;
  double index_ms = 0.0;
  MemoryBreakdown memory;               // one entry per purpose, in bytes
  std::vector<std::string> files_read;  // beside the file itself: buffers and images
  ListedScenes scenes;
  HiddenNodes hidden_nodes;
  std::vector<std::string> unapplied_extras;  // one line each (SceneDescription)
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

// A node of the scene that can be touched. A node whose material is not solid is not a SceneObject:
// it bounds a region with a medium. NodeMotions does not move such a region.
struct SceneObject {
  std::string name;
  std::uint32_t mesh;           // index for Scene::mesh()
  std::uint32_t tree_node;      // index into Scene::tree()
  RigidTransform T_scene_body;  // pose of its body; does not contain the body's unit (ContactBody)
  std::optional<std::uint32_t> physics_material = {};  // index into Scene::physics_materials()
};

// Surfaces with their indices and poses, and the effects of their materials. The scene frame is the
// frame of the file (glTF world coordinates, metres), scaled by SceneSettings. Immutable: any
// number of haptic loops and threads may read a scene.
class Scene {
 public:
  // Reads and compiles a glTF file. Returns the errors of read_gltf() and compile(); returns
  // kOutOfMemory, with the name and the memory need of the step, if the system is out of memory.
  static Result<Scene> load(const std::string& path, const SceneSettings& settings = {});

  // Compiles a description. Nodes with a singular transform have no surface to touch; they are
  // left out with a warning. Returns an error if no node is left, if SceneSettings::node does not
  // exist, or if a declaration of a material, a region or the scene is wrong or contradictory
  // (scene_effects.h).
  //
  // Every step computes its memory need before it allocates. The error is kLimitExceeded if the
  // need exceeds what is left of the memory limit. It is kOutOfMemory if an allocation fails.
  static Result<Scene> compile(SceneDescription description, const SceneSettings& settings = {});

  const ContactWorld& world() const { return world_; }
  const SceneStatistics& statistics() const { return statistics_; }
  const std::vector<SceneObject>& objects() const { return objects_; }  // in the order of bodies
  const std::vector<TreeNode>& tree() const { return tree_; }
  const SurfaceMesh& mesh(std::size_t i) const { return meshes_[i]; }

  // The material declarations of the file, as io describes them.
  const std::vector<MaterialDescription>& materials() const { return materials_; }
  const std::vector<PhysicsMaterialDescription>& physics_materials() const {
    return physics_materials_;
  }
  const std::vector<HapticMaterialDescription>& haptic_materials() const {
    return haptic_materials_;
  }
  // The contours of the nodes in tree(), in the order of tree(), as the file states them
  // (extras.palpate_contour). In the scene frame, scaled with the scene. A contour with a problem
  // has no points; the scene has a warning about the problem.
  const std::vector<ContourDescription>& contours() const { return contours_; }
  // Reports how the declarations were applied.
  const SceneEffectsReport& effects() const { return effects_; }
  // The effect calls in the tables of world().effects, grouped by material.
  const std::vector<MaterialCalls>& material_calls() const { return material_calls_; }
  // The material of a face of an object's mesh: an index into materials(). If equal triangles were
  // merged into one face, the face has the material of the first of them. The time is logarithmic
  // in the number of primitives of the mesh.
  std::optional<std::uint32_t> material(std::size_t object, std::size_t face) const;
  // The names of TickRecord::body and TickRecord::material. Empty for kNothingTouched,
  // kTouchUnknown and any other number that this scene does not have. Valid as long as the scene.
  std::string_view body_name(std::int32_t body) const;
  std::string_view material_name(std::int32_t material) const;
  // The haptic material of an object: an index into haptic_materials().
  std::optional<std::uint32_t> haptic_material(std::size_t object) const {
    return parts_[objects_[object].mesh].haptic_material();
  }

  // Maps the frame of an object's mesh to its body frame, in units of the body. Contains the
  // node's stretch and shear.
  AffineMap map_body_mesh(std::size_t object) const;
  // The map from the frame of an object's mesh to its body frame in metres. It includes the node's
  // scale and mirror: p_scene = T_scene_body.point(deformation(object)(p_mesh)).
  AffineMap deformation(std::size_t object) const;
  // Appends all triangles, node by node, in the scene frame. For slicing and pictures, not for
  // haptics.
  void append_triangles_scene(std::vector<Vec3>& positions_m,
                              std::vector<Triangle>& triangles) const;

 private:
  friend class SceneCompiler;

  Scene() = default;
  AffineMap map_body_mesh(const IndexUse& use) const;

  std::vector<SurfaceMesh> meshes_;
  std::vector<MeshParts> parts_;  // one per mesh
  std::vector<IndexShape> shapes_;
  std::vector<std::unique_ptr<SurfaceIndex>> indices_;  // one per shape
  std::vector<SceneObject> objects_;
  std::vector<IndexUse> use_of_object_;
  std::vector<TreeNode> tree_;
  std::vector<MaterialDescription> materials_;
  std::vector<PhysicsMaterialDescription> physics_materials_;
  std::vector<HapticMaterialDescription> haptic_materials_;
  std::vector<ContourDescription> contours_;
  SceneEffectsReport effects_;
  std::vector<MaterialCalls> material_calls_;
  ContactWorld world_;
  SceneStatistics statistics_;
};

}  // namespace palpate
