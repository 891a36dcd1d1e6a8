#include "engine/accuracy/sphere_paths.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace palpate {
namespace {

// A line of constant curvature would close after some seconds; a weaving line does not.
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

Vec3 sphere_path_start() {
  return Vec3(1.0, 2.0, 3.0).normalized();
}

std::vector<Vec3> path_over_sphere(double radius_m, const HeightSwing& swing,
                                   std::size_t sample_count) {
  assert(std::numbers::pi * (swing.high_m - swing.low_m) <
         kSpherePathSpeed_m_per_s * swing.period_s);
  Vec3 up = sphere_path_start();
  Vec3 ahead = up.unitOrthogonal();
  std::vector<Vec3> path_m;
  path_m.reserve(sample_count);
  for (std::size_t n = 0; n < sample_count; ++n) {
    const double time_s = static_cast<double>(n) * kSpherePathPeriod_s;
    const double height = height_m(swing, time_s);
    path_m.push_back((radius_m + height) * up);
    const double climb = height_m(swing, time_s + kSpherePathPeriod_s) - height;
    const double along = std::sqrt(kSpherePathStep_m * kSpherePathStep_m - climb * climb);
    turn(up, ahead, along / (radius_m + height));
    Vec3 left = up.cross(ahead);
    const double weave = std::sin(2.0 * std::numbers::pi * time_s / kWeavePeriod_s);
    turn(ahead, left, kWeave_rad_per_s * kSpherePathPeriod_s * weave);
  }
  return path_m;
}

DevicePath entered_path_over_sphere(double radius_m, const HeightSwing& swing,
                                    std::size_t sample_count) {
  // From a millimetre outside, at about the speed of the path.
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

}  // namespace palpate
