#pragma once

#include <optional>

#include "geometry/base/types.h"
#include "geometry/index/surface_index.h"

namespace palpate {

// An affine node transform, split into what deforms and what only moves.
struct NodePlacement {
  Mat3 deformation;  // S: scale and shear, symmetric and positive, or minus that for a mirror
  Quat rotation;     // R, so that linear = R S
};

// Polar decomposition of the linear part of a node transform. Where the matrix is diagonal it loses
// no bit: so an axis-aligned node keeps its vertices. Nothing if the matrix is singular to within
// rounding, or not finite.
std::optional<NodePlacement> split_linear(const Mat3& linear);

}  // namespace palpate
