#include "engine/scene/seams.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "geometry/exact/orientation.h"
#include "geometry/index/touching_boxes.h"
#include "geometry/mesh/boundary_vertices.h"
#include "geometry/mesh/point_grid.h"
#include "geometry/mesh/shared_cells.h"
#include "haptics/proxy/contact_world.h"

namespace palpate {
namespace {

// The three constants below bound the distance of a vertex in the solver frame from its exact
// position in the file. Let u be the unit roundoff, v the vertex in the mesh frame, and L and t the
// linear part and the translation of each transform from the mesh to the scene. All bounds are in
// units of u times |L..| |v| + sum |L..| |t| (TransformProduct), where |L| |v| is the sum of
// |L's columns| |v's components|.
//
// For each transform: 2 for rounding its numbers to double; 18 for the matrix of a quaternion (sums
// of four products, divided by the square of its length); 2 for the scale; 9 for the product with
// the parent transform (3 per entry, where the magnitudes of two rotations can be 5/3 as long as
// the rotations).
constexpr double kRoundoffPerTransform = 32 * kUnitRoundoff;
// For each vertex: 5 for three products and their sums, 1 for the translation relative to the
// anchor, 1 for adding this translation.
constexpr double kRoundoffPerVertex = 8 * kUnitRoundoff;
// For the program that wrote the file: it may have computed a quaternion or a matrix as a product
// of two, and rotated an offset by it, in double.
constexpr double kRoundoffOfWriter = 32 * kUnitRoundoff;

// Bounds the distance between a vertex in the solver frame and the same vertex of the index after
// the body's pose was applied. The difference between rotation times deformation and the linear
// part is counted separately. In units of u: 8 for the deformed vertex and the middle of the index;
// 4 for the unit of the body (its inverse, and a product in each direction); 24 for rotating a
// point by a quaternion in both directions; 16 for the product used to compute the difference.
// Transforming a query point to the index adds 24 of its distance from the body, which is less than
// three sizes of the scene for every step that can touch the body.
constexpr double kFrameRoundoff = 72 * kUnitRoundoff;

// Limits on the two bounds, in stand-offs. With them a joined vertex is within
// kMostApartPerStandOff of its position in the index, even if it was moved by the rounding errors
// of two surfaces.
constexpr double kMostJoinPerStandOff = 0.1;
constexpr double kMostFramePerStandOff = 0.1;
static_assert(kMostJoinPerStandOff + kMostFramePerStandOff <= kMostApartPerStandOff);

// Size of a grid cell, in units of the largest distance of joined vertices. Nearly all queries then
// visit one cell.
constexpr double kCellPerJoin = 64.0;

// Limit on the places near one vertex. If rounding errors are small relative to the mesh, a vertex
// is near one place, or near two if it lies halfway between them. If it is near many places, its
// mesh is smaller than the rounding errors, and its vertices cannot be distinguished.
constexpr std::size_t kMostMet = 16;

// The most vertices of all near surfaces together whose cells are searched, about a second of work
// with what follows. A boundary edge counts as several, because its points have places in the
// cells, which take memory. A thousand nodes of 50,000 vertices that all touch others have fewer.
constexpr std::size_t kMostVerticesSearched = std::size_t{1} << 26;
constexpr std::size_t kVerticesPerBoundaryEdge = 4;

// Properties of a mesh, shared by all its surfaces.
struct MeshOutline {
  Box box;
  Vec3 reach_m;                               // largest |coordinate| of its vertices, by axis
  std::vector<std::uint32_t> boundary;        // ascending; filled on demand, for open meshes only
  std::optional<SharedCells::Points> points;  // filled on demand
};

MeshOutline outline_of(const WeldedSurface& mesh) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  MeshOutline outline{{Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity)}, {}, {}, {}};
  for (const Vec3& p : mesh.positions()) outline.box = outline.box.united({p, p});
  outline.reach_m = outline.box.low.cwiseAbs().cwiseMax(outline.box.high.cwiseAbs());
  return outline;
}

