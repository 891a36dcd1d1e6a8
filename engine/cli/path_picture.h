#pragma once

#include <string>
#include <vector>

#include "engine/simulation/exploration.h"
#include "geometry/base/result.h"

namespace palpate {

// Draws the paths of the device of one or two runs, and the contact angle over time, as an SVG file
// by gnuplot. Device frame, seen against A3: A1 upwards, A2 to the left. Returns the file written.
// kFileUnwritable if there is no room for it; another error if gnuplot is missing or fails.
Result<std::string> write_path_picture(const std::vector<ExplorationRun>& runs,
                                       const std::string& scene_name, const std::string& svg_path);

}  // namespace palpate
