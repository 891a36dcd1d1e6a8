#include "engine/viewer/tick_statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {

void TickStatistics::add(std::span<const TickSummary> rows) {
  for (const TickSummary& row : rows) {
    if (late_us_.size() < kTicks) {
      late_us_.push_back(row.late_us);
      step_us_.push_back(row.step_us);
    } else {
      late_us_[next_] = row.late_us;
      step_us_[next_] = row.step_us;
      next_ = (next_ + 1) % kTicks;
    }
    count(row.faults, faults_);
    count(row.rules, rules_);
  }
}

void TickStatistics::count(std::uint32_t bits, BitCounts& counts) {
  for (std::size_t bit = 0; bits != 0; ++bit, bits >>= 1) counts[bit] += bits & 1u;
}

std::optional<double> TickStatistics::percentile(std::vector<float> times_us, double share) {
  if (times_us.empty()) return std::nullopt;
  const double rank = std::ceil(share * static_cast<double>(times_us.size()));
  const std::size_t index =
      std::min(times_us.size() - 1, static_cast<std::size_t>(std::max(0.0, rank - 1.0)));
  const auto at = times_us.begin() + static_cast<std::ptrdiff_t>(index);
  std::nth_element(times_us.begin(), at, times_us.end());
  return static_cast<double>(*at);
}

TickStatistics::BitCounts TickStatistics::take_faults() {
  return std::exchange(faults_, {});
}

TickStatistics::BitCounts TickStatistics::take_rules() {
  return std::exchange(rules_, {});
}

}  // namespace palpate
