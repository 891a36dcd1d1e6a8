#pragma once

// The plan of a comparison of strategies: what `palpate compare` writes and runs.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "engine/trials/plan.h"
#include "geometry/base/result.h"
#include "haptics/strategies/anisotropic.h"

namespace palpate {

// The strategies of `anisotropic` in a list: several values of E, each a strategy of its own.
std::vector<Strategy> anisotropic_strategies();
// The list of all strategies, and the same for a help text.
std::string every_strategy();
std::string strategies_help();

struct CompareSettings {
  std::vector<std::string> scenes;  // paths of glTF files, from the current folder
  SceneSettings scene;              // of every scene: as in PlanObject
  RunSettings device;               // two sensors; force, A4 and moves are not used
  int hands = 20;
  std::vector<Strategy> strategies;
  std::string person = "people2005";
  bool has_all_followings = false;  // false: kDelayed alone
  std::uint64_t seed = 2005;
};

// Reads a list of names of strategies, separated by commas; `anisotropic` without a number stands
// for anisotropic_strategies(). An error has the element "strategies".
Result<CompareSettings> with_strategies(CompareSettings settings, std::string_view list);

// The text of a plan for a file in this folder, with paths that lead from there to the scenes. The
// objects have the names of the files, without what kMostObjectNameBytes and plans do not allow;
// equal names get a number. The sizes of the spheres, the display and the time limit are those of
// the paper's plan.
std::string compare_plan_text(const CompareSettings& settings, const std::string& folder);

// The plan itself, whose scenes have the paths of the settings, so that errors name them. Errors of
// the plan have no path.
Result<ExperimentPlan> compare_plan(const CompareSettings& settings);

}  // namespace palpate
