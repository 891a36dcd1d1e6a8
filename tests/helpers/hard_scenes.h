#pragma once

// Random scenes in which a proxy easily leaks through a surface, and a device motion that provokes
// leaks.

#include <cstdint>
#include <vector>

#include "haptics/proxy/god_object.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

enum class HardKind : std::uint8_t {
  kWedge,             // closed, 0.5 to 179.9 degrees
  kNeedle,            // closed, 0.1 m long, at least a micrometre thick
  kSaddle,            // a vertex whose faces alternately rise and fall
  kSliver,            // closed, faces of aspect ratio 1e8
  kRepeated,          // closed, with duplicate faces and faces of almost no area or none
  kCoplanarOverlap,   // overlapping sheets in one plane
  kTJunction,         // a box whose faces share no vertices; some vertices are off by 1 um
  kGap,               // sheets with slits of 1 um
  kThinSheets,        // sheets 0.1 mm apart
  kSelfIntersection,  // intersecting closed bodies
  kSoup               // random triangles, some with common edges
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
  bool is_closed = false;  // a path that crosses any face enters or leaves a body
  std::vector<Vec3> aims;  // further targets besides vertices, edges and faces: slits
};

// Builds a scene of this kind in a random pose. One scene in three keeps its original pose, in
// which planes are exact.
HardScene hard_scene(HardKind kind, Random& random);

// A closed body of constant cross-section along x. profile_m: y and z of the convex profile,
// counter-clockwise. stations_m: the x of the cross-sections, ascending.
Soup extruded(const std::vector<Eigen::Vector2d>& profile_m, const std::vector<double>& stations_m);

// A box whose faces have separate vertices on the edges of the box. Some of these vertices are
// displaced by kGapWidth_m along one axis.
Soup ragged_box(const Vec3& half_extent_m, Random& random);

// The triangles that the engine uses: the faces that the surface kept, with the coordinates of its
// index. Solver frame, if the world's body has no transform.
std::vector<Corners> solver_triangles(const OwnedWorld& world);

// A device motion that slides, pokes at vertices and slits, jitters, stands still, turns back, and
// sometimes jumps across the whole scene. Solver frame.
class DeviceMotion {
 public:
  // The triangles must outlive the motion.
  DeviceMotion(const std::vector<Corners>& triangles, std::vector<Vec3> aims, const Vec3& start,
               Random& random);
  Vec3 next_goal(const ProxyState& state);

 private:
  enum class Habit : std::uint8_t { kWander, kSlide, kPoke, kThrough, kReturn, kAlongAxis, kCount };

  double step_m();
  Vec3 place_of_interest();
  Vec3 slide(const ProxyState& state);

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
