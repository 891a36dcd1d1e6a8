// Turns the nodes of a scene into the bodies of its world: see scene_compiler.h.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "engine/scene/memory_budget.h"
#include "engine/scene/scene_compiler.h"
#include "haptics/proxy/face_materials.h"

namespace palpate {
namespace {

// Up to this many bodies are tested one by one; a tree is used for more bodies.
constexpr std::size_t kFewBodies = 8;

// The sweep radius that indices are built for; 0 if the proxy is a point.
double sweep_radius_m(double size_m, double proxy_radius_m) {
  const double stand_off_m = SolverScale::of(size_m, proxy_radius_m).stand_off_m;
  return proxy_radius_m > 0.0 ? proxy_radius_m + 2 * stand_off_m : 0.0;
}

}  // namespace

// Takes the memory of all placed nodes, without their surfaces, from the ledger.
std::optional<Error> SceneCompiler::take_places() {
  const std::vector<NodeDescription>& nodes = description_.nodes;
  constexpr std::uint64_t kKept = sizeof(SceneObject) + sizeof(IndexUse) + sizeof(std::size_t) +
                                  2 * sizeof(std::uint32_t) + sizeof(ContactBody);
  MemoryNeed need;
  for (const NodeDescription& node : nodes) need.kept += kKept + text_bytes(node.name);
  // The materials of faces, in vectors that may have twice the capacity that they need.
  for (const MeshDescription& mesh : description_.meshes) {
    need.kept += 2 * sizeof(FaceMaterialRun) * (mesh.material_runs.size() + 2);
  }
  need.peak = need.kept + nodes.size() * sizeof(NodePlacement);
  if (nodes.size() > kFewBodies) need = need + BoxTree::memory_need(nodes.size());
  ledger_.begin("placing nodes", std::to_string(nodes.size()) + " nodes");
  return ledger_.take(need);
}

// Removes the nodes that have no surface to touch, and places the others.
void SceneCompiler::keep_touchable_nodes() {
  placements_.reserve(description_.nodes.size());
  std::erase_if(description_.nodes, [&](const NodeDescription& node) {
    if (welded_[node.mesh].face_count() == 0) return true;
    const auto placement = split_linear(node.linear_scene_mesh);
    if (!placement || !node.translation_m.allFinite()) {
      statistics_.warnings.push_back(node.name +
                                     ": left out because its transform flattens the surface");
      return true;
    }
    placements_.push_back(*placement);
    return false;
  });
}

std::optional<Error> SceneCompiler::add_surfaces(SceneEffects& effects) {
  const std::vector<NodeDescription>& nodes = description_.nodes;
  const double size_m = statistics_.extent_m.maxCoeff();
  IndexSharing sharing(welded_, boxes_, sweep_radius_m(size_m, settings_.proxy_radius_m), size_m);
  for (std::size_t i = 0; i < nodes.size(); ++i) sharing.examine(nodes[i].mesh, placements_[i]);
  scene_.objects_.reserve(nodes.size());
  scene_.use_of_object_.reserve(nodes.size());
  std::vector<IndexUse> uses;
  uses.reserve(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    uses.push_back(sharing.use(nodes[i].mesh, placements_[i]));
  }
  scene_.shapes_ = sharing.take_shapes();
  scene_.world_.stretches = std::make_shared<const std::vector<Stretch>>(sharing.take_stretches());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const NodeDescription& node = nodes[i];
    const auto material_set = effects.material_set(node.name, node.mesh, node.physics_material);
    if (!material_set) return material_set.error();
    const Vec3 middle_m = -uses[i].metres_per_unit * scene_.map_body_mesh(uses[i]).translation_m;
    const Quat& rotation = placements_[i].rotation;
    const RigidTransform T_scene_body{rotation, node.translation_m + rotation * middle_m};
    statistics_.instanced_triangles += welded_[node.mesh].face_count();
    if (!effects.is_solid(*material_set)) {
      media_.push_back({node.name, uses[i], *material_set, T_scene_body});
      continue;
    }
    scene_.objects_.push_back(
        {node.name, node.mesh, node.tree_node, T_scene_body, node.physics_material});
    scene_.use_of_object_.push_back(uses[i]);
    material_set_of_object_.push_back(*material_set);
    node_of_object_.push_back(static_cast<std::uint32_t>(i));
  }
  statistics_.instances = scene_.objects_.size() + media_.size();
  statistics_.indices = scene_.shapes_.size();
  return std::nullopt;
}

