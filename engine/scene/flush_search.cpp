#include "engine/scene/flush_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptics/proxy/solver_corners.h"

namespace palpate {
namespace {

// Unit roundoff of float.
constexpr double kFloat = 0x1p-24;

// The constants below bound the distance of a vertex from the position that its author intended, in
// units of kFloat times the same magnitudes as kRoundoffPerTransform (seams.cpp).
//
// For each vertex: 1 for rounding its coordinates to the floats of the file; 3 for the program that
// computed them in float, by a product and a sum of two such products.
constexpr double kFloatPerVertex = 4 * kFloat;
// For each transform: 1 for rounding its numbers; 3 for the program that computed them, like those
// of a vertex.
constexpr double kFloatPerTransform = 4 * kFloat;
// For each transform of a node that is turned or sheared: 4 for the rotation of a quaternion with
// rounded components; 4 for the program that turned an offset by it, or that multiplied two
// rotations.
constexpr double kFloatPerTurn = 8 * kFloat;

// Two edges that cross at an acute angle are apart by this multiple of the bound at the nearer end,
// at least. Edges that diverge less coincide, and then their ends lie on each other.
constexpr double kDivergesPerBound = 4.0;

// A shorter piece of an edge is too near one of its ends to cross another edge.
constexpr double kShortPerBound = 4.0;

// Limit on the work of a search, in boxes examined: 5 to 10 ns each. A box that meets 26 others in
// a grid takes 4,000, up to kMostWorkOfSurfaces for all of them, three quarters of a second. In
// addition, any scene may take kMostWork, a fifth of a second.
constexpr std::uint64_t kMostWork = std::uint64_t{1} << 24;
constexpr std::uint64_t kWorkPerSurface = 4096;
constexpr std::uint64_t kMostWorkOfSurfaces = 100'000'000;
constexpr std::uint64_t kWorkPerFace = 64;

// The vertices of a surface with at most this many are placed once; with more, whenever they are
// examined, because few of them are near another surface.
constexpr std::size_t kMostPlaced = 64;

struct SegmentPair {
  double s, t;  // fractions of the two segments
  double distance_m;
};

// The nearest points of the lines through two segments, if both lie within the segments.
std::optional<SegmentPair> nearest_within(const Vec3& p, const Vec3& p_end, const Vec3& q,
                                          const Vec3& q_end, double bound_m) {
  const Vec3 d = p_end - p;
  const Vec3 e = q_end - q;
  const Vec3 across = d.cross(e);
  const double dd = d.squaredNorm();
  const double ee = e.squaredNorm();
  const double apart_m = kDivergesPerBound * bound_m;
  if (!(across.squaredNorm() > apart_m * apart_m * std::max(dd, ee))) return std::nullopt;
  const double s = (q - p).cross(e).dot(across) / across.squaredNorm();
  if (!(s > 0.0 && s < 1.0)) return std::nullopt;
  const double t = (q - p).cross(d).dot(across) / across.squaredNorm();
  if (!(t > 0.0 && t < 1.0)) return std::nullopt;
  const double within_s = bound_m / std::sqrt(dd);
  const double within_t = bound_m / std::sqrt(ee);
  if (!(s > within_s && s < 1 - within_s && t > within_t && t < 1 - within_t)) return std::nullopt;
  return SegmentPair{s, t, (p + s * d - q - t * e).norm()};
}

// The distance of p from the triangle a, b, c.
double distance_from(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  const auto beside = [&](const Vec3& from, const Vec3& to) {
    return triple_product(normal, to - from, p - from) < 0.0;
  };
  if (area2 > 0.0 && !beside(a, b) && !beside(b, c) && !beside(c, a)) {
    return std::abs(normal.dot(p - a)) / std::sqrt(area2);
  }
  const auto from_edge = [&](const Vec3& from, const Vec3& to) {
    const Vec3 d = to - from;
    const double t = std::clamp(d.dot(p - from) / d.squaredNorm(), 0.0, 1.0);
    return (p - from - t * d).norm();
  };
  return std::min({from_edge(a, b), from_edge(b, c), from_edge(c, a)});
}

Box intersection(const Box& a, const Box& b) {
  return {a.low.cwiseMax(b.low), a.high.cwiseMin(b.high)};
}

// The side opposite to heights that are all on one side; 0 if they are on both or on none.
int side_opposite(double least, double most, double tolerance_m) {
  const bool is_in_front = most > tolerance_m;
  const bool is_behind = least < -tolerance_m;
  return is_in_front == is_behind ? 0 : is_in_front ? -1 : 1;
}

}  // namespace

// The features nearest to a point, and their distances.
struct FlushSearch::Nearest {
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double vertex_m = kNone;
  std::uint32_t vertex = 0;
  double edge_m = kNone;  // of a sharp edge, within its length
  std::uint32_t half_edge = 0;
  double face_m = kNone;
  std::uint32_t face = 0;
};

// A sharp edge, in the solver frame.
struct FlushSearch::Edge {
  std::uint32_t surface;
  std::uint32_t half_edge;
  Vec3 from, to;
  Box box_m;  // around its part near the other surface
  double bound_m;
};

Vec3 PlacedSurface::vertex(const Vec3& v_mesh) const {
  return solver_vertex(linear, translation_m, v_mesh);
}

// One step of Newton's method takes off the rounding of the inverse.
Vec3 PlacedSurface::to_mesh(const Vec3& p) const {
  const Vec3 v_mesh = inverse * (p - translation_m);
  return v_mesh + inverse * (p - vertex(v_mesh));
}

double float_rounding_m(const NodeDescription& node, const Vec3& reach_m) {
  const Vec3 columns =
      node.linear_scene_mesh.colwise().norm().transpose().cwiseMax(node.product.columns);
  const double vertex_m = columns.dot(reach_m);
  const double terms_m = vertex_m + std::max(node.product.translation_m, node.translation_m.norm());
  const Mat3& linear = node.linear_scene_mesh;
  const bool is_turned = Mat3(linear.diagonal().asDiagonal()) != linear;
  const double factors = std::max<std::uint32_t>(node.product.factors, 1);
  return kFloatPerVertex * vertex_m +
         factors * (kFloatPerTransform + (is_turned ? kFloatPerTurn : 0.0)) * terms_m;
}

double float_rounding_of_vertex_m(const Vec3& reach_m) {
  return kFloatPerVertex * reach_m.norm();
}

FlushSearch::FlushSearch(const std::vector<WeldedSurface>& meshes, std::span<const Box> boxes,
                         std::span<const double> moved_m, std::span<const PlacedSurface> surfaces,
                         double close_gaps_m, MemoryLedger& ledger)
    : meshes_(meshes),
      boxes_(boxes),
      moved_m_(moved_m),
      surfaces_(surfaces),
      close_gaps_m_(close_gaps_m),
      ledger_(ledger) {
  limit_ = kMostWork + std::min(kWorkPerSurface * surfaces.size(), kMostWorkOfSurfaces);
  for (const WeldedSurface& m : meshes) limit_ += kWorkPerFace * m.face_count();
  features_.resize(meshes.size());
  first_placed_.assign(surfaces.size(), kNotPlaced);
}

double FlushSearch::joins_within_m(std::uint32_t s, std::uint32_t other) const {
  return std::max(surfaces_[s].bound_m + surfaces_[other].bound_m, close_gaps_m_);
}

double FlushSearch::reported_within_m(std::uint32_t s, std::uint32_t other) const {
  return std::max(joins_within_m(s, other),
                  kReportedPerJoin * (surfaces_[s].bound_m + surfaces_[other].bound_m));
}

Result<Meetings> FlushSearch::find() {
  const std::uint64_t tree_bytes = OverlapTree::bytes(surfaces_.size());
  if (auto error = ledger_.check(tree_bytes + surfaces_.size() * sizeof(Box))) return *error;
  place_small_meshes();
  std::vector<Box> boxes;
  boxes.reserve(surfaces_.size());
  for (const PlacedSurface& s : surfaces_) boxes.push_back(s.box_m);
  const OverlapTree tree(boxes);
  std::vector<std::uint32_t> others;
  for (std::uint32_t a = 0; a < surfaces_.size() && !gives_up(); ++a) {
    others.clear();
    tree.visit(boxes[a], work_, [&](std::uint32_t b) {
      if (b > a) others.push_back(b);
      return !gives_up();
    });
    std::sort(others.begin(), others.end());
    for (const std::uint32_t b : others) {
      if (!gives_up()) search_pair(a, b);
    }
  }
  if (!gives_up()) return std::move(found_);
  Meetings none;
  none.is_complete = false;
  return none;
}

// If memory is short, no vertices are stored.
void FlushSearch::place_small_meshes() {
  std::size_t count = 0;
  const auto is_small = [&](std::uint32_t s) { return mesh(s).positions().size() <= kMostPlaced; };
  for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
    if (is_small(s)) count += mesh(s).positions().size();
  }
  if (ledger_.check(count * sizeof(Vec3))) return;
  features_bytes_ += count * sizeof(Vec3);
  placed_m_.reserve(count);
  for (std::uint32_t s = 0; s < surfaces_.size(); ++s) {
    if (!is_small(s)) continue;
    first_placed_[s] = placed_m_.size();
    for (const Vec3& v : mesh(s).positions()) placed_m_.push_back(surfaces_[s].vertex(v));
  }
}

