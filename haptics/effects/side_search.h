#pragma once

// A search for the side of a closed surface on which a point lies, with counted work.

#include <cstdint>

#include "geometry/index/inside.h"
#include "haptics/proxy/work.h"

namespace palpate {

// The side of a point is found from the number of triangles that a segment crosses: the path from a
// point whose side is known, or a probe that ends outside (inside.h). The search can stop at any
// pack and continue in a later tick, with the segment that it began. Index frame. Plain numbers,
// because it is a part of an effect's state. Like is_inside() and crosses_odd(), it requires a
// closed surface.
struct SideSearch {
  enum class Segment : std::uint8_t { kNone, kPath, kProbe };

  Segment segment = Segment::kNone;
  std::uint8_t is_undecided = 0;
  std::uint16_t attempt = 0;    // number of the probe
  std::uint32_t next_pack = 0;  // all packs before it have been searched
  std::uint32_t crossings = 0;  // in these packs
  double point[3] = {};         // the point whose side is sought
  double other_end[3] = {};     // of the segment

  bool is_under_way() const { return segment != Segment::kNone; }
  void begin_path(const Vec3& from, const Vec3& to) noexcept;
  void begin_probe(const SurfaceIndex& index, const Vec3& p, int number) noexcept;
};

enum class SideResult : std::uint8_t {
  kCutShort,   // the work is spent: call again
  kUndecided,  // the segment meets an edge, or as crosses_odd()
  kEven,
  kOdd
};

// Begins or continues the search along the segment. Searches at least one pack. The result depends
// neither on the instruction set nor on the calls in which it was found. Safe on the haptic thread.
SideResult count_crossings(const SurfaceIndex& index, SideSearch& search, WorkMeter& work) noexcept;

// Begins or continues a search by probes, as is_inside() does: kOdd is inside, kEven outside.
SideResult find_side(const SurfaceIndex& index, SideSearch& search, WorkMeter& work) noexcept;

}  // namespace palpate
