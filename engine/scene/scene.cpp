#include "engine/scene/scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <sstream>

#include "engine/scene/memory_budget.h"
#include "engine/scene/node_placement.h"
#include "engine/scene/node_tree.h"
#include "geometry/base/parallel.h"
#include "io/gltf/reader.h"

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

// That indices are built for. Of a proxy.
double sweep_radius_m(double size_m, double proxy_radius_m) {
  const double stand_off_m = SolverScale::of(size_m, proxy_radius_m).stand_off_m;
  return proxy_radius_m > 0.0 ? proxy_radius_m + 2 * stand_off_m : 0.0;
}

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

bool has_uv(const MeshDescription& mesh) {
  return !mesh.texture_uv.empty() || !mesh.friction_uv.empty();
}

std::string mesh_named(const MeshDescription& mesh) {
  return "mesh \"" + mesh.name + "\"";
}

std::string node_named(const std::string& name) {
  return "node \"" + name + "\"";
}

// What height maps of all images take, one of each.
MemoryNeed of_maps(const std::vector<ImageDescription>& images) {
  constexpr std::uint64_t kMakingPerTexel = 28;  // see kMostMapTexels
  MemoryNeed need;
  for (const ImageDescription& image : images) {
    const std::uint64_t texels = std::uint64_t{image.width} * image.height;
    const std::uint64_t kept = texels * 16 / 3;
    need = need + MemoryNeed{kept, kept + kMakingPerTexel * texels};
  }
  return need;
}

bool calls_for_shading(const std::vector<MaterialDescription>& materials) {
  const auto calls = [](const MaterialDescription& material) {
    return std::any_of(material.parameters.begin(), material.parameters.end(),
                       [](const MaterialParameter& p) { return p.key == "creaseAngle"; });
  };
  return std::any_of(materials.begin(), materials.end(), calls);
}

// What surface_attributes() keeps of a surface of so many slots, if it is all called for.
MemoryNeed of_attributes(const MeshParts& parts, std::uint64_t slots, bool is_shaded) {
  const std::uint64_t maps = (parts.has_texture_uv() ? 1 : 0) + (parts.has_friction_uv() ? 1 : 0);
  std::uint64_t kept = slots * maps * sizeof(UvMap);
  if (parts.materials().size() > 1) kept += slots * sizeof(std::uint16_t);
  if (!is_shaded) return {kept, kept};
  constexpr std::uint64_t kPasses = 2;  // by face: of one angle, and of all
  kept += slots * sizeof(CornerNormals);
  return {kept, kept + kPasses * slots * sizeof(CornerNormals)};
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
  MemoryLedger ledger;
  Result<Scene> scene = or_out_of_memory(ledger, [&]() -> Result<Scene> {
    ledger.begin("loading the scene");
    ReadOptions options{settings.overrides, settings.pose};
    options.memory = memory_limit(settings.max_memory_bytes);
    Result<SceneDescription> description = read_gltf(path, options);
    if (!description) return description.error();
    ledger = MemoryLedger(std::move(options.memory));
    return compile(std::move(*description), settings, ledger);
  });
  if (!scene && scene.error().path.empty()) return with_path(scene.error(), path);
  return scene;
}

Result<Scene> Scene::compile(SceneDescription description, const SceneSettings& settings) {
  MemoryLedger ledger;
  return or_out_of_memory(ledger, [&]() -> Result<Scene> {
    ledger.begin("compiling the scene");
    ledger = MemoryLedger(memory_limit(settings.max_memory_bytes));
    return compile(std::move(description), settings, ledger);
  });
}

