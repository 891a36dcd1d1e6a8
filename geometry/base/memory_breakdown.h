#pragma once

// Memory of surfaces: the memory needed to build a surface, and the memory that a compiled surface
// uses, by purpose.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// The allocated bytes, including unused capacity.
template <typename T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

// Bytes needed to build an object, known before the object is built.
struct MemoryNeed {
  std::uint64_t kept = 0;
  std::uint64_t peak = 0;  // the most in use at any time during the build, including `kept`

  // The need of two builds in sequence.
  MemoryNeed operator+(const MemoryNeed& next) const {
    return {kept + next.kept, std::max(peak, kept + next.peak)};
  }
  MemoryNeed operator+(std::uint64_t more_kept) const {
    return {kept + more_kept, peak + more_kept};
  }
};

// Bytes by purpose. Two breakdowns may be added, for example those of a mesh and of its index.
struct MemoryBreakdown {
  std::size_t adjacency = 0;        // OpenMesh's vertices, half-edges and faces
  std::size_t positions = 0;        // of OpenMesh's vertices, shared with the welded surface
  std::size_t maps = 0;             // from cleaned faces and vertices to the input's
  std::size_t index_triangles = 0;  // in double, with their face numbers
  std::size_t index_packs = 0;      // the same triangles in float, in packs of sixteen
  std::size_t index_boxes = 0;      // boxes around packs, and Embree's tree

  std::size_t places = 0;   // of a scene: its nodes' names and poses, and its box tree
  std::size_t effects = 0;  // of a scene: maps, parameters and data per surface

  std::size_t total() const {
    return adjacency + positions + maps + index_triangles + index_packs + index_boxes + places +
           effects;
  }
  MemoryBreakdown& operator+=(const MemoryBreakdown& other) {
    adjacency += other.adjacency;
    positions += other.positions;
    maps += other.maps;
    index_triangles += other.index_triangles;
    index_packs += other.index_packs;
    index_boxes += other.index_boxes;
    places += other.places;
    effects += other.effects;
    return *this;
  }
};

}  // namespace palpate
