#pragma once

// The interface of a point haptic device: its description, its samples and its commands. This
// header depends only on the standard library.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace palpate {

// How a device drives its motors when the host stops sending commands.
enum class HostSilence : std::uint8_t {
  kUnknown,     // not documented: assume kHoldsForce
  kHoldsForce,  // the device holds the last command
  kZeroForce    // the device sets its motors to zero force
};

// One motor. It can push in both directions along a line.
struct MotorDescription {
  // The direction of the line: a unit vector, device frame. If the line turns as the device moves,
  // this is its direction in the device's rest pose.
  std::array<double, 3> direction_device = {1.0, 0.0, 0.0};
  double peak_force_N = 0.0;        // > 0; for a time that the device itself limits
  double continuous_force_N = 0.0;  // > 0, at most peak_force_N; for an unlimited time
};

// The time from a sample to the moment at which the motors begin to exert the force that answers
// it: the way of the sample to the host, the host, and the way of the command to the motors. It is
// in [least_s, most_s]; 0, 0: unknown.
struct DelayInterval {
  double least_s = 0.0;
  double most_s = 0.0;

  constexpr bool is_known() const { return most_s > 0.0; }
  constexpr bool operator==(const DelayInterval&) const = default;
};

// The longest delay that a description may state: that of one sample at the lowest rate of a
// driver, 1 Hz. A larger number is in another unit.
inline constexpr double kLongestDelay_s = 1.0;
constexpr bool is_delay(const DelayInterval& delay) {  // false for NaN
  return delay.least_s >= 0.0 && delay.least_s <= delay.most_s && delay.most_s <= kLongestDelay_s;
}

// The properties of one device. Device frame, SI units. A number is 0 if it is unknown.
struct DeviceDescription {
  std::string name;
  // 2: A1 = x and A2 = y; 3: also A3 = z. A device with one sensor has 2, its y stays 0, and its
  // workspace has an extent along y as well.
  int sensed_axes = 3;
  int motor_count = 0;
  std::array<MotorDescription, 3> motors = {};  // the first motor_count are used
  // False for a simulated or recorded device. The governor applies more rules to a device that
  // moves motors, and such a device without described motors gets no force.
  bool moves_motors = true;
  double peak_force_N = 0.0;  // the largest length of a force; 0: unknown
  // Two opposite corners of the workspace, a box along the axes. It extends along each sensed axis.
  std::array<double, 3> workspace_low_m = {};
  std::array<double, 3> workspace_high_m = {};
  double mass_kg = 0.0;           // apparent mass at the tip, along an axis
  double damping_Ns_per_m = 0.0;  // viscous
  double coulomb_friction_N = 0.0;
  double encoder_quantum_m = 0.0;  // step to which positions are rounded; 0: not rounded
  double rate_Hz = 1000.0;         // the rate at which the host should read and command
  DelayInterval delay = {};        // as is_delay() allows
  HostSilence when_host_is_silent = HostSilence::kUnknown;
};

// The latest sample of a device.
struct DeviceSample {
  std::array<double, 3> position_m = {};  // device frame; z is ignored with 2 sensed axes
  std::uint32_t buttons = 0;              // one bit per button, 1 while pressed
  // Increases with each sample of the device. A number that stays the same means that there is no
  // newer sample; the governor stops the motors if that lasts.
  std::uint64_t sequence = 0;
  std::int64_t time_ns = 0;  // sampling time on a monotonic clock; 0: unknown
  bool is_valid = true;      // false: the device sensed nothing; the tick commands zero force
  // The device asks the governor to trip, because it cannot obey any more. health() has the reason.
  bool asks_for_trip = false;
};

// The force that the motors must exert on the hand. Device frame. The device holds this force until
// the next command.
struct DeviceCommand {
  std::array<double, 3> force_N = {};
};

struct DeviceHealth {
  bool is_good = true;
  std::string problem = {};  // one line: the problem and its remedy; empty if is_good
};

// The interface of a point haptic device.
//
// Thread-safety: the thread that owns the device calls start(), stop(), description() and health(),
// which may block. Between start() and stop(), the haptic thread calls read() and command() once
// per tick. Before stop(), when no tick is running, the owner's thread calls command() once with
// zero force. read() and command() must not block, lock, allocate or throw.
class Device {
 public:
  virtual ~Device() = default;
  // The reference must stay valid as long as the device exists. The description must not change
  // between start() and stop().
  virtual const DeviceDescription& description() const noexcept = 0;
  // Prepares the device for read() and command(). If the device cannot start, returns a description
  // of the problem in one line. In this case read() is not called, but command() with zero force
  // and stop() are still called.
  virtual std::optional<std::string> start() { return std::nullopt; }
  // Returns the latest sample. dt_s: the nominal time since the last call, s.
  virtual DeviceSample read(double dt_s) noexcept = 0;
  virtual void command(const DeviceCommand& command) noexcept = 0;
  // The motors at the position of the last read(), at most three. Empty: they have not turned since
  // the last call that was not empty; before such a call, they are those of description(). Called
  // on the haptic thread; must not block, lock, allocate or throw.
  virtual std::span<const MotorDescription> motors_now() const noexcept { return {}; }
  // Ends a session. stop() is the last call of a session, after command() with zero force. The
  // device stays idle until the next start().
  virtual void stop() noexcept {}
  virtual DeviceHealth health() const { return {}; }
};

}  // namespace palpate