bool FlushSearch::make_features(std::uint32_t mesh) {
  std::unique_ptr<MeshFeatures>& made = features_[mesh];
  if (made) return true;
  features_bytes_ += MeshFeatures::bytes(meshes_[mesh]);
  is_memory_short_ = ledger_.check(features_bytes_ + bytes_of_meetings()).has_value();
  if (is_memory_short_) return false;
  const Box& box = boxes_[mesh];
  const Vec3 reach_m = box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs());
  made = std::make_unique<MeshFeatures>(meshes_[mesh],
                                        float_rounding_of_vertex_m(reach_m) + moved_m_[mesh]);
  work_ += meshes_[mesh].face_count();
  return true;
}

std::uint64_t FlushSearch::bytes_of_meetings() const {
  return found_.vertices.capacity() * sizeof(VertexOnVertex) +
         found_.on_edges.capacity() * sizeof(VertexOnEdge) +
         found_.on_faces.capacity() * sizeof(VertexOnFace) +
         found_.crossings.capacity() * sizeof(EdgeOnEdge);
}

void FlushSearch::search_pair(std::uint32_t a, std::uint32_t b) {
  if (!make_features(surfaces_[a].mesh) || !make_features(surfaces_[b].mesh)) return;
  const Box box_m = intersection(surfaces_[a].box_m, surfaces_[b].box_m);
  find_faces(a, b, box_m, faces_a_);
  if (faces_a_.empty()) return;
  find_faces(b, a, box_m, faces_b_);
  search_vertices(a, b, box_m, faces_a_);
  search_vertices(b, a, box_m, faces_b_);
  search_edges(a, b, faces_a_);
  search_edges(b, a, faces_b_);
  is_memory_short_ = ledger_.check(features_bytes_ + bytes_of_meetings()).has_value();
}

