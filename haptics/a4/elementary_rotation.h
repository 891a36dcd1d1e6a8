#pragma once

// Action 6 of A4: the elementary rotation, which is the angle turned in one tick.

#include <cstdint>
#include <numbers>

namespace palpate {

// Figure 3 (Lecuyer et al. 2005): angular speed S as a function of the remaining angle. S is linear
// from speed_at_zero to speed_at_knee, and constant above the knee. All three numbers must be
// positive.
struct RotationProfile {
  double speed_at_zero_rad_per_s = 5.0 * std::numbers::pi / 180.0;
  double speed_at_knee_rad_per_s = 90.0 * std::numbers::pi / 180.0;
  double knee_rad = 30.0 * std::numbers::pi / 180.0;

  double speed_rad_per_s(double angle_rad) const;
};

// The rule by which the profile is integrated over a tick.
enum class StepRule : std::uint8_t {
  // The solution of a' = -S(a), split where a crosses the knee. It gives the same motion at any
  // servo rate.
  kExact,
  kSpeedByDt  // S(a) dt, the paper's rule; 1.2 ms ahead of the profile at 1 kHz
};

// The angle to turn in dt_s seconds if angle_rad >= 0 remains; at most angle_rad. Thread-safe; no
// allocation, so that the haptic thread may call it.
double elementary_rotation_rad(const RotationProfile& profile, StepRule rule, double angle_rad,
                               double dt_s) noexcept;

// The time in which the profile turns by angle_rad >= 0 to 0, by StepRule::kExact. Thread-safe; no
// allocation.
double alignment_time_s(const RotationProfile& profile, double angle_rad) noexcept;

}  // namespace palpate
