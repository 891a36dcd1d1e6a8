#pragma once

// Numbers and sentences about a comparison of strategies, for readers.

#include <string>
#include <vector>

#include "engine/analysis/strategy_comparison.h"

namespace palpate {

// "contact angle, deg"; "losses of contact"
std::string measure_heading(const ComparedMeasure& measure);

// How many decimals show the means of a measure with three digits; the same for all strategies.
int shown_decimals(const MeasureComparison& comparison);

// In the shown unit: "12.3"; "-" without a value.
std::string shown_mean(const ComparedMeasure& measure, const MeanInterval& mean, int decimals);

// "-1.23 +- 0.45" with this sign between the two; "-" without a value.
std::string shown_interval(const ComparedMeasure& measure, const MeanInterval& interval,
                           int decimals, const std::string& plus_minus);

// The strategies to which a4 loses, in the order of tables, each with its measures: "mask", then
// "port work -52.1 +- 3.2 mJ".
struct LossesToStrategy {
  std::string strategy;
  StrategyRole role;
  std::vector<std::string> measures;
};
std::vector<LossesToStrategy> losses_by_strategy(const FollowingComparison& comparison,
                                                 const std::string& plus_minus);

// The techniques that lead by a measure: "a4", "a4 (tied: cd)", "tie of all", "-".
std::string leaders_text(const MeasureComparison& comparison);

// What the intervals of simulated hands mean.
extern const std::string kSimulatedHandsSentence;

// For a terminal: the means of all scenes together, the leaders, where a4 loses, and strategies
// whose trials are not comparable.
std::string comparison_text(const FollowingComparison& comparison);

}  // namespace palpate
