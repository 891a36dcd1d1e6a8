// The analysis of trials with several levels of view, start orientation or scale.

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/analysis/analysis.h"
#include "engine/analysis/analysis_tables.h"
#include "engine/analysis/experiment_report.h"
#include "engine/analysis/variant_differences.h"
#include "tests/engine/analysis/sample_trials.h"

namespace palpate {
namespace {

using test::sample_trials;
using test::SampleTrials;

constexpr double kLimit_s = 120.0;

// Sample trials of one following in one variant.
std::vector<TrialRow> trials_of(const std::string& following, const TrialVariant& variant,
                                std::uint64_t seed, int participants = 4) {
  SampleTrials sample;
  sample.followings = {following};
  sample.participants = participants;
  sample.blocks = 2;
  sample.seed = seed;
  auto rows = sample_trials(sample);
  for (TrialRow& row : rows) {
    row.view = variant.view;
    row.align = variant.align;
    row.start_orientation_deg = variant.start_orientation_deg;
    row.scale = variant.scale;
  }
  return rows;
}

void append(std::vector<TrialRow>& rows, const std::vector<TrialRow>& more) {
  rows.insert(rows.end(), more.begin(), more.end());
}

TEST(VariantAnalysis, AnalysesEachVariantAsIfItWereAlone) {
  const TrialVariant turned{"turning", "nearest", 45.0, 1.0};
  const auto first = trials_of("delayed", {}, 1);
  const auto second = trials_of("delayed", turned, 2);
  auto rows = second;  // the order of rows has no influence
  append(rows, first);
  const auto both = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(both.ok()) << both.error().to_string();
  ASSERT_EQ(both->operators.size(), 2u);
  EXPECT_EQ(both->variants(), 2);
  EXPECT_EQ(both->operators[0].name(), "delayed");
  EXPECT_EQ(both->operators[1].name(), "delayed, start 45 deg");
  const auto alone_first = analyse_trials(first, kLimit_s);
  const auto alone_second = analyse_trials(second, kLimit_s);
  EXPECT_EQ(alone_second->operators[0].name(), "delayed, start 45 deg");
  for (const auto& [together, alone] :
       {std::pair(&both->operators[0], &alone_first->operators[0]),
        std::pair(&both->operators[1], &alone_second->operators[0])}) {
    ASSERT_EQ(together->primary.size(), alone->primary.size());
    for (std::size_t i = 0; i < alone->primary.size(); ++i) {
      for (std::size_t k = 0; k < alone->primary[i].means.size(); ++k) {
        EXPECT_EQ(together->primary[i].means[k].mean, alone->primary[i].means[k].mean);
      }
      for (std::size_t k = 0; k < alone->primary[i].effects.size(); ++k) {
        EXPECT_EQ(together->primary[i].effects[k].test->p_gg,
                  alone->primary[i].effects[k].test->p_gg);
      }
    }
  }
  EXPECT_TRUE(alone_first->differences.empty());
}

// Two participants, one condition each way, numbers by hand.
TEST(VariantDifferences, AreMeansOverTrialsThatBothCompleted) {
  std::vector<TrialRow> rows;
  const auto add = [&](const char* participant, int block, const char* object, double start_deg,
                       double time_s, TrialStatus status = TrialStatus::kDone) {
    TrialRow row;
    row.following = "delayed";
    row.participant = participant;
    row.block = block;
    row.haptic = "UaH";
    row.rotation = "R";
    row.object = object;
    row.status = status;
    row.start_orientation_deg = start_deg;
    if (status == TrialStatus::kDone) row.measures[kTotalTime] = time_s;
    rows.push_back(row);
  };
  // Participant 1: differences 1, 3 and, after a timeout, none. Mean 2.
  add("1", 1, "O1", 0, 10);
  add("1", 1, "O1", 90, 11);
  add("1", 2, "O1", 0, 20);
  add("1", 2, "O1", 90, 23);
  add("1", 1, "O2", 0, 30);
  add("1", 1, "O2", 90, 0, TrialStatus::kTimeout);
  // Participant 2: difference 6. Practice does not count.
  add("2", 0, "O1", 0, 1);
  add("2", 0, "O1", 90, 1000);
  add("2", 1, "O1", 0, 10);
  add("2", 1, "O1", 90, 16);
  // Participant 3: no pair.
  add("3", 1, "O1", 0, 10);
  add("3", 2, "O1", 90, 17);
  const auto tables = trial_tables(rows, kLimit_s);
  ASSERT_TRUE(tables.ok()) << tables.error().to_string();
  ASSERT_EQ(tables->size(), 2u);
  const auto differences = variant_differences({&(*tables)[0], &(*tables)[1]});
  ASSERT_EQ(differences.size(), 2u);
  const VariantDifference& time = differences[0];
  EXPECT_EQ(time.outcome, Outcome::kTime);
  EXPECT_EQ(time.haptic, "UaH");
  EXPECT_EQ(time.rotation, "R");
  EXPECT_EQ(time.test.pairs, 2);
  EXPECT_DOUBLE_EQ(time.test.difference, 4.0);
  EXPECT_DOUBLE_EQ(time.test.t, 2.0);                                 // 4 / (sqrt(8) / sqrt(2))
  EXPECT_NEAR(time.test.half_width, 12.706204736432095 * 2.0, 1e-9);  // t(0.975; 1) s / sqrt(2)
  // With the timeout as the limit, participant 1 has (1 + 3 + 90) / 3.
  EXPECT_EQ(differences[1].outcome, Outcome::kTimeToLimit);
  EXPECT_NEAR(differences[1].test.difference, ((1.0 + 3.0 + 90.0) / 3.0 + 6.0) / 2.0, 1e-12);
}

TEST(VariantDifferences, CompareTheStillViewWithTheFirstFollowingOfTheTurningOne) {
  const TrialVariant still{"still", "nearest", 0.0, 1.0};
  const TrialVariant small{"turning", "nearest", 0.0, 0.5};
  auto rows = trials_of("delayed", {}, 1);
  append(rows, trials_of("predict", {}, 2));
  append(rows, trials_of("delayed", small, 3));
  append(rows, trials_of("predict", small, 4));
  for (const char* following : {"adapts-0", "adapts-0.5", "adapts-1"}) {
    append(rows, trials_of(following, still, 5));
  }
  const auto analysis = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(analysis.ok()) << analysis.error().to_string();
  EXPECT_EQ(analysis->variants(), 3);
  std::set<std::string> pairs;
  for (const VariantDifference& difference : analysis->differences) {
    pairs.insert(analysis->operators[difference.second].name() + " - " +
                 analysis->operators[difference.first].name());
  }
  EXPECT_EQ(pairs, (std::set<std::string>{"delayed, scale 0.5 - delayed",
                                          "predict, scale 0.5 - predict", "adapts-0 - delayed",
                                          "adapts-0.5 - delayed", "adapts-1 - delayed"}))
      << "pairs that differ in one setting";
}

TEST(VariantDifferences, DoNotPairPeopleWithSimulatedPersons) {
  const TrialVariant still{"still", "nearest", 0.0, 1.0};
  auto rows = trials_of("", {}, 1);
  append(rows, trials_of("", still, 2));
  append(rows, trials_of("delayed", {}, 3));
  append(rows, trials_of("adapts-0", still, 4));
  const auto analysis = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(analysis.ok()) << analysis.error().to_string();
  std::set<std::string> pairs;
  for (const VariantDifference& difference : analysis->differences) {
    pairs.insert(analysis->operators[difference.second].name() + " - " +
                 analysis->operators[difference.first].name());
  }
  EXPECT_EQ(pairs, (std::set<std::string>{"people, view still - people", "adapts-0 - delayed"}));
}

// Differences by rounding alone are no differences.
TEST(VariantDifferences, OfRoundingHaveNoTest) {
  auto rows = trials_of("delayed", {}, 1);
  auto turned = rows;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    turned[i].start_orientation_deg = 45.0;
    double& time = *turned[i].measures[kTotalTime];
    time = i % 3 == 0 ? std::nextafter(time, 1e9) : time;
  }
  append(rows, turned);
  const auto analysis = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(analysis.ok()) << analysis.error().to_string();
  for (const VariantDifference& difference : analysis->differences) {
    EXPECT_TRUE(std::isnan(difference.test.p)) << difference.test.p;
  }
}

// Many levels of one setting are compared with the first one only.
TEST(VariantDifferences, GrowWithTheNumberOfLevelsAndNotWithItsSquare) {
  std::vector<TrialRow> rows;
  constexpr int kLevels = 20;
  for (int level = 0; level < kLevels; ++level) {
    append(rows, trials_of("delayed", {"turning", "nearest", 5.0 * level, 1.0}, 1, 2));
  }
  const auto analysis = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(analysis.ok()) << analysis.error().to_string();
  EXPECT_EQ(analysis->differences.size(), (kLevels - 1) * 4u * 6u);
  for (int level = kLevels; level <= 100; ++level) {
    append(rows, trials_of("delayed", {"turning", "nearest", 3.0 * level + 100.0, 1.0}, 1, 2));
  }
  const auto refused = analyse_trials(rows, kLimit_s);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().problem.find("101 experiments; expected at most 100"),
            std::string::npos)
      << refused.error().to_string();
}

