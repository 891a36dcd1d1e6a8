#pragma once

// Whether the figures of a run say anything: from what anybody can compute from its trace and from
// what the hand followed, which is written beside it.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/exploration.h"

namespace palpate {

// Means over contact of a run that was in contact for less are not told.
inline constexpr double kLeastContactShareOfMeans = 0.05;

// The least part of what the hand set out to touch.
inline constexpr double kLeastWayShare = 0.9;

// The longest part of a run without contact, at a stretch after the first touch.
inline constexpr double kLongestGapShare = 0.1;

// What a run lacks to be compared with others.
enum class Shortfall : std::uint8_t { kNeverTouched, kLostContact, kLittleWay };

// A sentence: what was found, and what is the least or most of it.
std::string shortfall_text(Shortfall shortfall, const ExplorationRun& run);

// Nothing for a run that is comparable. A run that never touched lacks that alone.
std::vector<Shortfall> shortfalls(const ExplorationRun& run);

bool has_means(const RunSummary& summary);

}  // namespace palpate
