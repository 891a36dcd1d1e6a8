// Rankings, flips and shares of sweeps, compared with counts by hand.

#include "engine/analysis/sweep_analysis.h"

#include <array>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/analysis/sweep_chance.h"
#include "engine/analysis/sweep_plots.h"
#include "engine/analysis/sweep_report.h"
#include "engine/analysis/sweep_tables.h"
#include "geometry/base/random.h"

namespace palpate {
namespace {

constexpr std::size_t kTimePlace = 0, kAnglePlace = 3;  // in kSweepOutcomes

// The place of a ranking by its name.
std::size_t ranking_place(const std::string& name) {
  for (std::size_t i = 0; i < sweep_rankings().size(); ++i) {
    if (sweep_rankings()[i].name == name) return i;
  }
  ADD_FAILURE() << "no ranking " << name;
  return 0;
}

// The mean of a measure: (participant, haptic, rotation, outcome).
using MeanAt = std::function<std::optional<double>(int, std::size_t, std::size_t, std::size_t)>;

void add_point(std::vector<SweepRow>& rows, SweepRow row, int participants, const MeanAt& mean) {
  row.point = rows.empty() ? 1 : rows.back().point + 1;
  row.trials = row.done = 1;
  for (row.participant = 1; row.participant <= participants; ++row.participant) {
    for (row.haptic = 0; row.haptic < 3; ++row.haptic) {
      for (row.rotation = 0; row.rotation < 2; ++row.rotation) {
        for (std::size_t o = 0; o < 4; ++o) {
          row.means[o] = mean(row.participant, row.haptic, row.rotation, o);
        }
        rows.push_back(row);
      }
    }
  }
}

SweepRow row_with(SweepBlock block, std::optional<std::size_t> varied, std::size_t parameter,
                  double value) {
  SweepRow row;
  row.block = block;
  row.varied = varied;
  row.values[parameter] = value;
  return row;
}

RankingAtPoint ranked(const std::string& name, int participants, const MeanAt& mean) {
  std::vector<SweepRow> rows;
  add_point(rows, {}, participants, mean);
  return ranking_at(sweep_rankings()[ranking_place(name)], rows);
}

TEST(SweepRanking, AreThoseOfThePaperAndThatA4Helps) {
  std::vector<std::string> found;
  for (const SweepRanking& ranking : sweep_rankings()) {
    found.push_back(ranking.name + ": " + ranking.order() + (ranking.is_of_paper ? "" : " *"));
  }
  EXPECT_EQ(found,
            (std::vector<std::string>{
                "total time, Haptic: H < UaH < NoH", "total time, Rotation: NoR < R",
                "losses of contact, Haptic: H < UaH < NoH", "losses of contact, Rotation: NoR < R",
                "mean penetration, Haptic: H < UaH < NoH", "mean contact angle, Rotation: R < NoR",
                "total time, A4 in UaH: R < NoR *", "losses of contact, A4 in UaH: R < NoR *",
                "mean penetration, A4 in UaH: R < NoR *"}));
}

TEST(SweepRanking, ComparesMeansOverTheOtherFactor) {
  // NoH 20 and 40, UaH 21 and 37, H 10 and 46: means 30, 29 and 28.
  const double times[3][2] = {{20, 40}, {21, 37}, {10, 46}};
  const MeanAt mean = [&](int, std::size_t h, std::size_t r, std::size_t) { return times[h][r]; };
  const RankingAtPoint haptic = ranked("total time, Haptic", 1, mean);
  EXPECT_EQ(haptic.holds, true);
  EXPECT_EQ(haptic.means, (std::vector<double>{28.0, 29.0, 30.0}));
  EXPECT_EQ(haptic.participants, 1);
  EXPECT_FALSE(haptic.is_clear);  // one participant has no interval
  const RankingAtPoint rotation = ranked("total time, Rotation", 1, mean);
  EXPECT_EQ(rotation.holds, true);
  EXPECT_EQ(rotation.means, (std::vector<double>{17.0, 41.0}));
  // In UaH alone, and the claim is R < NoR.
  const RankingAtPoint a4 = ranked("total time, A4 in UaH", 1, mean);
  EXPECT_EQ(a4.holds, false);
  EXPECT_EQ(a4.means, (std::vector<double>{37.0, 21.0}));
}

TEST(SweepRanking, ATieDoesNotHold) {
  const MeanAt same = [](int, std::size_t, std::size_t, std::size_t) { return 1.0; };
  for (const SweepRanking& ranking : sweep_rankings()) {
    EXPECT_EQ(ranked(ranking.name, 3, same).holds, false) << ranking.name;
  }
}

// The mean of the pairs counts, not how many participants agree.
TEST(SweepRanking, IsOfTheMeanOverParticipants) {
  const MeanAt mean = [](int participant, std::size_t, std::size_t r, std::size_t) {
    return r == 0 ? 10.0 : participant == 3 ? 30.0 : 9.0;
  };
  EXPECT_EQ(ranked("total time, Rotation", 3, mean).holds, true);
  EXPECT_FALSE(ranked("total time, Rotation", 3, mean).is_clear);
}

TEST(SweepRanking, LeavesOutParticipantsWithoutACell) {
  const MeanAt mean = [](int participant, std::size_t h, std::size_t r,
                         std::size_t) -> std::optional<double> {
    if (participant == 1 && h == 2 && r == 0) return std::nullopt;
    return participant == 1 ? 100.0 * static_cast<double>(h) : 3.0 - static_cast<double>(h);
  };
  const RankingAtPoint haptic = ranked("total time, Haptic", 2, mean);
  EXPECT_EQ(haptic.participants, 1);
  EXPECT_EQ(haptic.means, (std::vector<double>{1.0, 2.0, 3.0}));
  // The missing cell is not one of UaH.
  EXPECT_EQ(ranked("mean contact angle, Rotation", 2, mean).participants, 2);
  const MeanAt none = [](int, std::size_t, std::size_t, std::size_t) {
    return std::optional<double>();
  };
  EXPECT_FALSE(ranked("total time, Haptic", 2, none).holds.has_value());
}

// Three participants with the differences d - w, d and d + w have a t interval of half width
// 4.302653 w / sqrt(3) = 2.484138 w.
TEST(SweepRanking, IsClearIfTheIntervalsOfPairedDifferencesExcludeZero) {
  const auto at = [](double difference) {
    return ranked("mean contact angle, Rotation", 3,
                  [&](int participant, std::size_t, std::size_t r, std::size_t) {
                    return r == 0 ? 50.0 : 50.0 - difference + (participant - 2);
                  });
  };
  EXPECT_TRUE(at(2.4842).is_clear);
  EXPECT_FALSE(at(2.4841).is_clear);
  EXPECT_EQ(at(2.4841).holds, true);
  EXPECT_TRUE(at(-2.4842).is_clear);
  EXPECT_EQ(at(-2.4842).holds, false);
  EXPECT_FALSE(at(-2.4841).is_clear);
}

// A row of a trial that was not done has no means.
void set_counts(SweepRow& row, int done, int timeouts, int faults) {
  row.trials = done + timeouts + faults;
  row.done = done;
  row.timeouts = timeouts;
  row.faults = faults;
  row.limit_s = 120.0;
  if (done == 0) row.means = {};
}

TEST(SweepCellMean, CountsTheLimitForATimeoutOfTheTimeAndNeedsAllTrialsOtherwise) {
  SweepRow row;
  row.means = {30.0, 5.0, 0.04, 20.0};
  const auto expect_means = [&](std::optional<double> time_s, bool has_others) {
    EXPECT_EQ(sweep_cell_mean(row, kTimePlace), time_s);
    for (std::size_t o = 1; o < 4; ++o) {
      EXPECT_EQ(sweep_cell_mean(row, o), has_others ? row.means[o] : std::nullopt);
    }
  };
  set_counts(row, 4, 0, 0);
  expect_means(30.0, true);
  set_counts(row, 3, 1, 0);
  expect_means((3 * 30.0 + 120.0) / 4, false);
  set_counts(row, 3, 0, 1);
  expect_means(std::nullopt, false);
  set_counts(row, 2, 1, 1);
  expect_means(std::nullopt, false);
  set_counts(row, 0, 4, 0);
  expect_means(120.0, false);
  set_counts(row, 0, 0, 0);
  expect_means(std::nullopt, false);
}

// In one cell, the trials of a hard object end by the limit. The means of the others would be
// smaller than those of the complete cells.
TEST(SweepRanking, ATimeoutDoesNotFavourTheConditionThatTimesOut) {
  std::vector<SweepRow> rows;
  add_point(rows, {}, 2,
            [](int, std::size_t, std::size_t r, std::size_t) { return r == 1 ? 10.0 : 20.0; });
  for (SweepRow& row : rows) {
    const bool is_timed_out = row.participant == 1 && row.haptic == 1 && row.rotation == 1;
    set_counts(row, is_timed_out ? 3 : 4, is_timed_out ? 1 : 0, 0);
  }
  const auto at = [&](const char* name) {
    return ranking_at(sweep_rankings()[ranking_place(name)], rows);
  };
  EXPECT_EQ(at("losses of contact, A4 in UaH").participants, 1);
  EXPECT_EQ(at("mean penetration, Haptic").participants, 1);
  EXPECT_EQ(at("mean contact angle, Rotation").participants, 1);
  const RankingAtPoint time = at("total time, A4 in UaH");
  EXPECT_EQ(time.participants, 2);
  EXPECT_EQ(time.means, (std::vector<double>{((3 * 10.0 + 120.0) / 4 + 10.0) / 2, 20.0}));
  EXPECT_EQ(time.holds, false);
}

TEST(SweepRanking, IsNotTestableWhereNobodyCompletedATrial) {
  std::vector<SweepRow> rows;
  add_point(rows, {}, 2, [](int, std::size_t, std::size_t, std::size_t) { return 1.0; });
  for (SweepRow& row : rows) set_counts(row, 0, 4, 0);
  for (const SweepRanking& ranking : sweep_rankings()) {
    EXPECT_FALSE(ranking_at(ranking, rows).holds.has_value()) << ranking.name;
  }
}

// Two points of which one holds are in different parts: each of the two deals has the same
// difference. Of 8 and 8 points, the parts that hold and fail are one of 12,870 deals; two of these
// deals have the difference 1.
TEST(SweepChance, IsTheShareOfDealsWithALargerDifference) {
  const PointSplit two{{0, 1}, 2};
  EXPECT_EQ(largest_difference_p({two}, {true, false}, "two"), 1.0);
  PointSplit halves{{}, 2};
  std::vector<bool> holds;
  for (std::size_t i = 0; i < 16; ++i) {
    halves.part_of.emplace_back(i / 8);
    holds.push_back(i < 8);
  }
  EXPECT_LT(largest_difference_p({halves}, holds, "parted"), 0.005);
  // Of 2 and 2 points, two of six deals part them.
  const PointSplit four{{0, 0, 1, 1}, 2};
  const double p = largest_difference_p({four}, {true, true, false, false}, "four");
  EXPECT_NEAR(p, 1.0 / 3.0, 5.0 * std::sqrt(2.0 / 9.0 / 2000.0) + 1.0 / 2001.0);
  EXPECT_EQ(largest_difference_p({four}, {true, true, false, false}, "four"), p);
  // Three splits, one for each way to pair four points: every deal parts one of them.
  const std::vector<PointSplit> all = {four, {{0, 1, 0, 1}, 2}, {{0, 1, 1, 0}, 2}};
  EXPECT_EQ(largest_difference_p(all, {true, true, false, false}, "all"), 1.0);
}

// Noise decides in about one of twenty sets of noise, however many parameters there are.
TEST(SweepChance, RarelyFindsAParameterInNoise) {
  constexpr std::uint64_t kSeed = 17;
  constexpr int kSets = 200;
  std::cout << "seed " << kSeed << "\n";
  SeededRandom random(kSeed);
  int found = 0;
  for (int set = 0; set < kSets; ++set) {
    std::vector<PointSplit> splits(12, PointSplit{{}, 2});
    std::vector<bool> holds;
    for (int i = 0; i < 40; ++i) {
      for (PointSplit& split : splits) split.part_of.emplace_back(random.index(2));
      holds.push_back(random.index(2) == 0);
    }
    if (largest_difference_p(splits, holds, std::to_string(set)) < 0.05) ++found;
  }
  std::cout << found << " of " << kSets << "\n";
  EXPECT_LE(found, kSets * 0.05 + 5.0 * std::sqrt(kSets * 0.05 * 0.95));
}

TEST(SweepMeans, HaveTheStandardDeviationOverParticipants) {
  std::vector<SweepRow> rows;
  add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, 1.0), 3,
            [](int participant, std::size_t, std::size_t, std::size_t) {
              return participant == 3 ? std::optional<double>() : 10.0 * participant;
            });
  const SweepAnalysis analysis = analyse_sweep(rows);
  const SweepMean mean = sweep_mean(analysis.points.front(), kTimePlace, 1, 1);
  EXPECT_EQ(mean.participants, 2);
  EXPECT_EQ(mean.mean, 15.0);
  EXPECT_DOUBLE_EQ(*mean.sd, std::sqrt(50.0));
}

