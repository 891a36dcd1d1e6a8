#pragma once

// The nodes of a scene that are not read, because the file hides them.

#include <span>
#include <string>

#include "io/scene_description.h"

namespace palpate {

// Those with a mesh among the nodes of a tree. Thread-safe, like hidden_nodes_text().
HiddenNodes hidden_nodes_of(std::span<const TreeNode> tree);

// "2 nodes with a mesh are hidden in the file (KHR_node_visibility) and cannot be felt: "a", "b";
// ..."; empty if there are none. The text names a field of settings, as Error does.
std::string hidden_nodes_text(const HiddenNodes& hidden);

}  // namespace palpate
