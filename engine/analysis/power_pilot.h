#pragma once

// Variances of the model of power_run.h, from the trials of a pilot.

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "engine/analysis/power_run.h"
#include "engine/analysis/trial_table.h"
#include "geometry/base/result.h"

namespace palpate {

// The estimates from a pilot. With k conditions, n participants and m trials of each participant in
// each condition: e = MS_e, w = (MS_pc - MS_e) / m, u = (MS_p - MS_pc) / (k m).
//
// MS_p is the mean square between participants, MS_pc that of participants x conditions. MS_e is
// that of the trials within a participant and a condition, less what is common to all participants
// in a condition, an object and a block: the objects and blocks of an experiment are fixed, and
// cancel in its comparisons, as in the paper's own error.
//
// Missing trials: within a condition, the means of participants are adjusted for the objects and
// blocks that they lack (least squares), and m is the number of trials that would give the adjusted
// means their mean variance. With it the estimates are unbiased, if trials are missing at random.
// Without missing trials m is exactly their number, and all this is the usual analysis of variance.
//
// The model has no term for how a person differs in one object, in all conditions alike. Such
// scatter stays in MS_e and cancels in MS_pc, so that w is estimated too low, and often below 0
// (power_fit.h).
struct PilotEstimate {
  int participants = 0;               // who have all conditions
  std::vector<std::string> left_out;  // participants who lack a condition
  int trials = 0;                     // that count
  int missing = 0;                    // of these participants: timeouts, faults, absent
  double m = 0.0;                     // trials of a participant in a condition
  double ms_p = 0.0, ms_pc = 0.0, ms_e = 0.0;
  int df_p = 0, df_pc = 0, df_e = 0;
  PowerVariances raw;         // may be negative
  PowerVariances variances;   // negative estimates are 0
  std::vector<double> means;  // of the conditions, over participants
  Eigen::MatrixXd cells;      // adjusted means: one row per participant, one column per condition
};

// table: the trials of one following, or of people. Errors name the file `path`: fewer than two
// participants with all conditions, a condition that the table lacks, no trials from which e can be
// estimated, objects and blocks that no participants have in common, a value beyond
// kMostPowerValue, a measure that does not vary.
Result<PilotEstimate> estimate_pilot(const TrialTable& table, Outcome outcome,
                                     const PowerDesign& design, const std::string& path);

// The trials of one following in a file, beside practice and trials at other levels of Haptic than
// those of the design. following: as in the file, `people` for rows without a following, or empty
// if the file has one kind only. Errors: those of read_trials() and TrialTable::create(), trials
// with a strategy, several followings, a following that is not there, several variants
// (trial_variant.h).
Result<TrialTable> read_pilot(const std::string& path, const std::string& following,
                              const PowerDesign& design);

}  // namespace palpate