// Calls visit(shape) for each shape that has a surface without a stretch, and for each stretch:
// what surfaces share that share attributes.
template <typename Visit>
void Scene::visit_shapes_and_stretches(const Visit& visit) const {
  std::vector<bool> is_shape_known(shapes_.size(), false);
  std::vector<bool> is_stretch_known(world_.stretches->size(), false);
  const auto look_at = [&](const IndexUse& use) {
    const bool is_stretched = use.stretch != IndexUse::kNoStretch;
    std::vector<bool>::reference is_known =
        is_stretched ? is_stretch_known[use.stretch] : is_shape_known[use.shape];
    if (!is_known) visit(use.shape);
    is_known = true;
  };
  for (const IndexUse& use : use_of_object_) look_at(use);
  for (const Medium& medium : media_) look_at(medium.use);
}

Result<Scene> Scene::compile(SceneDescription&& given, const SceneSettings& settings,
                             MemoryLedger& ledger) {
  SceneDescription description = std::move(given);  // so that what throws gives it back
  Scene scene;
  scene.ledger_ = &ledger;
  ledger.advise("load a part of it with `SceneSettings::node`");
  ledger.begin("compiling the scene");
  complete_tree(description);
  if (!settings.node.empty()) {
    const auto node = find_node(description.tree, settings.node);
    if (!node) return with_path(node.error(), description.path);
    keep_subtree(description, *node);
  }
  drop_unused_meshes(description);
  ledger.begin("what the scene describes");
  if (auto error = ledger.take(memory_bytes(description))) {
    return with_path(*error, description.path);
  }
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
  if (auto error = scene.weld_meshes(description.meshes)) {
    return with_path(*error, description.path);
  }
  if (auto error = scene.take_places(description.nodes)) {
    return with_path(*error, description.path);
  }
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
  if (auto error = scene.add_surfaces(description.nodes, placements, boxes, settings.proxy_radius_m,
                                      effects)) {
    return with_path(*error, description.path);
  }
  std::vector<NodePlacement>().swap(placements);  // of a million nodes, that counts
  const auto index_start = std::chrono::steady_clock::now();
  if (auto error = scene.build_world(bounds, description.nodes, settings.proxy_radius_m)) {
    return with_path(*error, description.path);
  }
  MemoryNeed kept_for_effects = of_maps(description.images);
  const bool is_shaded = calls_for_shading(scene.materials_);
  scene.visit_shapes_and_stretches([&](std::uint32_t shape) {
    const std::uint64_t slots = scene.indices_[shape]->pack_count() * TrianglePack::kLanes;
    const MeshParts& parts = scene.parts_[scene.shapes_[shape].mesh];
    kept_for_effects = kept_for_effects + of_attributes(parts, slots, is_shaded);
  });
  ledger.begin("what effects keep of surfaces and images", "scene");
  if (auto error = ledger.take(kept_for_effects)) return with_path(*error, description.path);
  std::vector<NodeDescription>().swap(description.nodes);
  if (auto error = scene.compile_effects(effects)) return with_path(*error, description.path);
  statistics.index_ms = milliseconds_since(index_start);
  scene.ledger_ = nullptr;
  return scene;
}

std::optional<Error> Scene::weld_meshes(std::vector<MeshDescription>& descriptions) {
  const auto start = std::chrono::steady_clock::now();
  std::size_t triangles = 0;
  std::vector<MemoryNeed> needs;
  std::size_t largest = 0;
  for (const MeshDescription& mesh : descriptions) {
    triangles += mesh.triangles.size();
    needs.push_back(WeldedSurface::memory_need(mesh.positions.size(), mesh.triangles.size()));
    if (has_uv(mesh)) needs.back() = needs.back() + mesh.triangles.size() * sizeof(Triangle);
    if (needs.back().peak > needs[largest].peak) largest = needs.size() - 1;
  }
  ledger_->begin("welding meshes", descriptions.empty() ? "" : mesh_named(descriptions[largest]));
  if (auto error = ledger_->take(sum_of(std::move(needs), core_count()))) return error;
  welded_.resize(descriptions.size());
  run_meshes(descriptions.size(), triangles, [&](std::size_t i) {
    MeshDescription& mesh = descriptions[i];
    welded_[i] = WeldedSurface(std::move(mesh.positions),
                               has_uv(mesh) ? mesh.triangles : std::move(mesh.triangles));
  });
  for (std::size_t i = 0; i < descriptions.size(); ++i) {
    parts_.emplace_back(welded_[i], std::move(descriptions[i]));
    descriptions[i] = {};  // what is compiled need not be kept twice
  }
  statistics_.mesh_ms = milliseconds_since(start);
  return std::nullopt;
}

