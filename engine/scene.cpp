#include "engine/scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <span>
#include <sstream>

#include "engine/node_placement.h"
#include "engine/node_tree.h"
#include "geometry/parallel.h"
#include "io/gltf_reader.h"

namespace palpate {
namespace {

Error with_path(Error error, const std::string& path) {
  error.path = path;
  return error;
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

// Squares of areas must neither overflow nor vanish, of triangles a million times smaller as well.
constexpr double kLargestExtent_m = 1e60;
constexpr double kSmallestExtent_m = 1e-60;

// Vertices looked at for the extent of a scene, of all nodes together: a second or less.
constexpr std::size_t kMostExactVertices = std::size_t{1} << 27;

// So many bodies are asked one by one; more are found by a tree.
constexpr std::size_t kFewBodies = 8;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
Box empty_box() {
  return {Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity)};
}

Box bounding_box(std::span<const Vec3> positions, const Mat3& linear) {
  Box box = empty_box();
  for (const Vec3& p : positions) {
    const Vec3 q = linear * p;
    box = box.united({q, q});
  }
  return box;
}

// Around p_scene = linear * p + translation_m of all p of a box.
Box placed_box(const Box& box, const NodeDescription& node) {
  const Vec3 centre =
      node.linear_scene_mesh * (0.5 * box.low + 0.5 * box.high) + node.translation_m;
  const Vec3 reach = node.linear_scene_mesh.cwiseAbs() * (0.5 * box.high - 0.5 * box.low);
  return {centre - reach, centre + reach};
}

std::vector<Box> bounding_boxes(const std::vector<WeldedSurface>& meshes) {
  std::vector<Box> boxes;
  boxes.reserve(meshes.size());
  for (const WeldedSurface& mesh : meshes) {
    boxes.push_back(bounding_box(mesh.positions(), Mat3::Identity()));
  }
  return boxes;
}

// Around all vertices in their places. A node whose box lies inside what has been found already is
// not looked at any closer: of ten thousand instances only the outermost are. What is left when
// kMostExactVertices have been looked at counts with its boxes.
Box bounds_in_scene(const std::vector<WeldedSurface>& meshes, const std::vector<Box>& boxes,
                    const std::vector<NodeDescription>& nodes) {
  Box bounds = empty_box();
  std::size_t left = kMostExactVertices;
  for (const NodeDescription& node : nodes) {
    const WeldedSurface& mesh = meshes[node.mesh];
    if (mesh.face_count() == 0) continue;
    const Box placed = placed_box(boxes[node.mesh], node);
    if (bounds.contains(placed.low) && bounds.contains(placed.high)) continue;
    if (mesh.positions().size() > left) {
      bounds = bounds.united(placed);
      continue;
    }
    left -= mesh.positions().size();
    for (const Vec3& p : mesh.positions()) {
      const Vec3 q = node.linear_scene_mesh * p + node.translation_m;
      bounds = bounds.united({q, q});
    }
  }
  return bounds;
}

// A mesh can be larger than the scene: its node takes it back to the others by a translation as
// large, and leaves rounding errors of it.
std::optional<Error> refuse_beyond_limits(const std::vector<Box>& boxes,
                                          const std::vector<NodeDescription>& nodes) {
  for (const NodeDescription& node : nodes) {
    const Box& box = boxes[node.mesh];
    const Vec3 farthest = box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs());
    const Vec3 reach_m = node.linear_scene_mesh.cwiseAbs() * farthest;
    if ((reach_m.array() <= kLargestExtent_m).all()) continue;  // false for NaN
    std::ostringstream problem;
    const double scale = lengthening(node.linear_scene_mesh);
    if (scale != 1.0) problem << "at its scale of " << scale << " ";
    problem << "its mesh reaches farther than " << kLargestExtent_m << " m";
    return Error{ErrorCode::kLimitExceeded, "", "node \"" + node.name + "\"", problem.str(),
                 "choose another scale"};
  }
  return std::nullopt;
}

void scale_by(double scale, SceneDescription& description, std::vector<NodePlacement>& placements) {
  for (NodeDescription& node : description.nodes) {
    node.linear_scene_mesh *= scale;
    node.translation_m *= scale;
    node.product.columns *= scale;
    node.product.translation_m *= scale;
  }
  for (NodePlacement& placement : placements) placement.deformation *= scale;
  for (TreeNode& node : description.tree) node.origin_m *= scale;
  for (RegionDescription& region : description.regions) {
    region.linear_scene_node *= scale;
    region.translation_m *= scale;
  }
}

// A tree of those that carry meshes, where the description has none.
void complete_tree(SceneDescription& description) {
  if (!description.tree.empty()) return;
  for (NodeDescription& node : description.nodes) {
    node.tree_node = static_cast<std::uint32_t>(description.tree.size());
    description.tree.push_back({node.name, node.tree_node, {}, true, node.translation_m});
  }
}

// Only the meshes that nodes still refer to.
void drop_unused_meshes(SceneDescription& description) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> new_index(description.meshes.size(), kUnused);
  std::vector<MeshDescription> used;
  for (NodeDescription& node : description.nodes) {
    std::uint32_t& index = new_index[node.mesh];
    if (index == kUnused) {
      index = static_cast<std::uint32_t>(used.size());
      used.push_back(std::move(description.meshes[node.mesh]));
    }
    node.mesh = index;
  }
  description.meshes = std::move(used);
}

