#pragma once

// The one road through a tick: a device, a haptic loop, and what changes, governs and hears of it.

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "haptics/haptic_loop.h"
#include "palpate/device.h"
#include "palpate/record.h"

namespace palpate {

// Changes something for the next tick (nodes, materials, motors): asked on the haptic thread before
// each, and must not block, allocate or throw.
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

// Stands between loop and device, under the same rules: may lessen the commanded force of the
// record, and says why in the upper 16 bits of its faults.
class ForceGovernor {
 public:
  virtual ~ForceGovernor() = default;
  virtual void govern(TickRecord& record) noexcept = 0;
};

// Told of each tick on the haptic thread, after the force was commanded; under the same rules.
class TickObserver {
 public:
  virtual ~TickObserver() = default;
  virtual void on_tick(const TickRecord& record) noexcept = 0;
};

// Who takes part in a tick beside loop and device, each asked in the order given. None is null but
// the governor, which may be.
struct SessionParts {
  std::vector<BeforeTick*> changes = {};
  ForceGovernor* governor = nullptr;
  std::vector<TickObserver*> observers = {};
};

// Runs ticks: read the device, change what changes, run the loop, govern, command the force,
// publish, tell the observers. No allocation, lock, I/O or exception in tick().
//
// Between start() and stop() the device pushes. However a session ends, by stop(), by the end of
// its life or by an exception that passes it, the device's last command is zero force, and its
// stop() is called once.
//
// All references must outlive the session. tick() is for one thread, latest() for any; start() and
// stop() while no tick is running.
class HapticSession {
 public:
  HapticSession(HapticLoop& loop, Device& device, SessionParts parts = {});
  ~HapticSession();
  HapticSession(const HapticSession&) = delete;
  HapticSession& operator=(const HapticSession&) = delete;

  // Starts the device, unless it is started. What it says if it refuses, one line; it has then been
  // stopped, and ticks do nothing.
  std::optional<std::string> start();

  // One tick; nothing before start() and after stop(). dt_s: since the last one, nominal. late_ns:
  // since it was due. A force that is not finite is not commanded: zero force, and
  // kFaultNonFiniteForce.
  void tick(double dt_s, std::int64_t late_ns = 0) noexcept;

  void stop() noexcept;

  // The newest record, from any thread; see SnapshotRing::read().
  bool latest(TickRecord& record) const noexcept { return published_.read(record); }

 private:
  void command(TickRecord& record) noexcept;

  HapticLoop& loop_;
  Device& device_;
  SessionParts parts_;
  double time_s_ = 0.0;
  std::atomic<bool> is_running_{false};
  SnapshotRing<TickRecord> published_;
};

}  // namespace palpate
