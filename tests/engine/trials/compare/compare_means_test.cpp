// The means of strategies, against tables computed by hand.

#include "engine/trials/compare/compare_means.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/compare/compared_measures.h"

namespace palpate {
namespace {

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

const std::vector<std::string> kStrategies = {"none", "mask", "a4"};
const std::vector<std::string> kScenes = {"A", "B"};

// Angles of three hands on the scenes A and B.
std::vector<TrialRow> small_trials() {
  struct Angles {
    const char* strategy;
    std::array<double, 3> a, b;
  };
  std::vector<TrialRow> rows;
  for (const Angles& angles :
       {Angles{"none", {9, 9, 9}, {9, 9, 9}}, Angles{"mask", {40, 42, 44}, {50, 52, 54}},
        Angles{"a4", {10, 14, 15}, {20, 22, 27}}}) {
    for (int hand = 1; hand <= 3; ++hand) {
      const auto place = static_cast<std::size_t>(hand - 1);
      rows.push_back(trial(angles.strategy, hand, "A", angles.a[place]));
      rows.push_back(trial(angles.strategy, hand, "B", angles.b[place]));
    }
  }
  return rows;
}

std::size_t place_of(const std::string& column) {
  std::size_t place = 0;
  while (compared_measures()[place].column != column) ++place;
  return place;
}

StrategyMeans means_of(const std::vector<TrialRow>& rows) {
  return strategy_means(rows, "delayed", kStrategies, kScenes, 0.5);
}

TEST(StrategyMeans, AreThoseComputedByHand) {
  const StrategyMeans means = means_of(small_trials());
  EXPECT_EQ(means.hands, 3);
  EXPECT_EQ(means.scenes, (std::vector<std::string>{"", "A", "B"}));
  const std::size_t angle = place_of("mean_contact_angle_deg");
  EXPECT_EQ(means.mean(0, angle, 1).mean, 47.0);
  EXPECT_EQ(means.mean(0, angle, 2).mean, 18.0);
  EXPECT_EQ(means.mean(0, angle, 2).hands, 3);
  EXPECT_EQ(means.mean(1, angle, 2).mean, 13.0);
  EXPECT_EQ(means.mean(2, angle, 2).mean, 23.0);
  EXPECT_EQ(means.mean(0, place_of("total_time_s"), 2).hands, 0) << "nobody has a time";
  EXPECT_TRUE(std::isnan(means.mean(0, place_of("total_time_s"), 2).mean));
  EXPECT_TRUE(means.incomplete().empty());
}

// Hand 1 did not complete B with a4, and hand 3 completed nothing with it.
TEST(StrategyMeans, AreOfTrialsThatWereCompleted) {
  auto rows = small_trials();
  for (TrialRow& row : rows) {
    if (row.strategy != "a4") continue;
    if (row.participant == "1" && row.object == "B") row.status = TrialStatus::kTimeout;
    if (row.participant == "3") row.status = TrialStatus::kFault;
  }
  const StrategyMeans means = means_of(rows);
  const HandMean& angle = means.mean(0, place_of("mean_contact_angle_deg"), 2);
  EXPECT_EQ(angle.hands, 2);
  EXPECT_EQ(angle.mean, 14.0);  // 10 and 18
  EXPECT_EQ(means.counts[2].trials, 6);
  EXPECT_EQ(means.counts[2].done, 3);
  EXPECT_EQ(means.counts[2].timeouts, 1);
  EXPECT_EQ(means.counts[2].faults, 2);
  EXPECT_EQ(means.incomplete(), std::vector<std::string>{"a4"});
  // Timeouts of hands: 1/2, 0, 0.
  EXPECT_NEAR(means.mean(0, place_of("status"), 2).mean, 0.5 / 3.0, 1e-15);
  EXPECT_NE(means_text(means).find("\nnot comparable: 3 of 6 trials of a4 ended at the red sphere; "
                                   "expected 90 %\n"),
            std::string::npos);
}

// The workspace is 0.5 m. A travel that is as long fits it.
TEST(StrategyMeans, NameStrategiesThatLeaveTheWorkspace) {
  auto rows = small_trials();
  for (TrialRow& row : rows) {
    if (row.strategy == "mask") row.measures[kDeviceTravel] = 0.5;
    if (row.strategy == "a4") row.measures[kDeviceTravel] = row.participant == "1" ? 0.75 : 0.25;
    // What was not completed counts: a scene that runs away is a reason for that.
    if (row.strategy == "a4" && row.object == "B") row.status = TrialStatus::kTimeout;
  }
  const StrategyMeans means = means_of(rows);
  EXPECT_EQ(means.counts[0].largest_travel_m, std::nullopt);
  EXPECT_EQ(means.counts[1].beyond_workspace, 0);
  EXPECT_EQ(means.counts[1].largest_travel_m, 0.5);
  EXPECT_EQ(means.counts[2].beyond_workspace, 2);
  EXPECT_EQ(means.counts[2].largest_travel_m, 0.75);
  const std::string text = means_text(means);
  EXPECT_NE(text.find("\n! beyond the workspace of 500 mm: a4 in 2 of 6 trials, by up to 250 mm\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("\ndevice travel, mm                 -      500    417 !\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("mask in"), std::string::npos) << text;
  EXPECT_NE(strategies_csv({means}).find("delayed,a4,technique,6,3,3,0,2,0.75\n"),
            std::string::npos);
}

TEST(StrategyMeans, OfMagnitudesWhereZeroIsTheBest) {
  std::vector<TrialRow> rows = {trial("mask", 1, "A", 1.0), trial("mask", 2, "A", 1.0)};
  rows[0].measures[kWorkLost] = -0.5;
  rows[1].measures[kWorkLost] = 0.25;
  const StrategyMeans means = strategy_means(rows, "delayed", {"mask"}, {"A"}, 0.5);
  ASSERT_EQ(means.scenes.size(), 1u) << "one scene is all scenes";
  EXPECT_EQ(means.mean(0, place_of("work_lost_J"), 0).mean, 0.375);
}

TEST(StrategyMeans, NinetyPercentOfTheTrialsAreEnough) {
  StrategyCounts counts;
  counts.trials = 80;
  counts.done = 72;
  EXPECT_TRUE(counts.is_comparable());
  counts.done = 71;
  EXPECT_FALSE(counts.is_comparable());
}

TEST(StrategyMeans, LeaveOutOtherFollowingsPracticeAndStrategies) {
  auto rows = small_trials();
  const std::string expected = means_csv({means_of(rows)});
  rows.push_back(trial("a4", 1, "A", 1000.0));
  rows.back().following = "predict";
  rows.push_back(trial("a4", 1, "A", 1000.0));
  rows.back().block = 0;
  rows.push_back(trial("full", 1, "A", 1000.0));
  EXPECT_EQ(means_csv({means_of(rows)}), expected);
}

TEST(StrategyMeans, AreTheSameInTheTableTheTextAndAsJson) {
  const std::vector<StrategyMeans> followings = {means_of(small_trials())};
  EXPECT_TRUE(means_csv(followings)
                  .starts_with("following,scene,measure,column,unit,better,strategy,role,hands,mean"
                               "\ndelayed,,contact angle,mean_contact_angle_deg,deg,lower,none,"
                               "reference,3,9\ndelayed,,contact angle,mean_contact_angle_deg,deg,"
                               "lower,mask,technique,3,47\n"));
  EXPECT_TRUE(
      strategies_csv(followings)
          .starts_with("following,strategy,role,trials,done,timeouts,faults,beyond_workspace,"
                       "largest_travel_m\n"
                       "delayed,none,reference,6,6,0,0,0,\n"));
  EXPECT_TRUE(means_text(followings.front())
                  .starts_with("mean over 3 hands              none     mask       a4\n"
                               "contact angle, deg              9.0     47.0     18.0\n"
                               "penetration, mm                   -        -        -\n"))
      << means_text(followings.front());
  const StrategyMeans settled = strategy_means({trial("anisotropic:0.25", 1, "A", 1.0)}, "delayed",
                                               {"mask", "anisotropic:0.25"}, {"A"}, 0.5);
  EXPECT_TRUE(
      means_text(settled).starts_with("mean over 1 hands              mask  anisotropic\n"
                                      "                                           :0.25\n"
                                      "contact angle, deg                -         1.00\n"))
      << means_text(settled);
  CompareSettings settings;
  settings.device.sensors = 2;
  settings.scenes = {"A.glb", "B.glb"};
  const auto json = means_json(settings, followings);
  EXPECT_EQ(json["means"].size(), 3u * 18u * 3u);
  EXPECT_EQ(json["means"][1]["mean"], 47.0);
  EXPECT_EQ(json["strategies"][1]["done"], 6);
  EXPECT_EQ(json["comparable"]["delayed"], true);
}

}  // namespace
}  // namespace palpate
