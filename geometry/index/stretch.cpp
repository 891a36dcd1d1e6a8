#include "geometry/index/stretch.h"

#include <cmath>
#include <utility>

#include "geometry/base/decompositions.h"
#include "geometry/exact/exact.h"
#include "geometry/exact/orientation.h"
#include "geometry/index/pack_queries.h"

namespace palpate {
namespace {

// Rounding in units of the unit roundoff times |L| |M| |p|, where L and M are the maps between the
// frames: 3 for a point or a displacement mapped to the index, 3 for a vertex of the index mapped
// to the body frame, 2 for the difference of two points.
constexpr double kMapRoundoff = 8 * kUnitRoundoff;

// A factor on a length that covers second-order terms.
constexpr double kSlack = 1 + 0x1p-30;

// A nearest-point search in progress.
struct NearestSearch {
  const SurfaceIndex& index;
  const Stretch& stretch;
  Vec3 p_body, p_index;
  double best_m;
  std::optional<SurfacePoint> nearest;

  StretchedBall needed() const { return stretch.ball_index(best_m, p_body); }

  StretchedBall consider(std::uint32_t id) {
    LaneDistances distances;
    const TrianglePack& pack = index.pack(id);
    double radius = stretch.reach_index(best_m, p_body);
    for (std::uint32_t lanes = lanes_within(pack, p_index, radius, distances); lanes != 0;) {
      // The lane with the smallest distance estimate is first: it usually rules out most other
      // lanes.
      const int lane = least_lane(lanes, distances.squared);
      lanes &= ~(1u << lane);
      if (!distances.may_be_within(lane, local_length(pack, radius))) break;
      const std::uint32_t slot = SurfaceIndex::slot(id, lane);
      const TrianglePoint point =
          closest_point_on_triangle(stretch.triangle(index.triangle(slot)), p_body);
      if (point.distance > best_m || (nearest && point.distance == best_m)) continue;
      best_m = point.distance;
      nearest = SurfacePoint{point.point, point.distance, index.face(slot)};
      radius = stretch.reach_index(best_m, p_body);
    }
    return needed();
  }
};

}  // namespace

Stretch::Stretch(const Mat3& linear_body_index, const Box& box_index)
    : linear_body_index_(linear_body_index),
      mean_metres_(linear_body_index.norm() / std::sqrt(3.0)),
      is_mirrored_(linear_body_index.determinant() < 0.0) {
  const SingularValueDecomposition svd = decompose(linear_body_index);
  const Vec3 inverse = svd.values.cwiseInverse();
  const Mat3 scaled = inverse.asDiagonal() * svd.u.transpose();
  linear_index_body_ = svd.v * scaled;
  most_per_metre_ = kSlack * inverse[2];
  const Mat3 magnitude = linear_body_index_.cwiseAbs() * linear_index_body_.cwiseAbs();
  const Mat3 off = linear_body_index_ * linear_index_body_ - Mat3::Identity();
  roundoff_ = kSlack * (off.norm() + kMapRoundoff * magnitude.norm());
  const Vec3 farthest = box_index.low.cwiseAbs().cwiseMax(box_index.high.cwiseAbs());
  size_m_ = kSlack * (linear_body_index_.cwiseAbs() * farthest).lpNorm<1>();
}

StretchedBall Stretch::ball_index(double radius_m, const Vec3& p_body) const {
  const double radius = reach_index(radius_m, p_body);
  const Vec3 rows = linear_index_body_.rowwise().norm();
  return {radius, kSlack * radius / most_per_metre_ * rows};
}

TriangleGeometry Stretch::triangle(const TriangleGeometry& t_index) const noexcept {
  const Mat3& map = linear_body_index_;
  TriangleGeometry t{map * t_index.a, map * t_index.b, map * t_index.c, {}};
  if (is_mirrored_) std::swap(t.b, t.c);
  t.normal = exactly_collinear(t.a, t.b, t.c)
                 ? Vec3((linear_index_body_.transpose() * t_index.normal).normalized())
                 : accurate_unit_normal(t.a, t.b, t.c);
  return t;
}

Box Stretch::box_body(const Box& box_index) const {
  const Vec3 centre = linear_body_index_ * (0.5 * (box_index.low + box_index.high));
  const Vec3 half = linear_body_index_.cwiseAbs() * (0.5 * (box_index.high - box_index.low));
  return {centre - half, centre + half};
}

std::optional<SurfacePoint> closest_point(const SurfaceIndex& index, const Stretch& stretch,
                                          const Vec3& p_body, double radius_m) noexcept {
  NearestSearch search{index, stretch, p_body, stretch.to_index(p_body), radius_m, {}};
  index.visit_nearest_packs(
      search.p_index, search.needed(),
      [](void* s, std::uint32_t pack) { return static_cast<NearestSearch*>(s)->consider(pack); },
      &search);
  return search.nearest;
}

}  // namespace palpate
