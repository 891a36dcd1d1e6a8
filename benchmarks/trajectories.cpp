#include "benchmarks/trajectories.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace palpate::bench {
namespace {

// A circle of constant curvature would close after some seconds; a weaving line does not.
constexpr double kWeavePeriod_s = 3.7;
constexpr double kWeave_rad_per_s = 0.8;

double height_m(const HeightSwing& swing, double time_s) {
  const double phase = 2.0 * std::numbers::pi * time_s / swing.period_s;
  return 0.5 * (swing.high_m + swing.low_m) + 0.5 * (swing.high_m - swing.low_m) * std::cos(phase);
}

// Turns the orthonormal pair by an angle from u towards v.
void turn(Vec3& u, Vec3& v, double angle_rad) {
  const Vec3 turned = std::cos(angle_rad) * u + std::sin(angle_rad) * v;
  v = (std::cos(angle_rad) * v - std::sin(angle_rad) * u).normalized();
  u = turned.normalized();
}

}  // namespace

std::vector<Vec3> path_over_sphere(double radius_m, const HeightSwing& swing,
                                   std::size_t sample_count) {
  constexpr double kDt_s = 1.0 / kSampleRateHz;
  constexpr double kStep_m = kSpeed_m_per_s * kDt_s;
  assert(std::numbers::pi * (swing.high_m - swing.low_m) < kSpeed_m_per_s * swing.period_s);
  // A start away from the icosphere's planes of symmetry, where edges would be met end on.
  Vec3 up = Vec3(1.0, 2.0, 3.0).normalized();
  Vec3 ahead = up.unitOrthogonal();
  std::vector<Vec3> path_m;
  path_m.reserve(sample_count);
  for (std::size_t n = 0; n < sample_count; ++n) {
    const double time_s = static_cast<double>(n) * kDt_s;
    const double height = height_m(swing, time_s);
    path_m.push_back((radius_m + height) * up);
    const double climb = height_m(swing, time_s + kDt_s) - height;
    const double along = std::sqrt(kStep_m * kStep_m - climb * climb);
    turn(up, ahead, along / (radius_m + height));
    Vec3 left = up.cross(ahead);
    const double weave = std::sin(2.0 * std::numbers::pi * time_s / kWeavePeriod_s);
    turn(ahead, left, kWeave_rad_per_s * kDt_s * weave);
  }
  return path_m;
}

}  // namespace palpate::bench
