// The order of starting and ending a session on a device with motors, with a real guard. Each step
// of the start fails once.

#include "engine/session/guarded_run.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <functional>
#include <linux/capability.h>
#include <string>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/monotonic_clock.h"
#include "tests/helpers/made.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

// A device that stays at one position, whose port is a pipe. It refuses to start, or sends a signal
// to its guard, on request, and keeps what it is told.
class PipeDevice final : public GuardableDevice {
 public:
  PipeDevice() {
    EXPECT_EQ(::pipe2(pipe_.data(), O_NONBLOCK | O_CLOEXEC), 0);
    description_.name = "a device of a test";
    description_.motor_count = 3;
    for (std::size_t k = 0; k < 3; ++k) {
      description_.motors[k].direction_device = {};
      description_.motors[k].direction_device[k] = 1.0;
      description_.motors[k].peak_force_N = description_.motors[k].continuous_force_N = 3.0;
    }
    description_.workspace_low_m.fill(-1.0);
    description_.workspace_high_m.fill(1.0);
    description_.when_host_is_silent = HostSilence::kHoldsForce;
  }
  ~PipeDevice() override {
    for (const int end : pipe_) ::close(end);
  }
  const DeviceDescription& description() const noexcept override { return description_; }
  std::optional<std::string> start() override {
    calls.emplace_back("start");
    if (++starts_ == refused_start) return "the port of the test is missing";
    if (starts_ == 2 && signal_at_start != 0) send_to_guard(signal_at_start);
    return std::nullopt;
  }
  DeviceSample read(double) noexcept override {
    DeviceSample sample;
    sample.position_m = {0.0, 0.0, height_m};
    sample.sequence = ++sequence_;
    return sample;
  }
  void command(const DeviceCommand& command) noexcept override {
    for (const double force_N : command.force_N) has_pushed = has_pushed || force_N != 0.0;
    last_ = command;
  }
  void stop() noexcept override {
    calls.emplace_back(last_.force_N == std::array<double, 3>{} ? "stop at zero" : "stop");
  }
  int descriptor() const noexcept override { return has_port ? pipe_[1] : -1; }
  std::vector<std::uint8_t> zero_bytes() const override {
    return std::vector<std::uint8_t>(has_zero ? 1 : 0);
  }
  void set_guard(WriteGuard* guard) noexcept override {
    calls.emplace_back(guard != nullptr ? "guard" : "no guard");
    guard_ = dynamic_cast<MotorGuard*>(guard);
    if (guard_ != nullptr && signal_before_arming != 0) send_to_guard(signal_before_arming);
  }
  std::string summary() const override { return ""; }
  LineRate line_rate() const override { return line; }

  LineRate line;
  double height_m = 1.0;
  int refused_start = 0;  // 1: the first one
  bool has_port = true;
  bool has_zero = true;
  int signal_before_arming = 0;
  int signal_at_start = 0;  // of the session
  std::atomic<bool> has_pushed{false};
  std::vector<std::string> calls;  // not those of the haptic thread in a tick

  // A stopped guard is not waited for.
  void send_to_guard(int signal) {
    ::kill(guard_->process(), signal);
    while (signal == SIGKILL && guard_->is_alive())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  MotorGuard* guard_ = nullptr;
  DeviceDescription description_;
  std::array<int, 2> pipe_ = {-1, -1};
  int starts_ = 0;
  std::uint64_t sequence_ = 0;
  DeviceCommand last_ = {{1.0, 1.0, 1.0}};
};

struct GuardedRig {
  GuardedRig()
      : world(test::box_soup(Vec3::Constant(0.1))),
        loop(test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 3), {}))),
        session(loop, device) {
    settings.without_realtime = true;  // the tests run where SCHED_FIFO is refused as well
  }
  // The error of a start; empty if it succeeds.
  std::string problem() {
    run = std::make_unique<GuardedRun>(device, session, settings);
    const auto error = run->start();
    return error ? error->to_string() : "";
  }
  // A failed start has stopped the device at zero force, and ended the guard.
  void expect_undone() {
    EXPECT_FALSE(device.has_pushed);
    EXPECT_EQ(std::count(device.calls.begin(), device.calls.end(), "stop at zero"), 1);
    EXPECT_EQ(device.calls.back(), "stop at zero");
    EXPECT_EQ(run->guard(), nullptr);
    EXPECT_FALSE(run->thread().running());
    const std::size_t calls = device.calls.size();
    run.reset();
    EXPECT_EQ(device.calls.size(), calls);  // nothing was left to end
  }

  test::OwnedWorld world;
  HapticLoop loop;
  PipeDevice device;
  HapticSession session;
  GuardedRunSettings settings;
  std::unique_ptr<GuardedRun> run;
};