// A surface with the error bounds that follow from its transform.
struct Placed {
  const SeamSurface* surface;
  Vec3 translation_solver_m;
  double rounding_m = 0.0;  // bound on the error of its vertices, see kRoundoffPerTransform
  double apart_m = 0.0;     // bound on the distance of its index, see kFrameRoundoff
  std::vector<std::uint32_t> joining;  // SeamSurface::met and the boundary; empty without met
  std::size_t first_shared = 0;        // of its vertices in SeamSearch::is_shared_
  std::vector<std::uint32_t> inner;    // vertices inside the boundary near other boundaries

  Placed(const SeamSurface& s, const Vec3& anchor_scene_m)
      : surface(&s), translation_solver_m(s.node->translation_m - anchor_scene_m) {}

  // Computes the bounds. reach_m: MeshOutline::reach_m. size_m: the largest extent of the scene.
  void bound(const Vec3& reach_m, double size_m) {
    const NodeDescription& node = *surface->node;
    const Vec3 columns = node.linear_scene_mesh.colwise().norm();
    const double length_m = columns.dot(reach_m);
    const double terms_m = columns.cwiseMax(node.product.columns).dot(reach_m) +
                           std::max(node.product.translation_m, node.translation_m.norm());
    const double factors = std::max<std::uint32_t>(node.product.factors, 1);
    const double from_anchor_m = translation_solver_m.norm();
    rounding_m =
        (kRoundoffPerTransform * factors + kRoundoffPerVertex + kRoundoffOfWriter) * terms_m +
        kRoundoffPerVertex * from_anchor_m;
    const Mat3 moved = surface->rotation.toRotationMatrix() * surface->deformation;
    apart_m = ((moved - node.linear_scene_mesh).cwiseAbs() * reach_m).norm() +
              kFrameRoundoff * (length_m + node.translation_m.norm() + from_anchor_m + 2 * size_m);
  }

  Vec3 vertex(const Vec3& v_mesh) const {
    return solver_vertex(surface->node->linear_scene_mesh, translation_solver_m, v_mesh);
  }
  // The bounding box of the surface, with a margin for the position error of surfaces far from the
  // origin.
  Box box_solver(const Box& box_mesh) const {
    const NodeDescription& node = *surface->node;
    const Vec3 centre = vertex(0.5 * (box_mesh.low + box_mesh.high));
    const Vec3 half = node.linear_scene_mesh.cwiseAbs() * (0.5 * (box_mesh.high - box_mesh.low));
    const double far_m = node.translation_m.lpNorm<1>() + node.product.translation_m;
    return Box{centre - half, centre + half}.grown(kRoundoffPerTransform * far_m);
  }
};

// A vertex that may coincide with vertices of other surfaces.
struct Candidate {
  std::uint32_t vertex;
  bool is_on_boundary;
  Vec3 position_m;
};
// A position at which vertices may coincide.
struct Place {
  Vec3 position_m;    // of its first vertex
  double rounding_m;  // of the surface of its first vertex
  bool has_boundary;  // whether one of its vertices is on a boundary
  // The last surface that joined. Surfaces join in ascending order, so comparing with the last one
  // ensures that each surface joins at most once.
  std::uint32_t last;
  std::uint32_t vertices = 1;
};
// A vertex at a place.
struct Membership {
  std::uint32_t surface;
  std::uint32_t vertex;
  std::uint32_t place;
  bool is_moved;
};

bool is_within(const Vec3& p, const Vec3& q, double distance_m) {
  return (p - q).squaredNorm() <= distance_m * distance_m;
}

struct BoundaryPoint {
  std::uint32_t surface;
  Vec3 position_m;
};

