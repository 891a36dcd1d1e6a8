#include "io/gltf/nodes.h"

#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/extras.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

constexpr int kNoParent = -1;

// The parent of every node.
Result<std::vector<int>> find_parents(const tinygltf::Model& model) {
  std::vector<int> parents(model.nodes.size(), kNoParent);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const auto& children = model.nodes[i].children;
    for (std::size_t c = 0; c < children.size(); ++c) {
      int& parent = parents[static_cast<std::size_t>(children[c])];
      if (parent != kNoParent) {
        return gltf_invalid(gltf_element("nodes", i, "children/" + std::to_string(c)),
                            "node " + std::to_string(children[c]) + " is already a child of node " +
                                std::to_string(parent) + "; a node has one parent");
      }
      parent = static_cast<int>(i);
    }
  }
  return parents;
}

// Every node has at most one parent, so a node that no root reaches is in or below a cycle.
std::optional<Error> check_cycles(const tinygltf::Model& model, const std::vector<int>& parents) {
  std::vector<bool> reached(parents.size(), false);
  std::vector<int> pending;
  for (std::size_t i = 0; i < parents.size(); ++i) {
    if (parents[i] == kNoParent) pending.push_back(static_cast<int>(i));
  }
  while (!pending.empty()) {
    const auto node = static_cast<std::size_t>(pending.back());
    pending.pop_back();
    reached[node] = true;
    const auto& children = model.nodes[node].children;
    pending.insert(pending.end(), children.begin(), children.end());
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (!reached[i]) {
      return gltf_invalid(gltf_element("nodes", i),
                          "is its own ancestor, or a descendant of such a node");
    }
  }
  return std::nullopt;
}

// The root nodes of the scene, in file order.
std::vector<int> scene_roots(const tinygltf::Model& model, std::optional<std::size_t> scene,
                             const std::vector<int>& parents, std::vector<std::string>& warnings) {
  std::vector<int> roots;
  if (!scene) {
    for (std::size_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == kNoParent) roots.push_back(static_cast<int>(i));
    }
    return roots;
  }
  for (const int id : model.scenes[*scene].nodes) {
    if (const int parent = parents[static_cast<std::size_t>(id)]; parent != kNoParent) {
      warnings.push_back(
          gltf_element("scenes", *scene, "nodes/" + std::to_string(roots.size())) + ": node " +
          std::to_string(id) + " is a child of node " + std::to_string(parent) +
          ", but a root of a scene must not have a parent; it is read without its parent");
    }
    roots.push_back(id);
  }
  return roots;
}

struct PendingNode {
  std::size_t node = 0;
  std::size_t depth = 1;
  bool is_hidden = false;  // an ancestor is hidden
  std::optional<std::uint32_t> tree_parent;
  AffineTransform T_scene_parent;
};

// The stack is last in, first out, so the first node of the list is pushed last.
void push_all(const std::vector<int>& nodes, const PendingNode& common,
              std::vector<PendingNode>& pending) {
  for (auto id = nodes.rbegin(); id != nodes.rend(); ++id) {
    pending.push_back(common);
    pending.back().node = static_cast<std::size_t>(*id);
  }
}

// The error for an overflow of the product of a node's transform with that of its ancestors.
Error overflow_of(const tinygltf::Node& node, std::size_t node_id,
                  const AffineTransform& T_scene_parent, const AffineTransform& T_parent_node) {
  const std::string inherited = gltf_number(lengthening(T_scene_parent.linear));
  const std::string cause =
      (T_scene_parent.linear * T_parent_node.linear).allFinite()
          ? "its translation of " + gltf_number(T_parent_node.translation_m.cwiseAbs().maxCoeff()) +
                " m, scaled by its ancestors by " + inherited + ", overflows"
          : "its scale of " + gltf_number(T_parent_node.linear.cwiseAbs().maxCoeff()) +
                ", times that of its ancestors, " + inherited + ", overflows";
  const std::string named = node.name.empty() ? "" : in_quotes(node.name) + ": ";
  return gltf_invalid(gltf_element("nodes", node_id), named + cause);
}

// The transform to the scene of a node whose parent's transform is known.
Result<AffineTransform> place(const GltfAsset& asset, const GltfPose& pose,
                              const AffineTransform& T_scene_parent, std::size_t node) {
  const auto T_parent_node = local_transform(asset.model.nodes[node], node, pose.pose_of(node));
  if (!T_parent_node) return T_parent_node.error();
  const AffineTransform T_scene_node = T_scene_parent * *T_parent_node;
  if (!T_scene_node.all_finite()) {
    return overflow_of(asset.model.nodes[node], node, T_scene_parent, *T_parent_node);
  }
  return T_scene_node;
}