// Calls work(i) for all meshes, or indices of them, on several cores if there is enough to do.
template <typename Work>
void run_meshes(std::size_t count, std::size_t triangles, const Work& work) {
  constexpr std::size_t kWorthAThread = 10000;  // triangles: a millisecond of work
  const std::size_t least = 1 + count * kWorthAThread / std::max<std::size_t>(triangles, 1);
  run_ranges(count, least, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) work(i);
  });
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

}  // namespace

Result<Scene> Scene::load(const std::string& path, const SceneSettings& settings) {
  Result<SceneDescription> description = read_gltf(path, {settings.overrides, settings.pose});
  if (!description) return description.error();
  return compile(std::move(*description), settings);
}

// Finds the shape of an earlier node of the same mesh and scale, which a node can share. Nodes that
// are turned have their scale from a decomposition, so it is the same only up to rounding; one that
// is not turned keeps its vertices to the bit.
class Scene::ShapeFinder {
 public:
  explicit ShapeFinder(const std::vector<Shape>& shapes, std::size_t mesh_count)
      : shapes_(shapes), by_size_(mesh_count) {}

  std::optional<std::size_t> find(std::size_t mesh, const NodePlacement& placement) const {
    const Mat3& scale = placement.deformation;
    const double norm = scale.norm();
    const bool is_turned = placement.rotation.coeffs() != Quat::Identity().coeffs();
    const double tolerance = kSameScale * norm;
    const auto& shapes = by_size_[mesh];
    std::size_t left = kMaxCompared;
    for (auto it = shapes.lower_bound(norm - tolerance);
         it != shapes.end() && it->first <= norm + tolerance && left > 0; ++it, --left) {
      const Mat3 difference = shapes_[it->second].map_body_mesh.linear - scale;
      if (difference.norm() <= (is_turned ? tolerance : 0.0)) return it->second;
    }
    return std::nullopt;
  }
  void add(std::size_t shape) {
    const Shape& s = shapes_[shape];
    by_size_[s.mesh].emplace(s.map_body_mesh.linear.norm(), shape);
  }

 private:
  static constexpr double kSameScale = 64 * std::numeric_limits<double>::epsilon();
  // A hostile file can have any number of scales of one norm. To share is to save memory, no more.
  static constexpr std::size_t kMaxCompared = 256;

  const std::vector<Shape>& shapes_;
  std::vector<std::multimap<double, std::size_t>> by_size_;  // per mesh, by the norm of the scale
};

