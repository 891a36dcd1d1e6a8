#pragma once

#include "geometry/index/face_order.h"
#include "geometry/index/surface_index.h"

namespace palpate {

// Groups the faces of a mesh, mapped to the index frame, into packs and clusters of sixteen packs,
// in the order of order_faces(). Only the last pack and the last cluster may be partly filled.
// Deterministic for any number of threads. O(n log n).
PackedSurface pack_surface(const MappedFaces& faces);

}  // namespace palpate
