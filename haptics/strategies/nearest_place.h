#pragma once

// The place of a world's surfaces that is nearest to a moving point.

#include <optional>

#include "haptics/proxy/contact.h"
#include "haptics/proxy/live_world.h"
#include "haptics/proxy/work.h"

namespace palpate {

// A point of a surface, seen from a point p. Solver frame, metres.
struct SurfacePlace {
  FaceRef face;
  Vec3 point_m;
  Vec3 direction;  // unit, from point_m to p
  double distance_m = 0.0;
};

// Follows the surface point q nearest to a point p from tick to tick. As p moves, q slides along
// the surface. q changes to another place of the surfaces only if that place is nearer by more than
// kNearer_m: a point between two walls would otherwise alternate between them.
//
// q slides by at most kSlide times the motion of p relative to the body of q, plus rounding. A
// place farther from the last q is another place. Over a plane or round an edge, q moves no farther
// than p; in a cavity of radius R at height h, it moves R/(R - h) times as far.
//
// Safe on the haptic thread: no allocation, lock or exception. One thread owns an object.
class NearestPlace {
 public:
  static constexpr double kNearer_m = 0.5e-3;
  static constexpr double kSlide = 2.0;

  // q for p (solver frame, m), or no value if no surface is within reach_m of p, or if the search
  // has spent the budget of the meter, to which it adds its work. A search that has spent the
  // budget keeps the last q for the next update; one that finds no surface forgets it. The result
  // depends neither on the instruction set nor on the order of Embree's tree.
  std::optional<SurfacePlace> update(const LiveWorld& world, const Vec3& p, double reach_m,
                                     WorkMeter& work) noexcept;
  // Whether the last update has spent the budget.
  bool is_cut_short() const { return is_cut_short_; }
  void forget() noexcept { held_.reset(); }

 private:
  // The last q and the last p, in the frame of the body of q.
  struct Held {
    FaceRef face;
    Vec3 q_body;
    Vec3 p_body;
  };

  std::optional<Held> held_;
  bool is_cut_short_ = false;
};

}  // namespace palpate
