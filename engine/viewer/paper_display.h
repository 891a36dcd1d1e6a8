#pragma once

// The display of the paper, which a page shows in place of forces, axes and charts.

#include <optional>

#include "geometry/base/types.h"

namespace palpate {

// The spheres where a trial starts and ends, scene frame.
struct DisplayedSpheres {
  Vec3 green_m = Vec3::Zero();  // centre of the start
  Vec3 red_m = Vec3::Zero();    // centre of the end
  double radius_m = 0.0;
};

struct PaperDisplay {
  double rate_Hz = 40.0;  // mean rate of the pictures
  double scale = 1.0;     // length on the screen / length in the device frame
  std::optional<DisplayedSpheres> spheres = {};  // no value: none are shown
};

}  // namespace palpate
