#pragma once

// A judge of proxies that shares no code with the engine: it decides whether a path touches a
// triangle.
//
// Points are judged in exact arithmetic. A filter in double with a proven bound settles nearly
// every sign; integers of arbitrary length (Boost.Multiprecision) settle the other signs. Spheres
// are judged by the distance between path and triangle. This distance is evaluated in long double,
// from normals that were computed exactly and rounded once.
//
// Path and triangles are in one frame, in metres. The doubles are treated as exact numbers.
// Coordinates close to overflow are not supported.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/types.h"

namespace palpate::test {

struct Corners {
  Vec3 a, b, c;
};

// Returns the sign of (a - d) . ((b - d) x (c - d)), exactly: -1, 0 or 1.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// True if and only if the closed segment from p to q and the closed triangle have a point in
// common, exactly. If p == q, the segment is a point. The triangle must have an area.
bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Corners& t);

// True iff the corners lie on one line, exactly.
bool has_no_area(const Corners& t);

// The place where a path touches a triangle or gets too near to one.
struct Violation {
  std::size_t piece;     // piece of the path, from corner `piece` to the next
  std::size_t triangle;  // index in the judge's triangles
  double distance_m;     // distance between piece and triangle; 0 if they touch
};

class ExactJudge {
 public:
  using Wide3 = Eigen::Matrix<long double, 3, 1>;

  // Unit vectors, rounded from exact vectors.
  struct Directions {
    Wide3 normal;
    Wide3 outward[3];  // in the triangle's plane, outwards at the edges ab, bc, ca
    Wide3 along[3];    // the edges
    long double length_m[3];
  };
  struct Bounds {
    Vec3 low, high;
  };

  // Triangles without area are no obstacle and are left out.
  explicit ExactJudge(const std::vector<Corners>& triangles);

  // Returns the first piece of the polyline that touches a triangle. A path of a single corner is a
  // point.
  std::optional<Violation> touch_of_point(std::span<const Vec3> path) const;

  // Returns the first piece that touches a triangle or is nearer to one than least_distance_m.
  std::optional<Violation> touch_of_sphere(std::span<const Vec3> path,
                                           double least_distance_m) const;

  // True if p is inside a closed surface, by the parity of the triangles between p and infinity. p
  // must not lie on the surface.
  bool is_inside(const Vec3& p) const;

  // The distance between the closed segment from p to q and a triangle; 0 if they touch. Accurate
  // to a few ulp of the coordinates.
  double distance_m(const Vec3& p, const Vec3& q, std::size_t triangle) const;

  // The distance from the point p to the nearest triangle.
  double distance_m(const Vec3& p) const;

  const std::vector<Corners>& triangles() const { return triangles_; }
  const Bounds& bounds(std::size_t triangle) const { return bounds_[triangle]; }
  const Directions& directions(std::size_t triangle) const { return directions_[triangle]; }

  // True if a separating plane proves that the closed segment from p to q and the triangle are
  // farther apart than distance_m. False proves nothing.
  bool certainly_farther(const Vec3& p, const Vec3& q, std::size_t triangle,
                         double distance_m) const;

 private:
  static Directions directions_of(const Corners& t);
  long double distance_of_point(const Vec3& p, std::size_t triangle) const;
  // Directions, rounded to double.
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
  mutable std::vector<std::size_t> near_;  // reused, so that judging a tick does not allocate
};

}  // namespace palpate::test
