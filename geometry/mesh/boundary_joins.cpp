#include "geometry/mesh/boundary_joins.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "geometry/base/lowest_union.h"
#include "geometry/exact/exact.h"
#include "geometry/mesh/boundary_vertices.h"
#include "geometry/mesh/join_bound.h"
#include "geometry/mesh/point_tree.h"
#include "geometry/mesh/surface_parts.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr std::uint32_t kSeveral = kNone - 1;

// Limit on the edges whose middles are near the middle of one edge. Edges whose ends differ by more
// than the bound have their middles at one place only by chance.
constexpr std::size_t kMostNear = 64;

// Limit on the leaves of a PointTree that are examined for vertices on edges, per edge and vertex.
// A boundary edge usually passes a few leaves, because the vertices near it are its neighbours.
constexpr std::size_t kMostLeaves = 16;
// The same, per edge and vertex beyond those of the first kLeavesOfAny leaves. Real surfaces with
// very many boundary edges have short ones.
constexpr std::size_t kMostFurtherLeaves = 2;
constexpr std::size_t kLeavesOfAny = std::size_t{1} << 21;

// The search for what may be within a bound covers this much more than the bound, which is computed
// from the coordinates of one of the two positions only.
constexpr double kSearchMargin = 1 + 0x1p-10;

// Limit on the places of vertices on edges, per vertex. A vertex usually lies on one edge.
constexpr std::size_t kMostPlaces = 1;

// Removing pairs can shift the lowest number of a set, after which other pairs may be too far from
// it. If sets do not settle in this many rounds, they form long chains, and all pairs are removed.
constexpr int kMostRounds = 16;

// An edge of the boundary, or a piece of one. Vertices are indices into the boundary vertices.
struct Edge {
  std::uint32_t half_edge;
  std::uint32_t from, to;
  std::uint32_t whole;      // the edge of which it is a piece, or its own number
  double from_along = 0.0;  // place of `from` on the whole edge
};

// A vertex that lies on an edge.
struct Place {
  std::uint32_t edge;
  std::uint32_t vertex;
  double along;
};

// Two edges that are joined, as indices into the edges.
struct Pair {
  std::uint32_t edge;
  std::uint32_t mate;
  double apart_m;  // GapLimit
};

class JoinSearch {
 public:
  JoinSearch(const WeldedSurface& surface, const GapLimit& limit)
      : surface_(surface),
        limit_(limit),
        reach_m_(Vec3::Zero()),
        half_edges_(boundary_half_edges(surface)),
        vertices_(boundary_vertices(surface)),
        extents_m_(part_extents_m(surface, vertices_)),
        sets_(vertices_.size()) {
    if (limit.most_m > 0.0) {
      reach_m_ = limit.most_m * limit.linear.inverse().rowwise().norm();
    }
    edges_.reserve(half_edges_.size());
    for (const std::uint32_t h : half_edges_) {
      const Triangle& face = surface_.faces()[h / 3];
      edges_.push_back({h, index_of(face[h % 3]), index_of(face[next_half_edge(h) % 3]),
                        static_cast<std::uint32_t>(edges_.size())});
    }
    whole_edges_ = edges_.size();
    find_boundary_faces();
  }

  BoundaryJoins find() {
    std::vector<std::uint32_t> all(edges_.size());
    for (std::uint32_t e = 0; e < all.size(); ++e) all[e] = e;
    const std::vector<std::uint32_t> alone = pair(all);
    settle();
    divide(alone);
    settle();
    close_holes();
    return take();
  }

