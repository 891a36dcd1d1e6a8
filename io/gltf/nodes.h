#pragma once

// The node hierarchy of the scene that is read: the default scene, else the first, else all roots.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/animation.h"
#include "io/gltf/transform.h"
#include "io/scene_description.h"

namespace palpate {

struct PlacedNode {
  std::size_t node = 0;          // in the file
  std::uint32_t tree_node = 0;   // index into GltfNodeWalk::tree
  AffineTransform T_scene_node;  // the product of the ancestors; finite
};

struct GltfNodeWalk {
  std::vector<PlacedNode> mesh_nodes;  // those that carry a mesh, depth first in file order
  std::vector<TreeNode> tree;          // all nodes of the scene, depth first in file order

  std::optional<std::size_t> scene;         // in /scenes; none: all roots
  std::vector<PlacedNode> declaring_nodes;  // those with extras.palpate, depth first

  std::vector<int> parents;  // of all nodes of the file; below 0: none
  // By node of the file, for scene_transform(): those of the scene if the file has skins.
  std::vector<std::optional<AffineTransform>> T_scene_nodes;
};

// Nodes lie where the pose puts them. The ids in the model must be within range (see
// gltf/schema.h). Refused: a node with two parents, a cycle, a node that the scene reaches twice,
// nodes deeper than kMaxGltfNodeDepth, a broken or overflowing transform. A scene that starts at a
// child, leaving its parent out, is read from there on, with a warning. Iterative, each node is
// visited once. Thread-safe.
Result<GltfNodeWalk> walk_nodes(const GltfAsset& asset, const GltfPose& pose,
                                std::vector<std::string>& warnings);

// Where a joint lies: as walked or, if the scene does not reach it, by its own ancestors, which are
// remembered in the walk. Iterative, each node is placed once.
Result<AffineTransform> scene_transform(const GltfAsset& asset, const GltfPose& pose,
                                        GltfNodeWalk& walk, std::size_t node);

}  // namespace palpate
