#pragma once

// A reference implementation of the god-object that is independent of the engine: long double, all
// faces in the cells of a grid, no stand-off, no cache and no index.

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "geometry/base/types.h"

namespace palpate::test {

using Wide = long double;
using WideVec3 = Eigen::Matrix<Wide, 3, 1>;

// A closed, consistently oriented surface that is touched from one side. Metres, any frame.
class ReferenceSurface {
 public:
  enum class Side : std::uint8_t { kOutside, kInside };  // where the proxy is

  struct Face {
    std::array<WideVec3, 3> corners;
    WideVec3 normal;                 // unit, towards the proxy's side
    std::array<WideVec3, 3> inward;  // [e]: inward unit normal of the edge from corner e, in plane
  };

  ReferenceSurface(const std::vector<Vec3>& positions_m, const std::vector<Triangle>& triangles,
                   Side side);

  const std::vector<Face>& faces() const { return faces_; }
  // Lengths below this bound are within the rounding error of long double. The bound allows 2^-64
  // for each of about 30 operations, and planes that meet at more than 0.1 deg.
  Wide roundoff_m() const { return roundoff_m_; }

  Wide height_m(std::uint32_t face, const WideVec3& p) const;
  // Whether p lies in the prism of the face, to within the rounding.
  bool is_over(std::uint32_t face, const WideVec3& p) const;
  WideVec3 project(std::uint32_t face, const WideVec3& p, Wide height_m) const;

  // A superset of the faces whose bounding boxes come near the box around a and b, in ascending
  // order. Valid until the next call.
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

// The half-space normal . p >= offset_m of a face.
struct ReferencePlane {
  std::uint32_t face;
  WideVec3 normal;
  Wide offset_m;
};

// The point nearest to the goal within all half-spaces, and the planes that hold it. These planes
// are the only subset of up to three planes with two properties: all its planes push, and its
// solution violates no plane. Returns nullopt if no such subset exists.
struct NearestFeasible {
  WideVec3 point;
  std::vector<ReferencePlane> active;
};
std::optional<NearestFeasible> nearest_feasible(const std::vector<ReferencePlane>& planes,
                                                const WideVec3& goal, Wide roundoff_m);

// The point proxy of Zilles & Salisbury. Its path is a sequence of straight pieces. The proxy moves
// on the planes of the faces that hold it. It moves straight to that point of these planes that is
// nearest to the goal, even through free space beyond a convex edge. The plane of the first face
// that the proxy meets on its way is added to those planes. If the faces are no longer under the
// proxy, the proxy drops all planes and falls straight towards the goal.
class ReferenceGodObject {
 public:
  ReferenceGodObject(const ReferenceSurface& surface, const WideVec3& start)
      : surface_(&surface), proxy_(start) {}

  // Returns false if the proxy did not come to rest.
  bool move_to(const WideVec3& goal);

  const WideVec3& proxy() const { return proxy_; }
  // The planes that hold the proxy.
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

// The point nearest to the goal inside a convex surface that is moved inwards by offset_m. The
// centre of a sphere of radius offset_m rests there if it is pressed against the surface from
// inside. The inside is convex, so the point is unique and does not depend on the path. surface:
// must have Side::kInside.
NearestFeasible nearest_inside_convex(const ReferenceSurface& surface, const WideVec3& goal,
                                      Wide offset_m, Wide reach_m);

}  // namespace palpate::test
