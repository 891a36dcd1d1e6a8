#pragma once

// Work-precision diagrams, drawn by gnuplot: the accuracy that a knob buys, and its time.

#include <string>

#include "engine/accuracy/measurement.h"
#include "geometry/base/result.h"

namespace palpate {

// Two SVG documents. Both have errors on the upright axis; if all errors are at the floor, the
// second has times instead.
//
// Axes are logarithmic; a grey band beside the axis holds errors, times and levels of 0. Points are
// medians, whiskers quartiles; open points are at the floor. A line is interrupted at a failed
// level, and the legend counts the failures.
struct WorkPrecisionPanels {
  // One curve for each method, the Pareto front, the presets and the level recommended.
  std::string error_against_time;
  // With the fitted order and the slope of the expected order.
  std::string error_against_level;
};

// An error if gnuplot is missing or fails.
Result<WorkPrecisionPanels> work_precision_panels(const KnobResult& result);

// Both side by side under the title of the knob, as one document.
Result<std::string> work_precision_svg(const KnobResult& result);

}  // namespace palpate
