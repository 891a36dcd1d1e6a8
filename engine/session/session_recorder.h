#pragma once

// What a session itself, beside the changes of its loop, hands to a recording.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/session/tick_sink.h"
#include "haptics/safety_governor.h"
#include "palpate/device.h"
#include "palpate/record.h"

namespace palpate {

// Hands a sink what a session reads and does. Without a sink, it does nothing. The functions of an
// input are called where the input acts, before it acts. All but start() run on the haptic thread;
// none allocates, locks or throws.
class SessionRecorder {
 public:
  // sink: null without a recording; it must outlive the recorder.
  explicit SessionRecorder(TickSink* sink) : sink_(sink) {}

  TickSink* sink() const noexcept { return sink_; }

  void start(const SessionFacts& facts) noexcept;
  // A tick of a paused session. The next tick that is not paused has their number as an input.
  void pause() noexcept { ++paused_ticks_; }
  // Begins a tick with the sample as the device gave it.
  void begin_tick(const DeviceSample& read) noexcept;
  void rearm() noexcept;
  // The motors of a device whose motors turn: an input if they differ from the last ones.
  void set_motors(std::span<const MotorDescription> motors) noexcept;
  // Ends a tick, after the force was commanded. session_tick: see TickReading. has_tripped: the
  // governor has cut the force in this tick.
  void end_tick(const TickRecord& record, const DeviceSample& read, const TickTime& time,
                std::uint64_t session_tick, const SafetyGovernor& governor,
                bool has_tripped) noexcept;
  void report_late(LateCause cause, const TickCost& cost) noexcept;

 private:
  TickSink* sink_;
  std::uint64_t paused_ticks_ = 0;  // since the last tick that was not paused
  std::array<MotorDescription, 3> motors_{};
  std::size_t motor_count_ = 0;
};

}  // namespace palpate
