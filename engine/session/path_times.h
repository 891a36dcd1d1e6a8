#pragma once

// The times of a recorded path: the length of each tick, gaps, and positions at another rate.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

// Facts about the intervals between the positions of a path.
struct PathTimes {
  std::size_t rows = 0;
  std::int64_t duration_ns = 0;
  std::int64_t median_ns = 0;  // of the intervals, the lower one of two; 0: one position
  // Gaps: intervals of at least kGapMedians times the median. first and longest are numbers of the
  // position after the gap; of equal gaps, the first counts.
  std::size_t gaps = 0;
  std::size_t first_gap = 0;
  std::size_t longest_gap = 0;
  std::int64_t longest_gap_ns = 0;

  // 0: one position.
  double median_rate_Hz() const {
    return median_ns > 0 ? 1e9 / static_cast<double>(median_ns) : 0.0;
  }
};

// From this length on, the nearest whole number of medians in an interval is 2 or more: at least
// one position is missing.
inline constexpr double kGapMedians = 1.5;

// Servo loops of haptic devices run at about 1 kHz. Below the lower rate, the steps of a held force
// are a vibration that the skin feels best, and no wall is stiff; above the upper rate, no device
// is sampled. Times in a wrong unit are usually off by a factor of 1000 and beyond one of them.
inline constexpr double kLowestUsualRate_Hz = 100.0;
inline constexpr double kHighestUsualRate_Hz = 10000.0;

// times_ns: of each position since the first one; strictly increasing, not empty.
PathTimes path_times(std::span<const std::int64_t> times_ns);

// The length of each tick, in seconds: the time since the position before. The first position has
// none before it; its tick has the median length. Of one position: single_s. A whole number of
// nanoseconds gives the double that is nearest to it: 1,000,000 ns give 0.001.
std::vector<double> tick_lengths_s(std::span<const std::int64_t> times_ns, double single_s);

struct RatePath {
  std::vector<Vec3> positions_m;
  std::size_t interpolated = 0;  // positions that are not those of the path
};

// The positions of a path every 1 / rate_Hz seconds, from the first one on, up to the last one.
// They are interpolated linearly in time. At a position's time, within kSameTime_ns, it is that
// position, to the bit. Between a position that is not finite and its neighbours, no position is
// finite. are_summed: each time is a sum of time steps in doubles, as in a trace; "at a position's
// time" then includes the rounding of the sum. Returns an error if there is not enough memory for a
// run of that many ticks. The limit is half of the free
// memory, or max_memory_bytes if that is less and not 0.
Result<RatePath> path_at_rate(std::span<const Vec3> positions_m,
                              std::span<const std::int64_t> times_ns, double rate_Hz,
                              bool are_summed = false, std::uint64_t max_memory_bytes = 0);

// Two times are the same if they differ by the rounding to whole nanoseconds of both.
inline constexpr double kSameTime_ns = 1.0;

}  // namespace palpate
