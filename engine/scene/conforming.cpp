#include "engine/scene/conforming.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "engine/scene/flush_search.h"
#include "geometry/index/touching_boxes.h"
#include "geometry/mesh/point_grid.h"
#include "haptics/proxy/contact_world.h"

namespace palpate {
namespace {

// A vertex that lies on a face is moved this far beyond the face. The distance is far more than the
// rounding of positions in double (kMostFramePerStandOff), so that no step finds a gap, and far
// less than a stand-off, so that no proxy can feel it.
constexpr double kOverlapPerStandOff = 0.0625;

// A node whose vertices are known less accurately than this part of the size of its mesh has no
// vertices that could be told apart.
constexpr double kMostBoundPerSize = 0x1p-8;

// Size of a grid cell, in units of the largest distance of joined vertices. Queries need two.
constexpr double kCellPerMeeting = 4.0;

// Moves of places until all lie on their edges and faces. Each pass takes the moves of the places
// at the ends of an edge, or at the corners of a face, to the places on it.
constexpr int kMostPasses = 16;
constexpr int kTurnsPerPass = 4;  // among the faces that one place lies on
// A place is where it should be if it moves less than this part of kOverlapPerStandOff.
constexpr double kSettledPerOverlap = 0x1p-6;
// An edge that passes a flat edge of another surface is not divided if it overlaps by this part of
// kOverlapPerStandOff. It may overlap by less than the whole because one of its ends is a vertex of
// both surfaces. The part is still many times kRoundoffOfPlace: a stand-off is about 1e-11 of the
// scene's size, so that the least overlap is 8e-14 of it.
constexpr double kLeastOverlapOfPass = 0.125;

// Bounds the distance between a position and the one that to_mesh() and vertex() give for it, in
// units of the unit roundoff times |L| |v| + |t|. For each of the two functions, 5 for three
// products and their sums, 1 for the translation relative to the anchor, 1 for adding it. A vertex
// as near as that to its place is not moved.
constexpr double kRoundoffOfPlace = 14 * 0x1p-53;

// The edge of a surface that is divided at a place.
struct DividedEdge {
  std::uint32_t surface;
  std::uint32_t half_edge;
};
struct FaceBelow {
  std::uint32_t surface;
  std::uint32_t face;
  int side;
};

// A position at which surfaces meet.
struct MeetingPlace {
  Vec3 position_m;
  Vec3 first_m;                            // before it was moved to edges and faces
  std::uint32_t first;                     // the surface that gave first_m
  std::vector<std::uint32_t> vertices_of;  // surfaces, ascending; one vertex of each
  std::vector<DividedEdge> edges;
  std::vector<FaceBelow> faces;
  bool is_crossing = false;  // of two sharp edges
  bool is_moved = false;     // its faces moved it

  bool has_edge_of(std::uint32_t s) const {
    return std::any_of(edges.begin(), edges.end(),
                       [&](const DividedEdge& e) { return e.surface == s; });
  }
  // Whether it is a vertex of a surface, or on an edge of it.
  bool is_on(std::uint32_t s) const {
    return has_edge_of(s) || std::binary_search(vertices_of.begin(), vertices_of.end(), s);
  }
  bool is_shared() const { return vertices_of.size() + edges.size() > 1; }
  // Whether edges only pass flat edges of other surfaces here.
  bool is_pass() const { return vertices_of.empty() && !is_crossing; }
};

struct PlacedVertex {
  std::uint32_t vertex;
  std::uint32_t place;
};

class Conformer {
 public:
  Conformer(const std::vector<WeldedSurface>& meshes, std::span<const PlacedSurface> surfaces,
            const FlushSearch& search, const Meetings& meetings, double size_m)
      : meshes_(meshes),
        surfaces_(surfaces),
        search_(search),
        meetings_(meetings),
        overlap_m_(kOverlapPerStandOff * SolverScale::of(size_m, 0.0).stand_off_m),
        of_surface_(surfaces.size()) {}

  Conforming conform() {
    join_vertices();
    put_on_edges();
    cross_edges();
    put_on_faces();
    settle();
    collect();
    return std::move(result_);
  }

