#pragma once

// Matches the half-edges of a triangle list at shared edges.
//
// Half-edge 3 f + e is edge e of face f, from corner e to corner (e + 1) mod 3 of the face. It
// starts at corner 3 f + e.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/fixed_array.h"
#include "geometry/base/types.h"

namespace palpate {

constexpr std::uint32_t kNoHalfEdge = 0xffffffffu;

// The next and the previous half-edge around the face of h.
constexpr std::uint32_t next_half_edge(std::uint32_t h) {
  return h % 3 == 2 ? h - 2 : h + 1;
}
constexpr std::uint32_t previous_half_edge(std::uint32_t h) {
  return h % 3 == 0 ? h + 2 : h - 1;
}

// A half-edge and its mate at an edge with exactly two faces of opposite orientation.
struct MisalignedMate {
  std::uint32_t half_edge;
  std::uint32_t mate;
};

struct EdgeFindings {
  // Edges with exactly two half-edges, which run in the same direction. Both half-edges are listed,
  // in ascending order of half_edge. Rare.
  std::vector<MisalignedMate> misaligned;
  std::size_t boundary_edges = 0;      // edges with one face
  std::size_t non_manifold_edges = 0;  // edges with three or more faces, or two misaligned faces
  // Whether two faces have the same three vertices. If so, the other findings include both faces.
  bool has_duplicates = false;
};

struct HalfEdgeMates : EdgeFindings {
  // The mate of each half-edge. It is the only other half-edge between the same two vertices, and
  // it runs in the opposite direction, so that the two faces are oriented alike. Without such a
  // half-edge, the entry is kNoHalfEdge.
  FixedArray<std::uint32_t> aligned;
};

// Matches the half-edges of all faces. Requires three different vertices per face, all less than
// vertex_count, and fewer than 2^32 / 3 faces. The result does not depend on the number of threads.
// O(n log n) in the worst case.
HalfEdgeMates match_half_edges(std::span<const Triangle> faces, std::size_t vertex_count);

}  // namespace palpate
