#pragma once

// Tests in exact arithmetic whether a segment touches a triangle, so that tests of crossings do not
// depend on the predicates under test. The arithmetic uses sums of doubles without rounding
// (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates", 1997).

#include <array>
#include <cmath>
#include <initializer_list>
#include <vector>

#include "geometry/base/types.h"

namespace palpate::test {

// An exact number: a sum of non-overlapping doubles in ascending order of magnitude.
class ExactSum {
 public:
  static ExactSum difference(double a, double b) {
    ExactSum sum;
    sum.add(a);
    sum.add(-b);
    return sum;
  }

  void add(double b) {
    std::vector<double> grown;
    double carry = b;
    for (const double term : terms_) {
      const double sum = carry + term;
      const double part = sum - carry;
      const double lost = (carry - (sum - part)) + (term - part);
      if (lost != 0.0) grown.push_back(lost);
      carry = sum;
    }
    if (carry != 0.0) grown.push_back(carry);
    terms_ = std::move(grown);
  }
  ExactSum operator*(const ExactSum& other) const {
    ExactSum product;
    for (const double a : terms_) {
      for (const double b : other.terms_) {
        const double high = a * b;
        product.add(std::fma(a, b, -high));
        product.add(high);
      }
    }
    return product;
  }
  ExactSum& operator+=(const ExactSum& other) {
    for (const double term : other.terms_) add(term);
    return *this;
  }
  ExactSum operator-() const {
    ExactSum negated = *this;
    for (double& term : negated.terms_) term = -term;
    return negated;
  }
  int sign() const { return terms_.empty() ? 0 : terms_.back() > 0.0 ? 1 : -1; }

 private:
  std::vector<double> terms_;
};

inline int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  std::array<std::array<ExactSum, 3>, 3> m;
  const std::array<const Vec3*, 3> rows = {&a, &b, &c};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int axis = static_cast<int>(k);
      m[i][k] = ExactSum::difference((*rows[i])[axis], d[axis]);
    }
  }
  ExactSum volume;
  for (std::size_t k = 0; k < 3; ++k) {
    ExactSum minor = m[1][(k + 1) % 3] * m[2][(k + 2) % 3];
    minor += -(m[1][(k + 2) % 3] * m[2][(k + 1) % 3]);
    volume += m[0][k] * minor;
  }
  return volume.sign();
}

// The sign of the volume (a - d) . ((b - d) x (c - d)). Its rounding error in double is below 8
// half-ulps of the summed magnitudes of its products (Shewchuk: 7 + 56 eps). Volumes below twice
// that bound are computed in exact arithmetic.
inline int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = a - d;
  const Vec3 v = b - d;
  const Vec3 w = c - d;
  const double volume = u.dot(v.cross(w));
  const Vec3 magnitude(std::abs(v.y() * w.z()) + std::abs(v.z() * w.y()),
                       std::abs(v.z() * w.x()) + std::abs(v.x() * w.z()),
                       std::abs(v.x() * w.y()) + std::abs(v.y() * w.x()));
  const double bound = 16 * 0x1p-53 * u.cwiseAbs().dot(magnitude);
  if (volume > bound) return 1;
  if (volume < -bound) return -1;
  return exact_orientation(a, b, c, d);
}

inline bool none_opposed(std::initializer_list<int> signs) {
  bool positive = false;
  bool negative = false;
  for (const int sign : signs) {
    positive = positive || sign > 0;
    negative = negative || sign < 0;
  }
  return !(positive && negative);
}

// A segment in the plane of a triangle touches the triangle if one of its ends lies in the triangle
// or if it meets an edge of the triangle.
inline bool touch_in_plane(const std::array<Vec3, 3>& t, const Vec3& p, const Vec3& q) {
  Vec3 off_plane = t[0];
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 candidate = t[0];
    candidate[axis] += (t[1] - t[0]).norm() + (t[2] - t[0]).norm();
    if (orientation(t[0], t[1], t[2], candidate) != 0) off_plane = candidate;
  }
  const auto side = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return orientation(a, b, c, off_plane);
  };
  for (const Vec3* end : {&p, &q}) {
    if (none_opposed({side(t[0], t[1], *end), side(t[1], t[2], *end), side(t[2], t[0], *end)})) {
      return true;
    }
  }
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3& a = t[e];
    const Vec3& b = t[(e + 1) % 3];
    // The segment's ends lie strictly on different sides of the edge's line, and the edge's ends do
    // not lie strictly on one side of the segment's line. An end on the edge was found above, and
    // an edge along the segment shares its corners with the other edges.
    const bool parts_edge = side(p, q, a) * side(p, q, b) <= 0;
    const bool parts_segment = side(a, b, p) * side(a, b, q) < 0;
    if (parts_edge && parts_segment) return true;
  }
  return false;
}

// Whether the closed segment from p to q and the closed triangle have a common point; exact. The
// triangle must have an area, and p must differ from q.
inline bool exactly_touch(const std::array<Vec3, 3>& t, const Vec3& p, const Vec3& q) {
  const Vec3 low = p.cwiseMin(q);
  const Vec3 high = p.cwiseMax(q);
  if ((t[0].cwiseMax(t[1]).cwiseMax(t[2]).array() < low.array()).any() ||
      (t[0].cwiseMin(t[1]).cwiseMin(t[2]).array() > high.array()).any()) {
    return false;
  }
  const int side_p = orientation(t[0], t[1], t[2], p);
  const int side_q = orientation(t[0], t[1], t[2], q);
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && side_q == 0) return touch_in_plane(t, p, q);
  return none_opposed({orientation(p, q, t[0], t[1]), orientation(p, q, t[1], t[2]),
                       orientation(p, q, t[2], t[0])});
}

}  // namespace palpate::test