 private:
  const WeldedSurface& mesh(std::uint32_t s) const { return meshes_[surfaces_[s].mesh]; }
  Vec3 given(std::uint32_t s, std::uint32_t v) const {
    return surfaces_[s].vertex(mesh(s).positions()[v]);
  }
  std::uint32_t start_vertex(std::uint32_t s, std::uint32_t h) const {
    return mesh(s).faces()[h / 3][h % 3];
  }
  std::optional<std::uint32_t> place_of(std::uint32_t s, std::uint32_t v) const {
    const std::vector<PlacedVertex>& own = of_surface_[s];
    const auto found = std::lower_bound(
        own.begin(), own.end(), v,
        [](const PlacedVertex& placed, std::uint32_t sought) { return placed.vertex < sought; });
    if (found == own.end() || found->vertex != v) return std::nullopt;
    return found->place;
  }
  Vec3 position(std::uint32_t s, std::uint32_t v) const {
    const auto place = place_of(s, v);
    return place ? places_[*place].position_m : given(s, v);
  }
  Vec3 start_of(std::uint32_t s, std::uint32_t h) const { return position(s, start_vertex(s, h)); }
  // Of the two half-edges of an edge, the lower one.
  std::uint32_t lower(std::uint32_t s, std::uint32_t h) const {
    return std::min(h, mesh(s).mates().aligned[h]);
  }

  // Per surface, the vertices that meet others, ascending.
  std::vector<std::vector<std::uint32_t>> candidates() const {
    std::vector<std::vector<std::uint32_t>> of(surfaces_.size());
    for (const VertexOnVertex& m : meetings_.vertices) {
      of[m.a].push_back(m.vertex_a);
      of[m.b].push_back(m.vertex_b);
    }
    for (const VertexOnEdge& m : meetings_.on_edges) of[m.surface].push_back(m.vertex);
    for (const VertexOnFace& m : meetings_.on_faces) of[m.surface].push_back(m.vertex);
    for (std::vector<std::uint32_t>& vertices : of) {
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    }
    return of;
  }

  void join_vertices() {
    const std::vector<std::vector<std::uint32_t>> of = candidates();
    std::size_t count = meetings_.crossings.size();
    for (const std::vector<std::uint32_t>& vertices : of) count += vertices.size();
    for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
      widest_m_ = std::max(widest_m_, search_.joins_within_m(s, s));
    }
    grid_.emplace(kCellPerMeeting * widest_m_, count);
    for (std::uint32_t s = 0; s < of.size(); ++s) join(s, of[s]);
  }

  // Joins the vertices of a surface and places, the nearest pairs first. Each remaining vertex
  // becomes a new place.
  void join(std::uint32_t s, std::span<const std::uint32_t> vertices) {
    std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;
    for (std::uint32_t c = 0; c < vertices.size(); ++c) {
      const Vec3 p = given(s, vertices[c]);
      grid_->visit_near(p, widest_m_, [&](std::uint32_t n) {
        const double distance_m = (p - places_[n].position_m).norm();
        if (distance_m <= search_.joins_within_m(s, places_[n].first)) {
          pairs.emplace_back(distance_m, c, n);
        }
        return true;
      });
    }
    std::sort(pairs.begin(), pairs.end());
    std::vector<bool> is_joined(vertices.size(), false);
    std::vector<PlacedVertex>& own = of_surface_[s];
    for (const auto& [distance_m, c, n] : pairs) {
      if (is_joined[c] || places_[n].vertices_of.back() == s) continue;
      is_joined[c] = true;
      places_[n].vertices_of.push_back(s);
      own.push_back({vertices[c], n});
    }
    for (std::uint32_t c = 0; c < vertices.size(); ++c) {
      if (is_joined[c]) continue;
      own.push_back({vertices[c], add_place(given(s, vertices[c]), s, {s})});
    }
    std::sort(own.begin(), own.end(),
              [](const PlacedVertex& a, const PlacedVertex& b) { return a.vertex < b.vertex; });
  }

  std::uint32_t add_place(const Vec3& position_m, std::uint32_t s,
                          std::vector<std::uint32_t> vertices_of) {
    const auto number = static_cast<std::uint32_t>(places_.size());
    places_.push_back({position_m, position_m, s, std::move(vertices_of), {}, {}});
    grid_->insert(position_m, number);
    return number;
  }

  void put_on_edges() {
    for (const VertexOnEdge& m : meetings_.on_edges) {
      const std::uint32_t place = *place_of(m.surface, m.vertex);
      if (places_[place].is_on(m.other)) continue;
      places_[place].edges.push_back({m.other, lower(m.other, m.half_edge)});
    }
  }

