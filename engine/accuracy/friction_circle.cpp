#include "engine/accuracy/friction_circle.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "engine/accuracy/posed_sheet.h"
#include "engine/accuracy/session_pass.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr double kTurns = 0.5;  // to settle, and as many to measure

// A point above the continuous circle, the point below it in the plane, then the circle of the
// device.
std::vector<Vec3> path_m(const FrictionCircle& circle, const PosedSheet& sheet, double step_s,
                         double start_rad) {
  const double step_rad = 2.0 * std::numbers::pi * circle.turns_per_s * step_s;
  const double ahead_rad = std::atan2(circle.lag_m(), circle.continuous_radius_m());
  const auto at = [&](double radius_m, double angle_rad, double height_m) {
    return sheet.T_scene_sheet.point(
        {radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad), height_m});
  };
  std::vector<Vec3> points_m{at(circle.continuous_radius_m(), start_rad, circle.depth_m),
                             at(circle.continuous_radius_m(), start_rad, -circle.depth_m)};
  const auto steps = static_cast<int>(std::ceil(4.0 * std::numbers::pi * kTurns / step_rad));
  for (int n = 1; n <= steps; ++n) {
    points_m.push_back(at(circle.radius_m, start_rad + ahead_rad + n * step_rad, -circle.depth_m));
  }
  return points_m;
}

}  // namespace

double FrictionCircle::continuous_radius_m() const {
  return std::sqrt(radius_m * radius_m - lag_m() * lag_m());
}

double FrictionCircle::discrete_radius_m(double step_s) const {
  const double step_rad = 2.0 * std::numbers::pi * turns_per_s * step_s;
  const double behind_m = lag_m() * std::sin(0.5 * step_rad);
  return std::hypot(continuous_radius_m(), behind_m) - behind_m;
}

Sample go_round(const FrictionCircle& circle, double step_s, const Accuracy& accuracy,
                std::uint64_t seed) {
  SeededRandom random(seed);
  const Result<PosedSheet> sheet = posed_sheet(random, circle.friction);
  if (!sheet) return {.failure = sheet.error().to_string()};
  const std::vector<Vec3> points_m =
      path_m(circle, *sheet, step_s, random.uniform(-std::numbers::pi, std::numbers::pi));
  double sum_m = 0.0;
  const OnContact add_radius = [&](const TickRecord& record) {
    const Vec3 proxy_m = sheet->T_scene_sheet.inverse_point(vec3(record.proxy_scene_m));
    sum_m += std::hypot(proxy_m.x(), proxy_m.y());
  };
  const PassCost cost =
      run_path(sheet->scene.world(), PassSetup::fully_actuated(circle.coupling, {0.0, accuracy}),
               points_m, step_s, points_m.size() / 2, add_radius);
  const double radius_m = sum_m / static_cast<double>(cost.ticks);
  return {std::abs(radius_m - circle.continuous_radius_m()), cost.us_per_s(step_s), cost.iterations,
          cost.ticks, failure_of(cost.faults)};
}

}  // namespace palpate
