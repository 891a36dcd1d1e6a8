#include "tests/helpers/exact_judge.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

namespace palpate::test {
namespace {

using Int = boost::multiprecision::cpp_int;
using IntVec = std::array<Int, 3>;

constexpr double kUnit = 0x1p-53;  // half an ulp of 1

// If products of coordinate differences are smaller than this, underflow invalidates the filter's
// bound.
constexpr double kNoUnderflow = 1e-270;

// A cast to double, direction and difference, product and two sums are 5 roundings; tripled.
constexpr double kHeightBound = 16 * kUnit;

// The same for a distance, which takes some more differences, products and sums, and whose
// directions have errors that grow with the distance along them. The bound is generous.
constexpr double kDistanceBound = 256 * kUnit;

// The doubles, multiplied by one power of two that makes all of them integers.
template <std::size_t N>
std::array<IntVec, N> on_grid(const std::array<const Vec3*, N>& points) {
  constexpr int kMantissaBits = 53;
  int least = std::numeric_limits<int>::max();
  for (const Vec3* p : points) {
    for (int k = 0; k < 3; ++k) {
      if ((*p)[k] != 0.0) least = std::min(least, std::ilogb((*p)[k]));
    }
  }
  std::array<IntVec, N> grid;
  for (std::size_t i = 0; i < N; ++i) {
    for (int k = 0; k < 3; ++k) {
      const double x = (*points[i])[k];
      if (x == 0.0) continue;
      int exponent = 0;
      const double mantissa = std::ldexp(std::frexp(x, &exponent), kMantissaBits);
      Int value = static_cast<std::int64_t>(mantissa);
      // frexp's exponent is one more than ilogb's.
      value <<= static_cast<unsigned>(exponent - 1 - least);
      grid[i][static_cast<std::size_t>(k)] = value;
    }
  }
  return grid;
}

IntVec minus(const IntVec& a, const IntVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

IntVec cross(const IntVec& a, const IntVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Int dot(const IntVec& a, const IntVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto g = on_grid<4>({&a, &b, &c, &d});
  return dot(minus(g[0], g[3]), cross(minus(g[1], g[3]), minus(g[2], g[3]))).sign();
}

// The coplanar case, projected along the largest component of the normal: any component that is not
// zero preserves the incidences.
class Flat {
 public:
  Flat(const IntVec& normal, std::array<IntVec, 5> points) : points_(std::move(points)) {
    std::size_t drop = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (abs(normal[k]) > abs(normal[drop])) drop = k;
    }
    x_ = (drop + 1) % 3;
    y_ = (drop + 2) % 3;
  }

  // Points 0 and 1 are the segment's, 2 to 4 the triangle's.
  bool segment_meets_triangle() const {
    if (in_triangle(0)) return true;
    return segments_meet(2, 3) || segments_meet(3, 4) || segments_meet(4, 2);
  }

 private:
  int turn(std::size_t i, std::size_t j, std::size_t k) const {
    const auto& [a, b, c] = std::tie(points_[i], points_[j], points_[k]);
    return Int((b[x_] - a[x_]) * (c[y_] - a[y_]) - (b[y_] - a[y_]) * (c[x_] - a[x_])).sign();
  }
  // For collinear points: is k between i and j?
  bool between(std::size_t i, std::size_t j, std::size_t k) const {
    const auto within = [&](std::size_t axis) {
      const auto& [a, b, c] = std::tie(points_[i][axis], points_[j][axis], points_[k][axis]);
      return (a <= c && c <= b) || (b <= c && c <= a);
    };
    return within(x_) && within(y_);
  }
  bool in_triangle(std::size_t p) const {
    const std::array<int, 3> turns = {turn(2, 3, p), turn(3, 4, p), turn(4, 2, p)};
    const auto [least, most] = std::minmax_element(turns.begin(), turns.end());
    return !(*least < 0 && *most > 0);
  }
  bool segments_meet(std::size_t e, std::size_t f) const {
    const int p = turn(e, f, 0);
    const int q = turn(e, f, 1);
    const int a = turn(0, 1, e);
    const int b = turn(0, 1, f);
    if (p * q < 0 && a * b < 0) return true;
    return (p == 0 && between(e, f, 0)) || (q == 0 && between(e, f, 1)) ||
           (a == 0 && between(0, 1, e)) || (b == 0 && between(0, 1, f));
  }

  std::array<IntVec, 5> points_;
  std::size_t x_ = 0;
  std::size_t y_ = 1;
};

bool coplanar_segment_meets_triangle(const Vec3& p, const Vec3& q, const Corners& t) {
  const auto g = on_grid<5>({&p, &q, &t.a, &t.b, &t.c});
  return Flat(cross(minus(g[3], g[2]), minus(g[4], g[2])), g).segment_meets_triangle();
}

IntVec exact_normal(const Corners& t) {
  const auto g = on_grid<3>({&t.a, &t.b, &t.c});
  return cross(minus(g[1], g[0]), minus(g[2], g[0]));
}

bool boxes_apart(const Vec3& low, const Vec3& high, const Vec3& other_low, const Vec3& other_high,
                 double margin) {
  for (int k = 0; k < 3; ++k) {
    if (other_low[k] - high[k] > margin || low[k] - other_high[k] > margin) return true;
  }
  return false;
}

}  // namespace

// The filter is stage A of J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast
// Robust Geometric Predicates" (1997), whose bound is (7 + 56 u) u times the permanent.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double ax = a.x() - d.x(), ay = a.y() - d.y(), az = a.z() - d.z();
  const double bx = b.x() - d.x(), by = b.y() - d.y(), bz = b.z() - d.z();
  const double cx = c.x() - d.x(), cy = c.y() - d.y(), cz = c.z() - d.z();
  const double bc = bx * cy, cb = cx * by;
  const double ca = cx * ay, ac = ax * cy;
  const double ab = ax * by, ba = bx * ay;
  const double volume = az * (bc - cb) + bz * (ca - ac) + cz * (ab - ba);
  const double permanent = (std::abs(bc) + std::abs(cb)) * std::abs(az) +
                           (std::abs(ca) + std::abs(ac)) * std::abs(bz) +
                           (std::abs(ab) + std::abs(ba)) * std::abs(cz);
  const double bound = 8 * kUnit * permanent;
  if (permanent > kNoUnderflow && std::abs(volume) > bound) return volume > 0.0 ? 1 : -1;
  return exact_orientation(a, b, c, d);
}

bool has_no_area(const Corners& t) {
  const IntVec normal = exact_normal(t);
  return normal[0] == 0 && normal[1] == 0 && normal[2] == 0;
}

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Corners& t) {
  const int side_p = orientation(t.a, t.b, t.c, p);
  const int side_q = orientation(t.a, t.b, t.c, q);
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && side_q == 0) return coplanar_segment_meets_triangle(p, q, t);
  // The line through p and q meets the triangle's plane once, between p and q. It meets the
  // triangle unless it passes one edge on the left and another on the right.
  const std::array<int, 3> passes = {orientation(p, q, t.a, t.b), orientation(p, q, t.b, t.c),
                                     orientation(p, q, t.c, t.a)};
  const auto [least, most] = std::minmax_element(passes.begin(), passes.end());
  return !(*least < 0 && *most > 0);
}