// A box in the mesh frame around a box in the solver frame.
Box FlushSearch::box_in_mesh(std::uint32_t s, const Box& box_m) const {
  const PlacedSurface& surface = surfaces_[s];
  const Vec3 middle = surface.inverse * (0.5 * (box_m.low + box_m.high) - surface.translation_m);
  const Vec3 half = surface.inverse.cwiseAbs() * (0.5 * (box_m.high - box_m.low));
  return {middle - half, middle + half};
}

// The faces in a box that may be near faces of the other surface, ascending.
void FlushSearch::find_faces(std::uint32_t s, std::uint32_t other, const Box& box_m,
                             std::vector<std::uint32_t>& faces) {
  const double margin_m = reported_within_m(s, other);
  faces.clear();
  features(s).tree().visit(box_in_mesh(s, box_m), work_, [&](std::uint32_t f) {
    Box face_m = Box::empty();
    for (const std::uint32_t v : mesh(s).faces()[f]) {
      const Vec3 p = position(s, v);
      face_m = face_m.united({p, p});
    }
    const Box near_m = box_in_mesh(other, face_m.grown(margin_m));
    bool is_near = false;
    features(other).tree().visit(near_m, work_, [&](std::uint32_t) {
      is_near = true;
      return false;
    });
    if (is_near) faces.push_back(f);
    return !gives_up();
  });
  std::sort(faces.begin(), faces.end());
}