TEST(SweepFlips, AreBetweenNeighbouringLevelsWithTheBaseInItsPlace) {
  std::vector<SweepRow> rows;
  // The angle with R is smaller at the levels 500 and 2000, not at 1000 (the base) and 4000.
  const auto mean_of = [](bool is_smaller) -> MeanAt {
    return [=](int participant, std::size_t, std::size_t r, std::size_t o) {
      return o == kAnglePlace && r == 1 && is_smaller ? 1.0 : 2.0 + 0.01 * participant;
    };
  };
  add_point(rows, row_with(SweepBlock::kBase, {}, kDeviceStiffness, 1000), 2, mean_of(false));
  for (const double level : {500.0, 2000.0, 4000.0}) {
    add_point(rows, row_with(SweepBlock::kOneAtATime, kDeviceStiffness, kDeviceStiffness, level), 2,
              mean_of(level != 4000.0));
  }
  const SweepAnalysis analysis = analyse_sweep(rows);
  ASSERT_EQ(analysis.axes.size(), 1u);
  EXPECT_EQ(analysis.axes[0].points, (std::vector<std::size_t>{1, 0, 2, 3}));
  ASSERT_EQ(analysis.flips.size(), 3u);
  const std::vector<std::pair<double, double>> expected = {{500, 1000}, {1000, 2000}, {2000, 4000}};
  for (std::size_t i = 0; i < 3; ++i) {
    const SweepFlip& flip = analysis.flips[i];
    EXPECT_EQ(sweep_rankings()[flip.ranking].name, "mean contact angle, Rotation");
    EXPECT_EQ(std::pair(flip.from, flip.to), expected[i]);
    EXPECT_EQ(flip.holds_at_to, i == 1);
    EXPECT_FALSE(flip.is_clear);  // where the ranking fails, all differences are 0
  }
}

