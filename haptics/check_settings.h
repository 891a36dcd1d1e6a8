#pragma once

// Which settings a haptic loop accepts, told before it is made.

#include <optional>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "haptics/proxy/check_god_object_settings.h"

namespace palpate {

struct ContactWorld;
struct HapticSettings;

// As check_settings() of a god-object, whose fields have "god_object." before their names. In range
// are, besides:
//
//   coupling.stiffness_N_per_m, coupling.damping_Ns_per_m
//                         finite, >= 0, and K l and B l / t no more than half of kLargestForce_N
//                         each, l the largest lag that a good sample can give (largest_lag_m) and t
//                         the shortest tick of which the damper's speed counts (kShortestTick_s)
//   a4.profile            three finite numbers, > 0
//   plane_height_m        finite
//   initial_pose          finite, its quaternion of length 1 (is_pose), and no farther from the
//                         device's origin than farthest_place_m(): a device's positions have 53
//                         bits, of which the distance takes the first
//
// A loop that is made in spite of an error gives kFaultBadSettings and zero force in each tick.
std::optional<Error> check_settings(const ContactWorld& world, const HapticSettings& settings);

// A sample so many times farther away than anything in the scene has lost the scene's digits: half
// of those that double has.
inline constexpr double kFarthestSamplePerSize = 0x1p26;

// The size of a world and how far it is from the scene's origin. m.
double world_extent_m(const ContactWorld& world) noexcept;

// The farthest from the device's origin that a scene can be placed: there a position that the
// device reads is rounded by 2^-53 of the distance, which is 2^-27 of the scene's size. m.
double farthest_place_m(const ContactWorld& world) noexcept;

// The farthest from the device's origin that a sample counts. m.
inline double farthest_sample_m(double world_extent_m,
                                const RigidTransform& T_device_scene) noexcept {
  return kFarthestSamplePerSize * (world_extent_m + T_device_scene.translation_m.norm());
}

// The largest lag that samples can give which count. The goal is within farthest_sample_m() of the
// device's origin and the scene's middle within a 2^26th of that, so the goal is less than twice as
// far from the middle. The proxy is where a goal was, or touches a surface: another twice. (A4
// moves the scene by less than that, and kLargestForce_N leaves half of the exponents.) m.
double largest_lag_m(const ContactWorld& world, const RigidTransform& T_device_scene) noexcept;

// Half of the exponents of double: sums and squares of such forces are finite. N.
inline constexpr double kLargestForce_N = 0x1p511;

// A thousandth of the tick of a servo at 1 MHz. A damper can still overflow in ticks that are
// shorter: those have kFaultNonFiniteForce. s.
inline constexpr double kShortestTick_s = 1e-9;

}  // namespace palpate
