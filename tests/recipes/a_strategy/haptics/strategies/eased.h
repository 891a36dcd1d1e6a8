#pragma once

// The strategy `eased`: a part of the force of `mask`, for hands that tire.
//
// f = s P F: P is the projection on the actuated span, F the force of the contact and the effects,
// and s is HapticSettings::eased_share. Nothing else is promised.

#include "haptics/strategies/strategy_step.h"

namespace palpate {

class EasedStep final : public StrategyStep {
 public:
  std::optional<StrategyForce> force(const Vec3& force_N,
                                     const StrategyTick& tick) noexcept override {
    const Vec3 full_N = tick.R_device_scene * force_N;
    return StrategyForce{full_N, tick.settings.eased_share * tick.actuation.actuated_part(full_N)};
  }
};

inline std::unique_ptr<StrategyStep> make_eased_step(const ActuationModel&, const HapticSettings&) {
  return std::make_unique<EasedStep>();
}

inline constexpr StrategyType kEasedStrategy{.name = "eased", .make_step = make_eased_step};

}  // namespace palpate
