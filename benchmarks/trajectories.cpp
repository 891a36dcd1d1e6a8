#include "benchmarks/trajectories.h"

#include <cassert>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace palpate::bench {
namespace {

// A circle of constant curvature would close after some seconds; a weaving line does not.
constexpr double kWeavePeriod_s = 3.7;
constexpr double kWeave_rad_per_s = 0.8;

constexpr std::uint64_t kCentreSeed = 1;
constexpr std::uint64_t kTeleportSeed = 2;

// Uniform in [low, high), made from the engine's bits so that every platform agrees.
double uniform(std::mt19937_64& engine, double low, double high) {
  return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
}

// Uniform over the unit ball.
Vec3 in_unit_ball(std::mt19937_64& engine) {
  for (;;) {
    const double x = uniform(engine, -1.0, 1.0);
    const double y = uniform(engine, -1.0, 1.0);
    const Vec3 p(x, y, uniform(engine, -1.0, 1.0));
    if (p.squaredNorm() < 1.0) return p;
  }
}

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

// Away from the icosphere's planes of symmetry, where edges would be met end on.
Vec3 start_direction() {
  return Vec3(1.0, 2.0, 3.0).normalized();
}

}  // namespace

std::vector<Vec3> path_over_sphere(double radius_m, const HeightSwing& swing,
                                   std::size_t sample_count) {
  assert(std::numbers::pi * (swing.high_m - swing.low_m) < kSpeed_m_per_s * swing.period_s);
  Vec3 up = start_direction();
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

DevicePath entered_path_over_sphere(double radius_m, const HeightSwing& swing,
                                    std::size_t sample_count) {
  // From a millimetre outside, and at about the path's own speed.
  constexpr double kEntryHeight_m = 1e-3;
  constexpr int kEntryTicks = 11;
  DevicePath path{{}, path_over_sphere(radius_m, swing, sample_count)};
  const Vec3& first = path.timed_m.front();
  const Vec3 entry = (radius_m + kEntryHeight_m) * first.normalized();
  for (int i = 0; i < kEntryTicks; ++i) {
    path.lead_in_m.emplace_back(entry + static_cast<double>(i) / kEntryTicks * (first - entry));
  }
  return path;
}

std::vector<Vec3> path_to_centre(double radius_m) {
  std::vector<Vec3> path_m;
  const auto steps = static_cast<int>(radius_m / kStep_m);
  for (int i = -1; i < steps; ++i) path_m.push_back((radius_m - i * kStep_m) * start_direction());
  return path_m;
}

std::vector<Vec3> path_about_centre(double farthest_m, std::size_t sample_count) {
  constexpr double kLeast_m = 1e-9;
  std::mt19937_64 engine(kCentreSeed);
  std::vector<Vec3> path_m(sample_count, Vec3::Zero());
  for (std::size_t n = 1; n < sample_count; ++n) {
    const double distance_m = kLeast_m * std::pow(farthest_m / kLeast_m, uniform(engine, 0.0, 1.0));
    path_m[n] = distance_m * in_unit_ball(engine).normalized();
  }
  return path_m;
}

std::vector<Vec3> random_teleports(double ball_radius_m, double longest_m,
                                   std::size_t sample_count) {
  std::mt19937_64 engine(kTeleportSeed);
  std::vector<Vec3> path_m;
  path_m.reserve(sample_count);
  while (path_m.size() < sample_count) {
    const Vec3 next_m = ball_radius_m * in_unit_ball(engine);
    if (path_m.empty() || (next_m - path_m.back()).norm() <= longest_m) path_m.push_back(next_m);
  }
  return path_m;
}

}  // namespace palpate::bench
