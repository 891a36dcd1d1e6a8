#pragma once

// What the god-object should answer, found by other means than the engine's: long double, all faces
// of a grid, no stand-off, no cache, no index.

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "geometry/base/types.h"

namespace palpate::test {

using Wide = long double;
using WideVec3 = Eigen::Matrix<Wide, 3, 1>;

// A closed, consistently oriented surface, seen from one side. Metres, any frame.
class ReferenceSurface {
 public:
  enum class Side : std::uint8_t { kOutside, kInside };  // where the proxy is

  struct Face {
    std::array<WideVec3, 3> corners;
    WideVec3 normal;                 // unit, towards the proxy's side
    std::array<WideVec3, 3> inward;  // of the edge from corner e: unit, in the face's plane
  };

  ReferenceSurface(const std::vector<Vec3>& positions_m, const std::vector<Triangle>& triangles,
                   Side side);

  const std::vector<Face>& faces() const { return faces_; }
  // Below this, lengths are the rounding of long double: 2^-64 a step, some 30 steps, and planes
  // that meet at more than 0.1 deg.
  Wide roundoff_m() const { return roundoff_m_; }

  Wide height_m(std::uint32_t face, const WideVec3& p) const;
  // Whether p lies in the prism of the face, to within the rounding.
  bool is_over(std::uint32_t face, const WideVec3& p) const;
  WideVec3 project(std::uint32_t face, const WideVec3& p, Wide height_m) const;

  // Every face of which the bounding box comes near the box around a and b, and some more.
  // Ascending. Valid until the next call.
  const std::vector<std::uint32_t>& faces_around(const WideVec3& a, const WideVec3& b) const;

 private:
  std::uint64_t cell_of(const std::array<std::int64_t, 3>& cell) const;
  std::array<std::int64_t, 3> cell_at(const WideVec3& p) const;

  std::vector<Face> faces_;
  Wide cell_m_ = 0;
  Wide roundoff_m_ = 0;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
  mutable std::vector<std::uint32_t> found_;
};

// Half-space normal . p >= offset_m, made by a face.
struct ReferencePlane {
  std::uint32_t face;
  WideVec3 normal;
  Wide offset_m;
};

// The point nearest to goal within all half-spaces, and the planes that hold it: the only one of
// the subsets of up to three that pushes everywhere and violates nothing. Nothing if no subset
// does.
struct NearestFeasible {
  WideVec3 point;
  std::vector<ReferencePlane> active;
};
std::optional<NearestFeasible> nearest_feasible(const std::vector<ReferencePlane>& planes,
                                                const WideVec3& goal, Wide roundoff_m);

// The point proxy of Zilles & Salisbury as a walk. On the planes of the faces that hold it, the
// proxy goes straight to the point nearest to the goal, in free space beyond a convex edge as well;
// the first face in the way joins those planes. Where the faces are no longer under the proxy, it
// lets go of all of them and falls straight towards the goal.
class ReferenceGodObject {
 public:
  ReferenceGodObject(const ReferenceSurface& surface, const WideVec3& start)
      : surface_(&surface), proxy_(start) {}

  // False if it did not come to rest.
  bool move_to(const WideVec3& goal);

  const WideVec3& proxy() const { return proxy_; }
  // That hold the proxy.
  const std::vector<ReferencePlane>& active() const { return active_; }

 private:
  struct Hit {
    Wide fraction;
    std::uint32_t face;
  };
  std::optional<Hit> first_hit(const WideVec3& to) const;
  ReferencePlane plane_of(std::uint32_t face) const;
  bool settled() const;

  const ReferenceSurface* surface_;
  WideVec3 proxy_;
  std::vector<ReferencePlane> active_;
};

// The point nearest to goal in the inside of a convex surface moved inwards by offset_m: where the
// centre of a sphere of that radius rests that is pressed against the surface from inside. The
// inside is convex, so there is one such point, whatever the way to it. surface: Side::kInside.
NearestFeasible nearest_inside_convex(const ReferenceSurface& surface, const WideVec3& goal,
                                      Wide offset_m, Wide reach_m);

}  // namespace palpate::test
