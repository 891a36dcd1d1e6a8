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

// The tolerance for the last row of a matrix; a row within the tolerance is replaced by 0 0 0 1.
// The tolerance is needed because exporters invert and multiply matrices of floats, with four
// products per entry, and write the computed row.
inline constexpr double kAffineRowTolerance = 16.0 * std::numeric_limits<float>::epsilon();

// The tolerance for the length of a quaternion; a quaternion within the tolerance is normalised.
// The tolerance is needed because files round quaternions to few digits, some of them to signed
// bytes with a half step of 1/256 per component. A quaternion outside the tolerance is an error,
// because glTF requires unit length.
inline constexpr double kRotationLengthTolerance = 1.0 / 128.0;

// Returns an error if rotation is not a unit quaternion. element: the JSON path for the message.
std::optional<Error> check_rotation(const Eigen::Vector4d& rotation, const std::string& element);

// The parts of a transform, each of which may be absent.
struct GltfTrs {
  std::optional<Vec3> translation_m;
  std::optional<Eigen::Vector4d> rotation;  // quaternion x, y, z, w; checked
  std::optional<Vec3> scale;
};

// translation * rotation * scale. Without rotation the linear part is exactly the scale.
AffineTransform transform_of(const GltfTrs& trs);

// The transform from the node frame to the frame of its parent (glTF 2.0, section 3.5.3). It is the
// node's matrix or the product translation * rotation * scale; the pose may replace each of these
// three factors. Returns an error unless the matrix is affine within kAffineRowTolerance. node_id:
// for messages.
Result<AffineTransform> local_transform(const tinygltf::Node& node, std::size_t node_id,
                                        const GltfTrs& pose);

// Returns an error if a mesh is lengthened by more than kMaxGltfScale. element: JSON path of the
// node or the joint. what: the name of the scaled object for the message, for example "\"lid\"".
std::optional<Error> check_scale(const Mat3& linear_scene_mesh, const std::string& element,
                                 const std::string& what);

// True if and only if the matrix has no inverse in double precision. The test scales first the rows
// of the matrix, then its columns, to length 1. There is no inverse if the smallest singular value
// of the scaled matrix is rounding noise compared with the largest one.
bool is_singular(const Mat3& linear);

}  // namespace palpate
