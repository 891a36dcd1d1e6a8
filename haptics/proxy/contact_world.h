#pragma once

// The rigid bodies that the proxy can touch, each with the index of its surface.

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
class FaceMaterials;

// A rigid surface placed in the solver frame.
//
// The index has its own frame and unit, so that bodies of different scales share one index. The
// body frame is the frame in which the exact tests of triangles are made:
//
//     p_body = units_per_metre R^-1 (p_solver - t),   R and t of T_solver_body
//
// For most bodies the body frame and its unit are those of the index. Tests in these units are as
// accurate as tests in metres, because rounding bounds are relative to the lengths in question. The
// change of unit adds one rounding to a point, or none if the unit is a power of two. A mirrored
// body has negative units, because a reflection is a rotation multiplied by -1. A reflection
// exchanges the front and the back of a face. The factor -1 is therefore applied to directions as
// well, so that the front of a face stays its front.
//
// The body frame of a stretched body has metres as its unit; the body's index then serves only to
// exclude triangles that are too far away (Stretch).
//
// The member functions are safe on the haptic thread: no allocation, lock or exception.
struct ContactBody {
  const SurfaceIndex* index;     // outlives the world
  RigidTransform T_solver_body;  // rotation and translation; the unit is separate
  bool is_identity;              // T_solver_body is exactly the identity
  // The body's triangles in the solver frame, with which the solver decides whether a point crosses
  // a triangle. Set only for a body that meets others along seams and has not moved since it was
  // loaded; otherwise null. Outlives the world.
  const SolverCorners* corners = nullptr;
  double units_per_metre = 1.0;
  double metres_per_unit = 1.0;
  // The stretch from the index frame to the body frame; null if the two are the same. Outlives the
  // world.
  const Stretch* stretch = nullptr;

  void place(const RigidTransform& T) {
    T_solver_body = T;
    is_identity = T.rotation.coeffs() == Quat::Identity().coeffs() && T.translation_m.isZero(0.0);
  }

  // The axis-aligned box around the body's transformed box_body(). Solver frame, m.
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
  // Transform a direction and keep its length.
  Vec3 direction_to_body(const Vec3& d_solver) const {
    return front() * (is_identity ? d_solver : T_solver_body.inverse_direction(d_solver));
  }
  Vec3 direction_to_solver(const Vec3& d_body) const {
    const Vec3 d = front() * d_body;
    return is_identity ? d : T_solver_body.direction(d);
  }
  // The difference of two points, in units of the body frame.
  Vec3 displacement_to_body(const Vec3& d_solver) const {
    return length_to_body(1.0) * direction_to_body(d_solver);
  }
  // Converts a gradient per unit of the body frame to a gradient per metre in the solver frame.
  Vec3 gradient_to_solver(const Vec3& g_body) const {
    return length_to_body(1.0) * direction_to_solver(g_body);
  }
  double length_to_body(double length_m) const { return std::abs(units_per_metre) * length_m; }
  double length_to_solver(double length_body) const {
    return std::abs(metres_per_unit) * length_body;
  }

  // Both functions convert a query near a point of the body frame to an index query. to_index()
  // maps the point, or a vector, to the index frame. reach_index() returns a radius in the index
  // frame; it covers all points within reach_m of p_body.
  Vec3 to_index(const Vec3& v_body) const { return stretch ? stretch->to_index(v_body) : v_body; }
  double reach_index(double reach_m, const Vec3& p_body) const {
    return stretch ? stretch->reach_index(reach_m, p_body) : length_to_body(reach_m);
  }

  // The triangle of a slot in the body frame. The triangle of a stretched body is computed and
  // stored in `buffer`.
  const TriangleGeometry& triangle(std::uint32_t slot, TriangleGeometry& buffer) const {
    if (!stretch) [[likely]]
      return index->triangle(slot);
    buffer = stretch->triangle(index->triangle(slot));
    return buffer;
  }

 private:
  double front() const { return std::copysign(1.0, units_per_metre); }
};

// The bodies of a scene at their initial poses. Immutable while a haptic loop uses it, so that
// threads may share it.
//
// The solver frame has the axes of the scene frame and its origin at anchor_scene_m, the middle of
// the scene. A scene 1 km from the scene frame's origin therefore loses no digits in the solver.
struct ContactWorld {
  std::vector<ContactBody> bodies;
  Box bounds_solver;  // around all surfaces, m
  Vec3 anchor_scene_m = Vec3::Zero();
  double size_m = 0.0;  // largest extent of the scene
  // Tree over the boxes of the bodies, in the order of `bodies`. Solver frame; built for sweeps of
  // the largest proxy. Null in a small world, where every body is tested.
  std::shared_ptr<const BoxTree> tree;
  // Owns the stretches of the bodies. Null in a world without stretched bodies.
  std::shared_ptr<const std::vector<Stretch>> stretches;
  // Owns the corners of the bodies. Null in a world without seams.
  std::shared_ptr<const SeamedBodies> seams;
  // The haptic effects of the surfaces, solver frame. Null in a world without effects.
  std::shared_ptr<const EffectProgram> effects;
  // The materials of the bodies' faces (face_materials.h), for TickRecord::material. Null: unknown.
  std::shared_ptr<const FaceMaterials> materials;

  Vec3 to_solver(const Vec3& p_scene) const { return p_scene - anchor_scene_m; }
  Vec3 to_scene(const Vec3& p_solver) const { return p_solver + anchor_scene_m; }
};

// The length thresholds of the solver. All derive from the scene's size and the format of double.
struct SolverScale {
  // A proxy touches a surface if it is nearer to the surface than the stand-off. The stand-off is
  // so large that rounding can never put the proxy on the other side. The rounding of a height is
  // at most 20 * 2^-53 * 3 sizes = 7e-15 sizes (kHeightRoundoff). A stand-off of 1e-11 sizes leaves
  // three orders of magnitude for the drift of heights over millions of ticks.
  double stand_off_m;
  // A step is stopped this far from a surface. The distance is a little less than a stand-off. The
  // proxy therefore still touches the surface after a slide, even if rounding has turned the slide
  // away from the surface by a ten-thousandth of its length.
  double stop_m;
  // A point proxy ends a step at least this far from every triangle, crossed or not. If a proxy
  // rested beside an edge at a distance smaller than the rounding error, rounding would hide on
  // which side of the triangle the proxy is.
  double clearance_m;

  static constexpr double kStandOffPerSize = 1e-11;
  static constexpr double kStopPerStandOff = 0.875;
  static constexpr double kClearancePerStandOff = 0.25;
  static_assert(kMostApartPerStandOff < kClearancePerStandOff);

  // The thresholds for a scene of size_m and a proxy of radius_m. They grow with the larger of the
  // two, because the rounding of positions does so, too.
  static SolverScale of(double size_m, double radius_m) {
    const double stand_off =
        kStandOffPerSize * std::max({size_m, radius_m, std::numeric_limits<double>::min()});
    return {stand_off, kStopPerStandOff * stand_off, kClearancePerStandOff * stand_off};
  }
};

}  // namespace palpate