ExactJudge::ExactJudge(const std::vector<Corners>& triangles) {
  for (const Corners& t : triangles) {
    if (has_no_area(t)) continue;
    triangles_.push_back(t);
    bounds_.push_back({t.a.cwiseMin(t.b).cwiseMin(t.c), t.a.cwiseMax(t.b).cwiseMax(t.c)});
    const Directions d = directions_of(t);
    Plain plain;
    plain.normal = d.normal.cast<double>();
    for (std::size_t e = 0; e < 3; ++e) {
      plain.outward[e] = d.outward[e].cast<double>();
      plain.along[e] = d.along[e].cast<double>();
      plain.length_m[e] = static_cast<double>(d.length_m[e]);
    }
    directions_.push_back(d);
    plain_.push_back(plain);
  }
  near_.reserve(triangles_.size());
}

ExactJudge::Directions ExactJudge::directions_of(const Corners& t) {
  const IntVec exact = exact_normal(t);
  Directions d;
  // Only the direction matters. The integers are shifted, because they exceed even a long double's
  // range.
  std::size_t bits = 0;
  for (const Int& x : exact) bits = std::max<std::size_t>(bits, x == 0 ? 0 : msb(Int(abs(x))));
  const unsigned keep = 400;
  const unsigned shift = bits > keep ? static_cast<unsigned>(bits - keep) : 0;
  for (int k = 0; k < 3; ++k) {
    d.normal[k] = Int(exact[static_cast<std::size_t>(k)] >> shift).convert_to<long double>();
  }
  d.normal.normalize();
  const std::array<const Vec3*, 4> corners = {&t.a, &t.b, &t.c, &t.a};
  for (std::size_t e = 0; e < 3; ++e) {
    const Wide3 edge = corners[e + 1]->cast<long double>() - corners[e]->cast<long double>();
    d.length_m[e] = edge.norm();
    d.along[e] = edge / d.length_m[e];
    d.outward[e] = d.along[e].cross(d.normal).normalized();
  }
  return d;
}

