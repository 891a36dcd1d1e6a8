#pragma once

// A spatial order of the faces of a surface.

#include <cstdint>
#include <span>

#include "geometry/mesh/mapped_faces.h"

namespace palpate {

// Writes the numbers of all faces to `order`, so that each group of 16 consecutive faces, and each
// group of 256, is compact in space. Every group except the last is full. The order results from
// recursive median splits of the face centres along the widest axis. Centres are compared in single
// precision, relative to the part being split; ties are broken by face number. Requires finite
// corners, before and after mapping, and order.size() equal to the number of faces. Deterministic
// for any number of threads. O(n log n).
void order_faces(const MappedFaces& faces, std::span<std::uint32_t> order);
// Temporary memory of order_faces() per face, in addition to `order`.
inline constexpr std::uint64_t kOrderBytesPerFace = 32;

}  // namespace palpate