// The features near p: vertices and edges up to reported_m away, faces up to bound_m. Of equally
// near features, the one with the lowest number. A vertex within the bound makes edges needless,
// and either of them makes faces needless: then these are not examined.
FlushSearch::Nearest FlushSearch::nearest(std::uint32_t other, const Vec3& p, double bound_m,
                                          double reported_m, bool needs_face) {
  Nearest best;
  const MeshFeatures& near = features(other);
  const std::span<const Triangle> triangles = mesh(other).faces();
  const Box box_m = Box{p, p}.grown(reported_m);
  const auto improve = [](double distance_m, std::uint32_t number, double& best_m,
                          std::uint32_t& best_number) {
    if (distance_m > best_m || (distance_m == best_m && number >= best_number)) return;
    best_m = distance_m;
    best_number = number;
  };
  near_faces_.clear();
  near.tree().visit(box_in_mesh(other, box_m), work_, [&](std::uint32_t f) {
    near_faces_.push_back(f);
    for (const std::uint32_t v : triangles[f]) {
      improve((p - position(other, v)).norm(), v, best.vertex_m, best.vertex);
    }
    work_ += 4;
    return true;
  });
  if (best.vertex_m <= bound_m) return best;
  for (const std::uint32_t f : near_faces_) {
    for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
      if (!near.is_sharp_edge(h)) continue;
      const Vec3 from = start_of(other, h);
      const Vec3 d = start_of(other, next_half_edge(h)) - from;
      const double t = d.dot(p - from) / d.squaredNorm();
      if (!(t > 0.0 && t < 1.0)) continue;
      improve((p - from - t * d).norm(), h, best.edge_m, best.half_edge);
    }
  }
  if (best.edge_m <= bound_m || !needs_face) return best;
  for (const std::uint32_t f : near_faces_) {
    const auto [a, b, c] = triangles[f];
    improve(distance_from(position(other, a), position(other, b), position(other, c), p), f,
            best.face_m, best.face);
  }
  return best;
}

double FlushSearch::height(std::uint32_t other, std::uint32_t face, const Vec3& p) const {
  const Vec3 a = start_of(other, 3 * face);
  const Vec3 normal = (start_of(other, 3 * face + 1) - a).cross(start_of(other, 3 * face + 2) - a);
  return normal.dot(p - a) / normal.norm();
}

// The side of the face on which a vertex must lie so that it is beyond the face, seen from its own
// surface. 0 if its surface lies in the plane of the face or on both sides of it.
int FlushSearch::side_of_vertex(std::uint32_t s, std::uint32_t vertex, std::uint32_t other,
                                std::uint32_t face, double tolerance_m) const {
  double least = 0.0;
  double most = 0.0;
  bool has_edge_along = false;  // else the surfaces touch in a single point, or by chance
  for (const std::uint32_t h : features(s).starting_at(vertex)) {
    for (const std::uint32_t around : {next_half_edge(h), previous_half_edge(h)}) {
      const double above = height(other, face, start_of(s, around));
      has_edge_along = has_edge_along || std::abs(above) <= 2 * tolerance_m;
      least = std::min(least, above);
      most = std::max(most, above);
    }
  }
  return has_edge_along ? side_opposite(least, most, tolerance_m) : 0;
}

int FlushSearch::side_of_edge(std::uint32_t s, std::uint32_t half_edge, std::uint32_t other,
                              std::uint32_t face, double tolerance_m) const {
  double least = 0.0;
  double most = 0.0;
  for (const std::uint32_t h : {half_edge, mesh(s).mates().aligned[half_edge]}) {
    if (h == kNoHalfEdge) continue;
    const double above = height(other, face, start_of(s, previous_half_edge(h)));
    least = std::min(least, above);
    most = std::max(most, above);
  }
  return side_opposite(least, most, tolerance_m);
}

void FlushSearch::search_vertices(std::uint32_t s, std::uint32_t other, const Box& box_m,
                                  std::span<const std::uint32_t> faces) {
  vertices_.clear();
  for (const std::uint32_t f : faces) {
    const Triangle& face = mesh(s).faces()[f];
    vertices_.insert(vertices_.end(), face.begin(), face.end());
  }
  std::sort(vertices_.begin(), vertices_.end());
  vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
  const double bound_m = joins_within_m(s, other);
  const double reported_m = reported_within_m(s, other);
  for (const std::uint32_t v : vertices_) {
    ++work_;
    if (gives_up()) return;
    const Vec3 p = position(s, v);
    if (!box_m.contains(p)) continue;
    const bool is_sharp = features(s).is_sharp_vertex(v);
    const Nearest near = nearest(other, p, bound_m, reported_m, is_sharp);
    if (near.vertex_m <= bound_m) {
      const bool joins = is_sharp || features(other).is_sharp_vertex(near.vertex);
      if (joins && s < other) found_.vertices.push_back({s, v, other, near.vertex});
      if (joins && s > other) found_.vertices.push_back({other, near.vertex, s, v});
    } else if (near.edge_m <= bound_m) {
      found_.on_edges.push_back({s, v, other, near.half_edge});
    } else if (near.face_m <= bound_m) {
      const int side = is_sharp ? side_of_vertex(s, v, other, near.face, bound_m) : 0;
      if (side != 0) found_.on_faces.push_back({s, v, other, near.face, side});
    } else if (const double gap_m = std::min(near.vertex_m, near.edge_m);
               is_sharp && gap_m <= reported_m) {
      found_.least_apart_m = found_.apart == 0 ? gap_m : std::min(found_.least_apart_m, gap_m);
      found_.most_apart_m = std::max(found_.most_apart_m, gap_m);
      ++found_.apart;
    }
  }
}

