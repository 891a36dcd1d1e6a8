#include "io/gltf/reader.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "geometry/base/memory_reserve.h"
#include "io/gltf/accessor.h"
#include "io/gltf/animation.h"
#include "io/gltf/buffers.h"
#include "io/gltf/contours.h"
#include "io/gltf/error.h"
#include "io/gltf/extensions.h"
#include "io/gltf/extras.h"
#include "io/gltf/file.h"
#include "io/gltf/images.h"
#include "io/gltf/instancing.h"
#include "io/gltf/json_memory.h"
#include "io/gltf/json_scan.h"
#include "io/gltf/json_text.h"
#include "io/gltf/limits.h"
#include "io/gltf/materials.h"
#include "io/gltf/meshopt.h"
#include "io/gltf/model.h"
#include "io/gltf/morph.h"
#include "io/gltf/nodes.h"
#include "io/gltf/physics_materials.h"
#include "io/gltf/prescan.h"
#include "io/gltf/primitives.h"
#include "io/gltf/skin.h"
#include "io/gltf/source.h"
#include "io/gltf/tinygltf.h"
#include "io/gltf/unapplied_extras.h"
#include "io/hidden_nodes.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// The largest number of bytes of a node's name that its instances repeat.
constexpr std::size_t kMaxInstanceName = 32;

// The name, cut between UTF-8 characters.
std::string shortened(const std::string& name) {
  if (name.size() <= kMaxInstanceName) return name;
  std::size_t end = kMaxInstanceName;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0u) == 0x80u) --end;
  return name.substr(0, end) + "...";
}

// Builds the description of the scene from a model whose JSON has been checked.
class SceneReader {
 public:
  // of_text: warnings about the form of the file; of_extensions: about unsupported extensions.
  SceneReader(const GltfAsset& asset, const ReadOptions& options, std::vector<std::string> of_text,
              const std::vector<std::string>& of_extensions)
      : asset_(asset), options_(options) {
    scene_.warnings = std::move(of_text);
    first_loss_ = scene_.warnings.size();
    scene_.warnings.insert(scene_.warnings.end(), of_extensions.begin(), of_extensions.end());
  }

  Result<SceneDescription> run() {
    auto pose = GltfPose::choose(asset_, options_.pose, budget_.pose_work, scene_.warnings);
    if (!pose) return pose.error();
    pose_ = std::move(*pose);
    auto walk = walk_nodes(asset_, pose_, {options_.scene, options_.feels_hidden}, scene_.warnings);
    if (!walk) return walk.error();
    walk_ = &*walk;
    scene_.tree = std::move(walk->tree);
    scene_.hidden_nodes = hidden_nodes_of(scene_.tree);
    list_scenes();
    if (options_.reads_only_tree) return std::move(scene_);
    if (auto error = read_extras()) return *error;
    auto materials = GltfMaterials::open(asset_.json, extras_, options_.overrides);
    if (!materials) return materials.error();
    materials_ = &*materials;
    scene_.nodes.reserve(walk->mesh_nodes.size());
    for (const PlacedNode& placed : walk->mesh_nodes) {
      if (auto error = add_node(placed)) return *error;
    }
    if (scene_.meshes.empty()) {
      return gltf_error(ErrorCode::kEmptyScene, {}, "the scene has no triangle", empty_hint());
    }
    read_contours();
    GltfImages images(asset_);
    if (auto error = materials->decode_maps(images)) return *error;
    if (auto error = materials->finish(scene_)) return *error;
    scene_.images = images.take();
    if (auto error = read_physics_materials(asset_.json, scene_)) return *error;
    note_variants(asset_.json, scene_.notes);
    scene_.animations = list_animations(asset_, scene_.warnings);
    scene_.pose = pose_.description();
    note_animated_visibility(asset_.json, scene_.notes);
    add_notes();
    shorten_warnings();
    if (options_.key_names) {
      scene_.unapplied_extras = unapplied_extras(asset_, applied_elements(), *options_.key_names);
    }
    return std::move(scene_);
  }

