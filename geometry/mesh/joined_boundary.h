#pragma once

// The boundary of a surface while its parts are joined: its vertices and edges, and the sets of
// vertices that get one position. Private to find_boundary_joins().

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/lowest_union.h"
#include "geometry/base/types.h"
#include "geometry/mesh/boundary_joins.h"
#include "geometry/mesh/join_bound.h"
#include "geometry/mesh/welded_surface.h"

namespace palpate {

// An edge of the boundary, or a piece of one. Vertices are indices into the boundary vertices.
struct BoundaryEdge {
  std::uint32_t half_edge;
  std::uint32_t from, to;
  std::uint32_t whole;      // the edge of which it is a piece, or its own number
  double from_along = 0.0;  // place of `from` on the whole edge
};

// Vertices are indices into the boundary vertices, which are in ascending order of their numbers in
// the surface. Mesh frame, m. Not thread-safe.
class JoinedBoundary {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint32_t kSeveral = kNone - 1;

  // Limit on the places that are compared with one place, because they are near it. Edges whose
  // ends differ by more than the bound have their middles at one place only by chance.
  static constexpr std::size_t kMostNear = 64;

  // The arguments must outlive this object. No vertices are joined yet.
  JoinedBoundary(const WeldedSurface& surface, const GapLimit& limit);

  const WeldedSurface& surface() const { return surface_; }
  std::size_t size() const { return vertices_.size(); }
  std::uint32_t vertex(std::uint32_t index) const { return vertices_[index]; }
  const std::vector<std::uint32_t>& faces() const { return faces_; }  // with a boundary vertex
  std::uint32_t index_of(std::uint32_t vertex) const {
    const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), vertex);
    return found != vertices_.end() && *found == vertex
               ? static_cast<std::uint32_t>(found - vertices_.begin())
               : kNone;
  }
  // The corners of a face, as indices into the boundary vertices; kNone for other vertices.
  Triangle corners_of(std::uint32_t face) const {
    const auto [a, b, c] = surface_.faces()[face];
    return {index_of(a), index_of(b), index_of(c)};
  }

  // The vertex with the lowest number among those that are joined with this one.
  std::uint32_t lowest(std::uint32_t index) { return sets_.lowest(index); }
  // The same, but kNone for a vertex that is not on the boundary.
  std::uint32_t set_of(std::uint32_t index) { return index == kNone ? kNone : sets_.lowest(index); }
  void unite(std::uint32_t v, std::uint32_t w) { sets_.unite(v, w); }
  void separate_all() { sets_ = LowestUnion(vertices_.size()); }

  const Vec3& position(std::uint32_t index) const { return surface_.positions()[vertices_[index]]; }
  // The position that the vertex gets.
  const Vec3& joined(std::uint32_t index) { return position(sets_.lowest(index)); }
  // The smaller extent of the parts of the surface that have these vertices.
  double extent_m(std::uint32_t v, std::uint32_t w) const {
    return std::min(extents_m_[v], extents_m_[w]);
  }
  // The length of a difference in the mesh frame, in the frame of the limit.
  double length_m(const Vec3& difference) const { return (limit_.linear * difference).norm(); }

  bool counts_as_one(const Vec3& p, const Vec3& q, double extent_m) const {
    return is_within(p, q, join_bound_m(p, q, extent_m)) ||
           (limit_.most_m > 0.0 && length_m(p - q) <= limit_.most_m);
  }
  // Of the positions that the vertices get.
  bool counts_as_one(std::uint32_t v, std::uint32_t w) {
    return sets_.lowest(v) == sets_.lowest(w) ||
           counts_as_one(joined(v), joined(w), extent_m(v, w));
  }
  // Of the positions that the vertices have in the surface.
  bool counted_as_one(std::uint32_t v, std::uint32_t w) const {
    return counts_as_one(position(v), position(w), extent_m(v, w));
  }
  bool is_tiny(const BoundaryEdge& edge) { return counts_as_one(edge.from, edge.to); }
  // Everything that counts as one with a position on the edge is within this distance of it.
  Vec3 search_m(const BoundaryEdge& edge);

  // For the lowest vertex of each set of several, the number in the surface of the vertex that all
  // of the set become: the one with the lowest number that counts as one with all of them. It may
  // be a vertex that no face uses. For other vertices, their own numbers.
  std::vector<std::uint32_t> merged_vertices();

 private:
  void find_faces();
  void take_unused(const std::vector<std::uint32_t>& sets, std::vector<std::uint32_t>& into) const;

  const WeldedSurface& surface_;
  const GapLimit& limit_;
  Vec3 reach_m_;  // half the extent of the box around all differences within the limit
  std::vector<std::uint32_t> vertices_;  // ascending
  std::vector<double> extents_m_;        // of the parts of these vertices
  std::vector<std::uint32_t> faces_;
  LowestUnion sets_;
};

}  // namespace palpate
