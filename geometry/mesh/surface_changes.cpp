#include "geometry/mesh/surface_changes.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <span>
#include <utility>

#include "geometry/exact/exact.h"
#include "geometry/mesh/divided_face.h"
#include "geometry/mesh/welded_surface.h"

namespace palpate {
namespace {

constexpr std::array<CornerWeights, 3> kWhole = {{{0, 0}, {1, 0}, {0, 1}}};

// Numbers of the vertices after merging.
FixedArray<std::uint32_t> merged_numbers(std::size_t vertices,
                                         std::span<const MergedVertex> merged) {
  FixedArray<std::uint32_t> number(vertices);
  std::iota(number.data(), number.data() + vertices, 0u);
  for (const MergedVertex& m : merged) number[m.vertex] = m.into;
  return number;
}

bool has_area(const Triangle& face, std::span<const Vec3> p) {
  return face[0] != face[1] && face[1] != face[2] && face[2] != face[0] &&
         !exactly_collinear(p[face[0]], p[face[1]], p[face[2]]);
}

}  // namespace

void WeldedSurface::change(const SurfaceChanges& changes) {
  for (const MovedVertex& m : changes.moved) positions_[m.vertex] = m.position_m;
  positions_.insert(positions_.end(), changes.added_m.begin(), changes.added_m.end());
  mates_ = {};  // frees the old mates before new ones are computed
  if (!changes.divisions.empty()) divide_faces(changes.divisions);
  if (!changes.merged.empty()) {
    const auto number = merged_numbers(positions_.size(), changes.merged);
    for (Triangle& face : faces_) {
      for (std::uint32_t& v : face) v = number[v];
    }
  }
  report_.joined_edges += changes.joined_edges;
  report_.joined_vertices += changes.merged.size();
  clean_again();
}

// Replaces each face with divisions by its parts.
void WeldedSurface::divide_faces(std::span<const EdgeDivision> divisions) {
  std::vector<Triangle> faces;
  faces.reserve(faces_.size() + divisions.size());
  SourceTriangles sources;
  const auto append = [&](const TrianglePart& part, std::uint32_t source, bool is_piece) {
    const auto number = static_cast<std::uint32_t>(faces.size());
    faces.push_back(part.vertices);
    sources.append(number, source);
    if (is_piece) sources.append_piece({number, part.corners});
  };
  auto next = divisions.begin();
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const FacePiece* piece = sources_.piece(f);
    const TrianglePart whole{faces_[f], piece ? piece->corners : kWhole};
    const auto first = next;
    while (next != divisions.end() && next->half_edge / 3 == f) {
      if (next == first || std::prev(next)->half_edge != next->half_edge) ++report_.divided_edges;
      ++next;
    }
    const std::uint32_t source = sources_.of_face(f);
    if (first == next) {
      append(whole, source, piece != nullptr);
      continue;
    }
    for (const TrianglePart& part : divided(whole, {first, next})) append(part, source, true);
  }
  report_.added_triangles += faces.size() - faces_.size();
  faces_ = std::move(faces);
  sources_ = std::move(sources);
}

// Cleans faces whose vertices have changed.
void WeldedSurface::clean_again() {
  std::vector<std::uint32_t> dropped;
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    if (!has_area(faces_[f], positions_)) dropped.push_back(f);
  }
  report_.dropped_degenerate += dropped.size();
  drop_faces(dropped);
  mates_ = match_half_edges(faces_, positions_.size());
  if (mates_.has_duplicates) {
    mates_ = {};
    const std::vector<std::uint32_t> duplicates = find_duplicates();
    report_.dropped_duplicate += duplicates.size();
    drop_faces(duplicates);
    mates_ = match_half_edges(faces_, positions_.size());
  }
  drop_unused_positions();
  sources_.shrink_to_fit();
  count();
}

// Drops faces and their sources. dropped: ascending.
void WeldedSurface::drop_faces(const std::vector<std::uint32_t>& dropped) {
  if (dropped.empty()) return;
  SourceTriangles sources;
  std::uint32_t kept = 0;
  auto next = dropped.begin();
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    if (next != dropped.end() && *next == f) {
      ++next;
      continue;
    }
    sources.append(kept, sources_.of_face(f));
    if (const FacePiece* piece = sources_.piece(f)) sources.append_piece({kept, piece->corners});
    faces_[kept++] = faces_[f];
  }
  faces_.resize(kept);
  sources_ = std::move(sources);
}

MemoryNeed WeldedSurface::memory_need_of_change(std::uint64_t divisions) const {
  constexpr std::uint64_t kBlocks = 2048;  // rounding of block sizes, and small blocks
  const std::uint64_t faces = faces_.size() + divisions;
  const std::uint64_t positions = positions_.size() + divisions;
  const std::uint64_t mates = 3 * sizeof(std::uint32_t) * faces;
  // A division adds a face, and makes pieces of two faces at most; a vector that grows has up to
  // twice its size, beside the old one.
  const std::uint64_t pieces =
      divisions == 0 ? 0 : 2 * divisions * (sizeof(FacePiece) + 2 * sizeof(std::uint32_t));
  const std::uint64_t kept = pieces +
                             (divisions == 0 ? 0
                                             : divisions * sizeof(Triangle) + mates -
                                                   3 * sizeof(std::uint32_t) * faces_.size()) +
                             kBlocks;
  const std::uint64_t numbers = positions * (sizeof(std::uint32_t) + 1);
  const std::uint64_t copies =
      divisions == 0 ? 0 : faces * sizeof(Triangle) + positions * sizeof(Vec3) + 2 * pieces;
  const std::uint64_t match = mates + numbers;
  return {kept, kept + std::max(numbers + copies, match) + kBlocks};
}

WeldedSurface WeldedSurface::copy() const {
  WeldedSurface surface;
  surface.faces_ = faces_;
  surface.positions_ = positions_;
  surface.mates_.aligned = FixedArray<std::uint32_t>(mates_.aligned.size());
  std::copy(mates_.aligned.begin(), mates_.aligned.end(), surface.mates_.aligned.data());
  static_cast<EdgeFindings&>(surface.mates_) = mates_;
  surface.sources_ = sources_;
  surface.report_ = report_;
  surface.position_span_ = surface.positions_;
  return surface;
}

}  // namespace palpate
