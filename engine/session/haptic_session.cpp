#include "engine/session/haptic_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

bool is_finite(const double (&force_N)[3]) {
  return std::isfinite(force_N[0]) && std::isfinite(force_N[1]) && std::isfinite(force_N[2]);
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
  if (problem) stop();
  return problem;
}

void HapticSession::stop() noexcept {
  if (!is_running_.exchange(false)) return;
  device_.command({});
  device_.stop();
}

void HapticSession::tick(double dt_s, std::int64_t late_ns) noexcept {
  if (!is_running_.load(std::memory_order_relaxed)) return;
  const DeviceSample sample = device_.read(dt_s);
  for (BeforeTick* change : parts_.changes) change->before_tick(time_s_, loop_);
  if (is_time_step(dt_s)) time_s_ += dt_s;
  if (!sample.is_valid) loop_.refuse_sample();
  const auto start = std::chrono::steady_clock::now();
  TickRecord record = loop_.tick(Vec3(sample.position_m.data()), dt_s);
  const std::chrono::nanoseconds step = std::chrono::steady_clock::now() - start;
  record.step_ns = step.count();
  record.late_ns = late_ns;
  if (parts_.governor) parts_.governor->govern(record);
  command(record);
  published_.publish(record);
  for (TickObserver* observer : parts_.observers) observer->on_tick(record);
}

// The last check before the motors, for forces of the loop and of the governor.
void HapticSession::command(TickRecord& record) noexcept {
  if (!is_finite(record.force_device_N)) {
    std::fill_n(record.force_device_N, 3, 0.0);
    record.faults |= kFaultNonFiniteForce;
  }
  DeviceCommand command;
  std::copy_n(record.force_device_N, 3, command.force_N.begin());
  device_.command(command);
}

}  // namespace palpate
