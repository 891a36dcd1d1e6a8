#include "engine/scene/scene.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "engine/scene/extras_keys.h"
#include "engine/scene/memory_budget.h"
#include "engine/scene/node_placement.h"
#include "engine/scene/node_tree.h"
#include "engine/scene/scene_bounds.h"
#include "io/gltf/reader.h"
#include "io/hidden_nodes.h"

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
  for (ContourDescription& contour : description.contours) {
    contour.start_scene_m *= scale;
    contour.end_scene_m *= scale;
  }
}

// If the description has no tree, makes a tree of the nodes that have meshes.
void complete_tree(SceneDescription& description) {
  if (!description.tree.empty()) return;
  for (NodeDescription& node : description.nodes) {
    node.tree_node = static_cast<std::uint32_t>(description.tree.size());
    description.tree.push_back({node.name, node.tree_node, {}, true, node.translation_m});
  }
}

// Removes the meshes that no node refers to.
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

// The memory need of height maps: one map of each image.
MemoryNeed need_of_maps(const std::vector<ImageDescription>& images) {
  constexpr std::uint64_t kMakingPerTexel = 28;  // see kMostMapTexels
  MemoryNeed need;
  for (const ImageDescription& image : images) {
    const std::uint64_t texels = std::uint64_t{image.width} * image.height;
    const std::uint64_t kept = texels * 16 / 3;
    need = need + MemoryNeed{kept, kept + kMakingPerTexel * texels};
  }
  return need;
}

bool requires_shading(const std::vector<MaterialDescription>& materials) {
  const auto has_crease_angle = [](const MaterialDescription& material) {
    return std::any_of(material.parameters.begin(), material.parameters.end(),
                       [](const MaterialParameter& p) { return p.key == "creaseAngle"; });
  };
  return std::any_of(materials.begin(), materials.end(), has_crease_angle);
}

// The memory need of surface_attributes() for a surface with this number of slots, if effects need
// all attributes.
MemoryNeed need_of_attributes(const MeshParts& parts, std::uint64_t slots, bool is_shaded) {
  const std::uint64_t maps = (parts.has_texture_uv() ? 1 : 0) + (parts.has_friction_uv() ? 1 : 0);
  std::uint64_t kept = slots * maps * sizeof(UvMap);
  if (parts.materials().size() > 1) kept += slots * sizeof(std::uint16_t);
  if (!is_shaded) return {kept, kept};
  constexpr std::uint64_t kPasses = 2;  // normals by face: of one angle, and of all angles
  kept += slots * sizeof(CornerNormals);
  return {kept, kept + kPasses * slots * sizeof(CornerNormals)};
}

}  // namespace