// Counts what the nodes take that are placed, whatever their surfaces.
std::optional<Error> Scene::take_places(const std::vector<NodeDescription>& nodes) {
  constexpr std::uint64_t kKept = sizeof(SceneObject) + sizeof(IndexUse) + sizeof(std::size_t) +
                                  sizeof(std::uint32_t) + sizeof(ContactBody);
  MemoryNeed need;
  for (const NodeDescription& node : nodes) need.kept += kKept + text_bytes(node.name);
  need.peak = need.kept + nodes.size() * sizeof(NodePlacement);
  if (nodes.size() > kFewBodies) need = need + BoxTree::memory_need(nodes.size());
  ledger_->begin("placing nodes", std::to_string(nodes.size()) + " nodes");
  return ledger_->take(need);
}

// Leaves the nodes that have a surface to touch, and returns how each is placed.
std::vector<NodePlacement> Scene::touchable(std::vector<NodeDescription>& nodes) {
  std::vector<NodePlacement> placements;
  placements.reserve(nodes.size());
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
                                         std::span<const Box> boxes, double proxy_radius_m,
                                         SceneEffects& effects) {
  const double size_m = statistics_.extent_m.maxCoeff();
  IndexSharing sharing(welded_, boxes, sweep_radius_m(size_m, proxy_radius_m), size_m);
  for (std::size_t i = 0; i < nodes.size(); ++i) sharing.look_at(nodes[i].mesh, placements[i]);
  objects_.reserve(nodes.size());
  use_of_object_.reserve(nodes.size());
  std::vector<IndexUse> uses;
  uses.reserve(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    uses.push_back(sharing.use(nodes[i].mesh, placements[i]));
  }
  shapes_ = sharing.take_shapes();
  world_.stretches = std::make_shared<const std::vector<Stretch>>(sharing.take_stretches());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const NodeDescription& node = nodes[i];
    const auto outfit = effects.outfit(node.name, node.mesh, node.physics_material);
    if (!outfit) return outfit.error();
    const Vec3 middle_m = -uses[i].metres_per_unit * map_body_mesh(uses[i]).translation_m;
    const Quat& rotation = placements[i].rotation;
    const RigidTransform T_scene_body{rotation, node.translation_m + rotation * middle_m};
    statistics_.instanced_triangles += welded_[node.mesh].face_count();
    if (!effects.is_solid(*outfit)) {
      media_.push_back({node.name, uses[i], *outfit, T_scene_body});
      continue;
    }
    objects_.push_back({node.name, node.mesh, node.tree_node, T_scene_body, node.physics_material});
    use_of_object_.push_back(uses[i]);
    outfit_of_object_.push_back(*outfit);
    node_of_object_.push_back(static_cast<std::uint32_t>(i));
  }
  statistics_.instances = objects_.size() + media_.size();
  statistics_.indices = shapes_.size();
  return std::nullopt;
}

AffineMap Scene::map_body_mesh(const IndexUse& use) const {
  const AffineMap& map = shapes_[use.shape].map_index_mesh;
  if (use.stretch == IndexUse::kNoStretch) return map;
  const Mat3& linear = (*world_.stretches)[use.stretch].linear_body_index();
  return {linear * map.linear, linear * map.translation_m};
}

AffineMap Scene::map_body_mesh(std::size_t object) const {
  return map_body_mesh(use_of_object_[object]);
}

AffineMap Scene::deformation(std::size_t object) const {
  const double metres_per_unit = use_of_object_[object].metres_per_unit;
  const AffineMap map = map_body_mesh(object);
  return {metres_per_unit * map.linear, metres_per_unit * map.translation_m};
}

