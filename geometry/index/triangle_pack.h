#pragma once

// Sixteen neighbouring triangles, in single precision, to be asked all at once.

#include <cstdint>

namespace palpate {

// A pack only sorts out: whatever may matter is decided afterwards on the triangle's own doubles.
// Its coordinates are relative to the pack's centre and in units of its size, so float keeps 24
// bits of what counts, whatever the size of the scene and wherever in it the pack is:
//
//     local = (p - centre_m) * per_metre,     every corner within [-1/2, 1/2]
//
// Lanes past `count` repeat the last triangle.
struct alignas(64) TrianglePack {
  static constexpr int kLanes = 16;

  double centre_m[3];  // frame of the index
  double per_metre;    // a power of two
  // Bound on the rounding in double of p - centre_m that the centre itself is the cause of, local
  // units. It counts only for packs a hundred million times smaller than their distance from the
  // origin.
  float centre_roundoff;
  std::int32_t count;

  alignas(64) float normal[3][kLanes];  // unit
  float height[kLanes];                 // of the plane: normal . local = height on it
  float a[3][kLanes];
  float b[3][kLanes];
  float c[3][kLanes];
  // Only for distances: 1 / length squared of the edges ab, bc, ca; 0 for one that has none in
  // float.
  float per_squared_edge[3][kLanes];

  std::uint32_t lanes() const { return (1u << count) - 1u; }  // a bit each
};

// Sixteen axis-aligned boxes, metres. Boxes that are not there are empty: low > high.
struct alignas(64) BoxPack {
  float low[3][TrianglePack::kLanes];
  float high[3][TrianglePack::kLanes];
};

// One box in float, metres. The fourth numbers are zero.
struct alignas(16) FloatBox {
  float low[4];
  float high[4];
};

// Some lanes of one pack.
struct PackLanes {
  std::uint32_t pack;
  std::uint32_t lanes;
};

// Some lanes of one pack that a sphere may come near to on a step, and by when it may.
struct alignas(64) PackApproach {
  std::uint32_t pack;
  std::uint32_t lanes;
  float squared_limit;  // of a distance out of reach
  // Squared distances at the start, and by how much they fall in all of the step: distance times
  // its derivative there. Local units.
  alignas(64) float squared[TrianglePack::kLanes];
  float fall[TrianglePack::kLanes];

  bool is_in_reach_at_start(int lane) const { return !(squared[lane] > squared_limit); }

  // Whether a triangle may be in reach by that fraction of the step, rounded up. A distance is
  // convex along the step, so it stays above its tangent at the start.
  bool may_be_in_reach_by(float fraction, int lane) const {
    const float end = squared[lane] - fraction * fall[lane];
    return is_in_reach_at_start(lane) || !(end > 0.0f && end * end > squared_limit * squared[lane]);
  }
};

}  // namespace palpate
