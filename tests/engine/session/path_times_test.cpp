// The times of a path: lengths of ticks, gaps, and positions at another rate.

#include "engine/session/path_times.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using Times = std::vector<std::int64_t>;

TEST(PathTimes, GiveEachTickItsLength) {
  EXPECT_EQ(tick_lengths_s(Times{0, 1'000'000, 3'000'000, 3'000'001}, 0.5),
            (std::vector<double>{0.001, 0.001, 0.002, 1e-9}));
  EXPECT_EQ(tick_lengths_s(Times{0}, 0.25), std::vector<double>{0.25});
}

TEST(PathTimes, FindGaps) {
  const PathTimes even = path_times(Times{0, 10, 20, 34, 44});
  EXPECT_EQ(even.gaps, 0u);
  EXPECT_EQ(even.median_ns, 10);
  const PathTimes gaps = path_times(Times{0, 10, 25, 35, 95, 105, 165, 170});
  EXPECT_EQ(gaps.gaps, 3u);
  EXPECT_EQ(gaps.first_gap, 2u);
  EXPECT_EQ(gaps.longest_gap, 4u);
  EXPECT_EQ(gaps.longest_gap_ns, 60);
  EXPECT_EQ(gaps.duration_ns, 170);
  EXPECT_EQ(path_times(Times{0}).median_ns, 0);
}

// A straight path at constant speed is its own interpolation.
TEST(PathTimes, InterpolateBetweenPositions) {
  test::Random random(46201);
  for (int pass = 0; pass < 20; ++pass) {
    const Vec3 speed(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double rate_Hz = random.uniform(50.0, 20000.0);
    Times times_ns{0};
    std::vector<Vec3> positions_m;
    for (int n = 0; n < 50; ++n) {
      times_ns.push_back(times_ns.back() + 10 + static_cast<int>(random.index(3'000'000)));
    }
    for (const std::int64_t t : times_ns) positions_m.emplace_back(speed * (1e-9 * double(t)));
    const auto path = path_at_rate(positions_m, times_ns, rate_Hz);
    ASSERT_TRUE(path);
    const double duration_s = 1e-9 * static_cast<double>(times_ns.back());
    EXPECT_EQ(path->positions_m.size(),
              static_cast<std::size_t>(std::floor((duration_s + 1e-9) * rate_Hz)) + 1);
    for (std::size_t n = 0; n < path->positions_m.size(); ++n) {
      const Vec3 expected = speed * (static_cast<double>(n) / rate_Hz);
      ASSERT_LE((path->positions_m[n] - expected).norm(), 2e-9);
    }
  }
}

TEST(PathTimes, KeepPositionsAtTheirTimes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  // 3 kHz in whole nanoseconds.
  const std::vector<Vec3> positions_m{Vec3(0.1, 0.2, 0.3), Vec3(0.7, 0.1, 0.9), Vec3(nan, 0, 0),
                                      Vec3(0.3, 0.3, 0.1)};
  const auto same = path_at_rate(positions_m, Times{0, 333'333, 666'667, 1'000'000}, 3000.0);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->interpolated, 0u);
  ASSERT_EQ(same->positions_m.size(), 4u);
  EXPECT_EQ(same->positions_m[1], positions_m[1]);
  EXPECT_EQ(same->positions_m[3], positions_m[3]);
  const auto twice = path_at_rate(positions_m, Times{0, 333'333, 666'667, 1'000'000}, 6000.0);
  ASSERT_TRUE(twice);
  EXPECT_EQ(twice->interpolated, 3u);
  EXPECT_TRUE(twice->positions_m[1].allFinite());
  EXPECT_FALSE(twice->positions_m[3].allFinite());
  EXPECT_FALSE(twice->positions_m[5].allFinite());
}

}  // namespace
}  // namespace palpate
