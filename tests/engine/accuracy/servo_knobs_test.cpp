// The knobs of the servo, against closed forms and the orders of theory.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/bounce.h"
#include "engine/accuracy/friction_circle.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/measurement.h"
#include "engine/accuracy/plant_integrators.h"
#include "engine/accuracy/pressed_contact.h"
#include "engine/accuracy/tick_periods.h"
#include "engine/devices/stability_limits.h"
#include "engine/simulation/mass_damper.h"
#include "haptics/proxy/contact_world.h"
#include "tests/engine/accuracy/measured_knobs.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::kEffort;
using test::kOrderTolerance;
using test::Random;

KnobResult measured_servo(const std::string& name) {
  return test::measured(servo_knobs(kEffort), name);
}

// Every method has the order that theory gives it, over at least four levels; every preset runs.
void expect_orders(const KnobResult& result) {
  ASSERT_FALSE(result.methods.empty());
  for (const MethodResult& method : result.methods) {
    ASSERT_TRUE(method.expected_order.has_value()) << method.name;
    ASSERT_TRUE(method.order.has_value()) << method.name;
    EXPECT_NEAR(*method.order, *method.expected_order, kOrderTolerance) << method.name;
  }
  for (const LevelResult& preset : result.presets) EXPECT_TRUE(preset.counts()) << preset.failure;
}

void expect_levels_count(const KnobResult& result) {
  for (const MethodResult& method : result.methods) {
    for (const LevelResult& level : method.levels) {
      EXPECT_TRUE(level.counts()) << method.name << ", " << level.label << ": " << level.failure;
      EXPECT_GT(level.time.median, 0.0);
    }
  }
}

TEST(ServoKnobs, AreComplete) {
  for (const Knob& knob : servo_knobs(kEffort)) {
    for (const std::string* text :
         {&knob.name, &knob.title, &knob.level.name, &knob.error.name, &knob.time.name,
          &knob.workload, &knob.reference, &knob.enough_because}) {
      EXPECT_FALSE(text->empty()) << knob.name;
    }
    EXPECT_GT(knob.enough, 0.0) << knob.name;
    ASSERT_LT(knob.default_method, knob.methods.size());
    ASSERT_LT(knob.default_level, knob.methods[knob.default_method].levels.size());
    for (const Method& method : knob.methods) {
      EXPECT_TRUE(std::is_sorted(method.levels.begin(), method.levels.end(),
                                 [](const Level& a, const Level& b) { return a.value > b.value; }))
          << knob.name << ", " << method.name;
      EXPECT_EQ(method.floor > 0.0, !knob.floor_is.empty()) << knob.name;
    }
  }
}

TEST(ServoKnobs, RepeatTheSameErrors) {
  for (const Knob& knob : servo_knobs(kEffort)) {
    const Level& level = knob.methods[0].levels[knob.default_level];
    const Sample one = level.run(7);
    const Sample other = level.run(7);
    EXPECT_EQ(one.error, other.error) << knob.name;
    EXPECT_EQ(one.ticks, other.ticks) << knob.name;
    EXPECT_EQ(level.run(8).failure, "") << knob.name;
  }
}

TEST(ServoRate, GainsHalfPiTimesTheFrequencyTimesThePeriod) {
  const KnobResult result = measured_servo("servo_rate");
  expect_orders(result);
  expect_levels_count(result);
  double last_off = 1.0;
  for (const LevelResult& level : result.methods[0].levels) {
    const double ratio = level.error.median / BounceSetup().gain_to_first_order(level.value);
    EXPECT_GT(ratio, 1.0) << level.label;
    EXPECT_LT(ratio - 1.0, last_off) << level.label;  // 1 + O(w T)
    last_off = ratio - 1.0;
  }
  EXPECT_LT(last_off, 0.02);
}

TEST(ServoJitter, GainsLikeEvenTicksOfTheEffectivePeriod) {
  const KnobResult result = measured_servo("jitter");
  expect_orders(result);
  expect_levels_count(result);
  ASSERT_EQ(result.methods.size(), 4u);
  for (const MethodResult& method : result.methods) {
    for (const LevelResult& level : method.levels) {
      if (level.value > 0.2e-3) continue;
      const double theory = BounceSetup().gain_to_first_order(level.value);
      EXPECT_NEAR(level.error.median / theory, 1.0, 0.02) << method.name << ", " << level.label;
    }
  }
}

TEST(ServoJitter, DrawsPeriodsOfItsMeanAndEffectiveLength) {
  Random random(1611);
  for (const double half_width : {0.0, 0.5, 0.9}) {
    for (const double left_out : {0.0, 0.1, 0.5}) {
      const TickPeriods periods{1e-3, half_width, left_out};
      const int count = 1000000;
      double sum_s = 0.0;
      double sum_s2 = 0.0;
      for (int i = 0; i < count; ++i) {
        const double period_s = periods.draw_s(random);
        sum_s += period_s;
        sum_s2 += period_s * period_s;
      }
      // Five standard errors of the widest of them, some 4e-3.
      EXPECT_NEAR(sum_s / count, periods.mean_s(), 0.01 * periods.mean_s());
      EXPECT_NEAR(sum_s2 / sum_s, periods.effective_s(), 0.01 * periods.effective_s());
    }
  }
}

