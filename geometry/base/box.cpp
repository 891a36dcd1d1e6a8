#include "geometry/base/box.h"

#include <algorithm>

namespace palpate {

bool Box::clip(const Vec3& p, const Vec3& d, double& enter, double& leave) const {
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0.0) {
      if (p[k] < low[k] || p[k] > high[k]) return false;
      continue;
    }
    const double at_low = (low[k] - p[k]) / d[k];
    const double at_high = (high[k] - p[k]) / d[k];
    enter = std::max(enter, std::min(at_low, at_high));
    leave = std::min(leave, std::max(at_low, at_high));
  }
  return enter <= leave;
}

}  // namespace palpate
