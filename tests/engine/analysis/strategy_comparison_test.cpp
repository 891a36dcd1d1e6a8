// Means, paired differences, ranks and tuning of strategies, against tables computed by hand; and
// the measures of a trial that only comparisons need.

#include "engine/analysis/strategy_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/analysis/intervals.h"
#include "engine/analysis/strategy_text.h"
#include "engine/trials/strategy_measures.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// Student's t with P(|T| > t) = 0.05, in closed form: with one degree of freedom T is Cauchy, so
// t = tan(0.475 pi); with two, t = p sqrt(2 / (1 - p^2)) with p = 0.95.
const double kT1 = std::tan(0.475 * std::numbers::pi);
const double kT2 = 0.95 * std::sqrt(2.0 / (1.0 - 0.95 * 0.95));

// Rounding of a handful of operations on numbers of this size, and of Boost's quantile.
void expect_near(double value, double expected) {
  EXPECT_NEAR(value, expected, 1e-12 * std::abs(expected)) << expected;
}

TEST(MeanInterval, IsStudentsInterval) {
  const MeanInterval two = mean_interval(std::array{1.0, 3.0});
  EXPECT_EQ(two.mean, 2.0);
  EXPECT_EQ(two.count, 2);
  expect_near(two.half_width, kT1);  // sd sqrt(2), over sqrt(2)
  const MeanInterval three = mean_interval(std::array{2.0, 4.0, 9.0});
  EXPECT_EQ(three.mean, 5.0);
  expect_near(three.half_width, kT2 * std::sqrt(13.0 / 3.0));  // sd^2 = (9 + 1 + 16) / 2
}

TEST(MeanInterval, HoldsZeroUnlessTheMeanIsFartherFromZeroThanHalfOfIt) {
  EXPECT_FALSE(mean_interval(std::array{-1.0, 2.0, 1.0}).excludes_zero());
  EXPECT_TRUE(mean_interval(std::array{-1.0, -1.0, -1.5}).excludes_zero());
  EXPECT_FALSE(mean_interval(std::array{0.0, 0.0}).excludes_zero());
  EXPECT_TRUE(mean_interval(std::array{1.0, 1.0}).excludes_zero());
  EXPECT_FALSE(mean_interval(std::array{1.0}).excludes_zero()) << "one value has no interval";
  EXPECT_FALSE(mean_interval(std::span<const double>()).excludes_zero());
  EXPECT_EQ(mean_interval(std::span<const double>()).count, 0);
}

// A completed trial with this contact angle; other measures have no value.
TrialRow trial(const std::string& strategy, int hand, const std::string& scene, double angle_deg) {
  TrialRow row;
  row.following = "delayed";
  row.participant = std::to_string(hand);
  row.block = 1;
  row.trial = 1;
  row.object = scene;
  row.strategy = strategy;
  row.measures[kContactAngle] = angle_deg;
  return row;
}

// Angles of three hands on the scenes A and B: none 9 everywhere.
std::vector<TrialRow> small_trials() {
  struct Angles {
    const char* strategy;
    std::array<double, 3> a, b;
  };
  std::vector<TrialRow> rows;
  for (const Angles& angles :
       {Angles{"none", {9, 9, 9}, {9, 9, 9}}, Angles{"mask", {40, 42, 44}, {50, 52, 54}},
        Angles{"a4", {10, 14, 15}, {20, 22, 27}}, Angles{"cd", {12, 16, 11}, {22, 20, 21}}}) {
    for (int hand = 1; hand <= 3; ++hand) {
      const auto place = static_cast<std::size_t>(hand - 1);
      rows.push_back(trial(angles.strategy, hand, "A", angles.a[place]));
      rows.push_back(trial(angles.strategy, hand, "B", angles.b[place]));
    }
  }
  return rows;
}

const ComparedStrategies kSmall = {{"none", "mask", "a4", "cd"}, {}, {"A", "B"}};

const MeasureComparison& by_angle(const SceneComparison& scene) {
  EXPECT_EQ(scene.measures.front().measure->column, "mean_contact_angle_deg");
  return scene.measures.front();
}

