#include "benchmarks/trajectories.h"

#include <cmath>
#include <cstdint>

#include "geometry/base/random.h"

namespace palpate::bench {
namespace {

constexpr std::uint64_t kCentreSeed = 1;
constexpr std::uint64_t kTeleportSeed = 2;

// Uniformly distributed over the unit ball.
Vec3 in_unit_ball(SeededRandom& random) {
  for (;;) {
    const Vec3 p = random.in_box(1.0);
    if (p.squaredNorm() < 1.0) return p;
  }
}

}  // namespace

std::vector<Vec3> path_to_centre(double radius_m) {
  std::vector<Vec3> path_m;
  const auto steps = static_cast<int>(radius_m / kStep_m);
  for (int i = -1; i < steps; ++i) path_m.push_back((radius_m - i * kStep_m) * sphere_path_start());
  return path_m;
}

std::vector<Vec3> path_about_centre(double farthest_m, std::size_t sample_count) {
  constexpr double kLeast_m = 1e-9;
  SeededRandom random(kCentreSeed);
  std::vector<Vec3> path_m(sample_count, Vec3::Zero());
  for (std::size_t n = 1; n < sample_count; ++n) {
    const double distance_m = kLeast_m * std::pow(farthest_m / kLeast_m, random.uniform(0.0, 1.0));
    path_m[n] = distance_m * in_unit_ball(random).normalized();
  }
  return path_m;
}

std::vector<Vec3> random_teleports(double ball_radius_m, double longest_m,
                                   std::size_t sample_count) {
  SeededRandom random(kTeleportSeed);
  std::vector<Vec3> path_m;
  path_m.reserve(sample_count);
  while (path_m.size() < sample_count) {
    const Vec3 next_m = ball_radius_m * in_unit_ball(random);
    if (path_m.empty() || (next_m - path_m.back()).norm() <= longest_m) path_m.push_back(next_m);
  }
  return path_m;
}

}  // namespace palpate::bench
