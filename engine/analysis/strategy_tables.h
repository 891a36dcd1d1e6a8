#pragma once

// All numbers of a comparison of strategies, for other programs.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "engine/analysis/result_table.h"
#include "engine/analysis/strategy_comparison.h"
#include "engine/trials/compare/compare_plan.h"

namespace palpate {

// The names of the tables, which are those of the CSV files, in the order of strategy_tables().
inline constexpr std::array<std::string_view, 4> kStrategyTableNames = {"strategies", "means",
                                                                        "a4_losses", "tuning"};

// How the trials of each strategy ended; every mean with its differences to mask and to a4; the
// measures in which a4 loses; the tuning. Units are those of trials.csv. An empty scene stands for
// all scenes together.
std::vector<ResultTable> strategy_tables(const std::vector<FollowingComparison>& followings);

// The tables as one JSON document, which begins with the settings. It has no paths but those of the
// scenes, as the user named them.
std::string comparison_json(const CompareSettings& settings,
                            const std::vector<FollowingComparison>& followings);

}  // namespace palpate
