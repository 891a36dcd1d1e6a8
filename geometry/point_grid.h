#pragma once

// Points sorted by where they are, for those very near to a point.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/types.h"

namespace palpate {

// Cubic cells without end, of which only those that hold points take memory. Any frame, metres.
// Coordinates below 2^62 cells. Deterministic. Not for the haptic thread.
class PointGrid {
 public:
  // What a query looks at, at most: a crowd in one cell cannot make a query long.
  static constexpr std::size_t kMostVisited = 1024;

  // capacity: points that will be inserted, at most.
  PointGrid(double cell_m, std::size_t capacity) : per_cell_(1.0 / cell_m) {
    std::size_t buckets = 16;
    while (buckets < 2 * capacity) buckets *= 2;
    first_.assign(buckets, kNone);
    entries_.reserve(capacity);
  }

  void insert(const Vec3& p, std::uint32_t id) {
    const std::uint64_t key = key_of(cell_of(p));
    std::uint32_t& first = first_[key & (first_.size() - 1)];
    entries_.push_back({key, id, first});
    first = static_cast<std::uint32_t>(entries_.size() - 1);
  }

  // Calls visit(id) for the points in all cells that come within radius_m of p, the last inserted
  // of a cell first: all that are so near, and some that are not. radius_m: less than half a cell.
  template <typename Visit>
  void visit_near(const Vec3& p, double radius_m, Visit visit) const {
    const Cell low = cell_of((p.array() - radius_m).matrix());
    const Cell high = cell_of((p.array() + radius_m).matrix());
    std::size_t visited = 0;
    for (std::int64_t x = low.x; x <= high.x; ++x) {
      for (std::int64_t y = low.y; y <= high.y; ++y) {
        for (std::int64_t z = low.z; z <= high.z; ++z) {
          const std::uint64_t key = key_of({x, y, z});
          for (std::uint32_t e = first_[key & (first_.size() - 1)]; e != kNone;
               e = entries_[e].next) {
            if (++visited > kMostVisited) return;
            if (entries_[e].key == key) visit(entries_[e].id);
          }
        }
      }
    }
  }

 private:
  struct Cell {
    std::int64_t x, y, z;
  };
  struct Entry {
    std::uint64_t key;
    std::uint32_t id;
    std::uint32_t next;  // of the same bucket
  };
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  Cell cell_of(const Vec3& p) const {
    const auto floor_of = [&](double x) {
      return static_cast<std::int64_t>(std::floor(x * per_cell_));
    };
    return {floor_of(p.x()), floor_of(p.y()), floor_of(p.z())};
  }
  // SplitMix64's finaliser (S. Vigna, 2015) over the three coordinates. Two cells with one key are
  // as if they were one.
  static std::uint64_t key_of(const Cell& cell) {
    std::uint64_t key = 0;
    for (const std::int64_t c : {cell.x, cell.y, cell.z}) {
      key = (key ^ static_cast<std::uint64_t>(c)) + 0x9e3779b97f4a7c15u;
      key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9u;
      key = (key ^ (key >> 27)) * 0x94d049bb133111ebu;
      key ^= key >> 31;
    }
    return key;
  }

  double per_cell_;
  std::vector<std::uint32_t> first_;  // by the low bits of the key; their number is a power of two
  std::vector<Entry> entries_;
};

}  // namespace palpate
