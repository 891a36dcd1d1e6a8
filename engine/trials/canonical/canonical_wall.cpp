#include "engine/trials/canonical/canonical_wall.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "models/primitives.h"

namespace palpate {

Result<Scene> canonical_wall(double proxy_radius_m) {
  TriangleMesh plate = box({kWallThickness_m, 2.0 * kWallHalfLength_m, kWallHeight_m});
  // The corners of box() are floats, and half of the thickness is not one.
  double front_m = 0.0;
  for (const Vec3& corner : plate.positions_m) front_m = std::max(front_m, corner.x());
  SceneDescription description;
  description.meshes.push_back({"wall", std::move(plate.positions_m), std::move(plate.triangles)});
  description.nodes.emplace_back();
  description.nodes.back().name = "wall";
  description.nodes.back().translation_m = {-front_m, 0.0, 0.0};
  description.tree.resize(1);
  SceneSettings settings;
  settings.proxy_radius_m = proxy_radius_m;
  return Scene::compile(std::move(description), settings);
}

ScenePose canonical_pose(const ActuationModel& actuation, double angle_deg) {
  const Vec3& motor = actuation.actuated_axis(0);
  const double motor_rad = std::atan2(motor.y(), motor.x());
  const double angle_rad = angle_deg * std::numbers::pi / 180.0;
  return {Quat(Eigen::AngleAxisd(motor_rad + angle_rad, Vec3::UnitZ())), Vec3::Zero()};
}

RunSetup canonical_setup(const RunSetup& device, double angle_deg, bool rotates) {
  RunSetup setup = device;
  setup.haptics.force = ForceMode::kActuated;
  setup.haptics.a4.enabled = rotates;
  setup.haptics.strategy.reset();
  setup.haptics.initial_pose = canonical_pose(device.actuation, angle_deg);
  return setup;
}

}  // namespace palpate
