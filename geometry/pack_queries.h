#pragma once

// Questions asked of all eight triangles of a pack at once. They only sort out: whatever may matter
// is decided afterwards, one triangle at a time, by the exact code (triangle.h,
// segment_triangle.h).

#include "geometry/surface_index.h"

namespace palpate {

// Lanes (a bit each) whose triangle may be as near to p as distance_m. Never leaves one out that
// is; may keep one that is farther by rounding. Frame of the index, metres.
unsigned lanes_within(const TrianglePack& pack, const Vec3& p, double distance_m) noexcept;

// Lanes whose triangle the closed segment p to p + d may meet, or whose plane its end may be as
// near to as clearance_m. Never leaves one out that does.
unsigned lanes_in_the_way(const TrianglePack& pack, const Vec3& p, const Vec3& d,
                          double clearance_m) noexcept;

}  // namespace palpate
