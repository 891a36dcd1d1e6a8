#pragma once

// Nodes by the names that users give them, and what is below them.

#include <cstdint>
#include <span>
#include <string>

#include "geometry/base/result.h"
#include "io/scene_description.h"

namespace palpate {

// The index of the node that is meant: by its name, or, as names may repeat, by "#7", its number in
// the file. Error::element is what was asked for. Thread-safe.
Result<std::uint32_t> find_node(std::span<const TreeNode> tree, const std::string& name);

// The tree is in depth-first order: a node and all below it are [node, end_of_subtree).
std::uint32_t end_of_subtree(std::span<const TreeNode> tree, std::uint32_t node);

// Leaves only a node and what is below it. The node keeps its place in the scene.
void keep_subtree(SceneDescription& description, std::uint32_t node);

// The tree as text, a line each, indented by depth: number, name, whether it has a mesh.
std::string tree_text(std::span<const TreeNode> tree);

}  // namespace palpate
