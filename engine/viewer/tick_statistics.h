#pragma once

// Statistics of the ticks of the last seconds, for the status that a page shows.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/viewer/tick_summary.h"

namespace palpate {

// Not thread-safe.
class TickStatistics {
 public:
  // Of this many last ticks: 10 s at 1 kHz.
  static constexpr std::size_t kTicks = 10000;

  void add(std::span<const TickSummary> rows);

  // A time that this share of the ticks does not exceed; no value without a tick. O(kTicks).
  std::optional<double> late_us(double share) const { return percentile(late_us_, share); }
  std::optional<double> step_us(double share) const { return percentile(step_us_, share); }
  // The ticks with each fault bit since the last call.
  std::array<std::uint64_t, 32> take_faults();

 private:
  static std::optional<double> percentile(std::vector<float> times_us, double share);

  std::vector<float> late_us_, step_us_;  // rings
  std::size_t next_ = 0;
  std::array<std::uint64_t, 32> faults_{};
};

}  // namespace palpate
