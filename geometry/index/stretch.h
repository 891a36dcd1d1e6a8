#pragma once

// Queries on a stretched or sheared surface through the index of the unstretched surface.

#include <optional>

#include "geometry/base/types.h"
#include "geometry/exact/triangle.h"
#include "geometry/index/surface_index.h"

namespace palpate {

// The stretch of one surface: a linear map from the index frame to the body frame. The index only
// finds candidate triangles. Crossings, heights, distances and normals are computed on triangles in
// the body frame, which are mapped on demand from the index's vertices in double. Results are
// therefore exact up to the rounding of the mapped vertices, and a vertex shared by two triangles
// stays shared in the body frame.
//
// The search in the index uses a larger radius. A ball in the body frame is contained in a ball in
// the index frame. The radius of the second ball is most_per_metre_ times that of the first, plus a
// margin for the rounding of the mapped point.
//
// Immutable. No allocation, lock or exception.
class Stretch {
 public:
  // The largest accepted ratio of two singular values of the map. Beyond this ratio, a surface has
  // its own index.
  static constexpr double kMostRatio = 100.0;

  // linear_body_index: p_body = linear_body_index * p_index. The map must not be singular to within
  // rounding.
  Stretch(const Mat3& linear_body_index, const Box& box_index);

  const Mat3& linear_body_index() const { return linear_body_index_; }
  bool is_mirrored() const { return is_mirrored_; }

  // Maps a point or a displacement to the index frame. reach_index() includes the rounding error of
  // the result.
  Vec3 to_index(const Vec3& v_body) const { return linear_index_body_ * v_body; }

  // Maps a search distance to the index frame: every point within reach_m of p_body, or of a
  // segment that begins at p_body, is within the returned distance of the mapped point or segment.
  double reach_index(double reach_m, const Vec3& p_body) const {
    const double rounding_m = roundoff_ * (2 * p_body.lpNorm<1>() + size_m_ + reach_m);
    return (reach_m + rounding_m) * most_per_metre_;
  }
  // Maps a ball around p_body to the index frame. Returns a ball there that contains the mapped
  // ball, and the bounding box of the mapped ball.
  StretchedBall ball_index(double radius_m, const Vec3& p_body) const;

  // Maps a triangle of the index to the body frame. If the mapped triangle has no area in double,
  // its normal is the index's normal mapped by the inverse transpose.
  TriangleGeometry triangle(const TriangleGeometry& t_index) const noexcept;

  // The bounding box of the surface in the body frame.
  Box box_body(const Box& box_index) const;
  // Maps a length of the index frame to metres. The mapped length depends on the direction; the
  // result is its quadratic mean over all directions.
  double mean_length_m(double length_index) const { return mean_metres_ * length_index; }

 private:
  Mat3 linear_body_index_;
  Mat3 linear_index_body_;
  double most_per_metre_;  // largest index-frame length of a unit body-frame vector
  double mean_metres_;     // body-frame length of a unit index-frame vector: quadratic mean over
                           // directions
  double roundoff_;  // of a point mapped to the index, in the body frame, relative to its 1-norm
  double size_m_;    // largest 1-norm of a surface point in the body frame
  bool is_mirrored_;
};

// The nearest point of a stretched surface within radius_m of p_body. If several faces are equally
// near, the first one found is returned. Body frame. Like SurfaceIndex::closest_point(), but the
// search covers a ball in the index frame that contains the ball in the body frame.
std::optional<SurfacePoint> closest_point(const SurfaceIndex& index, const Stretch& stretch,
                                          const Vec3& p_body, double radius_m) noexcept;

}  // namespace palpate
