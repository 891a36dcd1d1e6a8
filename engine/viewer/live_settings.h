#pragma once

// Settings of the haptic loop that a page changes during a session.

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "engine/session/haptic_session.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"

namespace palpate {

// Passes A4, the part of the force, stiffness, damping and, for a simulated device, the actuated
// axes to the haptic thread. A set value applies from the next tick on, all of it in the same tick.
//
// Thread-safety: one thread calls set_*() and the functions that return values. The haptic thread
// calls before_tick() in every tick; a device whose motors follow the axes calls take() and
// motors() before that.
class LiveSettings final : public BeforeTick {
 public:
  // The largest values that a page may set; a run that begins with a larger one may go up to that.
  static constexpr double kMostStiffness_N_per_m = 5000.0;
  static constexpr double kMostDamping_Ns_per_m = 50.0;

  // setup: of the session. The scene must outlive this object.
  LiveSettings(const Scene& scene, const RunSetup& setup);

  // Each returns an Error that names the setting, and changes nothing, if the value is refused.
  // A4 and the force belong to the strategy of a session that is more than these two.
  std::optional<Error> set_a4(bool enabled);
  std::optional<Error> set_force(ForceMode force);
  std::optional<Error> set_stiffness(double stiffness_N_per_m);
  std::optional<Error> set_damping(double damping_Ns_per_m);
  // Independent directions in the sensed span, at most as many as sensors; none: no actuator.
  std::optional<Error> set_axes(const std::vector<Vec3>& axes_device);

  bool a4() const { return wanted_.a4 != 0; }
  ForceMode force() const { return static_cast<ForceMode>(wanted_.force); }
  double stiffness_N_per_m() const { return wanted_.stiffness_N_per_m; }
  double damping_Ns_per_m() const { return wanted_.damping_Ns_per_m; }
  double most_stiffness_N_per_m() const { return most_stiffness_N_per_m_; }
  double most_damping_Ns_per_m() const { return most_damping_Ns_per_m_; }
  const std::vector<Vec3>& axes() const { return axes_; }

  // Whether the haptic thread has not yet applied what was set.
  bool is_pending() const { return applied_.load(std::memory_order_acquire) != wanted_.number; }

  // On the haptic thread: fetches what was set since the last tick. before_tick() calls it in a
  // tick in which the device has not.
  void take() noexcept;
  // The motors of the simulated device with these axes, in a tick in which they have changed;
  // otherwise empty, so that HapticSession keeps the last ones without work.
  std::span<const MotorDescription> motors() const noexcept {
    return is_new_ ? std::span(motors_).first(motor_count_) : std::span<const MotorDescription>();
  }
  void before_tick(double time_s, LoopChanges loop) noexcept override;

 private:
  // Plain numbers, so that they can be copied bytewise.
  struct Values {
    std::uint64_t number = 0;  // counts the changes
    double stiffness_N_per_m = 0.0;
    double damping_Ns_per_m = 0.0;
    std::uint32_t a4 = 0;
    std::uint32_t force = 0;
    std::uint32_t has_axes = 0;  // the axes were set at least once
    std::uint32_t axis_count = 0;
    std::array<std::array<double, 3>, 3> axes = {};
  };

  void publish();
  std::optional<Error> check_strategy(const char* name) const;
  std::optional<Error> check_coupling(const Values& values) const;
  void find_motors() noexcept;
  void apply(LoopChanges loop) const noexcept;

  const Scene* scene_;
  HapticSettings checked_;  // for check_settings()
  int sensors_;
  double most_stiffness_N_per_m_;
  double most_damping_Ns_per_m_;
  Values wanted_;
  std::vector<Vec3> axes_;
  std::atomic<std::uint64_t> newest_{0};
  std::atomic<std::uint64_t> applied_{0};  // Values::number
  SnapshotRing<Values, 8> mailbox_;

  // Of the haptic thread.
  Values taken_;
  bool is_taken_ = false;  // in this tick
  bool is_new_ = false;    // taken_ has changed
  std::array<MotorDescription, 3> motor_template_;
  std::array<MotorDescription, 3> motors_;
  std::size_t motor_count_ = 0;
};

}  // namespace palpate
