#pragma once

// Whether a point lies inside a closed surface: exact.
//
// A point is inside if a segment from it to somewhere outside crosses the surface an odd number of
// times. So a cavity is outside, what two nested or overlapping parts both enclose is outside, too,
// and it does not matter which way a face looks.

#include <optional>

#include "geometry/base/box.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"

namespace palpate {

// Whether inside and outside are well defined: every welded edge has an even number of faces,
// whichever way they look (then no segment between two points can tell another parity than the
// next). About the cleaned mesh, as it is indexed: a surface that is only closed by triangles
// without area counts as open. A mesh without faces is closed. Load time only; O(n), and O(m log m)
// in the edges that surface() cuts.
bool is_closed(const SurfaceMesh& mesh);

// How many segments is_inside() tries, and how many crossings of one it counts.
inline constexpr int kMostTries = 16;
inline constexpr int kMostCrossings = 256;

// Whether p, in the frame of the index, is inside the surface, which must be closed. No value if p
// lies on the surface, or if none of the segments to the probe_end() of each try decides. Exact for
// the triangles in double that the index holds, which are closed where the mesh is, under any map.
// Finite coordinates, within the range of orientation(). Work is bounded by kMostTries visits of a
// segment that is not much longer than the box. Thread-safe, safe on the haptic thread: no
// allocation.
std::optional<bool> is_inside(const SurfaceIndex& index, const Vec3& p) noexcept;

// Whether the segment from p to q crosses the surface an odd number of times, so that one end is
// inside and the other not: follows a point from tick to tick for less than is_inside() takes. No
// value if the segment touches an edge or vertex, begins or ends on the surface, runs along a face
// or crosses more than kMostCrossings. p == q crosses nothing. Otherwise as is_inside().
std::optional<bool> crosses_odd(const SurfaceIndex& index, const Vec3& p, const Vec3& q) noexcept;

// Where the segment from p, in the box, ends at try 0, 1, ... of is_inside(): outside, beyond one
// of the faces of the box, the nearest ones first, and aslant, since meshes have many edges along
// axes.
Vec3 probe_end(const Box& box, const Vec3& p, int attempt) noexcept;

}  // namespace palpate
