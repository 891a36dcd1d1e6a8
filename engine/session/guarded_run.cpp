#include "engine/session/guarded_run.h"

#include <algorithm>
#include <cstring>
#include <pthread.h>
#include <sched.h>
#include <thread>
#include <utility>

#include "engine/devices/realtime_limit.h"
#include "engine/session/realtime.h"

namespace palpate {
namespace {

constexpr const char* kNoGuard =
    "no process guards the motors: if this program hangs or ends, the device may keep its last "
    "force";

// How the system refuses SCHED_FIFO to the threads of this process; empty: it grants it. The
// question is put before anything moves, by a thread that ends at once.
std::string fifo_refusal() {
  int refused = 0;
  std::thread asking([&refused] {
    const sched_param priority{kHapticPriority};
    refused = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
  });
  asking.join();
  return refused == 0 ? std::string() : std::strerror(refused);
}

// Without motors, a device cannot keep a force.
bool keeps_last_force(const DeviceDescription& device) {
  return device.motor_count > 0 && device.when_host_is_silent != HostSilence::kZeroForce;
}

}  // namespace

GuardedRun::GuardedRun(GuardableDevice& device, HapticSession& session,
                       const GuardedRunSettings& settings)
    : device_(device), session_(session), settings_(settings), thread_(session, settings.thread) {}

GuardedRun::~GuardedRun() {
  stop();
}

std::optional<Error> GuardedRun::start() {
  auto error = start_steps();
  if (error) stop();
  return error;
}

std::optional<Error> GuardedRun::start_steps() {
  if (auto error = open_device()) return error;
  if (auto error = check_rates()) return error;
  const std::string refusal = fifo_refusal();
  if (auto error = check_fifo(refusal)) return error;
  has_fifo_ = refusal.empty();
  if (settings_.has_guard) {
    if (auto error = start_guard()) return error;
  } else {
    warnings_.emplace_back(kNoGuard);
  }
  return start_thread();
}

std::optional<Error> GuardedRun::open_device() {
  is_open_ = true;  // also a device that refuses is stopped
  auto problem = device_.start();
  if (!problem) return std::nullopt;
  return Error{ErrorCode::kFileUnreadable, "", "", std::move(*problem), ""};
}

// The device has measured its line.
std::optional<Error> GuardedRun::check_rates() {
  const LineRate line = device_.line_rate();
  const DeviceDescription& device = device_.description();
  if (auto error = check_least_rates(device, line, settings_.thread.rate_Hz)) return error;
  for (std::string& warning : slow_rate_warnings(device, line, settings_.thread.rate_Hz)) {
    warnings_.push_back(std::move(warning));
  }
  return std::nullopt;
}

std::optional<Error> GuardedRun::check_fifo(const std::string& refusal) const {
  if (refusal.empty() || settings_.without_realtime) return std::nullopt;
  if (!keeps_last_force(device_.description())) return std::nullopt;
  return Error{
      ErrorCode::kInvalidArgument, "", device_.description().name,
      "keeps its last force, and the system refuses SCHED_FIFO (" + refusal +
          "), without which a zero may come late; expected real-time scheduling",
      fifo_remedy() +
          ", or accept trips on a busy machine with `GuardedRunSettings::without_realtime`"};
}

std::optional<Error> GuardedRun::start_guard() {
  GuardSpec spec;
  spec.descriptor = device_.descriptor();
  // A command comes as often as the slower of the two threads writes.
  spec.period_s = 1.0 / std::min(settings_.thread.rate_Hz, device_.description().rate_Hz);
  spec.zero_bytes = device_.zero_bytes();
  auto guard = MotorGuard::spawn(spec);
  if (!guard) return guard.error();
  guard_ = std::move(*guard);
  if (!guard_->has_fifo()) {
    if (auto error = check_fifo("for palpate-guard")) return error;
    has_fifo_ = false;
    warnings_.push_back(guard_->fifo_problem());
  }
  device_.set_guard(guard_.get());
  if (auto error = guard_->arm()) return error;
  is_armed_ = true;
  return std::nullopt;
}

std::optional<Error> GuardedRun::start_thread() {
  RealtimeStatus status = thread_.start();
  if (!status.device_problem.empty()) {
    is_open_ = false;  // the session has stopped it
    return Error{ErrorCode::kFileUnreadable, "", "", std::move(status.device_problem), ""};
  }
  is_open_ = false;  // the session stops it
  if (!status.explanation.empty()) warnings_.push_back(std::move(status.explanation));
  return std::nullopt;
}

void GuardedRun::stop() {
  thread_.stop();
  session_.stop();
  if (is_open_) {
    device_.command({});
    device_.stop();
    is_open_ = false;
  }
  stop_guard();
}

// The device has got its zero and is closed.
void GuardedRun::stop_guard() {
  if (!guard_) return;
  if (is_armed_) {
    if (const auto error = guard_->disarm()) warnings_.push_back(error->to_string());
  }
  is_armed_ = false;
  guard_.reset();
}

}  // namespace palpate