std::optional<Error> Scene::build_world(const Box& bounds_scene,
                                        const std::vector<NodeDescription>& nodes,
                                        double proxy_radius_m) {
  world_.size_m = statistics_.extent_m.maxCoeff();
  // A single body is solved in its own frame: no transform, no rounding.
  world_.anchor_scene_m = objects_.size() == 1 ? objects_[0].T_scene_body.translation_m
                                               : Vec3(0.5 * (bounds_scene.low + bounds_scene.high));
  world_.bounds_solver = {world_.to_solver(bounds_scene.low), world_.to_solver(bounds_scene.high)};
  auto found = seams_of(nodes);
  if (!found) return found.error();
  Seams seams = std::move(*found);
  report_seams(seams);
  if (auto error = take_surfaces(seams)) return error;
  if (proxy_radius_m == 0.0) widen_sweeps(seams);
  build_meshes_and_indices();
  add_bodies();
  if (!seams.bodies.empty()) add_corners(seams, nodes);
  node_of_object_ = {};
  statistics_.memory.places =
      objects_.capacity() * sizeof(SceneObject) + tree_.capacity() * sizeof(TreeNode) +
      use_of_object_.capacity() * sizeof(IndexUse) +
      world_.bodies.capacity() * sizeof(ContactBody) + shapes_.capacity() * sizeof(IndexShape) +
      world_.stretches->capacity() * sizeof(Stretch) +
      (world_.seams ? world_.seams->memory_bytes() : 0);
  for (const SceneObject& object : objects_) statistics_.memory.places += text_bytes(object.name);
  for (const TreeNode& node : tree_) statistics_.memory.places += text_bytes(node.name);
  if (world_.bodies.size() <= kFewBodies) return std::nullopt;
  std::vector<Box> boxes;
  boxes.reserve(world_.bodies.size());
  for (const ContactBody& body : world_.bodies) boxes.push_back(body.box_solver());
  world_.tree = std::make_shared<BoxTree>(boxes, sweep_radius_m(world_.size_m, proxy_radius_m));
  statistics_.memory.places += world_.tree->memory_bytes();
  return std::nullopt;
}

void Scene::add_bodies() {
  world_.bodies.reserve(objects_.size());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const RigidTransform& T_scene_body = objects_[i].T_scene_body;
    const IndexUse& use = use_of_object_[i];
    ContactBody& body = world_.bodies.emplace_back();
    body.index = indices_[use.shape].get();
    body.place({T_scene_body.rotation, world_.to_solver(T_scene_body.translation_m)});
    body.metres_per_unit = use.metres_per_unit;
    body.units_per_metre = 1.0 / use.metres_per_unit;
    if (use.stretch != IndexUse::kNoStretch) body.stretch = &(*world_.stretches)[use.stretch];
  }
}

// For a point: as far as what sorts out looks beyond the clearance for bodies that meet others
// along seams, and for stretched ones. Of one that is next to nothing beside the scene, that is
// far: such a body is not searched with Embree (SegmentTracer).
void Scene::widen_sweeps(const Seams& seams) {
  constexpr double kMostSweep = 0x1p-10;  // of the size of the mesh
  const double reach_m = SolverScale::of(world_.size_m, 0.0).stand_off_m;
  const auto widen = [&](const IndexUse& use, double sweep_radius) {
    double& widest = shapes_[use.shape].sweep_radius;
    if (sweep_radius <= kMostSweep) widest = std::max(widest, sweep_radius);
  };
  for (const SeamBody& body : seams.bodies) {
    const IndexUse& use = use_of_object_[body.surface];
    widen(use, reach_m / std::abs(use.metres_per_unit));
  }
  // Steps that begin farther away are rare.
  const Vec3 far_m = Vec3::Constant(world_.size_m);
  for (const IndexUse& use : use_of_object_) {
    if (use.stretch == IndexUse::kNoStretch) continue;
    widen(use, (*world_.stretches)[use.stretch].reach_index(reach_m, far_m));
  }
}

