#pragma once

// An exact test whether a point lies inside a closed surface.
//
// A point is inside if a segment from the point to the outside crosses the surface an odd number of
// times. By this parity rule, a cavity is outside. A region that two nested or overlapping parts
// both enclose is outside, too. The orientation of faces has no effect.

#include <cstdint>
#include <optional>

#include "geometry/base/box.h"
#include "geometry/exact/orientation.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// Whether inside and outside are well defined: every welded edge has an even number of faces, in
// any orientation. All segments between two given points then have the same crossing parity. The
// test uses the cleaned mesh, as an index does. A surface that is closed only by triangles without
// area therefore counts as open. A mesh without faces is closed. Load time only; O(n), and O(m log
// m) in the number m of edges that surface() cuts.
bool is_closed(const SurfaceMesh& mesh);

// kMostTries is the largest number of segments that is_inside() tries; kMostCrossings is the
// largest number of crossings that it counts per segment.
inline constexpr int kMostTries = 16;
inline constexpr int kMostCrossings = 256;

// Whether p, in the index frame, is inside the surface. Requires a closed surface and finite
// coordinates within the range of orientation(). Returns no value if p lies on the surface, or if
// all kMostTries segments to probe_end() are undecided. Exact for the index's triangles in double;
// these form a closed surface if the mesh is closed, under any map. The work is at most kMostTries
// segment queries, each along a segment not much longer than the box. Thread-safe, safe on the
// haptic thread: no allocation.
std::optional<bool> is_inside(const SurfaceIndex& index, const Vec3& p) noexcept;

// Whether the segment from p to q crosses the surface an odd number of times, so that one end is
// inside and the other outside. With this test, a caller can track a moving point from tick to tick
// at a lower cost than with is_inside(). Returns no value if the segment touches an edge or vertex,
// begins or ends on the surface, lies in a face or crosses more than kMostCrossings triangles. If p
// == q, there is no crossing. Requirements, exactness and thread safety are those of is_inside().
std::optional<bool> crosses_odd(const SurfaceIndex& index, const Vec3& p, const Vec3& q) noexcept;

// How a segment crosses a triangle, for counts of crossings.
enum class Crossing : std::uint8_t {
  kNone,
  kProper,    // through the interior, and the segment does not end in the triangle's plane
  kUndecided  // it touches an edge or vertex, lies in the plane or ends in it
};
// Adds the signs that double arithmetic could not decide to `signs`.
Crossing crossing_of(const TriangleGeometry& t, const Vec3& p, const Vec3& q,
                     SignWork& signs) noexcept;

// In try `attempt` (0, 1, ...), is_inside() uses a segment from p to a point outside the box. This
// function returns that point, the end of the segment. Requires p inside the box. The tries cycle
// through the faces of the box, nearest face first. The end lies beyond the face that belongs to
// the try. The segment is oblique, because many meshes have edges parallel to the axes.
Vec3 probe_end(const Box& box, const Vec3& p, int attempt) noexcept;

}  // namespace palpate
