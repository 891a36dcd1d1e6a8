#pragma once

// Where a mesh is flat and where it is not, and which of its faces are near a place.

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/index/overlap_tree.h"
#include "geometry/mesh/welded_surface.h"

namespace palpate {

// An edge is flat if its two faces lie in one plane, to within the errors of their four vertices.
// Every other edge is sharp, also one with a single face. A vertex is sharp if one of its edges is.
// Load time only; the mesh must outlive the object.
class MeshFeatures {
 public:
  // error_m: the largest distance, mesh frame, between a vertex and its intended position.
  MeshFeatures(const WeldedSurface& mesh, double error_m);

  // The memory that the features of a mesh need, including their construction.
  static std::uint64_t bytes(const WeldedSurface& mesh);

  const OverlapTree& tree() const { return tree_; }  // of the faces' boxes, mesh frame
  bool is_sharp_edge(std::uint32_t half_edge) const { return edges_[half_edge].is_sharp; }
  // Whether it is the lower one of the two half-edges of its edge, or the only one.
  bool is_first(std::uint32_t half_edge) const { return edges_[half_edge].is_first; }
  bool is_sharp_vertex(std::uint32_t vertex) const { return sharp_vertices_[vertex]; }
  // The half-edges that start at a vertex, ascending.
  std::span<const std::uint32_t> starting_at(std::uint32_t vertex) const {
    return std::span(starts_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  struct Edge {
    bool is_sharp : 1;
    bool is_first : 1;
  };

  OverlapTree tree_;
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> first_;  // per vertex, the first of its entries in starts_
  std::vector<Edge> edges_;           // by half-edge
  std::vector<bool> sharp_vertices_;
};

}  // namespace palpate
