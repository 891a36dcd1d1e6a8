#include "engine/session/haptic_session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <utility>

#include "engine/session/monotonic_clock.h"

namespace palpate {
HapticSession::HapticSession(HapticLoop& loop, Device& device, SessionParts parts)
    : loop_(loop), device_(device), parts_(std::move(parts)) {}

HapticSession::~HapticSession() {
  stop();
}

std::optional<std::string> HapticSession::start() {
  if (is_running_.exchange(true)) return std::nullopt;
  // is_running_ is already set, so that stop() runs even if device_.start() throws.
  auto problem = device_.start();
  if (problem) {
    stop();
    return problem;
  }
  const DeviceDescription& device = device_.description();
  governor_.emplace(device, SafetyGovernor::clamp_of(device, parts_.max_force_N));
  return std::nullopt;
}

void HapticSession::stop() noexcept {
  if (!is_running_.exchange(false)) return;
  device_.command({});
  device_.stop();
}

void HapticSession::tick(double dt_s, std::int64_t late_ns, std::int64_t now_ns) noexcept {
  if (!is_running_.load(std::memory_order_relaxed)) return;
  if (is_paused_.load(std::memory_order_relaxed)) [[unlikely]] return rest(dt_s);
  const DeviceSample& sample = governor_->begin_tick(device_.read(dt_s), {dt_s, late_ns, now_ns});
  take_motors();
  for (BeforeTick* change : parts_.changes) change->before_tick(time_s_, loop_);
  if (is_time_step(dt_s)) time_s_ += dt_s;
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
  for (TickObserver* observer : parts_.observers) {
    if (has_tripped) observer->on_trip(governor_->status().trip);
    observer->on_tick(record);
  }
}

// A tick of a paused session.
void HapticSession::rest(double dt_s) noexcept {
  device_.read(dt_s);
  device_.command({});
  last_step_ns_ = 0;
}

// Takes the motors of a device whose motors turn.
void HapticSession::take_motors() noexcept {
  const std::span<const MotorDescription> motors = device_.motors_now();
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

void HapticSession::command(const TickRecord& record) noexcept {
  DeviceCommand command;
  std::copy_n(record.force_device_N, 3, command.force_N.begin());
  device_.command(command);
}

}  // namespace palpate
