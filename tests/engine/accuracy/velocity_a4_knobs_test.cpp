// The knobs of the velocity window and of the elementary rotation, measured as in the report and
// compared with theory.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/flat_sheet.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/measurement.h"
#include "tests/engine/accuracy/measured_knobs.h"

namespace palpate {
namespace {

using test::kEffort;
using test::kOrderTolerance;
using test::measured;

// Numbers of the workloads.
constexpr double kTick_s = 1e-3;
constexpr double kQuantum_m = 20e-6;
constexpr double kAcceleration_m_per_s2 = 0.5;

// Scatter of an rms over 500 ticks with nearly independent errors: at most 3 % in the median of 21.
// A sheet whose normal is along an axis does not involve the two other encoders.
constexpr double kNoiseScatter = 0.05;

// Fitted lines are correlated over their window: 500 / w of them are independent, and their rms
// scatters by 1 / sqrt(2 * 500 / w). Two deviations of the median of 21 repeats, which
// scatters 1.25 times as much as the mean.
double line_fit_scatter(double w) {
  const double one_repeat = 1.0 / std::sqrt(2.0 * 500.0 / w);
  return kNoiseScatter + 2.0 * 1.25 * one_repeat / std::sqrt(1.0 * MeasurementEffort::kRepeats);
}

// Every repeat of every level and preset counts, and fitted orders agree with theory.
void expect_sound(const KnobResult& result) {
  for (const MethodResult& m : result.methods) {
    std::size_t above_floor = 0;
    for (const LevelResult& level : m.levels) {
      EXPECT_TRUE(level.counts()) << m.name << ", " << level.label << ": " << level.failure;
      EXPECT_EQ(level.repeats, MeasurementEffort::kRepeats);
      EXPECT_GT(level.time.median, 0.0);
      above_floor += !level.at_floor;
    }
    if (!m.expected_order) continue;
    EXPECT_GE(above_floor, 4u) << m.name;
    ASSERT_TRUE(m.order) << m.name;
    EXPECT_NEAR(*m.order, *m.expected_order, kOrderTolerance) << m.name;
  }
  for (const LevelResult& preset : result.presets) {
    EXPECT_TRUE(preset.counts()) << preset.label << ": " << preset.failure;
  }
}

// On one flat face all presets act like the default.
void expect_presets_alike(const KnobResult& result, double tolerance) {
  const Knob& knob = result.knob;
  const LevelResult& plain = result.methods[knob.default_method].levels[knob.default_level];
  for (const LevelResult& preset : result.presets) {
    EXPECT_NEAR(preset.error.median, plain.error.median, tolerance) << preset.label;
  }
}

double difference_noise_m_per_s(double w) {
  return kQuantum_m / (std::sqrt(6.0) * w * kTick_s);
}
double line_fit_noise_m_per_s(double w) {
  return kQuantum_m / (kTick_s * std::sqrt(w * (w + 1.0) * (w + 2.0)));
}

TEST(VelocityKnobs, NoiseFallsWithTheWindowByTheFormulas) {
  const KnobResult result = measured(velocity_knobs(kEffort), "velocity_noise");
  expect_sound(result);
  expect_presets_alike(result, kNoiseScatter * difference_noise_m_per_s(1.0));
  const MethodResult& difference = test::method_of(result, "difference");
  EXPECT_EQ(difference.expected_order, -1.0);
  ASSERT_EQ(difference.levels.size(), 6u);
  for (const LevelResult& level : difference.levels) {
    const double expected = difference_noise_m_per_s(level.value);
    EXPECT_NEAR(level.error.median, expected, kNoiseScatter * expected) << level.label;
  }
  const MethodResult& line_fit = test::method_of(result, "line fit");
  ASSERT_EQ(line_fit.levels.size(), 5u);
  for (const LevelResult& level : line_fit.levels) {
    const double expected = line_fit_noise_m_per_s(level.value);
    EXPECT_NEAR(level.error.median, expected, line_fit_scatter(level.value) * expected)
        << level.label;
  }
  // At most the noise of a single tick, at least that of the whole window.
  for (const LevelResult& level : test::method_of(result, "adaptive").levels) {
    EXPECT_LT(level.error.median, difference.levels.front().error.median) << level.label;
    EXPECT_GT(level.error.median, difference_noise_m_per_s(level.value)) << level.label;
  }
}

TEST(VelocityKnobs, LagGrowsWithTheWindowByTheFormula) {
  const KnobResult result = measured(velocity_knobs(kEffort), "velocity_lag");
  expect_sound(result);
  // The proxy is anywhere within its stand-off, in a scene of at most the diagonal of the sheet.
  const double tolerance =
      2.0 * SolverScale::of(std::sqrt(2.0) * kSheetSize_m, 0.0).stand_off_m / kTick_s;
  expect_presets_alike(result, tolerance);
  for (const char* name : {"difference", "line fit"}) {
    const MethodResult& m = test::method_of(result, name);
    EXPECT_EQ(m.expected_order, 1.0);
    for (const LevelResult& level : m.levels) {
      EXPECT_NEAR(level.error.median, kAcceleration_m_per_s2 * level.value * kTick_s / 2, tolerance)
          << name << ", " << level.label;
    }
  }
  // The window s grows while its bend a s^2 / 8 is within half a quantum on each axis. The largest
  // component of the bend is at least 1/sqrt(3) of it, so s is between these two, less a tick.
  const double short_s = std::sqrt(4.0 * kQuantum_m / kAcceleration_m_per_s2);
  const double long_s = short_s * std::pow(3.0, 0.25);
  const MethodResult& adaptive = test::method_of(result, "adaptive");
  const double most_lag = adaptive.levels.back().error.median;
  EXPECT_GE(most_lag, kAcceleration_m_per_s2 * (short_s - kTick_s) / 2);
  EXPECT_LE(most_lag, kAcceleration_m_per_s2 * long_s / 2);
}

TEST(VelocityKnobs, TotalErrorIsLeastInBetween) {
  const KnobResult result = measured(velocity_knobs(kEffort), "velocity_total");
  expect_sound(result);
  constexpr double kRmsAcceleration_m_per_s2 = 10e-3 * 157.91367 / 1.41421356;  // (4 pi)^2, sqrt(2)
  for (const char* name : {"difference", "line fit"}) {
    const MethodResult& m = test::method_of(result, name);
    const bool fits = m.name == "line fit";
    for (const LevelResult& level : m.levels) {
      const double noise =
          fits ? line_fit_noise_m_per_s(level.value) : difference_noise_m_per_s(level.value);
      const double lag = kRmsAcceleration_m_per_s2 * level.value * kTick_s / 2;
      const double expected = std::hypot(noise, lag);
      EXPECT_NEAR(level.error.median, expected, kNoiseScatter * expected)
          << name << ", " << level.label;
    }
  }
  const std::vector<LevelResult>& levels = test::method_of(result, "difference").levels;
  const auto least = std::min_element(
      levels.begin(), levels.end(),
      [](const auto& a, const auto& b) { return a.error.median < b.error.median; });
  EXPECT_EQ(least->label, "4 ticks");
  EXPECT_GT(levels.front().error.median, 2.0 * least->error.median);
  EXPECT_GT(levels.back().error.median, 2.0 * least->error.median);
}

TEST(VelocityKnobs, ARepeatIsDeterministic) {
  for (const Knob& knob : velocity_knobs(kEffort)) {
    const Level& level = knob.methods.back().levels.back();
    EXPECT_EQ(level.run(7).error, level.run(7).error) << knob.name;
    EXPECT_NE(level.run(7).error, level.run(8).error) << knob.name;
  }
}

// Explicit Euler passes the part of the profile below the knee with a rate of -ln(1 - k dt) / dt
// instead of k, so it is early by dt / 2 ln(S(30) / S(1)), to first order in dt.
TEST(A4Knobs, SpeedByDtIsEarlyByHalfATickTimesALogarithm) {
  const KnobResult result = measured(a4_knobs(kEffort), "a4_step");
  expect_sound(result);
  const MethodResult& paper = test::method_of(result, "speed times dt (paper)");
  EXPECT_EQ(paper.expected_order, 1.0);
  ASSERT_EQ(paper.levels.size(), 8u);
  for (const LevelResult& level : paper.levels) {
    const double first_order_s = level.value / 2 * std::log(90.0 / (5.0 + 85.0 / 30.0));
    // The next order is k dt times as large, about: k = 17/6 a second.
    EXPECT_NEAR(level.error.median, first_order_s, 17.0 / 6.0 * level.value * first_order_s)
        << level.label;
  }
  const LevelResult& at_1_kHz = paper.levels[4];
  EXPECT_EQ(at_1_kHz.label, "1 kHz");
  EXPECT_NEAR(at_1_kHz.error.median, 1.22e-3, 0.01e-3);
}

TEST(A4Knobs, TheExactSolutionIsAtTheRoundOffAtAnyRate) {
  const KnobResult result = measured(a4_knobs(kEffort), "a4_step");
  const MethodResult& exact = test::method_of(result, "exact solution");
  EXPECT_FALSE(exact.expected_order);
  EXPECT_GT(exact.floor, 0.0);
  EXPECT_LT(exact.floor, 1e-9);
  for (const LevelResult& level : exact.levels) {
    EXPECT_TRUE(level.at_floor) << level.label << ": " << level.raw_error;
    EXPECT_EQ(level.error.median, exact.floor);
  }
  expect_presets_alike(result, 0.0);
  EXPECT_EQ(exact.levels[result.knob.default_level].label, "1 kHz");
  EXPECT_EQ(result.methods[result.knob.default_method].name, exact.name);
}

}  // namespace
}  // namespace palpate