// Finds points on boundaries by position.
class BoundaryGrid {
 public:
  BoundaryGrid(const std::vector<BoundaryPoint>& points, double distance_m)
      : points_(points),
        distance_m_(distance_m),
        grid_(kCellPerJoin * distance_m, points.size()),
        cells_(box_around(points).grown(distance_m), distance_m) {
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      grid_.insert(points[i].position_m, i);
      cells_.mark(points[i].position_m);
    }
  }

  // Whether p is within the distance of a boundary point of another surface. No value if too many
  // points are near p.
  std::optional<bool> is_near_another(const Vec3& p, std::uint32_t surface) const {
    if (!cells_.may_hold(p)) return false;
    bool is_near = false;
    const bool is_certain = grid_.visit_near(p, distance_m_, [&](std::uint32_t i) {
      const BoundaryPoint& point = points_[i];
      is_near = point.surface != surface && is_within(p, point.position_m, distance_m_);
      return !is_near;
    });
    return is_certain ? std::optional(is_near) : std::nullopt;
  }

 private:
  static Box box_around(const std::vector<BoundaryPoint>& points) {
    Box box{Vec3::Zero(), Vec3::Zero()};
    if (!points.empty()) box = {points[0].position_m, points[0].position_m};
    for (const BoundaryPoint& p : points) box = box.united({p.position_m, p.position_m});
    return box;
  }

  const std::vector<BoundaryPoint>& points_;
  double distance_m_;
  PointGrid grid_;
  OccupiedCells cells_;
};

class SeamSearch {
 public:
  SeamSearch(const std::vector<WeldedSurface>& meshes, std::span<const SeamSurface> surfaces,
             const Vec3& anchor_scene_m, double size_m, MemoryLedger& ledger)
      : meshes_(meshes),
        ledger_(ledger),
        size_m_(size_m),
        most_m_(kMostJoinPerStandOff * SolverScale::of(size_m, 0.0).stand_off_m),
        most_apart_m_(kMostFramePerStandOff * SolverScale::of(size_m, 0.0).stand_off_m) {
    outlines_.reserve(meshes.size());
    for (const WeldedSurface& mesh : meshes) outlines_.push_back(outline_of(mesh));
    placed_.reserve(surfaces.size());
    for (const SeamSurface& s : surfaces) placed_.emplace_back(s, anchor_scene_m);
  }

  Result<Seams> find() {
    find_near();
    limit_near();
    if (near_.empty()) return std::move(seams_);
    if (auto error = find_shared_boundary_points()) return *error;
    if (points_.empty()) return std::move(seams_);
    const BoundaryGrid boundary(points_, most_m_);
    PointGrid places(kCellPerJoin * most_m_, most_candidates_);
    for (const std::uint32_t s : near_) {
      const auto vertices = candidates(s, boundary);
      if (!vertices || !join(s, *vertices, places)) seams_.crowded.push_back(s);
    }
    collect();
    return std::move(seams_);
  }

 private:
  using Pair = std::tuple<double, std::uint32_t, std::uint32_t>;  // squared, candidate, place

  const WeldedSurface& mesh(std::uint32_t s) const {
    return meshes_[placed_[s].surface->node->mesh];
  }
  MeshOutline& outline(std::uint32_t s) { return outlines_[placed_[s].surface->node->mesh]; }
  bool is_open(std::uint32_t s) const {
    return mesh(s).report().boundary_edges > 0 || !placed_[s].surface->met.empty();
  }
  // The vertices that may be joined: the boundary, and those that meet others.
  const std::vector<std::uint32_t>& joining(std::uint32_t s) {
    return placed_[s].joining.empty() ? outline(s).boundary : placed_[s].joining;
  }

  // Finds the surfaces that may touch another surface where one of the two is open. Surfaces with
  // too large error bounds are reported as too far.
  void find_near() {
    std::vector<Box> boxes;
    std::vector<bool> open;
    boxes.reserve(placed_.size());
    for (std::uint32_t s = 0; s < placed_.size(); ++s) {
      boxes.push_back(placed_[s].box_solver(outline(s).box).grown(most_m_ + most_apart_m_));
      open.push_back(is_open(s));
    }
    const std::vector<bool> touches = may_touch_marked(boxes, open);
    for (std::uint32_t s = 0; s < placed_.size(); ++s) {
      if (!touches[s]) continue;
      placed_[s].bound(outline(s).reach_m, size_m_);
      // The errors of two surfaces add up. The comparison is false for NaN.
      const bool is_certain =
          2 * placed_[s].rounding_m <= most_m_ && placed_[s].apart_m <= most_apart_m_;
      (is_certain ? near_ : seams_.too_far).push_back(s);
    }
  }

