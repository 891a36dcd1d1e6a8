#include "geometry/mesh/source_triangles.h"

#include <algorithm>
#include <iterator>

#include "geometry/base/memory_breakdown.h"

namespace palpate {

SourceTriangles::SourceTriangles(const std::vector<std::uint32_t>& dropped) {
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    const bool is_run_of_drops = i + 1 < dropped.size() && dropped[i + 1] == dropped[i] + 1;
    if (is_run_of_drops) continue;
    runs_.push_back({dropped[i] - static_cast<std::uint32_t>(i), dropped[i] + 1});
  }
  runs_.shrink_to_fit();
}

void SourceTriangles::append(std::uint32_t face, std::uint32_t triangle) {
  if (of_face(face) != triangle) runs_.push_back({face, triangle});
}

void SourceTriangles::shrink_to_fit() {
  runs_.shrink_to_fit();
  pieces_.shrink_to_fit();
}

std::uint32_t SourceTriangles::of_face(std::size_t face) const {
  const auto next = std::upper_bound(runs_.begin(), runs_.end(), face,
                                     [](std::size_t f, const Run& run) { return f < run.face; });
  const auto number = static_cast<std::uint32_t>(face);
  return next == runs_.begin() ? number
                               : std::prev(next)->triangle + (number - std::prev(next)->face);
}

const FacePiece* SourceTriangles::piece(std::size_t face) const {
  const auto found =
      std::lower_bound(pieces_.begin(), pieces_.end(), face,
                       [](const FacePiece& piece, std::size_t f) { return piece.face < f; });
  return found != pieces_.end() && found->face == face ? &*found : nullptr;
}

std::size_t SourceTriangles::memory_bytes() const {
  return bytes_of(runs_) + bytes_of(pieces_);
}

}  // namespace palpate
