#include "haptics/strategies/control_display.h"

#include <algorithm>

#include "haptics/strategies/strategy_step.h"

namespace palpate {
namespace {

// The scene follows a part of the hand's step before the hand's motion counts.
class ControlDisplayStep final : public StrategyStep {
 public:
  explicit ControlDisplayStep(const Vec3& home_m) : home_m_(home_m) {}

  std::optional<Vec3> scene_origin_m(const StrategyTick& tick) noexcept override {
    const TickRecord& record = tick.record;
    const Vec3 device_m(record.device_m);
    const Vec3 step_m = device_m - last_device_m_;
    last_device_m_ = device_m;
    if (!tick.follows_good_tick) return std::nullopt;
    const Vec3 lag_scene_m = Vec3(record.proxy_scene_m) - Vec3(record.goal_scene_m);
    ratio_.update({step_m, record.contact != 0, tick.R_device_scene * lag_scene_m,
                   Vec3(record.full_force_device_N) - Vec3(record.force_device_N)});
    return home_m_ + ratio_.drift_m();
  }

 private:
  ControlDisplay ratio_;
  Vec3 home_m_;                        // the scene's origin at the start, device frame
  Vec3 last_device_m_ = Vec3::Zero();  // of the last good sample
};

}  // namespace

std::unique_ptr<StrategyStep> make_control_display_step(const ActuationModel&,
                                                        const HapticSettings& settings) {
  return std::make_unique<ControlDisplayStep>(settings.initial_pose.translation_m);
}

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
