#pragma once

// Whether the figures of a run mean anything. All that decides can be computed by anybody from the
// trace and from the contour or the places that are written beside it.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/simulation/exploration.h"

namespace palpate {

// A mean over contact is not printed of a run that was in contact for less than this share of it,
// and such a run is not comparable.
inline constexpr double kLeastContactShareOfMeans = 0.05;

// The least share of the contour, or of the places, that the proxy comes near to.
inline constexpr double kLeastWayShare = 0.9;

// The longest part of a run without contact, at a stretch after the first touch.
inline constexpr double kLongestGapShare = 0.1;

// What a run lacks to be compared with others.
enum class Shortfall : std::uint8_t { kNeverTouched, kLittleContact, kLostContact, kLittleWay };

// Nothing for a run that is comparable. A run that never touched lacks that alone.
std::vector<Shortfall> shortfalls(const ExplorationRun& run);

inline bool is_comparable(const ExplorationRun& run) {
  return shortfalls(run).empty();
}
bool are_comparable(const std::vector<ExplorationRun>& runs);

// A sentence for each shortfall: what was found, what is expected, and the cause as far as the run
// shows it.
std::vector<std::string> reasons(const ExplorationRun& run);

// The largest extent of what the hand followed. m.
double way_extent_m(const ExplorationRun& run);

// What the hand followed is no wider than it presses deep from both sides: it slips off.
bool slips_off(const ExplorationRun& run);

bool has_means(const RunSummary& summary);

// Whether the hand was still getting on when the run ended: its time was too short.
bool was_still_getting_on(const ExplorationRun& run);

}  // namespace palpate