Result<Seams> Scene::seams_of(const std::vector<NodeDescription>& nodes) const {
  ledger_->begin("joining nodes that meet", std::to_string(objects_.size()) + " nodes");
  if (auto error = ledger_->check(objects_.size() * sizeof(SeamSurface))) return *error;
  std::vector<SeamSurface> surfaces;
  surfaces.reserve(objects_.size());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const IndexUse& use = use_of_object_[i];
    surfaces.push_back({&nodes[node_of_object_[i]], use.metres_per_unit * map_body_mesh(use).linear,
                        objects_[i].T_scene_body.rotation});
  }
  return find_seams(welded_, surfaces, world_.anchor_scene_m, world_.size_m, *ledger_);
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
  const auto warn = [&](const std::vector<std::uint32_t>& surfaces, const char* problem) {
    if (surfaces.empty()) return;
    const std::size_t others = surfaces.size() - 1;
    statistics_.warnings.push_back(
        objects_[surfaces.front()].name +
        (others > 0 ? " and " + std::to_string(others) + " more nodes" : "") + problem);
  };
  warn(seams.too_far,
       ": too far from the origin of the scene, or of the mesh, to tell which vertices meet those "
       "of other nodes; a point may pass between nodes there. Move the scene to its origin");
  warn(seams.crowded,
       ": too small beside the scene to tell which vertices meet those of other nodes; a point may "
       "pass between nodes there. Leave out what makes the scene so large");
}

// Of the bodies that meet others, for a point. Their indices exist.
void Scene::add_corners(Seams& seams, const std::vector<NodeDescription>& nodes) {
  constexpr std::size_t kNone = ~std::size_t{0};
  std::vector<std::size_t> slots_of_shape(shapes_.size(), kNone);
  const auto made = std::make_shared<SeamedBodies>();
  for (const SeamBody& body : seams.bodies) {
    const std::size_t shape = use_of_object_[body.surface].shape;
    if (slots_of_shape[shape] != kNone) continue;
    slots_of_shape[shape] = made->slots.size();
    made->slots.push_back(vertices_of_slots(*indices_[shape], meshes_[shapes_[shape].mesh]));
  }
  made->bodies.reserve(seams.bodies.size());
  for (SeamBody& body : seams.bodies) {
    const std::size_t shape = use_of_object_[body.surface].shape;
    const NodeDescription& node = nodes[node_of_object_[body.surface]];
    body.joined.shrink_to_fit();
    made->bodies.push_back(std::make_unique<SolverCorners>(
        meshes_[shapes_[shape].mesh].welded_positions(), made->slots[slots_of_shape[shape]],
        node.linear_scene_mesh, world_.to_solver(node.translation_m), std::move(body.joined)));
    world_.bodies[body.surface].corners = made->bodies.back().get();
  }
  world_.seams = made;
}

// What the triangles of the indices take, by slot, that bodies which meet others have.
std::uint64_t Scene::corner_bytes(const Seams& seams) const {
  std::vector<bool> has_seams(shapes_.size(), false);
  for (const SeamBody& body : seams.bodies) has_seams[use_of_object_[body.surface].shape] = true;
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    if (has_seams[i]) bytes += sizeof(Triangle) * welded_[shapes_[i].mesh].face_count();
  }
  return bytes;
}