TEST(SweepFlips, CompareWithTheLastTestableLevel) {
  std::vector<SweepRow> rows;
  for (const double level : {0.5, 1.0, 2.0}) {
    add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, level), 3,
              [&](int, std::size_t, std::size_t r, std::size_t o) -> std::optional<double> {
                if (level == 1.0) return std::nullopt;
                if (o != kAnglePlace) return 1.0;
                return (r == 1) == (level == 0.5) ? 1.0 : 2.0;
              });
  }
  const SweepAnalysis analysis = analyse_sweep(rows);
  ASSERT_EQ(analysis.flips.size(), 1u);
  EXPECT_EQ(analysis.flips[0].from, 0.5);
  EXPECT_EQ(analysis.flips[0].to, 2.0);
  EXPECT_FALSE(analysis.flips[0].holds_at_to);
}

// A ranking that holds or fails as a function of two values, among random ones.
TEST(SweepShares, AreCountedOverTheHypercubeAndItsHalves) {
  constexpr std::uint64_t kSeed = 91;
  std::cout << "seed " << kSeed << "\n";
  SeededRandom random(kSeed);
  constexpr int kCount = 41;
  std::vector<SweepRow> rows;
  std::vector<double> delays;
  std::vector<int> words;
  std::vector<bool> holds;
  // One level of each parameter, so that both are of the sweep.
  const MeanAt any = [](int, std::size_t, std::size_t, std::size_t) { return 1.0; };
  add_point(rows, row_with(SweepBlock::kOneAtATime, kSightDelay, kSightDelay, 0.1), 1, any);
  add_point(rows, row_with(SweepBlock::kOneAtATime, kSweptFollowing, kSweptFollowing, 1), 1, any);
  for (int i = 0; i < kCount; ++i) {
    const double delay = random.uniform(0.1, 0.2);
    const int word = static_cast<int>(random.index(3));
    const bool is_true = delay < 0.13 || (word == 2 && delay < 0.18);
    SweepRow row = row_with(SweepBlock::kHypercube, {}, kSightDelay, delay);
    row.values[kSweptFollowing] = word;
    add_point(rows, row, 1, [&](int, std::size_t, std::size_t r, std::size_t o) {
      if (i == 7) return std::optional<double>();  // nobody completes this point
      return std::optional<double>(o == kAnglePlace && r == 1 && is_true ? 1.0 : 2.0);
    });
    delays.push_back(delay);
    words.push_back(word);
    holds.push_back(is_true);
  }
  const SweepAnalysis analysis = analyse_sweep(rows);
  const RankingResult& result = analysis.rankings[ranking_place("mean contact angle, Rotation")];
  const auto count = [&](const std::function<bool(int)>& is_in) {
    RankingShare share;
    for (int i = 0; i < kCount; ++i) {
      if (i == 7 || !is_in(i)) continue;
      ++share.points;
      share.holds += holds[static_cast<std::size_t>(i)] ? 1 : 0;
    }
    return share;
  };
  EXPECT_EQ(result.all.untestable, 1);
  const auto expect_share = [](const RankingShare& found, const RankingShare& expected) {
    EXPECT_EQ(found.points, expected.points);
    EXPECT_EQ(found.holds, expected.holds);
  };
  expect_share(result.all, count([](int) { return true; }));
  EXPECT_EQ(result.all.interval().low, wilson_interval(result.all.holds, kCount - 1).low);
  // Of 41 different delays, the 20 lowest and the 20 highest; of three words, each.
  std::vector<double> sorted = delays;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(result.halves.size(), 2u);
  ASSERT_EQ(result.halves[0].parts.size(), 2u);
  EXPECT_EQ(result.halves[0].parts[0].name, "low half");
  EXPECT_EQ(result.halves[0].parts[1].name, "high half");
  expect_share(result.halves[0].parts[0].share,
               count([&](int i) { return delays[static_cast<std::size_t>(i)] <= sorted[19]; }));
  expect_share(result.halves[0].parts[1].share,
               count([&](int i) { return delays[static_cast<std::size_t>(i)] >= sorted[21]; }));
  const std::array<std::string, 3> names = {"delayed", "predict", "replan"};
  std::vector<double> shares;
  ASSERT_EQ(result.halves[1].parts.size(), names.size());
  for (int word = 0; word < 3; ++word) {
    const RankingHalves::Part& part = result.halves[1].parts[static_cast<std::size_t>(word)];
    EXPECT_EQ(part.name, names[static_cast<std::size_t>(word)]);
    expect_share(part.share,
                 count([&](int i) { return words[static_cast<std::size_t>(i)] == word; }));
    shares.push_back(*part.share.share());
  }
  std::sort(shares.begin(), shares.end());
  EXPECT_EQ(result.halves[1].difference(), shares[2] - shares[0]);
  const bool is_delay =
      std::abs(*result.halves[0].difference()) >= std::abs(*result.halves[1].difference());
  EXPECT_EQ(result.most_different, (std::vector<std::size_t>{is_delay ? 0u : 1u}));
  EXPECT_LT(*result.p, 0.05);
  EXPECT_EQ(result.decisive(), result.most_different);
}

