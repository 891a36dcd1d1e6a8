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

// Joint i takes a point of the mesh frame to T_scene_mesh[i] * point.
struct GltfSkin {
  std::size_t id = 0;  // in the file
  std::vector<AffineTransform> T_scene_mesh;
};

// place: the transform of a node to the scene. Refused: ids out of range, no joint, more than
// max_joints (kLimitExceeded), fewer inverse bind matrices than joints, one that is not affine, a
// scale beyond kMaxGltfScale (kLimitExceeded). Without inverse bind matrices they are the identity.
// A node that is more than one joint, which glTF forbids, is a warning; it is each of them.
Result<GltfSkin> read_skin(const GltfAsset& asset, std::size_t skin, std::size_t max_joints,
                           const std::function<Result<AffineTransform>(std::size_t)>& place,
                           std::vector<std::string>& warnings);

class DracoPrimitive;

// Moves the positions of a primitive from the mesh frame into the scene frame: the mean of where
// its joints take a vertex, by all sets JOINTS_n and WEIGHTS_n. Weights are divided by their sum;
// if a sum is farther from 1 than its type's rounding explains, that is a warning. Refused: a
// missing set, sets of another length than the positions, negative weights, a joint with a weight
// that the skin does not have. Joints whose weight is 0 are not looked at. Vertices without any
// weight move with the first joint, which is a warning. Takes from pose_work, a budget, the numbers
// of each set. element: of the primitive. compressed: the primitive as it was decoded, if it is
// compressed, else null.
std::optional<Error> apply_skin(const GltfAsset& asset, const tinygltf::Primitive& primitive,
                                const DracoPrimitive* compressed, const std::string& element,
                                const GltfSkin& skin, std::size_t& pose_work,
                                std::span<Vec3> positions, std::vector<std::string>& warnings);

}  // namespace palpate
