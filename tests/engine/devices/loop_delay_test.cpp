// Stiffness limits at delays that are no whole number of periods: compared with a simulation of
// each tick, with the limits of the earlier search at whole periods, and with the energy of
// motions.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/stability_limits.h"
#include "tests/helpers/random.h"
#include "tests/helpers/tick_map.h"

namespace palpate {
namespace {

using test::Random;
using test::TickMap;

struct DelayedWall {
  DeviceMechanics device;
  double coupling_damping = 0.0;
  ServoTiming timing;

  static DelayedWall draw(Random& random, bool held) {
    DelayedWall wall;
    wall.device.mass_kg = random.uniform(0.05, 1.0);
    wall.device.damping_Ns_per_m = random.uniform(0.2, 3.0);
    if (held) {
      HandImpedance& hand = wall.device.hand.emplace();
      hand.mass_kg = random.uniform(0.0, 0.6);
      hand.damping_Ns_per_m = random.uniform(0.0, 8.0);
      hand.stiffness_N_per_m = random.uniform(0.0, 300.0);
    }
    wall.coupling_damping = random.uniform(0.0, 3.0);
    wall.timing.period_s = random.uniform(0.1e-3, 4e-3);
    wall.timing.delay_s = random.uniform(0.0, 5.0) * wall.timing.period_s;
    wall.timing.velocity_ticks = 1 + static_cast<int>(random.index(4));
    return wall;
  }
  StabilityLimits limits() const {
    return stability_limits(device, coupling_damping, timing).value();
  }
  bool decays(double stiffness_N_per_m) const {
    return TickMap(device, stiffness_N_per_m, {{coupling_damping, timing.velocity_ticks}}, timing)
        .decays();
  }
};

TEST(LoopDelay, ALoopDecaysBelowItsLimitAndGrowsAboveIt) {
  Random random(4901);
  // Relative; the simulation's own rounding is far below it.
  constexpr double kOff = 1e-6;
  int checked = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const DelayedWall wall = DelayedWall::draw(random, trial % 2 == 1);
    const double limit = wall.limits().stable_N_per_m;
    if (limit == 0.0) continue;
    EXPECT_TRUE(wall.decays((1.0 - kOff) * limit)) << "trial " << trial << ", " << limit;
    EXPECT_FALSE(wall.decays((1.0 + kOff) * limit)) << "trial " << trial << ", " << limit;
    EXPECT_TRUE(wall.decays(random.uniform(0.001, 0.999) * limit)) << "trial " << trial;
    ++checked;
  }
  EXPECT_GT(checked, 250);
}

TEST(LoopDelay, TheSpectralRadiusIsThatOfTheSimulatedTick) {
  Random random(4902);
  for (int trial = 0; trial < 100; ++trial) {
    const DelayedWall wall = DelayedWall::draw(random, trial % 2 == 1);
    const double stiffness = random.uniform(1.0, 3000.0);
    const Eigen::MatrixXd map =
        TickMap(wall.device, stiffness, {{wall.coupling_damping, wall.timing.velocity_ticks}},
                wall.timing)
            .matrix();
    const double radius =
        spectral_radius(wall.device, {stiffness, wall.coupling_damping}, wall.timing);
    // Two eigenvalues that nearly coincide amplify rounding to its square root.
    EXPECT_NEAR(map.eigenvalues().cwiseAbs().maxCoeff() / radius, 1.0, 1e-7) << "trial " << trial;
  }
}

// The first two rows are those of the notes: a bare tip at 1 ms and 3 ms.
TEST(LoopDelay, ABareTipHasTheKnownLimitsAtOneAndThreeMilliseconds) {
  const DeviceMechanics tip{0.1, 0.5};
  EXPECT_NEAR(stability_limits(tip, 0.0, {1e-3, 1e-3})->passive_N_per_m, 333.3, 0.05);
  EXPECT_NEAR(stability_limits(tip, 0.0, {1e-3, 3e-3})->passive_N_per_m, 142.9, 0.05);
  EXPECT_NEAR(stability_limits(tip, 0.0, {1e-3, 1e-3})->stable_N_per_m, 333.0, 1.0);
  EXPECT_NEAR(stability_limits(tip, 0.0, {1e-3, 3e-3})->stable_N_per_m, 143.0, 0.5);
}

// What the search over stiffnesses found when delays were whole ticks.
TEST(LoopDelay, WholePeriodsGiveTheLimitsOfTheSearchOverStiffnesses) {
  struct Row {
    double mass, damping, coupling_damping, period_s;
    int delay_ticks;
    bool is_held;
    double stable, passive;
  };
  constexpr Row kRows[] = {
      {0.1, 0.5, 0, 0.001, 0, false, 1000.8340280091514, 1000},
      {0.1, 0.5, 0, 0.001, 1, false, 333.7956022503954, 333.33333333333331},
      {0.1, 0.5, 0, 0.001, 3, false, 143.28071441539814, 142.85714285714286},
      {0.1, 0.5, 1, 0.001, 0, false, 2972.70075938013, 0},
      {0.1, 0.5, 1, 0.001, 2, false, 592.90586031470411, 0},
      {0.05, 0.2, 0.1, 0.0005, 5, false, 109.03505693980043, 36.363636363636367},
      {0.3, 2, 0.5, 0.004, 0, false, 1247.3475771557144, 750},
      {0.3, 2, 0.5, 0.004, 1, false, 416.69017420216545, 250},
      {0.1, 0.5, 0, 0.0001, 31, false, 159.14551065378168, 158.73015873015873},
      {0.1, 0.5, 0, 0.001, 0, true, 13925.05586713837, 1000},
      {0.1, 0.5, 0.3, 0.001, 3, true, 2083.6417238329536, 57.142857142857146},
      {0.2, 1, 3, 0.002, 2, true, 2084.4474151609834, 0},
  };
  for (const Row& row : kRows) {
    DeviceMechanics device{row.mass, row.damping};
    if (row.is_held) device.hand = HandImpedance{};
    const ServoTiming timing{row.period_s, row.delay_ticks * row.period_s};
    const auto limits = stability_limits(device, row.coupling_damping, timing);
    EXPECT_NEAR(limits->stable_N_per_m / row.stable, 1.0, 1e-9) << row.stable;
    EXPECT_DOUBLE_EQ(limits->passive_N_per_m, row.passive);
  }
}

TEST(LoopDelay, ALongerDelayLowersEveryLimit) {
  Random random(4903);
  for (int trial = 0; trial < 200; ++trial) {
    DelayedWall wall = DelayedWall::draw(random, trial % 2 == 1);
    // A damper near its own limit can gain from a delay.
    wall.coupling_damping = random.uniform(0.0, 0.5);
    StabilityLimits before = wall.limits();
    for (int step = 0; step < 8; ++step) {
      wall.timing.delay_s += random.uniform(0.01, 0.4) * wall.timing.period_s;
      const StabilityLimits after = wall.limits();
      EXPECT_LE(after.passive_N_per_m, before.passive_N_per_m) << "trial " << trial;
      EXPECT_LT(after.stable_first_order_N_per_m, before.stable_first_order_N_per_m);
      EXPECT_LT(after.stable_N_per_m, before.stable_N_per_m) << "trial " << trial;
      before = after;
    }
  }
}

TEST(LoopDelay, LimitsAreContinuousAtWholePeriods) {
  Random random(4904);
  for (int trial = 0; trial < 100; ++trial) {
    DelayedWall wall = DelayedWall::draw(random, trial % 2 == 1);
    wall.timing.delay_s = static_cast<double>(1 + random.index(4)) * wall.timing.period_s;
    const StabilityLimits at = wall.limits();
    if (at.stable_N_per_m == 0.0) continue;
    for (const double off : {1.0 - 1e-9, 1.0 + 1e-9}) {
      DelayedWall near = wall;
      near.timing.delay_s *= off;
      EXPECT_NEAR(near.limits().stable_N_per_m / at.stable_N_per_m, 1.0, 1e-6);
      EXPECT_NEAR(held_time_s(near.timing) / held_time_s(wall.timing), 1.0, 1e-6);
    }
  }
}

// The most energetic motion for what it dissipates has a constant speed between two moments at
// which a force is sampled or begins. Each tick has two such pieces.
struct Motion {
  std::vector<std::array<double, 2>> speeds_m_per_s;  // from the sample on, and after the part
};

struct Energies {
  double generated_J = 0.0;   // work of the wall's force, from rest at the unloaded wall
  double dissipated_J = 0.0;  // by a device with a damping of 1 N s/m
  double exchanged_J = 0.0;   // the sum of the magnitudes of the works
};

Energies energies_of(const Motion& motion, const ServoTiming& timing, double stiffness_N_per_m,
                     const LoopDamper& damper) {
  const double T = timing.period_s;
  const auto whole = static_cast<int>(timing.delay_s / T);
  const double lengths_s[] = {timing.delay_s - whole * T, (1 + whole) * T - timing.delay_s};
  Energies sum;
  std::vector<double> positions_m, forces_N;
  const auto force_of = [&](int tick) {
    return tick < 0 ? 0.0 : forces_N[static_cast<std::size_t>(tick)];
  };
  const auto position_of = [&](int tick) {
    return tick < 0 ? 0.0 : positions_m[static_cast<std::size_t>(tick)];
  };
  double x = 0.0;
  for (int n = 0; n < static_cast<int>(motion.speeds_m_per_s.size()); ++n) {
    positions_m.push_back(x);
    forces_N.push_back(-stiffness_N_per_m * x - damper.damping_Ns_per_m *
                                                    (x - position_of(n - damper.velocity_ticks)) /
                                                    (damper.velocity_ticks * T));
    for (int piece = 0; piece < 2; ++piece) {
      const double v = motion.speeds_m_per_s[static_cast<std::size_t>(n)][piece];
      const double dx = v * lengths_s[piece];
      const double work_J = force_of(n - whole - (piece == 0 ? 1 : 0)) * dx;
      sum.generated_J += work_J;
      sum.exchanged_J += std::abs(work_J);
      sum.dissipated_J += v * dx;
      x += dx;
    }
  }
  return sum;
}

TEST(LoopDelay, NoMotionGetsEnergyFromAPassiveWall) {
  Random random(4905);
  double most = 0.0;
  for (int trial = 0; trial < 1000; ++trial) {
    const double T = random.uniform(0.1e-3, 4e-3);
    const ServoTiming timing{T, random.uniform(0.0, 4.0) * T};
    const LoopDamper damper{trial % 2 == 0 ? 0.0 : random.uniform(0.0, 2.0),
                            1 + static_cast<int>(random.index(4))};
    const double b = damper.damping_Ns_per_m + random.uniform(0.1, 3.0);
    const auto limits = stability_limits({1.0, b}, damper.damping_Ns_per_m,
                                         {T, timing.delay_s, damper.velocity_ticks});
    Motion motion;
    const double angle = random.uniform(0.0, std::numbers::pi);
    const double noise = random.uniform(0.0, 1.0);
    for (int n = 0; n < 200; ++n) {
      const double speed = std::cos(angle * n);
      motion.speeds_m_per_s.push_back(
          {speed + noise * random.uniform(-1.0, 1.0), speed + noise * random.uniform(-1.0, 1.0)});
    }
    const Energies sum = energies_of(motion, timing, limits->passive_N_per_m, damper);
    const double share = sum.generated_J / (b * sum.dissipated_J);
    EXPECT_LE(share, 1.0) << "trial " << trial;
    most = std::max(most, share);
  }
  EXPECT_GT(most, 0.8);
}

// A slow sine of n ticks, one speed in each piece, whose ratio is searched: it gets within 1 % of
// the limit from below, where the mean delay T / 2 + D alone would be exceeded.
TEST(LoopDelay, AMotionOfTwoSpeedsReachesThePassiveLimit) {
  // Half an epsilon of the magnitudes for each of the sum's 810 terms.
  constexpr double kSumRounding = 405.0 * std::numeric_limits<double>::epsilon();
  int beyond_the_mean = 0;
  for (const double ticks : {0.0, 0.1, 0.25, 0.5, 0.9, 1.0, 1.5, 2.7}) {
    const ServoTiming timing{1e-3, ticks * 1e-3};
    double most = 0.0;
    for (double ratio = 0.0; ratio < 3.0; ratio += 0.02) {
      Motion motion;
      for (int n = 0; n < 400; ++n) {
        const double speed = std::sin(2.0 * std::numbers::pi * n / 400.0);
        motion.speeds_m_per_s.push_back({speed, ratio * speed});
      }
      for (int n = 0; n < 5; ++n) motion.speeds_m_per_s.push_back({0.0, 0.0});
      const Energies sum = energies_of(motion, timing, 1.0, {});
      EXPECT_LE(sum.generated_J,
                held_time_s(timing) * sum.dissipated_J + kSumRounding * sum.exchanged_J)
          << ticks << " " << ratio;
      most = std::max(most, sum.generated_J / sum.dissipated_J);
    }
    EXPECT_GT(most, 0.99 * held_time_s(timing)) << ticks;
    beyond_the_mean += most > 1.01 * (0.5 + ticks) * 1e-3;
  }
  EXPECT_GE(beyond_the_mean, 3);
}

TEST(LoopDelay, ErrorsStateTheRange) {
  const auto error_of = [](const ServoTiming& timing) {
    const auto limits = stability_limits({0.1, 0.5}, 0.0, timing);
    return limits.ok() ? std::string() : limits.error().to_string();
  };
  EXPECT_NE(error_of({1e-3, 300.5e-3}).find("0.300500 s, 300.500000 periods; expected 0 to 256"),
            std::string::npos)
      << error_of({1e-3, 300.5e-3});
  EXPECT_NE(error_of({1e-3, 0.0, 0}).find("is 0 ticks; expected 1 to 64"), std::string::npos);
  EXPECT_NE(error_of({1e-3, 0.0, 65}).find("is 65 ticks; expected 1 to 64"), std::string::npos);
  EXPECT_NE(error_of({1e-3, std::nan("")}), "");
}

}  // namespace
}  // namespace palpate