  // Leaves out the surfaces beyond kMostVerticesSearched.
  void limit_near() {
    std::size_t vertices = 0;
    std::erase_if(near_, [&](std::uint32_t s) {
      vertices +=
          mesh(s).positions().size() + kVerticesPerBoundaryEdge * mesh(s).report().boundary_edges;
      if (vertices <= kMostVerticesSearched) return false;
      seams_.unsearched.push_back(s);
      return true;
    });
  }

  // Finds the boundaries of the open surfaces in near_, and counts their points.
  std::size_t count_boundary_points() {
    std::size_t count = 0;
    for (const std::uint32_t s : near_) {
      std::vector<std::uint32_t>& boundary = outline(s).boundary;
      if (mesh(s).report().boundary_edges > 0 && boundary.empty()) {
        boundary = boundary_vertices(mesh(s));
      }
      const std::span<const std::uint32_t> met = placed_[s].surface->met;
      if (!met.empty()) {
        std::set_union(boundary.begin(), boundary.end(), met.begin(), met.end(),
                       std::back_inserter(placed_[s].joining));
      }
      count += joining(s).size();
    }
    return count;
  }

  Vec3 vertex(std::uint32_t s, std::uint32_t v) const {
    return placed_[s].vertex(mesh(s).positions()[v]);
  }

  // Collects the boundary points that share a small cell with a vertex of another surface. No other
  // boundary point can coincide with a vertex of another surface.
  std::optional<Error> find_shared_boundary_points() {
    const std::size_t most = count_boundary_points();
    if (auto error = ledger_.check(SharedCells::bytes(most))) return error;
    SharedCells cells(kCellPerJoin * most_m_, most);
    std::erase_if(near_, [&](std::uint32_t s) {
      const bool is_added = visit_blocks(
          s, [&](std::size_t, std::span<const Vec3> points) { return cells.add_all(points, s); });
      if (!is_added) seams_.crowded.push_back(s);
      return !is_added;
    });
    std::size_t inner = 0;
    for (const std::uint32_t s : near_) {
      inner += share_cells(s, cells);
      const std::uint64_t listed = 2 * inner * sizeof(std::uint32_t);  // as vectors grow
      if (auto error = ledger_.check(SharedCells::bytes(most) + listed)) return error;
    }
    if (!cells.may_be_shared()) return std::nullopt;
    const std::size_t shared = mark_shared(cells);
    if (shared == 0) return std::nullopt;
    most_candidates_ = shared + inner;
    if (auto error = ledger_.check(SharedCells::bytes(most) + bytes_of_search(shared))) {
      return error;
    }
    points_.reserve(shared);
    places_.reserve(most_candidates_);
    memberships_.reserve(most_candidates_);
    for (const std::uint32_t s : near_) {
      const std::vector<std::uint32_t>& own = joining(s);
      for (std::size_t i = 0; i < own.size(); ++i) {
        if (is_shared(s, i)) points_.push_back({s, vertex(s, own[i])});
      }
    }
    return std::nullopt;
  }

  // Marks the cells near the vertices of a surface. Returns how many vertices inside its boundary
  // are near a marked cell.
  std::size_t share_cells(std::uint32_t s, SharedCells& cells) {
    const std::vector<std::uint32_t>& own = joining(s);
    std::size_t inner = 0;
    std::size_t next = 0;
    MeshOutline& of_mesh = outline(s);
    if (!of_mesh.points) of_mesh.points.emplace(mesh(s).positions());
    cells.find_near(*of_mesh.points,
                    {placed_[s].surface->node->linear_scene_mesh, placed_[s].translation_solver_m,
                     of_mesh.reach_m},
                    most_m_, near_vertices_);
    for (const std::uint32_t v : near_vertices_) {
      while (next < own.size() && own[next] < v) ++next;
      const bool is_on_boundary = next < own.size() && own[next] == v;
      const Vec3 p = vertex(s, v);
      if (is_on_boundary && cells.is_inside_cell(p, most_m_)) continue;
      if (!cells.share_near(p, most_m_, s) || is_on_boundary) continue;
      placed_[s].inner.push_back(v);
      ++inner;
    }
    return inner;
  }

