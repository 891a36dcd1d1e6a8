// The decision between measured levels, on results that are made up.

#include "engine/accuracy/recommendation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/random.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

struct Figures {
  double time;
  double error;
  double spread = 0.0;  // the quartiles lie this part to either side of the median
};

LevelResult level_with(const Figures& f, const std::string& label) {
  LevelResult level;
  level.label = label;
  level.repeats = MeasurementEffort::kRepeats;
  level.time = {f.time * (1.0 - f.spread), f.time, f.time * (1.0 + f.spread)};
  level.error = {f.error * (1.0 - f.spread), f.error, f.error * (1.0 + f.spread)};
  level.raw_error = f.error;
  return level;
}

// One method, judged.
KnobResult knob_with(const std::vector<Figures>& levels, std::size_t usual, double enough) {
  KnobResult result;
  result.knob.default_level = usual;
  result.knob.enough = enough;
  MethodResult method{"method", {}, {}, {}, 0.0};
  for (const Figures& f : levels) {
    method.levels.push_back(level_with(f, std::to_string(method.levels.size())));
  }
  result.methods.push_back(std::move(method));
  judge(result);
  return result;
}

std::size_t recommended_level(const KnobResult& result) {
  EXPECT_TRUE(result.recommended.has_value());
  return result.recommended ? result.recommended->level : 1000;
}

TEST(Recommendation, FiguresAreAlikeWithinTheirSpread) {
  EXPECT_TRUE(is_alike({90, 100, 110}, {109, 130, 150})) << "the quartiles overlap";
  EXPECT_FALSE(is_alike({90, 100, 110}, {120, 130, 140}));
  EXPECT_TRUE(is_alike({100, 100, 100}, {114, 114, 114})) << "from one run to the next";
  EXPECT_FALSE(is_alike({100, 100, 100}, {116, 116, 116}));
  EXPECT_TRUE(is_alike({0, 0, 0}, {0, 0, 0}));
  EXPECT_FALSE(is_alike({0, 0, 0}, {1e-300, 1e-300, 1e-300}));
}

TEST(Recommendation, TheDefaultWinsATie) {
  const std::vector<Figures> levels{{100, 1e-6}, {104, 0.95e-6}, {98, 1.02e-6}};
  for (std::size_t usual = 0; usual < levels.size(); ++usual) {
    const KnobResult result = knob_with(levels, usual, 1e-5);
    EXPECT_EQ(recommended_level(result), usual);
    EXPECT_TRUE(result.default_is_on_front());
    EXPECT_TRUE(result.methods[0].levels[usual].on_front) << "the default wins the Pareto tie";
  }
}

TEST(Recommendation, TheDefaultLosesWhereALevelDiffersBeyondTheSpread) {
  EXPECT_EQ(recommended_level(knob_with({{100, 1e-6, 0.02}, {150, 1e-6, 0.02}}, 1, 1e-5)), 0u)
      << "clearly quicker";
  EXPECT_EQ(recommended_level(knob_with({{100, 1e-6, 0.02}, {100, 2e-6, 0.02}}, 1, 1e-5)), 0u)
      << "clearly more accurate";
  EXPECT_EQ(recommended_level(knob_with({{100, 1e-6, 0.4}, {150, 1e-6, 0.4}}, 1, 1e-5)), 1u)
      << "the spread hides the difference";
}

TEST(Recommendation, WhiskersWiderThanTheEffectRecommendNothing) {
  // The default errs by more than enough, but its quartiles overlap those of the other level.
  const KnobResult hidden = knob_with({{100, 12e-6, 0.3}, {150, 8e-6, 0.3}}, 0, 1e-5);
  EXPECT_FALSE(hidden.recommended.has_value());
  EXPECT_EQ(hidden.undecided, (LevelPlace{0, 1}));
  for (const KnobResult& seen : {knob_with({{100, 12e-6, 0.1}, {150, 8e-6, 0.1}}, 0, 1e-5),
                                 knob_with({{200, 12e-6, 0.3}, {100, 8e-6, 0.3}}, 0, 1e-5)}) {
    EXPECT_EQ(recommended_level(seen), 1u) << "the effect on the error, or on the time, is larger";
    EXPECT_FALSE(seen.undecided.has_value());
  }
  const KnobResult usual = knob_with({{100, 12e-6, 0.3}, {150, 8e-6, 0.3}}, 1, 1e-5);
  EXPECT_EQ(recommended_level(usual), 1u) << "the default needs no effect";
  KnobResult failed = hidden;
  failed.methods[0].levels[0].failures = 1;
  judge(failed);
  EXPECT_EQ(recommended_level(failed), 1u) << "instead of a default that fails";
  EXPECT_FALSE(failed.undecided.has_value());
}

