#include "engine/node_placement.h"

#include <limits>

#include <Eigen/SVD>

namespace palpate {

std::optional<NodePlacement> split_linear(const Mat3& linear) {
  if (!linear.allFinite()) return std::nullopt;
  const Eigen::JacobiSVD<Mat3> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3 scales = svd.singularValues();
  if (scales[2] <= 16 * std::numeric_limits<double>::epsilon() * scales[0]) return std::nullopt;
  const bool is_diagonal = Mat3(linear.diagonal().asDiagonal()) == linear;
  if (is_diagonal) return NodePlacement{linear, Quat::Identity()};
  // R must be proper: a mirror stays in S, which is then minus a stretch, the one such factor there
  // is, so that instances of one mirrored scale are found to be alike.
  const Mat3 orthogonal = svd.matrixU() * svd.matrixV().transpose();
  const Mat3 rotation = orthogonal.determinant() < 0.0 ? Mat3(-orthogonal) : orthogonal;
  const Quat q(Quat(rotation).normalized());
  const Mat3 deformation = q.conjugate().toRotationMatrix() * linear;
  // A node that is only turned deforms nothing: it can share an index with one that is not turned.
  constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon();
  if ((deformation - Mat3::Identity()).norm() <= kRounding) {
    return NodePlacement{Mat3::Identity(), q};
  }
  return NodePlacement{deformation, q};
}

}  // namespace palpate
