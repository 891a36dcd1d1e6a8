#pragma once

// EXT_mesh_gpu_instancing: one node represents many copies of its mesh.

#include <cstddef>
#include <optional>
#include <vector>

#include "geometry/base/result.h"
#include "io/gltf/accessor.h"
#include "io/gltf/transform.h"

namespace palpate {

// The transforms of the instances relative to their node. A list that the file omits is empty here.
struct GltfInstances {
  std::size_t count = 0;
  std::vector<double> translations_m;  // 3 numbers per instance
  std::vector<double> rotations;       // 4 per instance: a unit quaternion x, y, z, w
  std::vector<double> scales;          // 3 per instance

  // translation * rotation * scale of an instance; index < count.
  AffineTransform T_node_instance(std::size_t index) const;
};

// The instances of a node; no value if the node is not instanced. Attributes other than
// TRANSLATION, ROTATION and SCALE are ignored. Errors: none of these three is present, their counts
// differ or exceed max_count (kLimitExceeded), a list has no bufferView, or a rotation is not a
// unit quaternion.
Result<std::optional<GltfInstances>> read_instances(const GltfAsset& asset, std::size_t node,
                                                    std::size_t max_count);

}  // namespace palpate