const MeasureComparison& by_column(const SceneComparison& scene, const std::string& column) {
  for (const MeasureComparison& comparison : scene.measures) {
    if (comparison.measure->column == column) return comparison;
  }
  ADD_FAILURE() << column;
  return scene.measures.front();
}

TEST(StrategyComparison, GivesTheMeansAndPairedDifferencesComputedByHand) {
  const FollowingComparison all = compare_strategies(small_trials(), {}, kSmall, "delayed");
  EXPECT_EQ(all.hands, 3);
  ASSERT_EQ(all.scenes.size(), 3u);
  const auto& entries = by_angle(all.scenes[0]).entries;
  ASSERT_EQ(entries.size(), 4u);
  // Means of hands: mask 45, 47, 49; a4 15, 18, 21; cd 17, 18, 16.
  EXPECT_EQ(entries[1].mean.mean, 47.0);
  expect_near(entries[1].mean.half_width, kT2 * 2.0 / std::sqrt(3.0));
  EXPECT_EQ(entries[2].mean.mean, 18.0);
  expect_near(entries[2].mean.half_width, kT2 * 3.0 / std::sqrt(3.0));
  EXPECT_EQ(entries[3].mean.mean, 17.0);
  // a4 - mask: -30, -29, -28. cd - a4: 2, 0, -5. a4 - a4 does not exist.
  ASSERT_TRUE(entries[2].minus_mask && entries[3].minus_a4);
  EXPECT_EQ(entries[2].minus_mask->mean, -29.0);
  expect_near(entries[2].minus_mask->half_width, kT2 / std::sqrt(3.0));
  EXPECT_EQ(entries[3].minus_a4->mean, -1.0);
  expect_near(entries[3].minus_a4->half_width, kT2 * std::sqrt(13.0 / 3.0));
  EXPECT_FALSE(entries[2].minus_a4 || entries[1].minus_mask);
  // Scene B alone: a4 - mask is -30, -30, -27.
  EXPECT_EQ(all.scenes[2].scene, "B");
  EXPECT_EQ(by_angle(all.scenes[2]).entries[2].minus_mask->mean, -29.0);
  expect_near(by_angle(all.scenes[2]).entries[2].minus_mask->half_width, kT2);
}

TEST(StrategyComparison, RanksTechniquesAndNoReference) {
  const FollowingComparison all = compare_strategies(small_trials(), {}, kSmall, "delayed");
  const MeasureComparison& angle = by_angle(all.scenes[0]);
  EXPECT_EQ(angle.entries[0].standing, Standing::kOther) << "none has 9 deg";
  EXPECT_EQ(angle.leaders(), (std::vector<std::string>{"cd", "a4"}));
  EXPECT_EQ(angle.entries[1].standing, Standing::kOther);
  EXPECT_FALSE(angle.is_tie_of_all());
  EXPECT_EQ(leaders_text(angle), "cd (tied: a4)");
  // Nobody has a time: no leader. Nobody has a timeout: a tie.
  EXPECT_EQ(leaders_text(by_column(all.scenes[0], "total_time_s")), "-");
  EXPECT_EQ(leaders_text(by_column(all.scenes[0], "status")), "tie of all");
}

TEST(StrategyComparison, A4LosesOnlyWhereTheIntervalIsOnTheBetterSide) {
  auto rows = small_trials();
  // Port work of hands: mask 1, 1, 2; a4 5, 5, 7; cd 4, 4, 9: a4 - cd is 1, 1, -2.
  const std::array<std::array<double, 3>, 3> port = {{{1, 1, 2}, {5, 5, 7}, {4, 4, 9}}};
  for (TrialRow& row : rows) {
    const auto hand = static_cast<std::size_t>(std::stoi(row.participant) - 1);
    if (row.strategy == "mask") row.measures[kPortWork] = 1e-3 * port[0][hand];
    if (row.strategy == "a4") row.measures[kPortWork] = 1e-3 * port[1][hand];
    if (row.strategy == "cd") row.measures[kPortWork] = 1e-3 * port[2][hand];
  }
  const FollowingComparison all = compare_strategies(rows, {}, kSmall, "delayed");
  const auto losses = losses_by_strategy(all, "+-");
  ASSERT_EQ(losses.size(), 2u);
  EXPECT_EQ(losses[0].strategy, "none");
  EXPECT_EQ(losses[0].role, StrategyRole::kReference);
  // 9 - 18 with sd 3: the half width is 4.3027 sqrt(3) = 7.45.
  EXPECT_EQ(losses[0].measures, std::vector<std::string>{"contact angle -9.00 +- 7.45 deg"});
  EXPECT_EQ(losses[1].strategy, "mask");
  // -4, -4, -5: mean -4.333, sd 1 / sqrt(3), half width 4.3027 / 3 = 1.43.
  EXPECT_EQ(losses[1].measures, std::vector<std::string>{"port work -4.33 +- 1.43 mJ"});
}

