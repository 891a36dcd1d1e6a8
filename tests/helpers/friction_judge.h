#pragma once

// A judge of contacts under friction that shares no code with the engine: it decides from the
// triangles alone whether the force of a tick is within the friction cone of the faces that the
// proxy touches at the end of the tick.
//
// The faces that the proxy touches press on it along their contact normals: for a point, the normal
// of the face on the proxy's side; for a sphere, the direction from the nearest point of the face
// to the centre. Up to three of these faces bear the lag (proxy minus goal): the lag is a
// combination of their normals with positive coefficients f_i, plus a tangential part t, which is
// perpendicular to all of them. The static cone is |t| <= sum(mu_s_i f_i), the dynamic one |t| =
// sum(mu_k_i f_i). A touched face bears nothing if the slide -t does not approach it, or if it
// lies behind the plane of a face that bears (the other side of a convex edge, or a face in the
// same plane).

#include <optional>
#include <span>
#include <vector>

#include "haptics/proxy/friction_cone.h"
#include "tests/helpers/exact_judge.h"

namespace palpate::test {

// A face in the scene frame, with the coefficients at the place of the proxy.
struct FrictionFace {
  Corners corners;
  FrictionCone cone;
};

// A force relative to the faces that bear it.
struct BorneForce {
  double normal_N = 0.0;      // length of the part along the normals
  double tangential_N = 0.0;  // length of the part along the surface
  double mu_s = 0.0;          // static and dynamic coefficient of the faces together
  double mu_k = 0.0;
  // Whether the touched faces that do not bear bear nothing without friction either: the slide does
  // not approach them, or they lie behind a face that bears. Only then does the dynamic cone apply.
  bool slides_freely = true;
  std::vector<Vec3> normals;

  double ratio() const { return tangential_N / normal_N; }
  // The ratio minus that of the static cone, and the distance of the ratio from the dynamic cone.
  double above_static() const { return ratio() - mu_s; }
  double off_dynamic() const { return ratio() - mu_k; }
};

class FrictionJudge {
 public:
  // touch_m: largest distance at which a face is touched. motion_plane_normal: as for
  // GodObject::move_to(); contact normals then lie in that plane.
  FrictionJudge(double radius_m, double touch_m) : radius_m_(radius_m), touch_m_(touch_m) {}

  // All ways in which touched faces can bear the force. More than one is possible only within
  // touch_m of an edge.
  std::vector<BorneForce> borne(std::span<const FrictionFace> faces, const Vec3& proxy,
                                const Vec3& force_N,
                                const std::optional<Vec3>& motion_plane_normal) const;

  // The faces that a proxy touches, as indices.
  std::vector<std::size_t> touched(std::span<const FrictionFace> faces, const Vec3& proxy) const;

 private:
  double radius_m_;
  double touch_m_;
};

// The point of a triangle that is nearest to p.
Vec3 nearest_point(const Corners& t, const Vec3& p);

}  // namespace palpate::test
