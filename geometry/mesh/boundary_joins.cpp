#include "geometry/mesh/boundary_joins.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "geometry/exact/exact.h"
#include "geometry/mesh/boundary_holes.h"
#include "geometry/mesh/boundary_vertices.h"
#include "geometry/mesh/joined_boundary.h"
#include "geometry/mesh/point_tree.h"
#include "geometry/mesh/vertices_on_edges.h"

namespace palpate {
namespace {

// Removing pairs can shift the lowest number of a set, after which other pairs may be too far from
// it. If sets do not settle in this many rounds, they form long chains, and all pairs are removed.
constexpr int kMostSettlingRounds = 16;

// Two edges that are joined, as indices into the edges.
struct EdgePair {
  std::uint32_t edge;
  std::uint32_t mate;
  double apart_m;  // GapLimit
};

class JoinSearch {
 public:
  JoinSearch(const WeldedSurface& surface, const GapLimit& limit) : boundary_(surface, limit) {
    const std::vector<std::uint32_t> half_edges = boundary_half_edges(surface);
    edges_.reserve(half_edges.size());
    for (const std::uint32_t h : half_edges) {
      const Triangle& face = surface.faces()[h / 3];
      edges_.push_back({h, boundary_.index_of(face[h % 3]),
                        boundary_.index_of(face[next_half_edge(h) % 3]),
                        static_cast<std::uint32_t>(edges_.size())});
    }
    whole_edges_ = edges_.size();
  }

  BoundaryJoins find() {
    std::vector<std::uint32_t> all(edges_.size());
    for (std::uint32_t e = 0; e < all.size(); ++e) all[e] = e;
    const std::vector<std::uint32_t> alone = pair(all);
    settle();
    divide(alone);
    settle();
    return take();
  }

 private:
  static constexpr std::uint32_t kNone = JoinedBoundary::kNone;
  static constexpr std::uint32_t kSeveral = JoinedBoundary::kSeveral;

  // Pairs edges one to one. Returns the edges that have no mate. Tiny edges are left out: all their
  // ends are near each other.
  std::vector<std::uint32_t> pair(const std::vector<std::uint32_t>& edges) {
    std::vector<std::uint32_t> long_edges;
    std::vector<Vec3> middles;
    long_edges.reserve(edges.size());
    middles.reserve(edges.size());
    for (const std::uint32_t e : edges) {
      if (boundary_.is_tiny(edges_[e])) continue;
      long_edges.push_back(e);
      middles.push_back(0.5 * (boundary_.joined(edges_[e].from) + boundary_.joined(edges_[e].to)));
    }
    const PointTree tree(std::move(middles));
    std::vector<std::uint32_t> mates(long_edges.size());
    for (std::uint32_t i = 0; i < mates.size(); ++i) mates[i] = mate_of(i, long_edges, tree);
    std::vector<std::uint32_t> alone;
    for (std::uint32_t i = 0; i < mates.size(); ++i) {
      const std::uint32_t mate = mates[i];
      if (mate == kNone) {
        alone.push_back(long_edges[i]);
      } else if (mate == kSeveral || mates[mate] != i) {
        ++ambiguous_edges_;
      } else if (i < mate) {
        pairs_.push_back({long_edges[i], long_edges[mate],
                          apart_m(edges_[long_edges[i]], edges_[long_edges[mate]])});
      }
    }
    return alone;
  }

  // The larger distance of two ends, and of ends of pieces from the edges that they divide.
  double apart_m(const BoundaryEdge& edge, const BoundaryEdge& mate) {
    const double ends_m =
        std::max(boundary_.length_m(boundary_.joined(edge.from) - boundary_.joined(mate.to)),
                 boundary_.length_m(boundary_.joined(edge.to) - boundary_.joined(mate.from)));
    return std::max({ends_m, from_whole_m(edge), from_whole_m(mate)});
  }
  double from_whole_m(const BoundaryEdge& piece) {
    const BoundaryEdge& whole = edges_[piece.whole];
    const Vec3 a = boundary_.joined(whole.from);
    const Vec3 along = boundary_.joined(whole.to) - a;
    double most_m = 0.0;
    for (const std::uint32_t v : {piece.from, piece.to}) {
      const Vec3 d = boundary_.joined(v) - a;
      most_m = std::max(most_m, boundary_.length_m(d - d.dot(along) / along.squaredNorm() * along));
    }
    return most_m;
  }

