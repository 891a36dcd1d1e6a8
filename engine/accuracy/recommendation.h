#pragma once

// Judges the measurements of a knob: the Pareto front, the rank of the default, and the recommended
// level.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/accuracy/measurement.h"

namespace palpate {

// Medians that differ by no more than this factor count as equal. The times of one level in two
// runs of the program on an idle machine differ by up to this factor, because the addresses of code
// and data differ.
inline constexpr double kAlikeFactor = 1.15;

// Whether two spreads count as equal: the intervals between their quartiles overlap, or their
// medians are within kAlikeFactor.
bool is_alike(const Spread& a, const Spread& b);

// Whether the quartiles of `a` lie below those of `b`: the effect is larger than the whiskers.
bool is_below(const Spread& a, const Spread& b);

// Whether `a` is clearly better than `b` in time or in error, and clearly worse in neither.
// "Clearly" means that the two spreads are not is_alike().
bool is_clearly_better(const LevelResult& a, const LevelResult& b);

// The index of the level to choose. Levels that do not count are left out.
//  1. Only levels with an error of at most `enough` are considered. If there are none, all levels
//     are considered, and steps 2 and 3 are exchanged.
//  2. Levels stay if their time is about the shortest.
//  3. Levels stay if their error is about the smallest.
//  4. The levels that are left are tied. The default is chosen, or else the level nearest to it.
// "About" means that the medians are within kAlikeFactor. For the default, "about" means
// is_alike(). A wide spread thus favours the default, but does not decide between other levels.
// `distance[i]` ranks level i for step 4: 0 for the default, more for levels farther from it.
// Returns no value if no level counts.
std::optional<std::size_t> chosen_level(std::span<const LevelResult* const> levels,
                                        std::span<const std::size_t> distance, double enough);

// Sets LevelResult::on_front of every level, default_behind, better_than_default, recommended and
// undecided. A level is on the front if no other level is clearly better. Nothing is recommended in
// place of a default that counts if neither error nor time is_below() that of the default.
void judge(KnobResult& result);

// A Knob::decided_by names another knob. If the other knob is among the results and has the same
// methods and levels, its recommendation, or that it is undecided, replaces that of the knob that
// names it.
void reconcile(std::vector<KnobResult>& results);

}  // namespace palpate