// Counts what adjacency and indices take, and the corners of those that meet others. The node that
// is named shows the mesh of which indices take the most.
std::optional<Error> Scene::take_surfaces(const Seams& seams) {
  std::vector<MemoryNeed> needs;
  for (const WeldedSurface& mesh : welded_) needs.push_back(SurfaceMesh::memory_need(mesh));
  std::vector<std::uint64_t> of_mesh(welded_.size(), 0);
  std::vector<std::uint64_t> shapes_of_mesh(welded_.size(), 0);
  for (const IndexShape& shape : shapes_) {
    needs.push_back(SurfaceIndex::memory_need(welded_[shape.mesh].face_count()) +
                    sizeof(IndexShape));
    of_mesh[shape.mesh] += needs.back().kept;
    ++shapes_of_mesh[shape.mesh];
  }
  MemoryNeed need = sum_of(std::move(needs), core_count() + 1);
  need = need + world_.stretches->size() * sizeof(Stretch);
  for (const SeamBody& body : seams.bodies) {
    need = need + (sizeof(SolverCorners) + body.joined.size() * sizeof(JoinedVertex));
  }
  if (!seams.bodies.empty()) need = need + corner_bytes(seams);
  const auto largest =
      static_cast<std::size_t>(std::max_element(of_mesh.begin(), of_mesh.end()) - of_mesh.begin());
  const auto shows_it = [&](const SceneObject& object) { return object.mesh == largest; };
  const auto object = std::find_if(objects_.begin(), objects_.end(), shows_it);
  const bool is_object = object != objects_.end();
  std::string element = is_object ? node_named(object->name) : "media";
  if (shapes_of_mesh[largest] > 1) {
    element += ", whose mesh has " + std::to_string(shapes_of_mesh[largest]) + " shapes";
  }
  ledger_->begin("building indices", std::move(element));
  return ledger_->take(need);
}

// Adjacency and indices at the same time: both need the welded surfaces alone.
void Scene::build_meshes_and_indices() {
  std::size_t triangles = 0;
  for (const WeldedSurface& mesh : welded_) triangles += mesh.face_count();
  meshes_.resize(welded_.size());
  indices_.resize(shapes_.size());
  run_both(
      [&] {
        run_meshes(shapes_.size(), triangles, [&](std::size_t i) {
          const WeldedSurface& mesh = welded_[shapes_[i].mesh];
          indices_[i] = std::make_unique<SurfaceIndex>(
              MappedFaces{mesh.positions(), mesh.faces(), shapes_[i].map_index_mesh},
              shapes_[i].sweep_radius);
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
  for (const auto& index : indices_) statistics_.memory += index->memory();
}

EffectSurface Scene::effect_surface(std::string_view node, const IndexUse& use, std::size_t outfit,
                                    const RigidTransform& T_scene_body) const {
  const IndexShape& shape = shapes_[use.shape];
  const bool is_stretched = use.stretch != IndexUse::kNoStretch;
  return {node,
          outfit,
          is_stretched ? shapes_.size() + use.stretch : use.shape,
          {&meshes_[shape.mesh], &parts_[shape.mesh], shape.map_index_mesh,
           indices_[use.shape].get(), is_stretched ? &(*world_.stretches)[use.stretch] : nullptr},
          {T_scene_body.rotation, world_.to_solver(T_scene_body.translation_m)},
          use.metres_per_unit};
}

std::optional<Error> Scene::compile_effects(SceneEffects& effects) {
  const EffectSurfaces bodies{objects_.size(), [&](std::size_t i) {
                                const SceneObject& object = objects_[i];
                                return effect_surface(object.name, use_of_object_[i],
                                                      outfit_of_object_[i], object.T_scene_body);
                              }};
  const EffectSurfaces media{media_.size(), [&](std::size_t i) {
                               const Medium& m = media_[i];
                               return effect_surface(m.name, m.use, m.outfit, m.T_scene_body);
                             }};
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
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const SceneObject& object = objects_[i];
    const SurfaceMesh& mesh = meshes_[object.mesh];
    const double metres_per_unit = use_of_object_[i].metres_per_unit;
    const AffineMap map = map_body_mesh(i);
    const auto first = static_cast<std::uint32_t>(positions_m.size());
    for (const Vec3& p : mesh.welded_positions()) {
      positions_m.push_back(object.T_scene_body.point(metres_per_unit * map(p)));
    }
    const bool mirrored = metres_per_unit * map.linear.determinant() < 0.0;
    for (const Triangle& t : mesh.faces()) {
      triangles.push_back({first + t[0], first + t[mirrored ? 2 : 1], first + t[mirrored ? 1 : 2]});
    }
  }
}

}  // namespace palpate