TEST(Recommendation, QuartilesThatTouchDoNotLieBelow) {
  EXPECT_TRUE(is_below({1, 2, 3}, {3.1, 4, 5}));
  EXPECT_FALSE(is_below({1, 2, 3}, {3, 4, 5}));
  EXPECT_FALSE(is_below({3.1, 4, 5}, {1, 2, 3}));
  EXPECT_FALSE(is_below({0, 0, 0}, {0, 0, 0}));
}

TEST(Recommendation, OfTiesWithoutTheDefaultTheNearestToItWins) {
  // The default is too coarse; levels 2 to 4 are alike.
  const std::vector<Figures> levels{{100, 1e-3}, {100, 1e-4}, {100, 1e-6}, {102, 1e-6}, {99, 1e-6}};
  EXPECT_EQ(recommended_level(knob_with(levels, 0, 1e-5)), 2u);
  EXPECT_EQ(recommended_level(knob_with(levels, 1, 1e-5)), 2u);
  KnobResult two = knob_with({{100, 1e-3}, {100, 1e-6}}, 0, 1e-5);
  two.methods.insert(two.methods.begin(), two.methods[0]);
  two.knob.default_method = 1;
  judge(two);
  EXPECT_EQ(two.recommended->method, 1u) << "the method of the default";
}

// A ladder like those of the report: errors fall by a power, times rise or stay.
std::vector<Figures> random_ladder(Random& random) {
  std::vector<Figures> levels;
  const double ratio = random.uniform(0.05, 0.9);
  const double growth = random.index(2) == 0 ? 1.0 : random.uniform(1.0, 2.0);
  double error = 1.0;
  double time = 100.0;
  for (int i = 0; i < 8; ++i) {
    levels.push_back({time * random.uniform(0.97, 1.03), error * random.uniform(0.97, 1.03), 0.05});
    error *= ratio;
    time *= growth;
  }
  return levels;
}

TEST(Recommendation, ADefaultWithTenTimesTheErrorIsNotRecommended) {
  Random random(1701);
  int checked = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const std::vector<Figures> levels = random_ladder(random);
    const double enough = std::pow(10.0, random.uniform(-5.0, 1.0));
    const KnobResult judged = knob_with(levels, 0, enough);
    if (judged.undecided) continue;  // levels 0 and 1 of a flat ladder
    const std::size_t best = recommended_level(judged);
    for (std::size_t worse = 0; worse < levels.size(); ++worse) {
      if (levels[worse].error < 10.0 * levels[best].error) continue;
      ++checked;
      const KnobResult result = knob_with(levels, worse, enough);
      EXPECT_NE(recommended_level(result), worse) << trial;
    }
    // Made worse on purpose: the level recommended, with ten times the error and the same time.
    std::vector<Figures> spoilt = levels;
    spoilt.push_back({levels[best].time, 10.0 * levels[best].error, 0.05});
    EXPECT_NE(recommended_level(knob_with(spoilt, spoilt.size() - 1, enough)), spoilt.size() - 1)
        << trial;
  }
  EXPECT_GT(checked, 1000);
}

TEST(Recommendation, ALevelThatFailedIsNotRecommended) {
  KnobResult result = knob_with({{100, 1e-6}, {200, 1e-6}}, 0, 1e-5);
  result.methods[0].levels[0].failures = 1;
  judge(result);
  EXPECT_EQ(recommended_level(result), 1u);
  result.methods[0].levels[1].failures = 1;
  judge(result);
  EXPECT_FALSE(result.recommended.has_value());
}

