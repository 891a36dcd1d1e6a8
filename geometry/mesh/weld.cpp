#include "geometry/mesh/weld.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

#include "geometry/base/fixed_array.h"
#include "geometry/base/parallel.h"

namespace palpate {
namespace {

constexpr std::size_t kPositionsWorthAThread = 20000;  // a millisecond of work

// The finalizer of SplitMix64 (Steele, Lea, Flood 2014): every bit of the result depends on every
// bit of the argument, which matters because coordinates on a grid differ in few bits.
std::uint64_t mixed(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
  return bits ^ (bits >> 31);
}

// -0 + 0 is +0; adding 0 to any other number does not change it.
Vec3 without_minus_zero(const Vec3& p) {
  return p.array() + 0.0;
}

std::uint32_t hash(const Vec3& p) {
  const Vec3 q = without_minus_zero(p);
  std::uint64_t value = 0;
  for (int axis = 0; axis < 3; ++axis) {
    value = mixed(value + 0x9e3779b97f4a7c15u + std::bit_cast<std::uint64_t>(q[axis]));
  }
  return static_cast<std::uint32_t>(value);
}

FixedArray<std::uint32_t> hashes_of(const std::vector<Vec3>& positions_m) {
  FixedArray<std::uint32_t> hashes(positions_m.size());
  run_ranges(hashes.size(), kPositionsWorthAThread, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) hashes[i] = hash(positions_m[i]);
  });
  return hashes;
}

// Finds the first of equal positions, among the positions with hashes in one part of the range.
class PartWelder {
 public:
  PartWelder(const std::vector<Vec3>& positions_m, const FixedArray<std::uint32_t>& hashes,
             std::size_t part, std::size_t parts)
      : positions_m_(positions_m), hashes_(hashes), part_(part), parts_(parts) {
    const auto own = static_cast<std::size_t>(
        std::count_if(hashes.begin(), hashes.end(), [this](std::uint32_t h) { return is_own(h); }));
    // At most half full, so that a probe run has one or two steps.
    table_.assign(std::bit_ceil(2 * std::max<std::size_t>(own, 1)), kEmpty);
  }

  // Per position: the number of the first equal position.
  void find_first(std::vector<std::uint32_t>& first_of) {
    for (std::size_t i = 0; i < positions_m_.size(); ++i) {
      constexpr std::size_t kAhead = 24;  // covers the latency of memory
      if (i + kAhead < hashes_.size() && is_own(hashes_[i + kAhead])) {
        __builtin_prefetch(&table_[hashes_[i + kAhead] & (table_.size() - 1)]);
      }
      if (!is_own(hashes_[i])) continue;
      first_of[i] = enter(static_cast<std::uint32_t>(i));
    }
  }

 private:
  // The upper half of an entry holds the hash, so that most positions need no fetch for a
  // comparison.
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  // Tests the upper bits, because the lower bits select the slot in the table.
  bool is_own(std::uint32_t hash) const { return (std::uint64_t{hash} * parts_) >> 32 == part_; }

  std::uint32_t enter(std::uint32_t i) {
    const std::uint64_t entry = std::uint64_t{hashes_[i]} << 32 | i;
    for (std::size_t slot = hashes_[i];; ++slot) {
      std::uint64_t& found = table_[slot & (table_.size() - 1)];
      if (found == kEmpty) {
        found = entry;
        return i;
      }
      const auto other = static_cast<std::uint32_t>(found);
      if (found >> 32 == entry >> 32 && positions_m_[other] == positions_m_[i]) return other;
    }
  }

  const std::vector<Vec3>& positions_m_;
  const FixedArray<std::uint32_t>& hashes_;
  std::size_t part_;
  std::size_t parts_;
  std::vector<std::uint64_t> table_;
};

}  // namespace

std::uint64_t weld_memory(std::uint64_t positions) {
  const std::uint64_t parts = positions < kPositionsWorthAThread ? 1 : pass_count();
  // A part of the hashes may exceed its share by chance: rarely by more than four standard
  // deviations, where sqrt(share) is one.
  const double share = static_cast<double>(positions) / static_cast<double>(parts);
  const auto most = static_cast<std::uint64_t>(share + 4 * std::sqrt(share) + 1);
  const std::uint64_t tables = parts * sizeof(std::uint64_t) * std::bit_ceil(2 * most);
  const std::uint64_t vertex_of = positions * sizeof(std::uint32_t);
  const std::uint64_t hashes = positions * sizeof(std::uint32_t);
  const std::uint64_t positions_once_more = positions * sizeof(Vec3);  // when the vector shrinks
  return vertex_of + std::max(hashes + tables, positions_once_more);
}

Weld weld_equal_positions(std::vector<Vec3> positions_m) {
  assert(positions_m.size() < 0xffffffffu);
  Weld weld;
  weld.vertex_of.resize(positions_m.size());
  {
    const FixedArray<std::uint32_t> hashes = hashes_of(positions_m);
    const std::size_t parts = positions_m.size() < kPositionsWorthAThread ? 1 : pass_count();
    run_each(0, parts, [&](std::size_t part) {
      PartWelder(positions_m, hashes, part, parts).find_first(weld.vertex_of);
    });
  }
  // Replaces first positions by vertex numbers. A first position precedes all positions equal to
  // it.
  std::uint32_t distinct = 0;
  for (std::size_t i = 0; i < positions_m.size(); ++i) {
    std::uint32_t& vertex = weld.vertex_of[i];
    if (vertex != i) {
      vertex = weld.vertex_of[vertex];
    } else {
      vertex = distinct;
      positions_m[distinct++] = without_minus_zero(positions_m[i]);
    }
  }
  positions_m.resize(distinct);
  positions_m.shrink_to_fit();
  weld.positions_m = std::move(positions_m);
  return weld;
}

}  // namespace palpate
