#pragma once

// The transform of one glTF node.

#include <cstddef>
#include <string>

#include "geometry/result.h"
#include "geometry/types.h"

namespace tinygltf {
class Node;
}

namespace palpate {

// p_to = linear * p_from + translation_m
struct AffineTransform {
  Mat3 linear = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();

  // First inner, then this. May overflow: the caller checks.
  AffineTransform operator*(const AffineTransform& inner) const {
    return {linear * inner.linear, linear * inner.translation_m + translation_m};
  }
  bool all_finite() const { return linear.allFinite() && translation_m.allFinite(); }
};

// How far the length of a rotation may be from 1. Files round quaternions to few digits, some to
// signed bytes, whose half step is 1/256 per component; the length is divided out. Beyond that it
// is no unit quaternion, as glTF demands, and refused.
inline constexpr double kRotationLengthTolerance = 1.0 / 128.0;

// Node frame to the frame of its parent (glTF 2.0, section 3.5.3): matrix, or translation *
// rotation * scale. The matrix must be affine: its last row 0 0 0 1. Without rotation the linear
// part is exactly the scale of the file. node_id: for messages.
Result<AffineTransform> local_transform(const tinygltf::Node& node, std::size_t node_id);

// True iff the matrix has no inverse in double precision: with rows, then columns scaled to length
// 1, its smallest singular value is rounding noise beside the largest.
bool is_singular(const Mat3& linear);

}  // namespace palpate