bool is_running(pid_t process) {
  return ::kill(process, 0) == 0;
}

TEST(GuardedRun, StartsInOrderAndEndsInReverseOrder) {
  GuardedRig rig;
  ASSERT_EQ(rig.problem(), "");
  ASSERT_NE(rig.run->guard(), nullptr);
  const pid_t guard = rig.run->guard()->process();
  EXPECT_TRUE(is_running(guard));
  while (rig.run->thread().ticks() < 10) std::this_thread::yield();
  rig.run->stop();
  EXPECT_EQ(rig.device.calls,
            (std::vector<std::string>{"start", "guard", "start", "stop at zero"}));
  EXPECT_FALSE(rig.run->thread().running());
  EXPECT_FALSE(is_running(guard));
  EXPECT_EQ(rig.run->guard(), nullptr);
  rig.run.reset();
  EXPECT_EQ(rig.device.calls.size(), 4u);
}

// The destructor ends a run as stop() does.
TEST(GuardedRun, EndsWhenItIsDestroyed) {
  GuardedRig rig;
  ASSERT_EQ(rig.problem(), "");
  const pid_t guard = rig.run->guard()->process();
  rig.run.reset();
  EXPECT_EQ(rig.device.calls.back(), "stop at zero");
  EXPECT_FALSE(is_running(guard));
}

TEST(GuardedRun, ADeviceThatRefusesEndsTheStart) {
  GuardedRig rig;
  rig.device.refused_start = 1;
  EXPECT_EQ(rig.problem(), "the port of the test is missing");
  EXPECT_EQ(rig.device.calls, (std::vector<std::string>{"start", "stop at zero"}));
  rig.expect_undone();
}

TEST(GuardedRun, AGuardThatCannotStartEndsTheStart) {
  GuardedRig without_zero;
  without_zero.device.has_zero = false;
  EXPECT_EQ(without_zero.problem().find("zero_bytes: is 0 bytes long"), 0u);
  without_zero.expect_undone();
  GuardedRig without_port;
  without_port.device.has_port = false;
  EXPECT_EQ(without_port.problem().find("descriptor: is not open"), 0u);
  without_port.expect_undone();
}

TEST(GuardedRun, AGuardThatEndsBeforeItIsArmedEndsTheStart) {
  GuardedRig rig;
  rig.device.signal_before_arming = SIGKILL;
  EXPECT_EQ(rig.problem().find("palpate-guard: has ended or does not answer"), 0u);
  EXPECT_EQ(rig.device.calls, (std::vector<std::string>{"start", "guard", "stop at zero"}));
  rig.expect_undone();
}

TEST(GuardedRun, AGuardThatIsFrozenBeforeItIsArmedEndsTheStart) {
  GuardedRig rig;
  rig.device.signal_before_arming = SIGSTOP;
  EXPECT_EQ(rig.problem().find("palpate-guard: is frozen: it does not run"), 0u);
  EXPECT_EQ(rig.device.calls, (std::vector<std::string>{"start", "guard", "stop at zero"}));
  rig.expect_undone();
}

// The device sees it, and asks for a trip (hapi_link_test.cpp). The end says how the guard ended.
TEST(GuardedRun, AGuardThatFailsLaterIsToldAtTheEnd) {
  for (const bool starts : {true, false}) {
    for (const int signal : {SIGKILL, SIGSTOP}) {
      GuardedRig rig;
      if (starts) rig.device.signal_at_start = signal;
      ASSERT_EQ(rig.problem(), "");
      const std::int64_t begin_ns = monotonic_ns();
      if (!starts) rig.device.send_to_guard(signal);
      const pid_t guard = rig.run->guard()->process();
      rig.run->stop();
      EXPECT_LT(monotonic_ns() - begin_ns, 5 * kSecond_ns);  // not its two waits, 7 s
      EXPECT_FALSE(is_running(guard));
      EXPECT_EQ(rig.device.calls.back(), "stop at zero");
      ASSERT_FALSE(rig.run->warnings().empty());
      const std::string expected =
          signal == SIGKILL ? "palpate-guard: has ended" : "palpate-guard: is frozen";
      EXPECT_EQ(rig.run->warnings().back().find(expected), 0u) << rig.run->warnings().back();
    }
  }
}