 private:
  using Weights = std::vector<double>;

  // A mesh in one pose, by its ids in the file.
  struct PosedMesh {
    std::size_t mesh = 0;
    std::optional<std::size_t> skin;
    const Weights* morph_weights = nullptr;  // in weights_; equal weights have equal pointers

    auto operator<=>(const PosedMesh&) const = default;
  };

  void list_scenes() {
    const auto& scenes = asset_.model.scenes;
    scene_.scenes.count = scenes.size();
    scene_.scenes.loaded = walk_->scene;
    for (std::size_t i = 0; i < scenes.size() && i < kMostListedScenes; ++i) {
      scene_.scenes.names.push_back(scenes[i].name);
    }
  }

  // Why the scene may be empty.
  std::string empty_hint() const {
    if (scene_.hidden_nodes.count > 0) return hidden_nodes_text(scene_.hidden_nodes);
    return scene_.warnings.size() > first_loss_ ? scene_.warnings[first_loss_] : "";
  }

  AppliedElements applied_elements() const {
    AppliedElements applied;
    applied.materials.resize(count_of("materials"));
    for (std::size_t i = 0; i < applied.materials.size(); ++i) {
      applied.materials[i] = materials_->is_used(static_cast<std::uint32_t>(i));
    }
    applied.nodes.resize(asset_.model.nodes.size());
    applied.hidden_nodes.resize(asset_.model.nodes.size());
    for (const TreeNode& node : scene_.tree) {
      applied.nodes[node.file_index] = !node.is_hidden;
      applied.hidden_nodes[node.file_index] = node.is_hidden;
    }
    applied.scene = walk_->scene;
    return applied;
  }

  std::size_t count_of(const char* section) const {
    const auto list = asset_.json.find(section);
    return list == asset_.json.end() || !list->is_array() ? 0 : list->size();
  }

  // Reads the extras.palpate of the scene and its nodes.
  std::optional<Error> read_extras() {
    MaterialDescription& ours = scene_.scene_parameters;
    ours.name = "scene";
    if (walk_->scene) {
      const std::string element = gltf_element("scenes", *walk_->scene);
      ours.element = element + "/extras/palpate";
      const Json& object = asset_.json["scenes"][*walk_->scene];
      if (auto error = extras_.read(object, element, ours.parameters)) return error;
    }
    for (const PlacedNode& placed : walk_->declaring_nodes) {
      if (auto error = add_region(placed)) return error;
    }
    return std::nullopt;
  }

  std::optional<Error> add_region(const PlacedNode& placed) {
    const std::string element = gltf_element("nodes", placed.node);
    const Json& object = asset_.json["nodes"][placed.node];
    const std::string& name = scene_.tree[placed.tree_node].name;
    RegionDescription region{name,
                             element + "/extras/palpate",
                             {},
                             placed.tree_node,
                             placed.T_scene_node.linear,
                             placed.T_scene_node.translation_m};
    if (auto error = extras_.read(object, element, region.parameters)) return error;
    // unapplied_extras() states where the keys of another group belong.
    if (find_palpate_extras(object)->contains("medium")) {
      scene_.regions.push_back(std::move(region));
    }
    return std::nullopt;
  }

  // Reads the contours after the meshes: their warnings do not explain an empty scene.
  void read_contours() {
    scene_.contours.reserve(walk_->contour_nodes.size());
    for (const PlacedNode& placed : walk_->contour_nodes) {
      scene_.contours.push_back(read_contour(asset_, placed, scene_.tree[placed.tree_node].name));
      if (const ContourDescription& contour = scene_.contours.back(); !contour.problem.empty()) {
        scene_.warnings.push_back(warning_of(contour));
      }
    }
  }

