#pragma once

// The chart of the stiffness as a picture.

#include <string>

#include "engine/accuracy/stiffness_chart.h"

namespace palpate {

// An SVG document with a panel for each rate and a legend.
std::string stiffness_chart_svg(const StiffnessChart& chart);

}  // namespace palpate
