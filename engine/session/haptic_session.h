#pragma once

// A haptic session: the sequence of steps in a tick, from reading the device to commanding its
// force.

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/devices/snapshot_ring.h"
#include "engine/session/loop_changes.h"
#include "engine/session/session_recorder.h"
#include "engine/session/tick_sink.h"
#include "haptics/haptic_loop.h"
#include "haptics/safety_governor.h"
#include "palpate/device.h"
#include "palpate/record.h"

namespace palpate {

// Changes nodes, materials or settings before a tick. Called on the haptic thread before every
// tick; must not block, allocate or throw.
class BeforeTick {
 public:
  virtual ~BeforeTick() = default;
  // time_s: time of this tick, from 0 at the first one: the sum of the time steps after it that the
  // loop accepts.
  virtual void before_tick(double time_s, LoopChanges loop) noexcept = 0;
};

// Moves bodies of the world before a tick.
class WorldMover : public BeforeTick {
 public:
  void before_tick(double time_s, LoopChanges loop) noexcept final { move_bodies(time_s, loop); }
  // Calls loop.move_body() for each body that has moved. time_s: as in before_tick().
  virtual void move_bodies(double time_s, LoopChanges loop) noexcept = 0;
};

// Receives the record of each tick, after the force was commanded. Called on the haptic thread;
// must not block, allocate or throw.
class TickObserver {
 public:
  virtual ~TickObserver() = default;
  virtual void on_tick(const TickRecord& record) noexcept = 0;
  // The governor has cut the force in the tick whose record follows.
  virtual void on_trip(const GovernorTrip&) noexcept {}
};

// The objects that take part in a tick besides loop and device, none of them null. The objects of a
// list are called in the order of the list. All objects must outlive the session.
struct SessionParts {
  std::vector<BeforeTick*> changes = {};
  std::vector<TickObserver*> observers = {};
  // The largest force, N, > 0. It can only lower the clamp of the device
  // (SafetyGovernor::clamp_of).
  std::optional<double> max_force_N = {};
  // The loop takes the motors of a device whose motors turn (Device::motors_now) as its actuated
  // axes. False: it keeps its own axes.
  bool takes_motors = true;
  // Of the governor; one that somebody feels watches the energy.
  GovernorSettings governor = {};
  // Gets all that is needed to compute the session again; null without a recording.
  TickSink* sink = nullptr;
};

// Runs ticks. Each tick reads the device, calls SessionParts::changes, runs the loop, limits the
// force (SafetyGovernor), commands it, publishes the record and calls the observers. tick() itself
// does not allocate, lock, do I/O or throw.
//
// The device can exert forces only between start() and stop(). A session ends when stop() or the
// destructor is called, also during stack unwinding after an exception. In each case the session
// commands zero force and then calls Device::stop() once.
//
// All references must outlive the session. Call tick() on one thread, and start() and stop() only
// while no tick is running. Any thread may call latest().
class HapticSession {
 public:
  HapticSession(HapticLoop& loop, Device& device, SessionParts parts = {});
  ~HapticSession();
  HapticSession(const HapticSession&) = delete;
  HapticSession& operator=(const HapticSession&) = delete;

  // Starts the device unless it is already started. If the device refuses, returns its one-line
  // message; the device has then been stopped, and ticks do nothing.
  std::optional<std::string> start();

  // Adds an observer behind those of SessionParts; it must outlive the session. Call it before
  // start().
  void observe(TickObserver& observer) { parts_.observers.push_back(&observer); }

  // See HapticLoop::warm_up(). Call it before the first tick.
  void warm_up() const noexcept { loop_.warm_up(); }

  // Runs one tick. Does nothing before start() and after stop(). dt_s: the nominal time since the
  // last tick. late_ns: how long ago this tick was due; it is stored in the record. now_ns: the
  // time on the monotonic clock; 0: simulated time, in which a tick takes dt_s.
  void tick(double dt_s, std::int64_t late_ns = 0, std::int64_t now_ns = 0) noexcept;

  // Commands zero force and stops the device. Does nothing if the session is not running.
  void stop() noexcept;

  // Copies the newest record to `record`. Returns false if no record could be copied; see
  // SnapshotRing::read(). Any thread may call it.
  bool latest(TickRecord& record) const noexcept { return published_.read(record); }

  // The same for the governor.
  bool latest(GovernorStatus& status) const noexcept { return published_status_.read(status); }
  // The computing time of the loop in the last tick. Call it on the haptic thread.
  std::int64_t last_step_ns() const noexcept { return last_step_ns_; }
  // The time from now_ns of tick(), on the monotonic clock, to the end of the device's command() in
  // the last tick; 0 in simulated time. Call it on the haptic thread.
  std::int64_t last_delay_ns() const noexcept { return last_delay_ns_; }
  // While a session is paused, a tick reads the device and commands zero force, and does nothing
  // else: the scene, the contact and the newest record stay. After a pause, a device that moves
  // motors begins with the governor's rule *start*. Any thread may call this function.
  void set_paused(bool paused) noexcept { is_paused_.store(paused, std::memory_order_relaxed); }
  // Ends a trip of the governor. Any thread may call it between start() and stop().
  void rearm() noexcept {
    if (governor_) wants_rearm_.store(true, std::memory_order_release);
  }
  // Counts paused ticks that are not run: the replay of a recording. Call it on the haptic thread,
  // between start() and stop().
  void skip_paused(std::uint64_t ticks) noexcept {
    session_ticks_ += ticks;
    governor_->pause();
  }
  // The last tick ended after the next one was due. Call it on the haptic thread.
  void report_late(LateCause cause, const TickCost& cost) noexcept {
    recorder_.report_late(cause, cost);
  }

 private:
  void rest(double dt_s) noexcept;
  void change_loop(const DeviceSample& read, double dt_s) noexcept;
  void take_rearm() noexcept;
  void take_motors() noexcept;
  TickRecord run_loop(const DeviceSample& sample, double dt_s) noexcept;
  bool govern(TickRecord& record) noexcept;
  void command(const TickRecord& record) noexcept;
  void publish(const TickRecord& record) noexcept;
  void tell_observers(const TickRecord& record, bool has_tripped) noexcept;

  HapticLoop& loop_;
  Device& device_;
  SessionParts parts_;
  SessionRecorder recorder_;
  double time_s_ = 0.0;
  bool has_ticked_ = false;
  std::int64_t last_step_ns_ = 0;
  std::int64_t last_delay_ns_ = 0;
  std::atomic<bool> is_running_{false};
  std::atomic<bool> is_paused_{false};
  std::atomic<bool> wants_rearm_{false};
  std::uint64_t session_ticks_ = 0;         // paused ones included
  std::optional<SafetyGovernor> governor_;  // made by start()
  SnapshotRing<TickRecord> published_;
  SnapshotRing<GovernorStatus> published_status_;
};

}  // namespace palpate
