#pragma once

// Action 6 of A4: how far to turn in one tick.

#include <cstdint>
#include <numbers>

namespace palpate {

// Figure 3 (Lecuyer et al. 2005): angular speed as a function of the angle still to go. Linear from
// speed_at_zero to speed_at_knee, constant above the knee. All three must be positive.
struct RotationProfile {
  double speed_at_zero_rad_per_s = 5.0 * std::numbers::pi / 180.0;
  double speed_at_knee_rad_per_s = 90.0 * std::numbers::pi / 180.0;
  double knee_rad = 30.0 * std::numbers::pi / 180.0;

  double speed_rad_per_s(double angle_rad) const;
};

// How the profile is integrated over a tick.
enum class StepRule : std::uint8_t {
  kExact,     // the solution of a' = -S(a), split where it crosses the knee: any rate, same motion
  kSpeedByDt  // S(a) dt, the paper's; ahead of the profile by 1.2 ms at 1 kHz
};

// The angle to turn in dt_s when angle_rad >= 0 is left; never more than that. Safe on the haptic
// thread.
double elementary_rotation_rad(const RotationProfile& profile, StepRule rule, double angle_rad,
                               double dt_s) noexcept;

}  // namespace palpate