  std::optional<Error> add_node(const PlacedNode& placed) {
    const tinygltf::Node& node = asset_.model.nodes[placed.node];
    const std::size_t first = scene_.nodes.size();
    if (auto error = node.skin < 0 ? add_placed(placed) : add_skinned(placed)) return error;
    if (scene_.nodes.size() == first) return std::nullopt;
    const auto weights = weights_of(placed.node);
    if (!weights) return weights.error();
    PosedMesh posed{first_equal(static_cast<std::size_t>(node.mesh)), std::nullopt, *weights};
    if (node.skin >= 0) posed.skin = static_cast<std::size_t>(node.skin);
    const auto mesh = mesh_index(posed, placed.node);
    if (!mesh) return mesh.error();
    if (!*mesh) scene_.nodes.resize(first);
    for (std::size_t i = first; i < scene_.nodes.size(); ++i) scene_.nodes[i].mesh = **mesh;
    return std::nullopt;
  }

  // Adds the node or its instances, still without a mesh.
  std::optional<Error> add_placed(const PlacedNode& placed) {
    const auto instances = read_instances(asset_, placed.node, most_instances());
    if (!instances) return instances.error();
    if (*instances) return add_instances(placed, **instances);
    const std::string& name = scene_.tree[placed.tree_node].name;
    const Mat3& linear = placed.T_scene_node.linear;
    if (linear == Mat3::Identity()) {  // the common case in large scenes
      add_description(placed, name, placed.T_scene_node);
      return std::nullopt;
    }
    const std::string element = gltf_element("nodes", placed.node);
    if (auto error = check_scale(linear, element, in_quotes(name))) return error;
    if (linear.isZero(0.0)) {
      warn(element, name, "has scale zero and is left out");
    } else if (const double scale = lengthening(linear); scale < kMinGltfScale) {
      warn(element, name,
           "is scaled by " + gltf_number(scale) +
               ", with its ancestors, and is left out; expected at least " +
               gltf_number(kMinGltfScale));
    } else if (is_singular(linear)) {
      warn(element, name,
           "is left out: its transform, with those of its ancestors, flattens the mesh");
    } else {
      add_description(placed, name, placed.T_scene_node);
    }
    return std::nullopt;
  }

  // The largest number of instances that a node may still have, if the other nodes with meshes have
  // one each.
  std::size_t most_instances() const {
    const std::size_t others = walk_->mesh_nodes.size() - 1 + instance_count_;
    return kMaxGltfInstances - std::min(kMaxGltfInstances, others);
  }

  std::optional<Error> add_instances(const PlacedNode& placed, const GltfInstances& instances) {
    instance_count_ += instances.count;
    const std::string element = gltf_element("nodes", placed.node);
    const std::string& name = scene_.tree[placed.tree_node].name;
    const std::string prefix = shortened(name) + " #";
    std::size_t flat = 0;
    const std::uint64_t bytes = instances.count * (sizeof(NodeDescription) + kMaxInstanceName);
    if (auto error = asset_.buffers.take_memory({bytes, bytes}, element)) return error;
    if (instances.count > scene_.nodes.size()) {
      scene_.nodes.reserve(scene_.nodes.size() + instances.count);
    }
    for (std::size_t i = 0; i < instances.count; ++i) {
      const AffineTransform T_scene_instance = placed.T_scene_node * instances.T_node_instance(i);
      const Mat3& linear = T_scene_instance.linear;
      if (!(lengthening(linear) <= kMaxGltfScale) || !T_scene_instance.all_finite()) {
        return instance_out_of_range(element, name, i, instances, T_scene_instance);
      }
      if (is_singular(linear) || lengthening(linear) < kMinGltfScale) {
        ++flat;
      } else {
        add_description(placed, prefix + std::to_string(i), T_scene_instance);
      }
    }
    if (flat > 0) {
      warn(element, name,
           "is instanced; " + std::to_string(flat) + " of its " + std::to_string(instances.count) +
               " instances are left out: their transforms flatten the mesh");
    }
    return std::nullopt;
  }

