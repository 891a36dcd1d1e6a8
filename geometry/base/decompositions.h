#pragma once

// Functions of Eigen that need a singular value decomposition. Eigen's decomposition is a template
// that takes seconds to compile; it is compiled here once instead of in every source that uses it.

#include "geometry/base/types.h"

namespace palpate {

// m = u * diag(values) * v^T, where u and v are orthogonal and the values descend. From any thread.
struct SingularValueDecomposition {
  Mat3 u;
  Vec3 values;
  Mat3 v;
};
SingularValueDecomposition decompose(const Mat3& m);

// Only the singular values of m, in descending order. From any thread.
Vec3 singular_values(const Mat3& m);

// The smallest turn that takes the direction of `from` to that of `to`; both are vectors of any
// length other than 0. If they are opposite, the axis is any that is perpendicular to them. From
// any thread.
Quat turn_between(const Vec3& from, const Vec3& to);

}  // namespace palpate
