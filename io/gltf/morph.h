#pragma once

// Morph targets (glTF 2.0, section 3.7.2.2).

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "io/gltf/accessor.h"
#include "io/gltf/animation.h"

namespace tinygltf {
struct Primitive;
}

namespace palpate {

// The number of morph targets of a mesh. It is read from the first primitive; all primitives must
// have the same number.
std::size_t morph_target_count(const GltfAsset& asset, std::size_t mesh);

// The morph weights of a node: the weights of the pose, else those of the node; no value if neither
// has weights. Returns an error unless there is one weight for each target. The node must have a
// mesh.
Result<std::optional<std::vector<double>>> own_morph_weights(const GltfAsset& asset,
                                                             std::size_t node,
                                                             const GltfPose& pose);

// The weights that a mesh declares for nodes without weights of their own; no value if it declares
// none.
Result<std::optional<std::vector<double>>> default_morph_weights(const GltfAsset& asset,
                                                                 std::size_t mesh);

// Adds weight times POSITION of each target to the positions of a primitive; targets of weight 0
// are not decoded. The accessors of the targets contain one element for each position: floats or,
// with KHR_mesh_quantization, signed integers of 8 or 16 bits. pose_work: a budget, from which the
// number of decoded elements is subtracted. element: JSON path of the primitive.
std::optional<Error> add_morph_targets(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                       const std::string& element, std::span<const double> weights,
                                       std::size_t& pose_work, std::span<Vec3> positions);

}  // namespace palpate
