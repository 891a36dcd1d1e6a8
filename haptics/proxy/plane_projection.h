#pragma once

// The subproblem of a god-object step: the point nearest to the goal that violates no contact
// plane. All functions are safe on the haptic thread (no allocation, lock or exception) and
// thread-safe.

#include <array>
#include <optional>
#include <span>

#include "geometry/base/types.h"
#include "haptics/proxy/motion_plane.h"

namespace palpate {

// The half-space normal . y >= offset_m of displacements y from the proxy, in metres. Vec is Vec3
// in the solver frame, and Vec2 in the coordinates of a plane of motion, where it is a half-plane.
template <typename Vec>
struct HalfSpace {
  Vec normal;       // unit, towards the proxy's side
  double offset_m;  // minus the distance by which the proxy may approach; <= 0 if y = 0 is feasible
};
using ContactPlane = HalfSpace<Vec3>;

// kAtStart: y = 0 satisfies every plane. The solution is then never farther from the target than
// y = 0; a solution whose gain is lost in the rounding of squared distances, because it is shorter
// than about 1e-8 of the target, may be replaced by y = 0. kAtStartPrecise: the same, but only a
// solution shorter than about 1e-15 of the target may be. kMustMove: y = 0 may violate planes.
enum class Feasibility : std::uint8_t { kAtStart, kAtStartPrecise, kMustMove };

// The solution of project_onto_planes() and its active planes.
template <typename Vec>
struct Projection {
  Vec displacement_m = Vec::Zero();
  std::array<int, 3> active{};  // indices of the active planes; the first active_count are valid
  int active_count = 0;
  bool solved = false;  // false: there is no solution, or rounding hid it; displacement_m is 0
};
using PlaneProjection = Projection<Vec3>;

// Minimises |y - target|^2 over all displacements y that satisfy every plane (at most
// kMaxContactPlanes). Up to three planes hold the minimiser; they are its basis. (Zilles and
// Salisbury 1995, section 4, solve a 6 x 6 system for the minimiser.) The basis is found by
// exchanges. While a plane is violated, the most violated plane is added to the planes of the
// basis. The best basis of these planes, of which there are at most four, replaces the old basis.
// The minimiser of each basis is farther from the target than that of the basis before it, so the
// search ends (M. Sharir and E. Welzl, "A Combinatorial Bound for Linear Programming and Related
// Problems", 1992).
//
// Solved: the displacement violates no plane by more than the rounding of |displacement_m|, of the
// plane's offset and of |target|. No other solution of the search counts.
PlaneProjection project_onto_planes(std::span<const ContactPlane> planes, const Vec3& target,
                                    Feasibility start = Feasibility::kAtStart) noexcept;

// The same in two coordinates, where up to two planes (here: lines) hold the minimiser.
Projection<Vec2> project_onto_planes(std::span<const HalfSpace<Vec2>> planes, const Vec2& target,
                                     Feasibility start = Feasibility::kAtStart) noexcept;

// The same for displacements within a plane of motion. The normals must lie in that plane
// (within_plane), and any part of the target across it is ignored; but if no plane is active, the
// displacement is the target. The problem is solved in the two coordinates of the plane. Three
// normals that rounding has turned out of the plane can therefore not form a basis, and the
// displacement needs no correction.
PlaneProjection project_within(const MotionPlane& motion_plane,
                               std::span<const ContactPlane> planes, const Vec3& target,
                               Feasibility start = Feasibility::kAtStart) noexcept;

// The least displacement that satisfies every plane although y = 0 may not, within a plane of
// motion if there is one.
inline PlaneProjection least_displacement(std::span<const ContactPlane> planes,
                                          const std::optional<MotionPlane>& motion_plane) noexcept {
  const Vec3 none = Vec3::Zero();
  return motion_plane ? project_within(*motion_plane, planes, none, Feasibility::kMustMove)
                      : project_onto_planes(planes, none, Feasibility::kMustMove);
}

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

// The constraint that a contact plane imposes on a proxy that keeps to a plane of motion. The
// normal of the constraint lies in the plane of motion. Returns nullopt if the two planes are
// parallel to within half the digits of double, because such a contact plane cannot push the proxy
// within the plane of motion.
std::optional<ContactPlane> within_plane(const ContactPlane& plane,
                                         const MotionPlane& motion_plane) noexcept;
// The same, or the contact plane itself if there is no plane of motion.
inline std::optional<ContactPlane> within_plane(
    const ContactPlane& plane, const std::optional<MotionPlane>& motion_plane) noexcept {
  return motion_plane ? within_plane(plane, *motion_plane) : std::optional<ContactPlane>(plane);
}

}  // namespace palpate