  // Calls visit(index of the first one, positions) for blocks of the vertices of joining(s), until
  // it returns false. Returns whether it never did.
  template <typename Visit>
  bool visit_blocks(std::uint32_t s, Visit visit) {
    const std::vector<std::uint32_t>& own = joining(s);
    std::array<Vec3, SharedCells::kMostAtOnce> points;
    for (std::size_t first = 0; first < own.size(); first += points.size()) {
      const std::size_t count = std::min(own.size() - first, points.size());
      for (std::size_t i = 0; i < count; ++i) points[i] = vertex(s, own[first + i]);
      if (!visit(first, std::span<const Vec3>(points).first(count))) return false;
    }
    return true;
  }

  // Notes which boundary points are in shared cells. Returns their number.
  std::size_t mark_shared(const SharedCells& cells) {
    std::size_t count = 0;
    for (const std::uint32_t s : near_) {
      placed_[s].first_shared = is_shared_.size();
      is_shared_.resize(is_shared_.size() + joining(s).size(), false);
      visit_blocks(s, [&](std::size_t first, std::span<const Vec3> points) {
        cells.visit_shared(points, [&](std::size_t i) {
          is_shared_[placed_[s].first_shared + first + i] = true;
          ++count;
        });
        return true;
      });
    }
    return count;
  }

  // Of the vertex with this index in joining(s).
  bool is_shared(std::uint32_t s, std::size_t index) const {
    return is_shared_[placed_[s].first_shared + index];
  }

  // The memory of the search after this step. A candidate rarely has more than one pair.
  std::uint64_t bytes_of_search(std::size_t shared) const {
    constexpr std::uint64_t kPerCandidate =
        sizeof(Place) + sizeof(Membership) + sizeof(JoinedVertex);
    std::size_t most_vertices = 0;  // of one surface
    for (const std::uint32_t s : near_) {
      most_vertices = std::max(most_vertices, mesh(s).positions().size());
    }
    return 2 * most_candidates_ * sizeof(std::uint32_t) + shared * sizeof(BoundaryPoint) +
           PointGrid::bytes(shared) + PointGrid::bytes(most_candidates_) +
           most_candidates_ * kPerCandidate +
           std::min(most_vertices, most_candidates_) * (sizeof(Candidate) + sizeof(Pair));
  }

  // The vertices of a surface that are on a shared part of its boundary or near the boundary of
  // another surface. No value if too many points are near a vertex.
  std::optional<std::vector<Candidate>> candidates(std::uint32_t s, const BoundaryGrid& boundary) {
    std::vector<Candidate> found;
    const std::vector<std::uint32_t>& own = joining(s);
    std::size_t next = 0;
    const auto add_boundary = [&](std::uint32_t end) {
      for (; next < own.size() && own[next] < end; ++next) {
        if (is_shared(s, next)) found.push_back({own[next], true, vertex(s, own[next])});
      }
    };
    for (const std::uint32_t v : placed_[s].inner) {
      add_boundary(v);
      const Vec3 p = vertex(s, v);
      const std::optional<bool> is_near = boundary.is_near_another(p, s);
      if (!is_near) return std::nullopt;
      if (*is_near) found.push_back({v, false, p});
    }
    add_boundary(static_cast<std::uint32_t>(mesh(s).positions().size()));
    return found;
  }

