#pragma once

// The figures of the canonical protocol: a measure over the angle of the wall.

#include <string>
#include <vector>

#include "engine/experiment/canonical_means.h"
#include "geometry/base/result.h"

namespace palpate {

// The participants' means of a measure for one motion, without and with rotation, over the angle,
// with 95 % intervals. kAlongOverInto has the curve tan a beside them. An SVG document.
//
// Errors: those of gnuplot_svg(), and if no row has a value.
Result<std::string> canonical_svg(const std::vector<CanonicalRow>& rows, CanonicalMeasure measure,
                                  CanonicalMotion motion);

}  // namespace palpate
