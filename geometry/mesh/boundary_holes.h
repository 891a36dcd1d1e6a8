#pragma once

// Shrinks holes whose vertices all count as one to vertices. Private to find_boundary_joins().

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/mesh/joined_boundary.h"

namespace palpate {

// Joins the vertices of each hole whose edges are all tiny, if all its vertices count as one with
// the lowest, and no face has all its corners there. edges: the first whole_count are whole, the
// others are pieces. is_joined: per edge, whether it has a mate. Returns the number of edges of
// holes that stay open.
std::size_t close_holes(JoinedBoundary& boundary, std::span<const BoundaryEdge> edges,
                        std::size_t whole_count, std::vector<bool> is_joined);

}  // namespace palpate