  // All pairs of a vertex and a place near it, nearest first. No value if too many places are near
  // a vertex.
  std::optional<std::vector<Pair>> pairs_of(std::uint32_t s, const std::vector<Candidate>& vertices,
                                            const PointGrid& grid) const {
    std::vector<Pair> pairs;
    for (std::uint32_t c = 0; c < vertices.size(); ++c) {
      const Vec3& p = vertices[c].position_m;
      std::size_t met = 0;
      const bool is_certain = grid.visit_near(p, most_m_, [&](std::uint32_t place) {
        const double bound_m = placed_[s].rounding_m + places_[place].rounding_m;
        if (!is_within(p, places_[place].position_m, bound_m)) return true;
        pairs.emplace_back((p - places_[place].position_m).squaredNorm(), c, place);
        return ++met <= kMostMet;
      });
      if (!is_certain || met > kMostMet) return std::nullopt;
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

  // Joins vertices and places, the nearest pairs first; each remaining vertex becomes a new place.
  // Returns false and joins nothing if too many places are near a vertex.
  bool join(std::uint32_t s, const std::vector<Candidate>& vertices, PointGrid& grid) {
    const auto pairs = pairs_of(s, vertices, grid);
    if (!pairs) return false;
    std::vector<bool> is_joined(vertices.size(), false);
    for (const auto& [squared, c, n] : *pairs) {
      Place& place = places_[n];
      if (is_joined[c] || place.last == s) continue;
      is_joined[c] = true;
      place.last = s;
      place.has_boundary = place.has_boundary || vertices[c].is_on_boundary;
      ++place.vertices;
      memberships_.push_back(
          {s, vertices[c].vertex, n, vertices[c].position_m != place.position_m});
    }
    for (std::size_t c = 0; c < vertices.size(); ++c) {
      if (is_joined[c]) continue;
      const auto n = static_cast<std::uint32_t>(places_.size());
      memberships_.push_back({s, vertices[c].vertex, n, false});
      places_.push_back(
          {vertices[c].position_m, placed_[s].rounding_m, vertices[c].is_on_boundary, s});
      grid.insert(vertices[c].position_m, n);
    }
    return true;
  }

  bool is_seam(const Place& place) const { return place.vertices > 1 && place.has_boundary; }

  void collect() {
    std::sort(memberships_.begin(), memberships_.end(),
              [](const Membership& a, const Membership& b) {
                return std::pair(a.surface, a.vertex) < std::pair(b.surface, b.vertex);
              });
    for (const Membership& m : memberships_) {
      if (!is_seam(places_[m.place])) continue;
      ++seams_.vertices;
      if (seams_.bodies.empty() || seams_.bodies.back().surface != m.surface) {
        seams_.bodies.push_back({m.surface, {}});
      }
      if (!m.is_moved) continue;
      seams_.bodies.back().joined.push_back({m.vertex, places_[m.place].position_m});
    }
    for (const Place& place : places_) seams_.places += is_seam(place) ? 1 : 0;
  }

  const std::vector<WeldedSurface>& meshes_;
  MemoryLedger& ledger_;
  double size_m_;        // largest extent of the scene
  double most_m_;        // largest distance of joined vertices
  double most_apart_m_;  // largest allowed Placed::apart_m
  std::vector<MeshOutline> outlines_;
  std::vector<Placed> placed_;
  std::vector<std::uint32_t> near_;
  std::vector<std::uint32_t> near_vertices_;  // of the surface that is searched
  std::vector<bool> is_shared_;               // of the boundary points of near_, see mark_shared()
  std::size_t most_candidates_ = 0;           // of all surfaces together
  std::vector<BoundaryPoint> points_;         // in shared cells
  std::vector<Place> places_;
  std::vector<Membership> memberships_;
  Seams seams_;
};

}  // namespace

Result<Seams> find_seams(const std::vector<WeldedSurface>& meshes,
                         std::span<const SeamSurface> surfaces, const Vec3& anchor_scene_m,
                         double size_m, MemoryLedger& ledger) {
  // The surface, its box, two numbers in the search for touching boxes, and an entry of near_.
  constexpr std::uint64_t kPerSurface = sizeof(Placed) + sizeof(Box) + 3 * sizeof(std::uint32_t);
  const bool has_open =
      std::any_of(meshes.begin(), meshes.end(),
                  [](const WeldedSurface& mesh) { return mesh.report().boundary_edges > 0; }) ||
      std::any_of(surfaces.begin(), surfaces.end(),
                  [](const SeamSurface& surface) { return !surface.met.empty(); });
  if (surfaces.size() < 2 || !has_open) return Seams{};
  if (auto error = ledger.check(surfaces.size() * kPerSurface)) return *error;
  return SeamSearch(meshes, surfaces, anchor_scene_m, size_m, ledger).find();
}

}  // namespace palpate
