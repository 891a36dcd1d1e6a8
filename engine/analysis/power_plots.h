#pragma once

// The figures of the report on power: power over the number of people.

#include <string>
#include <vector>

#include "engine/analysis/power_study.h"
#include "geometry/base/result.h"

namespace palpate {

// The assumptions that are drawn: all of one or two; otherwise those with the least, a middle and
// the most noise. One, if the noise of all is equal.
std::vector<std::size_t> drawn_assumptions(const PowerStudy& study);

// A panel: its title and its SVG document.
struct PowerPanel {
  std::string title;
  std::string svg;
};

// A panel for each effect, with a curve for each drawn assumption, corrected and uncorrected; then
// one for each family of several pairs, with the middle one of the drawn assumptions. A band is the
// 95 % interval. Errors: those of gnuplot_svg().
Result<std::vector<PowerPanel>> power_panels(const PowerStudy& study);

}  // namespace palpate
