#include "engine/devices/hapi_device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sstream>
#include <thread>
#include <utility>

#include "engine/devices/serial_port.h"
#include "engine/devices/snapshot_ring.h"

namespace palpate {
namespace {

using Milliseconds = std::chrono::milliseconds;

// Scheduled as the haptic thread is (haptic_thread.cpp). Where the system refuses this, it refuses
// it for the haptic thread as well, which reports it.
constexpr int kDriverPriority = 80;
constexpr std::int64_t kLongestSleep_ns = 5'000'000;
constexpr std::int64_t kShortestSleep_ns = 10'000;  // so that other threads can always run
constexpr auto kLongestRelease = Milliseconds(50);  // a line that takes no bytes is left as it is

std::int64_t steady_now_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

const char* explain(HapiProblem problem) {
  switch (problem) {
    case HapiProblem::kNone:
      return "";
    case HapiProblem::kNoAnswers:
      return "the board did not answer three messages in a row (check its cable and its power)";
    case HapiProblem::kBadAnswers:
      return "three answers in a row were malformed (check the cable and other users of the board)";
    case HapiProblem::kHungUp:
      return "the port was disconnected (connect the board and start again)";
    case HapiProblem::kGuardTripped:
      return "the guard has stopped the motors, because the program had stopped writing";
    case HapiProblem::kGuardGone:
      return "the guard of the motors has ended (start again)";
  }
  return "";
}

constexpr const char* kUncalibrated =
    "commands no force without torque-per-Nm (to calibrate: hold the device down, command a torque "
    "number, measure the force at a known lever, and divide the number by force times lever)";
constexpr const char* kFading =
    "is near a singular pose, where the force fades to zero (move towards the middle of the "
    "workspace)";

}  // namespace

// One run of the driver's thread.
class HapiDevice::Session {
 public:
  Session(const HapiSettings& settings, SerialPort port) : link_(settings), port_(std::move(port)) {
    // Signals are for other threads.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([this] { run(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    const sched_param priority{kDriverPriority};
    pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
  }
  ~Session() { end(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  void command(const HapiForce& force) noexcept { forces_.publish(force); }
  bool read(HapiSample& sample) const noexcept { return samples_.read(sample); }
  bool read(HapiCounts& counts) const noexcept { return counts_.read(counts); }
  // Returns when the thread no longer uses the guard before.
  void set_guard(WriteGuard* guard) noexcept {
    guard_ = guard;
    while (used_guard_ != guard) std::this_thread::sleep_for(Milliseconds(1));
  }
  // Sends zero and ends the thread.
  void end() noexcept {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  int descriptor() const noexcept { return port_.descriptor(); }

 private:
  void run();
  void exchange();
  void publish();
  void sleep();

  HapiLink link_;
  SerialPort port_;
  SnapshotRing<HapiForce> forces_;
  SnapshotRing<HapiSample> samples_;
  SnapshotRing<HapiCounts> counts_;
  std::atomic<WriteGuard*> guard_{nullptr};
  std::atomic<WriteGuard*> used_guard_{nullptr};
  std::uint64_t published_messages_ = 0;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

void HapiDevice::Session::run() {
  link_.start(steady_now_ns());
  while (!ends_) {
    exchange();
    publish();
    sleep();
  }
  link_.release();
  const auto end = std::chrono::steady_clock::now() + kLongestRelease;
  while (!link_.has_released() && std::chrono::steady_clock::now() < end) {
    exchange();
    sleep();
  }
  publish();
}

// Moves what can be moved, without waiting.
void HapiDevice::Session::exchange() {
  WriteGuard* const guard = guard_;
  if (guard != used_guard_) link_.set_guard(guard);
  used_guard_ = guard;
  std::array<std::uint8_t, 256> bytes;
  const auto count = port_.read(bytes);
  if (!count) link_.hang_up(steady_now_ns());
  link_.receive(std::span(bytes).first(count.value_or(0)), steady_now_ns());
  HapiForce force;
  if (forces_.read(force)) link_.set_force(force);
  link_.step(steady_now_ns());
  const auto written = port_.write(link_.to_send());
  if (!written) link_.hang_up(steady_now_ns());
  link_.sent(written.value_or(0), steady_now_ns());
}

void HapiDevice::Session::publish() {
  samples_.publish(link_.sample());
  const HapiCounts counts = link_.counts();
  if (counts.messages != published_messages_) counts_.publish(counts);
  published_messages_ = counts.messages;
}

// Waits for an answer, for space in the terminal's queue if bytes wait, or for the next step.
void HapiDevice::Session::sleep() {
  const std::int64_t wait_ns =
      std::clamp(link_.wake_ns() - steady_now_ns(), kShortestSleep_ns, kLongestSleep_ns);
  const timespec wait{0, static_cast<long>(wait_ns)};
  if (link_.is_off()) {  // a dead port would be ready at once
    std::this_thread::sleep_for(std::chrono::nanoseconds(kLongestSleep_ns));
    return;
  }
  const bool has_bytes = !link_.to_send().empty();
  pollfd port{port_.descriptor(), static_cast<short>(has_bytes ? POLLIN | POLLOUT : POLLIN), 0};
  ::ppoll(&port, 1, &wait, nullptr);
}

HapiDevice::HapiDevice(HapiSettings settings) : settings_(std::move(settings)), view_(settings_) {}

HapiDevice::~HapiDevice() {
  stop();
}

std::optional<std::string> HapiDevice::start() {
  if (session_) return std::nullopt;
  if (const auto error = check_hapi_settings(settings_)) return error->to_string();
  auto port = SerialPort::open(settings_.port);
  if (!port) return port.error().to_string();
  view_ = HapiView(settings_);
  sample_ = HapiSample{};
  session_ = std::make_unique<Session>(settings_, std::move(*port));
  const auto end =
      std::chrono::steady_clock::now() + Milliseconds(static_cast<int>(1e3 * kAnswerToStart_s));
  HapiSample sample;
  while (std::chrono::steady_clock::now() < end) {
    if (session_->read(sample) && sample.is_working) {
      sample_ = sample;
      return std::nullopt;
    }
    if (sample.problem == HapiProblem::kHungUp) break;
    std::this_thread::sleep_for(Milliseconds(1));
  }
  stop();
  Error error = {ErrorCode::kFileUnreadable, settings_.port, "",
                 "nobody answers within 2 s; expected a hAPI board",
                 "check the board's power and its firmware, and that no other port is its own"};
  return error.to_string();
}

DeviceSample HapiDevice::read(double) noexcept {
  if (session_) session_->read(sample_);
  return view_.take(sample_);
}

void HapiDevice::command(const DeviceCommand& command) noexcept {
  if (session_) session_->command({{command.force_N[0], command.force_N[1]}, steady_now_ns()});
}

void HapiDevice::stop() noexcept {
  if (!session_) return;
  session_->end();
  session_->read(last_sample_);
  session_->read(last_counts_);
  session_.reset();
}

DeviceHealth HapiDevice::health() const {
  HapiSample sample = last_sample_;
  if (session_) session_->read(sample);
  std::string problem = explain(sample.problem);
  if (problem.empty() && !settings_.torque_per_Nm) problem = kUncalibrated;
  if (problem.empty() && sample.sequence > 0 && sample.fade < 1.0) problem = kFading;
  if (problem.empty()) return {};
  return {false, settings_.port + ": " + problem};
}

int HapiDevice::descriptor() const noexcept {
  return session_ ? session_->descriptor() : -1;
}

void HapiDevice::set_guard(WriteGuard* guard) noexcept {
  if (session_) session_->set_guard(guard);
}

HapiCounts HapiDevice::counts() const {
  HapiCounts counts = last_counts_;
  if (session_) session_->read(counts);
  return counts;
}

std::string HapiDevice::summary() const {
  const HapiCounts counts = this->counts();
  std::ostringstream line;
  line << counts.messages << " messages, " << counts.answers << " answers, " << counts.missed
       << " missed, " << counts.late << " late, " << counts.malformed << " malformed, round trip ";
  if (counts.answers == 0) {
    line << "- (longest -)";
  } else {
    line << 1e-6 * static_cast<double>(counts.round_trip_median_ns) << " ms (longest "
         << 1e-6 * static_cast<double>(counts.round_trip_longest_ns) << " ms)";
  }
  return line.str();
}

}  // namespace palpate
