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
  TransformProduct product = {};  // magnitudes for rounding bounds

  // A transform with the numbers of a file.
  static AffineTransform given(const Mat3& linear, const Vec3& translation_m) {
    return {linear, translation_m, TransformProduct::of(linear, translation_m)};
  }
  // The transform inner, followed by this one. May overflow: the caller checks.
  AffineTransform operator*(const AffineTransform& inner) const {
    return {linear * inner.linear, linear * inner.translation_m + translation_m,
            product * inner.product};
  }
  // May overflow: the caller checks.
  Vec3 point(const Vec3& p_from) const { return linear * p_from + translation_m; }
  bool all_finite() const { return linear.allFinite() && translation_m.allFinite(); }
};

// The tolerance of the last row of a matrix, which is then replaced by 0 0 0 1. Exporters invert
// and multiply matrices of floats, with four products per entry, and write the computed row.
inline constexpr double kAffineRowTolerance = 16.0 * std::numeric_limits<float>::epsilon();

// The tolerance of the length of a quaternion, which is then normalised. Files round quaternions to
// few digits, some to signed bytes with a half step of 1/256 per component. A quaternion outside
// the tolerance is an error, because glTF requires unit length.
inline constexpr double kRotationLengthTolerance = 1.0 / 128.0;

// An error if rotation is not a unit quaternion. element: for the message.
std::optional<Error> check_rotation(const Eigen::Vector4d& rotation, const std::string& element);

// The optional parts of a transform in a file.
struct GltfTrs {
  std::optional<Vec3> translation_m;
  std::optional<Eigen::Vector4d> rotation;  // quaternion x, y, z, w; checked
  std::optional<Vec3> scale;
};

// translation * rotation * scale. Without rotation the linear part is exactly the scale.
AffineTransform transform_of(const GltfTrs& trs);

// The transform from the node frame to the frame of its parent (glTF 2.0, section 3.5.3): matrix,
// or translation * rotation * scale, each of which the pose may replace. An error unless the matrix
// is affine within kAffineRowTolerance. node_id: for messages.
Result<AffineTransform> local_transform(const tinygltf::Node& node, std::size_t node_id,
                                        const GltfTrs& pose);

// An error if a mesh is lengthened by more than kMaxGltfScale. element: of the node or the joint.
// what: the name of the scaled object, for the message: "\"lid\"".
std::optional<Error> check_scale(const Mat3& linear_scene_mesh, const std::string& element,
                                 const std::string& what);

// True if and only if the matrix has no inverse in double precision: after its rows, then its
// columns, are scaled to length 1, its smallest singular value is rounding noise compared with the
// largest.
bool is_singular(const Mat3& linear);

}  // namespace palpate
