#include "engine/drivers/rail_driver.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <numbers>
#include <optional>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sstream>
#include <stdlib.h>
#include <string_view>
#include <system_error>
#include <termios.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "engine/devices/light_device.h"
#include "engine/devices/monotonic_clock.h"
#include "engine/devices/serial_port.h"
#include "engine/devices/snapshot_ring.h"

// The rail sends the position of its handle, such as P0.01, and is sent the force of its motor,
// such as F-1.5: a letter and a decimal number in a line of its own, m and N. The rest of a line
// that was cut has no letter, and is therefore no force.

namespace palpate {
namespace {

struct RailSettings {
  std::string port;
  double travel_m = 0.2;
  double peak_N = 2.0;
  double rate_Hz = 1000.0;
  bool works_without_guard = false;
};

// Collects lines, and keeps the number of the last complete one that begins with the letter.
class LineNumber {
 public:
  explicit LineNumber(char letter) noexcept : letter_(letter) {}

  // Returns how many numbers were completed.
  int take(std::span<const std::uint8_t> bytes) noexcept {
    int completed = 0;
    for (const std::uint8_t byte : bytes) {
      if (byte == '\n') {
        if (const auto number = number_of({line_.data(), length_})) {
          value_ = *number;
          ++completed;
        }
        length_ = 0;
      } else {
        if (length_ == line_.size()) length_ = 0;  // no number is so long
        line_[length_++] = static_cast<char>(byte);
      }
    }
    return completed;
  }
  double value() const noexcept { return value_; }

 private:
  std::optional<double> number_of(std::string_view line) const noexcept {
    double number = 0.0;
    if (line.empty() || line.front() != letter_) return std::nullopt;
    line.remove_prefix(1);
    const char* const last = line.data() + line.size();
    const auto [end, failed] = std::from_chars(line.data(), last, number, std::chars_format::fixed);
    if (failed != std::errc() || end != last || !std::isfinite(number)) return std::nullopt;
    return number;
  }

  char letter_;
  std::array<char, 32> line_ = {};
  std::size_t length_ = 0;
  double value_ = 0.0;
};

// A letter and a number as a line, without an exponent.
struct Line {
  Line(char letter, double number) noexcept {
    bytes[0] = letter;
    const auto [end, failed] = std::to_chars(bytes.data() + 1, bytes.data() + bytes.size() - 1,
                                             number, std::chars_format::fixed, 9);
    *end = '\n';
    length = static_cast<std::size_t>(end + 1 - bytes.data());
  }
  std::array<char, 32> bytes = {};
  std::size_t length = 0;
};

DeviceDescription description_of(const RailSettings& settings) {
  DeviceDescription device;
  device.name = "rail";
  device.sensed_axes = 2;
  device.motor_count = 1;
  device.motors[0] = {{1.0, 0.0, 0.0}, settings.peak_N, settings.peak_N};
  device.peak_force_N = settings.peak_N;
  set_workspace_extent(device, settings.travel_m);
  device.rate_Hz = settings.rate_Hz;
  return device;
}

// What the haptic thread asks for, and the time of its tick.
struct RailForce {
  double force_N = 0.0;
  std::int64_t tick_ns = 0;
};

// What the driver's thread has seen and done.
struct RailState {
  double position_m = 0.0;
  std::uint64_t samples = 0;
  std::uint64_t commands = 0;
  bool is_connected = true;
  bool has_guard_stopped = false;
};

// One run of the driver's thread, which alone uses the port. A mailbox in each direction holds the
// newest value, so that the haptic thread never waits for the port.
class RailThread {
 public:
  RailThread(const RailSettings& settings, SerialPort port)
      : port_(std::move(port)),
        period_ns_(static_cast<std::int64_t>(1e9 / settings.rate_Hz)),
        works_without_guard_(settings.works_without_guard) {
    // Signals are for other threads.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([this] { run(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    // Where the system refuses this, GuardedRun refuses the device.
    const sched_param priority{kDriverPriority};
    pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
  }
  ~RailThread() { end(); }
  RailThread(const RailThread&) = delete;
  RailThread& operator=(const RailThread&) = delete;

  // Of the haptic thread: neither blocks.
  void command(const RailForce& force) noexcept { forces_.publish(force); }
  bool read(RailState& state) const noexcept { return states_.read(state); }