TEST(SweepShares, EqualDifferencesDecideTogether) {
  std::vector<SweepRow> rows;
  const auto angle = [](bool is_true) -> MeanAt {
    return [=](int, std::size_t, std::size_t r, std::size_t o) {
      return o == kAnglePlace && r == 1 && is_true ? 1.0 : 2.0;
    };
  };
  add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, 1), 1, angle(true));
  add_point(rows, row_with(SweepBlock::kOneAtATime, kAlign, kAlign, 1), 1, angle(true));
  add_point(rows, row_with(SweepBlock::kOneAtATime, kSpeed, kSpeed, 1), 1, angle(true));
  for (const double value : {0.0, 1.0}) {
    for (const double speed : {0.1, 0.2}) {
      SweepRow row = row_with(SweepBlock::kHypercube, {}, kScale, value);
      row.values[kAlign] = 1.0 - value;
      row.values[kSpeed] = speed;
      add_point(rows, row, 1, angle(value == 1.0));
    }
  }
  const SweepAnalysis analysis = analyse_sweep(rows);
  const RankingResult& result = analysis.rankings[ranking_place("mean contact angle, Rotation")];
  ASSERT_EQ(result.halves.size(), 3u);  // speed, align and scale
  EXPECT_EQ(result.most_different, (std::vector<std::size_t>{1, 2}));
  // Four points: one of three deals parts them as well.
  EXPECT_GT(*result.p, 0.05);
  EXPECT_TRUE(result.decisive().empty());
}

