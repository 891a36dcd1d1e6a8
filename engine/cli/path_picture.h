#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "engine/simulation/exploration.h"
#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"

namespace palpate {

// Largest size of a picture, bytes.
inline constexpr std::size_t kLargestPicture = 300'000;

// Draws the device paths of one or two runs, the contour or path that the hand followed, and the
// contact angle over time, as an SVG file, by gnuplot. Device frame, seen against A3: A1 upwards,
// A2 to the left, both runs at one scale. The title is the scene's name; the legend names the
// actuated axis or plane.
//
// Curves are simplified: a drawn line deviates by 0.4 px at most from the recorded one, and the
// angle by another 0.5 px along the time axis. The bound doubles until the picture has no more
// bytes than kLargestPicture.
//
// Returns the file written. kFileUnwritable if there is no space for the file; another error if
// gnuplot is missing or fails.
Result<std::string> write_path_picture(const std::vector<ExplorationRun>& runs,
                                       const ActuationModel& actuation,
                                       const std::string& scene_name, const std::string& svg_path);

}  // namespace palpate
