#pragma once

// A judge of proxies that shares no code with the engine: does a path touch a triangle?
//
// Points are judged in exact arithmetic: a filter in double with a proven bound settles nearly
// every sign, integers of any length (Boost.Multiprecision) the rest. Spheres are judged by the
// distance between path and triangle, evaluated in long double from normals that were exact before
// they were rounded once.
//
// One frame for path and triangles, metres. Coordinates are taken as the exact numbers that the
// doubles are; nothing is said about scenes whose coordinates come near overflow.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/types.h"

namespace palpate::test {

struct Corners {
  Vec3 a, b, c;
};

// Sign of (a - d) . ((b - d) x (c - d)), exactly: -1, 0 or 1.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// True iff the closed segment from p to q and the closed triangle have a point in common, exactly.
// p == q is a point. The triangle must have area.
bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Corners& t);

// True iff the corners lie on one line, exactly.
bool has_no_area(const Corners& t);

// Where a path did what it must not.
struct Violation {
  std::size_t piece;     // of the path, from corner `piece` to the next
  std::size_t triangle;  // as given to the judge
  double distance_m;     // between the two; 0 where they touch
};

class ExactJudge {
 public:
  using Wide3 = Eigen::Matrix<long double, 3, 1>;

  // Unit vectors, made from exact ones.
  struct Directions {
    Wide3 normal;
    Wide3 outward[3];  // in the plane, out of the triangle at edges ab, bc, ca
    Wide3 along[3];    // the edges
    long double length_m[3];
  };
  struct Bounds {
    Vec3 low, high;
  };

  // Triangles without area are no obstacle and are left out.
  explicit ExactJudge(const std::vector<Corners>& triangles);

  // The first piece of the polyline that touches a triangle. One corner is a point.
  std::optional<Violation> touch_of_point(std::span<const Vec3> path) const;

  // The first piece that touches a triangle or comes nearer to one than least_distance_m.
  std::optional<Violation> touch_of_sphere(std::span<const Vec3> path,
                                           double least_distance_m) const;

  // Whether p is inside a closed surface: the parity of the triangles between p and far away.
  // p must not lie on the surface.
  bool is_inside(const Vec3& p) const;

  // Of the closed segment from p to q; 0 if they touch. Good to a few ulp of the coordinates.
  double distance_m(const Vec3& p, const Vec3& q, std::size_t triangle) const;

  // The nearest that the point p is to any triangle.
  double distance_m(const Vec3& p) const;

  const std::vector<Corners>& triangles() const { return triangles_; }
  const Bounds& bounds(std::size_t triangle) const { return bounds_[triangle]; }
  const Directions& directions(std::size_t triangle) const { return directions_[triangle]; }

  // Whether a plane between the closed segment from p to q and the triangle shows that they are
  // farther apart than distance_m. False says nothing.
  bool certainly_farther(const Vec3& p, const Vec3& q, std::size_t triangle,
                         double distance_m) const;

 private:
  static Directions directions_of(const Corners& t);
  long double distance_of_point(const Vec3& p, std::size_t triangle) const;
  // The same as Directions, rounded.
  struct Plain {
    Vec3 normal;
    Vec3 outward[3];
    Vec3 along[3];
    double length_m[3];
  };
  double rough_distance_m(const Vec3& p, std::size_t triangle) const;
  void find_near(const Bounds& path, double margin_m) const;
  template <typename Judge>
  std::optional<Violation> first_violation(std::span<const Vec3> path, std::size_t first_piece,
                                           std::span<const std::size_t> near, double margin_m,
                                           Judge judge) const;
  template <typename Judge>
  std::optional<Violation> first_violation(std::span<const Vec3> path, double margin_m,
                                           Judge judge) const;

  std::vector<Corners> triangles_;
  std::vector<Bounds> bounds_;
  std::vector<Directions> directions_;
  std::vector<Plain> plain_;
  mutable std::vector<std::size_t> near_;  // kept, so that judging a tick does not allocate
};

}  // namespace palpate::test
