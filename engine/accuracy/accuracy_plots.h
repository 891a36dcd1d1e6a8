#pragma once

// Work-precision diagrams, drawn by gnuplot. They show the error at each level of a knob (knob.h)
// and the time that the level takes.

#include <string>

#include "engine/accuracy/measurement.h"
#include "geometry/base/result.h"

namespace palpate {

// Two SVG documents. Both have the errors on the vertical axis; if all errors are at the floor, the
// second document has the times there instead.
//
// The axes are logarithmic. A grey band beside an axis contains the points whose error, time or
// level is 0. Points are medians, and whiskers extend from the first to the third quartile; open
// points are at the floor. A line is interrupted at a failed level, and the legend counts the
// failures.
struct WorkPrecisionPanels {
  // Errors against times: one curve for each method, the Pareto front, the presets and the
  // recommended level.
  std::string error_against_time;
  // Errors against levels, with the fitted order and the slope of the expected order.
  std::string error_against_level;
};

// Returns an error if gnuplot is missing or fails.
Result<WorkPrecisionPanels> work_precision_panels(const KnobResult& result);

// Both panels side by side under the title of the knob, as one SVG document.
Result<std::string> work_precision_svg(const KnobResult& result);

}  // namespace palpate
