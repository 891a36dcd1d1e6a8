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
  using BitCounts = std::array<std::uint64_t, 32>;

  // Of this many last ticks: 10 s at 1 kHz.
  static constexpr std::size_t kTicks = 10000;

  void add(std::span<const TickSummary> rows);

  // A time that this share of the ticks does not exceed; no value without a tick. O(kTicks).
  std::optional<double> late_us(double share) const { return percentile(late_us_, share); }
  std::optional<double> step_us(double share) const { return percentile(step_us_, share); }
  // The ticks with each fault bit, and with each rule of the governor, since the last call.
  BitCounts take_faults();
  BitCounts take_rules();

 private:
  static void count(std::uint32_t bits, BitCounts& counts);
  static std::optional<double> percentile(std::vector<float> times_us, double share);

  std::vector<float> late_us_, step_us_;  // rings
  std::size_t next_ = 0;
  BitCounts faults_{}, rules_{};
};

}  // namespace palpate
