#include "engine/session/session_recorder.h"

#include <algorithm>

namespace palpate {

void SessionRecorder::start(const SessionFacts& facts) noexcept {
  if (sink_) sink_->on_start(facts);
}

void SessionRecorder::begin_tick(const DeviceSample& read) noexcept {
  if (!sink_) return;
  if (paused_ticks_ > 0) {
    sink_->on_input({InputKind::kPause, 0, std::as_bytes(std::span(&paused_ticks_, 1))});
    paused_ticks_ = 0;
  }
  if (read.asks_for_trip) sink_->on_input({InputKind::kTrip});
}

void SessionRecorder::rearm() noexcept {
  if (sink_) sink_->on_input({InputKind::kRearm});
}

void SessionRecorder::set_motors(std::span<const MotorDescription> motors) noexcept {
  static_assert(sizeof(MotorDescription) == 5 * sizeof(double));
  if (!sink_) return;
  motors = motors.first(std::min(motors.size(), motors_.size()));
  const auto bytes = std::as_bytes(motors);
  const auto recorded = std::as_bytes(std::span(motors_).first(motor_count_));
  if (std::equal(bytes.begin(), bytes.end(), recorded.begin(), recorded.end())) return;
  std::copy(motors.begin(), motors.end(), motors_.begin());
  motor_count_ = motors.size();
  sink_->on_input({InputKind::kMotors, static_cast<std::uint32_t>(motors.size()), bytes});
}

void SessionRecorder::end_tick(const TickRecord& record, const DeviceSample& read,
                               const TickTime& time, std::uint64_t session_tick,
                               const SafetyGovernor& governor, bool has_tripped) noexcept {
  if (!sink_) return;
  TickReading reading;
  std::copy_n(read.position_m.begin(), 3, reading.sample_m);
  reading.sequence = read.sequence;
  reading.sample_ns = read.time_ns;
  reading.dt_s = time.dt_s;
  reading.due_ns = time.now_ns - time.late_ns;
  reading.measured_dt_ns = governor.step_ns();
  reading.sample_age_ns = governor.sample_age_ns();
  reading.session_tick = session_tick;
  reading.buttons = read.buttons;
  reading.is_valid = read.is_valid ? 1 : 0;
  sink_->on_tick(record, reading);
  if (has_tripped) sink_->on_trip(governor.status().trip);
}

void SessionRecorder::report_late(LateCause cause, const TickCost& cost) noexcept {
  if (sink_) sink_->on_late(cause, cost);
}

}  // namespace palpate
