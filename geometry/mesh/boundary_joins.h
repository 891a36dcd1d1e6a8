#pragma once

// Finds the parts of the boundary of a surface that meet within a bound, and the changes that make
// them meet exactly.

#include <cstddef>
#include <cstdint>
#include <limits>

#include "geometry/base/memory_breakdown.h"
#include "geometry/base/types.h"
#include "geometry/mesh/surface_changes.h"
#include "geometry/mesh/welded_surface.h"

namespace palpate {

// Gaps that a user wants joined. Positions p and q count as one if |linear (p - q)| <= most_m.
struct GapLimit {
  Mat3 linear = Mat3::Identity();  // from the mesh frame to the frame of most_m; not singular
  double most_m = 0.0;             // 0: no gap beyond the rounding of the file
};

struct BoundaryJoins {
  SurfaceChanges changes;
  // Boundary edges that stay open because they are near several others, or because the surface has
  // details that are smaller than the bound there.
  std::size_t ambiguous_edges = 0;
  // Those of them that were not examined completely, because that would take too long.
  std::size_t capped_edges = 0;
  std::size_t examined_leaves = 0;  // of the tree of vertices: a measure of the time taken
  // The smallest distance of the ends of two joined edges, measured as in GapLimit: the larger one
  // of the two ends. Infinite if no edges are joined.
  double nearest_m = std::numeric_limits<double>::infinity();
};

// Two positions count as one if they are within join_bound_m() of each other, or within the limit.
// Only vertices of boundary edges change:
// - Two boundary edges that run in opposite directions are joined if their ends count as one, and
//   if this is so for no other boundary edge with one of the two.
// - A boundary edge is divided at a boundary vertex that counts as one with a point of the edge, if
//   a piece of the edge can then be joined.
// - A boundary that surrounds a hole shrinks to a vertex if all its vertices count as one. (The
//   last column of a generator makes such holes at poles.)
// Joined vertices get the position of the one with the lowest number, including positions that no
// face uses. What is joined would leave no face without area, except at a hole; else it stays
// apart, and so do vertices that are joined in a chain and do not all count as one with the lowest.
//
// surface: may have unused positions. Deterministic, on one thread. O(n log n) time: a boundary
// edge near very many others stays open, and so do the last edges if edges pass very many vertices
// (BoundaryJoins::capped_edges).
BoundaryJoins find_boundary_joins(const WeldedSurface& surface, const GapLimit& limit = {});

// The memory of find_boundary_joins(), including its result.
std::uint64_t boundary_joins_memory(const WeldedSurface& surface);

}  // namespace palpate
