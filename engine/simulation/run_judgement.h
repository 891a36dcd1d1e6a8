#pragma once

// Decides whether the results of a run are comparable. Every criterion can be recomputed from the
// trace and from the contour or places file written beside it.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/simulation/exploration.h"

namespace palpate {

// The least share of the run's ticks that must be in contact. If the share is smaller, averages
// over the ticks in contact are not printed, and the run is not comparable.
inline constexpr double kLeastContactShareOfMeans = 0.05;

// The least share of the contour, or of the places, that the proxy must cover.
inline constexpr double kLeastWayShare = 0.9;

// The longest allowed interval without contact after the first touch, as a share of the run.
inline constexpr double kLongestGapShare = 0.1;

// The reason why a run is not comparable with others.
enum class Shortfall : std::uint8_t { kNeverTouched, kLittleContact, kLostContact, kLittleWay };

// The shortfalls of a run; empty for a comparable run. The only shortfall of a run that never
// touched a surface is kNeverTouched.
std::vector<Shortfall> shortfalls(const ExplorationRun& run);

inline bool is_comparable(const ExplorationRun& run) {
  return shortfalls(run).empty();
}
bool are_comparable(const std::vector<ExplorationRun>& runs);

// A sentence for each shortfall. It states the value found, the value expected and, if the run
// shows it, the cause.
std::vector<std::string> reasons(const ExplorationRun& run);

// The largest extent of the contour or of the places, m.
double way_extent_m(const ExplorationRun& run);

// Whether the contour or the places span at most two press depths, so that the hand slips off.
bool slips_off(const ExplorationRun& run);

bool has_means(const RunSummary& summary);

// Whether the hand was still advancing when the run ended, which means that the run was too short.
bool was_still_getting_on(const ExplorationRun& run);

}  // namespace palpate
