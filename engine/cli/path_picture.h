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

// Draws an SVG file. It shows the device paths of one or two runs, the contour or path
// that the hand followed, and the contact angle over time. The paths are in the device frame,
// viewed in the direction of -A3, with A1 upwards and A2 to the left; both runs have the same
// scale. The title is the scene's name; the legend names the actuated axis or plane.
//
// Curves are simplified. A drawn line deviates by at most 0.4 px from the recorded one. The curve
// of the angle deviates by at most another 0.5 px along the time axis. The bound of 0.4 px is
// doubled until the picture has at most kLargestPicture bytes.
//
// Returns the path of the file, or kFileUnwritable if there is no space for the file.
Result<std::string> write_path_picture(const std::vector<ExplorationRun>& runs,
                                       const ActuationModel& actuation,
                                       const std::string& scene_name, const std::string& svg_path);

}  // namespace palpate
