#include "engine/scene/node_placement.h"

#include <limits>

#include "geometry/base/decompositions.h"

namespace palpate {
namespace {

// A diagonal matrix needs no rotation, or half a turn about an axis, which changes only signs.
NodePlacement split_diagonal(const Vec3& diagonal) {
  const bool is_mirrored = (diagonal.array() < 0.0).count() % 2 != 0;
  const double sign = is_mirrored ? -1.0 : 1.0;
  Quat rotation = Quat::Identity();
  const Vec3 turned = sign * diagonal.cwiseSign();
  for (int k = 0; k < 3; ++k) {
    const bool is_axis = turned[k] > 0.0 && turned[(k + 1) % 3] < 0.0;
    if (is_axis) rotation.coeffs() = Eigen::Vector4d::Unit(k);
  }
  return {Mat3((sign * diagonal.cwiseAbs()).asDiagonal()), rotation};
}

}  // namespace

std::optional<NodePlacement> split_linear(const Mat3& linear) {
  if (!linear.allFinite()) return std::nullopt;
  const SingularValueDecomposition svd = decompose(linear);
  const Vec3& scales = svd.values;
  if (scales[2] <= 16 * std::numeric_limits<double>::epsilon() * scales[0]) return std::nullopt;
  const bool is_diagonal = Mat3(linear.diagonal().asDiagonal()) == linear;
  if (is_diagonal) return split_diagonal(linear.diagonal());
  // R must be a proper rotation, so a mirror remains in S. S is then the negative of a positive
  // definite matrix. This factor is unique; therefore instances with equal mirrored scales have
  // equal factors S.
  const Mat3 orthogonal = svd.u * svd.v.transpose();
  const Mat3 rotation = orthogonal.determinant() < 0.0 ? Mat3(-orthogonal) : orthogonal;
  const Quat q(Quat(rotation).normalized());
  const Mat3 deformation = q.conjugate().toRotationMatrix() * linear;
  // A node that is only rotated has exactly S = 1 and can share an index with unrotated nodes.
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  if ((deformation - Mat3::Identity()).norm() <= kRounding) {
    return NodePlacement{Mat3::Identity(), q};
  }
  return NodePlacement{deformation, q};
}

}  // namespace palpate
