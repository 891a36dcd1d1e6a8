#pragma once

// The node hierarchy of the scene that is read: the default scene, else the first, else all roots.

#include <cstddef>
#include <string>
#include <vector>

#include "geometry/result.h"
#include "io/gltf_transform.h"
#include "io/scene_description.h"

namespace tinygltf {
class Model;
}

namespace palpate {

struct PlacedNode {
  std::size_t node = 0;          // in the file
  std::uint32_t tree_node = 0;   // index into GltfNodeWalk::tree
  AffineTransform T_scene_node;  // the product of the ancestors; finite
};

struct GltfNodeWalk {
  std::vector<PlacedNode> mesh_nodes;  // those that carry a mesh, depth first in file order
  std::vector<TreeNode> tree;          // all nodes of the scene, depth first in file order
};

// The ids in the model must be within range (see gltf_schema.h). Refused: a node with two parents,
// a cycle, a node that the scene reaches twice, nodes deeper than kMaxGltfNodeDepth, a broken or
// overflowing transform. A scene that starts at a child, leaving its parent out, is read from there
// on, with a warning. Iterative, each node is visited once. Thread-safe.
Result<GltfNodeWalk> walk_nodes(const tinygltf::Model& model, std::vector<std::string>& warnings);

}  // namespace palpate
