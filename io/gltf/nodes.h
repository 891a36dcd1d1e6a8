#pragma once

// The node hierarchy of one scene of the file.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/animation.h"
#include "io/gltf/scene_choice.h"
#include "io/gltf/transform.h"
#include "io/scene_description.h"

namespace palpate {

struct PlacedNode {
  std::size_t node = 0;          // index in the file
  std::uint32_t tree_node = 0;   // index into GltfNodeWalk::tree
  AffineTransform T_scene_node;  // product over the node and its ancestors; finite
};

// Hidden nodes are in the tree only, unless the choice reads them.
struct GltfNodeWalk {
  std::vector<PlacedNode> mesh_nodes;  // nodes with a mesh, depth first in file order
  std::vector<TreeNode> tree;          // all nodes of the scene, depth first in file order

  std::optional<std::size_t> scene;         // index into /scenes; absent: all roots
  std::vector<PlacedNode> declaring_nodes;  // nodes with extras.palpate, depth first
  std::vector<PlacedNode> contour_nodes;    // nodes with extras.palpate_contour, depth first

  std::vector<int> parents;  // of all nodes of the file; negative: no parent
  // For scene_transform(). If the file has skins, there is one entry for each node of the file, and
  // the entries of the scene's nodes are set.
  std::vector<std::optional<AffineTransform>> T_scene_nodes;
};

// Traverses the nodes with the transforms of the pose. The ids in the model must be within range
// (see gltf/schema.h). Errors: those of choose_scene() and is_hidden(), a node with two parents, a
// cycle, a node that the scene reaches twice, nodes deeper than kMaxGltfNodeDepth, more contours
// than kMaxGltfContours, an invalid or overflowing transform. If a root of the scene has a parent,
// the parent is ignored, with a warning. Iterative; each node is visited once. Thread-safe.
Result<GltfNodeWalk> walk_nodes(const GltfAsset& asset, const GltfPose& pose,
                                const GltfSceneChoice& choice, std::vector<std::string>& warnings);

// The transform of a node, in particular a joint, to the scene frame. If the walk has not reached
// the node, the product over its ancestors is computed and stored in the walk. Iterative; the
// transform of each node is computed once.
Result<AffineTransform> scene_transform(const GltfAsset& asset, const GltfPose& pose,
                                        GltfNodeWalk& walk, std::size_t node);

}  // namespace palpate