TEST(SweepShares, WithoutADifferenceNothingDecides) {
  std::vector<SweepRow> rows;
  const MeanAt any = [](int, std::size_t h, std::size_t, std::size_t) {
    return 3.0 - static_cast<double>(h);
  };
  add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, 1), 1, any);
  for (const double scale : {0.5, 1.0, 1.0, 0.5}) {
    add_point(rows, row_with(SweepBlock::kHypercube, {}, kScale, scale), 1, any);
  }
  const SweepAnalysis analysis = analyse_sweep(rows);
  const RankingResult& result = analysis.rankings[ranking_place("total time, Haptic")];
  EXPECT_EQ(result.all.share(), 1.0);
  EXPECT_EQ(result.all.interval().high, 1.0);
  EXPECT_EQ(result.halves[0].difference(), 0.0);
  EXPECT_TRUE(result.most_different.empty());
  EXPECT_FALSE(result.p.has_value());
}

// 399 of 400 points hold; nobody completes another one.
TEST(SweepText, StatesUntestablePointsAndRoundsNoShareToAll) {
  std::vector<SweepRow> rows;
  const auto angle = [](bool is_smaller) -> MeanAt {
    return [=](int, std::size_t, std::size_t r, std::size_t o) {
      return o == kAnglePlace && r == 1 && is_smaller ? 1.0 : 2.0;
    };
  };
  add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, 1), 1, angle(true));
  for (int i = 0; i < 401; ++i) {
    add_point(rows, row_with(SweepBlock::kHypercube, {}, kScale, i), 1, angle(i != 5));
  }
  for (std::size_t i = rows.size() - 6; i < rows.size(); ++i) set_counts(rows[i], 0, 4, 0);
  const std::string text = sweep_text(analyse_sweep(rows));
  for (const char* const part :
       {"mean contact angle, Rotation (R < NoR): > 99 % (99 to > 99 %): holds at 399 of 400 "
        "testable "
        "points; 1 of 401 not testable, because nobody completed the trials; decides most: none "
        "beyond chance (p = 1)",
        "mean penetration, A4 in UaH (R < NoR): 0 % (0 to 1 %): holds at 0 of 400 testable points",
        "two conditions holds at 1/2 of the points, and an order of three at 1/6",
        "by the means of 1 person, who is the same at all points"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
}

// Of the 2 * 6 trials at the second level, one ends by the limit.
TEST(SweepFigure, CountsTheTrialsOfALevelAtWhichSomeAreMissing) {
  std::vector<SweepRow> rows;
  for (const double level : {0.5, 1.0}) {
    add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, level), 2,
              [](int, std::size_t, std::size_t, std::size_t) { return 1.0; });
  }
  set_counts(rows.back(), 0, 1, 0);
  const SweepAnalysis analysis = analyse_sweep(rows);
  const auto svg = sweep_axis_svg(analysis, analysis.axes.front());
  ASSERT_TRUE(svg.ok()) << svg.error().to_string();
  EXPECT_NE(svg->find("11/12"), std::string::npos);
  EXPECT_EQ(svg->find("12/12"), std::string::npos);
  const auto tables = sweep_tables(analysis);
  EXPECT_EQ(std::get<int>(tables[0].rows.front()[6]), 12);
  EXPECT_EQ(std::get<int>(tables[0].rows.front()[7]), 12);
  EXPECT_EQ(std::get<int>(tables[0].rows.back()[7]), 11);
}