std::optional<Error> SceneCompiler::build_world() {
  scene_.world_.size_m = statistics_.extent_m.maxCoeff();
  // A single body is solved in its own frame, which needs no transform and causes no rounding.
  scene_.world_.anchor_scene_m = scene_.objects_.size() == 1
                                     ? scene_.objects_[0].T_scene_body.translation_m
                                     : Vec3(0.5 * (bounds_scene_.low + bounds_scene_.high));
  scene_.world_.bounds_solver = {scene_.world_.to_solver(bounds_scene_.low),
                                 scene_.world_.to_solver(bounds_scene_.high)};
  auto found = find_node_seams();
  if (!found) return found.error();
  Seams seams = std::move(*found);
  report_seams(seams);
  if (auto error = take_surfaces(seams)) return error;
  if (settings_.proxy_radius_m == 0.0) widen_sweeps(seams);
  build_meshes_and_indices();
  add_bodies();
  add_face_materials();
  if (!seams.bodies.empty()) add_corners(seams);
  node_of_object_ = {};
  met_of_node_ = {};
  statistics_.memory.places = scene_.objects_.capacity() * sizeof(SceneObject) +
                              scene_.tree_.capacity() * sizeof(TreeNode) +
                              scene_.use_of_object_.capacity() * sizeof(IndexUse) +
                              scene_.world_.bodies.capacity() * sizeof(ContactBody) +
                              scene_.shapes_.capacity() * sizeof(IndexShape) +
                              scene_.world_.stretches->capacity() * sizeof(Stretch) +
                              scene_.world_.materials->memory_bytes() +
                              (scene_.world_.seams ? scene_.world_.seams->memory_bytes() : 0);
  for (const SceneObject& object : scene_.objects_)
    statistics_.memory.places += text_bytes(object.name);
  for (const TreeNode& node : scene_.tree_) statistics_.memory.places += text_bytes(node.name);
  if (scene_.world_.bodies.size() <= kFewBodies) return std::nullopt;
  std::vector<Box> boxes;
  boxes.reserve(scene_.world_.bodies.size());
  for (const ContactBody& body : scene_.world_.bodies) boxes.push_back(body.box_solver());
  scene_.world_.tree = std::make_shared<BoxTree>(
      boxes, sweep_radius_m(scene_.world_.size_m, settings_.proxy_radius_m));
  statistics_.memory.places += scene_.world_.tree->memory_bytes();
  return std::nullopt;
}

void SceneCompiler::add_bodies() {
  scene_.world_.bodies.reserve(scene_.objects_.size());
  for (std::size_t i = 0; i < scene_.objects_.size(); ++i) {
    const RigidTransform& T_scene_body = scene_.objects_[i].T_scene_body;
    const IndexUse& use = scene_.use_of_object_[i];
    ContactBody& body = scene_.world_.bodies.emplace_back();
    body.index = scene_.indices_[use.shape].get();
    body.place({T_scene_body.rotation, scene_.world_.to_solver(T_scene_body.translation_m)});
    body.metres_per_unit = use.metres_per_unit;
    body.units_per_metre = 1.0 / use.metres_per_unit;
    if (use.stretch != IndexUse::kNoStretch)
      body.stretch = &(*scene_.world_.stretches)[use.stretch];
  }
}

void SceneCompiler::add_face_materials() {
  auto materials = std::make_shared<FaceMaterials>();
  materials->reserve(scene_.objects_.size());
  for (const MeshParts& parts : scene_.parts_) materials->add_surface(parts.face_materials());
  for (const SceneObject& object : scene_.objects_) materials->add_body(object.mesh);
  scene_.world_.materials = std::move(materials);
}

// Widens the sweep radii of indices for a point. For bodies with seams and for stretched bodies,
// the search examines triangles at a distance of up to one stand-off, beyond the boxes built for a
// point. Relative to a tiny body this distance is large; such a body keeps its sweep radius and is
// not searched with Embree (SegmentTracer).
void SceneCompiler::widen_sweeps(const Seams& seams) {
  constexpr double kMostSweep = 0x1p-10;  // of the size of the mesh
  const double reach_m = SolverScale::of(scene_.world_.size_m, 0.0).stand_off_m;
  const auto widen = [&](const IndexUse& use, double sweep_radius) {
    double& widest = scene_.shapes_[use.shape].sweep_radius;
    if (sweep_radius <= kMostSweep) widest = std::max(widest, sweep_radius);
  };
  for (const SeamBody& body : seams.bodies) {
    const IndexUse& use = scene_.use_of_object_[body.surface];
    widen(use, reach_m / std::abs(use.metres_per_unit));
  }
  // Steps that begin farther away are rare.
  const Vec3 far_m = Vec3::Constant(scene_.world_.size_m);
  for (const IndexUse& use : scene_.use_of_object_) {
    if (use.stretch == IndexUse::kNoStretch) continue;
    widen(use, (*scene_.world_.stretches)[use.stretch].reach_index(reach_m, far_m));
  }
}

