#include "engine/drivers/rail_driver.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <numbers>
#include <sstream>
#include <stdlib.h>
#include <system_error>
#include <termios.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "engine/devices/light_device.h"
#include "engine/devices/monotonic_clock.h"
#include "engine/devices/serial_port.h"

// The rail sends the position of its handle and is sent the force of its motor, each as a decimal
// number in a line of its own, m and N.

namespace palpate {
namespace {

struct RailSettings {
  std::string port;
  double travel_m = 0.2;
  double peak_N = 2.0;
  double rate_Hz = 1000.0;
  bool works_without_guard = false;
};

// Collects lines, and keeps the number of the last complete one.
class LineNumber {
 public:
  // Returns how many numbers were completed.
  int take(std::span<const std::uint8_t> bytes) noexcept {
    int completed = 0;
    for (const std::uint8_t byte : bytes) {
      if (byte == '\n') {
        double number = 0.0;
        const auto [end, failed] = std::from_chars(line_.data(), line_.data() + length_, number);
        if (failed == std::errc() && end == line_.data() + length_ && std::isfinite(number)) {
          value_ = number;
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
  std::array<char, 32> line_ = {};
  std::size_t length_ = 0;
  double value_ = 0.0;
};

// A number as a line.
struct Line {
  explicit Line(double number) noexcept {
    const auto [end, failed] = std::to_chars(bytes.data(), bytes.data() + bytes.size() - 1, number);
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

// For a test only: it reads and writes its port in the tick. A real driver has a thread for that.
class RailDevice final : public GuardableDevice {
 public:
  explicit RailDevice(RailSettings settings)
      : settings_(std::move(settings)), description_(description_of(settings_)) {}

  const DeviceDescription& description() const noexcept override { return description_; }
  std::optional<std::string> start() override {
    if (port_) return std::nullopt;
    auto port = SerialPort::open(settings_.port);
    if (!port) return port.error().to_string();
    port_.emplace(std::move(*port));
    return std::nullopt;
  }
  DeviceSample read(double) noexcept override {
    std::array<std::uint8_t, 1024> bytes;
    const auto count = port_ ? port_->read(bytes) : std::nullopt;
    is_connected_ = count.has_value();
    samples_ +=
        static_cast<std::uint64_t>(position_m_.take(std::span(bytes).first(count.value_or(0))));
    return {.position_m = {position_m_.value(), 0.0, 0.0},
            .sequence = samples_,
            .is_valid = samples_ > 0,
            .asks_for_trip = !is_connected_ || has_guard_stopped_};
  }
  void command(const DeviceCommand& command) noexcept override {
    WriteGuard* const guard = guard_;
    const std::int64_t now_ns = monotonic_ns();
    if (guard) {
      has_guard_stopped_ = guard->trip_epoch() != epoch_ || !guard->is_alive(now_ns);
    }
    const bool may_push = guard ? !has_guard_stopped_ : settings_.works_without_guard;
    const Line line(may_push ? command.force_N[0] : 0.0);
    if (!port_) return;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(line.bytes.data());
    const auto written = port_->write(std::span(bytes, line.length));
    if (written == line.length) {
      ++commands_;
      if (guard) guard->beat(now_ns, monotonic_ns());
    }
  }
  void stop() noexcept override { port_.reset(); }
  DeviceHealth health() const override {
    if (has_guard_stopped_) return {false, "the guard has stopped the motor (start again)"};
    if (!is_connected_) return {false, "the port was disconnected (connect the rail)"};
    return {};
  }

  int descriptor() const noexcept override { return port_ ? port_->descriptor() : -1; }
  std::vector<std::uint8_t> zero_bytes() const override { return {'\n', '0', '\n'}; }
  void set_guard(WriteGuard* guard) noexcept override {
    if (guard) epoch_ = guard->trip_epoch();
    guard_ = guard;
  }
  std::string summary() const override {
    return std::to_string(samples_) + " positions, " + std::to_string(commands_) + " commands";
  }

 private:
  RailSettings settings_;
  DeviceDescription description_;
  std::optional<SerialPort> port_;
  LineNumber position_m_;
  std::uint64_t samples_ = 0;
  std::uint64_t commands_ = 0;
  std::uint64_t epoch_ = 0;
  std::atomic<WriteGuard*> guard_{nullptr};
  std::atomic<bool> has_guard_stopped_{false};
  std::atomic<bool> is_connected_{true};
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
    LineNumber force_N;
    while (!ends_) {
      std::array<std::uint8_t, 1024> bytes;
      const auto count = std::max<ssize_t>(0, ::read(terminal_, bytes.data(), bytes.size()));
      commands_ += force_N.take(std::span(bytes).first(static_cast<std::size_t>(count)));
      last_N_ = force_N.value();
      const double time_s = 1e-9 * static_cast<double>(monotonic_ns() - start_ns);
      const Line line(kAmplitude_m * std::sin(2.0 * std::numbers::pi * time_s / kPeriod_s));
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
