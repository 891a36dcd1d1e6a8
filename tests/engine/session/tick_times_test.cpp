// Histograms of times, and the causes of late ticks.

#include "engine/session/tick_times.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

TEST(TimeHistogram, CountsEachTimeInTheBucketWhoseBoundItDoesNotExceed) {
  TimeHistogram times;
  EXPECT_EQ(times.percentile_ns(0.5), 0);
  EXPECT_EQ(TimeHistogram::bound_ns(0), 1000);
  EXPECT_EQ(TimeHistogram::bound_ns(4), 20'000);
  EXPECT_EQ(TimeHistogram::bound_ns(TimeHistogram::kBuckets - 2), 1'000'000'000);
  for (const std::int64_t ns : {0, 1000, 1001, 2000, 1'000'000'001}) times.add(ns);
  EXPECT_EQ(times.count(), 5u);
  EXPECT_EQ(times.in_bucket(0), 2u);
  EXPECT_EQ(times.in_bucket(1), 2u);
  EXPECT_EQ(times.in_bucket(TimeHistogram::kBuckets - 1), 1u);
  EXPECT_EQ(times.largest_ns(), 1'000'000'001);
}

TEST(TimeHistogram, APercentileIsAtLeastTheExactOneAndInItsBucket) {
  test::Random random(3);
  std::vector<std::int64_t> all;
  TimeHistogram times;
  for (int n = 0; n < 10'000; ++n) {
    all.push_back(std::llround(std::pow(10.0, random.uniform(2.0, 9.5))));
    times.add(all.back());
  }
  std::sort(all.begin(), all.end());
  for (const double share : {0.001, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * 10'000)) - 1;
    const std::int64_t percentile_ns = times.percentile_ns(share);
    EXPECT_GE(percentile_ns, all[rank]);
    EXPECT_LE(static_cast<double>(percentile_ns),
              2.5 * static_cast<double>(std::max<std::int64_t>(400, all[rank])));
  }
  EXPECT_EQ(times.percentile_ns(1.0), all.back());
}

TEST(LateCause, IsThePartThatTookTheLongest) {
  constexpr std::int64_t kMs = 1'000'000;
  struct Case {
    TickCost cost;
    LateCause cause;
  };
  //             late, wall, loop, cpu, faults, preemptions
  for (const Case& c : {
           Case{{5 * kMs, 1000, 900, 900, 0, 0}, LateCause::kWokenLate},
           Case{{5 * kMs, 4 * kMs, 4 * kMs, 1000, 0, 1}, LateCause::kWokenLate},
           Case{{1000, 5 * kMs, 5 * kMs, 1000, 0, 1}, LateCause::kPreempted},
           Case{{1000, 5 * kMs, 5 * kMs, 1000, 3, 1}, LateCause::kPreempted},
           Case{{1000, 5 * kMs, 5 * kMs, 1000, 0, 0}, LateCause::kPreempted},  // by the host
           Case{{1000, 5 * kMs, 5 * kMs, 1000, 3, 0}, LateCause::kPageFault},
           Case{{1000, 5 * kMs, 1000, 1500, 0, 0}, LateCause::kDevice},     // it waited
           Case{{1000, 5 * kMs, 1000, 5 * kMs, 0, 0}, LateCause::kDevice},  // it computed
           Case{{1000, 5 * kMs, 5 * kMs, 5 * kMs, 0, 0}, LateCause::kOurs},
           Case{{1000, 5 * kMs, 5 * kMs, 3 * kMs, 9, 9}, LateCause::kOurs},
       }) {
    EXPECT_EQ(cause_of(c.cost), c.cause) << c.cost.late_ns << " " << c.cost.wall_ns;
  }
}

TEST(ThreadUsage, CountsTheComputingOfThisThread) {
  const ThreadUsage::Reading before = ThreadUsage::now();
  volatile double sum = 0.0;
  while (ThreadUsage::cpu_ns() < before.cpu_ns + 1'000'000) sum = sum + 1.0;
  const ThreadUsage::Reading after = ThreadUsage::now();
  EXPECT_GE(after.cpu_ns, before.cpu_ns + 1'000'000);
  EXPECT_GE(after.faults, before.faults);
  EXPECT_GE(after.preemptions, before.preemptions);
}

}  // namespace
}  // namespace palpate