// ---- seeds -------------------------------------------------------------------------------------

// Samples scatter by a few per cent, times by more.
Level noisy(double value, double time, double error) {
  return {value, std::to_string(value), [=](std::uint64_t seed) {
            SeededRandom random(seed * 7919 + static_cast<std::uint64_t>(1e6 * value));
            return Sample{error * std::exp(0.05 * random.normal()),
                          time * std::exp(0.10 * random.normal()), 1.0, 1, ""};
          }};
}

Knob noisy_knob(std::vector<Method> methods, std::size_t usual, double enough) {
  Knob knob;
  knob.methods = std::move(methods);
  knob.default_level = usual;
  knob.enough = enough;
  knob.run_preset = [](std::uint64_t, const Accuracy&) { return Sample{1.0, 1.0, 1.0, 1, ""}; };
  return knob;
}

TEST(Recommendation, FiveSeedsRecommendTheSameLevel) {
  Method mesh{"mesh", {}}, flat{"flat", {}}, difference{"difference", {}}, line{"line fit", {}};
  for (int n = 0; n < 6; ++n) {
    mesh.levels.push_back(noisy(n, 200.0 * std::pow(1.4, n), 1e-3 * std::pow(0.25, n)));
    flat.levels.push_back(noisy(n, 300.0, n < 3 ? 1e-3 * std::pow(0.1, n) : 1e-6));
    const double ticks = std::exp2(n);
    difference.levels.push_back(noisy(n, 316.0, std::hypot(8.2e-3 / ticks, 0.56e-3 * ticks)));
    line.levels.push_back(noisy(n + 100, 325.0, std::hypot(7.8e-3 / ticks, 0.56e-3 * ticks)));
  }
  struct Case {
    Knob knob;
    LevelPlace expected;
  };
  const std::vector<Case> cases{{noisy_knob({mesh}, 2, 1e-5), {0, 4}},
                                {noisy_knob({flat}, 4, 1e-5), {0, 4}},
                                {noisy_knob({flat}, 0, 1e-5), {0, 3}},
                                {noisy_knob({difference, line}, 0, 5e-3), {0, 2}}};
  for (const Case& c : cases) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const KnobResult result = measure(c.knob, {.quick = true, .seed = seed}, nullptr);
      ASSERT_TRUE(result.recommended.has_value());
      EXPECT_EQ(*result.recommended, c.expected)
          << "seed " << seed << ": " << result.recommended->method << ", "
          << result.recommended->level << " instead of " << c.expected.level;
    }
  }
}

// ---- knobs that measure a part -----------------------------------------------------------------

TEST(Recommendation, AKnobThatMeasuresAPartFollowsTheDecidingKnob) {
  KnobResult total = knob_with({{100, 8e-3}, {100, 3e-3}, {100, 2e-2}}, 0, 5e-3);
  total.knob.name = "total";
  total.knob.title = "Noise and lag";
  KnobResult noise = knob_with({{100, 8e-3}, {100, 2e-3}, {100, 1e-4}}, 0, 5e-3);
  noise.knob.decided_by = "total";
  EXPECT_EQ(recommended_level(noise), 2u);
  std::vector<KnobResult> results{noise, total};
  reconcile(results);
  EXPECT_EQ(recommended_level(results[0]), 1u);
  EXPECT_EQ(results[0].decided_by_title, "Noise and lag");
  EXPECT_EQ(recommended_level(results[1]), 1u);
  // Also where the deciding knob recommends nothing.
  results[1].undecided = std::exchange(results[1].recommended, std::nullopt);
  reconcile(results);
  EXPECT_FALSE(results[0].recommended.has_value());
  EXPECT_EQ(results[0].undecided, (LevelPlace{0, 1}));
  // Without the deciding knob, or with other levels, the recommendation stays.
  results = {noise};
  reconcile(results);
  EXPECT_EQ(recommended_level(results[0]), 2u);
  total.methods[0].levels.pop_back();
  results = {noise, total};
  reconcile(results);
  EXPECT_EQ(recommended_level(results[0]), 2u);
  EXPECT_EQ(results[0].decided_by_title, "");
}

}  // namespace
}  // namespace palpate
