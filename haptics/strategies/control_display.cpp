#include "haptics/strategies/control_display.h"

#include <algorithm>

namespace palpate {

void ControlDisplay::update(const HandStep& step) noexcept {
  if (!step.was_in_contact) {
    const double drift_m = drift_m_.norm();
    const double back_m = kReturnPerStep * step.step_m.norm();
    drift_m_ = back_m >= drift_m ? Vec3(Vec3::Zero()) : Vec3((1.0 - back_m / drift_m) * drift_m_);
    return;
  }
  if (!(step.step_m.dot(step.lag_m) < 0.0)) return;
  const double c = std::max(kLeastRatio, 1.0 / (1.0 + step.missing_N.norm() / kHalvingForce_N));
  const Vec3 drift_m = drift_m_ + (1.0 - c) * step.step_m;
  if (drift_m.norm() <= kMostDrift_m) drift_m_ = drift_m;  // false for NaN
}

}  // namespace palpate
