#pragma once

// The transform of one glTF node.

#include <cstddef>
#include <limits>
#include <optional>
#include <string>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "io/transform_product.h"

namespace tinygltf {
class Node;
}

namespace palpate {

// p_to = linear * p_from + translation_m
struct AffineTransform {
  Mat3 linear = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
  TransformProduct product = {};  // that the two are

  // As a file gives it.
  static AffineTransform given(const Mat3& linear, const Vec3& translation_m) {
    return {linear, translation_m, TransformProduct::of(linear, translation_m)};
  }
  // First inner, then this. May overflow: the caller checks.
  AffineTransform operator*(const AffineTransform& inner) const {
    return {linear * inner.linear, linear * inner.translation_m + translation_m,
            product * inner.product};
  }
  bool all_finite() const { return linear.allFinite() && translation_m.allFinite(); }
};

// How far the last row of a matrix may be from 0 0 0 1. Exporters invert and multiply matrices of
// floats, each entry four products, and do not write the row that they know. It is taken as that.
inline constexpr double kAffineRowTolerance = 16.0 * std::numeric_limits<float>::epsilon();

// How far the length of a rotation may be from 1. Files round quaternions to few digits, some to
// signed bytes, whose half step is 1/256 per component; the length is divided out. Beyond that it
// is no unit quaternion, as glTF demands, and refused.
inline constexpr double kRotationLengthTolerance = 1.0 / 128.0;

// The error if this is no unit quaternion. element: for the message.
std::optional<Error> check_rotation(const Eigen::Vector4d& rotation, const std::string& element);

// What a file may say of a transform.
struct GltfTrs {
  std::optional<Vec3> translation_m;
  std::optional<Eigen::Vector4d> rotation;  // quaternion x, y, z, w; checked
  std::optional<Vec3> scale;
};

// translation * rotation * scale. Without rotation the linear part is exactly the scale.
AffineTransform transform_of(const GltfTrs& trs);

// Node frame to the frame of its parent (glTF 2.0, section 3.5.3): matrix, or translation *
// rotation * scale, each of them replaced by that of the pose if it has one. The matrix must be
// affine, to within kAffineRowTolerance. node_id: for messages.
Result<AffineTransform> local_transform(const tinygltf::Node& node, std::size_t node_id,
                                        const GltfTrs& pose);

// The error if a mesh is lengthened by more than kMaxGltfScale. element: of the node, or the joint.
// what: which is scaled, for the message: "\"lid\"".
std::optional<Error> check_scale(const Mat3& linear_scene_mesh, const std::string& element,
                                 const std::string& what);

// True iff the matrix has no inverse in double precision: with rows, then columns scaled to length
// 1, its smallest singular value is rounding noise beside the largest.
bool is_singular(const Mat3& linear);

}  // namespace palpate
