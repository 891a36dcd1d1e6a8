#pragma once

// The subproblem of a god-object step: the point nearest to the goal that violates no contact
// plane. All functions are safe on the haptic thread (no allocation, lock or exception) and
// thread-safe.

#include <array>
#include <optional>
#include <span>

#include "geometry/base/types.h"

namespace palpate {

// The half-space normal . y >= offset_m of displacements y from the proxy. Solver frame, metres.
struct ContactPlane {
  Vec3 normal;      // unit, towards the proxy's side
  double offset_m;  // minus the distance by which the proxy may approach; <= 0 if y = 0 is feasible
};

// kAtStart: y = 0 satisfies every plane. The solution is then never farther from the target than
// y = 0. kMustMove: y = 0 may violate planes.
enum class Feasibility : std::uint8_t { kAtStart, kMustMove };

// The solution of project_onto_planes() and its active planes.
struct PlaneProjection {
  Vec3 displacement_m = Vec3::Zero();
  std::array<int, 3> active{};  // indices of the active planes; the first active_count are valid
  int active_count = 0;
  bool solved = false;  // false: rounding hid the solution; displacement_m is 0
};

// Minimises |y - target|^2 over all displacements y that satisfy every plane (at most
// kMaxContactPlanes). Up to three planes hold the minimiser; they are its basis. (Zilles and
// Salisbury 1995, section 4, solve a 6 x 6 system for the minimiser.) The basis is found by
// exchanges. While a plane is violated, the most violated plane is added to the planes of the
// basis. The best basis of these planes, of which there are at most four, replaces the old basis.
// The minimiser of each basis is farther from the target than that of the basis before it, so the
// search ends (M. Sharir and E. Welzl, "A Combinatorial Bound for Linear Programming and Related
// Problems", 1992). Planes whose normals lie in one plane (a device with two sensors) never form a
// basis of three.
PlaneProjection project_onto_planes(std::span<const ContactPlane> planes, const Vec3& target,
                                    Feasibility start = Feasibility::kAtStart) noexcept;

// Capacity for the planes of the faces that touch the proxy at one place and of the faces that the
// proxy meets in one tick.
inline constexpr int kMaxContactPlanes = 24;

// The parts of a lag (here: proxy minus goal), m, that up to three unit normals bear. They are the
// coefficients of the lag as a combination of the normals; negative coefficients are set to zero.
// If the normals are linearly dependent, each bears an equal part of the lag's length.
std::array<double, 3> bearing_parts(const Vec3& lag_m, std::span<const Vec3> normals) noexcept;
// The parts of bearing_parts() divided by their sum.
std::array<double, 3> bearing_shares(const Vec3& lag_m, std::span<const Vec3> normals) noexcept;

// The unit direction of the line in which planes with these unit normals intersect; zero if the
// planes are parallel. If they are nearly parallel, rounding may turn the cross product in any
// direction. The component of the product along `normal` is removed, so that the line deviates from
// either plane by no more than rounding.
inline Vec3 crossing_line(const Vec3& normal, const Vec3& other) noexcept {
  const Vec3 line = normal.cross(other);
  return (line - line.dot(normal) * normal).normalized();
}

// The constraint that a contact plane imposes on a proxy that keeps to a plane of motion with this
// unit normal. The normal of the constraint lies in the plane of motion. Returns nullopt if the two
// planes are parallel to within half the digits of double, because such a contact plane cannot push
// the proxy within the plane of motion.
std::optional<ContactPlane> within_plane(const ContactPlane& plane,
                                         const Vec3& motion_plane_normal) noexcept;

}  // namespace palpate
