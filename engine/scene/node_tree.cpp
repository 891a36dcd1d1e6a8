#include "engine/scene/node_tree.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "geometry/base/printable.h"
#include "io/hidden_nodes.h"

namespace palpate {
namespace {

// "#7" -> 7
std::optional<std::uint32_t> file_index(const std::string& name) {
  if (name.size() < 2 || name.front() != '#') return std::nullopt;
  std::uint32_t index = 0;
  const char* end = name.data() + name.size();
  const auto [rest, failed] = std::from_chars(name.data() + 1, end, index);
  if (failed != std::errc() || rest != end) return std::nullopt;
  return index;
}

Error no_such_node(const std::string& name, std::string problem, std::string hint) {
  return {ErrorCode::kInvalidArgument, "", "node \"" + name + "\"", std::move(problem),
          std::move(hint)};
}

}  // namespace

Result<std::uint32_t> find_node(std::span<const TreeNode> tree, const std::string& name) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t n = 0; n < tree.size(); ++n) {
    if (tree[n].name == name) found.push_back(n);
  }
  if (found.empty()) {
    const auto index = file_index(name);
    for (std::uint32_t n = 0; index && n < tree.size(); ++n) {
      if (tree[n].file_index == *index) found.push_back(n);
    }
  }
  if (found.empty()) {
    return no_such_node(name,
                        "is not among the " + std::to_string(tree.size()) + " nodes of the scene",
                        "`Scene::tree` lists the nodes");
  }
  if (found.size() > 1) {
    return no_such_node(name, "is the name of " + std::to_string(found.size()) + " nodes",
                        "name the node by its number in the file: \"#" +
                            std::to_string(tree[found.front()].file_index) + "\" is the first one");
  }
  return found.front();
}

std::uint32_t end_of_subtree(std::span<const TreeNode> tree, std::uint32_t node) {
  std::uint32_t end = node + 1;
  while (end < tree.size() && tree[end].parent && *tree[end].parent >= node) ++end;
  return end;
}

void keep_subtree(SceneDescription& description, std::uint32_t node) {
  const std::uint32_t end = end_of_subtree(description.tree, node);
  const auto is_outside = [&](const auto& n) { return n.tree_node < node || n.tree_node >= end; };
  std::erase_if(description.nodes, is_outside);
  std::erase_if(description.regions, is_outside);
  std::erase_if(description.contours, is_outside);
  for (NodeDescription& n : description.nodes) n.tree_node -= node;
  for (RegionDescription& r : description.regions) r.tree_node -= node;
  for (ContourDescription& c : description.contours) c.tree_node -= node;
  auto& tree = description.tree;
  tree.erase(tree.begin() + end, tree.end());
  tree.erase(tree.begin(), tree.begin() + node);
  tree.front().parent.reset();
  for (TreeNode& n : tree) {
    if (n.parent) *n.parent -= node;
  }
  description.hidden_nodes = hidden_nodes_of(tree);
}

std::string tree_text(std::span<const TreeNode> tree) {
  std::string text;
  std::vector<std::size_t> depths;
  for (const TreeNode& node : tree) {
    depths.push_back(node.parent ? depths[*node.parent] + 1 : 0);
    text += std::string(2 + 2 * depths.back(), ' ') + printable(node.name) + "  #" +
            std::to_string(node.file_index) + (node.has_mesh ? "  mesh" : "") +
            (node.is_hidden ? "  hidden" : "") + "\n";
  }
  return text;
}

}  // namespace palpate
