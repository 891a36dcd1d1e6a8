#pragma once

#include "geometry/surface_index.h"
#include "geometry/surface_mesh.h"

namespace palpate {

// Groups the faces of a mesh, mapped to the index frame, into packs that lie close together, by
// recursive median splits of the face centres along the widest axis, and sixteen packs into a
// cluster. All but the last pack and the last cluster of the surface are full. Deterministic: equal
// centres are ordered by face number. O(n log n).
PackedSurface pack_surface(const SurfaceMesh& mesh, const AffineMap& map);

}  // namespace palpate