// Nobody completes a trial with force, or any at the second level.
TEST(SweepFigure, IsDrawnWithoutSomeConditions) {
  std::vector<SweepRow> rows;
  for (const double level : {0.5, 1.0}) {
    add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, level), 2,
              [&](int participant, std::size_t h, std::size_t, std::size_t) {
                return h == 0 && level == 0.5 ? std::optional(1.0 * participant) : std::nullopt;
              });
  }
  const SweepAnalysis analysis = analyse_sweep(rows);
  const auto svg = sweep_axis_svg(analysis, analysis.axes.front());
  ASSERT_TRUE(svg.ok()) << svg.error().to_string();
  for (const char* const text : {"NoH, NoR", "H, R", "0.5", "mean penetration (dm)"}) {
    EXPECT_NE(svg->find(text), std::string::npos) << text;
  }
  for (SweepRow& row : rows) row.means = {};
  const SweepAnalysis empty = analyse_sweep(rows);
  EXPECT_TRUE(sweep_axis_svg(empty, empty.axes.front()).ok());
}

TEST(SweepTables, HaveOneRowForEachThingTheyCount) {
  std::vector<SweepRow> rows;
  const MeanAt any = [](int p, std::size_t h, std::size_t r, std::size_t) {
    return 1.0 * p + 2.0 * static_cast<double>(h) + static_cast<double>(r);
  };
  for (const double level : {0.5, 1.0}) {
    add_point(rows, row_with(SweepBlock::kOneAtATime, kScale, kScale, level), 2, any);
  }
  add_point(rows, row_with(SweepBlock::kHypercube, {}, kScale, 0.5), 2, any);
  const SweepAnalysis analysis = analyse_sweep(rows);
  const auto tables = sweep_tables(analysis);
  ASSERT_EQ(tables.size(), kSweepTableNames.size());
  const std::map<std::string, std::size_t> expected = {
      {"one_at_a_time", 2 * 4 * 6}, {"flips", 0}, {"rankings", 9}, {"halves", 2 * 9}};
  for (std::size_t i = 0; i < tables.size(); ++i) {
    EXPECT_EQ(tables[i].name, kSweepTableNames[i]);
    EXPECT_EQ(tables[i].rows.size(), expected.at(tables[i].name)) << tables[i].name;
    for (const auto& row : tables[i].rows) EXPECT_EQ(row.size(), tables[i].columns.size());
  }
}

}  // namespace
}  // namespace palpate