  void cross_edges() {
    for (const EdgeOnEdge& m : meetings_.crossings) {
      const Vec3 from = start_of(m.other, m.other_half_edge);
      const Vec3 to = start_of(m.other, next_half_edge(m.other_half_edge));
      const Vec3 p = from + m.along * (to - from);
      std::optional<std::uint32_t> near;
      grid_->visit_near(p, widest_m_, [&](std::uint32_t n) {
        const bool is_near = (p - places_[n].position_m).norm() <=
                             search_.joins_within_m(m.surface, places_[n].first);
        if (is_near && (!near || n < *near)) near = n;
        return true;
      });
      const std::uint32_t place = near ? *near : add_place(p, m.other, {});
      if (!places_[place].is_on(m.surface)) {
        places_[place].edges.push_back({m.surface, lower(m.surface, m.half_edge)});
      }
      if (places_[place].is_on(m.other)) continue;
      if (m.side == 0) {
        places_[place].is_crossing = true;
        places_[place].edges.push_back({m.other, lower(m.other, m.other_half_edge)});
        continue;
      }
      for (const std::uint32_t h :
           {m.other_half_edge, mesh(m.other).mates().aligned[m.other_half_edge]}) {
        places_[place].faces.push_back({m.other, h / 3, facing(m, h / 3)});
      }
    }
  }

  // The side of a flat edge's other face: the two faces may be oriented differently.
  int facing(const EdgeOnEdge& m, std::uint32_t face) const {
    const auto normal = [&](std::uint32_t f) -> Vec3 {
      const Vec3 a = given(m.other, start_vertex(m.other, 3 * f));
      return (given(m.other, start_vertex(m.other, 3 * f + 1)) - a)
          .cross(given(m.other, start_vertex(m.other, 3 * f + 2)) - a);
    };
    return normal(m.other_half_edge / 3).dot(normal(face)) < 0.0 ? -m.side : m.side;
  }

  void put_on_faces() {
    for (const VertexOnFace& m : meetings_.on_faces) {
      const std::uint32_t place = *place_of(m.surface, m.vertex);
      if (places_[place].is_on(m.other)) continue;
      places_[place].faces.push_back({m.other, m.face, m.side});
    }
  }

  // Moves all places to their edges and beyond their faces.
  void settle() {
    for (int pass = 0; pass < kMostPasses; ++pass) {
      double most_m = 0.0;
      for (MeetingPlace& place : places_) {
        if (place.edges.empty() && place.faces.empty()) continue;
        const Vec3 on_edges = on_edge(place);
        const Vec3 p = on_faces(place, on_edges);
        place.is_moved = p != on_edges;
        most_m = std::max(most_m, (p - place.position_m).norm());
        place.position_m = p;
      }
      if (most_m <= kSettledPerOverlap * overlap_m_) return;
    }
  }

  // The nearest point of the edge with the lowest surface. Further edges at the place bend.
  Vec3 on_edge(const MeetingPlace& place) const {
    if (place.edges.empty()) return place.first_m;
    const auto edge = std::min_element(
        place.edges.begin(), place.edges.end(),
        [](const DividedEdge& a, const DividedEdge& b) { return a.surface < b.surface; });
    const Vec3 from = start_of(edge->surface, edge->half_edge);
    const Vec3 d = start_of(edge->surface, next_half_edge(edge->half_edge)) - from;
    const double along = std::clamp(d.dot(place.first_m - from) / d.squaredNorm(), 0.0, 1.0);
    return from + along * d;
  }

  Vec3 on_faces(const MeetingPlace& place, Vec3 p) const {
    const double least_m =
        (place.is_pass() ? kLeastOverlapOfPass : 1 - kSettledPerOverlap) * overlap_m_;
    for (int turn = 0; turn < kTurnsPerPass; ++turn) {
      bool is_moved = false;
      for (const FaceBelow& below : place.faces) {
        const Vec3 a = start_of(below.surface, 3 * below.face);
        const Vec3 normal = (start_of(below.surface, 3 * below.face + 1) - a)
                                .cross(start_of(below.surface, 3 * below.face + 2) - a)
                                .normalized();
        const double depth_m = below.side * normal.dot(p - a);
        if (!(depth_m < least_m)) continue;
        p += below.side * (overlap_m_ - depth_m) * normal;
        is_moved = true;
      }
      if (!is_moved) break;
    }
    return p;
  }

