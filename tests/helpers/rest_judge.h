#pragma once

// A judge of resting places that shares no code with the engine. It decides whether the proxy can
// get nearer to the goal from its present place.
//
// A free segment is a straight segment from the proxy. It crosses no triangle. Except for rounding,
// it never comes nearer to a triangle than one stand-off; if it starts nearer than that, it does
// not approach the triangle at its start. (A sphere's distance is that of its centre minus the
// radius.) If the proxy moves in a plane of motion, a free segment lies in this plane. The proxy is
// not at rest if a free segment leads nearer to the goal.
//
// The slope at the start decides whether a segment approaches a triangle. It does if this slope,
// continued to the point nearest to the goal, leads nearer by more than 4 ulps of the size. The
// directions that remain form a convex cone, since the distance to a triangle is convex. If even
// the unhindered steepest descent in that cone gains no more than the tolerance, this proves that
// no free segment leads nearer to the goal. Otherwise the judge searches for free segments. A
// segment that it reports satisfies the definition above. The judge checks this for each triangle:
// crossings exactly, distances in long double.
//
// The search tries the following directions, each as far as the distance to the goal decreases and
// up to the first obstacle:
// - straight to the goal;
// - the steepest descent in the cone, and again in the part of the cone that each obstacle leaves;
// - the tangent past the last of these obstacles;
// - the steepest descent along the plane of each triangle near the proxy, and along the planes that
//   pass the triangle's edges at the smallest allowed distance;
// - the line in which two of these planes meet;
// - the directions that pass a corner near the proxy at the smallest allowed distance: the one that
//   leads most directly to the goal, and those in each of these planes.
//
// If the distance of a triangle exceeds one stand-off by no more than rounding, it counts as one
// stand-off, in the proxy's favour.
//
// Under friction, a slide along the planes of one or two triangles is at most as long as the part
// of the lag along the slide that exceeds the limit of static friction. The straight segment to the
// goal is not limited.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "tests/helpers/exact_judge.h"

namespace palpate::test {

// A body in its pose. The judge's triangles are in the body frame.
struct JudgedBody {
  const ExactJudge* judge = nullptr;
  RigidTransform T_solver_body = {};
};

// A resting place of a proxy. Solver frame, metres.
struct Rest {
  Vec3 proxy;
  Vec3 goal;
  std::optional<Vec3> motion_plane_normal = {};
  double static_friction = 0.0;  // coefficient of all surfaces
};

// A free segment that leads nearer to the goal. Solver frame, metres.
struct Escape {
  Vec3 from;
  Vec3 to;
  double gain_m;     // decrease of the distance to the goal
  const char* kind;  // the direction that the search tried
};

struct Verdict {
  std::optional<Escape> escape;
  bool is_proven;  // the absence of an escape is proven, or an escape was found
};

// A text with all data to check the escape by hand; doubles in hexadecimal.
std::string to_text(const Escape& escape);
std::string hex(const Vec3& p);

class RestJudge {
 public:
  // size_m: the size of the scene. stand_off_m: the stand-off of the engine.
  RestJudge(double size_m, double radius_m, double stand_off_m);

  // Returns an escape that gains more than tolerance_m(), if the search finds one.
  std::optional<Escape> escape_from(std::span<const JudgedBody> bodies, const Rest& rest) const {
    return judged(bodies, rest).escape;
  }
  // escape_from() in a world of one body without a transform.
  std::optional<Escape> escape_from(const ExactJudge& judge, const Rest& rest) const;

  Verdict judged(std::span<const JudgedBody> bodies, const Rest& rest) const;

  // The least gain of a reported escape, in metres.
  double tolerance_m() const { return kGainPerSize * size_m_; }

  // 1e-9 of the size of the scene, or of the radius of the sphere if that is larger.
  static constexpr double kGainPerSize = 1e-9;

 private:
  double size_m_;
  double radius_m_;
  double stand_off_m_;
};

}  // namespace palpate::test
