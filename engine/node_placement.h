#pragma once

#include <optional>

#include "geometry/surface_index.h"
#include "geometry/types.h"

namespace palpate {

// An affine node transform, split into what deforms (baked into the index) and what only moves.
struct NodePlacement {
  Mat3 deformation;  // S: scale, mirror, shear
  Quat rotation;     // R, so that linear = R S
};

// Polar decomposition of the linear part of a node transform. A diagonal matrix is taken as pure
// deformation, so that an axis-aligned node keeps its vertices to the bit. Nothing if the matrix is
// singular to within rounding, or not finite.
std::optional<NodePlacement> split_linear(const Mat3& linear);

}  // namespace palpate
