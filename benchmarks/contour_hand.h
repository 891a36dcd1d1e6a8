#pragma once

// A hand without delay that follows a contour once, and the mean contact angle that it reaches.

#include <cstdint>
#include <vector>

#include "engine/scene/scene.h"
#include "geometry/base/result.h"
#include "haptics/a4/theoretical_rotation.h"
#include "models/primitives.h"

namespace palpate::bench {

// The goals of the hand, in the plane and the frame of the contour. The hand goes counter-clockwise
// at constant speed, once round from the middle of the first wall. Its goal is kDepth_m below the
// contour's point, that is, on the inner side of the wall on which this point lies.
//
// Corners take no time. At a concave corner the goal jumps from one wall to the next; the contact
// goes on. A point proxy cannot go round a convex corner of at most 90 deg while its goal is inside
// the object: the old wall holds it. The hand therefore lets go at each convex corner. Until it is
// kReleased_m beyond the corner, its goal is kDepth_m above the next wall, so that contact is lost
// for a few ticks. Beyond kReleased_m, a point at kDepth_m below the wall is inside the object if
// the angle between the walls is at least atan(1/2) = 26.6 deg.
//
// Requires a simple contour whose walls are longer than 2 kReleased_m. Thread-safe.
class ContourHand {
 public:
  static constexpr double kDepth_m = 1e-4;
  static constexpr double kReleased_m = 2.0 * kDepth_m;

  explicit ContourHand(const Contour& contour_m);

  // The goal before the first tick: kDepth_m above the middle of the first wall.
  Point2 start_m() const;
  // The goal after this share of the way, [0, 1).
  Point2 goal_m(double share) const;

 private:
  struct Leg {  // one wall; the first and the last leg are the halves of the first wall
    Point2 from_m;
    Point2 along;    // unit
    Point2 outward;  // unit
    double begin_m;  // on the way
    bool is_after_convex_corner;
  };
  std::vector<Leg> legs_;
  double length_m_ = 0.0;
};

// One way of this hand round a contour.
struct ContourRound {
  double duration_s = 27.0;
  double start_orientation_deg = 0.0;  // of the scene about A3, before the first tick
  Alignment align = Alignment::kNearest;
};

struct ContourAngle {
  double mean_deg = 0.0;       // the contact angle, mean over the ticks in contact
  double contact_share = 0.0;  // of the ticks
  std::uint32_t faults = 0;    // fault bits of all ticks
};

// Lets the hand go round in ticks of 1 ms, on a device with two sensors and a motor along A1, while
// A4 turns the scene. In each tick, the device point is the goal, placed in the device frame by the
// scene's pose after the tick before. The goal is that of the middle of the tick; otherwise some
// corners would lie at the place of a tick, and rounding would decide on which wall the tick is. No
// force displaces this hand.
// contour_m: the scene's contour in the plane of the device, scene frame. Returns the errors of
// make_setup() and check_setup(). Deterministic; thread-safe.
Result<ContourAngle> angle_round(const Scene& scene, const Contour& contour_m,
                                 const ContourRound& round);

}  // namespace palpate::bench
