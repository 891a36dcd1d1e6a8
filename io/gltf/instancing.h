#pragma once

// EXT_mesh_gpu_instancing: one node that stands for many copies of its mesh.

#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/transform.h"

namespace palpate {

// The frames of the instances in that of their node; a list that the file does not give is empty.
struct GltfInstances {
  std::size_t count = 0;
  std::vector<double> translations_m;  // 3 each
  std::vector<double> rotations;       // 4 each, unit quaternions x, y, z, w
  std::vector<double> scales;          // 3 each

  // translation * rotation * scale of one below count.
  AffineTransform T_node_instance(std::size_t index) const;
};

// Nothing if the node is not instanced. Attributes other than TRANSLATION, ROTATION and SCALE do
// not move anything and are not looked at. Refused: none of the three, different counts, more than
// max_count (kLimitExceeded), a list without bufferView, a rotation that is no unit quaternion.
Result<std::optional<GltfInstances>> read_instances(const GltfAsset& asset, std::size_t node,
                                                    std::size_t max_count);

}  // namespace palpate