  // The only edge that can be joined with edge number i; kNone or kSeveral if there is no such one.
  std::uint32_t mate_of(std::uint32_t i, const std::vector<std::uint32_t>& edges,
                        const PointTree& tree) {
    const BoundaryEdge& edge = edges_[edges[i]];
    const Vec3 search = boundary_.search_m(edge);
    const Box box{tree.point(i) - search, tree.point(i) + search};
    std::uint32_t mate = kNone;
    std::size_t visits = 0;
    const bool is_complete = tree.visit_box(box, [&](std::uint32_t j) {
      if (++visits > JoinedBoundary::kMostNear) return false;
      const BoundaryEdge& other = edges_[edges[j]];
      const bool is_other_face = edge.half_edge / 3 != other.half_edge / 3;
      if (is_other_face && boundary_.counts_as_one(edge.from, other.to) &&
          boundary_.counts_as_one(edge.to, other.from)) {
        mate = mate == kNone ? j : kSeveral;
      }
      return mate != kSeveral;
    });
    if (visits > JoinedBoundary::kMostNear) ++capped_edges_;
    return is_complete ? mate : kSeveral;
  }

  // Joins the ends of the pairs. Removes pairs that would join what does not count as one with the
  // lowest number, or would leave a face without area, until no such pair is left.
  void settle() {
    for (int round = 0;; ++round) {
      boundary_.separate_all();
      for (const EdgePair& p : pairs_) {
        boundary_.unite(edges_[p.edge].from, edges_[p.mate].to);
        boundary_.unite(edges_[p.edge].to, edges_[p.mate].from);
      }
      std::vector<bool> is_wrong(boundary_.size(), false);  // by the lowest number
      bool any = mark_far(is_wrong);
      any = mark_flat(is_wrong) || any;
      any = mark_flat_pieces(is_wrong) || any;
      if (!any) return;
      const std::size_t before = pairs_.size();
      std::erase_if(pairs_, [&](const EdgePair& p) {
        const BoundaryEdge& edge = edges_[p.edge];
        return round >= kMostSettlingRounds || is_wrong[boundary_.lowest(edge.from)] ||
               is_wrong[boundary_.lowest(edge.to)];
      });
      ambiguous_edges_ += 2 * (before - pairs_.size());
      if (round >= kMostSettlingRounds) capped_edges_ += 2 * (before - pairs_.size());
    }
  }

  bool mark_far(std::vector<bool>& is_wrong) {
    bool any = false;
    for (std::uint32_t v = 0; v < boundary_.size(); ++v) {
      const std::uint32_t lowest = boundary_.lowest(v);
      if (v == lowest || boundary_.counted_as_one(v, lowest)) continue;
      any = is_wrong[lowest] = true;
    }
    return any;
  }

  bool mark_flat(std::vector<bool>& is_wrong) {
    bool any = false;
    for (const std::uint32_t f : boundary_.faces()) {
      const Triangle corners = boundary_.corners_of(f);
      std::array<Vec3, 3> p;
      bool is_moved = false;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = boundary_.surface().positions()[boundary_.surface().faces()[f][i]];
        if (corners[i] == kNone || boundary_.lowest(corners[i]) == corners[i]) continue;
        p[i] = boundary_.joined(corners[i]);
        is_moved = true;
      }
      if (!is_moved || !exactly_collinear(p[0], p[1], p[2])) continue;
      for (const std::uint32_t corner : corners) {
        if (corner != kNone) any = is_wrong[boundary_.lowest(corner)] = true;
      }
    }
    return any;
  }

  // A vertex at which an edge is divided must not be joined with a corner of the divided face, nor
  // with the next such vertex.
  bool mark_flat_pieces(std::vector<bool>& is_wrong) {
    bool any = false;
    visit_divisions([&](const BoundaryEdge& piece) {
      const std::uint32_t set = boundary_.lowest(piece.from);
      bool is_flat = boundary_.lowest(piece.to) == set;
      for (const std::uint32_t corner : boundary_.surface().faces()[piece.half_edge / 3]) {
        is_flat = is_flat || boundary_.set_of(boundary_.index_of(corner)) == set;
      }
      if (is_flat) any = is_wrong[set] = true;
    });
    return any;
  }

  // Divides the edges at vertices that lie on them, and pairs the pieces. alone: the edges without
  // a mate.
  void divide(const std::vector<std::uint32_t>& alone) {
    const VerticesOnEdges found = find_vertices_on_edges(boundary_, edges_, alone);
    ambiguous_edges_ += found.ambiguous_edges;
    capped_edges_ += found.capped_edges;
    examined_leaves_ += found.examined_leaves;
    const std::vector<VertexOnEdge>& places = found.places;
    if (places.empty()) return;
    edges_.reserve(edges_.size() + 2 * places.size());
    std::vector<std::uint32_t> pieces;
    auto next = places.begin();
    for (const std::uint32_t e : alone) {
      const auto first = next;
      while (next != places.end() && next->edge == e) ++next;
      append_pieces(e, {first, next}, pieces);
    }
    pair(pieces);
  }

