#include "geometry/exact/triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/exact/orientation.h"

namespace palpate {
namespace {

// A unit normal has an error of 4 roundings, and so has a direction computed from two points.
constexpr double kDirectionRoundoff = 4 * kUnitRoundoff;

// Rounding error of a position relative to an edge, as a fraction of the distance from the nearer
// end of the edge: 3 for the projection, 1 for the product, 1 for the difference.
constexpr double kEdgeRoundoff = 8 * kUnitRoundoff;

// An edge relative to the query point.
struct SeenEdge {
  Vec3 along;        // to - from
  Vec3 p_from;       // p - from
  Vec3 p_to;         // p - to
  double past_from;  // projection of p, times the squared edge length: > 0 inside or beyond `to`
  double past_to;    // < 0 inside or before `from`
  double side;       // of p, times the edge's length: < 0 outside the triangle

  // Positions are measured from the nearer end, so that the rounding error there is small.
  SeenEdge(const TriangleGeometry& t, const Vec3& from, const Vec3& to, const Vec3& p)
      : along(to - from),
        p_from(p - from),
        p_to(p - to),
        past_from(p_from.dot(along)),
        past_to(p_to.dot(along)),
        side(triple_product(t.normal, along, is_nearer_from() ? p_from : p_to)) {}

  bool is_nearer_from() const { return past_from < -past_to; }
  bool is_outside() const { return side < 0.0; }
  bool is_beside() const { return past_from > 0.0 && past_to < 0.0; }
  double roundoff_m() const { return kEdgeRoundoff * norm1(is_nearer_from() ? p_from : p_to); }
};

TrianglePoint at(const Vec3& apart, const Vec3& p, double error_m, TriangleFeature feature,
                 const Vec3& normal) {
  const double distance = apart.norm();
  if (distance == 0.0) return {p, 0.0, normal, 0.0, feature};
  return {p - apart, distance, apart / distance, kDirectionRoundoff + error_m / distance, feature};
}

TrianglePoint on_edge(const SeenEdge& e, const Vec3& p, const Vec3& normal) {
  const bool near_from = e.is_nearer_from();
  const double t = (near_from ? e.past_from : e.past_to) / e.along.squaredNorm();
  return at((near_from ? e.p_from : e.p_to) - t * e.along, p, e.roundoff_m(),
            TriangleFeature::kEdge, normal);
}

// Above or below the face, the direction is the normal or its opposite. Its error is larger if p is
// so close to an edge that rounding cannot decide whether p is outside this edge.
TrianglePoint on_face(const TriangleGeometry& t, const SeenEdge (&edges)[3], const Vec3& p) {
  const double height = t.normal.dot(edges[0].p_from);
  double error_m = 0.0;
  for (const SeenEdge& e : edges) {
    if (e.side <= e.roundoff_m() * norm1(e.along)) error_m = std::max(error_m, e.roundoff_m());
  }
  const double distance = std::abs(height);
  return {p - height * t.normal, distance, height < 0.0 ? Vec3(-t.normal) : t.normal,
          kDirectionRoundoff + (distance > 0.0 ? error_m / distance : 0.0), TriangleFeature::kFace};
}

TrianglePoint on_vertex(const Vec3& from_vertex, const Vec3& p, const Vec3& normal) {
  return at(from_vertex, p, 0.0, TriangleFeature::kVertex, normal);
}

}  // namespace

TrianglePoint closest_point_on_triangle(const TriangleGeometry& t, const Vec3& p) noexcept {
  const SeenEdge edges[3] = {{t, t.a, t.b, p}, {t, t.b, t.c, p}, {t, t.c, t.a, p}};
  if (!edges[0].is_outside() && !edges[1].is_outside() && !edges[2].is_outside()) {
    return on_face(t, edges, p);
  }
  constexpr double kNone = std::numeric_limits<double>::infinity();
  TrianglePoint nearest{p, kNone, t.normal, 0.0};
  const auto consider = [&](const TrianglePoint& candidate) {
    if (candidate.distance < nearest.distance) nearest = candidate;
  };
  // The nearest feature is found from the region that contains p, not by comparing distances. The
  // distances to a vertex and to its edge can agree to the last bit while their directions still
  // differ considerably.
  for (std::size_t i = 0; i < 3; ++i) {
    const SeenEdge& in = edges[(i + 2) % 3];
    const SeenEdge& out = edges[i];
    if (out.is_outside() && out.is_beside()) consider(on_edge(out, p, t.normal));
    if (in.past_to >= 0.0 && out.past_from <= 0.0) consider(on_vertex(out.p_from, p, t.normal));
  }
  if (nearest.distance < kNone) return nearest;
  // Due to rounding, p lies in none of the regions.
  for (const SeenEdge& edge : edges) {
    if (edge.is_beside()) consider(on_edge(edge, p, t.normal));
    consider(on_vertex(edge.p_from, p, t.normal));
  }
  return nearest;
}

}  // namespace palpate
