// Histograms of times, and the causes of late ticks.

#include "engine/session/tick_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "engine/session/reached_timing.h"
#include "haptics/device_mechanics.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

TEST(TimeHistogram, CountsEachTimeInTheFirstBucketWhoseBoundItDoesNotExceed) {
  EXPECT_EQ(TimeHistogram().percentile_ns(0.5), 0);
  test::Random random(4);
  std::vector<std::int64_t> times_ns;
  for (std::int64_t ns = 0; ns < 5000; ++ns) times_ns.push_back(ns);
  for (int bit = 12; bit < 40; ++bit) {
    for (const std::int64_t off : {-1, 0, 1}) times_ns.push_back((std::int64_t{1} << bit) + off);
    times_ns.push_back(std::llround(std::pow(2.0, random.uniform(bit, bit + 1))));
  }
  for (const std::int64_t ns : times_ns) {
    std::size_t first = 0;
    while (TimeHistogram::bound_ns(first) < ns) ++first;
    TimeHistogram times;
    times.add(ns);
    EXPECT_EQ(times.in_bucket(first), 1u) << ns;
    EXPECT_EQ(times.count(), 1u);
    EXPECT_EQ(times.largest_ns(), ns);
  }
}

TEST(TimeHistogram, BoundsGrowByAtMostOneIn32) {
  constexpr std::int64_t kLast_ns = std::int64_t{1} << 34;
  for (std::size_t i = 1; i + 1 < TimeHistogram::kBuckets; ++i) {
    const std::int64_t below_ns = TimeHistogram::bound_ns(i - 1);
    const std::int64_t bound_ns = TimeHistogram::bound_ns(i);
    EXPECT_GT(bound_ns, below_ns);
    EXPECT_LE(bound_ns - below_ns, std::max<std::int64_t>(1, (below_ns + 1) / 32));
  }
  EXPECT_EQ(TimeHistogram::bound_ns(TimeHistogram::kBuckets - 2), kLast_ns - 1);
  EXPECT_EQ(TimeHistogram::bound_ns(TimeHistogram::kBuckets - 1),
            std::numeric_limits<std::int64_t>::max());
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
    EXPECT_LE(percentile_ns, all[rank] + all[rank] / 32);
  }
  EXPECT_EQ(times.percentile_ns(1.0), all.back());
}

TEST(LateCause, IsThePartThatTookTheLongest) {
  constexpr std::int64_t kMs = 1'000'000;
  struct Case {
    TickCost cost;
    LateCause cause;
  };
  //             late, wall, loop, delay, cpu, faults, preemptions
  for (const Case& c : {
           Case{{5 * kMs, 1000, 900, 950, 900, 0, 0}, LateCause::kWokenLate},
           Case{{5 * kMs, 4 * kMs, 4 * kMs, 4 * kMs, 1000, 0, 1}, LateCause::kWokenLate},
           Case{{1000, 5 * kMs, 5 * kMs, 5 * kMs, 1000, 0, 1}, LateCause::kPreempted},
           Case{{1000, 5 * kMs, 5 * kMs, 5 * kMs, 1000, 3, 1}, LateCause::kPreempted},
           Case{{1000, 5 * kMs, 5 * kMs, 5 * kMs, 1000, 0, 0},
                LateCause::kPreempted},  // by the host
           Case{{1000, 5 * kMs, 5 * kMs, 5 * kMs, 1000, 3, 0}, LateCause::kPageFault},
           Case{{1000, 5 * kMs, 1000, 1000, 1500, 0, 0}, LateCause::kDevice},     // it waited
           Case{{1000, 5 * kMs, 1000, 1000, 5 * kMs, 0, 0}, LateCause::kDevice},  // it computed
           Case{{1000, 5 * kMs, 5 * kMs, 5 * kMs, 5 * kMs, 0, 0}, LateCause::kOurs},
           Case{{1000, 5 * kMs, 5 * kMs, 5 * kMs, 3 * kMs, 9, 9}, LateCause::kOurs},
       }) {
    EXPECT_EQ(cause_of(c.cost), c.cause) << c.cost.late_ns << " " << c.cost.wall_ns;
  }
}

TEST(LateTickLog, KeepsTheFirstOnes) {
  LateTickLog log;
  for (std::uint64_t n = 0; n < LateTickLog::kMost + 5; ++n) log.add({n, {}});
  ASSERT_EQ(log.ticks().size(), LateTickLog::kMost);
  EXPECT_EQ(log.ticks().back().tick, LateTickLog::kMost - 1);
}

