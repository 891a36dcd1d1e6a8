#include "engine/session/haptic_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <sstream>
#include <utility>

#include "engine/devices/monotonic_clock.h"

namespace palpate {
namespace {

std::string delay_problem(const DeviceDescription& device) {
  std::ostringstream text;
  text << "the device \"" << device.name << "\" states a delay of " << device.delay_s
       << " s; expected 0 to " << kLongestDelay_s << " s (DeviceDescription::delay_s)";
  return text.str();
}

}  // namespace

HapticSession::HapticSession(HapticLoop& loop, Device& device, SessionParts parts)
    : loop_(loop), device_(device), parts_(std::move(parts)) {}

HapticSession::~HapticSession() {
  stop();
}

std::optional<std::string> HapticSession::start() {
  if (is_running_.exchange(true)) return std::nullopt;
  // is_running_ is already set, so that stop() runs even if device_.start() throws.
  auto problem = device_.start();
  const DeviceDescription& device = device_.description();
  if (!problem && !is_delay(device.delay_s)) problem = delay_problem(device);
  if (problem) {
    stop();
    return problem;
  }
  governor_.emplace(device, SafetyGovernor::clamp_of(device, parts_.max_force_N));
  if (parts_.sink) parts_.sink->on_start({device, parts_.max_force_N, parts_.takes_motors});
  return std::nullopt;
}

void HapticSession::stop() noexcept {
  if (!is_running_.exchange(false)) return;
  device_.command({});
  device_.stop();
}

void HapticSession::tick(double dt_s, std::int64_t late_ns, std::int64_t now_ns) noexcept {
  if (!is_running_.load(std::memory_order_relaxed)) return;
  if (is_paused_.load(std::memory_order_relaxed)) [[unlikely]]
    return rest(dt_s);
  const DeviceSample read = device_.read(dt_s);
  const DeviceSample& sample = governor_->begin_tick(read, {dt_s, late_ns, now_ns});
  if (parts_.sink) record_inputs(read);
  if (wants_rearm_.load(std::memory_order_relaxed)) take_rearm();
  take_motors();
  const LoopChanges changes(loop_, parts_.sink);
  if (has_ticked_ && loop_.accepts(dt_s)) time_s_ += dt_s;
  has_ticked_ = true;
  const bool was_free = loop_.is_hand_free();
  for (BeforeTick* change : parts_.changes) change->before_tick(time_s_, changes);
  if (was_free && !loop_.is_hand_free()) governor_->restart();
  if (!sample.is_valid) loop_.refuse_sample();
  const auto start = std::chrono::steady_clock::now();
  TickRecord record = loop_.tick(Vec3(sample.position_m.data()), dt_s);
  const std::chrono::nanoseconds step = std::chrono::steady_clock::now() - start;
  record.step_ns = last_step_ns_ = step.count();
  record.late_ns = late_ns;
  const std::uint64_t trips = governor_->status().trips;
  governor_->govern(record);
  command(record);
  last_delay_ns_ = now_ns == 0 ? 0 : monotonic_ns() - now_ns;
  published_.publish(record);
  published_status_.publish(governor_->status());
  const bool has_tripped = governor_->status().trips > trips;
  if (parts_.sink) record_tick(record, read, dt_s, now_ns);
  if (parts_.sink && has_tripped) parts_.sink->on_trip(governor_->status().trip);
  ++session_ticks_;
  for (TickObserver* observer : parts_.observers) {
    if (has_tripped) observer->on_trip(governor_->status().trip);
    observer->on_tick(record);
  }
}

// A tick of a paused session.
void HapticSession::rest(double dt_s) noexcept {
  device_.read(dt_s);
  device_.command({});
  governor_->pause();
  last_step_ns_ = 0;
  last_delay_ns_ = 0;
  ++session_ticks_;
  ++paused_ticks_;
}

// Takes the motors of a device whose motors turn.
void HapticSession::take_motors() noexcept {
  const std::span<const MotorDescription> motors = device_.motors_now();
  if (parts_.sink) record_motors(motors);
  if (motors.empty()) return;
  governor_->set_motors(motors);
  if (!parts_.takes_motors) return;
  std::array<Vec3, 3> axes_device;
  const std::size_t count = std::min(motors.size(), axes_device.size());
  for (std::size_t i = 0; i < count; ++i) axes_device[i] = Vec3(motors[i].direction_device.data());
  const auto actuation = ActuationModel::from_axes_at_pose(device_.description().sensed_axes,
                                                           std::span(axes_device).first(count));
  if (actuation) loop_.set_actuation(*actuation);  // else: the last motors count
}

// The inputs of the session itself.
void HapticSession::record_inputs(const DeviceSample& sample) noexcept {
  if (paused_ticks_ > 0) {
    parts_.sink->on_input({InputKind::kPause, 0, std::as_bytes(std::span(&paused_ticks_, 1))});
    paused_ticks_ = 0;
  }
  if (sample.asks_for_trip) parts_.sink->on_input({InputKind::kTrip});
}

void HapticSession::take_rearm() noexcept {
  if (!wants_rearm_.exchange(false, std::memory_order_acq_rel)) return;
  if (parts_.sink) parts_.sink->on_input({InputKind::kRearm});
  governor_->rearm();
}

// Motors that have not changed since the last tick are no input.
void HapticSession::record_motors(std::span<const MotorDescription> motors) noexcept {
  static_assert(sizeof(MotorDescription) == 5 * sizeof(double));
  motors = motors.first(std::min(motors.size(), recorded_motors_.size()));
  const auto bytes = std::as_bytes(motors);
  const auto recorded = std::as_bytes(std::span(recorded_motors_).first(recorded_motor_count_));
  if (std::equal(bytes.begin(), bytes.end(), recorded.begin(), recorded.end())) return;
  std::copy(motors.begin(), motors.end(), recorded_motors_.begin());
  recorded_motor_count_ = motors.size();
  parts_.sink->on_input({InputKind::kMotors, static_cast<std::uint32_t>(motors.size()), bytes});
}

void HapticSession::record_tick(const TickRecord& record, const DeviceSample& sample, double dt_s,
                                std::int64_t now_ns) noexcept {
  TickReading reading;
  std::copy_n(sample.position_m.begin(), 3, reading.sample_m);
  reading.sequence = sample.sequence;
  reading.sample_ns = sample.time_ns;
  reading.dt_s = dt_s;
  reading.due_ns = now_ns - record.late_ns;
  reading.measured_dt_ns = governor_->step_ns();
  reading.sample_age_ns = governor_->sample_age_ns();
  reading.session_tick = session_ticks_;
  reading.buttons = sample.buttons;
  reading.is_valid = sample.is_valid ? 1 : 0;
  parts_.sink->on_tick(record, reading);
}

void HapticSession::command(const TickRecord& record) noexcept {
  DeviceCommand command;
  std::copy_n(record.force_device_N, 3, command.force_N.begin());
  device_.command(command);
}

}  // namespace palpate
