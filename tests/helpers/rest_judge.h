#pragma once

// A judge of resting places that shares no code with the engine: is there a way on from here?
//
// A way is a straight segment from the proxy that crosses no triangle and that, for each triangle,
// never comes nearer to it than the smaller of its distance at the start and one stand-off, but for
// rounding. (A sphere's distance is that of its centre less the radius.) In a plane of motion, a
// way lies in that plane. A resting place is none if a way leads nearer to the goal.
//
// The distance to a triangle is a convex function, so a way may not begin with a fall of any
// distance that is a stand-off or less at its start: the directions that are left are a convex
// cone. If even the steepest descent in that cone, unhindered, gains no more than the tolerance,
// there is no way: that is a proof. Otherwise ways are looked for, and one that is reported is a
// way by the definition, judged segment by triangle: crossings exactly, distances in long double.
// What is looked for, each as far as the lag falls and the first obstacle allows:
// - straight to the goal;
// - the steepest descent in the cone, and again in what the obstacles met on the way leave of it;
// - past the last of these obstacles, as a tangent;
// - the steepest descent along the plane of each triangle near the proxy, and along the planes that
//   pass its edges as near as they may;
// - the line in which two of these planes meet.
//
// A triangle that is farther than one stand-off by no more than rounding counts as one stand-off
// away, in the proxy's favour.
//
// Under friction a slide along the planes of one or two triangles counts, and goes, as far as the
// part of the lag along it exceeds what static friction holds. The straight way always counts.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "tests/helpers/exact_judge.h"

namespace palpate::test {

// A body where it is. Triangles are in its frame.
struct JudgedBody {
  const ExactJudge* judge = nullptr;
  RigidTransform T_solver_body = {};
};

// Where a proxy rests. Solver frame, metres.
struct Rest {
  Vec3 proxy;
  Vec3 goal;
  std::optional<Vec3> motion_plane_normal = {};
  double static_friction = 0.0;  // of all surfaces
};

// A way on. Solver frame, metres.
struct Way {
  Vec3 from;
  Vec3 to;
  double gain_m;     // by how much it ends nearer to the goal
  const char* kind;  // how it was found
};

struct Verdict {
  std::optional<Way> way;
  bool is_proven;  // that there is none; or there is one
};

// What a person needs to check it, doubles in hexadecimal.
std::string to_text(const Way& way);
std::string hex(const Vec3& p);

class RestJudge {
 public:
  // size_m: of the scene. The stand-off is the engine's.
  RestJudge(double size_m, double radius_m, double stand_off_m);

  // A way that gains more than tolerance_m(), if one is found.
  std::optional<Way> way_on(std::span<const JudgedBody> bodies, const Rest& rest) const {
    return judged(bodies, rest).way;
  }
  // The same in a world of one body without a transform.
  std::optional<Way> way_on(const ExactJudge& judge, const Rest& rest) const;

  Verdict judged(std::span<const JudgedBody> bodies, const Rest& rest) const;

  // What a way gains at least.
  double tolerance_m() const { return kGainPerSize * size_m_; }

  // 1e-9 of the size of the scene, or of a sphere larger than it.
  static constexpr double kGainPerSize = 1e-9;

 private:
  double size_m_;
  double radius_m_;
  double stand_off_m_;
};

}  // namespace palpate::test
