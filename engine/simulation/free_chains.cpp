#include "engine/simulation/free_chains.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "geometry/mesh/planar_pieces.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

// The curve and segment of a planar segment. The last segment of an open curve closes the curve.
struct Source {
  std::uint32_t curve, segment;
  bool is_closing;
};

// All coincident pieces between two vertices.
struct Edge {
  std::array<std::uint32_t, 2> ends;
  std::uint32_t begin, end;  // range of pieces_by_edge_
  std::array<bool, 2>
      is_solid;  // on the left and on the right of the direction from ends[0] to ends[1]
};

// A half-edge: one direction of an edge, which a chain may follow.
struct HalfEdge {
  std::uint32_t edge, piece;
  std::uint32_t next = kNone;
  bool has_previous = false;
  bool exists = false;
  bool is_sheet = false;  // free on both sides, and the opposite half-edge does not exist
  bool is_of_open = false;
};

class ChainFinder {
 public:
  ChainFinder(const std::vector<Polyline>& curves, const Vec3& plane_normal) : curves_(curves) {
    const Vec3 u = plane_normal.unitOrthogonal();
    const Vec3 v = plane_normal.cross(u);
    double largest_m = 0.0;
    std::vector<PlanarSegment> segments;
    const auto on_plane = [&](const Vec3& p) { return Eigen::Vector2d(p.dot(u), p.dot(v)); };
    for (std::uint32_t c = 0; c < curves.size(); ++c) {
      const std::vector<Vec3>& points_m = curves[c].points_m;
      const auto count = static_cast<std::uint32_t>(points_m.size());
      for (const Vec3& p : points_m) largest_m = std::max(largest_m, p.cwiseAbs().maxCoeff());
      for (std::uint32_t i = 0; i < count; ++i) {
        segments.push_back({on_plane(points_m[i]), on_plane(points_m[(i + 1) % count])});
        sources_.push_back({c, i, !curves[c].closed && i + 1 == count});
      }
    }
    arrangement_ = planar_pieces(segments, largest_m);
  }

  FreeChains run() {
    if (arrangement_.gave_up) return {{}, arrangement_.merged_m, true};
    find_edges();
    find_solid();
    find_half_edges();
    link_half_edges();
    FreeChains found{{}, arrangement_.merged_m, false};
    std::vector<bool> is_done(half_edges_.size(), false);
    for (const bool closed : {false, true}) {
      for (const std::uint32_t w : half_edges_in_order_) {
        if (is_done[w] || (!closed && half_edges_[w].has_previous)) continue;
        found.chains.push_back(chain_from(w, closed, is_done));
      }
    }
    return found;
  }

 private:
  const PlanarPiece& piece(std::uint32_t p) const { return arrangement_.pieces[p]; }
  const Source& source(std::uint32_t p) const { return sources_[piece(p).segment]; }
  const GridPoint& at(std::uint32_t vertex) const { return arrangement_.vertices[vertex].at; }
  bool is_open(std::uint32_t p) const { return !curves_[source(p).curve].closed; }

  // --- edges

