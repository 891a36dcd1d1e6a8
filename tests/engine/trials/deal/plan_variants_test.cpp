// The keys of a plan that change the order, the persons and the scenes of its trials, with a
// stand-in for the trial.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/deal/participant_run.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"
#include "engine/trials/trial_order.h"
#include "engine/trials/trials_file.h"
#include "tests/engine/trials/stand_in_trial.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/slit_tube.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::kEpsilon;

Json base_json() {
  return Json::parse(R"({"palpate_plan": 1, "name": "variants", "seed": 7, "participants": 6,
      "blocks": 2, "practice_blocks": 1,
      "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                 "damping_Ns_per_m": 2, "place": [0.01, 0.02, 0, 1, 0, 0, 0]},
      "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 120,
      "haptic": ["NoH", "UaH", "H"], "rotation": ["NoR", "R"],
      "objects": {"O1": "star.glb", "O2": "labyrinth.glb", "O3": {"file": "lock.glb", "fit_size_m": 0.1}},
      "operator": "people2005", "followings": ["delayed", "replan"]})");
}

ExperimentPlan plan_with(const std::vector<std::pair<const char*, Json>>& keys) {
  Json json = base_json();
  for (const auto& [key, value] : keys) json[key] = value;
  auto plan = parse_plan(json.dump(), "plan.json", PALPATE_MODELS_DIR);
  EXPECT_TRUE(plan.ok()) << plan.error().to_string();
  return *plan;
}

// The levels of the conditions of one block, in order; the objects of a level follow each other.
std::vector<std::size_t> levels_in_order(const ExperimentPlan& plan, int participant, int block) {
  std::vector<std::size_t> levels;
  std::set<std::size_t> objects;
  for (const PlannedTrial& trial : planned_trials(plan, participant)) {
    if (trial.following != Following::kDelayed || trial.block != block) continue;
    const PlanCondition& c = trial.condition;
    const std::size_t level =
        c.strategy ? *c.strategy : c.haptic * plan.rotation.size() + c.rotation;
    if (objects.empty()) levels.push_back(level);
    EXPECT_EQ(level, levels.back()) << "before all objects of another condition";
    EXPECT_TRUE(objects.insert(c.object).second);
    EXPECT_EQ(trial.trial,
              static_cast<int>((levels.size() - 1) * plan.objects.size() + objects.size()));
    if (objects.size() == plan.objects.size()) objects.clear();
  }
  EXPECT_TRUE(objects.empty());
  return levels;
}

TEST(WilliamsOrder, BeginsWithTheRowsOfTheSquare) {
  using Row = std::vector<std::size_t>;
  EXPECT_EQ(williams_row(6, 0), (Row{0, 1, 5, 2, 4, 3}));
  EXPECT_EQ(williams_row(6, 1), (Row{1, 2, 0, 3, 5, 4}));
  EXPECT_EQ(williams_row(2, 1), (Row{1, 0}));
  const ExperimentPlan plan = plan_with({{"order", "williams"}});
  EXPECT_EQ(levels_in_order(plan, 1, 0), williams_row(6, 0));
  EXPECT_EQ(levels_in_order(plan, 1, 1), williams_row(6, 1));
  EXPECT_EQ(levels_in_order(plan, 5, 2), williams_row(6, 0));
}

