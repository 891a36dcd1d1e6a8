#pragma once

// Surfaces that are felt stretched or sheared, through an index that has them as they are.

#include <optional>

#include "geometry/base/types.h"
#include "geometry/exact/triangle.h"
#include "geometry/index/surface_index.h"

namespace palpate {

// The stretch of one surface. The index only sorts out: whatever is decided, crossing, height,
// distance and normal, is decided on triangles that are made when they are asked for, in the body
// frame, from the vertices that the index has in double. So all is as in the scene, to the rounding
// of a vertex, and one that two triangles share is one in the body frame, too.
//
// What sorts out looks farther: a ball of the body frame is within a ball of the index frame that
// is most_per_metre as large, and more by what rounding can make of a point on its way there.
//
// Immutable. No allocation, lock or exception.
class Stretch {
 public:
  // Whether one of these singular values is not too different from another: a surface that is
  // stretched more has an index of its own.
  static constexpr double kMostRatio = 100.0;

  // linear_body_index: p_body = linear p_index. Not singular to within rounding.
  Stretch(const Mat3& linear_body_index, const Box& box_index);

  const Mat3& linear_body_index() const { return linear_body_index_; }
  bool is_mirrored() const { return is_mirrored_; }

  // Of a point or a displacement, to within reach_index().
  Vec3 to_index(const Vec3& v_body) const { return linear_index_body_ * v_body; }

  // What is within reach_m of a segment that begins at p_body, or of that point, is within so much
  // of it in the index frame.
  double reach_index(double reach_m, const Vec3& p_body) const {
    const double rounding_m = roundoff_ * (2 * p_body.lpNorm<1>() + size_m_ + reach_m);
    return (reach_m + rounding_m) * most_per_metre_;
  }
  // The same for a ball around p_body, and what its box is in the index frame.
  StretchedBall ball_index(double radius_m, const Vec3& p_body) const;

  // A triangle of the index as it is felt. Where it has no area left in double, its normal is that
  // of the index under the inverse transpose.
  TriangleGeometry triangle(const TriangleGeometry& t_index) const noexcept;

  // Around the surface, body frame.
  Box box_body(const Box& box_index) const;
  // A length of the index frame, in a direction of no interest. Metres.
  double mean_length_m(double length_index) const { return mean_metres_ * length_index; }

 private:
  Mat3 linear_body_index_;
  Mat3 linear_index_body_;
  double most_per_metre_;  // length in the index frame of one in the body frame, at most
  double mean_metres_;     // the other way, quadratic mean over directions
  double roundoff_;        // of a point mapped to the index, in the body frame, of its 1-norm
  double size_m_;          // how far the surface reaches from the origin of the body frame, 1-norm
  bool is_mirrored_;
};

// The nearest point of a stretched surface at most radius_m away from p; of equally near faces the
// one found first. Body frame. As SurfaceIndex::closest_point(), but it looks at all triangles in
// a ball of the index that holds that of the body frame.
std::optional<SurfacePoint> closest_point(const SurfaceIndex& index, const Stretch& stretch,
                                          const Vec3& p_body, double radius_m) noexcept;

}  // namespace palpate
