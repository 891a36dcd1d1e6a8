#pragma once

// Paired differences between the variants of a plan: its levels of view, start orientation and
// scale, which have the same persons and random numbers.

#include <cstddef>
#include <string>
#include <vector>

#include "engine/analysis/comparisons.h"
#include "engine/analysis/trial_table.h"

namespace palpate {

// The difference second - first at a level of Haptic and of Rotation. The value of a participant is
// the mean of the differences between trials with the same object and block, for which both
// variants have the outcome.
struct VariantDifference {
  std::size_t first = 0, second = 0;  // indices of the tables
  Outcome outcome = Outcome::kTime;
  std::string haptic, rotation;
  PairedT test;  // of the participants who have a value; NaN without one
};

// Two tables are compared if their variants differ in one setting, and if both are of people or
// both of simulated persons. A setting with more than kMostLevelsInPairs levels is compared with
// its first level only. Simulated persons have the same following; with two views, each following
// of the still view is compared with the first following of the turning view: without rotation they
// have the same rows, and with it the followings of the still view state what the person adapts to.
//
// Outcomes: time, losses, penetration and contact angle, where both tables have them, and the time
// with timeouts as the limit, if there are timeouts. The order is
// that of the tables, outcomes and conditions.
inline constexpr std::size_t kMostLevelsInPairs = 6;
std::vector<VariantDifference> variant_differences(const std::vector<const TrialTable*>& tables);

}  // namespace palpate
