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
  text << "the device \"" << device.name << "\" states a delay of " << device.delay.least_s
       << " to " << device.delay.most_s << " s; expected an interval within 0 to "
       << kLongestDelay_s << " s (DeviceDescription::delay)";
  return text.str();
}

}  // namespace

HapticSession::HapticSession(HapticLoop& loop, Device& device, SessionParts parts)
    : loop_(loop), device_(device), parts_(std::move(parts)), recorder_(parts_.sink) {}

HapticSession::~HapticSession() {
  stop();
}

std::optional<std::string> HapticSession::start() {
  if (is_running_.exchange(true)) return std::nullopt;
  // is_running_ is already set, so that stop() runs even if device_.start() throws.
  auto problem = device_.start();
  const DeviceDescription& device = device_.description();
  if (!problem && !is_delay(device.delay)) problem = delay_problem(device);
  if (problem) {
    stop();
    return problem;
  }
  governor_.emplace(device, SafetyGovernor::clamp_of(device, parts_.max_force_N), parts_.governor);
  recorder_.start({device, parts_.max_force_N, parts_.takes_motors, parts_.governor});
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
  const TickTime time{dt_s, late_ns, now_ns};
  const DeviceSample read = device_.read(dt_s);
  const DeviceSample& sample = governor_->begin_tick(read, time);
  change_loop(read, dt_s);
  TickRecord record = run_loop(sample, dt_s);
  record.late_ns = late_ns;
  const bool has_tripped = govern(record);
  command(record);
  last_delay_ns_ = now_ns == 0 ? 0 : monotonic_ns() - now_ns;
  publish(record);
  recorder_.end_tick(record, read, time, session_ticks_++, *governor_, has_tripped);
  tell_observers(record, has_tripped);
}

// A tick of a paused session.
void HapticSession::rest(double dt_s) noexcept {
  device_.read(dt_s);
  device_.command({});
  governor_->pause();
  last_step_ns_ = 0;
  last_delay_ns_ = 0;
  ++session_ticks_;
  recorder_.pause();
}

// The inputs of a tick, in the order in which they act.
void HapticSession::change_loop(const DeviceSample& read, double dt_s) noexcept {
  recorder_.begin_tick(read);
  if (wants_rearm_.load(std::memory_order_relaxed)) take_rearm();
  take_motors();
  if (has_ticked_ && loop_.accepts(dt_s)) time_s_ += dt_s;
  has_ticked_ = true;
  const LoopChanges changes(loop_, recorder_.sink());
  const bool was_free = loop_.is_hand_free();
  for (BeforeTick* change : parts_.changes) change->before_tick(time_s_, changes);
  if (was_free && !loop_.is_hand_free()) governor_->restart();
}

void HapticSession::take_rearm() noexcept {
  if (!wants_rearm_.exchange(false, std::memory_order_acq_rel)) return;
  recorder_.rearm();
  governor_->rearm();
}

// Takes the motors of a device whose motors turn.
void HapticSession::take_motors() noexcept {
  const std::span<const MotorDescription> motors = device_.motors_now();
  recorder_.set_motors(motors);
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

TickRecord HapticSession::run_loop(const DeviceSample& sample, double dt_s) noexcept {
  if (!sample.is_valid) loop_.refuse_sample();
  const auto start = std::chrono::steady_clock::now();
  TickRecord record = loop_.tick(Vec3(sample.position_m.data()), dt_s);
  const std::chrono::nanoseconds step = std::chrono::steady_clock::now() - start;
  record.step_ns = last_step_ns_ = step.count();
  return record;
}

// Returns whether the governor has cut the force in this tick.
bool HapticSession::govern(TickRecord& record) noexcept {
  const std::uint64_t trips = governor_->status().trips;
  governor_->govern(record, governor_->needs_sources() ? loop_.force_sources() : ForceSources{});
  return governor_->status().trips > trips;
}

void HapticSession::command(const TickRecord& record) noexcept {
  DeviceCommand command;
  std::copy_n(record.force_device_N, 3, command.force_N.begin());
  device_.command(command);
}

void HapticSession::publish(const TickRecord& record) noexcept {
  published_.publish(record);
  published_status_.publish(governor_->status());
}

void HapticSession::tell_observers(const TickRecord& record, bool has_tripped) noexcept {
  for (TickObserver* observer : parts_.observers) {
    if (has_tripped) observer->on_trip(governor_->status().trip);
    observer->on_tick(record);
  }
}

}  // namespace palpate