  static Error instance_out_of_range(const std::string& element, const std::string& name,
                                     std::size_t instance, const GltfInstances& instances,
                                     const AffineTransform& T_scene_instance) {
    const std::string what = "instance " + std::to_string(instance) + " of " + in_quotes(name);
    if (T_scene_instance.linear.allFinite()) {
      if (auto error = check_scale(T_scene_instance.linear, element, what)) return *error;
    }
    const Mat3 own = instances.T_node_instance(instance).linear;
    return gltf_invalid(element, "the transform of " + what + ", of scale " +
                                     gltf_number(lengthening(own)) +
                                     ", with those of its ancestors, overflows");
  }

  // The node's own transform is not used: its mesh is posed in the scene frame.
  std::optional<Error> add_skinned(const PlacedNode& placed) {
    const auto instances = read_instances(asset_, placed.node, kMaxGltfInstances);
    if (!instances) return instances.error();
    if (*instances) {
      return gltf_error(ErrorCode::kUnsupported, gltf_element("nodes", placed.node),
                        "has a skin and EXT_mesh_gpu_instancing; expected only one of them");
    }
    add_description(placed, scene_.tree[placed.tree_node].name, AffineTransform());
    return std::nullopt;
  }

  void add_description(const PlacedNode& placed, std::string name,
                       const AffineTransform& T_scene_mesh) {
    NodeDescription description;
    description.name = std::move(name);
    description.tree_node = placed.tree_node;
    description.linear_scene_mesh = T_scene_mesh.linear;
    description.translation_m = T_scene_mesh.translation_m;
    description.product = T_scene_mesh.product;
    scene_.nodes.push_back(std::move(description));
  }

  // This mesh, or one used before that is equal to it in all that the file says, if meshes that are
  // equal have many triangles together: thousands of meshes may refer to the same accessors.
  std::size_t first_equal(std::size_t mesh) {
    if (const auto known = first_equal_.find(mesh); known != first_equal_.end()) {
      return known->second;
    }
    const auto [other, is_new] = meshes_by_text_.emplace(text_of(asset_.model.meshes[mesh]), mesh);
    if (!is_new && asset_.model.meshes[other->second] == asset_.model.meshes[mesh] &&
        asset_.json["meshes"][other->second] == asset_.json["meshes"][mesh] &&
        (repeated_triangles_ += triangles_[other->second] + kGltfTrianglesPerMesh) >
            kMaxGltfRepeatedTriangles) {
      return first_equal_.emplace(mesh, other->second).first->second;
    }
    return first_equal_.emplace(mesh, mesh).first->second;
  }