Result<Scene> Scene::compile(SceneDescription description, const SceneSettings& settings) {
  Scene scene;
  complete_tree(description);
  if (!settings.node.empty()) {
    const auto node = find_node(description.tree, settings.node);
    if (!node) return with_path(node.error(), description.path);
    keep_subtree(description, *node);
  }
  drop_unused_meshes(description);
  SceneStatistics& statistics = scene.statistics_;
  statistics.nodes = description.tree.size();
  statistics.meshes = description.meshes.size();
  statistics.parse_ms = description.parse_ms;
  statistics.animations = std::move(description.animations);
  statistics.pose = description.pose;
  statistics.notes = std::move(description.notes);
  statistics.warnings = std::move(description.warnings);
  scene.materials_ = std::move(description.materials);
  scene.physics_materials_ = std::move(description.physics_materials);
  scene.haptic_materials_ = std::move(description.haptic_materials);
  scene.weld_meshes(description.meshes);

  const std::size_t reader_warnings = statistics.warnings.size();
  std::vector<NodePlacement> placements = scene.touchable(description.nodes);
  if (description.nodes.empty()) {
    const bool left_out = statistics.warnings.size() > reader_warnings;
    return Error{ErrorCode::kEmptyScene, description.path, "scene",
                 "no node has a triangle with area, expected at least one",
                 left_out ? statistics.warnings[reader_warnings] : std::string()};
  }
  const std::vector<Box> boxes = bounding_boxes(scene.welded_);
  Box bounds = bounds_in_scene(scene.welded_, boxes, description.nodes);
  statistics.scale = settings.fit_size_m > 0.0
                         ? settings.fit_size_m / (bounds.high - bounds.low).maxCoeff()
                         : settings.scale;
  if (statistics.scale != 1.0) {
    scale_by(statistics.scale, description, placements);
    bounds = bounds_in_scene(scene.welded_, boxes, description.nodes);
  }
  statistics.bounds_scene = bounds;
  statistics.extent_m = bounds.high - bounds.low;
  if (auto error = refuse_beyond_limits(boxes, description.nodes)) {
    return with_path(*error, description.path);
  }
  const double extent_m = statistics.extent_m.maxCoeff();
  if (!statistics.extent_m.allFinite() || extent_m > kLargestExtent_m ||
      extent_m < kSmallestExtent_m) {
    return Error{ErrorCode::kLimitExceeded, description.path, "scene",
                 "its largest extent is not between 1e-60 and 1e60 m", "choose another scale"};
  }
  scene.tree_ = std::move(description.tree);
  SceneEffects effects(
      {scene.materials_, scene.physics_materials_, scene.haptic_materials_, description.images,
       &description.scene_parameters, description.regions, statistics.scale},
      scene.parts_);
  if (auto error = scene.add_surfaces(description.nodes, placements, effects)) {
    return with_path(*error, description.path);
  }
  const auto index_start = std::chrono::steady_clock::now();
  if (auto error = scene.build_world(bounds, description.nodes, settings.proxy_radius_m)) {
    return with_path(*error, description.path);
  }
  if (auto error = scene.compile_effects(effects)) return with_path(*error, description.path);
  statistics.index_ms = milliseconds_since(index_start);
  return scene;
}

void Scene::weld_meshes(std::vector<MeshDescription>& descriptions) {
  const auto start = std::chrono::steady_clock::now();
  std::size_t triangles = 0;
  for (const MeshDescription& mesh : descriptions) triangles += mesh.triangles.size();
  welded_.resize(descriptions.size());
  run_meshes(descriptions.size(), triangles, [&](std::size_t i) {
    MeshDescription& mesh = descriptions[i];
    const bool has_uv = !mesh.texture_uv.empty() || !mesh.friction_uv.empty();
    welded_[i] = WeldedSurface(std::move(mesh.positions),
                               has_uv ? mesh.triangles : std::move(mesh.triangles));
  });
  for (std::size_t i = 0; i < descriptions.size(); ++i) {
    parts_.emplace_back(welded_[i], std::move(descriptions[i]));
    descriptions[i] = {};  // what is compiled need not be kept twice
  }
  statistics_.mesh_ms = milliseconds_since(start);
}