// Searches only where the boxes meet to within the distance of joined vertices.
void FlushSearch::search_edges(std::uint32_t s, std::uint32_t other,
                               std::span<const std::uint32_t> faces) {
  const MeshFeatures& own = features(s);
  const MeshFeatures& others = features(other);
  const double bound_m = joins_within_m(s, other);
  const auto tight = [&](std::uint32_t n) {
    return surfaces_[n].box_m.grown(bound_m - surfaces_[n].margin_m);
  };
  const Box box_m = intersection(tight(s), tight(other));
  if (!((box_m.high - box_m.low).maxCoeff() > kShortPerBound * bound_m)) return;
  for (const std::uint32_t f : faces) {
    for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
      if (!own.is_sharp_edge(h)) continue;
      // The edge is searched from its lower half-edge if both faces are listed.
      const std::uint32_t mate = mesh(s).mates().aligned[h];
      if (mate < h && std::binary_search(faces.begin(), faces.end(), mate / 3)) continue;
      const Vec3 from = start_of(s, h);
      const Vec3 d = start_of(s, next_half_edge(h)) - from;
      double enter = 0.0;
      double leave = 1.0;
      if (!box_m.clip(from, d, enter, leave)) continue;
      if (!((leave - enter) * d.norm() > kShortPerBound * bound_m)) continue;
      const Vec3 begin = from + enter * d;
      const Vec3 end = from + leave * d;
      const Edge edge{s, h, from, from + d, Box{begin.cwiseMin(end), begin.cwiseMax(end)}, bound_m};
      others.tree().visit(box_in_mesh(other, edge.box_m.grown(bound_m)), work_,
                          [&](std::uint32_t g) {
                            for (std::uint32_t k = 3 * g; k < 3 * g + 3; ++k) {
                              // Two sharp edges are found from the surface with the higher number.
                              const bool is_found = s < other && others.is_sharp_edge(k);
                              if (others.is_first(k) && !is_found) cross(edge, other, k);
                            }
                            work_ += 4;
                            return !gives_up();
                          });
      if (gives_up()) return;
    }
  }
}

// Whether a segment is parallel to a face at an edge, to within the bound of both its ends. Edges
// that cross, and lie along none of their faces, belong to surfaces that pass through each other,
// or touch in a single point.
bool FlushSearch::lies_along(std::uint32_t s, std::uint32_t half_edge, const Vec3& from,
                             const Vec3& to, double bound_m) const {
  for (const std::uint32_t h : {half_edge, mesh(s).mates().aligned[half_edge]}) {
    if (h == kNoHalfEdge) continue;
    if (std::abs(height(s, h / 3, to) - height(s, h / 3, from)) <= 2 * bound_m) return true;
  }
  return false;
}

void FlushSearch::cross(const Edge& edge, std::uint32_t other, std::uint32_t other_half_edge) {
  const bool is_sharp = features(other).is_sharp_edge(other_half_edge);
  const Vec3 from = start_of(other, other_half_edge);
  const Vec3 to = start_of(other, next_half_edge(other_half_edge));
  if (!OverlapTree::meet(Box{from.cwiseMin(to), from.cwiseMax(to)}.grown(edge.bound_m),
                         edge.box_m)) {
    return;
  }
  const auto near = nearest_within(edge.from, edge.to, from, to, edge.bound_m);
  if (!near || !(near->distance_m <= edge.bound_m)) return;
  if (!lies_along(other, other_half_edge, edge.from, edge.to, edge.bound_m) &&
      !lies_along(edge.surface, edge.half_edge, from, to, edge.bound_m)) {
    return;
  }
  const int side = is_sharp ? 0
                            : side_of_edge(edge.surface, edge.half_edge, other, other_half_edge / 3,
                                           edge.bound_m);
  if (!is_sharp && side == 0) return;
  found_.crossings.push_back({edge.surface, edge.half_edge, other, other_half_edge, side, near->t});
}

}  // namespace palpate
