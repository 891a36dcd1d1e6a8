#pragma once

// A scene compiled once from what io read, and immutable afterwards.

#include <memory>
#include <string>
#include <vector>

#include "geometry/result.h"
#include "geometry/surface_index.h"
#include "geometry/surface_mesh.h"
#include "haptics/contact_world.h"
#include "io/scene_description.h"

namespace palpate {

struct SceneSettings {
  double proxy_radius_m = 0.0;  // the largest proxy that will touch the scene
};

// What `palpate info` tells. Triangles are counted per mesh, except instanced_triangles.
struct SceneStatistics {
  std::size_t nodes = 0;
  std::size_t meshes = 0;
  std::size_t instances = 0;
  CleaningReport cleaning;              // summed over meshes
  std::size_t instanced_triangles = 0;  // summed over nodes
  Vec3 extent_m = Vec3::Zero();
  double parse_ms = 0.0;
  double mesh_ms = 0.0;
  double index_ms = 0.0;
  std::size_t memory_bytes = 0;
  std::vector<std::string> warnings;
};

// One node of the scene that can be touched.
struct SceneObject {
  std::string name;
  std::size_t mesh;             // index for Scene::mesh()
  AffineMap map_body_mesh;      // mesh frame to body frame: the node's scale, mirror and shear
  RigidTransform T_scene_body;  // what is left of the node's transform
};

// Surfaces, their indices and their places. The scene frame is that of the file: glTF world
// coordinates in metres. Immutable; any number of haptic loops and threads may read it.
class Scene {
 public:
  // Reads and compiles a glTF file.
  static Result<Scene> load(const std::string& path, const SceneSettings& settings = {});

  // Compiles a description. Nodes with a singular transform have no surface to touch; they are
  // left out with a warning. An error if nothing is left.
  static Result<Scene> compile(SceneDescription description, const SceneSettings& settings = {});

  const ContactWorld& world() const { return world_; }
  const SceneStatistics& statistics() const { return statistics_; }
  const std::vector<SceneObject>& objects() const { return objects_; }
  const SurfaceMesh& mesh(std::size_t i) const { return meshes_[i]; }

  // All triangles in the scene frame, node by node: for slicing and pictures, not for haptics.
  void append_triangles_scene(std::vector<Vec3>& positions_m,
                              std::vector<Triangle>& triangles) const;

 private:
  Scene() = default;
  void add_object(const NodeDescription& node);
  void build_indices(const SceneSettings& settings);

  std::vector<SurfaceMesh> meshes_;
  std::vector<std::unique_ptr<SurfaceIndex>> indices_;
  std::vector<SceneObject> objects_;
  ContactWorld world_;
  SceneStatistics statistics_;
};

}  // namespace palpate
