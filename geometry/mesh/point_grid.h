#pragma once

// A spatial hash of points that finds the points very near to a given point.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/base/box.h"
#include "geometry/base/types.h"
#include "geometry/mesh/spatial_hash.h"

namespace palpate {

// An unbounded grid of cubic cells; only cells with points use memory. Any frame, metres. Requires
// coordinates below 2^62 cells. Deterministic. Not for the haptic thread.
class PointGrid {
 public:
  // The largest number of points that a query examines, so that a crowded cell does not make a
  // query slow.
  static constexpr std::size_t kMostVisited = 64;

  // capacity: the largest number of points that will be inserted.
  PointGrid(double cell_m, std::size_t capacity) : per_cell_(1.0 / cell_m) {
    first_.assign(bucket_count(capacity), kNone);
    entries_.reserve(capacity);
  }

  static std::uint64_t bytes(std::size_t capacity) {
    return bucket_count(capacity) * sizeof(std::uint32_t) + capacity * sizeof(Entry);
  }

  void insert(const Vec3& p, std::uint32_t id) {
    const std::uint64_t key = spatial_key(spatial_cell(p, per_cell_));
    std::uint32_t& first = first_[key & (first_.size() - 1)];
    entries_.push_back({key, id, first});
    first = static_cast<std::uint32_t>(entries_.size() - 1);
  }

  // Calls visit(id) for the points in all cells within radius_m of p, until visit() returns false.
  // Visits all points within radius_m and some points beyond; within a cell, the last inserted
  // point comes first. Returns false if the query gave up after kMostVisited points. radius_m: less
  // than half a cell.
  template <typename Visit>
  bool visit_near(const Vec3& p, double radius_m, Visit visit) const {
    std::size_t visited = 0;
    bool goes_on = true;
    visit_cells_near(p, radius_m, per_cell_, [&](std::uint64_t key) {
      std::uint32_t e = first_[key & (first_.size() - 1)];
      for (; goes_on && e != kNone && visited <= kMostVisited; e = entries_[e].next) {
        if (++visited > kMostVisited) return;
        if (entries_[e].key == key) goes_on = visit(entries_[e].id);
      }
    });
    return !goes_on || visited <= kMostVisited;
  }

 private:
  struct Entry {
    std::uint64_t key;
    std::uint32_t id;
    std::uint32_t next;  // next entry of the same bucket
  };
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  static std::size_t bucket_count(std::size_t capacity) {
    std::size_t buckets = 16;
    while (buckets < 2 * capacity) buckets *= 2;
    return buckets;
  }

  double per_cell_;
  std::vector<std::uint32_t> first_;  // indexed by the key's low bits; its size is a power of two
  std::vector<Entry> entries_;
};

// Marks the parts of a box that contain points. Unlike a PointGrid with many points, the marks fit
// into the CPU cache; the test of a mark makes most queries of the PointGrid unnecessary.
class OccupiedCells {
 public:
  // box: contains the points that will be marked. A cell is at least as wide as the margin, so that
  // each point marks at most 27 cells.
  OccupiedCells(const Box& box, double margin_m)
      : box_(box),
        margin_m_(margin_m),
        cells_per_m_((kAlongAxis / (box.high - box.low).array()).min(1.0 / margin_m)) {
    // A box without width along an axis has one cell there.
    for (int k = 0; k < 3; ++k) {
      if (!std::isfinite(cells_per_m_[k])) cells_per_m_[k] = 0.0;
    }
    bits_.assign(kAlongAxis * kAlongAxis * kAlongAxis / 64, 0);
  }

  // Marks all cells within the margin of p.
  void mark(const Vec3& p) {
    const Vec3 margin = Vec3::Constant(margin_m_);
    const Eigen::Array3i low = cell_of(p - margin);
    const Eigen::Array3i high = cell_of(p + margin);
    for (int x = low[0]; x <= high[0]; ++x) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int z = low[2]; z <= high[2]; ++z) {
          const std::size_t bit = bit_of({x, y, z});
          bits_[bit / 64] |= std::uint64_t{1} << bit % 64;
        }
      }
    }
  }
  bool may_hold(const Vec3& p) const {
    if (!box_.contains(p)) return false;
    const std::size_t bit = bit_of(cell_of(p));
    return (bits_[bit / 64] >> bit % 64 & 1u) != 0;
  }

 private:
  static constexpr int kAlongAxis = 128;  // 256 kB in all

  Eigen::Array3i cell_of(const Vec3& p) const {
    return ((p - box_.low).array() * cells_per_m_)
        .max(0.0)
        .min(kAlongAxis - 1)
        .template cast<int>();
  }
  static std::size_t bit_of(const Eigen::Array3i& cell) {
    return static_cast<std::size_t>((cell[0] * kAlongAxis + cell[1]) * kAlongAxis + cell[2]);
  }

  Box box_;
  double margin_m_;
  Eigen::Array3d cells_per_m_;
  std::vector<std::uint64_t> bits_;
};

}  // namespace palpate