// Leaves the nodes that have a surface to touch, and returns how each is placed.
std::vector<NodePlacement> Scene::touchable(std::vector<NodeDescription>& nodes) {
  std::vector<NodePlacement> placements;
  std::erase_if(nodes, [&](const NodeDescription& node) {
    if (welded_[node.mesh].face_count() == 0) return true;
    const auto placement = split_linear(node.linear_scene_mesh);
    if (!placement || !node.translation_m.allFinite()) {
      statistics_.warnings.push_back(
          node.name +
          ": left out, its transform stretches it by so much more in one "
          "direction than in another that no surface is left");
      return true;
    }
    placements.push_back(*placement);
    return false;
  });
  return placements;
}

std::optional<Error> Scene::add_surfaces(const std::vector<NodeDescription>& nodes,
                                         const std::vector<NodePlacement>& placements,
                                         SceneEffects& effects) {
  ShapeFinder finder(shapes_, welded_.size());
  objects_.reserve(nodes.size());
  shape_of_object_.reserve(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const NodeDescription& node = nodes[i];
    const NodePlacement& placement = placements[i];
    const auto outfit = effects.outfit(node.name, node.mesh, node.physics_material);
    if (!outfit) return outfit.error();
    const std::size_t shape = add_shape(node, placement, finder);
    const AffineMap& map = shapes_[shape].map_body_mesh;
    const Vec3 middle = -map.translation_m;
    const RigidTransform T_scene_body{placement.rotation,
                                      node.translation_m + placement.rotation * middle};
    statistics_.instanced_triangles += welded_[node.mesh].face_count();
    if (!effects.is_solid(*outfit)) {
      media_.push_back({node.name, shape, *outfit, T_scene_body});
      continue;
    }
    objects_.push_back(
        {node.name, node.mesh, node.tree_node, map, T_scene_body, node.physics_material});
    shape_of_object_.push_back(shape);
    outfit_of_object_.push_back(*outfit);
    node_of_object_.push_back(static_cast<std::uint32_t>(i));
  }
  statistics_.instances = objects_.size() + media_.size();
  statistics_.indices = shapes_.size();
  return std::nullopt;
}

// That of an earlier node, or a new one.
std::size_t Scene::add_shape(const NodeDescription& node, const NodePlacement& placement,
                             ShapeFinder& finder) {
  if (const auto shape = finder.find(node.mesh, placement)) return *shape;
  // The body frame has its origin in the middle of the surface.
  const Box box = bounding_box(welded_[node.mesh].positions(), placement.deformation);
  shapes_.push_back({node.mesh, {placement.deformation, -0.5 * (box.low + box.high)}, nullptr});
  finder.add(shapes_.size() - 1);
  return shapes_.size() - 1;
}

