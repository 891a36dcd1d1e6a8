#pragma once

// Checks the settings of a haptic loop.

#include <optional>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "haptics/proxy/check_god_object_settings.h"

namespace palpate {

struct ContactWorld;
struct HapticSettings;

// Returns an Error for the first setting out of range. The god-object's settings are checked first,
// by their own check_settings(); their fields have the prefix "god_object.". The other ranges are:
//
//   coupling.stiffness_N_per_m, coupling.damping_Ns_per_m
//                         finite, >= 0; K l and B l / t are each at most half of kLargestForce_N,
//                         where l is the largest lag that good samples can give (largest_lag_m) and
//                         t the shortest tick for which the damper is bounded (kShortestTick_s)
//   a4.profile            three finite numbers, > 0
//   plane_height_m        finite
//   strategy              empty, or as set_strategy() sets it with force and a4; `anisotropic`
//                         needs a point, and a world without effects other than stiffness and
//                         damping
//   anticipation          with a strategy: finite numbers, range_m > 0, the other >= 0
//   initial_pose          finite, with a quaternion of length 1 (is_pose), and at most
//                         farthest_place_m() from the device's origin: a device's positions have 53
//                         bits, and a large distance leaves fewer of them for the scene
//
// HapticLoop::create() returns this Error.
std::optional<Error> check_settings(const ContactWorld& world, const HapticSettings& settings);

// The largest distance of a good sample, in extents of the world. At this distance, half of the
// bits of a double are left to resolve the scene.
inline constexpr double kFarthestSamplePerSize = 0x1p26;

// The size of a world plus the distance of its middle from the scene's origin, in metres.
double world_extent_m(const ContactWorld& world) noexcept;

// The largest distance from the device's origin at which a scene can be placed. There, a sensed
// position is rounded by 2^-53 of the distance; this rounding is 2^-27 of the world's extent. In
// metres.
double farthest_place_m(const ContactWorld& world) noexcept;

// The largest distance of a good sample from the device's origin, in metres.
inline double farthest_sample_m(double world_extent_m,
                                const RigidTransform& T_device_scene) noexcept {
  return kFarthestSamplePerSize * (world_extent_m + T_device_scene.translation_m.norm());
}

// The largest lag that good samples can give. The goal is within farthest_sample_m() of the
// device's origin, and the scene's middle is at most 2^-26 times that distance from the same
// origin; therefore, the goal is less than two such distances from the middle. The proxy is at an
// earlier goal or touches a surface; therefore, it is also less than two such distances from the
// middle. The lag is less than the sum, four such distances. (A4 moves the scene by less than this,
// and kLargestForce_N leaves half of the exponents in reserve.) In metres.
double largest_lag_m(const ContactWorld& world, const RigidTransform& T_device_scene) noexcept;

// The limit of the coupling's force under valid settings. It uses half of the exponent range of
// double, so that sums and squares of such forces are finite. In newtons.
inline constexpr double kLargestForce_N = 0x1p511;

// The shortest tick for which the damper's force is bounded: a thousandth of the tick of a servo at
// 1 MHz. In a shorter tick the damper can still overflow; the tick then reports
// kFaultNonFiniteForce. In seconds.
inline constexpr double kShortestTick_s = 1e-9;

}  // namespace palpate
