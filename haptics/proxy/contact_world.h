#pragma once

// What the proxy can touch: rigid bodies, each with the index of its surface.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/index/box_tree.h"
#include "geometry/index/stretch.h"
#include "geometry/index/surface_index.h"
#include "haptics/proxy/solver_corners.h"

namespace palpate {

struct EffectProgram;

// A rigid surface placed in the solver frame.
//
// Its index is in a frame and a unit of its own, so that bodies share one whatever their scale. The
// body frame is the one in which triangles are decided on:
//
//     p_body = units_per_metre R^-1 (p_solver - t),   R and t of T_solver_body
//
// Of most bodies it is that of the index, and its unit is that of the index. All that decides there
// is as good as in metres: bounds on rounding are relative to the lengths that they are about, and
// a point takes one rounding more on its way, none where units are powers of two. A mirrored body
// has negative units: a mirror is minus a rotation, and minus one takes a direction to its
// opposite, so that a front stays a front.
//
// A stretched body is decided on in metres, and its index sorts out (Stretch).
struct ContactBody {
  const SurfaceIndex* index;     // outlives the world
  RigidTransform T_solver_body;  // but for the unit
  bool is_identity;              // the transform changes nothing, not even a bit
  // Of a body that meets others along seams, as long as it is where it was at first: what decides
  // there whether a point passes. Null for all others. Outlives the world, as the index.
  const SolverCorners* corners = nullptr;
  double units_per_metre = 1.0;
  double metres_per_unit = 1.0;
  // Null where the body frame is that of the index. Outlives the world.
  const Stretch* stretch = nullptr;

  void place(const RigidTransform& T) {
    T_solver_body = T;
    is_identity = T.rotation.coeffs() == Quat::Identity().coeffs() && T.translation_m.isZero(0.0);
  }

  // Around the surface, where the body is: what its own box needs when it is turned. Solver frame.
  Box box_solver() const {
    const Box box = box_body();
    const Vec3 centre = to_solver(0.5 * (box.low + box.high));
    const Vec3 half_m = length_to_solver(1.0) * (0.5 * (box.high - box.low));
    const Vec3 reach_m = T_solver_body.rotation.toRotationMatrix().cwiseAbs() * half_m;
    return {centre - reach_m, centre + reach_m};
  }
  Box box_body() const { return stretch ? stretch->box_body(index->box()) : index->box(); }

  Vec3 to_body(const Vec3& p_solver) const {
    return units_per_metre * (is_identity ? p_solver : T_solver_body.inverse_point(p_solver));
  }
  Vec3 to_solver(const Vec3& p_body) const {
    const Vec3 p_m = metres_per_unit * p_body;
    return is_identity ? p_m : T_solver_body.point(p_m);
  }
  // Unit vectors, and what keeps its length.
  Vec3 direction_to_body(const Vec3& d_solver) const {
    return front() * (is_identity ? d_solver : T_solver_body.inverse_direction(d_solver));
  }
  Vec3 direction_to_solver(const Vec3& d_body) const {
    const Vec3 d = front() * d_body;
    return is_identity ? d : T_solver_body.direction(d);
  }
  // The way between two points.
  Vec3 way_to_body(const Vec3& d_solver) const {
    return length_to_body(1.0) * direction_to_body(d_solver);
  }
  // What a quantity of the body frame gains in a unit of length there is, solver frame, a metre.
  Vec3 gradient_to_solver(const Vec3& g_body) const {
    return length_to_body(1.0) * direction_to_solver(g_body);
  }
  double length_to_body(double length_m) const { return std::abs(units_per_metre) * length_m; }
  double length_to_solver(double length_body) const {
    return std::abs(metres_per_unit) * length_body;
  }

  // Where what sorts out looks for a point of the body frame, and how far around it.
  Vec3 to_index(const Vec3& v_body) const { return stretch ? stretch->to_index(v_body) : v_body; }
  double reach_index(double reach_m, const Vec3& p_body) const {
    return stretch ? stretch->reach_index(reach_m, p_body) : length_to_body(reach_m);
  }

  // A triangle of the index, body frame: where it is, or made in `room`.
  const TriangleGeometry& triangle(std::uint32_t slot, TriangleGeometry& room) const {
    if (!stretch) [[likely]]
      return index->triangle(slot);
    room = stretch->triangle(index->triangle(slot));
    return room;
  }

 private:
  double front() const { return std::copysign(1.0, units_per_metre); }
};

// Immutable while a haptic loop uses it.
//
// The solver frame has the axes of the scene frame and its origin at anchor_scene_m, the middle of
// the scene: a scene 1 km from the origin loses no digits in the solver.
struct ContactWorld {
  std::vector<ContactBody> bodies;
  Box bounds_solver;  // around all surfaces
  Vec3 anchor_scene_m = Vec3::Zero();
  double size_m = 0.0;  // largest extent of the scene
  // Over the boxes of the bodies, in their order, solver frame, for sweeps of the largest proxy.
  // Null in small worlds: all bodies are asked.
  std::shared_ptr<const BoxTree> tree;
  // What the bodies' stretches point to. Null in a world without stretched bodies.
  std::shared_ptr<const std::vector<Stretch>> stretches;
  // What the bodies' corners point to. Null in a world without seams.
  std::shared_ptr<const SeamedBodies> seams;
  // What the surfaces are felt like, solver frame. Null in a world without effects.
  std::shared_ptr<const EffectProgram> effects;

  Vec3 to_solver(const Vec3& p_scene) const { return p_scene - anchor_scene_m; }
  Vec3 to_scene(const Vec3& p_solver) const { return p_solver + anchor_scene_m; }
};

// Lengths the solver decides by, all derived from the scene's size and the format of double.
struct SolverScale {
  // A proxy touches what is this near: far enough that rounding can never put it on the other side.
  // Rounding of a height is at most 20 * 2^-53 * 3 sizes = 7e-15 sizes (kHeightRoundoff); 1e-11
  // leaves three orders of magnitude for the millions of ticks over which heights wander.
  double stand_off_m;
  // The proxy is stopped this far from a surface. A little less than a stand-off, so that it still
  // touches what it has been stopped at when rounding has turned its slide away by a part in ten
  // thousand of its length.
  double stop_m;
  // Where a point proxy ends a step, it is at least this far from every triangle, crossed or not: a
  // proxy that came to rest closer than rounding beside an edge would have lost its side.
  double clearance_m;

  static constexpr double kStandOffPerSize = 1e-11;
  static constexpr double kStopPerStandOff = 0.875;
  static constexpr double kClearancePerStandOff = 0.25;
  static_assert(kMostApartPerStandOff < kClearancePerStandOff);

  // radius_m: of the proxy; positions are then exact to the radius' rounding, too.
  static SolverScale of(double size_m, double radius_m) {
    const double stand_off =
        kStandOffPerSize * std::max({size_m, radius_m, std::numeric_limits<double>::min()});
    return {stand_off, kStopPerStandOff * stand_off, kClearancePerStandOff * stand_off};
  }
};

}  // namespace palpate
