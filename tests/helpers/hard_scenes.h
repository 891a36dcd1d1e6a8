#pragma once

// Random scenes that are hard to feel without falling through, and a device that tries to.

#include <cstdint>
#include <vector>

#include "haptics/proxy/god_object.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

enum class HardKind : std::uint8_t {
  kWedge,             // closed, of 0.5 to 179.9 degrees
  kNeedle,            // closed, 0.1 m long, down to a micrometre thick
  kSaddle,            // a vertex whose faces go up and down in turn
  kSliver,            // closed, faces of aspect 1e8
  kRepeated,          // closed, with duplicates, and faces of no area or next to none
  kCoplanarOverlap,   // sheets lying in each other
  kTJunction,         // a box whose faces do not share their vertices, +-1 um apart
  kGap,               // sheets with slits of 1 um
  kThinSheets,        // 0.1 mm apart
  kSelfIntersection,  // closed bodies through each other
  kSoup               // triangles anyhow, some with common edges
};
inline constexpr HardKind kAllHardKinds[] = {
    HardKind::kWedge,      HardKind::kNeedle,           HardKind::kSaddle,    HardKind::kSliver,
    HardKind::kRepeated,   HardKind::kCoplanarOverlap,  HardKind::kTJunction, HardKind::kGap,
    HardKind::kThinSheets, HardKind::kSelfIntersection, HardKind::kSoup};

const char* name_of(HardKind kind);

inline constexpr double kGapWidth_m = 1e-6;
inline constexpr double kSheetDistance_m = 1e-4;

struct HardScene {
  Soup soup;               // about 0.2 m in size
  bool is_closed = false;  // faces only at whose crossing one is inside another body
  std::vector<Vec3> aims;  // places worth aiming at besides vertices, edges and faces: slits
};

// In a random pose; one in three is left as built, where planes are exactly planes.
HardScene hard_scene(HardKind kind, Random& random);

// A body of constant cross-section along x, closed: the profile's y and z, counter-clockwise and
// convex, at each of the ascending stations x.
Soup extruded(const std::vector<Eigen::Vector2d>& profile_m, const std::vector<double>& stations_m);

// A box whose faces have vertices of their own on its edges, some kGapWidth_m off in one axis.
Soup ragged_box(const Vec3& half_extent_m, Random& random);

// What the engine touches: the faces the surface kept, with the coordinates its index has. Solver
// frame; right for a world whose body has no transform.
std::vector<Corners> solver_triangles(const OwnedWorld& world);

// A device that slides, pokes at vertices and slits, jitters, stands still, turns back, and
// sometimes jumps across everything. Solver frame.
class DeviceMotion {
 public:
  // The triangles outlive the motion.
  DeviceMotion(const std::vector<Corners>& triangles, std::vector<Vec3> aims, const Vec3& start,
               Random& random);
  Vec3 next_goal(const ProxyState& felt);

 private:
  enum class Habit : std::uint8_t { kWander, kSlide, kPoke, kThrough, kReturn, kAlongAxis, kCount };

  double step_m();
  Vec3 place_of_interest();
  Vec3 slide(const ProxyState& felt);

  const std::vector<Corners>* triangles_;
  std::vector<Vec3> aims_;
  Random* random_;
  Vec3 goal_;
  Vec3 earlier_goal_;
  Vec3 heading_;
  double pace_m_ = 0.0;
  Habit habit_ = Habit::kWander;
  std::uint64_t ticks_left_ = 0;
};

}  // namespace palpate::test
