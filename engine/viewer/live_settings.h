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
#include "engine/session/live_setting.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"
#include "haptics/a4/actuation.h"

namespace palpate {

// Passes the settings of kLiveSettings and, for a simulated device, the actuated axes to the haptic
// thread. A set value applies from the next tick on, all of it in the same tick. To set what is set
// already does nothing, and a recording has an input of the settings that changed and of no other.
//
// Thread-safety: one thread calls set(), set_axes() and the functions that return values. The
// haptic thread calls before_tick() in every tick; a device whose motors follow the axes calls
// take() and motors() before that.
class LiveSettings final : public BeforeTick {
 public:
  // setup: of the session. The scene must outlive this object.
  LiveSettings(const Scene& scene, const RunSetup& setup);

  // Each returns an Error that names the setting, and changes nothing, if the value is refused.
  // setting: its place in kLiveSettings. A4 and the force belong to the strategy of a session that
  // is more than these two.
  std::optional<Error> set(std::size_t setting, double value);
  // Independent directions in the sensed span, at most as many as sensors; none: no actuator.
  std::optional<Error> set_axes(const std::vector<Vec3>& axes_device);

  double value(std::size_t setting) const { return wanted_.settings[setting]; }
  // The largest number that a page may set: that of the table, or that of the session's start.
  double most(std::size_t setting) const { return most_[setting]; }
  const std::vector<Vec3>& axes() const { return axes_; }

  // Whether the haptic thread has not yet applied what was set.
  bool is_pending() const { return applied_.load(std::memory_order_acquire) != wanted_.number; }

  // On the haptic thread: fetches what was set since the last tick. before_tick() calls it in a
  // tick in which the device has not.
  void take() noexcept;
  // The motors of the simulated device with these axes, in a tick in which axes or force changed;
  // otherwise empty, so that HapticSession keeps the last ones without work.
  std::span<const MotorDescription> motors() const noexcept {
    return has_new_motors_ ? std::span(motors_).first(motor_count_)
                           : std::span<const MotorDescription>();
  }
  void before_tick(double time_s, LoopChanges loop) noexcept override;

 private:
  // Plain numbers, so that they can be copied bytewise.
  struct Values {
    std::uint64_t number = 0;  // counts the changes
    std::array<double, kLiveSettings.size()> settings = {};
    std::uint64_t axes_number = 0;  // counts the changes of the axes
    std::uint64_t axis_count = 0;
    std::array<std::array<double, 3>, 3> axes = {};
  };

  void publish();
  std::optional<Error> check(std::size_t setting, double value) const;
  bool has_all_motors() const noexcept;
  void find_motors() noexcept;
  void apply(LoopChanges loop) noexcept;

  const Scene* scene_;
  HapticSettings checked_;  // as wanted
  int sensors_;
  std::array<double, kLiveSettings.size()> most_ = {};
  Values wanted_;
  std::vector<Vec3> axes_;
  std::atomic<std::uint64_t> newest_{0};
  std::atomic<std::uint64_t> applied_{0};  // Values::number
  SnapshotRing<Values, 8> mailbox_;

  // Of the haptic thread.
  Values taken_;
  bool is_taken_ = false;  // in this tick
  bool is_new_ = false;    // taken_ has changed
  bool has_new_motors_ = false;
  std::uint64_t applied_axes_number_ = 0;
  std::array<MotorDescription, 3> motor_template_;
  std::array<MotorDescription, 3> motors_;
  std::size_t motor_count_ = 0;
};

}  // namespace palpate
