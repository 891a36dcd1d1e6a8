// The rows of an experiment with real trials, from the version before trials.csv had its last four
// columns: without them, every byte is the same.

#include <string>

#include <gtest/gtest.h>

#include "engine/trials/deal/participant_run.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/plan.h"

namespace palpate {
namespace {

// The paper's plan with fewer participants, blocks, objects and followings.
constexpr const char* kPlan = R"({"palpate_plan": 1, "name": "paper", "seed": 2005,
    "participants": 2, "blocks": 1, "practice_blocks": 0,
    "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
               "damping_Ns_per_m": 2},
    "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 120,
    "haptic": ["NoH", "UaH", "H"], "rotation": ["NoR", "R"],
    "objects": {"O1": "star.glb", "O4": "lock.glb"},
    "operator": "people2005", "followings": ["delayed", "frozen"]})";

constexpr std::string_view kNewColumns = ",turning,nearest,0,1";
// The column effects_capped is new, too; this many columns stand before it.
constexpr int kColumnsBeforeEffectsCapped = 38;

std::string without_effects_capped(std::string_view line) {
  std::size_t begin = 0;
  for (int i = 0; i < kColumnsBeforeEffectsCapped; ++i) begin = line.find(',', begin) + 1;
  const std::size_t end = line.find(',', begin) + 1;
  return std::string(line.substr(0, begin)).append(line.substr(end));
}

TEST(GoldenTrials, KeepTheBytesOfTheirOldColumns) {
  const auto plan = parse_plan(kPlan, "plan.json", PALPATE_MODELS_DIR);
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  const TrialFunctions functions{find_trial_way, run_trial};
  const auto scenes = load_experiment_scenes(*plan, functions);
  ASSERT_TRUE(scenes.ok()) << scenes.error().to_string();
  std::string old_columns;
  for (const int participant : {1, 2}) {
    UnitTrials trials;
    const auto run = run_participant(*plan, *scenes, functions, participant, "", trials);
    ASSERT_TRUE(run.ok());
    std::string_view rows = (*run)->rows;
    for (std::size_t end = rows.find('\n'); end != std::string_view::npos; end = rows.find('\n')) {
      const std::string_view line = rows.substr(0, end);
      ASSERT_TRUE(line.ends_with(kNewColumns)) << line;
      old_columns.append(without_effects_capped(line.substr(0, line.size() - kNewColumns.size())))
          .append("\n");
      rows.remove_prefix(end + 1);
    }
  }
  EXPECT_EQ(hash_text(KeyHash().add(old_columns).value()), "d9cf7b6d9c901f69");
}

}  // namespace
}  // namespace palpate