TEST(WilliamsOrder, HasEachOrderedPairAndEachPlaceEquallyOften) {
  struct Case {
    std::vector<std::pair<const char*, Json>> keys;
    int conditions;
  };
  const std::vector<Case> cases = {
      {{{"haptic", {"UaH"}}}, 2}, {{{"haptic", {"UaH", "H"}}}, 4}, {{}, 6}};
  for (const Case& c : cases) {
    for (const int times : {1, 3}) {
      auto keys = c.keys;
      keys.emplace_back("order", "williams");
      keys.emplace_back("participants", times * c.conditions);
      const ExperimentPlan plan = plan_with(keys);
      EXPECT_TRUE(plan.warnings().empty());
      for (const int block : {0, 1, 2}) {
        std::map<std::pair<std::size_t, std::size_t>, int> successions, places;
        for (int participant = 1; participant <= plan.participants; ++participant) {
          const auto levels = levels_in_order(plan, participant, block);
          ASSERT_EQ(levels.size(), static_cast<std::size_t>(c.conditions));
          for (std::size_t i = 0; i < levels.size(); ++i) {
            ++places[{levels[i], i}];
            if (i > 0) ++successions[{levels[i - 1], levels[i]}];
          }
        }
        EXPECT_EQ(successions.size(), static_cast<std::size_t>(c.conditions * (c.conditions - 1)));
        EXPECT_EQ(places.size(), static_cast<std::size_t>(c.conditions * c.conditions));
        for (const auto& [pair, count] : successions) EXPECT_EQ(count, times);
        for (const auto& [place, count] : places) EXPECT_EQ(count, times);
      }
    }
  }
}

TEST(WilliamsOrder, TakesTheObjectsInAnOrderOfItsOwnForEachCondition) {
  const ExperimentPlan plan = plan_with({{"order", "williams"}});
  std::set<std::string> orders;
  for (int participant = 1; participant <= 6; ++participant) {
    std::string order;
    for (const PlannedTrial& trial : planned_trials(plan, participant)) {
      order += std::to_string(trial.condition.object);
      if (order.size() < 3) continue;
      orders.insert(order);
      order.clear();
    }
  }
  EXPECT_EQ(orders.size(), 6u) << "all orders of three objects";
}

TEST(WilliamsOrder, AlsoOrdersStrategies) {
  Json json = base_json();
  json.erase("haptic");
  json.erase("rotation");
  json["strategies"] = {"none", "mask", "a4", "cd"};
  json["order"] = "williams";
  const auto plan = parse_plan(json.dump(), "plan.json", PALPATE_MODELS_DIR);
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  EXPECT_EQ(levels_in_order(*plan, 2, 0), williams_row(4, 1));
  json["strategies"] = {"none", "mask", "a4"};
  const auto odd = parse_plan(json.dump(), "plan.json", PALPATE_MODELS_DIR);
  ASSERT_FALSE(odd.ok());
  EXPECT_EQ(odd.error().element, "/order");
}

TEST(WilliamsOrder, WarnsOfParticipantsWhoLeaveItUnbalanced) {
  EXPECT_TRUE(plan_with({{"participants", 10}}).warnings().empty());
  const auto warnings = plan_with({{"participants", 10}, {"order", "williams"}}).warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("is 10, which is no multiple of 6"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("4 of the 6 orders"), std::string::npos) << warnings[0];
}

// What a trial was given.
struct Given {
  std::uint64_t noise_seed;
  Following following;
  OperatorParameters person;
  ScenePose pose;
  double extent_m;
  double sphere_radius_m;
};

// Runs one participant; each row with what its trial was given.
std::vector<std::pair<TrialRow, Given>> run_given(const ExperimentPlan& plan, int participant = 2) {
  std::vector<Given> given;
  TrialFunctions functions = test::stand_in_trials();
  functions.run = [&, run = functions.run](
                      const Scene& scene, const TrialWay& way, const RunSetup& setup,
                      const TrialSettings& settings, const OperatorParameters& person,
                      const TrialConditions& conditions, const TrialSink& sink) {
    given.push_back({conditions.noise_seed, conditions.following, person,
                     setup.haptics.initial_pose, scene.statistics().extent_m.maxCoeff(),
                     settings.sphere_radius_m});
    return run(scene, way, setup, settings, person, conditions, sink);
  };
  const auto scenes = load_experiment_scenes(plan, functions);
  EXPECT_TRUE(scenes.ok()) << scenes.error().to_string();
  UnitTrials trials;
  const auto run = run_participant(plan, *scenes, functions, participant, "", trials);
  EXPECT_TRUE(run.ok());
  const auto rows = parse_trials(trials_columns() + "\n" + (*run)->rows, "trials.csv");
  EXPECT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_EQ(rows->size(), given.size());
  EXPECT_EQ(rows->size(), plan.trials_per_participant());
  std::vector<std::pair<TrialRow, Given>> all;
  for (std::size_t i = 0; i < given.size(); ++i) all.emplace_back((*rows)[i], given[i]);
  return all;
}

