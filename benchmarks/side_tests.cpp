#include "benchmarks/side_tests.h"

#include <cmath>

#include "geometry/exact/orientation.h"

namespace palpate::bench {
namespace {

double norm1(double x, double y, double z) {
  return std::abs(x) + std::abs(y) + std::abs(z);
}

// The filter: 1, -1, or 0 if undecided. Written with scalars: with Eigen's vectors it takes three
// times as long, because GCC stores their components in pairs and loads them one by one.
int filtered_side(const SideInput& in) {
  const double ux = in.d.x();
  const double uy = in.d.y();
  const double uz = in.d.z();
  const double vx = in.from.x() - in.p.x();
  const double vy = in.from.y() - in.p.y();
  const double vz = in.from.z() - in.p.z();
  const double wx = in.to.x() - in.p.x();
  const double wy = in.to.y() - in.p.y();
  const double wz = in.to.z() - in.p.z();
  const double volume =
      ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx);
  const double bound = kTripleRoundoff * norm1(ux, uy, uz) * norm1(vx, vy, vz) * norm1(wx, wy, wz);
  return volume > bound ? 1 : volume < -bound ? -1 : 0;
}

__extension__ using Wide = __float128;

int wide_side(const SideInput& in) {
  Wide u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) {
    u[k] = in.d[k];
    v[k] = static_cast<Wide>(in.from[k]) - in.p[k];
    w[k] = static_cast<Wide>(in.to[k]) - in.p[k];
  }
  const Wide terms[6] = {u[0] * v[1] * w[2],  u[1] * v[2] * w[0],  u[2] * v[0] * w[1],
                         -u[0] * v[2] * w[1], -u[1] * v[0] * w[2], -u[2] * v[1] * w[0]};
  Wide sum = 0;
  Wide magnitude = 0;
  for (const Wide& term : terms) {
    sum += term;
    magnitude += term < 0 ? -term : term;
  }
  const Wide bound = magnitude * static_cast<Wide>(12 * 0x1p-113);
  return sum > bound ? 1 : sum < -bound ? -1 : 0;
}

}  // namespace

bool filter_decides(const SideInput& input) {
  return filtered_side(input) != 0;
}

int side_float128(const SideInput& input) {
  const int side = filtered_side(input);
  return side != 0 ? side : wide_side(input);
}

int side_adaptive(const SideInput& input) {
  return orientation(input.p, input.p + input.d, input.from, input.to);
}

}  // namespace palpate::bench
