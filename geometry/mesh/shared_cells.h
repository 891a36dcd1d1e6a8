#pragma once

// Finds the cells of space that contain points of more than one owner.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/mesh/spatial_hash.h"

namespace palpate {

// An unbounded grid of cubic cells. A cell with points uses 8 bytes, regardless of the number of
// points. This is far less than the memory of a PointGrid of the same points, so that isolated
// points can be filtered out before a PointGrid is built. Reports every shared cell and, in rare
// cases, a cell that is not shared. Any frame, metres. Requires coordinates below 2^62 cells and
// owners below 2^31. Deterministic. Not for the haptic thread.
class SharedCells {
 public:
  // capacity: the largest number of points that will be added.
  SharedCells(double cell_m, std::size_t capacity)
      : per_cell_(1.0 / cell_m),
        slots_(slot_count(capacity), 0),
        marks_(slots_.size() / kSlotsPerWord, 0),
        word_shift_(64 - std::countr_zero(marks_.size())) {}

  static std::uint64_t bytes(std::size_t capacity) {
    return slot_count(capacity) * (sizeof(std::uint64_t) + sizeof(std::uint64_t) / kSlotsPerWord);
  }

  // The number of points of one owner in one cell that counts as a crowd.
  static constexpr std::uint64_t kCrowd = 64;

  // Adds a point of an owner to the cell of the point. All points of one owner must be added
  // consecutively. Returns false if the cell contains a crowd of this owner's points.
  bool add(const Vec3& p, std::uint32_t owner) { return add(key_of(p), mark_at(p), owner); }

  // The most points for the two functions below. They fetch the memory for all points into the CPU
  // cache first: to wait for it at each point would take most of the time.
  static constexpr std::size_t kMostAtOnce = 64;
  // Adds points, until add() returns false for one.
  bool add_all(std::span<const Vec3> points, std::uint32_t owner);
  // Calls visit(i) for each point in a shared cell. All points must have been added.
  template <typename Visit>
  void visit_shared(std::span<const Vec3> points, Visit visit) const {
    std::array<std::uint64_t, kMostAtOnce> keys;
    for (std::size_t i = 0; i < points.size(); ++i) {
      keys[i] = key_of(points[i]);
      fetch(keys[i]);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      if ((slots_[find(keys[i])] & kIsShared) != 0) visit(i);
    }
  }

  // False: no cell is shared.
  bool may_be_shared() const { return may_be_shared_; }

  // Points of a mesh, one array for each coordinate.
  struct Points {
    std::vector<double> x, y, z;

    explicit Points(std::span<const Vec3> points_mesh);
  };
  // Maps the points to the frame of the cells, in metres.
  struct Map {
    Mat3 linear;
    Vec3 translation;
    Vec3 reach;  // the largest |coordinate| of the points before the map, by axis
  };

  // Replaces `near` by the numbers of all points that share_near() may find near added points, and
  // of some others, in ascending order. Many times faster than share_near(). radius_m: less than
  // half a cell.
  void find_near(const Points& points, const Map& map, double radius_m,
                 std::vector<std::uint32_t>& near) const;

  // Marks as shared all cells within radius_m of p that contain points of other owners. Returns
  // whether there are any such cells. radius_m: less than half a cell.
  bool share_near(const Vec3& p, double radius_m, std::uint32_t owner) {
    bool is_any = false;
    visit_cells_near(p, radius_m, per_cell_, [&](std::uint64_t key) {
      std::uint64_t& slot = slots_[find(key)];
      if (slot == 0 || (owner_of(slot) == owner && (slot & kIsShared) == 0)) return;
      slot |= kIsShared;
      is_any = true;
    });
    may_be_shared_ = may_be_shared_ || is_any;
    return is_any;
  }

  // Whether the cell of p is the only cell within radius_m of p. If so, and if p has been added,
  // share_near() has no cell to mark.
  bool is_inside_cell(const Vec3& p, double radius_m) const {
    const SpatialCell low = spatial_cell((p.array() - radius_m).matrix(), per_cell_);
    const SpatialCell high = spatial_cell((p.array() + radius_m).matrix(), per_cell_);
    return low.x == high.x && low.y == high.y && low.z == high.z;
  }