  // An edge of a surface that is divided at a place.
  struct Division {
    std::uint32_t surface;
    std::uint32_t half_edge;  // the lower one
    double along;
    std::uint32_t place;
  };

  std::vector<Division> divisions() const {
    std::vector<Division> all;
    for (std::uint32_t n = 0; n < places_.size(); ++n) {
      const MeetingPlace& place = places_[n];
      if (!is_real(place)) continue;
      for (const DividedEdge& edge : place.edges) {
        const Vec3 from = start_of(edge.surface, edge.half_edge);
        const Vec3 d = start_of(edge.surface, next_half_edge(edge.half_edge)) - from;
        const double along = d.dot(place.position_m - from) / d.squaredNorm();
        if (along > 0.0 && along < 1.0) all.push_back({edge.surface, edge.half_edge, along, n});
      }
    }
    std::sort(all.begin(), all.end(), [](const Division& a, const Division& b) {
      return std::tie(a.surface, a.half_edge, a.along, a.place) <
             std::tie(b.surface, b.half_edge, b.along, b.place);
    });
    return all;
  }

  // Whether surfaces are changed at a place, or meet in it. Edges that pass a flat edge are divided
  // where they would come out of its faces, and not elsewhere.
  static bool is_real(const MeetingPlace& place) {
    if (place.is_pass()) return place.is_moved;
    return place.is_shared() || !place.faces.empty();
  }

  void collect() {
    const std::vector<Division> divided = divisions();
    auto next = divided.begin();
    for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
      const auto first = next;
      while (next != divided.end() && next->surface == s) ++next;
      ConformingSurface made{surfaces_[s].number, {}, {}};
      move_vertices(s, made);
      divide_edges(s, {first, next}, made);
      if (!made.changes.empty() || !made.met.empty()) result_.surfaces.push_back(std::move(made));
    }
    for (const MeetingPlace& place : places_) {
      if (place.vertices_of.size() < 2) continue;
      ++result_.joined_places;
      result_.joined_vertices += place.vertices_of.size();
    }
  }

  void move_vertices(std::uint32_t s, ConformingSurface& made) const {
    for (const PlacedVertex& placed : of_surface_[s]) {
      const MeetingPlace& place = places_[placed.place];
      if (!is_real(place)) continue;
      if (place.is_shared()) made.met.push_back(placed.vertex);
      if ((place.position_m - given(s, placed.vertex)).norm() <= surfaces_[s].rounding_m) continue;
      made.changes.moved.push_back({placed.vertex, surfaces_[s].to_mesh(place.position_m)});
    }
  }

  void divide_edges(std::uint32_t s, std::span<const Division> divided, ConformingSurface& made) {
    const auto count = static_cast<std::uint32_t>(mesh(s).positions().size());
    for (std::size_t i = 0; i < divided.size(); ++i) {
      const Division& d = divided[i];
      const MeetingPlace& place = places_[d.place];
      const auto vertex = count + static_cast<std::uint32_t>(made.changes.added_m.size());
      made.changes.added_m.push_back(surfaces_[s].to_mesh(place.position_m));
      if (place.is_shared()) made.met.push_back(vertex);
      if (i == 0 || divided[i - 1].half_edge != d.half_edge) ++result_.divided_edges;
      const std::uint32_t from = start_vertex(s, d.half_edge);
      const std::uint32_t to = start_vertex(s, next_half_edge(d.half_edge));
      // All faces at the edge.
      for (const std::uint32_t start : {from, to}) {
        for (const std::uint32_t h : search_.features(s).starting_at(start)) {
          if (start_vertex(s, next_half_edge(h)) != (start == from ? to : from)) continue;
          made.changes.divisions.push_back({h, vertex, start == from ? d.along : 1 - d.along});
        }
      }
    }
    std::sort(made.changes.divisions.begin(), made.changes.divisions.end(),
              [](const EdgeDivision& a, const EdgeDivision& b) {
                return std::tie(a.half_edge, a.along, a.vertex) <
                       std::tie(b.half_edge, b.along, b.vertex);
              });
  }