std::optional<Error> Scene::build_world(const Box& bounds_scene,
                                        const std::vector<NodeDescription>& nodes,
                                        double proxy_radius_m) {
  world_.size_m = statistics_.extent_m.maxCoeff();
  // A single body is solved in its own frame: no transform, no rounding.
  world_.anchor_scene_m = objects_.size() == 1 ? objects_[0].T_scene_body.translation_m
                                               : Vec3(0.5 * (bounds_scene.low + bounds_scene.high));
  world_.bounds_solver = {world_.to_solver(bounds_scene.low), world_.to_solver(bounds_scene.high)};
  const double stand_off = SolverScale::of(world_.size_m, proxy_radius_m).stand_off_m;
  const double sweep_radius_m = proxy_radius_m > 0.0 ? proxy_radius_m + 2 * stand_off : 0.0;
  Seams seams = seams_of(nodes);
  report_seams(seams);
  if (auto error = check_index_size()) return error;
  build_meshes_and_indices(sweep_radius_m, seams);
  world_.bodies.reserve(objects_.size());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const RigidTransform& T_scene_body = objects_[i].T_scene_body;
    world_.bodies.push_back({shapes_[shape_of_object_[i]].index.get(), {}, true});
    world_.bodies.back().place(
        {T_scene_body.rotation, world_.to_solver(T_scene_body.translation_m)});
  }
  if (!seams.bodies.empty()) add_corners(seams, nodes);
  node_of_object_ = {};
  // Short names are inside the objects and nodes. Embree's tree is counted as for clusters.
  constexpr std::size_t kTreeBytesPerBody = 200;
  statistics_.memory.places =
      objects_.capacity() * sizeof(SceneObject) + tree_.capacity() * sizeof(TreeNode) +
      shape_of_object_.capacity() * sizeof(std::size_t) +
      world_.bodies.capacity() * sizeof(ContactBody) + shapes_.capacity() * sizeof(Shape) +
      (world_.seams ? world_.seams->memory_bytes() : 0);
  if (world_.bodies.size() <= kFewBodies) return std::nullopt;
  statistics_.memory.places += world_.bodies.size() * kTreeBytesPerBody;
  std::vector<Box> boxes;
  boxes.reserve(world_.bodies.size());
  for (const ContactBody& body : world_.bodies) boxes.push_back(body.box_solver());
  world_.tree = std::make_shared<BoxTree>(boxes, sweep_radius_m);
  return std::nullopt;
}

Seams Scene::seams_of(const std::vector<NodeDescription>& nodes) const {
  std::vector<SeamSurface> surfaces;
  surfaces.reserve(objects_.size());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    surfaces.push_back({&nodes[node_of_object_[i]], objects_[i].map_body_mesh.linear,
                        objects_[i].T_scene_body.rotation});
  }
  return find_seams(welded_, surfaces, world_.anchor_scene_m, world_.size_m);
}

void Scene::report_seams(const Seams& seams) {
  statistics_.seam_vertices = seams.vertices;
  statistics_.seam_places = seams.places;
  statistics_.seam_nodes = seams.bodies.size();
  if (!seams.bodies.empty()) {
    statistics_.notes.push_back(
        "seams: " + std::to_string(seams.vertices) + " vertices of " +
        std::to_string(seams.bodies.size()) + " nodes meet in " + std::to_string(seams.places) +
        " places and are joined, so that no point passes there; open stay nodes that have moved, "
        "a vertex on the edge of another node, and gaps that are in the file");
  }
  if (seams.too_far.empty()) return;
  const std::size_t others = seams.too_far.size() - 1;
  statistics_.warnings.push_back(
      objects_[seams.too_far.front()].name +
      (others > 0 ? " and " + std::to_string(others) + " more nodes" : "") +
      ": too far from the origin of the scene, or of the mesh, to tell which vertices meet those "
      "of other nodes; a point may pass between nodes there. Move the scene to its origin");
}

// Of the bodies that meet others, for a point. Their indices exist.
void Scene::add_corners(Seams& seams, const std::vector<NodeDescription>& nodes) {
  constexpr std::size_t kNone = ~std::size_t{0};
  std::vector<std::size_t> slots_of_shape(shapes_.size(), kNone);
  const auto made = std::make_shared<SeamedBodies>();
  for (const SeamBody& body : seams.bodies) {
    const std::size_t id = shape_of_object_[body.surface];
    if (slots_of_shape[id] != kNone) continue;
    slots_of_shape[id] = made->slots.size();
    const Shape& shape = shapes_[id];
    made->slots.push_back(vertices_of_slots(*shape.index, meshes_[shape.mesh],
                                            shape.map_body_mesh.linear.determinant() < 0.0));
  }
  made->bodies.reserve(seams.bodies.size());
  for (SeamBody& body : seams.bodies) {
    const std::size_t shape = shape_of_object_[body.surface];
    const NodeDescription& node = nodes[node_of_object_[body.surface]];
    body.joined.shrink_to_fit();
    made->bodies.push_back(std::make_unique<SolverCorners>(
        meshes_[shapes_[shape].mesh].welded_positions(), made->slots[slots_of_shape[shape]],
        node.linear_scene_mesh, world_.to_solver(node.translation_m), std::move(body.joined)));
    world_.bodies[body.surface].corners = made->bodies.back().get();
  }
  world_.seams = made;
}

