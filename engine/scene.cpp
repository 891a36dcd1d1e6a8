#include "engine/scene.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "engine/node_placement.h"
#include "io/gltf_reader.h"

namespace palpate {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

Box bounding_box(const std::vector<Vec3>& positions, const Mat3& linear) {
  const double infinity = std::numeric_limits<double>::infinity();
  Box box{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  for (const Vec3& p : positions) {
    const Vec3 q = linear * p;
    box.low = box.low.cwiseMin(q);
    box.high = box.high.cwiseMax(q);
  }
  return box;
}

void add(CleaningReport& sum, const CleaningReport& report) {
  sum.triangles_in += report.triangles_in;
  sum.triangles += report.triangles;
  sum.dropped_degenerate += report.dropped_degenerate;
  sum.dropped_duplicate += report.dropped_duplicate;
  sum.welded_vertices += report.welded_vertices;
  sum.split_vertices += report.split_vertices;
  sum.boundary_edges += report.boundary_edges;
  sum.non_manifold_edges += report.non_manifold_edges;
}

// An earlier node of the same mesh and scale, whose index this one can share. Nodes that are turned
// have their scale from a decomposition, so it is the same only up to rounding; one that is not
// turned keeps its vertices to the bit.
const SceneObject* find_twin(const std::vector<SceneObject>& objects, std::size_t mesh,
                             const NodePlacement& placement) {
  constexpr double kSameScale = 64 * std::numeric_limits<double>::epsilon();
  const Mat3& scale = placement.deformation;
  const bool is_turned = placement.rotation.coeffs() != Quat::Identity().coeffs();
  const double tolerance = is_turned ? kSameScale * scale.norm() : 0.0;
  for (const SceneObject& object : objects) {
    if (object.mesh == mesh && (object.map_body_mesh.linear - scale).norm() <= tolerance) {
      return &object;
    }
  }
  return nullptr;
}

}  // namespace

Result<Scene> Scene::load(const std::string& path, const SceneSettings& settings) {
  Result<SceneDescription> description = read_gltf(path);
  if (!description) return description.error();
  return compile(std::move(*description), settings);
}

Result<Scene> Scene::compile(SceneDescription description, const SceneSettings& settings) {
  Scene scene;
  scene.statistics_.nodes = description.tree.size();
  scene.statistics_.meshes = description.meshes.size();
  scene.statistics_.parse_ms = description.parse_ms;
  scene.statistics_.warnings = std::move(description.warnings);

  const auto mesh_start = std::chrono::steady_clock::now();
  scene.meshes_.reserve(description.meshes.size());
  for (MeshDescription& mesh : description.meshes) {
    scene.meshes_.push_back(SurfaceMesh::build(mesh.positions, mesh.triangles));
    add(scene.statistics_.cleaning, scene.meshes_.back().report());
    scene.statistics_.memory_bytes += scene.meshes_.back().memory_bytes();
    mesh = {};  // what is compiled need not be kept twice
  }
  scene.statistics_.mesh_ms = milliseconds_since(mesh_start);

  for (const NodeDescription& node : description.nodes) scene.add_object(node);
  if (scene.objects_.empty()) {
    return Error{ErrorCode::kEmptyScene, description.path, "scene",
                 "no node has a triangle with area, expected at least one",
                 "palpate info lists what was dropped and why"};
  }
  const auto index_start = std::chrono::steady_clock::now();
  scene.build_indices(settings);
  scene.statistics_.index_ms = milliseconds_since(index_start);
  return scene;
}

void Scene::add_object(const NodeDescription& node) {
  const SurfaceMesh& mesh = meshes_[node.mesh];
  if (mesh.face_count() == 0) return;
  const auto placement = split_linear(node.linear_scene_mesh);
  if (!placement || !node.translation_m.allFinite()) {
    statistics_.warnings.push_back(node.name +
                                   ": left out, its transform is singular and leaves no surface");
    return;
  }
  SceneObject object;
  object.name = node.name;
  object.mesh = node.mesh;
  if (const SceneObject* twin = find_twin(objects_, node.mesh, *placement)) {
    object.map_body_mesh = twin->map_body_mesh;
  } else {
    // The body frame has its origin in the middle of the surface.
    const Box box = bounding_box(mesh.welded_positions(), placement->deformation);
    object.map_body_mesh = {placement->deformation, -0.5 * (box.low + box.high)};
  }
  const Vec3 middle = -object.map_body_mesh.translation_m;
  object.T_scene_body = {placement->rotation, node.translation_m + placement->rotation * middle};
  objects_.push_back(std::move(object));
  statistics_.instanced_triangles += mesh.face_count();
  ++statistics_.instances;
}

void Scene::build_indices(const SceneSettings& settings) {
  const double infinity = std::numeric_limits<double>::infinity();
  Box bounds{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  for (const SceneObject& object : objects_) {
    for (const Vec3& p : meshes_[object.mesh].welded_positions()) {
      const Vec3 p_scene = object.T_scene_body.point(object.map_body_mesh(p));
      bounds.low = bounds.low.cwiseMin(p_scene);
      bounds.high = bounds.high.cwiseMax(p_scene);
    }
  }
  statistics_.extent_m = bounds.high - bounds.low;
  world_.size_m = statistics_.extent_m.maxCoeff();
  // A single body is solved in its own frame: no transform, no rounding.
  world_.anchor_scene_m = objects_.size() == 1 ? objects_[0].T_scene_body.translation_m
                                               : Vec3(0.5 * (bounds.low + bounds.high));
  world_.bounds_solver = {world_.to_solver(bounds.low), world_.to_solver(bounds.high)};

  const double stand_off = SolverScale::of(world_.size_m, settings.proxy_radius_m).stand_off_m;
  const double sweep_radius =
      settings.proxy_radius_m > 0.0 ? settings.proxy_radius_m + 2 * stand_off : 0.0;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const SceneObject& object = objects_[i];
    const SurfaceIndex* shared = nullptr;  // with an earlier node of the same mesh and scale
    for (std::size_t j = 0; j < i && !shared; ++j) {
      if (objects_[j].mesh == object.mesh &&
          objects_[j].map_body_mesh.linear == object.map_body_mesh.linear) {
        shared = world_.bodies[j].index;
      }
    }
    if (!shared) {
      indices_.push_back(
          std::make_unique<SurfaceIndex>(meshes_[object.mesh], object.map_body_mesh, sweep_radius));
      shared = indices_.back().get();
      statistics_.memory_bytes += shared->memory_bytes();
    }
    const RigidTransform T_solver_body{object.T_scene_body.rotation,
                                       world_.to_solver(object.T_scene_body.translation_m)};
    const bool is_identity = T_solver_body.rotation.coeffs() == Quat::Identity().coeffs() &&
                             T_solver_body.translation_m.isZero(0.0);
    world_.bodies.push_back({shared, T_solver_body, is_identity});
  }
}

void Scene::append_triangles_scene(std::vector<Vec3>& positions_m,
                                   std::vector<Triangle>& triangles) const {
  for (const SceneObject& object : objects_) {
    const SurfaceMesh& mesh = meshes_[object.mesh];
    const auto first = static_cast<std::uint32_t>(positions_m.size());
    for (const Vec3& p : mesh.welded_positions()) {
      positions_m.push_back(object.T_scene_body.point(object.map_body_mesh(p)));
    }
    const bool mirrored = object.map_body_mesh.linear.determinant() < 0.0;
    for (const Triangle& t : mesh.faces()) {
      triangles.push_back({first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
    }
  }
}

}  // namespace palpate