  void find_edges() {
    const std::vector<PlanarPiece>& pieces = arrangement_.pieces;
    const auto ends = [&](std::uint32_t p) { return std::minmax(piece(p).from, piece(p).to); };
    pieces_by_edge_.resize(pieces.size());
    for (std::uint32_t p = 0; p < pieces.size(); ++p) pieces_by_edge_[p] = p;
    std::sort(pieces_by_edge_.begin(), pieces_by_edge_.end(),
              [&](std::uint32_t a, std::uint32_t b) {
                return ends(a) != ends(b) ? ends(a) < ends(b) : a < b;
              });
    edge_of_piece_.resize(pieces.size());
    for (std::uint32_t k = 0; k < pieces_by_edge_.size(); ++k) {
      const std::uint32_t p = pieces_by_edge_[k];
      if (k == 0 || ends(p) != ends(pieces_by_edge_[k - 1])) {
        edges_.push_back({{ends(p).first, ends(p).second}, k, k, {false, false}});
      }
      ++edges_.back().end;
      edge_of_piece_[p] = static_cast<std::uint32_t>(edges_.size() - 1);
    }
    first_at_vertex_.assign(arrangement_.vertices.size() + 1, 0);
    for (const Edge& edge : edges_) {
      for (const std::uint32_t v : edge.ends) ++first_at_vertex_[v + 1];
    }
    for (std::size_t v = 0; v + 1 < first_at_vertex_.size(); ++v) {
      first_at_vertex_[v + 1] += first_at_vertex_[v];
    }
    edges_at_vertex_.resize(first_at_vertex_.back());
    std::vector<std::uint32_t> filled = first_at_vertex_;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      for (const std::uint32_t v : edges_[e].ends) edges_at_vertex_[filled[v]++] = e;
    }
  }

  std::uint32_t edges_at(std::uint32_t vertex) const {
    return first_at_vertex_[vertex + 1] - first_at_vertex_[vertex];
  }
  std::uint32_t other_end(std::uint32_t edge, std::uint32_t vertex) const {
    const auto& ends = edges_[edge].ends;
    return ends[0] == vertex ? ends[1] : ends[0];
  }

  // --- solid

  void find_solid() {
    std::vector<GridBox> boxes;
    boxes.reserve(arrangement_.pieces.size());
    for (const PlanarPiece& p : arrangement_.pieces) {
      boxes.push_back(GridBox{at(p.from), at(p.from)}.united({at(p.to), at(p.to)}));
    }
    const PlanarBoxes tree(std::move(boxes));
    const bool all_closed = std::all_of(curves_.begin(), curves_.end(),
                                        [](const Polyline& curve) { return curve.closed; });
    if (all_closed) {
      spread_windings(tree);
    } else {
      classify_rows(tree);
    }
  }

  // If all curves are closed, a ray is cast for one edge of each connected component. The other
  // winding numbers follow: around a vertex, the region on the left of an edge is on the right of
  // the next.
  void spread_windings(const PlanarBoxes& tree) {
    std::vector<int> left(2 * edges_.size(), 0);  // winding number by half-edge
    std::vector<bool> is_known(edges_.size(), false);
    std::vector<bool> is_done(arrangement_.vertices.size(), false);
    std::vector<std::uint32_t> open;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      if (is_known[e]) continue;
      is_known[e] = true;
      const bool is_far_left = find_windings(e, tree);
      left[2 * e] = (is_far_left ? far_side_ : near_side_).closed;
      left[2 * e + 1] = (is_far_left ? near_side_ : far_side_).closed;
      open.assign({edges_[e].ends[0], edges_[e].ends[1]});
      while (!open.empty()) {
        const std::uint32_t v = open.back();
        open.pop_back();
        if (is_done[v]) continue;
        is_done[v] = true;
        const std::vector<std::uint32_t> around = half_edges_around(v);
        const auto first = std::find_if(around.begin(), around.end(),
                                        [&](std::uint32_t w) { return is_known[w / 2]; });
        const auto begin = static_cast<std::size_t>(first - around.begin());
        for (std::size_t n = 1; n < around.size(); ++n) {
          const std::uint32_t before = around[(begin + n - 1) % around.size()];
          const std::uint32_t w = around[(begin + n) % around.size()];
          if (is_known[w / 2]) continue;
          is_known[w / 2] = true;
          left[w ^ 1] = left[before];
          left[w] = left[before] + turns_along(w);
          open.push_back(to(w));
        }
      }
    }
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      edges_[e].is_solid = {left[2 * e] > 0, left[2 * e + 1] > 0};
    }
  }

  // The number of pieces of an edge along a half-edge minus the number against it: the winding
  // number on its left minus that on its right.
  int turns_along(std::uint32_t w) const {
    int turns = 0;
    for (std::uint32_t k = edges_[w / 2].begin; k < edges_[w / 2].end; ++k) {
      turns += piece(pieces_by_edge_[k]).from == from(w) ? 1 : -1;
    }
    return turns;
  }

  // Edges in a row that no other edge meets have the same regions on their sides; a ray is cast for
  // the longest edge only.
  void classify_rows(const PlanarBoxes& tree) {
    std::vector<bool> is_done(edges_.size(), false);
    std::vector<std::pair<std::uint32_t, bool>>
        row;  // edge, and whether it points the same way as the first
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      if (is_done[e]) continue;
      is_done[e] = true;
      row.assign(1, {e, true});
      for (const std::size_t end : {1u, 0u}) {
        std::uint32_t vertex = edges_[e].ends[end];
        std::uint32_t last = e;
        while (edges_at(vertex) == 2) {
          const std::uint32_t first = first_at_vertex_[vertex];
          const std::uint32_t next = edges_at_vertex_[first] == last ? edges_at_vertex_[first + 1]
                                                                     : edges_at_vertex_[first];
          if (is_done[next]) break;
          is_done[next] = true;
          row.emplace_back(next, edges_[next].ends[1 - end] == vertex);
          vertex = other_end(next, vertex);
          last = next;
        }
      }
      const auto length = [&](const auto& r) {
        const GridPoint along = at(edges_[r.first].ends[1]) - at(edges_[r.first].ends[0]);
        return dot(along, along);
      };
      const auto longest =
          *std::max_element(row.begin(), row.end(),
                            [&](const auto& a, const auto& b) { return length(a) < length(b); });
      const std::array<bool, 2> sides = sides_of(longest.first, tree);
      for (const auto& [edge, is_along] : row) {
        edges_[edge].is_solid =
            is_along == longest.second ? sides : std::array<bool, 2>{sides[1], sides[0]};
      }
    }
  }

  // Whether the region on the left of an edge is solid, and on the right. A ray from the middle of
  // the edge, along x or y, whichever is more across the edge, meets the curves that enclose either
  // side. Exact.
  std::array<bool, 2> sides_of(std::uint32_t e, const PlanarBoxes& tree) {
    const bool is_far_left = find_windings(e, tree);
    const bool is_far_solid = is_solid(far_side_);
    const bool is_near_solid = is_solid(near_side_);
    return is_far_left ? std::array<bool, 2>{is_far_solid, is_near_solid}
                       : std::array<bool, 2>{is_near_solid, is_far_solid};
  }

  // Finds the winding numbers on both sides of an edge; returns true if the far side is on its
  // left.
  bool find_windings(std::uint32_t e, const PlanarBoxes& tree) {
    const GridPoint a = at(edges_[e].ends[0]);
    const GridPoint b = at(edges_[e].ends[1]);
    const bool along_x = std::abs(b.y - a.y) >= std::abs(b.x - a.x);  // the ray
    const GridPoint middle{a.x + b.x, a.y + b.y};                     // doubled
    constexpr std::int64_t kFar = std::numeric_limits<std::int32_t>::max();
    const auto below = [](std::int64_t x) { return x >= 0 ? x / 2 : -((1 - x) / 2); };
    GridBox ray{{below(middle.x), below(middle.y)}, {below(middle.x + 1), below(middle.y + 1)}};
    (along_x ? ray.high.x : ray.high.y) = kFar;
    far_side_.clear();
    near_side_.clear();
    tree.visit(ray, [&](std::uint32_t p) {
      const bool is_here = edge_of_piece_[p] == e;
      const int turns = turns_about(middle, p, along_x, is_here);
      if (turns == 0) return;
      add(near_side_, p, turns);
      if (!is_here) add(far_side_, p, turns);
    });
    return along_x ? b.y < a.y : b.x > a.x;
  }

  // The contribution of a piece to the winding number about a point for a ray along x or y: +-1 if
  // the ray meets the piece, else 0. middle: the point, doubled. is_met: the piece passes through
  // the point and counts as met.
  int turns_about(const GridPoint& middle, std::uint32_t p, bool along_x, bool is_met) const {
    const GridPoint& from = at(piece(p).from);
    const GridPoint& to = at(piece(p).to);
    GridPoint a{2 * from.x - middle.x, 2 * from.y - middle.y};
    GridPoint b{2 * to.x - middle.x, 2 * to.y - middle.y};
    if (!along_x) {
      std::swap(a.x, a.y);
      std::swap(b.x, b.y);
    }
    if ((a.y <= 0) == (b.y <= 0)) return 0;
    const int up = b.y > a.y ? 1 : -1;
    if (!is_met && up * cross(a, b) <= 0) return 0;
    return along_x ? up : -up;
  }

  // The winding number of all closed curves that a ray meets, and the contributions of the pieces
  // of open curves.
  struct Windings {
    int closed = 0;
    std::vector<std::pair<std::uint32_t, int>> open;

    void clear() {
      closed = 0;
      open.clear();
    }
  };
  void add(Windings& windings, std::uint32_t p, int turns) const {
    if (is_open(p)) {
      windings.open.emplace_back(source(p).curve, turns);
    } else {
      windings.closed += turns;
    }
  }
  static bool is_solid(Windings& windings) {
    auto& open = windings.open;
    std::sort(open.begin(), open.end());
    int sum = windings.closed;
    for (std::size_t k = 0; k < open.size();) {
      const std::uint32_t curve = open[k].first;
      int winding = 0;
      for (; k < open.size() && open[k].first == curve; ++k) winding += open[k].second;
      sum += std::max(0, winding);
    }
    return sum > 0;
  }

  // --- half-edges; two for each edge, the second from ends[1] to ends[0]

  std::uint32_t from(std::uint32_t w) const { return edges_[w / 2].ends[w % 2]; }
  std::uint32_t to(std::uint32_t w) const { return edges_[w / 2].ends[1 - w % 2]; }
  bool is_solid_left(std::uint32_t w) const { return edges_[w / 2].is_solid[w % 2]; }
  bool is_solid_right(std::uint32_t w) const { return edges_[w / 2].is_solid[1 - w % 2]; }

  void find_half_edges() {
    half_edges_.resize(2 * edges_.size());
    for (std::uint32_t w = 0; w < half_edges_.size(); ++w) {
      const Edge& edge = edges_[w / 2];
      HalfEdge& half_edge = half_edges_[w];
      half_edge.edge = w / 2;
      half_edge.piece = kNone;
      half_edge.is_of_open = true;
      for (std::uint32_t k = edge.begin; k < edge.end; ++k) {
        const std::uint32_t p = pieces_by_edge_[k];
        if (piece(p).from != from(w) || source(p).is_closing) continue;
        half_edge.piece = std::min(half_edge.piece, p);
        half_edge.is_of_open = half_edge.is_of_open && is_open(p);
      }
      half_edge.exists = half_edge.piece != kNone && !is_solid_right(w);
      if (half_edge.exists) half_edges_in_order_.push_back(w);
    }
    for (const std::uint32_t w : half_edges_in_order_) {
      half_edges_[w].is_sheet = !is_solid_left(w) && !half_edges_[w ^ 1].exists;
    }
    std::sort(half_edges_in_order_.begin(), half_edges_in_order_.end(),
              [&](std::uint32_t a, std::uint32_t b) {
                return half_edges_[a].piece < half_edges_[b].piece;
              });
  }

  void link_half_edges() {
    for (std::uint32_t v = 0; v < arrangement_.vertices.size(); ++v) {
      const std::vector<std::uint32_t> around = half_edges_around(v);
      link_around(around, false);
      link_around(around, true);
    }
  }

  // The half-edges that begin at a vertex, counter-clockwise.
  std::vector<std::uint32_t> half_edges_around(std::uint32_t v) const {
    std::vector<std::uint32_t> around;
    for (std::uint32_t k = first_at_vertex_[v]; k < first_at_vertex_[v + 1]; ++k) {
      const std::uint32_t e = edges_at_vertex_[k];
      around.push_back(2 * e + (edges_[e].ends[0] == v ? 0 : 1));
    }
    std::sort(around.begin(), around.end(),
              [&](std::uint32_t a, std::uint32_t b) { return is_before(a, b); });
    return around;
  }

  // Compares by the angle from the x axis.
  bool is_before(std::uint32_t a, std::uint32_t b) const {
    const GridPoint p = at(to(a)) - at(from(a));
    const GridPoint q = at(to(b)) - at(from(b));
    const auto half = [](const GridPoint& d) { return d.y < 0 || (d.y == 0 && d.x < 0); };
    if (half(p) != half(q)) return half(q);
    const std::int64_t turn = cross(p, q);
    return turn != 0 ? turn > 0 : a < b;
  }

  // Links each arriving half-edge to the next one counter-clockwise, as long as the region between
  // them is free. In a second pass (is_rest) the remaining half-edges, for example at the end of a
  // shell that turns into a sheet, are linked to any that are left.
  void link_around(const std::vector<std::uint32_t>& around, bool is_rest) {
    const std::size_t count = around.size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t arriving = around[i] ^ 1;
      if (!half_edges_[arriving].exists || half_edges_[arriving].next != kNone) continue;
      for (std::size_t n = 1; n <= count; ++n) {
        const std::uint32_t w = around[(i + n) % count];
        const bool fits =
            is_rest ? w != around[i] : half_edges_[w].is_sheet == half_edges_[arriving].is_sheet;
        if (half_edges_[w].exists && !half_edges_[w].has_previous && fits) {
          half_edges_[arriving].next = w;
          half_edges_[w].has_previous = true;
          break;
        }
        if (!is_rest && is_solid_left(w) && !is_solid_right(w)) break;
      }
    }
  }

  // --- chains

  Vec3 place(std::uint32_t vertex) const {
    const PlanarVertex& v = arrangement_.vertices[vertex];
    const Source& s = sources_[v.segment];
    const std::vector<Vec3>& points_m = curves_[s.curve].points_m;
    const Vec3& a = points_m[s.segment];
    const Vec3& b = points_m[(s.segment + 1) % points_m.size()];
    if (v.share == 0.0) return a;
    return v.share == 1.0 ? b : Vec3(a + v.share * (b - a));
  }

  FreeChain chain_from(std::uint32_t first, bool closed, std::vector<bool>& is_done) const {
    FreeChain chain{{}, closed, true, half_edges_[first].is_sheet};
    const auto add_point = [&](std::uint32_t vertex, std::uint32_t w) {
      const Source& s = source(half_edges_[w].piece);
      chain.points.push_back({place(vertex), s.curve, s.segment, edges_at(vertex) > 2});
    };
    std::uint32_t last = first;
    for (std::uint32_t w = first; w != kNone && !is_done[w]; w = half_edges_[w].next) {
      is_done[w] = true;
      add_point(from(w), w);
      chain.has_two_sides = chain.has_two_sides && half_edges_[w].is_of_open;
      last = w;
    }
    if (!closed) add_point(to(last), last);
    return chain;
  }

  const std::vector<Polyline>& curves_;
  std::vector<Source> sources_;  // by segment
  PlanarPieces arrangement_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> pieces_by_edge_;
  std::vector<std::uint32_t> edge_of_piece_;
  std::vector<std::uint32_t> first_at_vertex_;  // in edges_at_vertex_
  std::vector<std::uint32_t> edges_at_vertex_;
  std::vector<HalfEdge> half_edges_;
  std::vector<std::uint32_t> half_edges_in_order_;  // the existing half-edges
  Windings far_side_, near_side_;                   // results of find_windings()
};

}  // namespace

FreeChains free_chains(const std::vector<Polyline>& curves, const Vec3& plane_normal) {
  return ChainFinder(curves, plane_normal).run();
}

}  // namespace palpate
