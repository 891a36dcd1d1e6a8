#include "io/gltf_nodes.h"

#include <optional>
#include <string>
#include <utility>

#include "io/gltf_error.h"
#include "io/gltf_limits.h"
#include "io/tinygltf.h"

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
                            "node " + std::to_string(children[c]) + " already is a child of node " +
                                std::to_string(parent) + "; a node has one parent");
      }
      parent = static_cast<int>(i);
    }
  }
  return parents;
}

// With one parent at most for each node, whatever cannot be reached from a root is in or below a
// cycle.
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
      return gltf_invalid(gltf_element("nodes", i), "is its own ancestor, or a descendant of one");
    }
  }
  return std::nullopt;
}

// The nodes at which the scene that is read starts, in file order.
std::vector<int> scene_roots(const tinygltf::Model& model, const std::vector<int>& parents,
                             std::vector<std::string>& warnings) {
  std::vector<int> roots;
  if (model.scenes.empty()) {
    for (std::size_t i = 0; i < parents.size(); ++i) {
      if (parents[i] == kNoParent) roots.push_back(static_cast<int>(i));
    }
    return roots;
  }
  const std::size_t scene =
      model.defaultScene < 0 ? 0 : static_cast<std::size_t>(model.defaultScene);
  for (const int id : model.scenes[scene].nodes) {
    if (const int parent = parents[static_cast<std::size_t>(id)]; parent != kNoParent) {
      warnings.push_back(gltf_element("scenes", scene, "nodes/" + std::to_string(roots.size())) +
                         ": node " + std::to_string(id) + " is a child of node " +
                         std::to_string(parent) +
                         ", as no node of a scene may be; it is read without its parent");
    }
    roots.push_back(id);
  }
  return roots;
}

struct PendingNode {
  std::size_t node = 0;
  std::size_t depth = 1;
  std::optional<std::uint32_t> tree_parent;
  AffineTransform T_scene_parent;
};

// Last in, first out, so the first of the list must be pushed last.
void push_all(const std::vector<int>& nodes, const PendingNode& common,
              std::vector<PendingNode>& pending) {
  for (auto id = nodes.rbegin(); id != nodes.rend(); ++id) {
    pending.push_back(common);
    pending.back().node = static_cast<std::size_t>(*id);
  }
}

Result<PlacedNode> place(const tinygltf::Model& model, const PendingNode& pending) {
  if (pending.depth > kMaxGltfNodeDepth) {
    return gltf_error(ErrorCode::kLimitExceeded, gltf_element("nodes", pending.node),
                      "lies deeper than " + std::to_string(kMaxGltfNodeDepth) + " levels");
  }
  const auto T_parent_node = local_transform(model.nodes[pending.node], pending.node);
  if (!T_parent_node) return T_parent_node.error();
  const PlacedNode placed{pending.node, 0, pending.T_scene_parent * *T_parent_node};
  if (!placed.T_scene_node.all_finite()) {
    return gltf_invalid(gltf_element("nodes", pending.node),
                        "its transform, with those of its ancestors, overflows");
  }
  return placed;
}

}  // namespace

Result<GltfNodeWalk> walk_nodes(const tinygltf::Model& model, std::vector<std::string>& warnings) {
  const auto parents = find_parents(model);
  if (!parents) return parents.error();
  if (auto error = check_cycles(model, *parents)) return *error;

  GltfNodeWalk walk;
  std::vector<bool> visited(model.nodes.size(), false);
  std::vector<PendingNode> pending;
  push_all(scene_roots(model, *parents, warnings), {}, pending);
  while (!pending.empty()) {
    const PendingNode next = std::move(pending.back());
    pending.pop_back();
    if (visited[next.node]) {
      return gltf_invalid(gltf_element("nodes", next.node), "is reached twice in the same scene");
    }
    visited[next.node] = true;
    auto placed = place(model, next);
    if (!placed) return placed.error();
    const tinygltf::Node& node = model.nodes[next.node];
    placed->tree_node = static_cast<std::uint32_t>(walk.tree.size());
    walk.tree.push_back({node.name.empty() ? "node " + std::to_string(next.node) : node.name,
                         static_cast<std::uint32_t>(next.node), next.tree_parent, node.mesh >= 0,
                         placed->T_scene_node.translation_m});
    if (node.mesh >= 0) walk.mesh_nodes.push_back(*placed);
    push_all(node.children, {0, next.depth + 1, placed->tree_node, placed->T_scene_node}, pending);
  }
  return walk;
}

}  // namespace palpate
