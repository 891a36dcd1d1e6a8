#include "io/hidden_nodes.h"

#include "geometry/base/quoted.h"

namespace palpate {

HiddenNodes hidden_nodes_of(std::span<const TreeNode> tree) {
  HiddenNodes hidden;
  for (const TreeNode& node : tree) {
    if (!node.is_hidden || !node.has_mesh) continue;
    if (hidden.count++ < kMostHiddenNames) hidden.first_names.push_back(node.name);
  }
  return hidden;
}

std::string hidden_nodes_text(const HiddenNodes& hidden) {
  if (hidden.count == 0) return {};
  std::string names;
  for (const std::string& name : hidden.first_names) {
    names += (names.empty() ? "" : ", ") + in_quotes(name);
  }
  if (const std::size_t others = hidden.count - hidden.first_names.size(); others > 0) {
    names += " and " + std::to_string(others) + " more";
  }
  return std::to_string(hidden.count) +
         (hidden.count == 1 ? " node with a mesh is" : " nodes with a mesh are") +
         " hidden in the file (KHR_node_visibility) and cannot be felt: " + names +
         "; `SceneSettings::feels_hidden` loads hidden nodes, too";
}

}  // namespace palpate
