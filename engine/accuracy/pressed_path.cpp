#include "engine/accuracy/pressed_path.h"

#include <cmath>
#include <numbers>

namespace palpate {
namespace {

constexpr double kSwing_s = 0.5;
constexpr double kWaver_s = 1.7;          // no multiple of the swing
constexpr double kWaver_rad_per_s = 1.5;  // a circle would close
constexpr double kStart_m = 1e-3;         // outside
constexpr std::size_t kLeadInTicks = 20;

// T_n(x) of Chebyshev and its derivative: cos(n acos x).
struct Chebyshev {
  double value;
  double slope;
};
Chebyshev chebyshev(int degree, double x) {
  double before = 1.0, now = x, slope_before = 0.0, slope = 1.0;
  if (degree == 0) return {1.0, 0.0};
  for (int n = 1; n < degree; ++n) {
    const double next = 2.0 * x * now - before;
    const double next_slope = 2.0 * now + 2.0 * x * slope - slope_before;
    before = now;
    now = next;
    slope_before = slope;
    slope = next_slope;
  }
  return {now, slope};
}

}  // namespace

SmoothSurface smooth_sphere(double radius_m) {
  return [radius_m](const Vec3& near_m) {
    const Vec3 normal = near_m.normalized();
    return SmoothPoint{radius_m * normal, normal};
  };
}

SmoothSurface smooth_torus(double major_radius_m, double minor_radius_m) {
  return [=](const Vec3& near_m) {
    const Vec3 ring_m = major_radius_m * Vec3(near_m.x(), near_m.y(), 0.0).normalized();
    const Vec3 normal = (near_m - ring_m).normalized();
    return SmoothPoint{ring_m + minor_radius_m * normal, normal};
  };
}

// |p| = R + h T(x) T(y) T(z), (x, y, z) = p / |p|. The normal is the gradient of |p| minus the
// right side: u - (I - u u^T) grad(h T T T) / |p|.
SmoothSurface smooth_bumpy_sphere(double radius_m, double bump_height_m, int waves) {
  return [=](const Vec3& near_m) {
    const Vec3 u = near_m.normalized();
    const Chebyshev x = chebyshev(waves, u.x());
    const Chebyshev y = chebyshev(waves, u.y());
    const Chebyshev z = chebyshev(waves, u.z());
    const double distance_m = radius_m + bump_height_m * x.value * y.value * z.value;
    const Vec3 gradient =
        bump_height_m *
        Vec3(x.slope * y.value * z.value, x.value * y.slope * z.value, x.value * y.value * z.slope);
    const Vec3 along = gradient - gradient.dot(u) * u;
    return SmoothPoint{distance_m * u, (u - along / distance_m).normalized()};
  };
}

PressedPath pressed_path(const SmoothSurface& surface, double extent_m,
                         const PressSettings& settings, SeededRandom& random) {
  SmoothPoint at = surface(random.in_box(0.5 * extent_m));
  Vec3 ahead = at.normal.cross(random.unit_vector()).normalized();
  const double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
  const auto depth_m = [&](double time_s) {
    const double swing = std::cos(phase + 2.0 * std::numbers::pi * time_s / kSwing_s);
    return 0.5 * (settings.least_depth_m + settings.most_depth_m) +
           0.5 * (settings.most_depth_m - settings.least_depth_m) * swing;
  };
  const auto place = [&](double depth) {
    return Vec3(at.point_m + (settings.proxy_radius_m - depth) * at.normal);
  };
  PressedPath path;
  path.lead_in = kLeadInTicks;
  path.device_m.reserve(kLeadInTicks + settings.ticks);
  for (std::size_t n = 0; n < kLeadInTicks; ++n) {
    const double share = static_cast<double>(n) / static_cast<double>(kLeadInTicks);
    path.device_m.push_back(place((1.0 - share) * -kStart_m + share * depth_m(0.0)));
  }
  for (std::size_t n = 0; n < settings.ticks; ++n) {
    const double time_s = static_cast<double>(n) * settings.period_s;
    path.device_m.push_back(place(depth_m(time_s)));
    at = surface(at.point_m + settings.speed_m_per_s * settings.period_s * ahead);
    const double turn_rad = kWaver_rad_per_s * settings.period_s *
                            std::sin(phase + 2.0 * std::numbers::pi * time_s / kWaver_s);
    ahead += turn_rad * at.normal.cross(ahead);
    ahead = (ahead - ahead.dot(at.normal) * at.normal).normalized();
  }
  return path;
}

}  // namespace palpate
