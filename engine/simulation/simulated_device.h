#pragma once

// The simulated device, and the hand that holds it, with which `palpate run` explores a scene.

#include <cstdint>
#include <limits>
#include <optional>
#include <random>

#include "engine/devices/light_device.h"
#include "engine/devices/stability_limits.h"  // HandImpedance
#include "engine/session/haptic_session.h"
#include "engine/session/run_setup.h"
#include "engine/simulation/intention_wander.h"
#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

// The target state of a hand, in the device frame.
struct HandTarget {
  Vec3 position_m = Vec3::Zero();
  Vec3 velocity_m_per_s = Vec3::Zero();
};

// Sets the hand's target. target() runs on the haptic thread: it must not block, allocate or throw.
class HandPlan {
 public:
  virtual ~HandPlan() = default;
  // time_s: the time since the start. T_device_scene: the scene as displayed now. last: the last
  // tick.
  virtual HandTarget target(double time_s, const ScenePose& T_device_scene,
                            const TickRecord& last) noexcept = 0;
};

// A point mass with friction. Encoders measure its position; the hand is a spring and a damper
// between the mass and the target.
struct PlantSettings {
  DeviceDescription device = light_device();
  HandImpedance hand;
  double intention_noise_m = 0.3e-3;  // standard deviation per axis, 3 Hz low-pass
  double intention_noise_Hz = 3.0;
  // A second noise of the intended position, of second order (intention_wander.h): its standard
  // deviation per axis and its natural frequency.
  double wander_m = 0.0;
  double wander_Hz = 1.0;
  // Noise of the hand's force per axis, with a 6 Hz low-pass: its standard deviation, as a share of
  // the magnitude of the force.
  double force_noise = 0.0;
  int substeps = 10;  // semi-implicit Euler steps per tick
  std::uint64_t seed = 1;
};

// Returns an error if the time integration is unstable, so that the position diverges. The error
// names the field of RunSettings. dt_s: duration of a tick.
std::optional<Error> check_plant(const PlantSettings& settings, double dt_s);

// Deterministic: one seed and one plan give one motion.
class SimulatedDevice final : public Device, public TickObserver {
 public:
  // start_device_m: rest position of device and hand at time 0. planar: only A1 and A2 move.
  SimulatedDevice(const PlantSettings& settings, HandPlan& plan, const Vec3& start_device_m,
                  const ScenePose& T_device_scene, bool planar);

  const DeviceDescription& description() const noexcept override { return settings_.device; }
  DeviceSample read(double dt_s) noexcept override;
  void command(const DeviceCommand& command) noexcept override {
    force_N_ = Vec3(command.force_N.data());
  }
  void on_tick(const TickRecord& record) noexcept override;

 private:
  void move_hand(double dt_s);
  Vec3 intention_noise(double dt_s);
  void advance_force_noise(double dt_s);
  void substep(const HandTarget& target, double dt_s);

  PlantSettings settings_;
  HandPlan& plan_;
  bool planar_;
  std::mt19937_64 random_;
  double time_s_ = 0.0;
  std::uint64_t samples_ = 0;
  Vec3 position_m_;
  Vec3 velocity_m_per_s_ = Vec3::Zero();
  Vec3 noise_m_ = Vec3::Zero();
  IntentionWander wander_;
  Vec3 force_noise_ = Vec3::Zero();  // of unit variance per axis
  Vec3 force_N_ = Vec3::Zero();
  TickRecord last_;
};

// The device that a simulated hand holds in a session with this setup. Under ForceMode::kFull it
// has a motor along every sensed axis, as if it were fully actuated. The others: see
// SimulatedDevice.
SimulatedDevice device_in_hand(PlantSettings plant, const RunSetup& setup, HandPlan& plan,
                               const Vec3& start_device_m);

}  // namespace palpate
