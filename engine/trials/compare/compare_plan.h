#pragma once

// The plans of a comparison of strategies: what `palpate compare` writes and runs.

#include <array>
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

// The name of the strategy that stands for the best of several values of E.
inline constexpr std::string_view kTunedStrategy = kAnisotropicStrategy.name;
// The values of E that are tried.
inline constexpr std::array<double, 6> kTunedAnisotropies = {1.0 / 16, 0.25, 0.5, 2.0, 4.0, 16.0};
std::vector<Strategy> tuned_levels();
// The list of all strategies, and the same for a help text. Of those that need a
// number, only kTunedStrategy is in the list.
std::string every_strategy();
std::string strategies_help();

struct CompareSettings {
  std::vector<std::string> scenes;  // paths of glTF files, from the current folder
  SceneSettings scene;              // of every scene: as in PlanObject
  RunSettings device;               // two sensors; force, A4 and moves are not used
  int hands = 20;
  std::vector<Strategy> strategies;
  bool is_tuned = false;  // with kTunedStrategy, at the end of the list
  std::string person = "people2005";
  bool has_all_followings = false;  // false: kDelayed alone
  std::uint64_t seed = 2005;
};

// Reads a list of names of strategies, separated by commas; kTunedStrategy is allowed. An error has
// the element "strategies".
Result<CompareSettings> with_strategies(CompareSettings settings, std::string_view list);

// Which hands a plan has. The hands that tune have other random numbers than those compared.
enum class CompareHands : std::uint8_t { kCompared, kTuning };

// The seed of the plan of these hands.
std::uint64_t compare_seed(std::uint64_t seed, CompareHands hands);

// The text of a plan for a file in this folder, with paths that lead from there to the scenes. The
// objects have the names of the files, without what kMostObjectNameBytes and plans do not allow;
// equal names get a number. The sizes of the spheres, the display and the time limit are those of
// the paper's plan.
std::string compare_plan_text(const CompareSettings& settings, CompareHands hands,
                              const std::string& folder);

// The plan itself, whose scenes have the paths of the settings, so that errors name them. Errors of
// the plan have no path.
Result<ExperimentPlan> compare_plan(const CompareSettings& settings, CompareHands hands);

}  // namespace palpate
