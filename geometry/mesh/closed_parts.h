#pragma once

// The parts of a surface that are closed.

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// A part consists of faces that are connected by edges. It is closed if each of its edges has an
// even number of its faces, in any orientation, so that a point is inside or outside of it
// (inside.h). Two parts that only share a vertex are two.
struct ClosedParts {
  static constexpr std::uint32_t kOpen = ~std::uint32_t{0};

  std::size_t count = 0;
  // The number of the closed part of each face, or kOpen. Empty if all faces are of one closed
  // part, or if no part is closed.
  std::vector<std::uint32_t> part_of_face;

  bool is_whole() const { return count == 1 && part_of_face.empty(); }
  std::uint32_t part(std::uint32_t face) const {
    return part_of_face.empty() ? 0 : part_of_face[face];
  }
};

// faces: of welded vertices. O(n log n), 12 bytes an edge; load time only.
ClosedParts closed_parts(std::span<const Triangle> faces);

}  // namespace palpate