  // Whether the cell of a previously added point is shared.
  bool is_shared(const Vec3& p) const {
    return (slots_[find(spatial_key(spatial_cell(p, per_cell_)))] & kIsShared) != 0;
  }

 private:
  // The fields of a slot, from the high bits to the low ones: 24 bits of the key, the number of the
  // last owner's points in the cell, the shared flag, the last owner, and a one. 0 is an empty
  // slot.
  static constexpr std::uint64_t kIsThere = 1;
  static constexpr std::uint64_t kIsShared = std::uint64_t{1} << 32;
  static constexpr int kCountBegin = 33;
  static constexpr std::uint64_t kTag = ~std::uint64_t{0} << 40;
  static std::uint64_t count_of(std::uint64_t slot) { return (slot & ~kTag) >> kCountBegin; }
  static std::uint64_t tag_of(std::uint64_t key) { return key & kTag; }
  static std::uint32_t owner_of(std::uint64_t slot) {
    return static_cast<std::uint32_t>(slot) >> 1;
  }

  // Space is also divided into slices as thick as a cell, across a direction in which no mesh is
  // regular. Four bits of one word mark a slice with points; other slices may share them (a Bloom
  // filter in blocks: Putze, Sanders and Singler, 2007). Most points that are searched are in
  // slices without a mark, and the marks need far less memory than the slots. The hash is Fibonacci
  // hashing (Knuth, The Art of Computer Programming, 6.4).
  struct Mark {
    std::size_t word;
    std::uint64_t bits;
  };
  static constexpr std::size_t kSlotsPerWord = 8;
  static const Vec3 kAcross;  // a unit vector
  double along(const Vec3& p) const { return kAcross.dot(p) * per_cell_; }
  Mark mark_of(std::int64_t slice) const {
    const std::uint64_t product = static_cast<std::uint64_t>(slice) * 0x9e3779b97f4a7c15u;
    const std::uint64_t hash = (product ^ product >> 32) * 0xbf58476d1ce4e5b9u;
    const auto bit = [&](int begin) { return std::uint64_t{1} << (hash >> begin & 63u); };
    return {hash >> word_shift_, bit(26) | bit(20) | bit(14) | bit(8)};
  }
  Mark mark_at(const Vec3& p) const { return mark_of(whole_below(along(p))); }
  bool is_marked(const Mark& mark) const { return (mark.bits & ~marks_[mark.word]) == 0; }

  std::uint64_t key_of(const Vec3& p) const { return spatial_key(spatial_cell(p, per_cell_)); }
  void fetch(std::uint64_t key) const { __builtin_prefetch(&slots_[key & (slots_.size() - 1)]); }

  bool add(std::uint64_t key, const Mark& mark, std::uint32_t owner) {
    marks_[mark.word] |= mark.bits;
    std::uint64_t& slot = slots_[find(key)];
    const bool is_by_another = slot != 0 && owner_of(slot) != owner;
    const std::uint64_t count = slot == 0 || is_by_another ? 1 : count_of(slot) + 1;
    may_be_shared_ = may_be_shared_ || is_by_another;
    const std::uint64_t shared = is_by_another ? kIsShared : slot & kIsShared;
    slot = tag_of(key) | std::min(count, kCrowd) << kCountBegin | shared |
           std::uint64_t{owner} << 1 | kIsThere;
    return count < kCrowd;
  }

  // At most two thirds of the slots are used, so that the runs of slots to probe are short.
  static std::size_t slot_count(std::size_t capacity) {
    std::size_t count = 16;
    while (2 * count < 3 * capacity) count *= 2;
    return count;
  }

  // The slot of a cell, or the empty slot where it would be inserted. Two cells with equal tags in
  // one run of slots are treated as one cell.
  std::size_t find(std::uint64_t key) const {
    std::size_t i = key & (slots_.size() - 1);
    while (slots_[i] != 0 && (slots_[i] & kTag) != tag_of(key)) i = (i + 1) & (slots_.size() - 1);
    return i;
  }

  double per_cell_;
  std::vector<std::uint64_t> slots_;  // its size is a power of two
  std::vector<std::uint64_t> marks_;
  bool may_be_shared_ = false;
  int word_shift_;  // to the bits of a hash that number a word of marks_
};

}  // namespace palpate
