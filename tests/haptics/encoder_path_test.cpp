// The path of a device between the steps of its encoders.

#include "haptics/encoder_path.h"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

Vec3 rounded(const Vec3& p_m, double quantum_m) {
  return quantum_m * (p_m / quantum_m).array().round().matrix();
}

TEST(EncoderPath, IsTheSampleWithoutSteps) {
  Random random(1);
  EncoderPath path(0.0);
  for (int n = 0; n < 100; ++n) {
    const Vec3 p_m(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    EXPECT_EQ(path.add(p_m, 1e-3), p_m);
  }
}

// Whatever the hand does. The path and the sample round by some epsilons of a place of 1 m.
TEST(EncoderPath, IsWithinHalfAStepOfTheSample) {
  Random random(2);
  std::cout << "seed " << random.seed() << "\n";
  for (int run = 0; run < 50; ++run) {
    const double quantum_m = random.uniform(1e-6, 100e-6);
    EncoderPath path(quantum_m);
    Vec3 p_m = Vec3::Zero();
    for (int n = 0; n < 1000; ++n) {
      const double most_m = quantum_m * std::pow(10.0, random.uniform(-2.0, 1.0));
      p_m += Vec3(random.uniform(-most_m, most_m), random.uniform(-most_m, most_m), 0.0);
      const Vec3 sensed_m = rounded(p_m, quantum_m);
      const Vec3 place_m = path.add(sensed_m, random.uniform(0.1e-3, 5e-3));
      ASSERT_LE((place_m - sensed_m).lpNorm<Eigen::Infinity>(), 0.5 * quantum_m + 1e-15);
      if (random.index(100) == 0) path.clear();
    }
  }
}

// Of a steady hand of speed v, the time of a jump is known to a tick: the place to v T / 2, and
// the speed to v (v T / q) / (1 - v T / q). So from the second edge on, the place is known to
// v T (1/2 + 1 / (1 - v T / q)), less than 2 v T for v T < q / 4.
TEST(EncoderPath, FollowsASteadyHand) {
  Random random(3);
  std::cout << "seed " << random.seed() << "\n";
  for (int run = 0; run < 200; ++run) {
    const double quantum_m = random.uniform(5e-6, 100e-6);
    const double dt_s = random.uniform(0.1e-3, 4e-3);
    const double way_m = random.uniform(-0.25, 0.25) * quantum_m;  // of a tick
    const double start_m = random.uniform(-0.1, 0.1);
    EncoderPath path(quantum_m);
    int jumps = 0;
    double last_m = quantum_m * std::round(start_m / quantum_m);
    for (int n = 0; n < 400; ++n) {
      const double p_m = start_m + n * way_m;
      const double sensed_m = quantum_m * std::round(p_m / quantum_m);
      jumps += sensed_m != last_m;
      last_m = sensed_m;
      const Vec3 place_m = path.add(Vec3(sensed_m, 0.0, 0.0), dt_s);
      if (jumps >= 2) {
        ASSERT_LE(std::abs(place_m.x() - p_m), 2.0 * std::abs(way_m) + 1e-15) << n;
      }
    }
  }
}

// In and out of a spring. Its force is that of the last sample, and the hand's true leak is
// K v T / 2 for each way: small for a slow hand, where the jumps of the samples seem to give
// K q / 2.
TEST(EncoderPath, ASpringThatASlowHandPressesGivesNothing) {
  constexpr double kQuantum_m = 45e-6, kStiffness = 1000.0, kDt_s = 1e-3;
  EncoderPath path(kQuantum_m);
  double by_samples_J = 0.0, by_path_J = 0.0, last_sensed_m = 0.0, force_N = 0.0;
  double last_m = path.add(Vec3::Zero(), kDt_s).x();
  constexpr int kTicks = 4000;
  for (int n = 0; n <= kTicks; ++n) {
    const double p_m = 5e-3 * (1.0 - std::abs(1.0 - 2.0 * n / kTicks));
    const double sensed_m = kQuantum_m * std::round(p_m / kQuantum_m);
    const double place_m = path.add(Vec3(sensed_m, 0.0, 0.0), kDt_s).x();
    by_samples_J += force_N * (sensed_m - last_sensed_m);
    by_path_J += force_N * (place_m - last_m);
    force_N = -kStiffness * sensed_m;
    last_sensed_m = sensed_m;
    last_m = place_m;
  }
  const double steps = 2.0 * std::floor(5e-3 / kQuantum_m);
  const double jumps_J = steps * 0.5 * kStiffness * kQuantum_m * kQuantum_m;
  EXPECT_NEAR(by_samples_J, jumps_J, 0.02 * jumps_J);
  EXPECT_LE(std::abs(by_path_J), 0.1 * jumps_J);
}

}  // namespace
}  // namespace palpate
