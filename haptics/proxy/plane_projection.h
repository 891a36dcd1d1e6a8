#pragma once

// The god-object's subproblem: the point nearest to the goal that violates no contact plane.

#include <array>
#include <optional>
#include <span>

#include "geometry/base/types.h"

namespace palpate {

// Half-space normal . y >= offset_m of displacements y from the proxy.
struct ContactPlane {
  Vec3 normal;      // unit, towards the proxy's side
  double offset_m;  // minus the room the proxy still has towards the surface: <= 0 if feasible
};

// Whether y = 0 is known to satisfy every plane. Then no answer is farther from the target than it.
enum class Feasibility : std::uint8_t { kAtStart, kMustMove };

// Which planes hold the answer, and the answer.
struct PlaneProjection {
  Vec3 displacement_m = Vec3::Zero();
  std::array<int, 3> active{};  // indices of the planes that push, first active_count valid
  int active_count = 0;
  bool solved = false;  // false: rounding hid the solution, displacement 0 is what remains
};

// Minimises |y - target|^2 subject to every plane (at most kMaxContactPlanes). The minimiser is
// held by up to three planes, its basis (Zilles & Salisbury 1995, section 4, solve a 6 x 6 system
// for it). The basis is found by exchanges: while a plane is violated, the most violated one comes
// in, and the best basis of these four at most replaces the last one. Each is farther from the
// target than the one before, so the search ends (M. Sharir and E. Welzl, "A Combinatorial Bound
// for Linear Programming and Related Problems", 1992). Planes whose normals lie in one plane (a
// device with two sensors) never form a triple.
PlaneProjection project_onto_planes(std::span<const ContactPlane> planes, const Vec3& target,
                                    Feasibility start = Feasibility::kAtStart) noexcept;

// Faces that touch a proxy at one place, and those met on the way in one tick.
inline constexpr int kMaxContactPlanes = 24;

// How much of a lag (proxy minus goal) each of up to three unit normals bears: its part along them,
// none below zero. Normals that lie in a line or plane bear equal parts of its length. m.
std::array<double, 3> bearing_parts(const Vec3& lag_m, std::span<const Vec3> normals) noexcept;
// The same in shares of the sum.
std::array<double, 3> bearing_shares(const Vec3& lag_m, std::span<const Vec3> normals) noexcept;

// The direction, unit, of the line in which planes with these unit normals cross; zero if they are
// parallel. Of nearly parallel normals the product is rounded in any direction: what leads out of
// the first plane is taken away, so that out of the other no more than rounding leads, either.
inline Vec3 crossing_line(const Vec3& normal, const Vec3& other) noexcept {
  const Vec3 line = normal.cross(other);
  return (line - line.dot(normal) * normal).normalized();
}

// What a contact plane is for a proxy that keeps to a plane of motion with this unit normal.
// Nothing if the two are parallel to within half the digits of double: it cannot push the proxy
// there.
std::optional<ContactPlane> within_plane(const ContactPlane& plane,
                                         const Vec3& motion_plane_normal) noexcept;

}  // namespace palpate
