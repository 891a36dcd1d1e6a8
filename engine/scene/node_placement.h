#pragma once

#include <optional>

#include "geometry/base/types.h"
#include "geometry/index/surface_index.h"

namespace palpate {

// The linear part of a node transform, factored as linear = R S.
struct NodePlacement {
  // S: scale and shear. Symmetric; negative definite for a mirror, otherwise positive definite.
  Mat3 deformation;
  Quat rotation;  // R
};

// Polar decomposition of the linear part of a node transform. The decomposition of a diagonal
// matrix is exact; therefore an axis-aligned node keeps the exact coordinates of its vertices.
// Returns no value if the matrix is not finite or is singular to within rounding.
std::optional<NodePlacement> split_linear(const Mat3& linear);

}  // namespace palpate
