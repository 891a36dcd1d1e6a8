#pragma once

// The figures of a sweep.

#include <string>
#include <vector>

#include "engine/analysis/sweep_analysis.h"
#include "geometry/base/result.h"

namespace palpate {

// The flips along one parameter, in the order of SweepAnalysis::flips. The figure marks each with
// its place in this list, counted from 1.
std::vector<SweepFlip> flips_along(const SweepAnalysis& analysis, const SweepAxis& axis);

// One parameter alone: a panel for each measure of kSweepOutcomes, below each other, with the means
// of the six conditions at each level and their standard deviations over participants (sweep_mean),
// and a vertical line where a ranking of this measure flips: solid if the flip is clear, otherwise
// dashed, with its number in parentheses. A level at which trials are missing is shaded, and its
// tick states how many were done. An SVG document. Errors: those of gnuplot_svg().
Result<std::string> sweep_axis_svg(const SweepAnalysis& analysis, const SweepAxis& axis);

}  // namespace palpate
