#pragma once

// An unbounded grid of cubic cells, each identified by a 64-bit key.

#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

struct SpatialCell {
  std::int64_t x, y, z;
};

// The largest integer that is not above x. Unlike std::floor(), this needs no call of a function.
inline std::int64_t whole_below(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return whole - (x < static_cast<double>(whole) ? 1 : 0);
}

// The cell that contains p. Requires coordinates below 2^62 cells.
inline SpatialCell spatial_cell(const Vec3& p, double cells_per_m) {
  return {whole_below(p.x() * cells_per_m), whole_below(p.y() * cells_per_m),
          whole_below(p.z() * cells_per_m)};
}

// The key of a cell: SplitMix64's finaliser (S. Vigna, 2015) over the three coordinates. Two cells
// with the same key are treated as one cell.
inline std::uint64_t spatial_key(const SpatialCell& cell) {
  std::uint64_t key = 0;
  for (const std::int64_t c : {cell.x, cell.y, cell.z}) {
    key = (key ^ static_cast<std::uint64_t>(c)) + 0x9e3779b97f4a7c15u;
    key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9u;
    key = (key ^ (key >> 27)) * 0x94d049bb133111ebu;
    key ^= key >> 31;
  }
  return key;
}

// Calls visit(key) for the cells within radius_m of p: at most eight cells for a radius of less
// than half a cell.
template <typename Visit>
void visit_cells_near(const Vec3& p, double radius_m, double cells_per_m, Visit visit) {
  const SpatialCell low = spatial_cell((p.array() - radius_m).matrix(), cells_per_m);
  const SpatialCell high = spatial_cell((p.array() + radius_m).matrix(), cells_per_m);
  for (std::int64_t x = low.x; x <= high.x; ++x) {
    for (std::int64_t y = low.y; y <= high.y; ++y) {
      for (std::int64_t z = low.z; z <= high.z; ++z) visit(spatial_key({x, y, z}));
    }
  }
}

}  // namespace palpate
