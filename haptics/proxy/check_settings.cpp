#include "haptics/proxy/check_settings.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "haptics/haptic_loop.h"

namespace palpate {
namespace {

Error invalid(std::string field, std::string problem, std::string hint = "") {
  return {ErrorCode::kInvalidArgument, "", std::move(field), std::move(problem), std::move(hint)};
}

std::string text_of(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

std::optional<Error> check_number(const char* field, double value, bool zero_allowed) {
  if (std::isfinite(value) && (value > 0.0 || (zero_allowed && value == 0.0))) return std::nullopt;
  return invalid(field, text_of(value) + " given, expected a finite number " +
                            (zero_allowed ? ">= 0" : "> 0"));
}

// radius_m: finite, > 0. Neither too small to be told from a point, nor larger than indices allow.
std::optional<Error> check_sphere(const ContactWorld& world, double radius_m) {
  const double stand_off_m = SolverScale::of(world.size_m, radius_m).stand_off_m;
  if (radius_m < stand_off_m) {
    return invalid("radius_m",
                   text_of(radius_m) + " m given, expected 0 for a point, or at least the " +
                       text_of(stand_off_m) + " m that a proxy stays off what it touches");
  }
  const double sweep_m = radius_m + stand_off_m;
  double built_for_m = SurfaceIndex::kLargestSweep_m;
  if (world.tree) built_for_m = std::min(built_for_m, world.tree->sweep_radius_m());
  for (const ContactBody& body : world.bodies) {
    const double units_per_metre = body.reach_index(1.0, Vec3::Zero());
    built_for_m = std::min(built_for_m, body.index->sweep_radius_m() / units_per_metre);
  }
  if (sweep_m <= built_for_m) return std::nullopt;
  return invalid("radius_m",
                 text_of(radius_m) + " m given, with its stand-off " + text_of(sweep_m) +
                     " m; expected at most the " + text_of(built_for_m) +
                     " m that the scene's indices were built for",
                 "load the scene for this radius");
}

std::optional<Error> check_pose(const ContactWorld& world, const RigidTransform& T_device_scene) {
  if (!is_pose(T_device_scene)) {
    return invalid("initial_pose", "is no pose: expected finite numbers and a unit quaternion");
  }
  const double away_m = T_device_scene.translation_m.stableNorm();
  const double most_m = farthest_place_m(world);
  if (away_m <= most_m) return std::nullopt;
  return invalid("initial_pose",
                 text_of(away_m) + " m away given, expected at most " + text_of(most_m) +
                     " m, where positions keep half of their digits for the scene",
                 "place the scene nearer to the device's origin");
}

std::optional<Error> check_coupling(const ContactWorld& world, const HapticSettings& settings) {
  const CouplingSettings& coupling = settings.coupling;
  const double lag_m = largest_lag_m(world, settings.initial_pose);
  const auto check = [](const char* field, double value, double most) -> std::optional<Error> {
    if (auto error = check_number(field, value, true)) return error;
    if (value <= most) return std::nullopt;
    return invalid(field, text_of(value) + " given, expected at most " + text_of(most) +
                              ", so that no force overflows");
  };
  if (auto error = check("coupling.stiffness_N_per_m", coupling.stiffness_N_per_m,
                         0.5 * kLargestForce_N / lag_m)) {
    return error;
  }
  return check("coupling.damping_Ns_per_m", coupling.damping_Ns_per_m,
               0.5 * kLargestForce_N / lag_m * kShortestTick_s);
}

}  // namespace

double world_extent_m(const ContactWorld& world) noexcept {
  return world.size_m + world.anchor_scene_m.norm();
}

double farthest_place_m(const ContactWorld& world) noexcept {
  return kFarthestSamplePerSize * world_extent_m(world);
}

double largest_lag_m(const ContactWorld& world, const RigidTransform& T_device_scene) noexcept {
  return 4.0 * farthest_sample_m(world_extent_m(world), T_device_scene);
}

std::optional<Error> check_settings(const ContactWorld& world, const GodObjectSettings& settings) {
  if (auto error = check_number("radius_m", settings.radius_m, true)) return error;
  if (settings.radius_m > 0.0) {
    if (auto error = check_sphere(world, settings.radius_m)) return error;
  }
  const Accuracy& accuracy = settings.accuracy;
  if (accuracy.iterations < 1 || accuracy.iterations > Accuracy::kMostIterations) {
    return invalid("accuracy.iterations", std::to_string(accuracy.iterations) +
                                              " given, expected 1 to " +
                                              std::to_string(Accuracy::kMostIterations));
  }
  if (accuracy.work_budget < 1) {
    return invalid("accuracy.work_budget",
                   std::to_string(accuracy.work_budget) + " given, expected at least 1");
  }
  return check_number("accuracy.tolerance", accuracy.tolerance, false);
}

std::optional<Error> check_settings(const ContactWorld& world, const HapticSettings& settings) {
  if (auto error = check_settings(world, settings.god_object)) {
    error->element = "god_object." + error->element;
    return error;
  }
  if (auto error = check_pose(world, settings.initial_pose)) return error;
  if (auto error = check_coupling(world, settings)) return error;
  for (const double part :
       {settings.a4.profile.speed_at_zero_rad_per_s, settings.a4.profile.speed_at_knee_rad_per_s,
        settings.a4.profile.knee_rad}) {
    if (auto error = check_number("a4.profile", part, false)) return error;
  }
  if (!std::isfinite(settings.plane_height_m)) {
    return invalid("plane_height_m",
                   text_of(settings.plane_height_m) + " given, expected a finite number");
  }
  return std::nullopt;
}

}  // namespace palpate
