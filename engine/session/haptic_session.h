#pragma once

// A device, a haptic loop and what listens to them, driven one tick at a time.

#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "haptics/haptic_loop.h"

namespace palpate {

// A point haptic device. Both calls come from the haptic thread, once a tick, and must not block,
// allocate or throw.
class Device {
 public:
  virtual ~Device() = default;
  // Position in the device frame, metres. dt_s: since the last call, nominal.
  virtual Vec3 read_position_m(double dt_s) noexcept = 0;
  // Force on the hand in the device frame, newtons, held until the next call.
  virtual void command_force_N(const Vec3& force_device) noexcept = 0;
};

// Told of each tick, on the haptic thread; under the same rules.
class TickObserver {
 public:
  virtual ~TickObserver() = default;
  // T_device_scene: after the elementary rotation, unlike the record's. step_ns: time the loop
  // took.
  virtual void on_tick(const TickRecord& record, const ScenePose& T_device_scene,
                       std::int64_t step_ns) noexcept = 0;
};

// Changes something for the next tick: asked on the haptic thread before each, under the same
// rules.
class BeforeTick {
 public:
  virtual ~BeforeTick() = default;
  // time_s: sum of the good dt of the ticks before this one.
  virtual void before_tick(double time_s, HapticLoop& loop) noexcept = 0;
};

// Moves bodies of the world.
class WorldMover : public BeforeTick {
 public:
  void before_tick(double time_s, HapticLoop& loop) noexcept final { move_bodies(time_s, loop); }
  // time_s: sum of the good dt of the ticks before this one. Calls loop.move_body() for what has
  // moved.
  virtual void move_bodies(double time_s, HapticLoop& loop) noexcept = 0;
};

// What other threads see of a running session: plain numbers, so that it can be copied as bits.
struct HapticSnapshot {
  std::uint64_t sequence = 0;  // tick number + 1; rises by one
  double time_s = 0.0;
  std::array<double, 4> q_wxyz{1, 0, 0, 0};  // T_device_scene after the tick
  std::array<double, 3> o_m{};
  std::array<double, 3> proxy_scene_m{};
  std::array<double, 3> device_m{};
  std::array<double, 3> force_device_N{};
  double alpha_rad = 0.0;
  std::uint32_t contact = 0;
  std::uint32_t faults = 0;

  ScenePose T_device_scene() const {
    return {Quat(q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3]), Vec3(o_m[0], o_m[1], o_m[2])};
  }
};

// Runs ticks: read the device, change what changes, run the loop, command the force, publish, tell
// the observer. No allocation, lock, I/O or exception in tick(). All references must outlive
// the session.
class HapticSession {
 public:
  HapticSession(HapticLoop& loop, Device& device, TickObserver* observer = nullptr,
                BeforeTick* before = nullptr)
      : loop_(loop), device_(device), observer_(observer) {
    if (before) before_.push_back(before);
  }
  // Several, asked in this order; none is null.
  HapticSession(HapticLoop& loop, Device& device, TickObserver* observer,
                std::initializer_list<BeforeTick*> before)
      : loop_(loop), device_(device), observer_(observer), before_(before) {}

  void tick(double dt_s) noexcept;

  // From any thread; see SnapshotRing::read().
  bool latest(HapticSnapshot& snapshot) const noexcept { return published_.read(snapshot); }

 private:
  HapticLoop& loop_;
  Device& device_;
  TickObserver* observer_;
  std::vector<BeforeTick*> before_;
  double time_s_ = 0.0;
  SnapshotRing<HapticSnapshot> published_;
};

}  // namespace palpate
