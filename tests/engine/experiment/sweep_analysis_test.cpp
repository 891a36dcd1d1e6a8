// Rankings, flips and shares of sweeps, compared with counts by hand.

#include "engine/experiment/sweep_analysis.h"

#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/experiment/sweep_plots.h"
#include "engine/experiment/sweep_tables.h"
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
  const auto expect_share = [](const RankingShare& found, const RankingShare& expected) {
    EXPECT_EQ(found.points, expected.points);
    EXPECT_EQ(found.holds, expected.holds);
  };
  expect_share(result.all, count([](int) { return true; }));
  EXPECT_EQ(result.all.interval().low, wilson_interval(result.all.holds, kCount - 1).low);
  // Of 41 different delays, the 20 lowest and the 20 highest; of three words, the first and last.
  std::vector<double> sorted = delays;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(result.halves.size(), 2u);
  expect_share(result.halves[0].low,
               count([&](int i) { return delays[static_cast<std::size_t>(i)] <= sorted[19]; }));
  expect_share(result.halves[0].high,
               count([&](int i) { return delays[static_cast<std::size_t>(i)] >= sorted[21]; }));
  expect_share(result.halves[1].low,
               count([&](int i) { return words[static_cast<std::size_t>(i)] == 0; }));
  expect_share(result.halves[1].high,
               count([&](int i) { return words[static_cast<std::size_t>(i)] == 2; }));
  const bool is_delay =
      std::abs(*result.halves[0].difference()) >= std::abs(*result.halves[1].difference());
  EXPECT_EQ(result.decisive, (std::vector<std::size_t>{is_delay ? 0u : 1u}));
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
  EXPECT_EQ(result.decisive, (std::vector<std::size_t>{1, 2}));
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
  EXPECT_TRUE(result.decisive.empty());
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
      {"one_at_a_time", 2 * 4 * 6}, {"flips", 0}, {"rankings", 9}, {"halves", 9}};
  for (std::size_t i = 0; i < tables.size(); ++i) {
    EXPECT_EQ(tables[i].name, kSweepTableNames[i]);
    EXPECT_EQ(tables[i].rows.size(), expected.at(tables[i].name)) << tables[i].name;
    for (const auto& row : tables[i].rows) EXPECT_EQ(row.size(), tables[i].columns.size());
  }
}

}  // namespace
}  // namespace palpate