  // Differs for almost all meshes that differ; others are read separately.
  static std::string text_of(const tinygltf::Mesh& mesh) {
    std::string text = mesh.name;
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      text += "/" + std::to_string(primitive.material) + "," + std::to_string(primitive.indices);
      for (const auto& [name, accessor] : primitive.attributes) {
        text += "," + name + std::to_string(accessor);
      }
    }
    return text;
  }

  // An error if the mesh, which has been read in another pose, is posed once too often.
  std::optional<Error> check_further_pose(const PosedMesh& posed, std::size_t node) const {
    const auto known = triangles_.find(posed.mesh);
    if (known == triangles_.end() || known->second == 0) return std::nullopt;
    GltfBudget after = budget_;  // the triangles are counted when they are read
    return count_triangles(asset_, known->second + kGltfTrianglesPerMesh,
                           gltf_element("nodes", node),
                           "poses mesh " + std::to_string(posed.mesh) + " once more",
                           posed.skin.has_value() || !posed.morph_weights->empty(), after);
  }

  // Reads the mesh at its first use in this pose, by a node; nothing if it has no triangle.
  Result<std::optional<std::uint32_t>> mesh_index(const PosedMesh& posed, std::size_t node) {
    if (const auto known = meshes_.find(posed); known != meshes_.end()) return known->second;
    if (auto error = check_further_pose(posed, node)) return *error;
    MeshPose pose{*posed.morph_weights, nullptr};
    if (posed.skin) {
      const auto skin = skin_of(*posed.skin);
      if (!skin) return skin.error();
      pose.skin = *skin;
    }
    // All skinned poses of a mesh give the same warnings, which are reported once.
    std::vector<std::string> already_reported;
    const bool is_new = warned_.emplace(posed.mesh, posed.skin.has_value()).second;
    auto mesh = read_mesh(asset_, posed.mesh, pose, *materials_, budget_,
                          is_new ? scene_.warnings : already_reported);
    if (!mesh) return mesh.error();
    std::optional<std::uint32_t> index;
    triangles_[posed.mesh] = mesh->triangles.size();
    if (!mesh->triangles.empty()) {
      index = static_cast<std::uint32_t>(scene_.meshes.size());
      scene_.meshes.push_back(std::move(*mesh));
      skinned_meshes_ += posed.skin ? 1 : 0;
      morphed_meshes_ += posed.morph_weights->empty() ? 0 : 1;
    }
    meshes_.emplace(posed, index);
    return index;
  }

  // The morph weights of a node's mesh; empty if no target has an effect. The weights of a mesh are
  // read only once, because many nodes may share many targets.
  Result<const Weights*> weights_of(std::size_t node) {
    auto own = own_morph_weights(asset_, node, pose_);
    if (!own) return own.error();
    if (*own) {
      if ((*own)->size() > budget_.pose_work) {
        return gltf_error(ErrorCode::kLimitExceeded, gltf_element("nodes", node),
                          "raises the number of morph weights of all nodes above the limit");
      }
      budget_.pose_work -= (*own)->size();
      return kept(std::move(**own));
    }
    const auto mesh = static_cast<std::size_t>(asset_.model.nodes[node].mesh);
    if (const auto known = default_weights_.find(mesh); known != default_weights_.end()) {
      return known->second;
    }
    auto weights = default_morph_weights(asset_, mesh);
    if (!weights) return weights.error();
    return default_weights_.emplace(mesh, kept(std::move(*weights).value_or(Weights())))
        .first->second;
  }

  const Weights* kept(Weights weights) {
    if (std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0.0; })) {
      weights.clear();
    }
    return &*weights_.insert(std::move(weights)).first;
  }

  Result<const GltfSkin*> skin_of(std::size_t skin_id) {
    const auto known = skins_.find(skin_id);
    if (known != skins_.end()) return static_cast<const GltfSkin*>(&known->second);
    auto skin = read_skin(
        asset_, skin_id, kMaxGltfJoints - joint_count_,
        [&](std::size_t node) { return scene_transform(asset_, pose_, *walk_, node); },
        scene_.warnings);
    if (!skin) return skin.error();
    joint_count_ += skin->T_scene_mesh.size();
    return static_cast<const GltfSkin*>(&skins_.emplace(skin_id, std::move(*skin)).first->second);
  }

  // "pose: animation #0 "Walk" at 1.5 s; 2 skinned meshes; 1 morphed mesh"
  void add_notes() {
    std::string pose = scene_.animations.empty() ? "" : pose_text(scene_.animations, scene_.pose);
    const auto add_count = [&](std::size_t count, const char* what) {
      if (count == 0) return;
      if (pose.empty()) pose = pose_text(scene_.animations, scene_.pose);
      pose += "; " + std::to_string(count) + " " + what + (count == 1 ? " mesh" : " meshes");
    };
    add_count(skinned_meshes_, "skinned");
    add_count(morphed_meshes_, "morphed");
    if (!pose.empty()) scene_.notes.push_back("pose: " + pose);
    if (instance_count_ > 0) {
      scene_.notes.push_back("instances: " + std::to_string(instance_count_) + " of meshes");
    }
  }

  void warn(const std::string& element, const std::string& name, const std::string& text) {
    scene_.warnings.push_back(element + ": " + in_quotes(name) + " " + text);
  }

  void shorten_warnings() {
    const std::size_t count = scene_.warnings.size();
    if (count <= kMaxGltfWarnings) return;
    scene_.warnings.resize(kMaxGltfWarnings);
    scene_.warnings.push_back("and " + std::to_string(count - kMaxGltfWarnings) +
                              " further warnings");
  }

  const GltfAsset& asset_;
  const ReadOptions& options_;
  SceneDescription scene_;
  std::size_t first_loss_ = 0;  // index of the first warning that may explain an empty scene
  PalpateExtras extras_;
  GltfBudget budget_{kMaxGltfVertices, kMaxGltfTriangles, kMaxGltfPoseWork, 0, 0};
  std::map<PosedMesh, std::optional<std::uint32_t>> meshes_;
  std::map<std::size_t, std::size_t> first_equal_;     // of meshes, by ids in the file
  std::map<std::size_t, std::size_t> triangles_;       // of meshes, by ids in the file
  std::size_t repeated_triangles_ = 0;                 // of meshes equal to others
  std::map<std::string, std::size_t> meshes_by_text_;  // those that differ
  std::set<Weights> weights_;
  std::map<std::size_t, const Weights*> default_weights_;  // by mesh id in the file
  std::set<std::pair<std::size_t, bool>> warned_;          // meshes read, and whether with a skin
  std::map<std::size_t, GltfSkin> skins_;                  // by id in the file
  GltfPose pose_;
  GltfNodeWalk* walk_ = nullptr;  // both are valid during run()
  GltfMaterials* materials_ = nullptr;
  std::size_t joint_count_ = 0;     // of skins_
  std::size_t instance_count_ = 0;  // including those left out
  std::size_t skinned_meshes_ = 0;
  std::size_t morphed_meshes_ = 0;
};