TEST(StrategyComparison, ComparesMagnitudesWhereZeroIsTheBest) {
  std::vector<TrialRow> rows;
  for (int hand = 1; hand <= 2; ++hand) {
    rows.push_back(trial("mask", hand, "A", 1.0));
    rows.push_back(trial("a4", hand, "A", 1.0));
    rows[rows.size() - 2].measures[kWorkLost] = -0.5;
    rows[rows.size() - 1].measures[kWorkLost] = 0.25;
  }
  const FollowingComparison all =
      compare_strategies(rows, {}, {{"mask", "a4"}, {}, {"A"}}, "delayed");
  ASSERT_EQ(all.scenes.size(), 1u) << "one scene is all scenes";
  const MeasureComparison& lost = by_column(all.scenes[0], "work_lost_J");
  EXPECT_EQ(lost.entries[0].mean.mean, 0.5);
  EXPECT_EQ(lost.leaders(), std::vector<std::string>{"a4"});
}

// Hand 1 did not complete B with a4, and hand 3 completed nothing with it.
TEST(StrategyComparison, PairsOnlyTrialsThatBothCompleted) {
  auto rows = small_trials();
  for (TrialRow& row : rows) {
    if (row.strategy != "a4") continue;
    if (row.participant == "1" && row.object == "B") row.status = TrialStatus::kTimeout;
    if (row.participant == "3") row.status = TrialStatus::kFault;
  }
  const FollowingComparison all = compare_strategies(rows, {}, kSmall, "delayed");
  const StrategyEntry& a4 = by_angle(all.scenes[0]).entries[2];
  EXPECT_EQ(a4.mean.count, 2);
  EXPECT_EQ(a4.mean.mean, 14.0);  // 10 and 18
  EXPECT_EQ(a4.minus_mask->count, 2);
  EXPECT_EQ(a4.minus_mask->mean, -29.5);  // 10 - 40; (14 - 42 + 22 - 52) / 2
  expect_near(a4.minus_mask->half_width, 0.5 * kT1);
  const StrategyCounts& counts = all.outcomes[2].counts;
  EXPECT_EQ(counts.trials, 6);
  EXPECT_EQ(counts.done, 3);
  EXPECT_EQ(counts.timeouts, 1);
  EXPECT_EQ(counts.faults, 2);
  EXPECT_EQ(all.incomplete(), std::vector<std::string>{"a4"});
  // Timeouts of hands: 1/2, 0, 0.
  expect_near(by_column(all.scenes[0], "status").entries[2].mean.mean, 0.5 / 3.0);
}

TEST(StrategyComparison, NinetyPercentOfTheTrialsAreEnough) {
  StrategyCounts counts{.trials = 80, .done = 72};
  EXPECT_TRUE(counts.is_comparable());
  counts.done = 71;
  EXPECT_FALSE(counts.is_comparable());
}

TEST(StrategyComparison, LeavesOutOtherFollowingsPracticeAndStrategies) {
  auto rows = small_trials();
  const FollowingComparison expected = compare_strategies(rows, {}, kSmall, "delayed");
  rows.push_back(trial("a4", 1, "A", 1000.0));
  rows.back().following = "predict";
  rows.push_back(trial("a4", 1, "A", 1000.0));
  rows.back().block = 0;
  rows.push_back(trial("full", 1, "A", 1000.0));
  const FollowingComparison all = compare_strategies(rows, {}, kSmall, "delayed");
  EXPECT_EQ(comparison_text(all), comparison_text(expected));
}

