#pragma once

// Work-precision diagrams, drawn by gnuplot: what accuracy a knob buys, and for how much time.

#include <string>

#include "engine/accuracy/measurement.h"
#include "geometry/base/result.h"

namespace palpate {

// Each an SVG document. Errors are on the same axis in both; where all of them are at the floor,
// the second has times instead.
//
// Axes are logarithmic; an error, a time or a level of 0 is in a grey band of its own beside the
// axis. Points are medians, whiskers quartiles; open points are at the floor. A line is interrupted
// where a level failed: that is counted in the legend.
struct WorkPrecisionPanels {
  // One curve for each method, the Pareto front, the presets and the level recommended.
  std::string error_against_time;
  // With the order fitted and the slope of the one expected.
  std::string error_against_level;
};

// An error if gnuplot is missing or fails.
Result<WorkPrecisionPanels> work_precision_panels(const KnobResult& result);

// Both side by side under the title of the knob, as one document.
Result<std::string> work_precision_svg(const KnobResult& result);

}  // namespace palpate
