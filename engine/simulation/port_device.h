#pragma once

// A device that moves motors, in simulated time: its force acts a true delay after its sample.

#include <array>
#include <cstddef>

#include "engine/simulation/held_tip.h"
#include "palpate/device.h"

namespace palpate {

// A device of this many motors (1 to 3) along its first axes, with a peak force, that states
// nothing else of itself; 2 sensors, or as many as motors. Its workspace is a cube of 0.4 m.
DeviceDescription motor_device(int motors, double peak_force_N, double rate_Hz);

struct PortDeviceSettings {
  DeviceDescription device = motor_device(2, 10.0, 1000.0);  // what the device says of itself
  TipSettings tip;                                           // what it is
  Vec3 start_m = Vec3::Zero();
  double delay_s = 0.0;  // from a sample to the force that answers it; >= 0
  int ticks_per_sample = 1;  // read() repeats the sample before until so many ticks have passed
};

// A span of simulated time, from_s <= time < until_s.
struct TimeSpan {
  double from_s = 0.0;
  double until_s = 0.0;
  bool contains(double time_s) const { return from_s <= time_s && time_s < until_s; }
};

// Knows only physics: the tip, the hold of the last command that arrived, and the delay. A sample
// is taken when read() is called; read() and idle() let the time pass. Between two moments at which
// the force changes, the motion is exact (HeldTip). Commands arrive in the order in which they were
// given. Deterministic. No function allocates. One thread owns an object.
class PortDevice final : public Device {
 public:
  // At most this many commands are on their way: the delay is at most kMostOnTheWay - 1 periods. A
  // command that finds no place is lost, and lost_commands() counts it.
  static constexpr std::size_t kMostOnTheWay = 256;

  explicit PortDevice(const PortDeviceSettings& settings);

  const DeviceDescription& description() const noexcept override { return settings_.device; }
  // The first call takes the sample of time 0.
  DeviceSample read(double dt_s) noexcept override;
  void command(const DeviceCommand& command) noexcept override;
  // Time passes without a tick.
  void idle(double seconds) noexcept { advance_to(time_s_ + seconds); }

  // Within the span, no sample arrives: read() repeats the last one.
  void lose_samples(const TimeSpan& span) { no_samples_ = span; }
  // Commands that are given within the span do not arrive: the motors hold their force.
  void lose_commands(const TimeSpan& span) { no_commands_ = span; }
  void set_delay(double delay_s) { settings_.delay_s = delay_s; }

  double time_s() const { return time_s_; }
  HeldTip& tip() { return tip_; }
  const HeldTip& tip() const { return tip_; }
  const Vec3& motors_N() const { return motors_N_; }  // the force that acts now
  std::uint64_t lost_commands() const { return lost_commands_; }

 private:
  struct Command {
    double acts_s = 0.0;
    Vec3 force_N = Vec3::Zero();
  };
  void advance_to(double time_s) noexcept;

  PortDeviceSettings settings_;
  HeldTip tip_;
  double time_s_ = 0.0;
  bool was_read_ = false;
  int ticks_since_sample_ = 0;
  DeviceSample sample_;
  Vec3 motors_N_ = Vec3::Zero();
  std::array<Command, kMostOnTheWay> on_the_way_;  // a ring
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  TimeSpan no_samples_, no_commands_;
  std::uint64_t lost_commands_ = 0;
};

}  // namespace palpate