std::optional<Error> check_visit(const PendingNode& next, const std::vector<bool>& visited) {
  if (visited[next.node]) {
    return gltf_invalid(gltf_element("nodes", next.node), "is reached twice in the same scene");
  }
  if (next.depth > kMaxGltfNodeDepth) {
    return gltf_error(ErrorCode::kLimitExceeded, gltf_element("nodes", next.node),
                      "lies deeper than " + std::to_string(kMaxGltfNodeDepth) + " levels");
  }
  return std::nullopt;
}

// Adds the node to the lists of the members that its extras have.
std::optional<Error> list_by_extras(const nlohmann::json& extras, const PlacedNode& placed,
                                    GltfNodeWalk& walk) {
  if (extras.contains("palpate")) walk.declaring_nodes.push_back(placed);
  if (!extras.contains("palpate_contour")) return std::nullopt;
  if (walk.contour_nodes.size() == kMaxGltfContours) {
    return gltf_error(ErrorCode::kLimitExceeded,
                      gltf_element("nodes", placed.node, "extras/palpate_contour"),
                      "raises the number of contours of the scene to more than " +
                          std::to_string(kMaxGltfContours) + ", the limit");
  }
  walk.contour_nodes.push_back(placed);
  return std::nullopt;
}

// Adds a visible node to the lists of what it has.
std::optional<Error> list_node(const nlohmann::json& object, const PlacedNode& placed,
                               const tinygltf::Node& node, GltfNodeWalk& walk) {
  if (node.mesh >= 0) walk.mesh_nodes.push_back(placed);
  const auto* extras = find_extras(object);
  return extras ? list_by_extras(*extras, placed, walk) : std::nullopt;
}

}  // namespace

Result<GltfNodeWalk> walk_nodes(const GltfAsset& asset, const GltfPose& pose,
                                const GltfSceneChoice& choice, std::vector<std::string>& warnings) {
  const tinygltf::Model& model = asset.model;
  auto parents = find_parents(model);
  if (!parents) return parents.error();
  if (auto error = check_cycles(model, *parents)) return *error;

  GltfNodeWalk walk;
  const auto scene = choose_scene(model, choice.scene);
  if (!scene) return scene.error();
  walk.scene = *scene;
  const bool has_skins = asset.json.contains("skins");
  if (has_skins) walk.T_scene_nodes.resize(model.nodes.size());
  walk.tree.reserve(model.nodes.size());
  walk.mesh_nodes.reserve(model.nodes.size());
  std::vector<bool> visited(model.nodes.size(), false);
  std::vector<PendingNode> pending;
  push_all(scene_roots(model, walk.scene, *parents, warnings), {}, pending);
  while (!pending.empty()) {
    const PendingNode next = std::move(pending.back());
    pending.pop_back();
    if (auto error = check_visit(next, visited)) return *error;
    visited[next.node] = true;
    const auto T_scene_node = place(asset, pose, next.T_scene_parent, next.node);
    if (!T_scene_node) return T_scene_node.error();
    const tinygltf::Node& node = model.nodes[next.node];
    const nlohmann::json& object = asset.json["nodes"][next.node];
    bool hidden = next.is_hidden;
    if (!hidden && !choice.feels_hidden) {
      const auto own = is_hidden(object, next.node);
      if (!own) return own.error();
      hidden = *own;
    }
    const auto tree_node = static_cast<std::uint32_t>(walk.tree.size());
    walk.tree.push_back({node.name.empty() ? "node " + std::to_string(next.node) : node.name,
                         static_cast<std::uint32_t>(next.node), next.tree_parent, node.mesh >= 0,
                         T_scene_node->translation_m, hidden});
    if (!hidden) {
      const PlacedNode placed{next.node, tree_node, *T_scene_node};
      if (auto error = list_node(object, placed, node, walk)) return *error;
    }
    if (has_skins) walk.T_scene_nodes[next.node] = *T_scene_node;
    push_all(node.children, {0, next.depth + 1, hidden, tree_node, *T_scene_node}, pending);
  }
  walk.parents = std::move(*parents);
  return walk;
}

Result<AffineTransform> scene_transform(const GltfAsset& asset, const GltfPose& pose,
                                        GltfNodeWalk& walk, std::size_t node) {
  std::vector<std::size_t> unplaced;
  for (int id = static_cast<int>(node);
       id >= 0 && !walk.T_scene_nodes[static_cast<std::size_t>(id)];
       id = walk.parents[static_cast<std::size_t>(id)]) {
    unplaced.push_back(static_cast<std::size_t>(id));
  }
  for (auto id = unplaced.rbegin(); id != unplaced.rend(); ++id) {
    const int parent = walk.parents[*id];
    const auto placed = place(
        asset, pose,
        parent < 0 ? AffineTransform() : *walk.T_scene_nodes[static_cast<std::size_t>(parent)],
        *id);
    if (!placed) return placed.error();
    walk.T_scene_nodes[*id] = *placed;
  }
  return *walk.T_scene_nodes[node];
}

}  // namespace palpate
