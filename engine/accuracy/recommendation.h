#pragma once

// Decides what a knob's measurements mean: the Pareto front, the rank of the default, and the level
// recommended.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/accuracy/measurement.h"

namespace palpate {

// Medians that differ by no more than this factor count as equal: the times of one level in two
// runs of the program on an idle machine differ by up to this much, as code and data lie elsewhere.
inline constexpr double kAlikeFactor = 1.15;

// Whether two figures do not differ beyond their spread: their quartiles overlap, or their medians
// are within kAlikeFactor.
bool is_alike(const Spread& a, const Spread& b);

// Whether `a` is clearly better in time or in error, and clearly worse in neither. Clearly: not
// is_alike().
bool is_clearly_better(const LevelResult& a, const LevelResult& b);

// The level to choose. Levels that do not count are left out.
//  1. Only levels with an error of at most `enough` are considered; if there are none, all are, and
//     steps 2 and 3 change places.
//  2. Only those stay whose time is about that of the quickest.
//  3. Only those stay whose error is about the smallest.
//  4. The levels left are ties: the default wins, else the level nearest to it.
// About: within kAlikeFactor; for the default is_alike(), so that a wide spread favours the default
// and does not decide between other levels. `distance[i]` ranks level i for step 4: 0 for the
// default, more for levels farther from it. Nothing if no level counts.
std::optional<std::size_t> chosen_level(std::span<const LevelResult* const> levels,
                                        std::span<const std::size_t> distance, double enough);

// Sets LevelResult::on_front of every level, default_behind, better_than_default and recommended. A
// level is on the front if no level is clearly better.
void judge(KnobResult& result);

// Gives each knob with a Knob::decided_by the recommendation of that knob, if it is among the
// results and has the same methods and levels.
void reconcile(std::vector<KnobResult>& results);

}  // namespace palpate
