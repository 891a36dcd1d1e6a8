#pragma once

// A whole haptic loop in simulated time around a device that moves motors: a session on a scene,
// and behind the device the tip in a hand. It judges what the engine does to a person.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/rig/rig.h"
#include "engine/scene/scene.h"
#include "engine/simulation/port_device.h"
#include "geometry/base/result.h"

namespace palpate {

// In the shape's frame, the solid lies at x < 0 near the origin. The wall is the plane x = 0. The
// groove is the valley between two planes at 45 degrees to the x axis; its bottom is the z axis.
enum class PortShape : std::uint8_t { kWall, kGroove };

// A light grip of two fingers: it pulls the tip back but hardly damps it. A firm grip is that of
// HandImpedance's defaults.
inline constexpr HandImpedance kLightGrip{0.0, 0.4, 100.0};
inline constexpr HandImpedance kFirmGrip{};

struct PortLoopSettings {
  PortShape shape = PortShape::kWall;
  double turn_rad = 0.0;  // of the shape about z, from the device frame
  PortDeviceSettings device;
  CouplingSettings coupling;
  std::optional<Strategy> strategy = {};  // no value: the force of all motors, without A4
  double rate_Hz = 1000.0;
  GovernorSettings governor = {};
};

// One thread owns an object.
class PortLoop final : public TickObserver {
 public:
  // Errors: those of Rig::create() and of the device's start.
  static Result<std::unique_ptr<PortLoop>> create(const PortLoopSettings& settings,
                                                  std::vector<BeforeTick*> changes = {});

  // Runs one tick, a period after the last one.
  void tick() { rig_->session().tick(dt_s_, 0, 0); }
  // The next tick comes late by this time; the device goes on meanwhile.
  void tick_late(double late_s);
  // Runs the ticks of a time, to the nearest tick.
  void run(double seconds);

  double dt_s() const { return dt_s_; }
  // A vector of the shape's frame in the device frame.
  Vec3 to_device(const Vec3& v_shape) const { return R_device_shape_ * v_shape; }
  PortDevice& device() { return device_; }
  const PortDevice& device() const { return device_; }
  HeldTip& tip() { return device_.tip(); }
  const HeldTip& tip() const { return device_.tip(); }
  Rig& rig() { return *rig_; }

  const TickRecord& last() const { return last_; }
  std::uint32_t rules() const { return rules_; }      // of all ticks
  const GovernorTrip& trip() const { return trip_; }  // the first one
  bool has_tripped() const { return trip_.reason != TripReason::kNone; }
  GovernorStatus governor() const;

  void on_tick(const TickRecord& record) noexcept override;
  void on_trip(const GovernorTrip& trip) noexcept override;

 private:
  PortLoop(const PortLoopSettings& settings, Scene scene);

  double dt_s_;
  Mat3 R_device_shape_;
  Scene scene_;
  PortDevice device_;
  std::unique_ptr<Rig> rig_;
  TickRecord last_;
  GovernorTrip trip_;
  std::uint32_t rules_ = 0;
};

}  // namespace palpate