// The files that the asset names are inputs, also those that nothing reads, such as colours and the
// sounds and lamps of extensions: each string named "uri", wherever it is. Iterative; the stack has
// as many levels as the JSON, at most kMaxGltfJsonDepth.
std::optional<Error> add_referenced_inputs(const Json& root, const std::string& folder) {
  struct Level {
    const Json& value;
    Json::const_iterator next;
  };
  std::vector<Level> levels;
  levels.push_back({root, root.begin()});
  while (!levels.empty()) {
    Level& level = levels.back();
    if (level.next == level.value.end()) {
      levels.pop_back();
      continue;
    }
    const Json& child = *level.next;
    const bool is_uri = child.is_string() && level.value.is_object() && level.next.key() == "uri";
    ++level.next;
    if (is_uri) {
      if (auto error = add_referenced_input(folder, child.get_ref<const std::string&>())) {
        return error;
      }
    } else if (child.is_structured()) {
      levels.push_back({child, child.begin()});
    }
  }
  return std::nullopt;
}

// The nodes are counted before the text is parsed, which takes half of their memory.
std::optional<Error> check_node_count(std::size_t nodes, std::uint64_t file_bytes) {
  const std::size_t most = most_gltf_nodes(file_bytes);
  if (nodes <= most) return std::nullopt;
  return gltf_error(ErrorCode::kLimitExceeded, "/nodes",
                    "has " + std::to_string(nodes) + " elements; at most " + std::to_string(most) +
                        " are read from a file of " + std::to_string(file_bytes) + " bytes",
                    "join small meshes, or divide the scene among several files");
}

std::optional<Error> check_count(std::size_t count, std::size_t most, const std::string& element) {
  if (count <= most) return std::nullopt;
  return gltf_error(
      ErrorCode::kLimitExceeded, element,
      "has " + std::to_string(count) + " elements; at most " + std::to_string(most) + " are read",
      "remove those that are not needed");
}

