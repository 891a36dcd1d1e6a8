#pragma once

// The wall of the canonical protocol: a frictionless plate, placed so that its normal is at a given
// angle to the only motor (Barbagli and Salisbury, Haptics 2003).

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"
#include "haptics/a4/scene_pose.h"

namespace palpate {

// The plate, in the scene frame: its front face lies in the plane x = 0 and faces +x; y runs along
// the wall, and z is A3. The face reaches from -kWallHalfLength_m to kWallHalfLength_m along y.
inline constexpr double kWallHalfLength_m = 0.15;
inline constexpr double kWallThickness_m = 0.02;
inline constexpr double kWallHeight_m = 0.04;

// Compiles the plate. proxy_radius_m: SceneSettings::proxy_radius_m.
Result<Scene> canonical_wall(double proxy_radius_m);

// T_device_scene that puts the middle of the front face at the origin of the device frame, and
// turns its normal by angle_deg about A3 from the motor's axis. actuation: 2 sensors and 1 motor.
ScenePose canonical_pose(const ActuationModel& actuation, double angle_deg);

// The setup of a trial: the device's, with the force along its motor only, and the wall in its
// pose. rotates: with A4.
RunSetup canonical_setup(const RunSetup& device, double angle_deg, bool rotates);

}  // namespace palpate