Result<Seams> SceneCompiler::find_node_seams() {
  ledger_.begin("joining nodes that meet", std::to_string(scene_.objects_.size()) + " nodes");
  if (auto error = ledger_.check(scene_.objects_.size() * sizeof(SeamSurface))) return *error;
  std::vector<SeamSurface> surfaces;
  surfaces.reserve(scene_.objects_.size());
  for (std::size_t i = 0; i < scene_.objects_.size(); ++i) {
    const IndexUse& use = scene_.use_of_object_[i];
    const auto met = met_of_node_.find(node_of_object_[i]);
    surfaces.push_back({&description_.nodes[node_of_object_[i]],
                        use.metres_per_unit * scene_.map_body_mesh(use).linear,
                        scene_.objects_[i].T_scene_body.rotation,
                        met == met_of_node_.end() ? std::span<const std::uint32_t>()
                                                  : std::span<const std::uint32_t>(met->second)});
  }
  return find_seams(welded_, surfaces, scene_.world_.anchor_scene_m, scene_.world_.size_m, ledger_);
}

void SceneCompiler::report_seams(const Seams& seams) {
  statistics_.seam_vertices = seams.vertices;
  statistics_.seam_places = seams.places;
  statistics_.seam_nodes = seams.bodies.size();
  if (!seams.bodies.empty()) {
    statistics_.notes.push_back(
        "seams: " + std::to_string(seams.vertices) + " vertices of " +
        std::to_string(seams.bodies.size()) + " nodes meet in " + std::to_string(seams.places) +
        " places and are joined, so that no point passes between the nodes; not joined are nodes "
        "that move, and gaps in the file");
  }
  const auto warn = [&](const std::vector<std::uint32_t>& surfaces, const char* problem) {
    if (surfaces.empty()) return;
    const std::size_t others = surfaces.size() - 1;
    statistics_.warnings.push_back(
        scene_.objects_[surfaces.front()].name +
        (others > 0 ? " and " + std::to_string(others) + " more nodes" : "") + problem);
  };
  warn(seams.too_far,
       ": too far from the origin of the scene or of the mesh to determine which vertices meet "
       "those of other nodes; a point may pass between the nodes. Move the scene to its origin");
  warn(seams.crowded,
       ": too small relative to the scene to determine which vertices meet those of other nodes; a "
       "point may pass between the nodes. Remove the distant parts of the scene");
  warn(seams.unsearched,
       ": overlap others, with so many vertices that it was not determined which of them meet; a "
       "point may pass between the nodes. Use simpler meshes, or remove nodes that nobody feels");
}

// Sets the corners of the bodies with seams, for a point. The indices must exist.
void SceneCompiler::add_corners(Seams& seams) {
  constexpr std::size_t kNone = ~std::size_t{0};
  std::vector<std::size_t> slots_of_shape(scene_.shapes_.size(), kNone);
  const auto made = std::make_shared<SeamedBodies>();
  for (const SeamBody& body : seams.bodies) {
    const std::size_t shape = scene_.use_of_object_[body.surface].shape;
    if (slots_of_shape[shape] != kNone) continue;
    slots_of_shape[shape] = made->slots.size();
    made->slots.push_back(
        vertices_of_slots(*scene_.indices_[shape], scene_.meshes_[scene_.shapes_[shape].mesh]));
  }
  made->bodies.reserve(seams.bodies.size());
  for (SeamBody& body : seams.bodies) {
    const std::size_t shape = scene_.use_of_object_[body.surface].shape;
    const NodeDescription& node = description_.nodes[node_of_object_[body.surface]];
    body.joined.shrink_to_fit();
    made->bodies.push_back(std::make_unique<SolverCorners>(
        scene_.meshes_[scene_.shapes_[shape].mesh].welded_positions(),
        made->slots[slots_of_shape[shape]], node.linear_scene_mesh,
        scene_.world_.to_solver(node.translation_m), std::move(body.joined),
        settings_.joins_within_rounding));
    scene_.world_.bodies[body.surface].corners = made->bodies.back().get();
  }
  scene_.world_.seams = made;
}

}  // namespace palpate