// As read_gltf_bytes(), but may throw, and Error::path is empty.
Result<SceneDescription> read_asset(const GltfSource& source, const std::string& folder,
                                    const ReadOptions& options, MemoryLedger& ledger) {
  const auto container = find_content(source);
  if (!container) return container.error();
  auto text = source.part(container->json);
  if (!text) return text.error();
  const std::string_view json(reinterpret_cast<const char*>(text->bytes.data()),
                              text->bytes.size());
  const auto scan = scan_json(json);
  if (!scan) return scan.error();
  if (auto error = check_node_count(scan->nodes, source.size())) return *error;
  if (auto error = check_count(scan->scenes, kMaxGltfScenes, "/scenes")) return *error;
  if (auto error = check_count(scan->animations, kMaxGltfAnimations, "/animations")) return *error;
  ledger.begin("parsing the JSON");
  const JsonExtent& extent = scan->extent;
  const MemoryNeed json_need = memory_of_json(parsed_bytes(*scan, json.size()), extent);
  if (auto error = ledger.take(json_need)) return *error;
  expect_available(json_need.peak);
  const MemoryReserve reserve(memory_to_destroy(parsed_bytes(*scan, json.size()), extent));
  std::vector<std::string> warnings;
  if (container->byte_order_mark) {
    warnings.push_back("JSON: begins with a byte order mark, which is ignored");
  }
  auto root = parse_gltf_json(json, *scan, warnings);
  if (!root) return root.error();
  if (auto error = check_asset_version(*root)) return *error;
  if (auto error = add_referenced_inputs(*root, folder)) return *error;
  auto extensions = check_extensions(*root);
  if (!extensions) return extensions.error();
  if (scan->long_data.empty()) {
    source.give_back(*text);
    text->storage = {};
  }
  auto sections = read_model(*root, container->json.length, warnings);
  expect_no_shortage();
  if (!sections) return sections.error();
  ledger.begin("reading the file");
  const std::span<std::uint8_t> own_text(text->storage.data(), text->storage.size());
  GltfBuffers buffers(std::move(sections->buffers), source, container->bin_chunk, folder, &ledger,
                      own_text.empty() ? GltfDataUris(json, scan->long_data)
                                       : GltfDataUris(own_text, scan->long_data));
  if (container->misaligned) {
    warnings.push_back("GLB: the length of a chunk is not a multiple of 4, as it must be");
  }
  GltfMeshoptViews compressed_views(*root, buffers);
  const GltfAsset asset{sections->model, *root, buffers, compressed_views,
                        extensions->mesh_quantization};
  ledger.begin("reading the scene");
  auto scene = SceneReader(asset, options, std::move(warnings), extensions->warnings).run();
  if (scene) scene->files_read = buffers.files_read();
  return scene;
}

// Handles the exceptions that are not caused by lack of memory.
Result<SceneDescription> read_counted(const GltfSource& source, const std::string& folder,
                                      const ReadOptions& options, MemoryLedger& ledger) {
  try {
    return read_asset(source, folder, options, ledger);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::length_error&) {
    throw;
  } catch (const std::system_error&) {
    throw;
  } catch (const std::exception& exception) {
    return gltf_invalid({}, std::string("cannot be read: ") + exception.what());
  }
}

Error with_path(Error error, const std::string& path) {
  error.path = path;
  return error;
}

}  // namespace

Result<SceneDescription> read_gltf_bytes(std::span<const std::uint8_t> bytes,
                                         const std::string& folder, const std::string& name,
                                         const ReadOptions& options) {
  MemoryLedger ledger;
  auto scene = or_out_of_memory(
      ledger, [&] { return read_counted(GltfSource(bytes), folder, options, ledger); });
  if (!scene) return with_path(scene.error(), name);
  scene->path = name;
  return scene;
}

Result<SceneDescription> read_gltf(const std::string& path, const ReadOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  MemoryLedger ledger;
  auto scene = or_out_of_memory(ledger, [&]() -> Result<SceneDescription> {
    ledger = MemoryLedger(options.memory);
    ledger.begin("reading the file");
    const auto file = RegularFile::open(path);
    if (!file) return file.error();
    const GltfSource source(*file, ledger);
    if (file->size() > kMaxGltfFileBytes) {
      // What is no glTF is better told than its size.
      if (const auto content = find_content(source);
          !content && content.error().code == ErrorCode::kNotGltf) {
        return content.error();
      }
      return *file->check_size(kMaxGltfFileBytes);
    }
    return read_counted(source, std::filesystem::path(path).parent_path().string(), options,
                        ledger);
  });
  if (!scene) return with_path(scene.error(), path);
  scene->path = path;
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - start;
  scene->parse_ms = elapsed.count();
  return scene;
}

}  // namespace palpate
