// Medians, orders, fronts and verdicts of knobs with known samples.

#include "engine/accuracy/measurement.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

Level level(double value, Sample sample) {
  if (sample.ticks == 0) sample.ticks = 1;
  return {value, std::to_string(value), [sample](std::uint64_t) { return sample; }};
}

Sample sample(double time, double error) {
  return {error, time, 1.0, 1, ""};
}

Knob knob(std::vector<Method> methods) {
  Knob k;
  k.methods = std::move(methods);
  k.run_preset = [](std::uint64_t, const Accuracy& preset) {
    return sample(preset.iterations, 1.0 / preset.iterations);
  };
  return k;
}

KnobResult measured(const Knob& k) {
  return measure(k, {}, nullptr);
}

TEST(Spread, IsMedianAndQuartiles) {
  const Spread odd = Spread::of({5.0, 1.0, 4.0, 2.0, 3.0});
  EXPECT_EQ(odd.low, 2.0);
  EXPECT_EQ(odd.median, 3.0);
  EXPECT_EQ(odd.high, 4.0);
  const Spread even = Spread::of({4.0, 1.0, 3.0, 2.0});
  EXPECT_EQ(even.median, 2.5);
  EXPECT_EQ(Spread::of({}).median, 0.0);
}

TEST(FittedOrder, IsTheExponentOfAPowerLaw) {
  test::Random random(601);
  for (int n = 0; n < 100; ++n) {
    const double order = random.uniform(-3.0, 3.0);
    const double factor = std::pow(10.0, random.uniform(-9.0, 3.0));
    std::vector<LevelResult> levels(5);
    for (LevelResult& l : levels) {
      l.value = std::pow(10.0, random.uniform(-4.0, 4.0));
      l.error.median = factor * std::pow(l.value, order);
    }
    ASSERT_NEAR(fitted_order(levels).value(), order, 1e-9);
  }
}

TEST(FittedOrder, IgnoresFailedLevelsAndLevelsAtTheFloor) {
  std::vector<LevelResult> levels(6);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i].value = std::exp2(static_cast<double>(i));
    levels[i].error.median = std::exp2(2.0 * static_cast<double>(i));
  }
  levels[1].failures = 1;
  levels[1].error.median = 1e9;
  levels[0].at_floor = true;
  levels[0].error.median = 1e9;
  EXPECT_NEAR(fitted_order(levels).value(), 2.0, 1e-12);
  levels[2].failures = 3;
  EXPECT_FALSE(fitted_order(levels).has_value()) << "three levels are too few";
}

TEST(FittedOrder, IsAbsentWithoutAPowerLaw) {
  std::vector<LevelResult> levels(7);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double x = std::exp2(static_cast<double>(i));
    levels[i].value = x;
    levels[i].error.median = 8.0 / x + x / 8.0;  // noise and lag
  }
  EXPECT_FALSE(fitted_order(levels).has_value());
}

TEST(Measure, RepeatsEveryLevelWithTheSameSeeds) {
  std::vector<std::vector<std::uint64_t>> seeds(2);
  Method method{"m", {}};
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    method.levels.push_back({1.0, "", [&seeds, i](std::uint64_t seed) {
                               seeds[i].push_back(seed);
                               return sample(1.0, static_cast<double>(seed));
                             }});
  }
  MeasurementEffort effort;
  effort.seed = 40;
  const KnobResult result = measure(knob({method}), effort, nullptr);
  ASSERT_EQ(seeds[0].size(), MeasurementEffort::kRepeats + 1u)
      << "one run to warm up, which does not count";
  EXPECT_EQ(seeds[0], seeds[1]);
  EXPECT_EQ(seeds[0][1], 40u);
  EXPECT_EQ(result.methods[0].levels[0].repeats, MeasurementEffort::kRepeats);
  EXPECT_EQ(result.methods[0].levels[0].error.median, 50.0);
  EXPECT_EQ(result.methods[0].levels[0].error.low, 45.0);
  EXPECT_EQ(result.methods[0].levels[0].error.high, 55.0);
}

TEST(Measure, MeasuresOneLevelLikeAllLevels) {
  Method method{"m", {}, {}, 1e-3};
  method.levels.push_back({2.0, "two", [](std::uint64_t seed) {
                             return sample(1.0 + static_cast<double>(seed), 1e-4);
                           }});
  const Knob k = knob({method});
  const LevelResult alone = measure_level(k, {0, 0}, {});
  const LevelResult among = measured(k).methods[0].levels[0];
  EXPECT_EQ(alone.time.median, among.time.median);
  EXPECT_EQ(alone.error.median, 1e-3) << "the floor";
  EXPECT_EQ(alone.raw_error, 1e-4);
  EXPECT_TRUE(alone.at_floor);
  EXPECT_EQ(alone.label, "two");
}

