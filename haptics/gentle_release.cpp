#include "haptics/gentle_release.h"

#include <algorithm>
#include <limits>

namespace palpate {
namespace {

// The part of a way in the span of the motors has a direction if it is more than the rounding of
// the projection, which is at most seven roundings of numbers up to the way's length.
constexpr double kWayRounding = 8 * std::numeric_limits<double>::epsilon();

}  // namespace

GentleRelease::GentleRelease(double quantum_m, std::int64_t fall_ns) noexcept
    : quantum_m_(quantum_m), fall_ns_(fall_ns) {}

void GentleRelease::begin(const Vec3& force_N) noexcept {
  is_active_ = force_N.allFinite();
  has_moved_ = false;
  turns_ = 0;
  age_ns_ = 0;
  before_N_ = held_N_ = force_N;
  way_m_.setZero();
}

Vec3 GentleRelease::force(const Vec3& way_m, std::int64_t step_ns,
                          const MotorLimits& motors) noexcept {
  age_ns_ += step_ns;
  if (!way_m.allFinite() || age_ns_ >= fall_ns_) stop();
  // In the tick of the trip, the way was that of the force before it.
  if (step_ns > 0 && held_N_.dot(way_m) > 0.0 && ++turns_ >= GentleReleaseLimits::kMostTurns) {
    stop();
  }
  if (!is_active_) return Vec3::Zero();
  way_m_ += way_m;
  const Vec3 part_m = motors.part(way_m_);
  const double length_m = part_m.norm();
  if (length_m > quantum_m_ + kWayRounding * way_m_.norm()) {
    direction_ = part_m / length_m;
    has_moved_ = true;
    way_m_.setZero();
  }
  const double left = 1.0 - static_cast<double>(age_ns_) / static_cast<double>(fall_ns_);
  Vec3 resists_N = before_N_;
  if (has_moved_) resists_N = std::min(0.0, before_N_.dot(direction_)) * direction_;
  held_N_ = motors.part(left * resists_N);  // motors that have turned cannot push all of it
  return held_N_;
}

}  // namespace palpate