// Searches for a separating plane among the directions of the triangle's normal and its edges'
// normals.
bool ExactJudge::certainly_farther(const Vec3& p, const Vec3& q, std::size_t triangle,
                                   double distance_m) const {
  const Corners& t = triangles_[triangle];
  const Plain& d = plain_[triangle];
  const auto beyond = [&](const Vec3& direction, const Vec3& origin) {
    const Vec3 to_p = p - origin;
    const Vec3 to_q = q - origin;
    const double bound = kHeightBound * std::max(to_p.lpNorm<1>(), to_q.lpNorm<1>());
    return std::min(direction.dot(to_p), direction.dot(to_q)) > distance_m + bound;
  };
  if (beyond(d.normal, t.a) || beyond(-d.normal, t.a)) return true;
  return beyond(d.outward[0], t.a) || beyond(d.outward[1], t.b) || beyond(d.outward[2], t.c);
}

long double ExactJudge::distance_of_point(const Vec3& p, std::size_t triangle) const {
  const Corners& t = triangles_[triangle];
  const Directions& d = directions_[triangle];
  const Wide3 x = p.cast<long double>();
  const std::array<Wide3, 3> corners = {t.a.cast<long double>(), t.b.cast<long double>(),
                                        t.c.cast<long double>()};
  bool over = true;
  long double nearest = std::numeric_limits<long double>::infinity();
  for (std::size_t e = 0; e < 3; ++e) {
    const Wide3 to_x = x - corners[e];
    over = over && d.outward[e].dot(to_x) <= 0.0L;
    const long double at = std::clamp(d.along[e].dot(to_x), 0.0L, d.length_m[e]);
    nearest = std::min(nearest, (to_x - at * d.along[e]).norm());
  }
  return over ? std::abs(d.normal.dot(x - corners[0])) : nearest;
}

double ExactJudge::distance_m(const Vec3& p, const Vec3& q, std::size_t triangle) const {
  const Corners& t = triangles_[triangle];
  if (segment_meets_triangle(p, q, t)) return 0.0;
  long double nearest = std::min(distance_of_point(p, triangle), distance_of_point(q, triangle));
  const Wide3 from = p.cast<long double>();
  const Wide3 step = q.cast<long double>() - from;
  if (step.isZero(0.0L)) return static_cast<double>(nearest);
  // If neither end is nearest to the triangle, an edge is nearest: at one of its ends or between
  // them.
  const Directions& d = directions_[triangle];
  const std::array<const Vec3*, 3> corners = {&t.a, &t.b, &t.c};
  for (std::size_t e = 0; e < 3; ++e) {
    const Wide3 corner = corners[e]->cast<long double>();
    const Wide3 to_from = from - corner;
    const long double at_corner = std::clamp(-to_from.dot(step) / step.squaredNorm(), 0.0L, 1.0L);
    nearest = std::min(nearest, (to_from + at_corner * step).norm());
    const Wide3 step_across = step - d.along[e].dot(step) * d.along[e];
    if (step_across.isZero(0.0L)) continue;
    const Wide3 from_across = to_from - d.along[e].dot(to_from) * d.along[e];
    const long double at_edge =
        std::clamp(-from_across.dot(step_across) / step_across.squaredNorm(), 0.0L, 1.0L);
    const Wide3 x = to_from + at_edge * step;
    const long double along = std::clamp(d.along[e].dot(x), 0.0L, d.length_m[e]);
    nearest = std::min(nearest, (x - along * d.along[e]).norm());
  }
  return static_cast<double>(nearest);
}

double ExactJudge::distance_m(const Vec3& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    if (certainly_farther(p, p, i, nearest)) continue;
    nearest = std::min(nearest, static_cast<double>(distance_of_point(p, i)));
  }
  return nearest;
}

void ExactJudge::find_near(const Bounds& path, double margin_m) const {
  near_.clear();
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    if (!boxes_apart(path.low, path.high, bounds_[i].low, bounds_[i].high, margin_m)) {
      near_.push_back(i);
    }
  }
}

// The distance of a point in double, with an error of some roundings of the coordinates involved.
double ExactJudge::rough_distance_m(const Vec3& p, std::size_t triangle) const {
  const Corners& t = triangles_[triangle];
  const Plain& d = plain_[triangle];
  const std::array<const Vec3*, 3> corners = {&t.a, &t.b, &t.c};
  bool over = true;
  double nearest2 = std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3 to_p = p - *corners[e];
    over = over && d.outward[e].dot(to_p) <= 0.0;
    const double at = std::clamp(d.along[e].dot(to_p), 0.0, d.length_m[e]);
    nearest2 = std::min(nearest2, (to_p - at * d.along[e]).squaredNorm());
  }
  return over ? std::abs(d.normal.dot(p - t.a)) : std::sqrt(nearest2);
}

