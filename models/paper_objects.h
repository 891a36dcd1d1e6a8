#pragma once

// The four contour-following objects of the evaluation of haptic scene alignment: star (O1),
// labyrinth (O2), inverted labyrinth (O3) and lock (O4).
//
// Source: Lecuyer et al., World Haptics 2005, which names the objects and shows their kind but
// gives no dimensions; the shapes here are Palpate's own. What they keep of the experiment is what
// its result depends on: a hand that follows the contour at constant speed meets walls at a mean
// angle of 45 deg to any fixed line (the paper measured 49.4), one turn takes 25 to 30 s at 24 to
// 46 mm/s, and no corner is so tight that a hand that overshoots it by 5 mm meets another wall.
//
// Frame: object; x and y in the plane of the contour, z along the prism, origin at the centre of
// the object. Not for the haptic thread. Thread-safe.

#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "models/primitives.h"

namespace palpate {

inline constexpr double kPaperObjectHeight_m = 0.04;  // along z, centred on z = 0

// Each counter-clockwise, simple, with no wall shorter than 25 mm, and listed from the wall where a
// turn starts: that wall faces sideways, so that a device which pushes along x is felt there.
Contour star_contour();                // 10 corners
Contour labyrinth_contour();           // 16, all right-angled
Contour inverted_labyrinth_contour();  // 14, all right-angled
Contour lock_contour();                // 16

struct PaperObject {
  std::string name;  // "star", "labyrinth", "inverted_labyrinth", "lock"
  Contour contour_m;
};

// O1 to O4, in this order.
std::vector<PaperObject> paper_objects();

// Where one turn along the contour, counter-clockwise, begins and ends: on its first wall, 10 mm
// after and 10 mm before the middle, at z = 0. Requires a first wall longer than that.
struct ContourRoute {
  Vec3 start_m;
  Vec3 end_m;
};
ContourRoute contour_route(const Contour& contour_m);

// The angle in [0, pi/2] between the walls' normals and the x axis of the device, for the object
// turned by orientation_rad about z: the mean over the length of the contour, hence over the time a
// hand spends on each wall at constant speed. Requires a contour with length.
double mean_contact_angle_rad(const Contour& contour_m, double orientation_rad);

}  // namespace palpate