// E = 4 is best for the hands that tune, E = 1/2 for the hands that are compared.
TEST(StrategyComparison, TunesOnOtherHandsThanItCompares) {
  const std::vector<std::string> levels = {"anisotropic:0.5", "anisotropic:2", "anisotropic:4"};
  std::vector<TrialRow> rows, tuning;
  for (int hand = 1; hand <= 2; ++hand) {
    rows.push_back(trial("mask", hand, "A", 30.0 + hand));
    for (std::size_t i = 0; i < levels.size(); ++i) {
      rows.push_back(trial(levels[i], hand, "A", 10.0 + 5.0 * static_cast<double>(i)));
      tuning.push_back(trial(levels[i], hand, "A", 20.0 - 5.0 * static_cast<double>(i)));
    }
  }
  const FollowingComparison all =
      compare_strategies(rows, tuning, {{"mask"}, levels, {"A"}}, "delayed");
  const MeasureComparison& angle = by_angle(all.scenes[0]);
  ASSERT_EQ(angle.entries.size(), 5u);
  EXPECT_EQ(angle.entries[1].strategy, "anisotropic");
  EXPECT_EQ(angle.entries[1].tuned_to, "anisotropic:4");
  EXPECT_EQ(angle.entries[1].mean.mean, 20.0) << "of the compared hands";
  EXPECT_EQ(angle.leaders(), std::vector<std::string>{"anisotropic"});
  EXPECT_EQ(angle.entries[2].role, StrategyRole::kLevel);
  EXPECT_EQ(all.tuning[2].strategy, "anisotropic:4");
  EXPECT_TRUE(all.tuning[2].is_chosen);
  EXPECT_FALSE(all.tuning[0].is_chosen || all.tuning[1].is_chosen);
  // By timeouts, the levels are equal: 1/2 and 2 are equally near to 1, and 1/2 is the first.
  EXPECT_EQ(by_column(all.scenes[0], "status").entries[1].tuned_to, "anisotropic:0.5");
}

TEST(StrategyComparison, ALevelThatDidNotCompleteItsTuningIsNotChosen) {
  const std::vector<std::string> levels = {"anisotropic:2", "anisotropic:16"};
  std::vector<TrialRow> rows, tuning;
  for (int hand = 1; hand <= 4; ++hand) {
    for (const std::string& level : levels) {
      rows.push_back(trial(level, hand, "A", 20.0));
      tuning.push_back(trial(level, hand, "A", level == "anisotropic:16" ? 5.0 : 20.0));
    }
    if (hand == 1) rows.back().status = tuning.back().status = TrialStatus::kTimeout;
  }
  const FollowingComparison all = compare_strategies(rows, tuning, {{}, levels, {"A"}}, "delayed");
  EXPECT_EQ(by_angle(all.scenes[0]).entries[0].tuned_to, "anisotropic:2");
  EXPECT_TRUE(all.incomplete().empty()) << "no measure chose E = 16";
}

// The measures of a trial.

constexpr double kDt_s = 1e-3;

// A tick with a wall along y below the device, whose normal is y.
TickRecord tick(double x_m, double y_m, bool contact) {
  TickRecord record;
  record.device_m[0] = x_m;
  record.device_m[1] = y_m;
  record.contact = contact ? 1 : 0;
  if (contact) record.normal_scene[1] = 1.0;
  return record;
}

std::array<std::optional<double>, kMeasureCount> measured(const std::vector<TickRecord>& ticks) {
  StrategyMeasures measures(kDt_s);
  measures.begin(ticks.front());
  for (const TickRecord& record : ticks) measures.add(record);
  std::array<std::optional<double>, kMeasureCount> values;
  measures.put(values);
  return values;
}