TEST(GuardedRun, ASessionThatCannotStartEndsTheStart) {
  GuardedRig rig;
  rig.device.refused_start = 2;
  EXPECT_EQ(rig.problem(), "the port of the test is missing");
  EXPECT_EQ(rig.device.calls,
            (std::vector<std::string>{"start", "guard", "start", "stop at zero"}));
  rig.expect_undone();
}

// Calls the function on a thread to which the system refuses SCHED_FIFO, also if it is root's.
void without_fifo(const std::function<void()>& function) {
  rlimit before{};
  getrlimit(RLIMIT_RTPRIO, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_RTPRIO, &none);
  std::thread thread([&] {
    // The capabilities of one thread.
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    std::array<__user_cap_data_struct, 2> held = {};
    ASSERT_EQ(::syscall(SYS_capget, &header, held.data()), 0);
    held[0].effective &= ~(1u << CAP_SYS_NICE);
    ASSERT_EQ(::syscall(SYS_capset, &header, held.data()), 0);
    function();
  });
  thread.join();
  setrlimit(RLIMIT_RTPRIO, &before);
}

TEST(GuardedRun, ADeviceThatKeepsItsForceNeedsRealTimeScheduling) {
  without_fifo([] {
    GuardedRig rig;
    rig.settings.without_realtime = false;
    const std::string problem = rig.problem();
    EXPECT_EQ(problem.find("a device of a test: keeps its last force, and the system refuses "
                           "SCHED_FIFO"),
              0u)
        << problem;
    EXPECT_NE(problem.find("write `* - rtprio 90` to /etc/security/limits.d/palpate.conf"),
              std::string::npos);
    EXPECT_EQ(rig.device.calls, (std::vector<std::string>{"start", "stop at zero"}));
    rig.expect_undone();
  });
}

TEST(GuardedRun, WithoutRealtimeStartsWhereSchedFifoIsRefused) {
  without_fifo([] {
    GuardedRig rig;
    EXPECT_EQ(rig.problem(), "");
    EXPECT_FALSE(rig.run->has_fifo());
    EXPECT_FALSE(rig.run->warnings().empty());
  });
}

// The device is open then, so that its line is measured, and has got no force.
TEST(GuardedRun, RefusesSlowTicksAndASlowLine) {
  GuardedRig ticks;
  ticks.settings.thread.rate_Hz = 249.0;
  EXPECT_EQ(ticks.problem().find("rate_Hz: is 249 Hz; expected at least 250"), 0u);
  EXPECT_EQ(ticks.device.calls, (std::vector<std::string>{"start", "stop at zero"}));
  ticks.expect_undone();
  GuardedRig line;
  line.device.line.asked_Hz = 1000.0;
  line.device.line.at_start_Hz = 200.0;
  EXPECT_EQ(line.problem().find("a device of a test: reaches only 200 of 1000 messages"), 0u);
  line.expect_undone();
}

TEST(GuardedRun, WarnsOfASlowLine) {
  GuardedRig rig;
  rig.device.line.asked_Hz = 1000.0;
  rig.device.line.at_start_Hz = 320.0;
  EXPECT_EQ(rig.problem(), "");
  const auto& warnings = rig.run->warnings();
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning == "the line to the device reaches only 320 of 1000 messages per second";
  }));
}

TEST(GuardedRun, WithoutAGuardItWarns) {
  GuardedRig rig;
  rig.settings.has_guard = false;
  EXPECT_EQ(rig.problem(), "");
  EXPECT_EQ(rig.run->guard(), nullptr);
  ASSERT_FALSE(rig.run->warnings().empty());
  EXPECT_EQ(rig.run->warnings().front().find("no process guards the motors"), 0u);
  rig.run->stop();
  EXPECT_EQ(rig.device.calls, (std::vector<std::string>{"start", "start", "stop at zero"}));
}

}  // namespace
}  // namespace palpate
