#include "haptics/check_settings.h"

#include <cmath>

#include "haptics/haptic_loop.h"
#include "haptics/proxy/setting_errors.h"

namespace palpate {
namespace {

std::optional<Error> check_pose(const ContactWorld& world, const RigidTransform& T_device_scene) {
  if (!is_pose(T_device_scene)) {
    return invalid_argument("initial_pose",
                            "is not a rigid pose; expected finite numbers and a unit quaternion");
  }
  const double away_m = T_device_scene.translation_m.stableNorm();
  const double most_m = farthest_place_m(world);
  if (away_m <= most_m) return std::nullopt;
  return invalid_argument("initial_pose",
                          "is " + digits_of(away_m) +
                              " m from the device's origin; expected at most " + digits_of(most_m) +
                              " m, where positions keep half of their digits for the scene",
                          "place the scene nearer to the device's origin");
}

std::optional<Error> check_coupling(const ContactWorld& world, const HapticSettings& settings) {
  const CouplingSettings& coupling = settings.coupling;
  const double lag_m = largest_lag_m(world, settings.initial_pose);
  const auto check = [](const char* field, double value, double most) -> std::optional<Error> {
    if (auto error = check_number(field, value, true)) return error;
    if (value <= most) return std::nullopt;
    return invalid_argument(field, "is " + digits_of(value) + "; expected at most " +
                                       digits_of(most) + ", so that no force overflows");
  };
  if (auto error = check("coupling.stiffness_N_per_m", coupling.stiffness_N_per_m,
                         0.5 * kLargestForce_N / lag_m)) {
    return error;
  }
  return check("coupling.damping_Ns_per_m", coupling.damping_Ns_per_m,
               0.5 * kLargestForce_N / lag_m * kShortestTick_s);
}

std::optional<Error> check_strategy(const ContactWorld& world, const HapticSettings& settings) {
  if (!settings.strategy) return std::nullopt;
  const StrategyType& type = *settings.strategy->type;
  HapticSettings expected = settings;
  set_strategy(*settings.strategy, expected);
  if (!expected.strategy || expected.force != settings.force ||
      expected.a4.enabled != settings.a4.enabled) {
    return invalid_argument(
        "strategy", "is " + name_of(*settings.strategy) + ", which contradicts the force or A4",
        "set the three with set_strategy()");
  }
  if (auto error = check_number("anticipation.range_m", settings.anticipation.range_m, false)) {
    return error;
  }
  if (auto error = check_number("anticipation.least_approach_m_per_s",
                                settings.anticipation.least_approach_m_per_s, true)) {
    return error;
  }
  if (type.parameter && !type.parameter->allows(settings.strategy->parameter)) {
    return invalid_argument("strategy", "is " + name_of(*settings.strategy) +
                                            "; expected a number from " +
                                            digits_of(type.parameter->least) + " to " +
                                            digits_of(type.parameter->most));
  }
  return type.check ? type.check(world, settings) : std::nullopt;
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
  if (auto error = check_strategy(world, settings)) return error;
  if (!std::isfinite(settings.plane_height_m)) {
    return invalid_argument("plane_height_m", "is " + digits_of(settings.plane_height_m) +
                                                  "; expected a finite number");
  }
  return std::nullopt;
}

}  // namespace palpate
