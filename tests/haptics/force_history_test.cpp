// Which forces act between two samples, judged by the definition of a delay.

#include "haptics/force_history.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kHistoryPeriod_s = 1e-3;

// The force of tick n acts from n T + tau on; before the first one, there is none.
Vec3 force_at(const std::vector<Vec3>& forces_N, double time_s, double delay_s) {
  const double n = std::floor((time_s - delay_s) / kHistoryPeriod_s);
  if (n < 0.0) return Vec3::Zero();
  return forces_N[static_cast<std::size_t>(n)];
}

TEST(ForceHistory, GivesTheMeanOfTheForcesThatActBetweenTwoSamples) {
  Random random(1);
  for (const double delay_s : {0.0, 1e-3, 4e-3, 0.25e-3, 2.7e-3, 60.5e-3}) {
    ForceHistory history;
    const DelayTicks delay = DelayTicks::of(delay_s, kHistoryPeriod_s);
    std::vector<Vec3> forces_N;
    for (int k = 0; k < 200; ++k) {
      forces_N.push_back(random.in_box(5.0));
      history.push(forces_N.back());
      // The mean over the period that follows sample k, by its midpoints.
      constexpr int kParts = 400;
      Vec3 mean_N = Vec3::Zero();
      for (int part = 0; part < kParts; ++part) {
        const double time_s = (k + (part + 0.5) / kParts) * kHistoryPeriod_s;
        mean_N += force_at(forces_N, time_s, delay_s) / kParts;
      }
      ASSERT_LE((history.acting_N(delay) - mean_N).norm(), 1e-9) << k << ' ' << delay_s;
    }
  }
}

TEST(DelayTicks, KeepsWholePeriodsAndLimitsTheirNumber) {
  for (const double rate_Hz : {250.0, 1000.0, 3000.0, 4096.0, 10000.0}) {
    for (std::size_t ticks = 0; ticks <= 50; ++ticks) {
      const DelayTicks delay = DelayTicks::of(static_cast<double>(ticks) / rate_Hz, 1.0 / rate_Hz);
      EXPECT_EQ(delay.whole, ticks) << rate_Hz;
      EXPECT_EQ(delay.share, 0.0) << rate_Hz;
    }
  }
  EXPECT_EQ(DelayTicks::of(1.0, 1e-3).whole, DelayTicks::kMostWhole);
  EXPECT_EQ(DelayTicks::of(1e-3, 0.0).whole, 0u);
  EXPECT_NEAR(DelayTicks::of(1.25e-3, 1e-3).share, 0.25, 1e-12);
}

}  // namespace
}  // namespace palpate