std::optional<Error> Scene::check_index_size() const {
  std::uint64_t triangles = 0;
  for (const Shape& shape : shapes_) triangles += welded_[shape.mesh].face_count();
  if (triangles <= kMaxIndexBytes / SurfaceIndex::kBytesPerTriangle) return std::nullopt;
  return Error{ErrorCode::kLimitExceeded, "", "scene",
               "its nodes show meshes at " + std::to_string(shapes_.size()) +
                   " different scales, which needs indices for " + std::to_string(triangles) +
                   " triangles; expected at most " +
                   std::to_string(kMaxIndexBytes / SurfaceIndex::kBytesPerTriangle),
               "load a part of it with --node"};
}

// Adjacency and indices at the same time: both need the welded surfaces alone.
void Scene::build_meshes_and_indices(double sweep_radius_m, const Seams& seams) {
  std::vector<bool> has_seams(shapes_.size(), false);
  for (const SeamBody& body : seams.bodies) has_seams[shape_of_object_[body.surface]] = true;
  const double seam_sweep_m =
      std::max(sweep_radius_m, SolverScale::of(world_.size_m, 0.0).stand_off_m);
  std::size_t triangles = 0;
  for (const WeldedSurface& mesh : welded_) triangles += mesh.face_count();
  meshes_.resize(welded_.size());
  run_both(
      [&] {
        run_meshes(shapes_.size(), triangles, [&](std::size_t i) {
          const WeldedSurface& mesh = welded_[shapes_[i].mesh];
          shapes_[i].index = std::make_unique<SurfaceIndex>(
              MappedFaces{mesh.positions(), mesh.faces(), shapes_[i].map_body_mesh},
              has_seams[i] ? seam_sweep_m : sweep_radius_m);
        });
      },
      [&] {
        run_meshes(welded_.size(), triangles,
                   [&](std::size_t i) { meshes_[i] = SurfaceMesh(welded_[i]); });
      });
  std::vector<WeldedSurface>().swap(welded_);
  for (const SurfaceMesh& mesh : meshes_) {
    add(statistics_.cleaning, mesh.report());
    statistics_.memory += mesh.memory();
  }
  for (const Shape& shape : shapes_) statistics_.memory += shape.index->memory();
}

EffectSurface Scene::effect_surface(const std::string& node, std::size_t shape, std::size_t outfit,
                                    const RigidTransform& T_scene_body) const {
  const Shape& s = shapes_[shape];
  return {node,
          outfit,
          shape,
          {&meshes_[s.mesh], &parts_[s.mesh], s.map_body_mesh, s.index.get()},
          {T_scene_body.rotation, world_.to_solver(T_scene_body.translation_m)}};
}

std::optional<Error> Scene::compile_effects(SceneEffects& effects) {
  std::vector<EffectSurface> bodies;
  bodies.reserve(objects_.size());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    bodies.push_back(effect_surface(objects_[i].name, shape_of_object_[i], outfit_of_object_[i],
                                    objects_[i].T_scene_body));
  }
  std::vector<EffectSurface> media;
  for (const Medium& m : media_) {
    media.push_back(effect_surface(m.name, m.shape, m.outfit, m.T_scene_body));
  }
  auto result = effects.compile(bodies, media, world_.anchor_scene_m);
  if (!result) return result.error();
  world_.effects = std::move(result->program);
  effects_ = std::move(result->report);
  material_calls_ = std::move(result->calls);
  statistics_.memory.effects = result->memory_bytes;
  for (MeshParts& parts : parts_) parts.drop_uv();
  outfit_of_object_ = {};
  media_ = {};
  return std::nullopt;
}

std::optional<std::uint32_t> Scene::material(std::size_t object, std::size_t face) const {
  const MeshParts& parts = parts_[objects_[object].mesh];
  return parts.materials()[parts.part_of_face(face)];
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
