#pragma once

// The statistics of one kind of operator as HTML tables, beside the paper's numbers.

#include <string>

#include "engine/analysis/analysis.h"

namespace palpate {

// "Total time (s)"
std::string outcome_heading(Outcome outcome);

// "27.1 ± 0.5"; without the half width of the interval if it is NaN.
std::string mean_with_interval(double mean, double half_width, int decimals);

// Means and standard deviations of all trials at each level.
std::string trial_means_table(const OperatorAnalysis& analysis);

// Means of participants with their 95 % intervals.
std::string participant_means_table(const OperatorAnalysis& analysis);

// Wilks' lambda of every effect. Empty if the paper's analysis is not possible.
std::string manova_table(const OperatorAnalysis& analysis);

// Every F of an outcome, for all levels of Haptic: as the paper did it, and by repeated measures.
std::string effects_table(const OperatorAnalysis& analysis, const PrimaryAnalysis& primary);

// Every F of the contact angle of UaH.
std::string angle_effects_table(const PrimaryAnalysis& angle);

// Fisher's PLSD of an outcome. Empty if no factor has a significant F.
std::string plsd_table(const PaperAnova& anova);

// Paired t tests with Holm's adjustment.
std::string paired_table(const PrimaryAnalysis& primary);

// How the trials ended, for all conditions together and, if any trial is missing, by condition.
std::string missing_table(const OperatorAnalysis& analysis);

}  // namespace palpate