 private:
  std::uint32_t index_of(std::uint32_t vertex) const {
    const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), vertex);
    return found != vertices_.end() && *found == vertex
               ? static_cast<std::uint32_t>(found - vertices_.begin())
               : kNone;
  }
  // The set of a vertex; kNone for a vertex that is not on the boundary.
  std::uint32_t set_of(std::uint32_t index) { return index == kNone ? kNone : sets_.lowest(index); }
  const Vec3& position(std::uint32_t index) const { return surface_.positions()[vertices_[index]]; }
  // The position that the vertex gets.
  const Vec3& joined(std::uint32_t index) { return position(sets_.lowest(index)); }

  bool counts_as_one(const Vec3& p, const Vec3& q, double extent_m) const {
    return is_within(p, q, join_bound_m(p, q, extent_m)) ||
           (limit_.most_m > 0.0 && length_m(p - q) <= limit_.most_m);
  }
  bool counts_as_one(std::uint32_t v, std::uint32_t w) {
    return sets_.lowest(v) == sets_.lowest(w) ||
           counts_as_one(joined(v), joined(w), std::min(extents_m_[v], extents_m_[w]));
  }
  bool is_tiny(const Edge& edge) { return counts_as_one(edge.from, edge.to); }

  // Everything that counts as one with a position on the edge is within this distance of it.
  Vec3 search_m(const Edge& edge) {
    const Vec3 bound_m = join_bound_m(joined(edge.from), joined(edge.to),
                                      std::max(extents_m_[edge.from], extents_m_[edge.to]));
    return kSearchMargin * bound_m.cwiseMax(reach_m_);
  }

  void find_boundary_faces() {
    std::vector<bool> is_on_boundary(surface_.positions().size(), false);
    for (const std::uint32_t v : vertices_) is_on_boundary[v] = true;
    for (std::uint32_t f = 0; f < surface_.face_count(); ++f) {
      const auto [a, b, c] = surface_.faces()[f];
      if (is_on_boundary[a] || is_on_boundary[b] || is_on_boundary[c]) faces_.push_back(f);
    }
  }

  // The corners of a face, as indices into the boundary vertices; kNone for other vertices.
  Triangle corners_of(std::uint32_t face) const {
    const auto [a, b, c] = surface_.faces()[face];
    return {index_of(a), index_of(b), index_of(c)};
  }

  // Pairs edges one to one. Returns the edges that have no mate. Tiny edges are left out: all their
  // ends are near each other.
  std::vector<std::uint32_t> pair(const std::vector<std::uint32_t>& edges) {
    std::vector<std::uint32_t> long_edges;
    std::vector<Vec3> middles;
    long_edges.reserve(edges.size());
    middles.reserve(edges.size());
    for (const std::uint32_t e : edges) {
      if (is_tiny(edges_[e])) continue;
      long_edges.push_back(e);
      middles.push_back(0.5 * (joined(edges_[e].from) + joined(edges_[e].to)));
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
  double apart_m(const Edge& edge, const Edge& mate) {
    const double ends_m = std::max(length_m(joined(edge.from) - joined(mate.to)),
                                   length_m(joined(edge.to) - joined(mate.from)));
    return std::max({ends_m, from_whole_m(edge), from_whole_m(mate)});
  }
  double length_m(const Vec3& difference) const { return (limit_.linear * difference).norm(); }
  double from_whole_m(const Edge& piece) {
    const Edge& whole = edges_[piece.whole];
    const Vec3 a = joined(whole.from);
    const Vec3 along = joined(whole.to) - a;
    double most_m = 0.0;
    for (const std::uint32_t v : {piece.from, piece.to}) {
      const Vec3 d = joined(v) - a;
      most_m = std::max(most_m, length_m(d - d.dot(along) / along.squaredNorm() * along));
    }
    return most_m;
  }

  // The only edge that can be joined with edge number i; kNone or kSeveral if there is no such one.
  std::uint32_t mate_of(std::uint32_t i, const std::vector<std::uint32_t>& edges,
                        const PointTree& tree) {
    const Edge& edge = edges_[edges[i]];
    const Vec3 search = search_m(edge);
    const Box box{tree.point(i) - search, tree.point(i) + search};
    std::uint32_t mate = kNone;
    std::size_t visits = 0;
    const bool is_complete = tree.visit_box(box, [&](std::uint32_t j) {
      if (++visits > kMostNear) return false;
      const Edge& other = edges_[edges[j]];
      const bool is_other_face = edge.half_edge / 3 != other.half_edge / 3;
      if (is_other_face && counts_as_one(edge.from, other.to) &&
          counts_as_one(edge.to, other.from)) {
        mate = mate == kNone ? j : kSeveral;
      }
      return mate != kSeveral;
    });
    if (visits > kMostNear) ++capped_edges_;
    return is_complete ? mate : kSeveral;
  }

  // Joins the ends of the pairs. Removes pairs that would join what does not count as one with the
  // lowest number, or would leave a face without area, until no such pair is left.
  void settle() {
    for (int round = 0;; ++round) {
      sets_ = LowestUnion(vertices_.size());
      for (const Pair& p : pairs_) {
        sets_.unite(edges_[p.edge].from, edges_[p.mate].to);
        sets_.unite(edges_[p.edge].to, edges_[p.mate].from);
      }
      std::vector<bool> is_wrong(vertices_.size(), false);  // by the lowest number
      bool any = mark_far(is_wrong);
      any = mark_flat(is_wrong) || any;
      any = mark_flat_pieces(is_wrong) || any;
      if (!any) return;
      const std::size_t before = pairs_.size();
      std::erase_if(pairs_, [&](const Pair& p) {
        const Edge& edge = edges_[p.edge];
        return round >= kMostRounds || is_wrong[sets_.lowest(edge.from)] ||
               is_wrong[sets_.lowest(edge.to)];
      });
      ambiguous_edges_ += 2 * (before - pairs_.size());
      if (round >= kMostRounds) capped_edges_ += 2 * (before - pairs_.size());
    }
  }

  bool mark_far(std::vector<bool>& is_wrong) {
    bool any = false;
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      const std::uint32_t lowest = sets_.lowest(v);
      if (v == lowest || counts_as_one(position(v), position(lowest),
                                       std::min(extents_m_[v], extents_m_[lowest]))) {
        continue;
      }
      any = is_wrong[lowest] = true;
    }
    return any;
  }

  bool mark_flat(std::vector<bool>& is_wrong) {
    bool any = false;
    for (const std::uint32_t f : faces_) {
      const Triangle corners = corners_of(f);
      std::array<Vec3, 3> p;
      bool is_moved = false;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = surface_.positions()[surface_.faces()[f][i]];
        if (corners[i] == kNone || sets_.lowest(corners[i]) == corners[i]) continue;
        p[i] = joined(corners[i]);
        is_moved = true;
      }
      if (!is_moved || !exactly_collinear(p[0], p[1], p[2])) continue;
      for (const std::uint32_t corner : corners) {
        if (corner != kNone) any = is_wrong[sets_.lowest(corner)] = true;
      }
    }
    return any;
  }

  // A vertex at which an edge is divided must not be joined with a corner of the divided face, nor
  // with the next such vertex.
  bool mark_flat_pieces(std::vector<bool>& is_wrong) {
    bool any = false;
    visit_divisions([&](const Edge& piece) {
      const std::uint32_t set = sets_.lowest(piece.from);
      bool is_flat = sets_.lowest(piece.to) == set;
      for (const std::uint32_t corner : surface_.faces()[piece.half_edge / 3]) {
        is_flat = is_flat || set_of(index_of(corner)) == set;
      }
      if (is_flat) any = is_wrong[set] = true;
    });
    return any;
  }

  // Divides the edges at vertices that lie on them, and pairs the pieces. alone: the edges without
  // a mate.
  void divide(const std::vector<std::uint32_t>& alone) {
    std::vector<std::uint32_t> ends;
    for (const std::uint32_t e : alone) {
      ends.insert(ends.end(), {sets_.lowest(edges_[e].from), sets_.lowest(edges_[e].to)});
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    const std::vector<Place> places = places_on(alone, ends);
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

  // The vertices that lie on edges, edge by edge, and in their order on each edge.
  std::vector<Place> places_on(const std::vector<std::uint32_t>& edges,
                               const std::vector<std::uint32_t>& ends) {
    std::vector<Vec3> positions;
    positions.reserve(ends.size());
    for (const std::uint32_t v : ends) positions.push_back(position(v));
    const PointTree tree(std::move(positions));
    const std::size_t count = edges.size() + ends.size();
    const std::size_t most_leaves =
        std::min(kMostLeaves * count, kLeavesOfAny + kMostFurtherLeaves * count);
    std::size_t leaves_left = most_leaves;
    std::size_t places_left = kMostPlaces * ends.size() + 1;
    std::vector<Place> places;
    for (const std::uint32_t e : edges) {
      const std::size_t first = places.size();
      if (places_left == 0 || !find_places(e, ends, tree, leaves_left, places_left, places)) {
        places.resize(first);
        ++ambiguous_edges_;
        if (places_left == 0 || leaves_left == 0) ++capped_edges_;
      }
    }
    examined_leaves_ += most_leaves - leaves_left;
    erase_places_on_two_edges(places);
    return places;
  }

  // A vertex that lies on two edges of one face lies near their common end; the face is thin.
  void erase_places_on_two_edges(std::vector<Place>& places) {
    using FaceVertex = std::pair<std::uint32_t, std::uint32_t>;
    const auto at = [&](const Place& p) {
      return FaceVertex(edges_[p.edge].half_edge / 3, p.vertex);
    };
    std::vector<FaceVertex> all;
    all.reserve(places.size());
    for (const Place& p : places) all.push_back(at(p));
    std::sort(all.begin(), all.end());
    std::erase_if(places, [&](const Place& p) {
      const auto [begin, end] = std::equal_range(all.begin(), all.end(), at(p));
      return end - begin > 1;
    });
  }

  // Appends the vertices that lie on an edge, in their order. Returns false if the order is not
  // certain.
  bool find_places(std::uint32_t e, const std::vector<std::uint32_t>& ends, const PointTree& tree,
                   std::size_t& leaves_left, std::size_t& places_left, std::vector<Place>& places) {
    const Edge& edge = edges_[e];
    const Vec3 a = joined(edge.from);
    const Vec3 along = joined(edge.to) - a;
    const double squared = along.squaredNorm();
    const Triangle& face = surface_.faces()[edge.half_edge / 3];
    const std::uint32_t apex = set_of(index_of(face[previous_half_edge(edge.half_edge) % 3]));
    const auto first = static_cast<std::ptrdiff_t>(places.size());
    const auto examine = [&](std::uint32_t i) {
      const std::uint32_t v = ends[i];
      const double t = (tree.point(i) - a).dot(along) / squared;
      const bool is_on = t > 0.0 && t < 1.0 && v != apex &&
                         counts_as_one(tree.point(i), a + t * along,
                                       std::min(extents_m_[v], extents_m_[edge.from])) &&
                         !counts_as_one(v, edge.from) && !counts_as_one(v, edge.to);
      if (is_on) places.push_back({e, v, t});
      return !is_on || --places_left > 0;
    };
    if (!tree.visit_segment(a, a + along, search_m(edge), leaves_left, examine)) return false;
    std::sort(places.begin() + first, places.end(), [](const Place& x, const Place& y) {
      return std::pair(x.along, x.vertex) < std::pair(y.along, y.vertex);
    });
    return std::adjacent_find(places.begin() + first, places.end(),
                              [&](const Place& x, const Place& y) {
                                return counts_as_one(x.vertex, y.vertex);
                              }) == places.end();
  }

  // Appends the pieces of an edge to the edges, or the edge itself if it is not divided.
  void append_pieces(std::uint32_t e, std::span<const Place> places,
                     std::vector<std::uint32_t>& pieces) {
    if (places.empty()) {
      pieces.push_back(e);
      return;
    }
    Edge piece = edges_[e];
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
    for (const Pair& p : pairs_) is_joined[p.edge] = is_joined[p.mate] = true;
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

  // Joins the vertices of holes whose edges are all tiny.
  void close_holes() {
    std::vector<bool> is_joined = joined_edges();
    for (std::size_t e = whole_edges_; e < edges_.size(); ++e) is_joined[edges_[e].whole] = true;
    for (std::size_t e = whole_edges_; e < edges_.size(); ++e) {
      if (!is_joined[e]) is_joined[edges_[e].whole] = false;
    }
    std::vector<std::uint32_t> next(vertices_.size(), kNone);  // by set: along a tiny edge
    std::vector<std::uint8_t> edges_out(vertices_.size(), 0), edges_in(vertices_.size(), 0);
    const auto count = [](std::uint8_t& n) { n = std::min<std::uint8_t>(n + 1, 2); };
    for (std::uint32_t e = 0; e < whole_edges_; ++e) {
      if (is_joined[e]) continue;
      const std::uint32_t from = sets_.lowest(edges_[e].from), to = sets_.lowest(edges_[e].to);
      count(edges_out[from]);
      count(edges_in[to]);
      if (is_tiny(edges_[e])) next[from] = to;
    }
    std::vector<bool> is_done(vertices_.size(), false);
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      std::vector<std::uint32_t> hole;
      std::uint32_t w = v;
      while (w != kNone && !is_done[w] && next[w] != kNone) {
        is_done[w] = true;
        const bool is_plain = edges_out[w] == 1 && edges_in[w] == 1;
        hole.push_back(w);
        w = is_plain ? next[w] : kNone;
      }
      // Two edges between the same two vertices surround no hole.
      if (w == v && hole.size() > 2) close_hole(hole);
    }
  }

  // hole: vertices of a closed chain; the first one is the lowest.
  void close_hole(const std::vector<std::uint32_t>& hole) {
    for (const std::uint32_t v : hole) {
      if (!counts_as_one(v, hole.front())) return;
    }
    holes_.push_back(hole);
  }

  BoundaryJoins take() {
    BoundaryJoins joins;
    SurfaceChanges& changes = joins.changes;
    changes.joined_edges = pairs_.size();
    visit_divisions([&](const Edge& rest) {
      changes.divisions.push_back({rest.half_edge, rest.from, rest.from_along});
    });
    join_holes();
    const std::vector<std::uint32_t> into = lowest_positions();
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      const std::uint32_t lowest = into[sets_.lowest(v)];
      if (lowest != vertices_[v]) changes.merged.push_back({vertices_[v], lowest});
    }
    for (EdgeDivision& d : changes.divisions) d.vertex = into[sets_.lowest(d.vertex)];
    std::sort(changes.divisions.begin(), changes.divisions.end(),
              [](const EdgeDivision& x, const EdgeDivision& y) {
                return std::pair(x.half_edge, x.along) < std::pair(y.half_edge, y.along);
              });
    joins.ambiguous_edges = ambiguous_edges_;
    joins.capped_edges = capped_edges_;
    joins.examined_leaves = examined_leaves_;
    for (const Pair& p : pairs_) joins.nearest_m = std::min(joins.nearest_m, p.apart_m);
    return joins;
  }

  // Joins the vertices of the holes that may close: all their vertices count as one with the
  // lowest, and no face has all its corners there.
  void join_holes() {
    if (holes_.empty()) return;
    std::vector<std::uint32_t> hole_of(vertices_.size(), kNone);  // by set
    for (std::uint32_t i = 0; i < holes_.size(); ++i) {
      for (const std::uint32_t v : holes_[i]) hole_of[v] = i;
    }
    const auto hole_at = [&](std::uint32_t v) { return v == kNone ? kNone : hole_of[set_of(v)]; };
    std::vector<bool> is_wrong(holes_.size(), false);
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      const std::uint32_t hole = hole_at(v);
      if (hole == kNone) continue;
      const std::uint32_t lowest = holes_[hole].front();
      if (!counts_as_one(position(v), position(lowest),
                         std::min(extents_m_[v], extents_m_[lowest]))) {
        is_wrong[hole] = true;
      }
    }
    for (const std::uint32_t f : faces_) {
      const Triangle face = corners_of(f);
      const std::uint32_t hole = hole_at(face[0]);
      if (hole != kNone && hole == hole_at(face[1]) && hole == hole_at(face[2])) {
        is_wrong[hole] = true;
      }
    }
    for (std::size_t i = 0; i < holes_.size(); ++i) {
      if (is_wrong[i]) {
        ambiguous_edges_ += holes_[i].size();
        continue;
      }
      for (const std::uint32_t v : holes_[i]) sets_.unite(v, holes_[i].front());
    }
  }

  // By the lowest boundary vertex of a set of several: the vertex of the surface with the lowest
  // number that counts as one with all of the set. It may be a vertex that no face uses.
  std::vector<std::uint32_t> lowest_positions() {
    std::vector<std::uint32_t> into = vertices_;
    std::vector<bool> has_several(vertices_.size(), false);
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      if (sets_.lowest(v) != v) has_several[sets_.lowest(v)] = true;
    }
    std::vector<std::uint32_t> sets;
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      if (has_several[v]) sets.push_back(v);
    }
    if (sets.empty()) return into;
    take_unused(sets, into);
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      const std::uint32_t lowest = sets_.lowest(v);
      const Vec3& p = surface_.positions()[into[lowest]];
      if (!counts_as_one(position(v), p, std::min(extents_m_[v], extents_m_[lowest]))) {
        into[lowest] = vertices_[lowest];
      }
    }
    return into;
  }

  // Replaces the lowest vertices of the sets by unused vertices of lower numbers near them.
  void take_unused(const std::vector<std::uint32_t>& sets, std::vector<std::uint32_t>& into) {
    std::vector<bool> is_used(surface_.positions().size(), false);
    for (const Triangle& face : surface_.faces()) {
      for (const std::uint32_t v : face) is_used[v] = true;
    }
    std::vector<Vec3> positions;
    positions.reserve(sets.size());
    for (const std::uint32_t v : sets) positions.push_back(position(v));
    const PointTree tree(std::move(positions));
    const double largest_m = *std::max_element(extents_m_.begin(), extents_m_.end());
    for (std::uint32_t u = 0; u < is_used.size(); ++u) {
      if (is_used[u]) continue;
      const Vec3& p = surface_.positions()[u];
      const Vec3 search = kSearchMargin * join_bound_m(p, p, largest_m).cwiseMax(reach_m_);
      std::uint32_t near = kNone;
      std::size_t visits = 0;
      tree.visit_box({p - search, p + search}, [&](std::uint32_t i) {
        if (++visits > kMostNear) near = kSeveral;
        if (counts_as_one(p, position(sets[i]), extents_m_[sets[i]])) {
          near = near == kNone ? sets[i] : kSeveral;
        }
        return near != kSeveral;
      });
      if (near < kSeveral && u < into[near]) into[near] = u;
    }
  }

  const WeldedSurface& surface_;
  const GapLimit& limit_;
  Vec3 reach_m_;  // half the extent of the box around all differences within the limit
  std::vector<std::uint32_t> half_edges_;
  std::vector<std::uint32_t> vertices_;  // of the boundary, ascending
  std::vector<double> extents_m_;        // of the parts of these vertices
  std::vector<Edge> edges_;              // the whole edges, then pieces
  std::size_t whole_edges_ = 0;
  std::vector<std::uint32_t> faces_;  // with a boundary vertex
  std::vector<Pair> pairs_;
  LowestUnion sets_;  // vertices that are joined
  std::vector<std::vector<std::uint32_t>> holes_;
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
  constexpr std::uint64_t kPerEdge = 2 * 3 * kIndex + sizeof(Edge) + PointTree::bytes(1) + kIndex +
                                     2 * sizeof(Pair) + 2 * 3 * kIndex + 2 * sizeof(Place) +
                                     2 * sizeof(Edge) + 2 * kIndex +
                                     2 * (kIndex + sizeof(MergedVertex) + sizeof(EdgeDivision));
  // Per boundary vertex, of which there are at most two per edge: number, extent, set, marks.
  constexpr std::uint64_t kPerVertex = 4 * kIndex + sizeof(double);
  // Per position and face: parts and marks; faces at the boundary.
  constexpr std::uint64_t kPerPosition = 2 * kIndex + 1;
  return edges * (kPerEdge + 2 * kPerVertex) + surface.positions().size() * kPerPosition +
         2 * surface.face_count() * kIndex;
}

}  // namespace palpate
