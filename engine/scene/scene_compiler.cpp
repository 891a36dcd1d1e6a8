#include "engine/scene/scene_compiler.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "engine/scene/memory_budget.h"
#include "engine/scene/node_tree.h"
#include "engine/scene/scene_bounds.h"
#include "io/hidden_nodes.h"

namespace palpate {
namespace {

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

SceneCompiler::SceneCompiler(SceneDescription&& description, const SceneSettings& settings,
                             MemoryLedger& ledger)
    : description_(std::move(description)), settings_(settings), ledger_(ledger) {}

Result<Scene> SceneCompiler::run() {
  if (auto error = compile()) {
    error->path = description_.path;
    return *error;
  }
  return std::move(scene_);
}

std::optional<Error> SceneCompiler::compile() {
  ledger_.advise("load a part of it with `SceneSettings::node`");
  if (auto error = choose_nodes()) return error;
  take_declarations();
  const auto mesh_start = std::chrono::steady_clock::now();
  if (auto error = weld_meshes()) return error;
  statistics_.mesh_ms = milliseconds_since(mesh_start);
  if (auto error = place_nodes()) return error;
  if (auto error = fix_size()) return error;
  take_parts();
  scene_.tree_ = std::move(description_.tree);
  take_contours();
  SceneEffects effects(
      {scene_.materials_, scene_.physics_materials_, scene_.haptic_materials_, description_.images,
       &description_.scene_parameters, description_.regions, statistics_.scale},
      scene_.parts_);
  if (auto error = conform_nodes(effects)) return error;
  if (auto error = add_surfaces(effects)) return error;
  std::vector<NodePlacement>().swap(placements_);  // a large amount of memory for a million nodes
  const auto index_start = std::chrono::steady_clock::now();
  if (auto error = build_world()) return error;
  if (auto error = take_attributes()) return error;
  std::vector<NodeDescription>().swap(description_.nodes);
  if (auto error = compile_effects(effects)) return error;
  statistics_.index_ms = milliseconds_since(index_start);
  return std::nullopt;
}

// Leaves out what SceneSettings::node does not choose, and takes the memory of the rest.
std::optional<Error> SceneCompiler::choose_nodes() {
  ledger_.begin("compiling the scene");
  complete_tree(description_);
  if (!settings_.node.empty()) {
    const auto node = find_node(description_.tree, settings_.node);
    if (!node) return node.error();
    keep_subtree(description_, *node);
  }
  drop_unused_meshes(description_);
  ledger_.begin("the scene description");
  return ledger_.take(memory_bytes(description_));
}

// Places the nodes that can be touched; there must be one.
std::optional<Error> SceneCompiler::place_nodes() {
  if (auto error = take_places()) return error;
  const std::size_t reader_warnings = statistics_.warnings.size();
  keep_touchable_nodes();
  if (!description_.nodes.empty()) return std::nullopt;
  const bool left_out = statistics_.warnings.size() > reader_warnings;
  return Error{ErrorCode::kEmptyScene, "", "scene",
               "no node has a triangle with area; expected at least one",
               left_out ? statistics_.warnings[reader_warnings]
                        : hidden_nodes_text(statistics_.hidden_nodes)};
}

// Scales the scene, checks its extent, and closes its gaps.
std::optional<Error> SceneCompiler::fix_size() {
  boxes_ = bounding_boxes(welded_);
  measure_bounds();
  statistics_.scale = settings_.fit_size_m > 0.0
                          ? settings_.fit_size_m / statistics_.extent_m.maxCoeff()
                          : settings_.scale;
  if (statistics_.scale != 1.0) {
    scale_by(statistics_.scale, description_, placements_);
    measure_bounds();
  }
  if (auto error = refuse_beyond_limits(boxes_, description_.nodes)) return error;
  if (auto error = refuse_extent(statistics_.extent_m)) return error;
  if (auto error = close_gaps()) return error;
  if (statistics_.gap_joins.joined_vertices > 0) {
    boxes_ = bounding_boxes(welded_);
    measure_bounds();
  }
  return std::nullopt;
}

void SceneCompiler::measure_bounds() {
  bounds_scene_ = bounds_in_scene(welded_, boxes_, description_.nodes);
  statistics_.bounds_scene = bounds_scene_;
  statistics_.extent_m = bounds_scene_.high - bounds_scene_.low;
}

// Moves those declarations out of the description that the scene stores unchanged.
void SceneCompiler::take_declarations() {
  statistics_.nodes = description_.tree.size();
  statistics_.meshes = description_.meshes.size();
  statistics_.parse_ms = description_.parse_ms;
  statistics_.animations = std::move(description_.animations);
  statistics_.pose = description_.pose;
  statistics_.files_read = std::move(description_.files_read);
  statistics_.scenes = std::move(description_.scenes);
  statistics_.hidden_nodes = std::move(description_.hidden_nodes);
  statistics_.unapplied_extras = std::move(description_.unapplied_extras);
  statistics_.notes = std::move(description_.notes);
  statistics_.warnings = std::move(description_.warnings);
  scene_.materials_ = std::move(description_.materials);
  scene_.physics_materials_ = std::move(description_.physics_materials);
  scene_.haptic_materials_ = std::move(description_.haptic_materials);
}

// Takes the contours, which are in the scene frame.
void SceneCompiler::take_contours() {
  scene_.contours_ = std::move(description_.contours);
  for (ContourDescription& contour : scene_.contours_) {
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
void SceneCompiler::visit_shapes_and_stretches(const Visit& visit) const {
  std::vector<bool> is_shape_known(scene_.shapes_.size(), false);
  std::vector<bool> is_stretch_known(scene_.world_.stretches->size(), false);
  const auto visit_use = [&](const IndexUse& use) {
    const bool is_stretched = use.stretch != IndexUse::kNoStretch;
    std::vector<bool>::reference is_known =
        is_stretched ? is_stretch_known[use.stretch] : is_shape_known[use.shape];
    if (!is_known) visit(use.shape);
    is_known = true;
  };
  for (const IndexUse& use : scene_.use_of_object_) visit_use(use);
  for (const Medium& medium : media_) visit_use(medium.use);
}

// Takes the memory of surface attributes and height maps from the ledger.
std::optional<Error> SceneCompiler::take_attributes() {
  MemoryNeed need = need_of_maps(description_.images);
  const bool is_shaded = requires_shading(scene_.materials_);
  visit_shapes_and_stretches([&](std::uint32_t shape) {
    const std::uint64_t slots = scene_.indices_[shape]->pack_count() * TrianglePack::kLanes;
    const MeshParts& parts = scene_.parts_[scene_.shapes_[shape].mesh];
    need = need + need_of_attributes(parts, slots, is_shaded);
  });
  ledger_.begin("storing attributes and maps for effects", "scene");
  return ledger_.take(need);
}

EffectSurface SceneCompiler::effect_surface(std::string_view node, const IndexUse& use,
                                            std::size_t material_set,
                                            const RigidTransform& T_scene_body) const {
  const IndexShape& shape = scene_.shapes_[use.shape];
  const bool is_stretched = use.stretch != IndexUse::kNoStretch;
  return {node,
          material_set,
          is_stretched ? scene_.shapes_.size() + use.stretch : use.shape,
          {&scene_.meshes_[shape.mesh], &scene_.parts_[shape.mesh], shape.map_index_mesh,
           scene_.indices_[use.shape].get(),
           is_stretched ? &(*scene_.world_.stretches)[use.stretch] : nullptr},
          {T_scene_body.rotation, scene_.world_.to_solver(T_scene_body.translation_m)},
          use.metres_per_unit};
}

std::optional<Error> SceneCompiler::compile_effects(SceneEffects& effects) {
  const EffectSurfaces bodies{scene_.objects_.size(), [&](std::size_t i) {
                                const SceneObject& object = scene_.objects_[i];
                                return effect_surface(object.name, scene_.use_of_object_[i],
                                                      material_set_of_object_[i],
                                                      object.T_scene_body);
                              }};
  const EffectSurfaces media{media_.size(), [&](std::size_t i) {
                               const Medium& m = media_[i];
                               return effect_surface(m.name, m.use, m.material_set, m.T_scene_body);
                             }};
  auto result = effects.compile(bodies, media, scene_.world_.anchor_scene_m);
  if (!result) return result.error();
  scene_.world_.effects = std::move(result->program);
  scene_.effects_ = std::move(result->report);
  scene_.material_calls_ = std::move(result->calls);
  statistics_.memory.effects = result->memory_bytes;
  for (MeshParts& parts : scene_.parts_) parts.drop_uv();
  material_set_of_object_ = {};
  media_ = {};
  return std::nullopt;
}

}  // namespace palpate
