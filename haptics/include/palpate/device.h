#pragma once

// What a point haptic device is, senses and is told. Needs the standard library alone.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace palpate {

// What a device does with its motors when the host has sent nothing for a while.
enum class HostSilence : std::uint8_t {
  kUnknown,     // nobody has found out: as bad as holding
  kHoldsForce,  // the last command goes on
  kZeroForce    // the device stops pushing by itself
};

// A motor pushes along a line, both ways.
struct MotorDescription {
  std::array<double, 3> direction_device = {1.0, 0.0,
                                            0.0};  // unit; of a pose-dependent motor: at rest
  double peak_force_N = 0.0;        // > 0 of a motor; for as long as the device allows
  double continuous_force_N = 0.0;  // > 0, at most the peak: for ever
};

// One device. Device frame, SI units; 0 in a number that nobody knows.
struct DeviceDescription {
  std::string name;
  int sensed_axes = 3;  // the first 2 or 3 of A1 = x, A2 = y, A3 = z
  int motor_count = 0;
  std::array<MotorDescription, 3> motors = {};  // the first motor_count of them
  bool moves_motors = false;                    // false of what is simulated or recorded
  std::array<double, 3> workspace_low_m = {};
  std::array<double, 3> workspace_high_m = {};
  double mass_kg = 0.0;           // at the tip, along an axis
  double damping_Ns_per_m = 0.0;  // viscous
  double coulomb_friction_N = 0.0;
  double encoder_quantum_m = 0.0;  // what positions are rounded to; 0: to nothing
  double rate_Hz = 1000.0;         // at which it wants to be asked and told
  HostSilence when_host_is_silent = HostSilence::kUnknown;
};

// What a device has sensed last.
struct DeviceSample {
  std::array<double, 3> position_m = {};  // device frame; of 2 sensed axes z counts for nothing
  std::uint32_t buttons = 0;              // a bit each, 1 while pressed
  std::uint64_t sequence = 0;             // rises by one with each sample that the device has taken
  std::int64_t time_ns = 0;               // when it was taken, of a monotonic clock; 0: unknown
  bool is_valid = true;                   // false: nothing was sensed; the tick gives no force
};

// What the motors are told. Device frame; held until the next command.
struct DeviceCommand {
  std::array<double, 3> force_N = {};
};

struct DeviceHealth {
  bool is_good = true;
  std::string problem = {};  // one line: what is wrong and what to do; empty if it is good
};

// A point haptic device. start(), stop(), description() and health() are for the thread that owns
// it and may block; read() and command() come from the haptic thread between the two, once a tick,
// and must not block, lock, allocate or throw.
class Device {
 public:
  virtual ~Device() = default;
  // Valid as long as the device; does not change between start() and stop().
  virtual const DeviceDescription& description() const noexcept = 0;
  // Makes ready to be read. A problem, one line, if it cannot: nothing is to be read or commanded
  // then, and stop() is called.
  virtual std::optional<std::string> start() { return std::nullopt; }
  // dt_s: since the last call, nominal.
  virtual DeviceSample read(double dt_s) noexcept = 0;
  virtual void command(const DeviceCommand& command) noexcept = 0;
  // The last call of a session: after a command of zero force. The device rests until start().
  virtual void stop() noexcept {}
  virtual DeviceHealth health() const { return {}; }
};

}  // namespace palpate
