#include "io/gltf/transform.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/base/decompositions.h"
#include "io/gltf/error.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

double squared_length_of(const Eigen::Vector4d& q) {
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

// The rotation matrix of the normalised quaternion x, y, z, w. It is computed with the squared
// length, so that quarter and half turns are exact even if the squares of their float components do
// not add up to 1.
Mat3 rotation_matrix(const Eigen::Vector4d& q) {
  const double squared_length = squared_length_of(q);
  const double x = q[0];
  const double y = q[1];
  const double z = q[2];
  const double w = q[3];
  Mat3 m;
  m << w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
      2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x),
      2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z;
  return m / squared_length;
}

Result<AffineTransform> from_matrix(const std::vector<double>& m, const std::string& element) {
  const double distance =
      std::max({std::abs(m[3]), std::abs(m[7]), std::abs(m[11]), std::abs(m[15] - 1.0)});
  if (!(distance <= kAffineRowTolerance)) {
    return gltf_invalid(element, "its last row (elements 3, 7, 11 and 15) is not 0 0 0 1");
  }
  Mat3 linear;
  linear << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
  return AffineTransform::given(linear, Vec3(m[12], m[13], m[14]));
}

}  // namespace

std::optional<Error> check_rotation(const Eigen::Vector4d& rotation, const std::string& element) {
  const double length = std::sqrt(squared_length_of(rotation));
  if (std::abs(length - 1.0) <= kRotationLengthTolerance) return std::nullopt;
  return gltf_invalid(element,
                      "is a quaternion of length " + std::to_string(length) + "; expected 1",
                      "divide it by its length");
}

AffineTransform transform_of(const GltfTrs& trs) {
  Mat3 linear = Mat3::Identity();
  if (trs.rotation) linear = rotation_matrix(*trs.rotation);
  if (trs.scale) linear = (linear * trs.scale->asDiagonal()).eval();
  return AffineTransform::given(linear, trs.translation_m.value_or(Vec3::Zero()));
}

Result<AffineTransform> local_transform(const tinygltf::Node& node, std::size_t node_id,
                                        const GltfTrs& pose) {
  if (!node.matrix.empty()) {
    return from_matrix(node.matrix, gltf_element("nodes", node_id, "matrix"));
  }
  GltfTrs trs = pose;
  if (!trs.translation_m && !node.translation.empty()) {
    trs.translation_m = Vec3(node.translation.data());
  }
  if (!trs.rotation && !node.rotation.empty()) {
    trs.rotation = Eigen::Vector4d(node.rotation.data());
    const auto error = check_rotation(*trs.rotation, gltf_element("nodes", node_id, "rotation"));
    if (error) return *error;
  }
  if (!trs.scale && !node.scale.empty()) trs.scale = Vec3(node.scale.data());
  return transform_of(trs);
}

std::optional<Error> check_scale(const Mat3& linear_scene_mesh, const std::string& element,
                                 const std::string& what) {
  double scale = lengthening(linear_scene_mesh);
  if (scale <= kMaxGltfScale) return std::nullopt;
  if (!std::isfinite(scale)) scale = linear_scene_mesh.cwiseAbs().maxCoeff();  // a lower bound
  return gltf_error(ErrorCode::kLimitExceeded, element,
                    what + " is scaled by " + gltf_number(scale) +
                        ", with its ancestors; at most " + gltf_number(kMaxGltfScale) + " is read");
}

bool is_singular(const Mat3& linear) {
  Mat3 scaled = linear;
  for (int i = 0; i < 3; ++i) {
    const double length = scaled.row(i).stableNorm();
    if (!(length > 0.0)) return true;
    scaled.row(i) /= length;
  }
  for (int i = 0; i < 3; ++i) {
    const double length = scaled.col(i).stableNorm();
    if (!(length > 0.0)) return true;
    scaled.col(i) /= length;
  }
  // Each entry is a sum of three products and has been rounded a few times.
  constexpr double kNoise = 16.0 * std::numeric_limits<double>::epsilon();
  const Vec3 stretch = singular_values(scaled);
  return !(stretch[2] > kNoise * stretch[0]);
}

}  // namespace palpate
