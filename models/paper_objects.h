#pragma once

// The four contour-following objects for the evaluation of haptic scene alignment: star (O1),
// labyrinth (O2), inverted labyrinth (O3) and lock (O4).
//
// Source: Lecuyer et al., World Haptics 2005. The paper names the objects and shows pictures but
// gives no dimensions; the shapes here are Palpate's own. They keep the properties that determine
// the result of the experiment. For a hand that follows the contour at constant speed, the mean
// angle of the walls to any fixed line is 45 deg (the paper measured 49.4 deg). One turn takes 25
// to 30 s at 24 to 46 mm/s. A hand that overshoots a corner by 5 mm does not meet another wall.
//
// Frame: object, with x and y in the plane of the contour, z along the prism and the origin at the
// centre of the object. Not for the haptic thread. Thread-safe.

#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "models/primitives.h"

namespace palpate {

inline constexpr double kPaperObjectHeight_m = 0.04;  // along z, centred on z = 0

// Each contour is counter-clockwise and simple, and no wall is shorter than 25 mm. A turn starts on
// the first wall. This wall faces sideways, so that a device actuated along x can render its force.
Contour star_contour();                // 10 corners
Contour labyrinth_contour();           // 16 corners, all right-angled
Contour inverted_labyrinth_contour();  // 14 corners, all right-angled
Contour lock_contour();                // 16 corners

struct PaperObject {
  std::string name;  // "star", "labyrinth", "inverted_labyrinth", "lock"
  Contour contour_m;
};

// O1 to O4, in this order.
std::vector<PaperObject> paper_objects();

// The start and end of one counter-clockwise turn along the contour. Both are on its first wall at
// z = 0, the start 10 mm after the middle of the wall and the end 10 mm before it. Requires a first
// wall longer than 20 mm.
struct ContourRoute {
  Vec3 start_m;
  Vec3 end_m;
};
ContourRoute contour_route(const Contour& contour_m);

// The mean angle, in [0, pi/2], between the walls' normals and the x axis of the device, for the
// object rotated by orientation_rad about z. The mean is weighted by length, which is the time on
// each wall for a hand at constant speed. Requires a contour of nonzero length.
double mean_contact_angle_rad(const Contour& contour_m, double orientation_rad);

}  // namespace palpate
