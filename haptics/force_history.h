#pragma once

// The forces of the last ticks, and which of them act on the hand between two samples.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "geometry/base/types.h"

namespace palpate {

// A delay tau from a sample to its force, in periods T: tau = (whole + share) T, 0 <= share < 1.
struct DelayTicks {
  // A longer delay counts as this one: 120 ms at 1 kHz.
  static constexpr std::size_t kMostWhole = 120;

  std::size_t whole = 0;
  double share = 0.0;

  static DelayTicks of(double delay_s, double period_s) noexcept {
    const double periods = period_s > 0.0 ? delay_s / period_s : 0.0;
    // A delay of whole periods keeps them: the quotient rounds by half an epsilon.
    const double nearest = std::round(periods);
    const bool is_whole = std::abs(periods - nearest) <= kRounding * nearest;
    const double whole = is_whole ? nearest : std::floor(periods);
    if (!(whole < static_cast<double>(kMostWhole))) return {kMostWhole, 0.0};
    return {static_cast<std::size_t>(whole), is_whole ? 0.0 : periods - whole};
  }

 private:
  // Delay, period and quotient round by half an epsilon each, and the caller's conversions of
  // decimal digits twice more.
  static constexpr double kRounding = 4 * 2.220446049250313e-16;
};

// Keeps the forces of the last ticks; before the first one, they are zero.
//
// The force of a tick begins to act tau after its sample, and is held until that of the next tick
// acts. So between the samples k and k + 1, the force of tick k - whole - 1 acts for share T, and
// then the force of tick k - whole. The position between two samples is taken from the straight
// line through them: the work is exact where the delay is a whole number of ticks, or where the
// device moves steadily.
//
// One thread owns an object. No function allocates or throws.
class ForceHistory {
 public:
  ForceHistory() noexcept { forces_N_.fill(Vec3::Zero()); }

  // Adds the force of a tick.
  void push(const Vec3& force_N) noexcept {
    newest_ = (newest_ + 1) % kCapacity;
    forces_N_[newest_] = force_N;
  }
  // The force of the tick this number of ticks before the newest one, at most kMostWhole + 1.
  const Vec3& back(std::size_t ticks) const noexcept {
    return forces_N_[(newest_ + kCapacity - ticks) % kCapacity];
  }
  // The mean force between the sample of the newest tick and the next sample.
  Vec3 acting_N(const DelayTicks& delay) const noexcept {
    if (delay.share == 0.0) return back(delay.whole);
    return delay.share * back(delay.whole + 1) + (1.0 - delay.share) * back(delay.whole);
  }

 private:
  static constexpr std::size_t kCapacity = 128;
  static_assert(DelayTicks::kMostWhole + 1 < kCapacity);

  std::array<Vec3, kCapacity> forces_N_;
  std::size_t newest_ = 0;
};

}  // namespace palpate
