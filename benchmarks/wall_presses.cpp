#include "benchmarks/wall_presses.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>

#include "benchmarks/compiled_mesh.h"
#include "engine/devices/path_device.h"
#include "engine/rig/rig.h"
#include "engine/trials/strategy_measures.h"
#include "haptics/record_vectors.h"
#include "models/primitives.h"

namespace palpate::bench {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;
constexpr double kHand_N_per_m = 400.0;
constexpr double kWall_N_per_m = 1000.0;
constexpr double kAim_m = 10e-3;
constexpr double kPress_s = 3.0;
constexpr double kPauses_s[] = {0.5, 2.0};

// The walls are those of a regular prism, so that there is a wall at each contact angle, however
// the scene has turned. A turn by 85 deg moves the proxy by up to 15 mm along its wall, which is
// wide enough for it.
constexpr int kWalls = 72;
constexpr double kWall_deg = 360.0 / kWalls;
constexpr double kApothem_m = 0.5;
constexpr double kWay_m = kApothem_m + 20e-3;  // of a hand between two walls, from the middle
constexpr double kHeight_m = 0.04;

// 1 to 17 walls from the motor, each once, large and small angles in turn.
constexpr int kAngles = 17;
constexpr int kStride = 7;

Vec3 at_angle(double angle_deg) {
  return {std::cos(angle_deg * kRad), std::sin(angle_deg * kRad), 0.0};
}

Contour contour_of_walls() {
  Contour contour_m;
  for (int n = 0; n < kWalls; ++n) {
    const Vec3 corner_m =
        kApothem_m / std::cos(0.5 * kWall_deg * kRad) * at_angle((n - 0.5) * kWall_deg);
    contour_m.emplace_back(corner_m.x(), corner_m.y());
  }
  return contour_m;
}

Error fault(const std::string& element, const std::string& problem) {
  return {ErrorCode::kInvalidArgument, "", element, problem, ""};
}

class PressingHand {
 public:
  PressingHand(HapticLoop& loop, double dt_s) : loop_(loop), dt_s_(dt_s), measures_(dt_s) {
    tick();
    measures_.begin(record_);
  }

  // Presses a wall at this angle to the motor; returns the depth at which the hand rests. No value:
  // the hand was not on this wall alone.
  std::optional<double> press(double angle_deg) {
    go_to(angle_deg);
    Vec3 normal = at_angle(place_deg_);
    at_m_ += (kApothem_m - kWay_m) * normal;
    tick();
    const Vec3 wall = loop_.T_device_scene().inverse_direction(normal);
    double depth_m = 0.0;
    for (int n = 0; n < ticks_of(kPress_s); ++n) {
      const double force_N = vec3(record_.force_device_N).dot(normal);
      at_m_ -=
          (kHand_N_per_m * (kAim_m - depth_m) - force_N) / (kWall_N_per_m + kHand_N_per_m) * normal;
      tick();
      if (record_.contacts != 1) return std::nullopt;
      normal = pose_before(record_).direction(vec3(record_.normal_scene));
      depth_m = (vec3(record_.proxy_scene_m) - vec3(record_.goal_scene_m)).norm();
    }
    if ((vec3(record_.normal_scene) - wall).norm() > 0.1 * kWall_deg * kRad) return std::nullopt;
    return depth_m;
  }

  // Leaves the wall for this time, less the way to the next one.
  void pause(double pause_s) {
    const Vec3 normal = pose_before(record_).direction(vec3(record_.normal_scene));
    at_m_ += (kWay_m - kApothem_m + kAim_m) * normal;
    for (int n = 0; n < ticks_of(pause_s); ++n) tick();
  }

  double turning_energy_J() const {
    std::array<std::optional<double>, kMeasureCount> measures;
    measures_.put(measures);
    return measures[kTurningEnergy].value_or(0.0);
  }

 private:
  int ticks_of(double time_s) const { return static_cast<int>(std::lround(time_s / dt_s_)); }

  void tick() {
    record_ = loop_.tick(at_m_, dt_s_);
    measures_.add(record_);
  }

  // Goes round the prism, outside of it, to the middle of the wall at this angle to the motor. The
  // scene does not turn meanwhile.
  void go_to(double angle_deg) {
    const ScenePose pose = loop_.T_device_scene();
    const auto scene_deg = [&](const Vec3& p_m) { return std::atan2(p_m.y(), p_m.x()) / kRad; };
    const double goal_deg =
        kWall_deg * std::round(scene_deg(pose.inverse_direction(at_angle(angle_deg))) / kWall_deg);
    double along_deg = scene_deg(pose.inverse_point(at_m_));
    for (double left_deg = 1.0; left_deg != 0.0;) {
      left_deg = std::remainder(goal_deg - along_deg, 360.0);
      along_deg = std::abs(left_deg) <= kWall_deg ? goal_deg
                                                  : along_deg + std::copysign(kWall_deg, left_deg);
      at_m_ = pose.point(kWay_m * at_angle(along_deg));
      tick();
    }
    place_deg_ = scene_deg(pose.direction(at_angle(goal_deg)));
  }

  HapticLoop& loop_;
  double dt_s_;
  Vec3 at_m_ = kWay_m * Vec3::UnitX();
  double place_deg_ = 0.0;
  TickRecord record_;
  StrategyMeasures measures_;
};

}  // namespace

Result<PressMeans> press_walls(const Strategy& strategy, double pause_s) {
  RunSettings settings;
  settings.sensors = 2;
  settings.actuators = 1;
  settings.haptics.coupling = {kWall_N_per_m, 0.0};
  settings.strategy = strategy;
  const auto setup = make_setup(settings);
  if (!setup) return setup.error();
  auto mesh = prism(contour_of_walls(), -0.5 * kHeight_m, 0.5 * kHeight_m);
  if (!mesh) return mesh.error();
  const auto scene = compile_mesh("walls", std::move(*mesh), 0.0);
  if (!scene) return fault("walls", "the prism was not compiled");
  PathDevice no_device({});
  const auto rig = Rig::create(*scene, *setup, no_device);
  if (!rig) return rig.error();
  PressingHand hand((*rig)->loop(), setup->dt_s);
  PressMeans means{strategy, pause_s, 0.0, 0.0};
  for (int n = 1; n <= kAngles; ++n) {
    const int walls = 1 + kStride * n % kAngles;
    const auto depth_m = hand.press(walls * kWall_deg);
    if (!depth_m) return fault("hand", "left the wall that it pressed");
    means.depth_m += *depth_m / kAngles;
    hand.pause(pause_s);
  }
  means.turning_energy_J = hand.turning_energy_J() / kAngles;
  return means;
}

Result<std::vector<PressMeans>> press_walls(const std::vector<std::string>& strategies) {
  std::vector<PressMeans> all;
  for (const std::string& name : strategies) {
    const auto strategy = parse_strategy(name);
    if (!strategy) return strategy.error();
    for (const double pause_s : kPauses_s) {
      const auto means = press_walls(*strategy, pause_s);
      if (!means) return means.error();
      all.push_back(*means);
    }
  }
  return all;
}

std::string wall_presses_csv(const std::vector<PressMeans>& presses) {
  std::string csv = "strategy,pause_s,depth_m,turning_energy_J\n";
  for (const PressMeans& press : presses) {
    std::array<char, 80> numbers;
    std::snprintf(numbers.data(), numbers.size(), ",%g,%.9g,%.9g\n", press.pause_s, press.depth_m,
                  press.turning_energy_J);
    csv += name_of(press.strategy) + numbers.data();
  }
  return csv;
}

}  // namespace palpate::bench
