#pragma once

// Finds nodes by name, and handles the subtrees below them.

#include <cstdint>
#include <span>
#include <string>

#include "geometry/base/result.h"
#include "io/scene_description.h"

namespace palpate {

// Returns the index of the node with this name. Because names may repeat, `name` may also be the
// number of a node in the file, such as "#7". Error::element contains `name`. Thread-safe.
Result<std::uint32_t> find_node(std::span<const TreeNode> tree, const std::string& name);

// The tree is in depth-first order, so that [node, end_of_subtree) is the subtree of a node.
std::uint32_t end_of_subtree(std::span<const TreeNode> tree, std::uint32_t node);

// Removes all nodes except the subtree of one node. That node keeps its pose in the scene.
void keep_subtree(SceneDescription& description, std::uint32_t node);

// The tree as text. Each node has one line, indented by its depth: name, number, "mesh" if the node
// has a mesh, and "hidden" if it is hidden and not read.
std::string tree_text(std::span<const TreeNode> tree);

}  // namespace palpate
