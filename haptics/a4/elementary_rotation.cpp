#include "haptics/a4/elementary_rotation.h"

#include <algorithm>
#include <cmath>

namespace palpate {

double RotationProfile::speed_rad_per_s(double angle_rad) const {
  if (angle_rad >= knee_rad) return speed_at_knee_rad_per_s;
  return speed_at_zero_rad_per_s +
         (speed_at_knee_rad_per_s - speed_at_zero_rad_per_s) * (angle_rad / knee_rad);
}

namespace {

// k of the speed S = S0 + k a below the knee.
double slope_per_s(const RotationProfile& profile) {
  return (profile.speed_at_knee_rad_per_s - profile.speed_at_zero_rad_per_s) / profile.knee_rad;
}

// The angle turned in dt below the knee. The solution for the speed S = S0 + k a is
// a(dt) = (a + S0/k) e^(-k dt) - S0/k, so a - a(dt) = (a + S0/k) (1 - e^(-k dt)).
double turned_below_knee(const RotationProfile& profile, double angle_rad, double dt_s) {
  const double rate = slope_per_s(profile);
  if (rate == 0.0) return profile.speed_at_zero_rad_per_s * dt_s;
  if (rate < 0.0) {  // a + S0/k = S(a)/k would be a difference that can lose all digits
    const double speed =
        std::max(profile.speed_rad_per_s(angle_rad), profile.speed_at_knee_rad_per_s);
    return speed * (std::expm1(-rate * dt_s) / -rate);
  }
  return (angle_rad + profile.speed_at_zero_rad_per_s / rate) * -std::expm1(-rate * dt_s);
}

}  // namespace

double elementary_rotation_rad(const RotationProfile& profile, StepRule rule, double angle_rad,
                               double dt_s) noexcept {
  double turned = 0.0;
  if (rule == StepRule::kSpeedByDt) {
    turned = profile.speed_rad_per_s(angle_rad) * dt_s;
  } else {
    const double above_knee_rad = std::max(0.0, angle_rad - profile.knee_rad);
    const double to_knee_s = above_knee_rad / profile.speed_at_knee_rad_per_s;
    turned = dt_s <= to_knee_s
                 ? profile.speed_at_knee_rad_per_s * dt_s
                 : above_knee_rad +
                       turned_below_knee(profile, angle_rad - above_knee_rad, dt_s - to_knee_s);
  }
  return turned < angle_rad ? turned : angle_rad;  // NaN or infinite: the speed overflowed
}

// The solution of a' = -S0 - k a from a to 0 takes ln(1 + k a / S0) / k.
double alignment_time_s(const RotationProfile& profile, double angle_rad) noexcept {
  const double above_knee_rad = std::max(0.0, angle_rad - profile.knee_rad);
  const double below_knee_rad = angle_rad - above_knee_rad;
  const double rate = slope_per_s(profile);
  const double below_knee_s =
      rate == 0.0 ? below_knee_rad / profile.speed_at_zero_rad_per_s
                  : std::log1p(rate * below_knee_rad / profile.speed_at_zero_rad_per_s) / rate;
  return above_knee_rad / profile.speed_at_knee_rad_per_s + below_knee_s;
}

}  // namespace palpate
