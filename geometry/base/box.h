#pragma once

#include <limits>

#include "geometry/base/types.h"

namespace palpate {

// An axis-aligned box in metres. The owner of the box defines the frame.
struct Box {
  Vec3 low, high;

  // The box of no points: the union of empty() and a box is that box.
  static Box empty() {
    const double infinity = std::numeric_limits<double>::infinity();
    return {Vec3::Constant(infinity), Vec3::Constant(-infinity)};
  }
  double squared_distance(const Vec3& p) const {
    return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
  }
  bool contains(const Vec3& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
  Box grown(double margin) const {
    return {(low.array() - margin).matrix(), (high.array() + margin).matrix()};
  }
  Box united(const Box& other) const {
    return {low.cwiseMin(other.low), high.cwiseMax(other.high)};
  }
  // Narrows [enter, leave] to the part of the segment p + [enter, leave] d that lies inside the
  // box. Returns false if no part does.
  bool clip(const Vec3& p, const Vec3& d, double& enter, double& leave) const;
};

}  // namespace palpate
