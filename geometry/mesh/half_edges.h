#pragma once

// Which faces of a triangle list meet at which edge.
//
// Half-edge 3 f + e is edge e of face f, from its corner e to its corner (e + 1) mod 3; corner
// 3 f + e is where it starts.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/fixed_array.h"
#include "geometry/base/types.h"

namespace palpate {

constexpr std::uint32_t kNoHalfEdge = 0xffffffffu;

// The half-edge after h, and the one before it, around their face.
constexpr std::uint32_t next_half_edge(std::uint32_t h) {
  return h % 3 == 2 ? h - 2 : h + 1;
}
constexpr std::uint32_t previous_half_edge(std::uint32_t h) {
  return h % 3 == 0 ? h + 2 : h - 1;
}

// The one other half-edge of an edge whose two faces are oriented against each other.
struct MisalignedMate {
  std::uint32_t half_edge;
  std::uint32_t mate;
};

struct EdgeFindings {
  // Where the only two half-edges run the same way; both are listed, in rising order of half_edge.
  // Rare.
  std::vector<MisalignedMate> misaligned;
  std::size_t boundary_edges = 0;      // edges with one face
  std::size_t non_manifold_edges = 0;  // edges with three faces or more, or two not aligned
  // Two faces have the same three vertices. The rest then counts both of them.
  bool has_duplicates = false;
};

struct HalfEdgeMates : EdgeFindings {
  // The one other half-edge between the same two vertices, if the two run opposite ways: their
  // faces are oriented alike. kNoHalfEdge if not, or if there is none, or more than one.
  FixedArray<std::uint32_t> aligned;
};

// Pairs the half-edges of faces with three different vertices each, all less than vertex_count.
// Fewer than 2^32 / 3 faces. The same for any number of threads. O(n log n) at worst.
HalfEdgeMates match_half_edges(std::span<const Triangle> faces, std::size_t vertex_count);

}  // namespace palpate
