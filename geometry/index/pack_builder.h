#pragma once

#include "geometry/index/face_order.h"
#include "geometry/index/surface_index.h"

namespace palpate {

// Sorts the faces of a mesh, mapped to the index frame, by order_faces(). Then groups every 16
// consecutive faces into a pack, and every 16 consecutive packs into a cluster. Only the last pack
// and the last cluster may be partly filled. The result is the same for any number of threads. O(n
// log n).
PackedSurface pack_surface(const MappedFaces& faces);

}  // namespace palpate