  // Appends the pieces of an edge to the edges, or the edge itself if it is not divided.
  void append_pieces(std::uint32_t e, std::span<const VertexOnEdge> places,
                     std::vector<std::uint32_t>& pieces) {
    if (places.empty()) {
      pieces.push_back(e);
      return;
    }
    BoundaryEdge piece = edges_[e];
    const std::uint32_t to = piece.to;
    for (std::size_t i = 0; i <= places.size(); ++i) {
      piece.to = i < places.size() ? places[i].vertex : to;
      pieces.push_back(static_cast<std::uint32_t>(edges_.size()));
      edges_.push_back(piece);
      if (i == places.size()) break;
      piece.from = places[i].vertex;
      piece.from_along = places[i].along;
    }
  }

  // Per edge: whether it is joined.
  std::vector<bool> joined_edges() const {
    std::vector<bool> is_joined(edges_.size(), false);
    for (const EdgePair& p : pairs_) is_joined[p.edge] = is_joined[p.mate] = true;
    return is_joined;
  }

  // Calls visit(piece) for each piece at whose start an edge is divided: this piece or the one
  // before is joined.
  template <typename Visit>
  void visit_divisions(Visit visit) {
    if (edges_.size() == whole_edges_) return;
    const std::vector<bool> is_joined = joined_edges();
    for (std::size_t e = whole_edges_ + 1; e < edges_.size(); ++e) {
      if (edges_[e].from_along > 0.0 && (is_joined[e - 1] || is_joined[e])) visit(edges_[e]);
    }
  }

  BoundaryJoins take() {
    BoundaryJoins joins;
    SurfaceChanges& changes = joins.changes;
    changes.joined_edges = pairs_.size();
    visit_divisions([&](const BoundaryEdge& rest) {
      changes.divisions.push_back({rest.half_edge, rest.from, rest.from_along});
    });
    ambiguous_edges_ += close_holes(boundary_, edges_, whole_edges_, joined_edges());
    const std::vector<std::uint32_t> into = boundary_.merged_vertices();
    for (std::uint32_t v = 0; v < boundary_.size(); ++v) {
      const std::uint32_t lowest = into[boundary_.lowest(v)];
      if (lowest != boundary_.vertex(v)) changes.merged.push_back({boundary_.vertex(v), lowest});
    }
    for (EdgeDivision& d : changes.divisions) d.vertex = into[boundary_.lowest(d.vertex)];
    std::sort(changes.divisions.begin(), changes.divisions.end(),
              [](const EdgeDivision& x, const EdgeDivision& y) {
                return std::pair(x.half_edge, x.along) < std::pair(y.half_edge, y.along);
              });
    joins.ambiguous_edges = ambiguous_edges_;
    joins.capped_edges = capped_edges_;
    joins.examined_leaves = examined_leaves_;
    for (const EdgePair& p : pairs_) joins.nearest_m = std::min(joins.nearest_m, p.apart_m);
    return joins;
  }

  JoinedBoundary boundary_;
  std::vector<BoundaryEdge> edges_;  // the whole edges, then pieces
  std::size_t whole_edges_ = 0;
  std::vector<EdgePair> pairs_;
  std::size_t ambiguous_edges_ = 0;
  std::size_t capped_edges_ = 0;
  std::size_t examined_leaves_ = 0;
};

}  // namespace

BoundaryJoins find_boundary_joins(const WeldedSurface& surface, const GapLimit& limit) {
  if (surface.report().boundary_edges == 0) return {};
  return JoinSearch(surface, limit).find();
}

std::uint64_t boundary_joins_memory(const WeldedSurface& surface) {
  constexpr std::uint64_t kIndex = sizeof(std::uint32_t);
  const std::uint64_t edges = surface.report().boundary_edges;
  if (edges == 0) return 0;
  // Per edge: the half-edge and two ends in growing lists; edge, middle, mate and pair; in the
  // second pass ends, places and their pieces; a hole, a merged vertex and a division in growing
  // lists.
  constexpr std::uint64_t kPerEdge =
      2 * 3 * kIndex + sizeof(BoundaryEdge) + PointTree::bytes(1) + kIndex + 2 * sizeof(EdgePair) +
      2 * 3 * kIndex + 2 * sizeof(VertexOnEdge) + 2 * sizeof(BoundaryEdge) + 2 * kIndex +
      2 * (kIndex + sizeof(MergedVertex) + sizeof(EdgeDivision));
  // Per boundary vertex, of which there are at most two per edge: number, extent, set, marks.
  constexpr std::uint64_t kPerVertex = 4 * kIndex + sizeof(double);
  // Per position and face: parts and marks; faces at the boundary.
  constexpr std::uint64_t kPerPosition = 2 * kIndex + 1;
  return edges * (kPerEdge + 2 * kPerVertex) + surface.positions().size() * kPerPosition +
         2 * surface.face_count() * kIndex;
}

}  // namespace palpate
