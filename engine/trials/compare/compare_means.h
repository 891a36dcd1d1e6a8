#pragma once

// The means of a comparison of strategies, from the files of its trials. Differences, intervals and
// ranks are statistics, which the Python package palpate.analysis computes from the same files.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/trials/compare/compare_plan.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"

namespace palpate {

// How the trials of a strategy ended, and how far the device travelled in them.
struct StrategyCounts {
  int trials = 0;
  int done = 0;
  int timeouts = 0;
  int faults = 0;
  // Of the trials in which the clock started, completed or not (kDeviceTravel).
  int beyond_workspace = 0;                // a device with this workspace cannot make them
  std::optional<double> largest_travel_m;  // no value: in none

  // At least 90 % of the trials were completed.
  bool is_comparable() const { return 10 * done >= 9 * trials; }
};

// A mean over hands. The value of a hand is the mean over its scenes; a trial without a value is
// left out.
struct HandMean {
  int hands = 0;      // those that have a value
  double mean = 0.0;  // NaN without a hand
};

// The means of one following.
struct StrategyMeans {
  std::string following;
  int hands = 0;
  double workspace_m = 0.0;             // workspace_extent_m() of the device
  std::vector<std::string> strategies;  // all of the plan
  std::vector<StrategyCounts> counts;   // of each strategy
  std::vector<std::string> scenes;  // "", which is all together; then each, if there are several
  std::vector<HandMean> means;      // by scene, compared measure and strategy

  const HandMean& mean(std::size_t scene, std::size_t measure, std::size_t strategy) const;
  // Strategies of which fewer than 90 % of the trials were completed.
  std::vector<std::string> incomplete() const;
};

// rows: of trials.csv, in any order; those of other followings, of practice and of other strategies
// are left out. scenes: the names of all objects. workspace_m: the extent of the device's
// workspace.
StrategyMeans strategy_means(const std::vector<TrialRow>& rows, const std::string& following,
                             const std::vector<std::string>& strategies,
                             const std::vector<std::string>& scenes, double workspace_m);

// The means of a complete comparison (compare_run.h) whose trials are in this folder: one result
// for each following, in the order of the plan. Errors: those of compare_plan() and read_trials().
Result<std::vector<StrategyMeans>> compare_means(const CompareSettings& settings,
                                                 const std::string& folder);

// The files means.csv and strategies.csv. An empty scene stands for all scenes together.
inline constexpr const char* kMeansFile = "means.csv";
inline constexpr const char* kStrategiesFile = "strategies.csv";
std::string means_csv(const std::vector<StrategyMeans>& followings);
std::string strategies_csv(const std::vector<StrategyMeans>& followings);

// For a terminal: the means of all scenes together, and strategies that are not comparable.
std::string means_text(const StrategyMeans& means);

// The settings and both tables, with the keys of comparison.json.
nlohmann::ordered_json means_json(const CompareSettings& settings,
                                  const std::vector<StrategyMeans>& followings);

}  // namespace palpate
