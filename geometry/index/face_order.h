#pragma once

// Which faces of a surface lie close together.

#include <cstdint>
#include <span>

#include "geometry/mesh/mapped_faces.h"

namespace palpate {

// Writes the numbers of all faces, in an order of which each sixteen are neighbours, and each 256:
// by recursive median splits of the centres along the widest axis. All sixteens but the last are
// full. Corners must be finite, mapped as well. Centres are compared in single precision, relative
// to the part that is split; those that are equal by face number. Deterministic, for any number of
// threads. O(n log n). order: room for all of them.
void order_faces(const MappedFaces& faces, std::span<std::uint32_t> order);
// Bytes that this takes for a face, beside what it writes.
inline constexpr std::uint64_t kOrderBytesPerFace = 32;

}  // namespace palpate
