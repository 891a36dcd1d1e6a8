#include "haptics/swing_watch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptics/nanoseconds.h"

namespace palpate {
void SwingWatch::add(const Vec3& force_N, double least_N, std::int64_t now_ns) noexcept {
  swing_rad_per_s_ = 0.0;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    Axis& axis = axes_[k];
    axis.add(force_N[static_cast<int>(k)], least_N, now_ns);
    if (axis.swings)
      swing_rad_per_s_ = std::max(swing_rad_per_s_,
                                  2.0 * std::numbers::pi / (axis.halves_s[0] + axis.halves_s[1]));
  }
}

void SwingWatch::Axis::add(double force_N, double least_N, std::int64_t now_ns) noexcept {
  if (direction >= 0) extreme_N = std::max(extreme_N, force_N);
  if (direction <= 0) extreme_N = std::min(extreme_N, force_N);
  if (direction == 0) {
    const double moved_N = force_N - last_extreme_N;
    if (moved_N > least_N) direction = 1;
    if (moved_N < -least_N) direction = -1;
    if (direction != 0) extreme_N = force_N;
    return;
  }
  if (direction * (extreme_N - force_N) > least_N) {
    reverse(now_ns);
    extreme_N = force_N;
    // A swing of the smallest size has died down.
    swings = is_swing() && sizes_N[0] > 2.0 * least_N;
  } else if (count > 0 && seconds(now_ns - reversed_ns) > kLongest_s) {
    count = 0;
    swings = false;
  }
}

void SwingWatch::Axis::reverse(std::int64_t now_ns) noexcept {
  std::copy_backward(sizes_N.begin(), sizes_N.end() - 1, sizes_N.end());
  std::copy_backward(halves_s.begin(), halves_s.end() - 1, halves_s.end());
  sizes_N[0] = std::abs(extreme_N - last_extreme_N);
  halves_s[0] = seconds(now_ns - reversed_ns);
  const bool is_in_time = halves_s[0] >= kShortest_s && halves_s[0] <= kLongest_s;
  count = is_in_time ? std::min(count + 1, kSteady) : 0;
  reversed_ns = now_ns;
  last_extreme_N = extreme_N;
  direction = -direction;
}

bool SwingWatch::Axis::is_swing() const noexcept {
  if (swings) return count >= 2;
  if (count >= kGrowing && is_regular(kGrowing)) {
    bool grows = true;
    for (std::size_t n = 0; n + 2 < kGrowing; ++n) grows = grows && sizes_N[n] > sizes_N[n + 2];
    if (grows) return true;
  }
  return count >= kSteady && is_regular(kSteady) &&
         sizes_N[0] > (1.0 - kLostShare) * sizes_N[kSteady - 1];
}

// The periods are compared, and not the half-swings: a tip that bounces is longer off the surface
// than on it.
bool SwingWatch::Axis::is_regular(std::size_t half_swings) const noexcept {
  double least_s = halves_s[0] + halves_s[1];
  double most_s = least_s;
  for (std::size_t n = 1; n + 1 < half_swings; ++n) {
    const double period_s = halves_s[n] + halves_s[n + 1];
    least_s = std::min(least_s, period_s);
    most_s = std::max(most_s, period_s);
  }
  return most_s < kSteadyTime * least_s;
}

}  // namespace palpate
