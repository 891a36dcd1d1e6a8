#pragma once

// What the paper (Lecuyer et al., 2005) states about the scatter and the effects of a measure.

#include <string>
#include <string_view>
#include <vector>

#include "engine/analysis/power_design.h"
#include "engine/analysis/trial_table.h"

namespace palpate {

inline constexpr int kPaperParticipants = 10;
inline constexpr int kPaperTrialsOfCondition = 12;  // 4 objects in 3 blocks

// A standard deviation that follows from the paper's means and one of its F.
struct PaperScatter {
  std::string_view from;  // the effect whose F it is: "Haptic"
  double sd = 0.0;
  // The least and the largest standard deviation that the printed means allow: each of them may be
  // off by half of its last printed digit. The rounding of F is not in it: it is at most 0.1 %.
  double low = 0.0, high = 0.0;

  bool allows(double other) const { return low <= other && other <= high; }
};

// Half of the last digit with which the paper prints a mean: 0.5 for 29, 0.05 for 27.5.
double paper_rounding(double mean);

// The standard deviation of one trial in the paper's own model, which treats all trials as
// independent: the square root of its mean square of the error. It holds u, w and e (power_run.h).
// It follows from the F of Haptic and from that of Rotation; the paper's means are rounded, so that
// the two differ. Of the time, the losses and the penetration; ascending.
std::vector<PaperScatter> paper_trial_scatter(Outcome outcome);

// The standard deviation over participants of their difference R - NoR in the contact angle of UaH:
// each value is the mean of kPaperTrialsOfCondition trials.
PaperScatter paper_angle_scatter();

// The means of the conditions of power_design_of(outcome). For the time, the losses and the
// penetration, the paper states the means at the levels of Haptic and of Rotation only; this sum of
// both, less their mean, assumes that there is no interaction.
std::vector<double> paper_condition_means(Outcome outcome);

}  // namespace palpate
