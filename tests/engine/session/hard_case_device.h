#pragma once

// Simulated devices, and a haptic loop with a judgement of every tick.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/simulation/mass_damper.h"
#include "geometry/base/decompositions.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/haptics/proxy/hard_case_proxy.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"

namespace palpate::test {

inline ActuationModel device(int sensors, int actuators) {
  return ActuationModel::from_counts(sensors, actuators).value();
}

inline HapticSettings settings(double stiffness_N_per_m, double damping_Ns_per_m, bool a4,
                               double radius_m = 0.0) {
  HapticSettings s;
  s.god_object.radius_m = radius_m;
  s.coupling = {stiffness_N_per_m, damping_Ns_per_m};
  s.force = ForceMode::kFull;
  s.a4.enabled = a4;
  return s;
}

// A pose at at_m that turns the z axis to `normal`. The z axis is the direction of a sheet's front.
// The angle of rotation about the normal is random.
inline RigidTransform facing(const Vec3& normal, const Vec3& at_m, Random& random) {
  const Quat turn(Eigen::AngleAxisd(random.uniform(-3.0, 3.0), normal));
  return {(turn * turn_between(Vec3::UnitZ(), normal)).normalized(), at_m};
}

struct HardDevice {
  int sensors, actuators;
  double radius_m;
};

inline void PrintTo(const HardDevice& c, std::ostream* out) {
  *out << c.sensors << " sensors, " << c.actuators << " actuators, radius " << c.radius_m;
}

inline std::string device_name(const testing::TestParamInfo<HardDevice>& c) {
  return std::to_string(c.param.sensors) + "Sensors" + std::to_string(c.param.actuators) +
         "Actuators" + (c.param.radius_m == 0.0 ? "_Point" : "_Sphere");
}

// A MassDamper on one axis with Coulomb friction in addition, so that it can stick. The motion
// between ticks is exact.
class RubbingMass {
 public:
  RubbingMass(double mass_kg, double damping_Ns_per_m, double friction_N)
      : mass_kg_(mass_kg), damping_Ns_per_m_(damping_Ns_per_m), friction_N_(friction_N) {}

  void advance(double force_N, double dt_s) {
    // Under a held force, the mass stops at most once. It then stays at rest, or starts again in
    // the other direction.
    for (int part = 0; part < 3 && dt_s > 0.0; ++part) {
      const double way = velocity_m_per_s != 0.0 ? velocity_m_per_s : force_N;
      if (velocity_m_per_s == 0.0 && std::abs(force_N) <= friction_N_) return;
      const double net_N = force_N - std::copysign(friction_N_, way);
      const double stop_s = time_to_stop_s(net_N);
      const double step_s = std::min(dt_s, stop_s);
      move(net_N, step_s);
      if (stop_s <= dt_s) velocity_m_per_s = 0.0;
      dt_s -= step_s;
    }
  }
  double position_m = 0.0;
  double velocity_m_per_s = 0.0;

 private:
  double time_to_stop_s(double net_N) const {
    const double terminal = net_N / damping_Ns_per_m_;
    if (velocity_m_per_s == 0.0 || velocity_m_per_s * terminal >= 0.0) {
      return std::numeric_limits<double>::infinity();
    }
    return mass_kg_ / damping_Ns_per_m_ * std::log1p(-velocity_m_per_s / terminal);
  }
  void move(double net_N, double dt_s) {
    const double rate = damping_Ns_per_m_ / mass_kg_;
    const double terminal = net_N / damping_Ns_per_m_;
    const double excess = velocity_m_per_s - terminal;
    position_m += terminal * dt_s - excess * std::expm1(-rate * dt_s) / rate;
    velocity_m_per_s = terminal + excess * std::exp(-rate * dt_s);
  }
  double mass_kg_, damping_Ns_per_m_, friction_N_;
};

// A haptic loop, and a JudgedProxy that gets the same goals. The loop's own proxy must be equal to
// the JudgedProxy bit for bit, so that the verdict on the JudgedProxy holds for the loop. The pose
// of the scene is judged as well.
class JudgedLoop {
 public:
  JudgedLoop(const OwnedWorld& world, const ActuationModel& actuation,
             const HapticSettings& settings)
      : world_(&world.world()),
        planar_(actuation.is_planar()),
        loop_(test::made(HapticLoop::create(world.world(), actuation, settings))),
        proxy_(world, settings.god_object.radius_m) {}

  const TickRecord& tick(const Vec3& p_device_m, double dt_s) {
    const TickRecord& now = loop_.tick(p_device_m, dt_s);
    if ((now.faults & kFaultsWithoutForce) == 0) follow(now);
    judge_record(now);
    return now;
  }
  ScenePose T_device_scene() const { return loop_.T_device_scene(); }
  const JudgedProxy& proxy() const { return proxy_; }
  std::string verdict() const { return proxy_.verdict() + verdict_; }

 private:
  void follow(const TickRecord& now) {
    const Vec3 goal = world_->to_solver(vec3(now.goal_scene_m));
    if (!started_) {
      proxy_.place_solver(goal);
      started_ = true;
      return;
    }
    std::optional<Vec3> motion_plane_normal;
    if (planar_) motion_plane_normal = pose_before(now).inverse_direction(Vec3::UnitZ());
    const ProxyState state = proxy_.move_to_solver(goal, motion_plane_normal);
    const Vec3 expected = state.in_contact ? world_->to_scene(state.proxy) : vec3(now.goal_scene_m);
    if (vec3(now.proxy_scene_m) != expected) verdict_ = "the loop has another proxy; ";
  }
  void judge_record(const TickRecord& now) {
    const bool finite = vec3(now.full_force_device_N).allFinite() &&
                        vec3(now.force_device_N).allFinite() &&
                        vec3(now.proxy_scene_m).allFinite() && vec3(now.normal_scene).allFinite() &&
                        std::isfinite(now.alpha_rad);
    if (!finite) verdict_ = "not finite; ";
    const double excess = std::abs(T_device_scene().rotation.norm() - 1.0);
    if (!(excess <= 4 * 0x1p-52)) verdict_ = "quaternion off by " + std::to_string(excess) + "; ";
  }

  const ContactWorld* world_;
  bool planar_;
  HapticLoop loop_;
  JudgedProxy proxy_;
  bool started_ = false;
  std::string verdict_;
};

}  // namespace palpate::test