// Calls judge(p, q, triangle) for each piece of the path and each near triangle that is not
// certainly farther away than the margin. judge returns a distance if the piece violates the rule.
// The path is halved recursively: a triangle that is far from a ball around a part of the path is
// far from all pieces of that part.
template <typename Judge>
std::optional<Violation> ExactJudge::first_violation(std::span<const Vec3> path,
                                                     std::size_t first_piece,
                                                     std::span<const std::size_t> near,
                                                     double margin_m, Judge judge) const {
  Bounds box{path.front(), path.front()};
  for (const Vec3& p : path) box = {box.low.cwiseMin(p), box.high.cwiseMax(p)};
  const Vec3 centre = 0.5 * (box.low + box.high);
  double radius_m = 0.0;
  for (const Vec3& p : path) radius_m = std::max(radius_m, (p - centre).norm());
  std::vector<std::size_t> nearer;
  for (const std::size_t i : near) {
    if (boxes_apart(box.low, box.high, bounds_[i].low, bounds_[i].high, margin_m)) continue;
    const double distance_m = rough_distance_m(centre, i);
    const double reach_m = centre.lpNorm<1>() + (bounds_[i].high - bounds_[i].low).lpNorm<1>();
    const double bound = kDistanceBound * (reach_m + distance_m + radius_m + margin_m);
    if (distance_m - radius_m > margin_m + bound) continue;
    nearer.push_back(i);
  }
  const std::size_t pieces = path.size() - 1;
  if (pieces <= 1) {
    for (const std::size_t i : nearer) {
      if (const std::optional<double> distance = judge(path.front(), path.back(), i)) {
        return Violation{first_piece, i, *distance};
      }
    }
    return std::nullopt;
  }
  if (nearer.empty()) return std::nullopt;
  const std::size_t half = pieces / 2;
  const auto before = first_violation(path.first(half + 1), first_piece, nearer, margin_m, judge);
  if (before) return before;
  return first_violation(path.subspan(half), first_piece + half, nearer, margin_m, judge);
}

template <typename Judge>
std::optional<Violation> ExactJudge::first_violation(std::span<const Vec3> path, double margin_m,
                                                     Judge judge) const {
  if (path.empty()) return std::nullopt;
  Bounds all{path.front(), path.front()};
  for (const Vec3& p : path) all = {all.low.cwiseMin(p), all.high.cwiseMax(p)};
  find_near(all, margin_m);
  return first_violation(path, 0, near_, margin_m, judge);
}

std::optional<Violation> ExactJudge::touch_of_point(std::span<const Vec3> path) const {
  return first_violation(
      path, 0.0, [this](const Vec3& p, const Vec3& q, std::size_t i) -> std::optional<double> {
        if (segment_meets_triangle(p, q, triangles_[i])) return 0.0;
        return std::nullopt;
      });
}

std::optional<Violation> ExactJudge::touch_of_sphere(std::span<const Vec3> path,
                                                     double least_distance_m) const {
  return first_violation(path, least_distance_m,
                         [&](const Vec3& p, const Vec3& q, std::size_t i) -> std::optional<double> {
                           if (certainly_farther(p, q, i, least_distance_m)) return std::nullopt;
                           const double distance = distance_m(p, q, i);
                           if (distance < least_distance_m) return distance;
                           return std::nullopt;
                         });
}

bool ExactJudge::is_inside(const Vec3& p) const {
  Vec3 low = p;
  Vec3 high = p;
  for (const Bounds& b : bounds_) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
  // Rays that touch an edge are inconclusive, so another is tried. Odd numbers make such rays rare.
  for (double slant = 0.3141;; slant += 0.0271) {
    const Vec3 out = high + (high - low).cwiseProduct(Vec3(1.0, slant, slant * slant));
    int crossings = 0;
    bool clean = true;
    for (const Corners& t : triangles_) {
      const int side_p = orientation(t.a, t.b, t.c, p);
      const int side_out = orientation(t.a, t.b, t.c, out);
      if (side_p * side_out > 0) continue;
      const int ab = orientation(p, out, t.a, t.b);
      const int bc = orientation(p, out, t.b, t.c);
      const int ca = orientation(p, out, t.c, t.a);
      const bool passes_by = std::min({ab, bc, ca}) < 0 && std::max({ab, bc, ca}) > 0;
      if (passes_by) continue;
      clean = clean && side_p * side_out * ab * bc * ca != 0;
      ++crossings;
    }
    if (clean) return crossings % 2 == 1;
  }
}

}  // namespace palpate::test