// The oracle is the closed form of the limits: to first order, T / 2 + D; exactly, with h = 1 / 2 +
// D / T and the part p of D / T, (h + sqrt(h^2 + p (1 - p))) T / 2.
TEST(ReachedTiming, TheDelayLowersTheLimits) {
  RunSettings settings;
  settings.device.damping_Ns_per_m = 2.0;
  settings.device.encoder_quantum_m = 0.0;
  const auto setup = make_setup(settings);
  ASSERT_TRUE(setup) << setup.error().to_string();
  TickTimes times;
  for (int n = 0; n < 2000; ++n) {
    times.period.add(n == 0 ? 50'000'000 : 1'000'000);  // one in 2000 does not count
    times.delay.add(n == 0 ? 50'000'000 : 200'000);
  }
  const auto timing = reached_timing(*setup, times);
  ASSERT_TRUE(timing) << timing.error().to_string();
  EXPECT_NEAR(static_cast<double>(timing->period_ns), 1e6, 1e6 / 32);
  EXPECT_NEAR(static_cast<double>(timing->delay_ns), 2e5, 2e5 / 32);
  EXPECT_EQ(timing->to_force_s, 1e-9 * static_cast<double>(timing->delay_ns));
  const double period_s = 1e-9 * static_cast<double>(timing->period_ns);
  const double part = timing->to_force_s / period_s;  // below one tick
  const double mean = 0.5 + part;
  const double held_s = 0.5 * (mean + std::sqrt(mean * mean + part * (1.0 - part))) * period_s;
  const double damping = settings.device.damping_Ns_per_m;
  EXPECT_NEAR(timing->limits.passive_N_per_m * held_s / damping, 1.0, 1e-12);
  EXPECT_NEAR(timing->limits.stable_first_order_N_per_m * mean * period_s / damping, 1.0, 1e-12);
}

// A device's own delay includes that of the host, so the longer one counts. A device that moves
// motors and states no numbers has those of its class.
TEST(ReachedTiming, TheLongerOfTheDevicesDelayAndThatOfTheTicksCounts) {
  auto setup = make_setup(RunSettings{});
  ASSERT_TRUE(setup) << setup.error().to_string();
  TickTimes times;
  for (int n = 0; n < 100; ++n) {
    times.period.add(1'000'000);
    times.delay.add(200'000);
  }
  const auto of = [&](DelayInterval delay) {
    setup->device.delay = delay;
    return reached_timing(*setup, times)->to_force_s;
  };
  EXPECT_NEAR(of({}), 2e-4, 2e-4 / 32);
  EXPECT_NEAR(of({0.0, 1e-4}), 2e-4, 2e-4 / 32);
  EXPECT_EQ(of({1e-3, 3e-3}), 3e-3);
  setup->device.moves_motors = true;
  setup->device.mass_kg = setup->device.damping_Ns_per_m = 0.0;
  EXPECT_EQ(of({}), kBareTip.delay.most_s);
  EXPECT_GT(reached_timing(*setup, times)->limits.stable_N_per_m, 0.0);
}

TEST(TickMeter, MeasuresTheComputingOfThisThread) {
  constexpr std::int64_t kComputing_ns = 1'000'000;
  std::array<std::uint32_t, 2> cpu_ns{};  // room for fewer ticks
  TickMeter meter;
  meter.start(cpu_ns);
  std::vector<std::int64_t> starts_ns;
  for (int n = 0; n < 3; ++n) {
    starts_ns.push_back(meter.begin(starts_ns.empty() ? 0 : starts_ns.back()));
    const std::int64_t before_ns = ThreadUsage::cpu_ns();
    volatile double sum = 0.0;
    while (ThreadUsage::cpu_ns() < before_ns + kComputing_ns) sum = sum + 1.0;
    // The tick of n = 1 ends after the next one is due.
    const std::int64_t next_due_ns = n == 1 ? starts_ns.back() : starts_ns.back() + (1LL << 60);
    EXPECT_EQ(meter.end(400, 500, next_due_ns), n == 1);
  }
  meter.finish();
  const TickTimes& times = meter.times();
  EXPECT_EQ(times.cpu.count(), 3u);
  EXPECT_GE(times.cpu.largest_ns(), kComputing_ns);
  EXPECT_GE(times.wall.largest_ns(), kComputing_ns);
  for (const std::uint32_t ns : cpu_ns) EXPECT_GE(ns, kComputing_ns);
  EXPECT_EQ(times.step.largest_ns(), 400);
  EXPECT_EQ(times.delay.largest_ns(), 500);
  ASSERT_EQ(times.period.count(), 2u);
  EXPECT_EQ(times.period.largest_ns(),
            std::max(starts_ns[1] - starts_ns[0], starts_ns[2] - starts_ns[1]));
  EXPECT_EQ(times.all_late_ticks(), 1u);
  ASSERT_EQ(times.late_log.ticks().size(), 1u);
  EXPECT_EQ(times.late_log.ticks().front().tick, 1u);
  EXPECT_EQ(times.late_log.ticks().front().cost.late_ns, starts_ns[1] - starts_ns[0]);
}

// Touches new pages in a tick. A tick that waits for them is asked for its faults, and none is
// lost.
TEST(TickMeter, CountsPageFaults) {
  constexpr std::size_t kPages = 256;
  constexpr std::size_t kPage_bytes = 4096;
  TickMeter meter;
  meter.start();
  meter.begin(0);
  const std::unique_ptr<volatile char[]> pages(new volatile char[kPages * kPage_bytes]);
  for (std::size_t i = 0; i < kPages; ++i) pages[i * kPage_bytes] = 1;
  meter.end(0, 0, std::numeric_limits<std::int64_t>::max());
  meter.finish();
  EXPECT_GE(meter.times().faults, static_cast<std::int64_t>(kPages) / 2);
}

}  // namespace
}  // namespace palpate
