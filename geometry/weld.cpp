#include "geometry/weld.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>

namespace palpate {
namespace {

constexpr std::uint32_t kEmpty = 0xffffffffu;

// The finalizer of SplitMix64 (Steele, Lea, Flood 2014): every bit of the result depends on every
// bit of the argument, which matters because coordinates on a grid differ in few bits.
std::uint64_t mixed(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
  return bits ^ (bits >> 31);
}

std::uint64_t hash(const Vec3& p) {
  std::uint64_t value = 0;
  for (int axis = 0; axis < 3; ++axis) {
    value = mixed(value + 0x9e3779b97f4a7c15u + std::bit_cast<std::uint64_t>(p[axis]));
  }
  return value;
}

}  // namespace

Weld weld_equal_positions(const std::vector<Vec3>& positions_m) {
  assert(positions_m.size() < kEmpty);
  // At most half full, so that probing ends after a step or two.
  std::vector<std::uint32_t> table(std::bit_ceil(2 * std::max<std::size_t>(positions_m.size(), 1)),
                                   kEmpty);
  const std::size_t mask = table.size() - 1;
  Weld weld;
  weld.vertex_of.reserve(positions_m.size());
  for (const Vec3& position : positions_m) {
    const Vec3 p = position.array() + 0.0;  // -0 + 0 is +0; any other sum with 0 changes nothing
    std::size_t slot = hash(p) & mask;
    while (table[slot] != kEmpty && weld.positions_m[table[slot]] != p) slot = (slot + 1) & mask;
    if (table[slot] == kEmpty) {
      table[slot] = static_cast<std::uint32_t>(weld.positions_m.size());
      weld.positions_m.push_back(p);
    }
    weld.vertex_of.push_back(table[slot]);
  }
  return weld;
}

}  // namespace palpate
