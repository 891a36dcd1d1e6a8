#include "geometry/base/decompositions.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace palpate {

SingularValueDecomposition decompose(const Mat3& m) {
  const Eigen::JacobiSVD<Mat3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Vec3 singular_values(const Mat3& m) {
  return Eigen::JacobiSVD<Mat3>(m).singularValues();
}

Quat turn_between(const Vec3& from, const Vec3& to) {
  return Quat::FromTwoVectors(from, to);
}

}  // namespace palpate
