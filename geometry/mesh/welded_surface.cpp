#include "geometry/mesh/welded_surface.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <mutex>
#include <utility>

#include "geometry/base/buckets.h"
#include "geometry/base/fixed_array.h"
#include "geometry/base/parallel.h"
#include "geometry/exact/exact.h"
#include "geometry/mesh/weld.h"

namespace palpate {
namespace {

constexpr std::size_t kFacesWorthAThread = 50000;  // a millisecond of work

// Replaces the vertex indices of triangles by welded vertices. Returns the triangles without area,
// ascending.
std::vector<std::uint32_t> weld_triangles(const Weld& weld, std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> dropped;
  std::mutex mutex;
  run_ranges(triangles.size(), kFacesWorthAThread, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> without_area;
    for (std::size_t t = begin; t < end; ++t) {
      Triangle& face = triangles[t];
      for (std::uint32_t& v : face) {
        assert(v < weld.vertex_of.size());
        v = weld.vertex_of[v];
      }
      const std::vector<Vec3>& p = weld.positions_m;
      const bool has_area = face[0] != face[1] && face[1] != face[2] && face[2] != face[0] &&
                            !exactly_collinear(p[face[0]], p[face[1]], p[face[2]]);
      if (!has_area) without_area.push_back(static_cast<std::uint32_t>(t));
    }
    const std::lock_guard lock(mutex);
    dropped.insert(dropped.end(), without_area.begin(), without_area.end());
  });
  std::sort(dropped.begin(), dropped.end());
  return dropped;
}

// dropped: ascending.
void erase_faces(const std::vector<std::uint32_t>& dropped, std::vector<Triangle>& faces) {
  if (dropped.empty()) return;
  std::size_t kept = dropped.front();
  auto next = dropped.begin();
  for (std::size_t f = kept; f < faces.size(); ++f) {
    if (next != dropped.end() && *next == f) {
      ++next;
    } else {
      faces[kept++] = faces[f];
    }
  }
  faces.resize(kept);
}

// Per vertex: whether a face uses it.
FixedArray<std::uint8_t> used_vertices(std::span<const Triangle> faces, std::size_t vertex_count) {
  FixedArray<std::uint8_t> is_used(vertex_count);
  std::fill(is_used.data(), is_used.data() + vertex_count, std::uint8_t{0});
  run_ranges(faces.size(), kFacesWorthAThread, [&](std::size_t begin, std::size_t end) {
    for (const Triangle& face : faces.subspan(begin, end - begin)) {
      for (const std::uint32_t v : face) {
        std::atomic_ref(is_used[v]).store(1, std::memory_order_relaxed);
      }
    }
  });
  return is_used;
}

}  // namespace

WeldedSurface::WeldedSurface(std::vector<Vec3> positions, std::vector<Triangle> triangles) {
  weld(std::move(positions), std::move(triangles));
  drop_unused_positions();
}

WeldedSurface WeldedSurface::with_unused_positions(std::vector<Vec3> positions,
                                                   std::vector<Triangle> triangles) {
  WeldedSurface surface;
  surface.weld(std::move(positions), std::move(triangles));
  return surface;
}

void WeldedSurface::weld(std::vector<Vec3> positions, std::vector<Triangle> triangles) {
  faces_ = std::move(triangles);
  assert(faces_.size() < 300'000'000);  // six half-edges each, within OpenMesh's int
  report_.triangles_in = faces_.size();
  Weld weld = weld_equal_positions(std::move(positions));
  std::vector<std::uint32_t> dropped = weld_triangles(weld, faces_);
  weld.vertex_of = std::vector<std::uint32_t>();  // {} would keep its memory
  positions_ = std::move(weld.positions_m);
  erase_faces(dropped, faces_);
  report_.dropped_degenerate = dropped.size();
  mates_ = match_half_edges(faces_, positions_.size());
  if (mates_.has_duplicates) {
    mates_ = {};  // frees the old mates before new ones are computed
    drop_duplicates(dropped);
    mates_ = match_half_edges(faces_, positions_.size());
  }
  report_.dropped_duplicate = dropped.size() - report_.dropped_degenerate;
  sources_ = SourceTriangles(dropped);
  count();
}

