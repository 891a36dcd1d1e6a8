#pragma once

// Skins: vertices that move with the nodes of a skeleton (glTF 2.0, sections 3.7.3 and 5.28).

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "io/gltf/accessor.h"
#include "io/gltf/transform.h"

namespace tinygltf {
struct Primitive;
}

namespace palpate {

// Joint i moves a point of the mesh frame to T_scene_mesh[i] * point.
struct GltfSkin {
  std::size_t id = 0;  // index in the file
  std::vector<AffineTransform> T_scene_mesh;
};

// place: returns the transform of a node to the scene. Errors: ids out of range, no joint, more
// than max_joints (kLimitExceeded), fewer inverse bind matrices than joints, a matrix that is not
// affine, a scale above kMaxGltfScale (kLimitExceeded). Absent inverse bind matrices are the
// identity. A node that is listed as several joints, which glTF forbids, causes a warning; each of
// the joints is used.
Result<GltfSkin> read_skin(const GltfAsset& asset, std::size_t skin, std::size_t max_joints,
                           const std::function<Result<AffineTransform>(std::size_t)>& place,
                           std::vector<std::string>& warnings);

class DracoPrimitive;

// Moves the positions of a primitive from the mesh frame to the scene frame: each vertex becomes
// the weighted mean of its positions under its joints, over all sets JOINTS_n and WEIGHTS_n.
// Weights are divided by their sum. If the sum differs from 1 by more than the rounding of the
// weights' type, there is a warning. Errors: a missing set, sets whose length differs from that of
// the positions, negative weights, a joint with non-zero weight that the skin does not have. Joints
// of weight 0 are ignored. Vertices without any weight move with the first joint, and there is a
// warning. pose_work: a budget, from which the number of values of each set is subtracted. element:
// JSON path of the primitive. compressed: the decoded primitive if it is compressed, else null.
std::optional<Error> apply_skin(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                const DracoPrimitive* compressed, const std::string& element,
                                const GltfSkin& skin, std::size_t& pose_work,
                                std::span<Vec3> positions, std::vector<std::string>& warnings);

}  // namespace palpate
