#include "engine/session/path_times.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/devices/monotonic_clock.h"
#include "engine/scene/memory_budget.h"
#include "palpate/record.h"

namespace palpate {
namespace {

std::vector<std::int64_t> intervals_of(std::span<const std::int64_t> times_ns) {
  std::vector<std::int64_t> intervals_ns;
  intervals_ns.reserve(times_ns.size());
  for (std::size_t n = 1; n < times_ns.size(); ++n) {
    intervals_ns.push_back(times_ns[n] - times_ns[n - 1]);
  }
  return intervals_ns;
}

// 0 without intervals.
std::int64_t lower_median(std::vector<std::int64_t> intervals_ns) {
  if (intervals_ns.empty()) return 0;
  const auto middle =
      intervals_ns.begin() + static_cast<std::ptrdiff_t>((intervals_ns.size() - 1) / 2);
  std::nth_element(intervals_ns.begin(), middle, intervals_ns.end());
  return *middle;
}

// The largest error of the sum of `terms` time steps: each addition is rounded by half of the last
// digit. Never more than a quarter of a step, so that no two ticks share a position.
double sum_rounding_ns(double terms, double step_ns) {
  const double digit_ns = std::numeric_limits<double>::epsilon() * terms * step_ns;
  return std::min(0.25 * step_ns, 0.5 * terms * digit_ns);
}

}  // namespace

PathTimes path_times(std::span<const std::int64_t> times_ns) {
  PathTimes facts;
  facts.rows = times_ns.size();
  facts.duration_ns = times_ns.back() - times_ns.front();
  const std::vector<std::int64_t> intervals_ns = intervals_of(times_ns);
  facts.median_ns = lower_median(intervals_ns);
  const double gap_ns = kGapMedians * static_cast<double>(facts.median_ns);
  for (std::size_t n = 0; n < intervals_ns.size(); ++n) {
    if (static_cast<double>(intervals_ns[n]) < gap_ns) continue;
    if (facts.gaps++ == 0) facts.first_gap = n + 1;
    if (intervals_ns[n] <= facts.longest_gap_ns) continue;
    facts.longest_gap_ns = intervals_ns[n];
    facts.longest_gap = n + 1;
  }
  return facts;
}

std::vector<double> tick_lengths_s(std::span<const std::int64_t> times_ns, double single_s) {
  if (times_ns.size() == 1) return {single_s};
  const std::vector<std::int64_t> intervals_ns = intervals_of(times_ns);
  std::vector<double> lengths_s;
  lengths_s.reserve(times_ns.size());
  const auto add = [&](std::int64_t length_ns) {
    lengths_s.push_back(static_cast<double>(length_ns) / kSecond_ns);
  };
  add(lower_median(intervals_ns));
  for (const std::int64_t interval_ns : intervals_ns) add(interval_ns);
  return lengths_s;
}

Result<RatePath> path_at_rate(std::span<const Vec3> positions_m,
                              std::span<const std::int64_t> times_ns, double rate_Hz,
                              bool are_summed, std::uint64_t max_memory_bytes) {
  const double period_ns = kSecond_ns / rate_Hz;
  const auto last_ns = static_cast<double>(times_ns.back());
  const double last_same_ns =
      kSameTime_ns + (are_summed ? sum_rounding_ns(last_ns / period_ns, period_ns) : 0.0);
  const double ticks = std::floor((last_ns + last_same_ns) / period_ns) + 1.0;
  // More than is free cannot be given.
  MemoryLimit limit = memory_limit(max_memory_bytes);
  MemoryLimit free = default_memory_limit();
  if (max_memory_bytes > 0 && free.bytes > 0 && free.bytes < limit.bytes) {
    limit = std::move(free);
    limit.option.clear();  // to raise it would not help
  }
  MemoryLedger ledger(std::move(limit));
  ledger.begin("recording the ticks");
  ledger.advise("lower --rate, or shorten the path");
  const double bytes =
      ticks * static_cast<double>(sizeof(Vec3) + sizeof(TickRecord) + sizeof(std::int64_t));
  // More bytes than any machine has, within the range of an integer.
  constexpr double kMostBytes = 0x1p62;
  if (auto error = ledger.take(static_cast<std::uint64_t>(std::min(bytes, kMostBytes)))) {
    return *error;
  }
  return or_out_of_memory(ledger, [&]() -> Result<RatePath> {
    RatePath path;
    path.positions_m.reserve(static_cast<std::size_t>(ticks));
    std::size_t next = 0;  // the first position that is not before the tick
    for (double tick = 0.0; tick < ticks; ++tick) {
      const double at_ns = tick * period_ns;
      const double same_ns = kSameTime_ns + (are_summed ? sum_rounding_ns(tick, period_ns) : 0.0);
      while (next + 1 < times_ns.size() && static_cast<double>(times_ns[next]) < at_ns - same_ns) {
        ++next;
      }
      const auto next_ns = static_cast<double>(times_ns[next]);
      if (std::abs(next_ns - at_ns) <= same_ns) {
        path.positions_m.push_back(positions_m[next]);
        continue;
      }
      const auto before_ns = static_cast<double>(times_ns[next - 1]);
      const double share = (at_ns - before_ns) / (next_ns - before_ns);
      const Vec3& before_m = positions_m[next - 1];
      path.positions_m.emplace_back(before_m + share * (positions_m[next] - before_m));
      ++path.interpolated;
    }
    return path;
  });
}

}  // namespace palpate
