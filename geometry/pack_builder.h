#pragma once

#include <vector>

#include "geometry/surface_index.h"
#include "geometry/surface_mesh.h"

namespace palpate {

// Groups the faces of a mesh, mapped to the index frame, into packs of eight that lie close
// together, by recursive median splits of the face centres along the widest axis. Only the last
// pack of a split may be partly filled. Deterministic: equal centres are ordered by face number.
// O(n log n).
std::vector<TrianglePack> build_packs(const SurfaceMesh& mesh, const AffineMap& map);

// The box around the triangles of a pack.
Box bounding_box(const TrianglePack& pack);

}  // namespace palpate
