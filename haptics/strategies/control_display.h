#pragma once

// The strategy `cd`: pseudo-haptics by the ratio of control to display.
//
// Changing that ratio to suggest a force is due to Lecuyer et al. (IEEE VR 2000). The ratio below
// and its limits are ours: it follows the force that the missing motors leave out.

#include "geometry/base/types.h"
#include "haptics/strategies/strategy.h"

namespace palpate {

// Two successive ticks. Device frame. Both samples are good.
struct HandStep {
  Vec3 step_m = Vec3::Zero();     // dx, of the device
  bool was_in_contact = false;    // in the last tick
  Vec3 lag_m = Vec3::Zero();      // p - x of the last tick
  Vec3 missing_N = Vec3::Zero();  // F* - f of the last tick: the full force less the wanted one
};

// In contact, a device step dx moves the goal by c dx, because the scene moves by (1 - c) dx:
//
//     c = max(kLeastRatio, 1 / (1 + |F* - f| / kHalvingForce_N))
//
// c = 1 where dx.(p - x) >= 0, since the depth does not grow there, in free motion, and where the
// scene's drift would exceed kMostDrift_m. In free motion, the drift returns by at most
// kReturnPerStep |dx| in a tick. The force is that of `mask`.
//
// Safe on the haptic thread: no allocation, lock or exception. One thread owns an object.
class ControlDisplay {
 public:
  static constexpr double kHalvingForce_N = 5.0;  // F0
  static constexpr double kLeastRatio = 0.3;
  static constexpr double kMostDrift_m = 0.030;
  static constexpr double kReturnPerStep = 0.1;

  // Updates the drift, which is the displacement of the scene from its place at the start, device
  // frame, m.
  void update(const HandStep& step) noexcept;
  const Vec3& drift_m() const { return drift_m_; }

 private:
  Vec3 drift_m_ = Vec3::Zero();
};

std::unique_ptr<StrategyStep> make_control_display_step(const ActuationModel& actuation,
                                                        const HapticSettings& settings);

inline constexpr StrategyType kControlDisplayStrategy{.name = "cd",
                                                      .make_step = make_control_display_step};

}  // namespace palpate
