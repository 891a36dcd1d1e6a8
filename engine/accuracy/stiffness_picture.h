#pragma once

// The chart of the stiffness as pictures.

#include <string>
#include <vector>

#include "engine/accuracy/report_section.h"
#include "engine/accuracy/stiffness_chart.h"

namespace palpate {

// An SVG document with a panel for each rate and a legend.
std::string stiffness_chart_svg(const StiffnessChart& chart);

// The same for the report, with what it says of the device.
ReportSection stiffness_chart_section(const StiffnessChart& chart);

}  // namespace palpate
