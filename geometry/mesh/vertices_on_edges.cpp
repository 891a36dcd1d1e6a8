#include "geometry/mesh/vertices_on_edges.h"

#include <algorithm>
#include <utility>

#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/point_tree.h"

namespace palpate {
namespace {

// Limit on the leaves of a PointTree that are examined for vertices on edges, per edge and vertex.
// A boundary edge usually passes a few leaves, because the vertices near it are its neighbours.
constexpr std::size_t kMostLeaves = 16;
// The same, per edge and vertex beyond those of the first kLeavesOfAny leaves. Real surfaces with
// very many boundary edges have short ones.
constexpr std::size_t kMostFurtherLeaves = 2;
constexpr std::size_t kLeavesOfAny = std::size_t{1} << 21;

// Limit on the places of vertices on edges, per vertex. A vertex usually lies on one edge.
constexpr std::size_t kMostPlaces = 1;

class VertexSearch {
 public:
  VertexSearch(JoinedBoundary& boundary, std::span<const BoundaryEdge> edges,
               const std::vector<std::uint32_t>& chosen)
      : boundary_(boundary), edges_(edges), chosen_(chosen), ends_(ends()), tree_(positions()) {}

  VerticesOnEdges run() {
    const std::size_t count = chosen_.size() + ends_.size();
    const std::size_t most_leaves =
        std::min(kMostLeaves * count, kLeavesOfAny + kMostFurtherLeaves * count);
    leaves_left_ = most_leaves;
    places_left_ = kMostPlaces * ends_.size() + 1;
    std::vector<VertexOnEdge>& places = found_.places;
    for (const std::uint32_t e : chosen_) {
      const std::size_t first = places.size();
      if (places_left_ == 0 || !find_on(e)) {
        places.resize(first);
        ++found_.ambiguous_edges;
        if (places_left_ == 0 || leaves_left_ == 0) ++found_.capped_edges;
      }
    }
    found_.examined_leaves = most_leaves - leaves_left_;
    erase_places_on_two_edges(places);
    return std::move(found_);
  }

 private:
  // The ends of the chosen edges, ascending.
  std::vector<std::uint32_t> ends() const {
    std::vector<std::uint32_t> ends;
    for (const std::uint32_t e : chosen_) {
      ends.insert(ends.end(), {boundary_.lowest(edges_[e].from), boundary_.lowest(edges_[e].to)});
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    return ends;
  }
  std::vector<Vec3> positions() const {
    std::vector<Vec3> positions;
    positions.reserve(ends_.size());
    for (const std::uint32_t v : ends_) positions.push_back(boundary_.position(v));
    return positions;
  }

  // Appends the vertices that lie on an edge, in their order. Returns false if the order is not
  // certain.
  bool find_on(std::uint32_t e) {
    const BoundaryEdge& edge = edges_[e];
    const Vec3 a = boundary_.joined(edge.from);
    const Vec3 along = boundary_.joined(edge.to) - a;
    const double squared = along.squaredNorm();
    const Triangle& face = boundary_.surface().faces()[edge.half_edge / 3];
    const std::uint32_t apex =
        boundary_.set_of(boundary_.index_of(face[previous_half_edge(edge.half_edge) % 3]));
    std::vector<VertexOnEdge>& places = found_.places;
    const auto first = static_cast<std::ptrdiff_t>(places.size());
    const auto examine = [&](std::uint32_t i) {
      const std::uint32_t v = ends_[i];
      const double t = (tree_.point(i) - a).dot(along) / squared;
      const bool is_on = t > 0.0 && t < 1.0 && v != apex &&
                         boundary_.counts_as_one(tree_.point(i), a + t * along,
                                                 boundary_.extent_m(v, edge.from)) &&
                         !boundary_.counts_as_one(v, edge.from) &&
                         !boundary_.counts_as_one(v, edge.to);
      if (is_on) places.push_back({e, v, t});
      return !is_on || --places_left_ > 0;
    };
    if (!tree_.visit_segment(a, a + along, boundary_.search_m(edge), leaves_left_, examine)) {
      return false;
    }
    std::sort(places.begin() + first, places.end(),
              [](const VertexOnEdge& x, const VertexOnEdge& y) {
                return std::pair(x.along, x.vertex) < std::pair(y.along, y.vertex);
              });
    return std::adjacent_find(places.begin() + first, places.end(),
                              [&](const VertexOnEdge& x, const VertexOnEdge& y) {
                                return boundary_.counts_as_one(x.vertex, y.vertex);
                              }) == places.end();
  }

  // A vertex that lies on two edges of one face lies near their common end; the face is thin.
  void erase_places_on_two_edges(std::vector<VertexOnEdge>& places) const {
    using FaceVertex = std::pair<std::uint32_t, std::uint32_t>;
    const auto at = [&](const VertexOnEdge& p) {
      return FaceVertex(edges_[p.edge].half_edge / 3, p.vertex);
    };
    std::vector<FaceVertex> all;
    all.reserve(places.size());
    for (const VertexOnEdge& p : places) all.push_back(at(p));
    std::sort(all.begin(), all.end());
    std::erase_if(places, [&](const VertexOnEdge& p) {
      const auto [begin, end] = std::equal_range(all.begin(), all.end(), at(p));
      return end - begin > 1;
    });
  }

  JoinedBoundary& boundary_;
  std::span<const BoundaryEdge> edges_;
  const std::vector<std::uint32_t>& chosen_;
  std::vector<std::uint32_t> ends_;
  PointTree tree_;  // of the ends
  std::size_t leaves_left_ = 0;
  std::size_t places_left_ = 0;
  VerticesOnEdges found_;
};

}  // namespace

VerticesOnEdges find_vertices_on_edges(JoinedBoundary& boundary,
                                       std::span<const BoundaryEdge> edges,
                                       const std::vector<std::uint32_t>& chosen) {
  return VertexSearch(boundary, edges, chosen).run();
}

}  // namespace palpate
