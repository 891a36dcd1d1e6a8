#pragma once

// What surfaces take: what making them will, and what those that are compiled do, by what it is
// for.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// What it keeps, with the room for more.
template <typename T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

// Bytes that making something takes, told before it is made.
struct MemoryNeed {
  std::uint64_t kept = 0;
  std::uint64_t peak = 0;  // at any time while it is made, with what is kept

  // One after the other.
  MemoryNeed operator+(const MemoryNeed& next) const {
    return {kept + next.kept, std::max(peak, kept + next.peak)};
  }
  MemoryNeed operator+(std::uint64_t more_kept) const {
    return {kept + more_kept, peak + more_kept};
  }
};

// Bytes. Those of a mesh and of an index add up.
struct MemoryBreakdown {
  std::size_t adjacency = 0;        // OpenMesh's vertices, half-edges and faces
  std::size_t positions = 0;        // of OpenMesh's vertices, which are the welded ones, too
  std::size_t maps = 0;             // to the triangles and vertices that cleaning was given
  std::size_t index_triangles = 0;  // in double, with the number of the face
  std::size_t index_packs = 0;      // the same in float, sixteen at a time
  std::size_t index_boxes = 0;      // around packs, and Embree's tree over them

  std::size_t places = 0;   // of a scene's nodes: names, poses, and the tree over them
  std::size_t effects = 0;  // of a scene: what surfaces keep for them, maps, and their parameters

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