TEST(StrategyMeasures, CountsWorkAlongTheWallOnlyWhereTheForcePushes) {
  std::vector<TickRecord> ticks = {tick(0, 0, true), tick(0.25, 0.5, true), tick(0, 0.5, true),
                                   tick(4, 4, false), tick(8, 8, true)};
  for (TickRecord& record : ticks) put(Vec3(2.0, 8.0, 0.0), record.force_device_N);
  // Along x: 2 * 0.25, then -2 * 0.25, which does not count, then 2 * 4; not after the loss.
  EXPECT_EQ(measured(ticks)[kWallWork], 0.5 + 8.0);
}

TEST(StrategyMeasures, TakesTheNormalInTheDeviceFrame) {
  std::vector<TickRecord> ticks = {tick(0, 0, true), tick(0.25, 0.5, true)};
  // The scene is turned by 180 deg about x and y: the normal y becomes x.
  const double h = std::sqrt(0.5);
  for (TickRecord& record : ticks) {
    put(Vec3(2.0, 8.0, 0.0), record.force_device_N);
    put(ScenePose{Quat(0.0, h, h, 0.0), Vec3::Zero()}, record.q_before_wxyz, record.o_before_m);
  }
  expect_near(*measured(ticks)[kWallWork], 8.0 * 0.5);
}

TEST(StrategyMeasures, TheLargestContactWorkIsOfOneContact) {
  std::vector<TickRecord> ticks = {tick(0, 0, true),   tick(0, 1, true), tick(0, 0.5, false),
                                   tick(0, 9, false),  tick(0, 0, true), tick(0, 0.25, true),
                                   tick(0, 0.5, false)};
  for (TickRecord& record : ticks) put(Vec3(0.0, 4.0, 0.0), record.force_device_N);
  // First contact: 4 * 1 - 4 * 0.5 = 2; free motion does not count; second: 4 * 0.5 = 2 up to here.
  EXPECT_EQ(measured(ticks)[kLargestContactWork], 2.0);
  ticks.push_back(tick(0, 0, true));
  put(Vec3(0.0, 4.0, 0.0), ticks.back().force_device_N);
  ticks.push_back(tick(0, 0.75, true));
  EXPECT_EQ(measured(ticks)[kLargestContactWork], 3.0) << "the last contact goes on";
  for (TickRecord& record : ticks) record.force_device_N[1] = -1.0;
  EXPECT_EQ(measured(ticks)[kLargestContactWork], -0.5) << "every contact took energy";
}

// Ticks of free motion; the scene turns in the first ones.
std::vector<TickRecord> turn(int turning, int still, bool touches) {
  std::vector<TickRecord> ticks;
  for (int i = 0; i < turning + still; ++i) {
    ticks.push_back(tick(0, 0, false));
    if (i < turning) ticks.back().rotation_rad = 0.01;
  }
  if (touches) ticks.push_back(tick(0, 0, true));
  return ticks;
}

TEST(StrategyMeasures, ATurnIsEmptyAfterATenthOfASecondWithoutATouch) {
  EXPECT_EQ(measured(turn(5, 0, true))[kEmptyTurns], 0.0);
  EXPECT_EQ(measured(turn(5, 99, true))[kEmptyTurns], 0.0);
  EXPECT_EQ(measured(turn(5, 100, true))[kEmptyTurns], 1.0);
  EXPECT_EQ(measured(turn(5, 99, false))[kEmptyTurns], 0.0) << "cut off by the end";
  std::vector<TickRecord> several;
  for (const auto& part : {turn(3, 50, false), turn(3, 150, false), turn(1, 200, true)}) {
    several.insert(several.end(), part.begin(), part.end());
  }
  several.back().rotation_rad = 0.01;  // A4 in contact
  several.push_back(tick(0, 0, false));
  EXPECT_EQ(measured(several)[kEmptyTurns], 2.0);
}

TEST(StrategyMeasures, DriftIsTheWayOfASceneThatDoesNotTurn) {
  std::vector<TickRecord> ticks(4, tick(0, 0, false));
  put(Vec3(1.0, 0.0, 0.0), ticks[0].o_before_m);
  put(Vec3(4.0, 4.0, 0.0), ticks[1].o_before_m);
  put(Vec3(1.0, 0.0, 0.0), ticks[2].o_before_m);
  put(Vec3(1.0, 0.0, 1.0), ticks[3].o_before_m);
  auto values = measured(ticks);
  EXPECT_EQ(values[kMeanDrift], 1.5);
  EXPECT_EQ(values[kWorstDrift], 5.0);
  ticks[2].q_before_wxyz[3] = 1e-9;
  values = measured(ticks);
  EXPECT_FALSE(values[kMeanDrift] || values[kWorstDrift]);
}

