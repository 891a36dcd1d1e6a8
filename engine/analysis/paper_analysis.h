#pragma once

// The analysis as the paper did it: fixed effects of Haptic, Rotation, Object and Trial with all
// their interactions, without participants in the model, so that all trials count as independent.

#include <string>
#include <vector>

#include "engine/analysis/comparisons.h"
#include "engine/analysis/factorial_model.h"
#include "engine/analysis/trial_table.h"
#include "engine/analysis/wilks.h"
#include "geometry/base/result.h"

namespace palpate {

// The three measures of the paper's MANOVA and ANOVAs.
inline constexpr std::array kPaperOutcomes = {Outcome::kTime, Outcome::kLosses,
                                              Outcome::kPenetration};

// Fisher's PLSD of the levels of a factor whose F is significant.
struct PlsdFamily {
  std::string factor;
  std::vector<std::string> levels;
  std::vector<LevelMean> means;  // of all trials at the level
  std::vector<PlsdPair> pairs;
};

struct PaperAnova {
  Outcome outcome;
  double mean_square_error = 0.0;
  std::vector<FixedEffectTest> effects;  // in the order of PaperAnalysis::terms
  std::vector<PlsdFamily> comparisons;
};

struct PaperAnalysis {
  int trials = 0;  // completed, with all three measures: the n of every F
  int error_df = 0;
  std::vector<FactorSet> terms;       // of ExperimentFactors
  std::vector<WilksTest> manova;      // in the order of terms
  std::vector<PaperAnova> anovas;     // in the order of kPaperOutcomes
  std::vector<std::string> left_out;  // factors that the model does not have, and why: sentences
};

// An error if a measure is missing, if the error matrix is singular, or if the trials do not
// determine the model.
Result<PaperAnalysis> analyse_as_paper(const TrialTable& table);

}  // namespace palpate
