#pragma once

// Means of trials by condition, and the trials that are missing.

#include <vector>

#include "engine/analysis/intervals.h"
#include "engine/analysis/trial_table.h"

namespace palpate {

// The levels of a mean; -1: over all levels.
struct TrialLevels {
  int haptic = -1, rotation = -1, object = -1;
};

// Mean and standard deviation (n - 1) of the trials that have an outcome; NaN if there are too few
// such trials.
struct TrialMean {
  TrialLevels at;
  int trials = 0;
  double mean = 0.0, sd = 0.0;
};
TrialMean trial_mean(const TrialTable& table, Outcome outcome, const TrialLevels& at);

// The levels of tables of means: all, each level of each factor, and each combination of Rotation
// and Haptic. Factors with one level are left out.
std::vector<TrialLevels> levels_of_means(const TrialTable& table);

// "all trials", "UaH", "R", "UaH, R", "UaH, R, O2"
std::string levels_name(const TrialTable& table, const TrialLevels& at);

// How the trials at these levels ended. timeout_share: the share of timeouts among the trials that
// took place.
struct TrialCounts {
  TrialLevels at;
  int done = 0, timeouts = 0, faults = 0;
  int absent = 0;  // no row for a participant, a condition and a block
  Interval timeout_share;

  int missing() const { return timeouts + faults + absent; }
};
TrialCounts trial_counts(const TrialTable& table, const TrialLevels& at);

// The counts of every condition.
std::vector<TrialCounts> counts_by_condition(const TrialTable& table);

}  // namespace palpate
