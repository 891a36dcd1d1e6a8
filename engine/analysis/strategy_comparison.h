#pragma once

// Compares strategies on the same hands and scenes: means, paired differences, and which is best.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/analysis/compared_measures.h"
#include "engine/analysis/intervals.h"
#include "engine/analysis/strategy_trials.h"
#include "engine/trials/compare/compare_plan.h"
#include "engine/trials/trial_row.h"

namespace palpate {

// How a strategy takes part in a comparison.
enum class StrategyRole : std::uint8_t {
  kReference,  // none and full: shown, but not ranked, since no device with missing motors is meant
  kTechnique,  // ranked
  kLevel       // a value of E that was tried: shown, and ranked only as kTunedStrategy
};
inline constexpr std::array<std::string_view, 3> kStrategyRoleNames = {"reference", "technique",
                                                                       "level"};

enum class Standing : std::uint8_t {
  kOther,
  kBest,  // the best mean of all techniques
  kTied   // the interval of its difference to the best holds 0, or there is no interval
};
inline constexpr std::array<std::string_view, 3> kStandingNames = {"", "best", "tied"};

// A strategy by one measure.
struct StrategyEntry {
  std::string strategy;  // name_of(), or kTunedStrategy
  std::string tuned_to;  // of kTunedStrategy: the value of E, as "anisotropic:4"
  StrategyRole role = StrategyRole::kTechnique;
  MeanInterval mean;
  // Paired differences; no value: this strategy itself, or not compared.
  std::optional<MeanInterval> minus_mask;
  std::optional<MeanInterval> minus_a4;
  Standing standing = Standing::kOther;
};

struct MeasureComparison {
  const ComparedMeasure* measure = nullptr;
  std::vector<StrategyEntry> entries;  // in the same order for all measures

  // The best technique and those tied with it, by name.
  std::vector<std::string> leaders() const;
  // There are several techniques with a value, and all of them are leaders.
  bool is_tie_of_all() const;
};

struct SceneComparison {
  std::string scene;  // the object; empty: all together
  std::vector<MeasureComparison> measures;
};

// A value of E by one measure, on the hands that tuned it.
struct TuningEntry {
  std::string scene;  // empty: all together
  const ComparedMeasure* measure = nullptr;
  std::string strategy;
  MeanInterval mean;
  bool is_chosen = false;
};

struct StrategyOutcome {
  std::string strategy;
  StrategyRole role;
  StrategyCounts counts;
};

// A measure in which another strategy is better than a4: the interval of the difference to a4 lies
// on the better side of 0.
struct A4Loss {
  const ComparedMeasure* measure;
  const StrategyEntry* better;
};

struct FollowingComparison {
  std::string following;
  int hands = 0;
  std::vector<StrategyOutcome> outcomes;
  std::vector<SceneComparison> scenes;  // all together first; the rest only if there are several
  std::vector<TuningEntry> tuning;      // empty: no strategy was tuned

  // Strategies of which fewer than 90 % of the trials were completed. A value of E counts only if
  // a measure chose it.
  std::vector<std::string> incomplete() const;
  // Of all scenes together. The pointers are valid as long as this object.
  std::vector<A4Loss> a4_losses() const;
};

// What is compared.
struct ComparedStrategies {
  std::vector<std::string> strategies;  // name_of(), in the order of tables
  std::vector<std::string> levels;      // values of E; empty: nothing is tuned
  std::vector<std::string> scenes;      // names of objects
};

// rows: of all strategies and levels. tuning_rows: of the levels, by other hands. For each measure,
// and for each scene and all together, kTunedStrategy is the level with the best mean in
// tuning_rows; of equal means, the one nearest to E = 1. A level that completed less than 90 % of
// its tuning trials is chosen only if every level did.
FollowingComparison compare_strategies(const std::vector<TrialRow>& rows,
                                       const std::vector<TrialRow>& tuning_rows,
                                       const ComparedStrategies& compared,
                                       const std::string& following);

}  // namespace palpate
