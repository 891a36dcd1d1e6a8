#pragma once

// The primary analysis: repeated measures on the cell means of participants. A cell is one
// participant in one condition. Its mean is the mean of this participant's completed trials in this
// condition. No missing trial is replaced by a number: an effect, a comparison or a mean is
// computed from the participants who have all cells that it needs, and states their number.

#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/comparisons.h"
#include "engine/analysis/repeated_measures.h"
#include "engine/analysis/trial_table.h"

namespace palpate {

// An effect, tested on `participants` participants. test: no value if fewer than two participants
// have all cells, or if the effect is the same for all of them to within rounding.
struct PrimaryEffect {
  FactorSet term;  // of ExperimentFactors
  int participants = 0;
  std::optional<RepeatedEffect> test;
};

// Paired t tests of one family. p_holm: adjusted within the family.
struct PrimaryPair {
  std::string name;  // "H - UaH"
  PairedT test;
  double p_holm = 0.0;
};
struct PrimaryFamily {
  std::string name;
  std::vector<PrimaryPair> pairs;
};

// A mean over participants at a level of Haptic and a level of Rotation (-1: over all levels).
// half_width: the half width of its Cousineau-Morey interval; NaN if it cannot be computed.
struct PrimaryMean {
  int haptic = -1, rotation = -1;
  double mean = 0.0, half_width = 0.0;
  int participants = 0;
};

struct PrimaryAnalysis {
  Outcome outcome;
  std::optional<int> only_haptic;  // the level of Haptic that is analysed alone
  std::vector<PrimaryEffect> effects;
  std::vector<PrimaryFamily> families;
  // The levels of Haptic, then those of Rotation, then their combinations; with only_haptic those
  // of Rotation alone. All means of a group are computed from the same participants.
  std::vector<PrimaryMean> means;

  const PrimaryEffect* effect(const FactorSet& term) const;
  const PrimaryMean* mean(int haptic, int rotation) const;
};

PrimaryAnalysis analyse_repeated_measures(const TrialTable& table, Outcome outcome,
                                          std::optional<int> only_haptic = std::nullopt);

}  // namespace palpate
