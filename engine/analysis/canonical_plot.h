#pragma once

// The figures of the canonical protocol: a measure over the angle of the wall.

#include <string>
#include <vector>

#include "engine/analysis/canonical_means.h"
#include "geometry/base/result.h"

namespace palpate {

// tan a is 4 at 76 deg, so that all angles of the plan that ships are below the end of the axis.
inline constexpr double kRatioShown = 4.0;

// The participants' means of a measure for one motion, without and with rotation, over the angle,
// with 95 % intervals. kAlongOverInto has the curve tan a beside them; its axis ends above R and
// above kRatioShown, and NoR and tan a are cut there. An SVG document.
//
// Errors: those of gnuplot_svg(), and if no row has a value.
Result<std::string> canonical_svg(const std::vector<CanonicalRow>& rows, CanonicalMeasure measure,
                                  CanonicalMotion motion);

// Whether a mean of NoR is above the end of the axis of the figure of kAlongOverInto.
bool is_canonical_ratio_cut(const std::vector<CanonicalRow>& rows, CanonicalMotion motion);

}  // namespace palpate