TEST(Measure, ListsFailuresAndExcludesThem) {
  Method method{"m", {}};
  method.levels.push_back(level(1.0, {0.0, 1.0, 0.0, 1, "unstable: it flew away"}));
  method.levels.push_back(level(2.0, sample(5.0, 0.1)));
  Sample no_number = sample(1.0, std::nan(""));
  method.levels.push_back(level(3.0, no_number));
  const KnobResult result = measured(knob({method}));
  EXPECT_EQ(result.methods[0].levels[0].failures, MeasurementEffort::kRepeats);
  EXPECT_EQ(result.methods[0].levels[0].failure, "unstable: it flew away");
  EXPECT_EQ(result.methods[0].levels[2].failure, "not finite");
  EXPECT_FALSE(result.methods[0].levels[0].on_front);
  EXPECT_TRUE(result.methods[0].levels[1].on_front);
  ASSERT_TRUE(result.recommended.has_value());
  EXPECT_EQ(result.recommended->level, 1u);
  EXPECT_FALSE(result.default_is_on_front()) << "the default failed";
}

TEST(Measure, ReportsALevelWithoutContactAsAFailure) {
  Method method{"m", {}};
  Level empty = level(1.0, {});
  empty.run = [](std::uint64_t) { return Sample{}; };
  method.levels.push_back(empty);
  EXPECT_EQ(measured(knob({method})).methods[0].levels[0].failure, "no tick in contact");
}

// Times 1 2 3, errors 3 1 2: the third is beaten by the second in both.
TEST(Measure, FindsTheParetoFront) {
  const Method a{"a", {level(1.0, sample(1.0, 3.0)), level(2.0, sample(2.0, 1.0))}};
  const Method b{"b", {level(1.0, sample(3.0, 2.0)), level(2.0, sample(2.0, 1.0))}};
  Knob k = knob({a, b});
  KnobResult result = measured(k);
  EXPECT_TRUE(result.methods[0].levels[0].on_front);
  EXPECT_TRUE(result.methods[0].levels[1].on_front);
  EXPECT_FALSE(result.methods[1].levels[0].on_front);
  EXPECT_TRUE(result.methods[1].levels[1].on_front) << "equal to a level on the front";
  k.levels_are_given = true;  // 1.0 against 3.0, and 2.0 against 2.0
  result = measured(k);
  EXPECT_TRUE(result.methods[0].levels[0].on_front) << "quicker, if less exact";
  EXPECT_TRUE(result.methods[1].levels[0].on_front) << "more exact";
  k.levels_are_given = false;
  k.methods_are_given = true;
  result = measured(k);
  EXPECT_FALSE(result.methods[1].levels[0].on_front);
}

TEST(Measure, StatesHowFarTheDefaultIsBehind) {
  Knob k = knob({{"a",
                  {level(1.0, sample(10.0, 1.0)), level(2.0, sample(5.0, 1.0)),
                   level(3.0, sample(9.0, 0.1)), level(4.0, sample(1.0, 2.0))}}});
  KnobResult result = measured(k);
  EXPECT_EQ(result.default_behind, 10.0) << "the error of the third";
  EXPECT_FALSE(result.default_is_on_front());
  k.default_level = 3;
  result = measured(k);
  EXPECT_EQ(result.default_behind, 1.0);
  EXPECT_TRUE(result.default_is_on_front());
}

TEST(Measure, RecommendsTheQuickestLevelWithASufficientError) {
  Knob k = knob({{"a",
                  {level(1.0, sample(1.0, 1.0)), level(2.0, sample(2.0, 0.1)),
                   level(3.0, sample(3.0, 0.01))}}});
  k.enough = 0.2;
  EXPECT_EQ(measured(k).recommended->level, 1u);
  k.enough = 1e-6;
  EXPECT_EQ(measured(k).recommended->level, 2u) << "no error is small enough: the most exact";
  // The times are alike: the smaller error wins.
  Knob tie = knob({{"a",
                    {level(1.0, sample(9.0, 0.0)), level(2.0, sample(1.0, 0.1)),
                     level(3.0, sample(1.01, 0.01))}}});
  tie.enough = 0.2;
  EXPECT_EQ(measured(tie).recommended->level, 2u);
  // A tie: the default wins.
  Knob close = knob({{"a", {level(1.0, sample(1.0, 0.1)), level(2.0, sample(1.05, 0.1))}}});
  close.enough = 1.0;
  close.default_level = 1;
  EXPECT_EQ(measured(close).recommended->level, 1u);
}

TEST(Measure, RunsThePresets) {
  const KnobResult result = measured(knob({{"a", {level(1.0, sample(1.0, 1.0))}}}));
  EXPECT_EQ(result.presets[0].time.median, Accuracy::fast().iterations);
  EXPECT_EQ(result.presets[1].time.median, Accuracy::balanced().iterations);
  EXPECT_EQ(result.presets[2].time.median, Accuracy::exact().iterations);
  EXPECT_EQ(result.presets[2].label, "exact");
}

}  // namespace
}  // namespace palpate