  const std::vector<WeldedSurface>& meshes_;
  std::span<const PlacedSurface> surfaces_;
  const FlushSearch& search_;
  const Meetings& meetings_;
  double overlap_m_;
  double widest_m_ = 0.0;  // the largest distance of surfaces that meet
  std::vector<MeetingPlace> places_;
  std::optional<PointGrid> grid_;                      // of the places
  std::vector<std::vector<PlacedVertex>> of_surface_;  // ascending by vertex
  Conforming result_;
};

// The surfaces whose boxes touch those of others, and whose vertices can be told apart.
std::vector<PlacedSurface> touching(std::span<const Box> boxes,
                                    std::span<const NodeDescription* const> nodes,
                                    const ConformingSettings& settings) {
  std::vector<Box> boxes_m;
  std::vector<double> bounds_m;
  boxes_m.reserve(nodes.size());
  bounds_m.reserve(nodes.size());
  for (const NodeDescription* node : nodes) {
    const Box& box = boxes[node->mesh];
    const Vec3 reach_m = box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs());
    const Vec3 middle_m = node->linear_scene_mesh * (0.5 * (box.low + box.high)) +
                          (node->translation_m - settings.anchor_scene_m);
    const Vec3 half_m = node->linear_scene_mesh.cwiseAbs() * (0.5 * (box.high - box.low));
    const double bound_m = float_rounding_m(*node, reach_m);
    const bool is_certain = bound_m <= kMostBoundPerSize * 2 * half_m.maxCoeff();
    bounds_m.push_back(is_certain ? bound_m : -1.0);
    const double margin_m = std::max(kReportedPerJoin * bound_m, settings.close_gaps_m);
    boxes_m.push_back(is_certain ? Box{middle_m - half_m, middle_m + half_m}.grown(margin_m)
                                 : Box::empty());
  }
  const std::vector<bool> touches =
      may_touch_marked(boxes_m, std::vector<bool>(boxes_m.size(), true));
  std::vector<PlacedSurface> placed;
  for (std::uint32_t s = 0; s < nodes.size(); ++s) {
    if (!touches[s] || bounds_m[s] < 0.0) continue;
    const Mat3& linear = nodes[s]->linear_scene_mesh;
    const Mat3 inverse = linear.inverse();
    if (!inverse.allFinite()) continue;
    const Vec3 translation_m = nodes[s]->translation_m - settings.anchor_scene_m;
    const Box& box = boxes[nodes[s]->mesh];
    const Vec3 reach_m = box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs());
    const double terms_m = linear.colwise().norm().dot(reach_m) + translation_m.norm() +
                           nodes[s]->translation_m.norm();
    placed.push_back({s, nodes[s]->mesh, linear, inverse, translation_m, kRoundoffOfPlace * terms_m,
                      bounds_m[s], std::max(kReportedPerJoin * bounds_m[s], settings.close_gaps_m),
                      boxes_m[s]});
  }
  return placed;
}

}  // namespace

Result<Conforming> conform(const std::vector<WeldedSurface>& meshes, std::span<const Box> boxes,
                           std::span<const double> moved_m,
                           std::span<const NodeDescription* const> nodes,
                           const ConformingSettings& settings, MemoryLedger& ledger) {
  constexpr std::uint64_t kPerSurface = sizeof(Box) + sizeof(double) + sizeof(PlacedSurface);
  // A place and its lists of surfaces, edges and faces; its entry in the grid; what it changes.
  constexpr std::uint64_t kPerPlace = sizeof(MeetingPlace) + 256;
  if (nodes.size() < 2) return Conforming{};
  if (auto error = ledger.check(nodes.size() * kPerSurface)) return *error;
  const std::vector<PlacedSurface> surfaces = touching(boxes, nodes, settings);
  if (surfaces.size() < 2) return Conforming{};
  FlushSearch search(meshes, boxes, moved_m, surfaces, settings.close_gaps_m, ledger);
  Result<Meetings> meetings = search.find();
  if (!meetings) return meetings.error();
  const std::uint64_t most_places = 2 * meetings->vertices.size() + meetings->on_edges.size() +
                                    meetings->on_faces.size() + meetings->crossings.size();
  if (!meetings->is_complete || ledger.check(most_places * kPerPlace)) {
    Conforming none;
    none.is_complete = false;
    return none;
  }
  Conforming made = Conformer(meshes, surfaces, search, *meetings, settings.size_m).conform();
  made.apart = meetings->apart;
  made.least_apart_m = meetings->least_apart_m;
  made.most_apart_m = meetings->most_apart_m;
  return made;
}

}  // namespace palpate