  // Of the owner's thread. Returns when the thread no longer uses the guard before.
  void set_guard(WriteGuard* guard) noexcept {
    guard_ = guard;
    while (used_guard_ != guard) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  int descriptor() const noexcept { return port_.descriptor(); }
  // Sends zero and ends the thread.
  void end() noexcept {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  static constexpr int kDriverPriority = 80;
  static constexpr std::int64_t kOldestForce_ns = 10'000'000;

  void run() noexcept {
    auto next = std::chrono::steady_clock::now();
    while (!ends_) {
      exchange();
      next =
          std::max(next + std::chrono::nanoseconds(period_ns_), std::chrono::steady_clock::now());
      std::this_thread::sleep_until(next);
    }
    send({});  // or the rest of a message
    send({});
    states_.publish(state_);
  }

  // Moves what can be moved, without waiting.
  void exchange() noexcept {
    WriteGuard* const guard = guard_;
    if (guard && guard != used_guard_) epoch_ = guard->trip_epoch();
    used_guard_ = guard;

    std::array<std::uint8_t, 1024> bytes;
    const auto count = port_.read(bytes);
    if (!count) state_.is_connected = false;
    state_.samples +=
        static_cast<std::uint64_t>(position_m_.take(std::span(bytes).first(count.value_or(0))));
    state_.position_m = position_m_.value();

    const std::int64_t now_ns = monotonic_ns();
    // This driver stays at zero after a trip of its guard; the session ends.
    if (guard && (guard->trip_epoch() != epoch_ || !guard->is_alive(now_ns))) {
      state_.has_guard_stopped = true;
    }
    RailForce force;
    forces_.read(force);
    const bool is_recent = now_ns - force.tick_ns < std::max(kOldestForce_ns, 5 * period_ns_);
    const bool may_push = is_recent && !state_.has_guard_stopped && (guard || works_without_guard_);
    if (!may_push) force.force_N = 0.0;
    if (force.tick_ns == 0) force.tick_ns = now_ns;  // before the first tick, no force can be old
    if (send(force) && guard) guard->beat(sent_tick_ns_, now_ns);
    states_.publish(state_);
  }

  // Sends a message, or the rest of one that was cut. A message of which nothing was sent is
  // replaced: its force may be old. Whether the port has then taken all of it.
  bool send(const RailForce& force) noexcept {
    if (sent_ == line_.length || sent_ == 0) {
      line_ = Line('F', force.force_N);
      sent_tick_ns_ = force.tick_ns;
      sent_ = 0;
    }
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(line_.bytes.data());
    const auto written = port_.write(std::span(bytes, line_.length).subspan(sent_));
    if (!written) state_.is_connected = false;
    sent_ += written.value_or(0);
    const bool is_whole = sent_ == line_.length;
    state_.commands += is_whole;
    return is_whole;
  }

  SerialPort port_;
  std::int64_t period_ns_;
  bool works_without_guard_;
  LineNumber position_m_{'P'};
  Line line_{'F', 0.0};
  std::size_t sent_ = line_.length;
  std::int64_t sent_tick_ns_ = 0;  // the tick of the line
  RailState state_;
  std::uint64_t epoch_ = 0;
  SnapshotRing<RailForce> forces_;
  SnapshotRing<RailState> states_;
  std::atomic<WriteGuard*> guard_{nullptr};
  std::atomic<WriteGuard*> used_guard_{nullptr};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

class RailDevice final : public GuardableDevice {
 public:
  explicit RailDevice(RailSettings settings)
      : settings_(std::move(settings)), description_(description_of(settings_)) {}
  ~RailDevice() override { stop(); }

  const DeviceDescription& description() const noexcept override { return description_; }
  std::optional<std::string> start() override {
    if (thread_) return std::nullopt;
    auto port = SerialPort::open(settings_.port);
    if (!port) return port.error().to_string();
    sample_ = {};
    thread_ = std::make_unique<RailThread>(settings_, std::move(*port));
    for (int n = 0; n < kMostWaits; ++n) {
      if (thread_->read(sample_) && sample_.samples > 0) return std::nullopt;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    stop();
    return settings_.port + ": sends no position; expected a rail (check its power)";
  }
  DeviceSample read(double) noexcept override {
    if (thread_) thread_->read(sample_);
    return {.position_m = {sample_.position_m, 0.0, 0.0},
            .sequence = sample_.samples,
            .is_valid = sample_.samples > 0,
            .asks_for_trip = !sample_.is_connected || sample_.has_guard_stopped};
  }
  void command(const DeviceCommand& command) noexcept override {
    if (thread_) thread_->command({command.force_N[0], monotonic_ns()});
  }
  void stop() noexcept override {
    if (!thread_) return;
    thread_->end();
    thread_->read(last_);
    thread_.reset();
  }
  DeviceHealth health() const override {
    const RailState state = newest();
    if (state.has_guard_stopped) return {false, "the guard has stopped the motor (start again)"};
    if (!state.is_connected) return {false, "the port was disconnected (connect the rail)"};
    return {};
  }

  int descriptor() const noexcept override { return thread_ ? thread_->descriptor() : -1; }
  // The first byte ends a line that was cut: a part of a number without exponent is not larger.
  std::vector<std::uint8_t> zero_bytes() const override { return {'\n', 'F', '0', '\n'}; }
  void set_guard(WriteGuard* guard) noexcept override {
    if (thread_) thread_->set_guard(guard);
  }
  std::string summary() const override {
    const RailState state = newest();
    return std::to_string(state.samples) + " positions, " + std::to_string(state.commands) +
           " commands";
  }

 private:
  static constexpr int kMostWaits = 2000;  // of a millisecond, until the first position

  RailState newest() const {
    RailState state = last_;
    if (thread_) thread_->read(state);
    return state;
  }

  RailSettings settings_;
  DeviceDescription description_;
  RailState sample_;  // the last one of the haptic thread
  RailState last_;    // of the last session
  std::unique_ptr<RailThread> thread_;
};

struct RailKey {
  DriverKey key;
  double RailSettings::*member;
};

std::vector<RailKey> number_keys() {
  const RailSettings initial;
  return {{{"travel", "length of the rail, m", DriverKeyKind::kReal, 0.05, 1.0, initial.travel_m},
           &RailSettings::travel_m},
          {{"peak", "the largest force of the motor, N", DriverKeyKind::kReal, 0.1, 20.0,
            initial.peak_N},
           &RailSettings::peak_N},
          {{"rate", "positions per second", DriverKeyKind::kWhole, 100.0, 2000.0, initial.rate_Hz},
           &RailSettings::rate_Hz}};
}

std::vector<DriverKey> rail_keys() {
  std::vector<DriverKey> keys{{"port", "the serial port; required", DriverKeyKind::kText}};
  for (const RailKey& number : number_keys()) keys.push_back(number.key);
  return keys;
}

Result<std::unique_ptr<GuardableDevice>> make_rail(const DriverValues& values,
                                                   bool works_without_guard) {
  RailSettings settings;
  settings.port = values.text("port").value_or("");
  if (settings.port.empty()) return invalid_argument("port", "is missing; expected port=FILE");
  for (const auto& [key, member] : number_keys()) {
    const double number = values.number(key.name).value_or(settings.*member);
    if (number < key.least || number > key.most) {
      std::ostringstream text;
      text << "is " << number << "; expected a number from " << key.least << " to " << key.most;
      return invalid_argument(std::string(key.name), text.str());
    }
    settings.*member = number;
  }
  settings.works_without_guard = works_without_guard;
  return std::unique_ptr<GuardableDevice>(std::make_unique<RailDevice>(settings));
}

DeviceDescription describe_rail() {
  return description_of({});
}

// A rail whose handle moves to and fro, behind a pseudo-terminal.
class SimulatedRail final : public SimulatedHardware {
 public:
  static constexpr double kAmplitude_m = 0.01;
  static constexpr double kPeriod_s = 2.0;

  SimulatedRail(int terminal, std::string path)
      : terminal_(terminal), path_(std::move(path)), thread_([this] { run(); }) {}
  ~SimulatedRail() override {
    ends_ = true;
    thread_.join();
    ::close(terminal_);
  }
  std::string place() const override { return "a simulated rail at " + path_; }
  std::string summary() const override {
    return std::to_string(commands_.load()) + " commands, the last " +
           std::to_string(last_N_.load()) + " N";
  }

 private:
  void run() {
    const std::int64_t start_ns = monotonic_ns();
    LineNumber force_N('F');
    while (!ends_) {
      std::array<std::uint8_t, 1024> bytes;
      const auto count = std::max<ssize_t>(0, ::read(terminal_, bytes.data(), bytes.size()));
      commands_ += force_N.take(std::span(bytes).first(static_cast<std::size_t>(count)));
      last_N_ = force_N.value();
      const double time_s = 1e-9 * static_cast<double>(monotonic_ns() - start_ns);
      const Line line('P', kAmplitude_m * std::sin(2.0 * std::numbers::pi * time_s / kPeriod_s));
      // While nobody reads, the terminal is full, and the position is lost.
      [[maybe_unused]] const auto written = ::write(terminal_, line.bytes.data(), line.length);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  int terminal_;
  std::string path_;
  std::atomic<bool> ends_{false};
  std::atomic<int> commands_{0};
  std::atomic<double> last_N_{0.0};
  std::thread thread_;
};

// Without this, the terminal would echo the positions.
bool make_raw(const char* path) {
  const int descriptor = ::open(path, O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) return false;
  termios mode{};
  bool is_raw = ::tcgetattr(descriptor, &mode) == 0;
  ::cfmakeraw(&mode);
  is_raw = is_raw && ::tcsetattr(descriptor, TCSANOW, &mode) == 0;
  ::close(descriptor);
  return is_raw;
}

Result<std::unique_ptr<SimulatedHardware>> simulate_rail() {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  std::array<char, 128> path{};
  if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0 ||
      ::ptsname_r(terminal, path.data(), path.size()) != 0 || !make_raw(path.data())) {
    if (terminal >= 0) ::close(terminal);
    return Error{ErrorCode::kFileUnreadable, "/dev/ptmx", "", "cannot make a pseudo-terminal", ""};
  }
  return std::unique_ptr<SimulatedHardware>(std::make_unique<SimulatedRail>(terminal, path.data()));
}

}  // namespace

const Driver kRailDriver{"rail",
                         "handle on a rail, made up for a test: 2 sensors, 1 motor",
                         "port=/dev/ttyUSB0",
                         rail_keys,
                         describe_rail,
                         make_rail,
                         simulate_rail};

}  // namespace palpate