// Updates the parts of the report that follow from faces, mates and positions.
void WeldedSurface::count() {
  report_.triangles = faces_.size();
  report_.boundary_edges = mates_.boundary_edges;
  report_.non_manifold_edges = mates_.non_manifold_edges;
  report_.welded_vertices = positions_.size();
  position_span_ = positions_;
}

MemoryNeed WeldedSurface::memory_need(std::uint64_t positions, std::uint64_t triangles) {
  constexpr std::uint64_t kBlocks = 1024;  // rounding of block sizes, and small blocks
  constexpr std::uint64_t kIndex = sizeof(std::uint32_t);
  const std::uint64_t mates = 3 * kIndex * triangles;
  // Each half-edge by its lower end. The search for duplicates, with sorted faces by lowest vertex,
  // needs no more.
  const std::uint64_t match = mates + 3 * kIndex * triangles + kIndex * positions;
  // A sample of lower ends, in a growing list.
  const std::uint64_t sample = mates + 9 * kIndex * std::min<std::uint64_t>(triangles, 4096);
  return {mates + kBlocks, std::max({weld_memory(positions), match, sample}) + kBlocks};
}

// The faces with the same three vertices as an earlier face, ascending.
std::vector<std::uint32_t> WeldedSurface::find_duplicates() const {
  std::vector<Triangle> keys = faces_;
  const std::size_t vertex_count = positions_.size();
  for (Triangle& key : keys) std::sort(key.begin(), key.end());
  Buckets by_lowest =
      group_by_key(keys.size(), vertex_count, [&](std::size_t f) { return keys[f][0]; });
  std::vector<std::uint32_t> duplicates;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto begin = by_lowest.items.begin() + by_lowest.first[v];
    const auto end = by_lowest.items.begin() + by_lowest.first[v + 1];
    std::sort(begin, end, [&](std::uint32_t f, std::uint32_t g) {
      return keys[f] != keys[g] ? keys[f] < keys[g] : f < g;
    });
    for (auto f = begin; f != end; ++f) {
      if (f != begin && keys[*f] == keys[*(f - 1)]) duplicates.push_back(*f);
    }
  }
  std::sort(duplicates.begin(), duplicates.end());
  return duplicates;
}

// Drops duplicate faces and adds their triangles to `dropped`.
void WeldedSurface::drop_duplicates(std::vector<std::uint32_t>& dropped) {
  const std::vector<std::uint32_t> duplicates = find_duplicates();
  const SourceTriangles sources(dropped);
  const auto first = static_cast<std::ptrdiff_t>(dropped.size());
  for (const std::uint32_t f : duplicates) dropped.push_back(sources.of_face(f));
  std::inplace_merge(dropped.begin(), dropped.begin() + first, dropped.end());
  erase_faces(duplicates, faces_);
}

// Keeps the order of the others, and renumbers the faces.
void WeldedSurface::drop_unused_positions() {
  const FixedArray<std::uint8_t> is_used = used_vertices(faces_, positions_.size());
  if (std::find(is_used.begin(), is_used.end(), 0) == is_used.end()) return;
  std::vector<std::uint32_t> new_index(positions_.size());
  std::uint32_t used = 0;
  for (std::size_t v = 0; v < positions_.size(); ++v) {
    if (is_used[v] == 0) continue;
    new_index[v] = used;
    positions_[used++] = positions_[v];
  }
  positions_.resize(used);
  for (Triangle& face : faces_) {
    for (std::uint32_t& v : face) v = new_index[v];
  }
  report_.welded_vertices = positions_.size();
  position_span_ = positions_;
}

}  // namespace palpate