TEST(VariantReport, HasATableOfDifferencesIfThereAreSeveralVariants) {
  auto rows = trials_of("delayed", {}, 1);
  std::vector<std::string> warnings;
  const auto one = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(one.ok());
  EXPECT_EQ(experiment_report_html(*one, {"t.csv", kLimit_s}, warnings).find("id=\"differences\""),
            std::string::npos);
  EXPECT_TRUE(analysis_tables(*one).back().rows.empty());
  append(rows, trials_of("delayed", {"turning", "nearest", 45.0, 1.0}, 2));
  const auto two = analyse_trials(rows, kLimit_s);
  ASSERT_TRUE(two.ok());
  const std::string page = experiment_report_html(*two, {"t.csv", kLimit_s}, warnings);
  EXPECT_NE(page.find("id=\"differences\""), std::string::npos);
  EXPECT_NE(page.find("delayed, start 45 deg \u2212 delayed"), std::string::npos);
  const ResultTable table = analysis_tables(*two).back();
  EXPECT_EQ(table.name, "differences");
  EXPECT_EQ(table.rows.size(), 4u * 6u);  // outcomes x conditions
  for (const ResultTable& each : analysis_tables(*two)) {
    for (const auto& row : each.rows) ASSERT_EQ(row.size(), each.columns.size()) << each.name;
  }
}

TEST(VariantAnalysis, NamesTheVariantInItsErrors) {
  auto rows = trials_of("delayed", {}, 1);
  append(rows, trials_of("delayed", {"turning", "nearest", 45.0, 1.0}, 2, 1));
  const auto refused = analyse_trials(rows, kLimit_s);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().element.find("following delayed, start 45 deg, participant"),
            std::string::npos)
      << refused.error().to_string();
}

}  // namespace
}  // namespace palpate
