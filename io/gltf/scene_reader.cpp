#include "io/gltf/scene_reader.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/gltf/animation.h"
#include "io/gltf/contours.h"
#include "io/gltf/error.h"
#include "io/gltf/extras.h"
#include "io/gltf/images.h"
#include "io/gltf/instancing.h"
#include "io/gltf/limits.h"
#include "io/gltf/materials.h"
#include "io/gltf/nodes.h"
#include "io/gltf/physics_materials.h"
#include "io/gltf/posed_meshes.h"
#include "io/gltf/tinygltf.h"
#include "io/gltf/unapplied_extras.h"
#include "io/hidden_nodes.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// The largest number of bytes of a node's name that its instances repeat.
constexpr std::size_t kMaxInstanceName = 32;

// The name, cut between UTF-8 characters.
std::string instance_name(const std::string& name) {
  if (name.size() <= kMaxInstanceName) return name;
  std::size_t end = kMaxInstanceName;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0u) == 0x80u) --end;
  return name.substr(0, end) + "...";
}

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
    std::size_t pose_work = kMaxGltfPoseWork;
    auto pose = GltfPose::choose(asset_, options_.pose, pose_work, scene_.warnings);
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
    PosedMeshes meshes(asset_, pose_, pose_work, *walk, *materials, scene_);
    scene_.nodes.reserve(walk->mesh_nodes.size());
    for (const PlacedNode& placed : walk->mesh_nodes) {
      if (auto error = add_node(placed, meshes)) return *error;
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
    add_notes(meshes);
    shorten_warnings();
    if (options_.key_names) {
      scene_.unapplied_extras = unapplied_extras(asset_, applied_elements(), *options_.key_names);
    }
    return std::move(scene_);
  }

 private:
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

  std::optional<Error> add_node(const PlacedNode& placed, PosedMeshes& meshes) {
    const tinygltf::Node& node = asset_.model.nodes[placed.node];
    const std::size_t first = scene_.nodes.size();
    if (auto error = node.skin < 0 ? add_placed(placed) : add_skinned(placed)) return error;
    if (scene_.nodes.size() == first) return std::nullopt;
    const auto mesh = meshes.mesh_of(placed.node);
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
    const std::string prefix = instance_name(name) + " #";
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

  // "pose: animation #0 "Walk" at 1.5 s; 2 skinned meshes; 1 morphed mesh"
  void add_notes(const PosedMeshes& meshes) {
    std::string pose = scene_.animations.empty() ? "" : pose_text(scene_.animations, scene_.pose);
    const auto add_count = [&](std::size_t count, const char* what) {
      if (count == 0) return;
      if (pose.empty()) pose = pose_text(scene_.animations, scene_.pose);
      pose += "; " + std::to_string(count) + " " + what + (count == 1 ? " mesh" : " meshes");
    };
    add_count(meshes.skinned_count(), "skinned");
    add_count(meshes.morphed_count(), "morphed");
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
  GltfPose pose_;
  GltfNodeWalk* walk_ = nullptr;  // both are valid during run()
  GltfMaterials* materials_ = nullptr;
  std::size_t instance_count_ = 0;  // including those left out
};

}  // namespace

Result<SceneDescription> read_scene(const GltfAsset& asset, const ReadOptions& options,
                                    std::vector<std::string> of_text,
                                    const std::vector<std::string>& of_extensions) {
  return SceneReader(asset, options, std::move(of_text), of_extensions).run();
}

}  // namespace palpate
