#pragma once

// The plane of motion of a device with two sensors.

#include <cmath>

#include "geometry/base/types.h"
#include "geometry/exact/orientation.h"

namespace palpate {

// A vector of the plane of motion, in the coordinates of its basis.
using Vec2 = Eigen::Vector2d;

// The direction of a plane of motion, with an orthonormal basis. Vectors of the plane have two
// coordinates in this basis; a vector that is computed in these coordinates cannot leave the plane.
// A coordinate plane has coordinate axes as its basis, so that a conversion rounds nothing there.
// Solver frame.
//
// Safe on the haptic thread: no allocation, lock or exception. Thread-safety: a value.
class MotionPlane {
 public:
  // normal: unit to within is_unit().
  explicit MotionPlane(const Vec3& normal) noexcept : given_normal_(normal), normal_(normal) {
    normal_.normalize();
    Eigen::Index least = 0;
    normal_.cwiseAbs().minCoeff(&least);
    axis_1_ = (Vec3::Unit(least) - normal_[least] * normal_).normalized();
    axis_2_ = normal_.cross(axis_1_);
  }

  const Vec3& normal() const { return normal_; }
  const Vec3& given_normal() const { return given_normal_; }  // as given to the constructor

  // The coordinates of the part of a vector that lies in the plane, the vector with the given
  // coordinates, and the part itself.
  Vec2 to_plane(const Vec3& v) const { return {axis_1_.dot(v), axis_2_.dot(v)}; }
  Vec3 to_solver(const Vec2& v) const { return v.x() * axis_1_ + v.y() * axis_2_; }
  Vec3 part_of(const Vec3& v) const { return to_solver(to_plane(v)); }

  // The height, m, of the plane through one point above the point p; 0 within its rounding.
  double height_over_m(const Vec3& p, const Vec3& through) const {
    const Vec3 to = through - p;
    const double height_m = to.dot(normal_);
    const Vec3 coordinates_m = p.cwiseAbs() + through.cwiseAbs();
    const double rounding_m = kHeightRoundoffPerDistance * to.lpNorm<1>() +
                              kRoundoffOfCoordinates * coordinates_m.dot(normal_.cwiseAbs());
    return std::abs(height_m) <= rounding_m ? 0.0 : height_m;
  }

  // The point of the plane through one point that is nearest to p; p if it lies there within
  // rounding.
  Vec3 nearest(const Vec3& p, const Vec3& through) const {
    const double height_m = height_over_m(p, through);
    return height_m == 0.0 ? p : Vec3(p + height_m * normal_);
  }

 private:
  // Rounding of the height of a point over a plane through another point, relative to the distance
  // between the two points: 1 rounding for their difference, 3 for the product and 4 for the length
  // of the normal.
  static constexpr double kHeightRoundoffPerDistance = 8 * kUnitRoundoff;
  // Rounding of the height relative to the coordinates, of which each is rounded once.
  static constexpr double kRoundoffOfCoordinates = kUnitRoundoff;

  Vec3 given_normal_;
  Vec3 normal_;
  Vec3 axis_1_;
  Vec3 axis_2_;
};

}  // namespace palpate
