// Which motions count as a swing that does not die down.

#include "haptics/swing_watch.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kSample_s = 1e-3;
constexpr double kLeast_N = 0.02;

// The time at which a sine of a frequency, which grows by e^(growth t), is first recognised.
std::optional<double> recognised_s(double frequency_Hz, double growth_per_s, double size_N,
                                   const Vec3& direction, double seconds) {
  SwingWatch watch;
  for (int n = 0; n < static_cast<int>(seconds / kSample_s); ++n) {
    const double t = n * kSample_s;
    const double force_N =
        size_N * std::exp(growth_per_s * t) * std::sin(2.0 * std::numbers::pi * frequency_Hz * t);
    watch.add((5.0 + force_N) * direction, kLeast_N, std::llround(1e9 * t));
    if (watch.swing_rad_per_s() > 0.0) {
      EXPECT_NEAR(watch.swing_rad_per_s() / (2.0 * std::numbers::pi * frequency_Hz), 1.0, 0.1);
      return t;
    }
  }
  return std::nullopt;
}

TEST(SwingWatch, RecognisesAGrowingSwingWithinThreePeriods) {
  Random random(2);
  for (int n = 0; n < 500; ++n) {
    const double frequency_Hz = random.uniform(5.5, 40.0);
    const double growth_per_s = frequency_Hz * random.uniform(0.02, 0.5);
    const double size_N = random.uniform(0.2, 2.0);
    const auto time_s =
        recognised_s(frequency_Hz, growth_per_s, size_N, random.unit_vector(), 4.0 / frequency_Hz);
    ASSERT_TRUE(time_s) << frequency_Hz << ' ' << growth_per_s << ' ' << size_N;
    // Three periods of half-swings after the first quarter, and the extreme is seen a little late.
    EXPECT_LE(*time_s, 3.4 / frequency_Hz) << frequency_Hz;
  }
}

TEST(SwingWatch, RecognisesASwingThatStays) {
  for (const double frequency_Hz : {5.5, 12.0, 40.0}) {
    EXPECT_TRUE(recognised_s(frequency_Hz, 0.0, 0.5, Vec3::UnitX(), 5.0 / frequency_Hz));
  }
}

// A bare tip of 0.1 kg and 0.5 N s/m on a spring of 100 N/m and more loses e^(-2.5 t).
TEST(SwingWatch, LeavesASwingThatDiesDownSmallOnesAndSlowOnesAlone) {
  for (const double frequency_Hz : {5.5, 7.0}) {
    EXPECT_FALSE(recognised_s(frequency_Hz, -2.5, 2.0, Vec3::UnitY(), 3.0)) << frequency_Hz;
  }
  EXPECT_FALSE(recognised_s(10.0, 0.0, 0.4 * kLeast_N, Vec3::UnitX(), 2.0)) << "too small";
  EXPECT_FALSE(recognised_s(2.0, 0.0, 2.0, Vec3::UnitX(), 5.0)) << "a hand moves as slowly";
}

TEST(SwingWatch, ASwingEndsWhenItStops) {
  SwingWatch watch;
  std::int64_t now_ns = 0;
  const auto add = [&](double force_N) {
    watch.add(force_N * Vec3::UnitZ(), kLeast_N, now_ns);
    now_ns += 1'000'000;
  };
  for (int n = 0; n < 500; ++n) add(std::sin(2.0 * std::numbers::pi * 20.0 * n * kSample_s));
  EXPECT_GT(watch.swing_rad_per_s(), 0.0);
  for (int n = 0; n < 200; ++n) add(0.0);
  EXPECT_EQ(watch.swing_rad_per_s(), 0.0);
}

// A hand that wanders: no regular time.
TEST(SwingWatch, LeavesARandomForceAlone) {
  Random random(3);
  int seen = 0;
  constexpr int kRandom = 100'000;
  SwingWatch watch;
  double force_N = 0.0, rate = 0.0;
  for (int n = 0; n < kRandom; ++n) {
    rate = 0.95 * rate + random.uniform(-1.0, 1.0);
    force_N = 0.999 * force_N + 0.01 * rate;
    watch.add(force_N * Vec3::UnitX(), kLeast_N, std::int64_t{1'000'000} * n);
    seen += watch.swing_rad_per_s() > 0.0;
  }
  EXPECT_LE(seen, kRandom / 1000);
}

}  // namespace
}  // namespace palpate