Result<Scene> Scene::load(const std::string& path, const SceneSettings& settings) {
  MemoryLedger ledger;
  Result<Scene> scene = or_out_of_memory(ledger, [&]() -> Result<Scene> {
    ledger.begin("loading the scene");
    ReadOptions options{settings.overrides, settings.pose};
    options.memory = memory_limit(settings.max_memory_bytes);
    options.scene = settings.listed_scene;
    options.feels_hidden = settings.feels_hidden;
    options.key_names = &extras_keys();
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

Result<Scene> Scene::compile(SceneDescription&& given, const SceneSettings& settings,
                             MemoryLedger& ledger) {
  SceneDescription description = std::move(given);  // freed here if an exception is thrown
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
  ledger.begin("the scene description");
  if (auto error = ledger.take(memory_bytes(description))) {
    return with_path(*error, description.path);
  }
  SceneStatistics& statistics = scene.statistics_;
  scene.take_declarations(description);
  const auto mesh_start = std::chrono::steady_clock::now();
  if (auto error = scene.weld_meshes(description.meshes, settings.joins_within_rounding)) {
    return with_path(*error, description.path);
  }
  statistics.mesh_ms = milliseconds_since(mesh_start);
  if (auto error = scene.take_places(description.nodes)) {
    return with_path(*error, description.path);
  }
  const std::size_t reader_warnings = statistics.warnings.size();
  std::vector<NodePlacement> placements = scene.touchable(description.nodes);
  if (description.nodes.empty()) {
    const bool left_out = statistics.warnings.size() > reader_warnings;
    return Error{ErrorCode::kEmptyScene, description.path, "scene",
                 "no node has a triangle with area; expected at least one",
                 left_out ? statistics.warnings[reader_warnings]
                          : hidden_nodes_text(statistics.hidden_nodes)};
  }
  std::vector<Box> boxes = bounding_boxes(scene.welded_);
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
  if (auto error = refuse_extent(statistics.extent_m)) return with_path(*error, description.path);
  if (auto error = scene.close_gaps(description.nodes, settings)) {
    return with_path(*error, description.path);
  }
  if (scene.statistics_.gap_joins.joined_vertices > 0) {
    boxes = bounding_boxes(scene.welded_);
    bounds = bounds_in_scene(scene.welded_, boxes, description.nodes);
    statistics.bounds_scene = bounds;
    statistics.extent_m = bounds.high - bounds.low;
  }
  scene.take_parts(description.meshes);
  scene.tree_ = std::move(description.tree);
  scene.take_contours(description.contours);
  SceneEffects effects(
      {scene.materials_, scene.physics_materials_, scene.haptic_materials_, description.images,
       &description.scene_parameters, description.regions, statistics.scale},
      scene.parts_);
  if (auto error = scene.conform_nodes(description.nodes, boxes, bounds, settings, effects)) {
    return with_path(*error, description.path);
  }
  if (auto error = scene.add_surfaces(description.nodes, placements, boxes, settings.proxy_radius_m,
                                      effects)) {
    return with_path(*error, description.path);
  }
  std::vector<NodePlacement>().swap(placements);  // a large amount of memory for a million nodes
  const auto index_start = std::chrono::steady_clock::now();
  if (auto error = scene.build_world(bounds, description.nodes, settings)) {
    return with_path(*error, description.path);
  }
  if (auto error = scene.take_attributes(description.images)) {
    return with_path(*error, description.path);
  }
  std::vector<NodeDescription>().swap(description.nodes);
  if (auto error = scene.compile_effects(effects)) return with_path(*error, description.path);
  statistics.index_ms = milliseconds_since(index_start);
  scene.ledger_ = nullptr;
  return scene;
}

// Moves those declarations out of the description that the scene stores unchanged.
void Scene::take_declarations(SceneDescription& description) {
  statistics_.nodes = description.tree.size();
  statistics_.meshes = description.meshes.size();
  statistics_.parse_ms = description.parse_ms;
  statistics_.animations = std::move(description.animations);
  statistics_.pose = description.pose;
  statistics_.files_read = std::move(description.files_read);
  statistics_.scenes = std::move(description.scenes);
  statistics_.hidden_nodes = std::move(description.hidden_nodes);
  statistics_.unapplied_extras = std::move(description.unapplied_extras);
  statistics_.notes = std::move(description.notes);
  statistics_.warnings = std::move(description.warnings);
  materials_ = std::move(description.materials);
  physics_materials_ = std::move(description.physics_materials);
  haptic_materials_ = std::move(description.haptic_materials);
}

// Takes the contours, which are in the scene frame.
void Scene::take_contours(std::vector<ContourDescription>& contours) {
  contours_ = std::move(contours);
  for (ContourDescription& contour : contours_) {
    const bool has_warning = !contour.problem.empty();
    check_points(contour);  // the scale may have changed the points
    if (!has_warning && !contour.problem.empty()) {
      statistics_.warnings.push_back(warning_of(contour));
    }
  }
}

// Calls visit(shape) once for each shape that is used without a stretch, and once for each stretch:
// surfaces with the same shape and stretch share attributes.
template <typename Visit>
void Scene::visit_shapes_and_stretches(const Visit& visit) const {
  std::vector<bool> is_shape_known(shapes_.size(), false);
  std::vector<bool> is_stretch_known(world_.stretches->size(), false);
  const auto visit_use = [&](const IndexUse& use) {
    const bool is_stretched = use.stretch != IndexUse::kNoStretch;
    std::vector<bool>::reference is_known =
        is_stretched ? is_stretch_known[use.stretch] : is_shape_known[use.shape];
    if (!is_known) visit(use.shape);
    is_known = true;
  };
  for (const IndexUse& use : use_of_object_) visit_use(use);
  for (const Medium& medium : media_) visit_use(medium.use);
}

// Takes the memory of surface attributes and height maps from the ledger.
std::optional<Error> Scene::take_attributes(const std::vector<ImageDescription>& images) {
  MemoryNeed need = need_of_maps(images);
  const bool is_shaded = requires_shading(materials_);
  visit_shapes_and_stretches([&](std::uint32_t shape) {
    const std::uint64_t slots = indices_[shape]->pack_count() * TrianglePack::kLanes;
    const MeshParts& parts = parts_[shapes_[shape].mesh];
    need = need + need_of_attributes(parts, slots, is_shaded);
  });
  ledger_->begin("storing attributes and maps for effects", "scene");
  return ledger_->take(need);
}

EffectSurface Scene::effect_surface(std::string_view node, const IndexUse& use,
                                    std::size_t material_set,
                                    const RigidTransform& T_scene_body) const {
  const IndexShape& shape = shapes_[use.shape];
  const bool is_stretched = use.stretch != IndexUse::kNoStretch;
  return {node,
          material_set,
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
                                                      material_set_of_object_[i],
                                                      object.T_scene_body);
                              }};
  const EffectSurfaces media{media_.size(), [&](std::size_t i) {
                               const Medium& m = media_[i];
                               return effect_surface(m.name, m.use, m.material_set, m.T_scene_body);
                             }};
  auto result = effects.compile(bodies, media, world_.anchor_scene_m);
  if (!result) return result.error();
  world_.effects = std::move(result->program);
  effects_ = std::move(result->report);
  material_calls_ = std::move(result->calls);
  statistics_.memory.effects = result->memory_bytes;
  for (MeshParts& parts : parts_) parts.drop_uv();
  material_set_of_object_ = {};
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