TEST(ServoPressed, DeviatesToFirstOrderAndListsUnstableRates) {
  const KnobResult result = measured_servo("servo_pressed");
  expect_orders(result);
  const PressedContact contact;
  ASSERT_EQ(result.methods[0].levels.size(), 7u);
  // Where second orders are negligible, twice the rate leaves half the deviation.
  const std::vector<LevelResult>& levels = result.methods[0].levels;
  EXPECT_NEAR(levels[5].error.median / levels[6].error.median, 2.0, 0.04);
  for (const LevelResult& level : result.methods[0].levels) {
    const StabilityLimits limits =
        stability_limits({contact.mass_kg, contact.damping_Ns_per_m},
                         contact.coupling.damping_Ns_per_m, {level.value})
            .value();
    const bool is_stable = limits.is_stable(contact.coupling.stiffness_N_per_m);
    EXPECT_EQ(is_stable, level.value < 4e-3) << level.label;
    EXPECT_EQ(level.failures, is_stable ? 0 : MeasurementEffort::kRepeats) << level.label;
    EXPECT_EQ(level.failure, is_stable
                                 ? ""
                                 : "unstable: 1000 N/m; the limit at this rate, without delay, is "
                                   "723 N/m");
  }
}

// The underdamped solution in its closed form.
TEST(ServoPressed, IsComparedWithTheExactPath) {
  const PressedContact contact;
  const double decay =
      0.5 * (contact.damping_Ns_per_m + contact.coupling.damping_Ns_per_m) / contact.mass_kg;
  const double w = std::sqrt(contact.coupling.stiffness_N_per_m / contact.mass_kg - decay * decay);
  for (int i = 0; i <= 500; ++i) {
    const double t = 1e-3 * i;
    const double swing = std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
    const double expected_m =
        contact.static_depth_m() + swing * (contact.start_depth_m() - contact.static_depth_m());
    // Rounding of the 50 rad that the path turns.
    EXPECT_NEAR(contact.depth_m(t), expected_m, 64 * 0x1p-52 * contact.static_depth_m());
  }
}

TEST(ServoSubsteps, HaveTheRadiusOfTheDiscreteLaw) {
  const KnobResult result = measured_servo("substeps");
  expect_orders(result);
  expect_levels_count(result);
  const FrictionCircle circle;
  // The stand-off of the proxy, which is part of the depth, and the part of the initial deviation
  // that is left after half a turn.
  const double left = std::exp(-std::numbers::pi * circle.continuous_radius_m() / circle.lag_m());
  for (const LevelResult& level : result.methods[0].levels) {
    const double expected_m = circle.continuous_radius_m() - circle.discrete_radius_m(level.value);
    const double tolerance_m = 4 * SolverScale::of(0.5, 0.0).stand_off_m + left * expected_m;
    EXPECT_NEAR(level.error.median, expected_m, tolerance_m) << level.label;
  }
}

TEST(ServoSubsteps, SolvesTheDiscreteLaw) {
  const FrictionCircle circle;
  for (const double step_s : {1e-2, 1e-3, 1e-4}) {
    const double r = circle.discrete_radius_m(step_s);
    const double half_rad = std::numbers::pi * circle.turns_per_s * step_s;
    const double rho2 = circle.radius_m * circle.radius_m;
    EXPECT_NEAR(r * r + 2 * circle.lag_m() * r * std::sin(half_rad),
                rho2 - circle.lag_m() * circle.lag_m(), 8 * 0x1p-52 * rho2);
  }
}

TEST(ServoIntegrator, HasTheOrdersOfItsMethods) {
  const KnobResult result = measured_servo("integrator");
  expect_orders(result);
  expect_levels_count(result);
  ASSERT_EQ(result.methods.size(), 2u);
  EXPECT_EQ(*result.methods[0].expected_order, 1.0);
  EXPECT_EQ(*result.methods[1].expected_order, 4.0);
  // The finest steps deviate by rounding alone, and only they are reported as at the floor.
  const LevelResult& finest = result.methods[1].levels.back();
  EXPECT_TRUE(finest.at_floor) << finest.raw_error;
  EXPECT_FALSE(result.methods[0].levels.back().at_floor);
}

// The result does not depend on how the time of a held force is divided, with or without damping.
TEST(MassDamper, MovesLikeTheExactSolution) {
  Random random(1612);
  for (int trial = 0; trial < 2000; ++trial) {
    const double mass = random.uniform(0.05, 0.5);
    const double damping = trial % 4 == 0 ? 0.0 : std::pow(10.0, random.uniform(-6.0, 3.0));
    const Vec3 force_N = random.in_box(5.0);
    const Vec3 start_m_per_s = random.in_box(0.5);
    const double time_s = std::pow(10.0, random.uniform(-5.0, 0.0));
    MassDamper whole(mass, damping);
    MassDamper cut(mass, damping);
    whole.put(Vec3::Zero(), start_m_per_s);
    cut.put(Vec3::Zero(), start_m_per_s);
    whole.advance(force_N, time_s);
    for (int i = 0; i < 16; ++i) cut.advance(force_N, time_s / 16);
    const double far_m = start_m_per_s.norm() * time_s + force_N.norm() / mass * time_s * time_s;
    EXPECT_LE((whole.position_m() - cut.position_m()).norm(), 64 * 0x1p-52 * far_m);
    // m (v - v0) = f t - b x.
    const Vec3 momentum = mass * (whole.velocity_m_per_s() - start_m_per_s);
    const Vec3 impulse = force_N * time_s - damping * whole.position_m();
    EXPECT_LE((momentum - impulse).norm(),
              64 * 0x1p-52 * (momentum.norm() + force_N.norm() * time_s + mass * 0.9));
  }
}

}  // namespace
}  // namespace palpate
