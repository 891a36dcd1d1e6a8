#pragma once

// A pack: sixteen neighbouring triangles in single precision, tested in parallel.

#include <cstdint>

namespace palpate {

// A pack is a filter only. The triangles that it does not exclude are tested in double, with their
// vertices. The coordinates are relative to the pack's centre and in units of its size, so that
// float has 24 bits of precision at the scale of the pack, for any size of the scene and any
// position of the pack:
//
//     local = (p - centre_m) * per_metre,     every corner within [-1/2, 1/2]
//
// Lanes at or beyond `count` repeat the last triangle.
struct alignas(64) TrianglePack {
  static constexpr int kLanes = 16;

  double centre_m[3];  // index frame
  double per_metre;    // a power of two
  // Bound, in local units, on the rounding error that the magnitude of the centre causes when
  // p - centre_m is computed in double. It is significant only for a pack whose distance from the
  // origin is more than 1e8 times its size.
  float centre_roundoff;
  std::int32_t count;

  alignas(64) float normal[3][kLanes];  // unit
  float height[kLanes];                 // of the plane: normal . local = height
  float a[3][kLanes];
  float b[3][kLanes];
  float c[3][kLanes];
  // For distances only: 1 / (squared length) of the edges ab, bc, ca; 0 if the edge has no length
  // in float.
  float per_squared_edge[3][kLanes];

  std::uint32_t lanes() const { return (1u << count) - 1u; }  // one bit per triangle
};

// Sixteen axis-aligned boxes, metres. Unused lanes hold empty boxes: low > high.
struct alignas(64) BoxPack {
  float low[3][TrianglePack::kLanes];
  float high[3][TrianglePack::kLanes];
};

// One box in float, metres. The fourth component is zero.
struct alignas(16) FloatBox {
  float low[4];
  float high[4];
};

// A set of lanes of one pack.
struct PackLanes {
  std::uint32_t pack;
  std::uint32_t lanes;
};

// The lanes of one pack that a moving sphere may reach during a step, and bounds on the earliest
// time at which it reaches each.
struct alignas(64) PackApproach {
  std::uint32_t pack;
  std::uint32_t lanes;
  float squared_limit;  // larger squared distances are out of reach
  // squared: squared distances at the start of the step. fall: bound on the product of two numbers.
  // The first is the distance at the start; the second is the decrease of the distance over the
  // whole step, if the rate at the start continued. Local units.
  alignas(64) float squared[TrianglePack::kLanes];
  float fall[TrianglePack::kLanes];

  bool is_in_reach_at_start(int lane) const { return !(squared[lane] > squared_limit); }

  // Whether a triangle may be in reach before this fraction of the step, which must be rounded up.
  // The distance is a convex function along the step, so it stays above its tangent at the start.
  bool may_be_in_reach_by(float fraction, int lane) const {
    const float end = squared[lane] - fraction * fall[lane];
    return is_in_reach_at_start(lane) || !(end > 0.0f && end * end > squared_limit * squared[lane]);
  }
};

}  // namespace palpate
