#pragma once

// The figures of the report, after Figures 6 and 7 of the paper.

#include <string>

#include "engine/analysis/analysis.h"
#include "geometry/base/result.h"

namespace palpate {

// Names the people or operators who did the trials, for titles: "simulated operators, delayed";
// "people".
std::string whose_trials(const OperatorAnalysis& analysis);

// A panel of Figure 6: the participants' means of an outcome at each level of Haptic, one curve for
// each level of Rotation, with 95 % intervals; beside them the paper's means over both rotations,
// if the paper has them. An SVG document.
//
// Errors: those of gnuplot_svg(), and if no participant has completed trials in all conditions.
Result<std::string> rotation_haptic_svg(const OperatorAnalysis& analysis, Outcome outcome);

// Figure 7: the mean contact angle of UaH without and with rotation, beside the paper's. The trials
// must have the angle. Errors as above.
Result<std::string> angle_svg(const OperatorAnalysis& analysis);

}  // namespace palpate