TEST(Learning, MakesTheHandFasterAndSteadierBlockByBlock) {
  const auto plain = run_given(plan_with({}));
  const auto learning = run_given(plan_with({{"learning_exponent", 0.3}}));
  ASSERT_EQ(plain.size(), learning.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const OperatorParameters& before = plain[i].second.person;
    const OperatorParameters& after = learning[i].second.person;
    const double times = std::pow(1.0 + plain[i].first.block, 0.3);
    EXPECT_NEAR(after.speed_m_per_s, before.speed_m_per_s * times, 4 * kEpsilon);
    EXPECT_NEAR(after.intention_noise_m, before.intention_noise_m / times, 4 * kEpsilon);
    EXPECT_EQ(after.sight_delay_s, before.sight_delay_s);
    EXPECT_EQ(plain[i].second.noise_seed, learning[i].second.noise_seed);
    // Practice is block 0, without learning; exponent 0 changes no bit.
    EXPECT_EQ(before.speed_m_per_s, plain[0].second.person.speed_m_per_s);
    if (plain[i].first.block == 0) {
      EXPECT_EQ(after.speed_m_per_s, before.speed_m_per_s);
    }
  }
}

// An object in another size has its gaps closed up to the same part of its size.
TEST(Variants, CloseTheSameGapsInEverySize) {
  const test::TemporaryFolder folder;
  const std::string file = test::slit_tube().write_glb(folder);
  const auto scenes_with = [&](std::optional<double> gap_m) {
    Json object{{"file", file}};
    if (gap_m) object["close_gaps_m"] = *gap_m;
    return load_experiment_scenes(plan_with({{"objects", {{"O1", object}}}, {"scale", {1, 0.5}}}),
                                  test::stand_in_trials());
  };
  for (const auto& [gap_m, joined] : std::vector<std::pair<std::optional<double>, std::size_t>>{
           {{}, 0}, {0.9 * test::kSlit_m, 0}, {1.1 * test::kSlit_m, 1}}) {
    const auto scenes = scenes_with(gap_m);
    ASSERT_TRUE(scenes.ok()) << scenes.error().to_string();
    ASSERT_EQ(scenes->size(), 2u);
    for (const ExperimentScene& scene : *scenes) {
      EXPECT_EQ(scene.scene.statistics().gap_joins.joined_edges, joined) << gap_m.value_or(0.0);
    }
  }
  const auto refused = scenes_with(0.05);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().path, file);
  EXPECT_EQ(refused.error().element, "close_gaps_m");
}

