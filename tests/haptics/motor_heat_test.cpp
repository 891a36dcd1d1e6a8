// The heat of motors: how warm a load makes them, and that the limit ends at the continuous force.

#include "haptics/motor_heat.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/motor_limits.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kTau_s = 10.0;
constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::int64_t kLong_ns = 1'000'000'000'000;  // a hundred time constants
constexpr double kFadeFrom2 = MotorHeatLimits::kFadeFrom * MotorHeatLimits::kFadeFrom;
constexpr double kEps = std::numeric_limits<double>::epsilon();

MotorDescription motor_along(const Vec3& direction, double continuous_N) {
  MotorDescription motor;
  std::copy_n(direction.data(), 3, motor.direction_device.begin());
  motor.peak_force_N = 20.0;
  motor.continuous_force_N = continuous_N;
  return motor;
}

// Three motors in a random pose, at most some 60 degrees from orthogonal.
std::vector<MotorDescription> random_motors(Random& random) {
  const Mat3 turn = random.rotation().toRotationMatrix();
  std::vector<MotorDescription> motors;
  for (int i = 0; i < 3; ++i) {
    const Vec3 oblique = (Vec3::Unit(i) + random.in_box(0.4)).normalized();
    motors.push_back(motor_along(turn * oblique, random.uniform(0.5, 5.0)));
  }
  return motors;
}

double largest(const Vec3& loads) {
  return loads.cwiseAbs().maxCoeff();
}

TEST(MotorLoads, AddUpToTheForce) {
  Random random(4901);
  for (int n = 0; n < 1000; ++n) {
    const auto motors = random_motors(random);
    const Vec3 force_N = random.in_box(10.0);
    const Vec3 loads = MotorLimits(motors).loads(force_N);
    Vec3 sum_N = Vec3::Zero();
    double most_N = 0.0;
    for (int i = 0; i < 3; ++i) {
      const MotorDescription& motor = motors[static_cast<std::size_t>(i)];
      const double share_N = loads[i] * motor.continuous_force_N;
      sum_N += share_N * Vec3(motor.direction_device.data());
      most_N = std::max(most_N, std::abs(share_N));
    }
    EXPECT_LE((sum_N - force_N).norm(), 100 * kEps * most_N);
  }
}

TEST(MotorLoads, OfTwoObliqueMotorsAddUpToAForceInTheirPlane) {
  Random random(4907);
  for (int n = 0; n < 1000; ++n) {
    const auto three = random_motors(random);
    const std::vector<MotorDescription> motors = {three[0], three[1]};
    const Vec3 efforts_N = random.in_box(5.0);
    Vec3 force_N = Vec3::Zero();
    for (int i = 0; i < 2; ++i) {
      force_N += efforts_N[i] * Vec3(motors[static_cast<std::size_t>(i)].direction_device.data());
    }
    const Vec3 loads = MotorLimits(motors).loads(force_N);
    for (int i = 0; i < 2; ++i) {
      const double share_N = loads[i] * motors[static_cast<std::size_t>(i)].continuous_force_N;
      EXPECT_NEAR(share_N, efforts_N[i], 100 * kEps * efforts_N.norm()) << n;
    }
  }
}

TEST(MotorLoads, BelongToTheMotorsInTheirOrderAlsoWhereOneHasNoShareOrIsUnknown) {
  const std::vector<MotorDescription> twice = {motor_along(Vec3::UnitX(), 2.0),
                                               motor_along(-Vec3::UnitX(), 3.0),
                                               motor_along(Vec3::UnitZ(), 4.0)};
  EXPECT_EQ(MotorLimits(twice).loads({1.0, 0.0, 8.0}), Vec3(0.5, 0.0, 2.0));
  const std::vector<MotorDescription> unknown = {motor_along(Vec3::UnitY(), 0.0),
                                                 motor_along(Vec3::UnitX(), 5.0)};
  EXPECT_EQ(MotorLimits(unknown).loads({10.0, 7.0, 0.0}), Vec3(0.0, 2.0, 0.0));
}

