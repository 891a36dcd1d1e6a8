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

#include "engine/devices/monotonic_clock.h"
#include "engine/devices/serial_port.h"
#include "engine/devices/snapshot_ring.h"
#include "haptics/haptic_loop.h"

namespace palpate {
namespace {

using Milliseconds = std::chrono::milliseconds;

// Scheduled as the haptic thread is (haptic_thread.cpp). Where the system refuses this, it refuses
// it for the haptic thread as well, which reports it.
constexpr int kDriverPriority = 80;
constexpr std::int64_t kLongestSleep_ns = 5'000'000;
constexpr std::int64_t kShortestSleep_ns = 10'000;  // so that other threads can always run
constexpr auto kLongestStart = Milliseconds(static_cast<int>(1e3 * HapiDevice::kAnswerToStart_s));
constexpr auto kMeasurement = Milliseconds(static_cast<int>(1e3 * HapiDevice::kMeasurement_s));
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
    case HapiProblem::kGuardFrozen:
      return "the guard of the motors is frozen: it has not run for half a second (let "
             "palpate-guard run again, by `kill -CONT` or by the debugger that holds it)";
    case HapiProblem::kSuspended:
      return "the machine was suspended, and the guard has stopped the motors (keep it awake "
             "during "
             "a session, for example by systemd-inhibit, and start again)";
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
  // The exchanges so far.
  std::size_t exchanges() const noexcept { return exchanges_; }
  // Ends the measurement. Later forces count as delayed if they are later than it shows.
  HapiLine end_measurement() noexcept {
    ends_measurement_ = true;
    while (!has_line_) std::this_thread::sleep_for(Milliseconds(1));
    return line_;
  }

 private:
  void run();
  void measure();
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
  std::atomic<std::size_t> exchanges_{0};
  std::atomic<bool> ends_measurement_{false};
  std::atomic<bool> has_line_{false};
  HapiLine line_;  // with has_line_
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

void HapiDevice::Session::run() {
  link_.start(steady_now_ns());
  while (!ends_) {
    exchange();
    publish();
    measure();
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

void HapiDevice::Session::measure() {
  if (has_line_) return;
  exchanges_ = link_.exchanges().count();
  if (!ends_measurement_) return;
  line_ = link_.exchanges().line();
  if (line_.delay.is_known()) {
    link_.set_longest_delay(static_cast<std::int64_t>(line_.delay.most_s * kSecond_ns));
  }
  has_line_ = true;
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
  if (session_) {  // what happened before the session is not its own
    session_->read(sample_);
    view_.forget_trips(sample_);
    return std::nullopt;
  }
  auto problem = open();
  if (!problem) problem = wait_for_answer();
  if (!problem) problem = measure_line();
  if (problem) stop();
  return problem;
}

std::optional<std::string> HapiDevice::open() {
  if (const auto error = check_hapi_settings(settings_)) return error->to_string();
  auto port = SerialPort::open(settings_.port);
  if (!port) return port.error().to_string();
  view_ = HapiView(settings_);
  sample_ = HapiSample{};
  line_ = HapiLine{};
  tick_ns_ = 0;
  session_ = std::make_unique<Session>(settings_, std::move(*port));
  return std::nullopt;
}

std::optional<std::string> HapiDevice::wait_for_answer() {
  const auto end = std::chrono::steady_clock::now() + kLongestStart;
  HapiSample sample;
  while (std::chrono::steady_clock::now() < end) {
    if (session_->read(sample) && sample.is_working) {
      sample_ = sample;
      return std::nullopt;
    }
    if (sample.problem == HapiProblem::kHungUp) break;
    std::this_thread::sleep_for(Milliseconds(1));
  }
  Error error = {ErrorCode::kFileUnreadable, settings_.port, "",
                 "nobody answers within 2 s; expected a hAPI board",
                 "check the board's power and its firmware, and that no other port is its own"};
  return error.to_string();
}

// No tick has commanded a force yet, so that the messages command zero.
std::optional<std::string> HapiDevice::measure_line() {
  const auto start = std::chrono::steady_clock::now();
  const auto is_over = [&] {
    const auto time = std::chrono::steady_clock::now() - start;
    const std::size_t exchanges = session_->exchanges();
    session_->read(sample_);
    return sample_.problem == HapiProblem::kHungUp || exchanges >= HapiDelay::kMost ||
           time >= kLongestStart || (time >= kMeasurement && exchanges >= HapiDelay::kFewest);
  };
  while (!is_over()) std::this_thread::sleep_for(Milliseconds(1));
  line_ = session_->end_measurement();
  view_.set_delay(line_.delay);
  session_->read(sample_);
  if (line_.delay.is_known() || !settings_.torque_per_Nm) return std::nullopt;
  std::ostringstream problem;
  problem << "has answered only " << session_->exchanges()
          << " messages within 2 s; expected at least " << HapiDelay::kFewest
          << ", from which the delay of its forces follows";
  return Error{ErrorCode::kFileUnreadable, settings_.port, "", problem.str(),
               "check the cable and other users of the board"}
      .to_string();
}

DeviceSample HapiDevice::read(double dt_s) noexcept {
  if (is_time_step(dt_s)) tick_ns_ = static_cast<std::int64_t>(dt_s * kSecond_ns);
  if (session_) session_->read(sample_);
  return view_.take(sample_);
}

void HapiDevice::command(const DeviceCommand& command) noexcept {
  if (!session_) return;
  session_->command(
      {{command.force_N[0], command.force_N[1]}, steady_now_ns(), tick_ns_, sample_.time_ns});
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

LineRate HapiDevice::line_rate() const {
  const HapiCounts counts = this->counts();
  const auto seconds = [](std::int64_t time_ns) { return 1e-9 * static_cast<double>(time_ns); };
  LineRate rate;
  rate.asked_Hz = settings_.rate_Hz;
  rate.at_start_Hz = line_.rate_Hz;
  if (counts.messages > 1) {
    rate.in_session_Hz = static_cast<double>(counts.messages - 1) /
                         seconds(std::max<std::int64_t>(1, counts.messages_ns));
  }
  rate.slowest_Hz = static_cast<double>(counts.fewest_in_second);
  rate.delay = {seconds(counts.delay_median_ns), seconds(counts.delay_longest_ns)};
  if (counts.forces > 0) {
    rate.delayed_share =
        static_cast<double>(counts.delayed_forces) / static_cast<double>(counts.forces);
  }
  return rate;
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
