#pragma once

// How much of a curve had a moving point near it.

#include <cstddef>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/index/box_tree.h"

namespace palpate {

// Gathers, point by point, the parts of a curve that lie within near_m of a point that was added.
// One frame, metres. Allocates; not for the haptic thread.
class CurveCoverage {
 public:
  // curve_m: corners of an open curve, finite; a closed one ends where it begins. near_m > 0.
  CurveCoverage(std::vector<Vec3> curve_m, double near_m);

  // p: finite.
  void add(const Vec3& p);

  // Covered length over the length of the curve, 0 to 1; 0 for a curve without length.
  double share() const;

 private:
  // Of a segment of the curve, as distances from where it begins.
  struct Interval {
    double begin_m, end_m;
  };
  static void unite(Interval part, std::vector<Interval>& covered);
  void cover_near(std::size_t segment, const Vec3& p);
  double segment_length_m(std::size_t i) const { return (curve_m_[i + 1] - curve_m_[i]).norm(); }

  std::vector<Vec3> curve_m_;
  double near_m_;
  Vec3 middle_m_;  // origin of the tree's frame
  BoxTree segments_;
  std::vector<std::vector<Interval>> covered_;  // per segment: apart, in order
};

}  // namespace palpate