TEST(Variants, AreExperimentsOfTheirOwnWithTheSamePersonsAndNumbers) {
  const auto plain = run_given(plan_with({}));
  const ExperimentPlan plan = plan_with({{"view", {"turning", "still"}},
                                         {"start_orientation_deg", {0, 45, -144}},
                                         {"scale", {1, 0.5}}});
  EXPECT_EQ(plan.variants().size(), 12u);
  const auto all = run_given(plan);
  std::map<std::string, std::uint64_t> seeds;  // of a trial of the plan without variants
  std::map<std::string, double> extents_m;
  const auto key = [](const TrialRow& row) {
    return std::to_string(row.block) + row.haptic + row.rotation + row.object + "#" +
           std::to_string(row.trial);
  };
  for (const auto& [row, given] : plain) {
    seeds[key(row)] = given.noise_seed;
    extents_m[row.object] = given.extent_m;
    EXPECT_EQ(row.view, "turning");
    EXPECT_EQ(row.align, "nearest");
    EXPECT_EQ(row.start_orientation_deg, 0.0);
    EXPECT_EQ(row.scale, 1.0);
  }
  std::map<std::string, int> rows_of;
  for (const auto& [row, given] : all) {
    EXPECT_EQ(given.noise_seed, seeds.at(key(row)));
    EXPECT_EQ(given.person.speed_m_per_s, plain[0].second.person.speed_m_per_s);
    EXPECT_EQ(given.sphere_radius_m, 0.006);
    EXPECT_NEAR(given.extent_m, row.scale * extents_m.at(row.object), 8 * kEpsilon);
    const double turn_rad = row.start_orientation_deg * std::numbers::pi / 180.0;
    const Vec3 x = given.pose.direction(Vec3::UnitX());
    EXPECT_NEAR(x.x(), std::cos(turn_rad), 4 * kEpsilon);
    EXPECT_NEAR(x.y(), std::sin(turn_rad), 4 * kEpsilon);
    // The place of the plan is turned as well, about A3 through the device's origin.
    const Vec3 origin = Eigen::AngleAxisd(turn_rad, Vec3::UnitZ()) * Vec3(0.01, 0.02, 0.0);
    EXPECT_LE((given.pose.translation_m - origin).norm(), 4 * kEpsilon * 0.03);
    const bool is_still = row.following.starts_with("adapts-");
    EXPECT_EQ(row.view, is_still ? "still" : "turning");
    ++rows_of[row.view + row.following + std::to_string(row.start_orientation_deg) + "x" +
              std::to_string(row.scale)];
  }
  EXPECT_EQ(rows_of.size(), (2 + 3) * 3 * 2u);
  for (const auto& [variant, rows] : rows_of) EXPECT_EQ(rows, 3 * 6 * 3) << variant;
}

TEST(Variants, HaveTracesOfTheirOwn) {
  const ExperimentPlan plan =
      plan_with({{"view", {"turning", "still"}}, {"start_orientation_deg", {0, 45}}});
  std::set<std::string> names;
  for (const PlannedTrial& trial : planned_trials(plan, 1)) {
    const std::string name = trace_name(plan, 1, trial);
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_TRUE(is_trace_name(name.substr(name.rfind('/') + 1)));
  }
  EXPECT_TRUE(names.contains("adapts-0.5/participant-1/block-1-trial-07-" +
                             plan.level_name(planned_trials(plan, 1)[24].condition) + "-" +
                             plan.objects[planned_trials(plan, 1)[24].condition.object].name +
                             "-still-45deg-x1.csv"));
}

TEST(StillView, ReplacesTheFollowings) {
  const ExperimentPlan still = plan_with({{"view", {"still"}}});
  std::set<Following> followings;
  for (const PlannedTrial& trial : planned_trials(still, 1)) followings.insert(trial.following);
  EXPECT_EQ(followings,
            (std::set{Following::kAdaptsNone, Following::kAdaptsHalf, Following::kAdaptsWhole}));
  Json json = base_json();
  json.erase("followings");
  json["view"] = {"still"};
  EXPECT_TRUE(parse_plan(json.dump(), "plan.json", PALPATE_MODELS_DIR).ok());
  json["view"] = {"still", "turning"};
  const auto lacks = parse_plan(json.dump(), "plan.json", PALPATE_MODELS_DIR);
  ASSERT_FALSE(lacks.ok());
  EXPECT_EQ(lacks.error().element, "/followings");
}

TEST(Align, IsPartOfEachRowAndOfTheSetup) {
  for (const auto& [row, given] : run_given(plan_with({{"align", "forward"}}))) {
    EXPECT_EQ(row.align, "forward");
  }
  const ExperimentPlan plan = plan_with({{"align", "forward"}});
  const auto setup = make_setup(plan.device);
  ASSERT_TRUE(setup.ok());
  EXPECT_EQ(setup->haptics.a4.align, Alignment::kForward);
}

}  // namespace
}  // namespace palpate