TEST(MotorHeat, WarmsByTheExponentialOfTheTime) {
  Random random(4902);
  EXPECT_EQ(warming_share(0), 0.0);
  for (int n = 0; n < 20'000; ++n) {
    const auto ns = static_cast<std::int64_t>(std::exp(random.uniform(0.0, std::log(1e12))));
    const double expected = -std::expm1(-static_cast<double>(ns) * 1e-9 / kTau_s);
    // Five terms, and up to 18 doublings that add an epsilon each.
    EXPECT_NEAR(warming_share(ns), expected, 32 * kEps * expected) << ns << " ns";
  }
}

TEST(MotorHeat, CoolsInAPauseByItsTimeConstant) {
  MotorHeat heat;
  heat.add({1.0, 2.0, 0.0}, kLong_ns);
  EXPECT_EQ(heat.mean_squares(), Vec3(1.0, 4.0, 0.0));
  for (int n = 0; n < 10'000; ++n) heat.add(Vec3::Zero(), kMillisecond_ns);
  const double left = std::exp(-1.0);
  EXPECT_NEAR(heat.mean_squares()[0], left, 10'000 * kEps);
  EXPECT_NEAR(heat.mean_squares()[1], 4.0 * left, 40'000 * kEps);
}

// A cold motor gives its peak until its mean square has reached the share at which the fade begins:
// w^2 (1 - exp(-t / tau)) = kFadeFrom^2.
TEST(MotorHeat, LetsAColdMotorGiveItsPeakUntilItIsWarm) {
  for (const double load : {1.2, 2.0, 3.3, 6.0}) {
    MotorHeat heat;
    std::int64_t ticks = 0;
    while (heat.factor({0.0, load, 0.0}) == 1.0) {
      heat.add({0.0, load, 0.0}, kMillisecond_ns);
      ++ticks;
      ASSERT_LT(ticks, 100'000);
    }
    const double warm_s = -kTau_s * std::log(1.0 - kFadeFrom2 / (load * load));
    EXPECT_NEAR(1e-3 * static_cast<double>(ticks), warm_s, 1e-3) << load;
  }
}

// From the peak to the continuous force, the force falls no faster than at the begin of the fade,
// where d(l^2)/dt = (w^2 - 1) / width * (w^2 - m) / tau, and it never grows on the way.
TEST(MotorHeat, FadesWithoutAJump) {
  constexpr double kLoad = 10.0 / 3.0;
  MotorHeat heat;
  double before = 1.0;
  const double load2 = kLoad * kLoad;
  const double fastest_per_s = (load2 - 1.0) / (1.0 - kFadeFrom2) * (load2 - kFadeFrom2) / kTau_s;
  for (int n = 0; n < 60'000; ++n) {
    const double factor = heat.factor({kLoad, 0.0, 0.0});
    ASSERT_LE(factor, before);
    const double fall2 = load2 * (before * before - factor * factor);
    ASSERT_LE(fall2, 1e-3 * fastest_per_s * (1.0 + 1e-9)) << n;
    before = factor;
    heat.add({factor * kLoad, 0.0, 0.0}, kMillisecond_ns);
  }
  EXPECT_NEAR(kLoad * before, 1.0, 1e-6);
}

struct Load {
  const char* name;
  std::function<double(int)> share;  // of the full force, by tick
};

// The root mean square of the warmest motor's load, over the last 40 s of 120 s. The test sums the
// squares itself.
double last_rms(MotorHeat heat, const MotorLimits& limits, const Vec3& full_N, const Load& load,
                std::int64_t step_ns) {
  const int ticks = static_cast<int>(120'000 * kMillisecond_ns / step_ns);
  Vec3 sum = Vec3::Zero();
  int summed = 0;
  for (int n = 0; n < ticks; ++n) {
    const Vec3 wanted_N = load.share(n) * full_N;
    const Vec3 force_N = heat.factor(limits.loads(wanted_N)) * wanted_N;
    const Vec3 loads = limits.loads(force_N);
    heat.add(loads, step_ns);
    if (n < ticks - ticks / 3) continue;
    sum += loads.cwiseAbs2();
    ++summed;
  }
  return std::sqrt(sum.maxCoeff() / summed);
}

TEST(MotorHeat, EndsAtTheContinuousForceFromColdAndWarm) {
  Random random(4903);
  for (int n = 0; n < 6; ++n) {
    const MotorLimits limits(random_motors(random));
    const Vec3 direction = random.unit_vector();
    // The warmest motor's mean square would be at least 1.2 under each of the loads.
    const double most = random.uniform(2.2, 5.0);
    const Vec3 full_N = most / largest(limits.loads(direction)) * direction;
    const int half_period = 1 + static_cast<int>(random.index(50));
    const std::int64_t step_ns = n % 2 == 0 ? kMillisecond_ns : 4 * kMillisecond_ns;
    std::vector<double> draws(4096);
    for (double& draw : draws) draw = random.uniform(-1.0, 1.0);
    const std::vector<Load> loads = {
        {"constant", [](int) { return 0.6; }},
        {"square", [&](int tick) { return tick / half_period % 2 == 0 ? 1.0 : 0.0; }},
        {"random", [&](int tick) { return draws[static_cast<std::size_t>(tick) % 4096]; }}};
    for (const Load& load : loads) {
      for (const double before : {0.0, 1.0, 1.5}) {
        MotorHeat heat;
        heat.add(Vec3::Constant(before), kLong_ns);
        EXPECT_NEAR(last_rms(heat, limits, full_N, load, step_ns), 1.0, 0.02)
            << load.name << ", most " << most << ", before " << before;
      }
    }
  }
}

// The mean square never exceeds 1 by more than what one step adds to a motor that may still have
// its full force, whatever the loads and the steps of time are.
TEST(MotorHeat, NeverLetsTheMeanSquareExceedTheContinuousForce) {
  Random random(4904);
  MotorHeat heat;
  double mean2 = 0.0;  // by the definition
  double most = 0.0;
  double wanted = 0.0;
  for (int n = 0; n < 300'000; ++n) {
    if (n % 50 == 0) wanted = random.uniform(-4.0, 4.0);
    const auto step_ns = static_cast<std::int64_t>(random.uniform(0.1, 20.0) * 1e6);
    const double load = heat.factor({0.0, 0.0, wanted}) * wanted;
    heat.add({0.0, 0.0, load}, step_ns);
    const double kept = std::exp(-1e-9 * static_cast<double>(step_ns) / kTau_s);
    mean2 = kept * mean2 + (1.0 - kept) * load * load;
    ASSERT_NEAR(heat.mean_squares()[2], mean2, 1e-11);
    most = std::max(most, mean2);
  }
  EXPECT_LE(most, 1.0 + 1e-11);
  EXPECT_GT(most, 0.98);
}

TEST(MotorHeat, LeavesALoadBelowTheContinuousForceToTheBit) {
  Random random(4905);
  // Never above 1; and above 1 for a fifth of the time, with a mean square of at most 0.87.
  for (const double peak : {1.0, 2.0}) {
    MotorHeat heat;
    heat.add(Vec3::Constant(0.8), kLong_ns);
    for (int n = 0; n < 100'000; ++n) {
      const double most = peak > 1.0 && n % 10 < 8 ? 0.3 : peak;
      const Vec3 loads = most * Vec3(random.uniform(-1.0, 1.0), -1.0, random.uniform(-1.0, 1.0));
      ASSERT_EQ(heat.factor(loads), 1.0) << n;
      heat.add(loads, kMillisecond_ns);
    }
    EXPECT_GT(heat.mean_squares()[1], 0.8);
  }
}

TEST(MotorHeat, ScalesForTheWarmestMotorOnly) {
  MotorHeat heat;
  heat.add({1.0, 0.0, 0.0}, kLong_ns);
  EXPECT_EQ(heat.factor({0.5, 9.0, 3.0}), 1.0);
  EXPECT_NEAR(heat.factor({-4.0, 9.0, 3.0}), 0.25, kEps);
  heat.add({1.0, 0.0, 1.0}, kLong_ns);
  EXPECT_NEAR(heat.factor({-4.0, 9.0, 5.0}), 0.2, kEps);
  EXPECT_NEAR(heat.factor({-5.0, 9.0, 4.0}), 0.2, kEps);
}

TEST(MotorHeat, TakesALoadThatIsNotFiniteForTheContinuousForce) {
  MotorHeat heat;
  const double none = std::numeric_limits<double>::quiet_NaN();
  heat.add({none, std::numeric_limits<double>::infinity(), 0.5}, kLong_ns);
  EXPECT_EQ(heat.mean_squares(), Vec3(1.0, 1.0, 0.25));
}

}  // namespace
}  // namespace palpate
