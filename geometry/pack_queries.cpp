#include "geometry/pack_queries.h"

#include <algorithm>
#include <cmath>

#include "geometry/segment_triangle.h"
#include "geometry/simd.h"

namespace palpate {
namespace {

constexpr int kLanes = TrianglePack::kLanes;

using Lanes = double[kLanes];

// Bound on the rounding of a squared distance computed as below, relative to the squared 1-norms of
// the differences it is made of: some 20 roundings, doubled for the division by the edge's length.
constexpr double kDistanceRoundoff = 64 * kUnitRoundoff;

unsigned bits_of(const Lanes& kept) {
  unsigned lanes = 0;
  for (int i = 0; i < kLanes; ++i) lanes |= static_cast<unsigned>(kept[i] != 0.0) << i;
  return lanes;
}

unsigned valid_lanes(const TrianglePack& pack) {
  return (1u << pack.count) - 1u;
}

// Lower bounds of the squared distances of p to the edges from -> to, and on which side of each
// edge p lies: inside[i] becomes 0 where it is outside.
PALPATE_SIMD_CLONES void fold_edge(const double (&from)[3][kLanes], const double (&to)[3][kLanes],
                                   const double (&normal)[3][kLanes], double x, double y, double z,
                                   Lanes& nearest, Lanes& inside) {
  for (int i = 0; i < kLanes; ++i) {
    const double ex = to[0][i] - from[0][i];
    const double ey = to[1][i] - from[1][i];
    const double ez = to[2][i] - from[2][i];
    const double px = x - from[0][i];
    const double py = y - from[1][i];
    const double pz = z - from[2][i];
    const double along = (px * ex + py * ey + pz * ez) / (ex * ex + ey * ey + ez * ez);
    const double t = along < 0.0 ? 0.0 : along > 1.0 ? 1.0 : along;
    const double rx = px - t * ex;
    const double ry = py - t * ey;
    const double rz = pz - t * ez;
    const double size = std::abs(px) + std::abs(py) + std::abs(pz);
    const double squared = rx * rx + ry * ry + rz * rz - kDistanceRoundoff * size * size;
    nearest[i] = squared < nearest[i] ? squared : nearest[i];
    const double side = (normal[1][i] * ez - normal[2][i] * ey) * px +
                        (normal[2][i] * ex - normal[0][i] * ez) * py +
                        (normal[0][i] * ey - normal[1][i] * ex) * pz;
    inside[i] = side >= 0.0 ? inside[i] : 0.0;
  }
}

// 1 in lanes whose plane the segment may cross or end close to; in close, those it ends close to.
PALPATE_SIMD_CLONES void cross_planes(const TrianglePack& pack, double x, double y, double z,
                                      double dx, double dy, double dz, double clearance,
                                      Lanes& crossing, Lanes& close) {
  const double step = std::abs(dx) + std::abs(dy) + std::abs(dz);
  for (int i = 0; i < kLanes; ++i) {
    const double px = x - pack.a[0][i];
    const double py = y - pack.a[1][i];
    const double pz = z - pack.a[2][i];
    const double start = pack.normal[0][i] * px + pack.normal[1][i] * py + pack.normal[2][i] * pz;
    const double end =
        start + (pack.normal[0][i] * dx + pack.normal[1][i] * dy + pack.normal[2][i] * dz);
    const double bound = kHeightRoundoff * (std::abs(px) + std::abs(py) + std::abs(pz) + step);
    const double end_bound = bound > clearance ? bound : clearance;
    // Apart: start and end on one side, each farther than its bound.
    const double above = (start > bound ? 1.0 : 0.0) * (end > end_bound ? 1.0 : 0.0);
    const double below = (start < -bound ? 1.0 : 0.0) * (end < -end_bound ? 1.0 : 0.0);
    crossing[i] = 1.0 - above - below;
    close[i] = std::abs(end) <= end_bound ? 1.0 : 0.0;
  }
}

// Adds 1 to left or right where the segment's line certainly passes that side of the edge.
PALPATE_SIMD_CLONES void side_of_edge(const double (&from)[3][kLanes],
                                      const double (&to)[3][kLanes], double x, double y, double z,
                                      double dx, double dy, double dz, Lanes& left, Lanes& right) {
  const double step = std::abs(dx) + std::abs(dy) + std::abs(dz);
  for (int i = 0; i < kLanes; ++i) {
    const double vx = from[0][i] - x;
    const double vy = from[1][i] - y;
    const double vz = from[2][i] - z;
    const double wx = to[0][i] - x;
    const double wy = to[1][i] - y;
    const double wz = to[2][i] - z;
    const double volume =
        dx * (vy * wz - vz * wy) + dy * (vz * wx - vx * wz) + dz * (vx * wy - vy * wx);
    const double bound = kTripleRoundoff * step * (std::abs(vx) + std::abs(vy) + std::abs(vz)) *
                         (std::abs(wx) + std::abs(wy) + std::abs(wz));
    left[i] += volume > bound ? 1.0 : 0.0;
    right[i] += volume < -bound ? 1.0 : 0.0;
  }
}

}  // namespace

unsigned lanes_within(const TrianglePack& pack, const Vec3& p, double distance_m) noexcept {
  Lanes nearest;
  Lanes inside;
  std::fill(std::begin(nearest), std::end(nearest), HUGE_VAL);
  std::fill(std::begin(inside), std::end(inside), 1.0);
  fold_edge(pack.a, pack.b, pack.normal, p.x(), p.y(), p.z(), nearest, inside);
  fold_edge(pack.b, pack.c, pack.normal, p.x(), p.y(), p.z(), nearest, inside);
  fold_edge(pack.c, pack.a, pack.normal, p.x(), p.y(), p.z(), nearest, inside);
  Lanes kept;
  for (int i = 0; i < kLanes; ++i) {
    const double px = p.x() - pack.a[0][i];
    const double py = p.y() - pack.a[1][i];
    const double pz = p.z() - pack.a[2][i];
    const double height = pack.normal[0][i] * px + pack.normal[1][i] * py + pack.normal[2][i] * pz;
    const double bound = kHeightRoundoff * (std::abs(px) + std::abs(py) + std::abs(pz));
    // Over the face the height counts; elsewhere the edges, which are never nearer than it.
    const bool by_height = std::abs(height) - bound <= distance_m;
    const bool by_edge = nearest[i] <= distance_m * distance_m;
    kept[i] = by_height && (by_edge || inside[i] != 0.0) ? 1.0 : 0.0;
  }
  return bits_of(kept) & valid_lanes(pack);
}

unsigned lanes_in_the_way(const TrianglePack& pack, const Vec3& p, const Vec3& d,
                          double clearance_m) noexcept {
  Lanes crossing;
  Lanes close;
  cross_planes(pack, p.x(), p.y(), p.z(), d.x(), d.y(), d.z(), clearance_m, crossing, close);
  const unsigned lanes = bits_of(crossing) & valid_lanes(pack);
  if (lanes == 0) return 0;
  Lanes left{};
  Lanes right{};
  side_of_edge(pack.a, pack.b, p.x(), p.y(), p.z(), d.x(), d.y(), d.z(), left, right);
  side_of_edge(pack.b, pack.c, p.x(), p.y(), p.z(), d.x(), d.y(), d.z(), left, right);
  side_of_edge(pack.c, pack.a, p.x(), p.y(), p.z(), d.x(), d.y(), d.z(), left, right);
  return lanes & ((~bits_of(left) | ~bits_of(right)) | bits_of(close));
}

}  // namespace palpate
