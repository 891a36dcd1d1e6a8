#include "io/gltf_transform.h"

#include <cmath>
#include <limits>

#include <Eigen/SVD>

#include "io/gltf_error.h"
#include "io/tinygltf.h"

namespace palpate {
namespace {

// The rotation matrix of the quaternion x, y, z, w divided by its length. Written with the squared
// length, so that quarter and half turns come out exact even when their float components do not
// square to 1.
Mat3 rotation_matrix(const std::vector<double>& q, double squared_length) {
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
  if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
    return gltf_invalid(element, "its last row (elements 3, 7, 11 and 15) is not 0 0 0 1");
  }
  AffineTransform transform;
  transform.linear << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
  transform.translation_m = Vec3(m[12], m[13], m[14]);
  return transform;
}

}  // namespace

Result<AffineTransform> local_transform(const tinygltf::Node& node, std::size_t node_id) {
  if (!node.matrix.empty())
    return from_matrix(node.matrix, gltf_element("nodes", node_id, "matrix"));
  AffineTransform transform;
  if (!node.rotation.empty()) {
    const auto& q = node.rotation;
    const double squared_length = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    const double length = std::sqrt(squared_length);
    if (!(std::abs(length - 1.0) <= kRotationLengthTolerance)) {
      return gltf_invalid(gltf_element("nodes", node_id, "rotation"),
                          "is a quaternion of length " + std::to_string(length) + "; expected 1",
                          "divide it by its length");
    }
    transform.linear = rotation_matrix(q, squared_length);
  }
  if (!node.scale.empty()) {
    const Vec3 scale(node.scale[0], node.scale[1], node.scale[2]);
    transform.linear = (transform.linear * scale.asDiagonal()).eval();
  }
  if (!node.translation.empty()) {
    transform.translation_m = Vec3(node.translation[0], node.translation[1], node.translation[2]);
  }
  return transform;
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
  // Each entry is the sum of three products, and was rounded a few times on the way.
  constexpr double kNoise = 16.0 * std::numeric_limits<double>::epsilon();
  const Vec3 stretch = Eigen::JacobiSVD<Mat3>(scaled).singularValues();  // falling
  return !(stretch[2] > kNoise * stretch[0]);
}

}  // namespace palpate