TEST(StrategyMeasures, CountsTicksInWhichTheGovernorActedOnTheForce) {
  std::vector<TickRecord> ticks(8, tick(0, 0, true));
  ticks[1].rules = kRuleClamp;
  ticks[2].rules = kRuleClamp | kRuleMotors;
  ticks[3].rules = kRuleTripped;
  ticks[4].rules = kRuleOrder;
  ticks[5].faults = kFaultSolverCapped;
  EXPECT_EQ(measured(ticks)[kGovernorShare], 3.0 / 8.0);
}

// A wall at 60 deg to A1, 10 mm above the device point, turns to 30 deg under A4. The motor along
// A1 gives a part of its force, before the turn and after it.
std::vector<TickRecord> turning_wall(double part_before, double part_after) {
  std::vector<TickRecord> ticks(2, tick(0, 0, true));
  const double degrees[] = {60.0, 30.0};
  const double parts[] = {part_before, part_after};
  for (std::size_t i = 0; i < 2; ++i) {
    TickRecord& record = ticks[i];
    const double angle = degrees[i] * std::numbers::pi / 180.0;
    const Vec3 n(std::cos(angle), std::sin(angle), 0.0);
    const Quat turned = Quat::FromTwoVectors(Vec3::UnitY(), n);
    put(ScenePose{turned, Vec3::Zero()}, record.q_before_wxyz, record.o_before_m);
    record.contacts = 1;
    record.proxy_scene_m[1] = 10e-3 * (i == 0 ? 1.0 : std::cos(std::numbers::pi / 6));
    record.alpha_rad = angle;
    const Vec3 full_N = 1000.0 * record.proxy_scene_m[1] * n;
    put(full_N, record.full_force_device_N);
    put(Vec3(parts[i] * full_N.x(), 0.0, 0.0), record.force_device_N);
  }
  ticks[0].rotation_rad = std::numbers::pi / 6;
  std::copy_n(ticks[1].q_before_wxyz, 4, ticks[0].q_after_wxyz);
  return ticks;
}

TEST(StrategyMeasures, CountsWhatTurnsAddToTheSpringOfTheMotors) {
  const auto energy_J = [](const std::vector<TickRecord>& ticks) {
    return *measured(ticks)[kTurningEnergy];
  };
  // 500 N/m times the square of e cos(a): e = 10 mm at 60 deg, 8.66 mm at 30 deg.
  const double before_J = 500.0 * 25e-6;
  const double after_J = 500.0 * 56.25e-6;
  expect_near(energy_J(turning_wall(1.0, 1.0)), after_J - before_J);
  expect_near(energy_J(turning_wall(0.5, 1.0)), after_J - 0.25 * before_J);
  expect_near(energy_J(turning_wall(0.5, 0.5)), 0.25 * (after_J - before_J));
  EXPECT_EQ(energy_J(turning_wall(1.0, 0.5)), 0.0) << "a turn that adds nothing";
  EXPECT_EQ(energy_J(turning_wall(1.0, 0.0)), 0.0) << "no force";
  auto ticks = turning_wall(1.0, 1.0);
  ticks[1].rules = kRuleClamp;
  EXPECT_EQ(energy_J(ticks), 0.0);
  ticks[1].rules = kRuleOrder;
  expect_near(energy_J(ticks), after_J - before_J);
  ticks[1].normal_scene[1] = 0.5;
  EXPECT_EQ(energy_J(ticks), 0.0) << "another wall";
  ticks = turning_wall(1.0, 1.0);
  ticks[0].rotation_rad = 0.0;
  EXPECT_EQ(energy_J(ticks), 0.0) << "no turn";
}

}  // namespace
}  // namespace palpate
