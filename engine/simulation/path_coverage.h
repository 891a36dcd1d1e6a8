#pragma once

// The share of a curve that a moving point has come near to.

#include <cstddef>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/index/box_tree.h"

namespace palpate {

// Collects the parts of a curve that lie within near_m of any point added. One frame, metres.
// Allocates; not for the haptic thread.
class CurveCoverage {
 public:
  // curve_m: vertices of the curve, finite; a closed curve repeats its first vertex at the end.
  // near_m > 0.
  CurveCoverage(std::vector<Vec3> curve_m, double near_m);

  // p: finite.
  void add(const Vec3& p);

  // Covered length divided by the length of the curve, 0 to 1; 0 for a curve of length 0.
  double share() const;

 private:
  // A part of a segment, as distances from the beginning of the segment.
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
  std::vector<std::vector<Interval>> covered_;  // per segment: disjoint, ascending
};

}  // namespace palpate
