// An engine that drives a hAPI board through a guarded port and fails on request. Tests and the
// measurement of the guard start it.
//
// usage: guarded_engine PORT BEHAVIOUR
//
// PORT is a path, or the number of an inherited descriptor.
// It writes "guard PID FIFO" to stdout when the guard watches, then commands 0.5 on two motors at
// 1 kHz, with the priority of a haptic thread if it may. It rearms after a trip. Behaviours:
//   run        until it is killed
//   unarmed    starts the guard without arming it, and does not command
//   segv       accesses address 0 after 100 ms
//   throw      throws an exception that nobody catches, after 100 ms
//   exit       calls exit() after 100 ms
//   destroy    destroys the client of an armed guard after 100 ms, and lives on
//   end-thread its driver's thread ends after 100 ms
//   hang-tick  its ticks stop after 100 ms; its driver goes on writing
//   no-fifo    gives up its right to SCHED_FIFO; then as run
//   end        commands zero, disarms and ends in order after 100 ms
//   fork       like run, with a child process that keeps all descriptors; writes "child PID"
//   watch      like run, and writes "lost" when the guard is gone
//   watch-no-fifo  both
//   full       after 100 ms it queues commands until the port takes no more, writes "full", and
//   hangs

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <linux/capability.h>
#include <memory>
#include <sched.h>
#include <stdexcept>
#include <string>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "engine/devices/hapi_zero.h"
#include "engine/devices/monotonic_clock.h"
#include "engine/devices/motor_guard.h"
#include "tests/engine/devices/board_terminal.h"

namespace palpate {
namespace {

constexpr std::uint8_t kDevice = 1;
constexpr int kMotors = 2;
constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr std::int64_t kFaultNs = 100'000'000;  // after the start

void sleep_ns(std::int64_t ns) {
  const timespec time{ns / 1'000'000'000, ns % 1'000'000'000};
  nanosleep(&time, nullptr);
}

class Engine {
 public:
  Engine(int port, std::unique_ptr<MotorGuard> guard, std::string behaviour)
      : port_(port), guard_(std::move(guard)), behaviour_(std::move(behaviour)) {}

  int run() {
    set_up();
    if (behaviour_ != "unarmed") {
      if (auto problem = guard_->arm()) {
        std::fprintf(stderr, "%s\n", problem->to_string().c_str());
        return 2;
      }
    }
    std::printf("guard %d %d\n", guard_->process(), guard_->has_fifo() ? 1 : 0);
    std::fflush(stdout);
    if (behaviour_ == "fork") fork_child();
    const sched_param fifo{kGuardPriority - 1};
    sched_setscheduler(0, SCHED_FIFO, &fifo);
    const std::int64_t start_ns = monotonic_ns();
    for (std::int64_t due_ns = start_ns;; due_ns += kPeriodNs) {
      const std::int64_t now_ns = monotonic_ns();
      if (due_ns > now_ns) sleep_ns(due_ns - now_ns);
      if (behaviour_ != "unarmed") tick(monotonic_ns());
      if (now_ns > start_ns + kFaultNs && fail()) return 0;
    }
  }

 private:
  void send(const std::vector<std::uint8_t>& bytes) {
    [[maybe_unused]] const ssize_t ignored = ::write(port_, bytes.data(), bytes.size());
  }
  void set_up() {
    send(HostMessages::reset());
    send(HostMessages::set_up(kDevice, kMotors, kMotors, 0, 0));
  }
  void command(float torque) {
    send(HostMessages::tick(kDevice, 0, std::vector<float>(kMotors, torque)));
  }

  // A child that keeps the engine's descriptors until it is killed.
  static void fork_child() {
    const pid_t child = ::fork();
    while (child == 0) ::pause();
    std::printf("child %d\n", child);
    std::fflush(stdout);
  }

  // Looks at the epoch before each write, as a driver does.
  void tick(std::int64_t now_ns) {
    const std::uint64_t epoch = guard_->trip_epoch();
    if (epoch != epoch_ && guard_->is_quiet()) {
      set_up();
      guard_->beat(now_ns);
      guard_->acknowledge(epoch);
      epoch_ = epoch;
      zeros_ = 50;
    }
    if (behaviour_.starts_with("watch") && !guard_->is_alive() && !is_lost_) {
      is_lost_ = true;
      std::printf("lost\n");
      std::fflush(stdout);
    }
    const bool is_zero = epoch != epoch_ || zeros_ > 0 || is_lost_;
    if (zeros_ > 0) --zeros_;
    command(is_zero ? 0.0f : 0.5f);
    guard_->beat(has_hung_ ? hung_ns_ : now_ns);
    std::array<char, 512> answers;
    for (int n = 0; n < 32 && ::read(port_, answers.data(), answers.size()) > 0; ++n) {
    }
  }

  // Tells once when the fault is. Before it, a busy machine may have made the engine late, so that
  // the guard set zero and the engine rearmed.
  void tell_fault() {
    if (has_told_) return;
    has_told_ = true;
    std::printf("fault %lld\n", static_cast<long long>(monotonic_ns()));
    std::fflush(stdout);
  }

  // Returns whether the program ends.
  bool fail() {
    constexpr std::array kFaults = {"segv", "throw", "exit", "destroy", "hang-tick", "end-thread"};
    if (std::find(kFaults.begin(), kFaults.end(), behaviour_) != kFaults.end()) tell_fault();
    if (behaviour_ == "segv") *static_cast<volatile int*>(nothing_) = 1;
    if (behaviour_ == "throw") throw std::runtime_error("a fault that nobody handles");
    if (behaviour_ == "exit") std::exit(0);
    if (behaviour_ == "destroy") {
      guard_.reset();
      for (;;) ::pause();
    }
    if (behaviour_ == "end-thread") ::syscall(SYS_exit, 0);
    if (behaviour_ == "hang-tick" && !has_hung_) {
      has_hung_ = true;
      hung_ns_ = monotonic_ns();
    }
    if (behaviour_ == "full") {
      const auto message = HostMessages::tick(kDevice, 0, {0.5f, 0.5f});
      while (::write(port_, message.data(), message.size()) > 0) {
      }
      std::printf("full\n");
      std::fflush(stdout);
      for (;;) ::pause();
    }
    if (behaviour_ != "end") return false;
    command(0.0f);
    guard_->disarm();
    guard_.reset();
    return true;
  }

  int port_;
  std::unique_ptr<MotorGuard> guard_;
  std::string behaviour_;
  std::uint64_t epoch_ = 0;
  int zeros_ = 0;
  bool is_lost_ = false;
  bool has_told_ = false;
  bool has_hung_ = false;
  std::int64_t hung_ns_ = 0;
  void* volatile nothing_ = nullptr;
};

// From now on this process and its children get no SCHED_FIFO, not even those of root.
void give_up_realtime() {
  prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_RTPRIO, &none);
}

int run(const char* path, const std::string& behaviour) {
  if (behaviour.ends_with("no-fifo")) give_up_realtime();
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const bool is_number = path[0] >= '0' && path[0] <= '9';
  const int port = is_number ? std::atoi(path) : open_raw(path);
  if (port < 0) {
    std::fprintf(stderr, "%s: cannot be opened: %s\n", path, std::strerror(errno));
    return 2;
  }
  GuardSpec spec;
  spec.descriptor = port;
  spec.period_s = 1e-9 * static_cast<double>(kPeriodNs);
  HapiMotors motors;
  motors.device = kDevice;
  motors.ports = (1 << kMotors) - 1;
  motors.directions = {0, 1};  // as HostMessages
  spec.zero_bytes = hapi_zero_bytes(motors);
  auto guard = MotorGuard::spawn(spec);
  if (!guard) {
    std::fprintf(stderr, "%s\n", guard.error().to_string().c_str());
    return 2;
  }
  // A driver has a thread of its own.
  Engine engine(port, std::move(*guard), behaviour);
  int code = 0;
  std::thread driver([&] { code = engine.run(); });
  // A SIGSEGV from outside hits the driver's thread, as its own would.
  sigset_t own;
  sigemptyset(&own);
  sigaddset(&own, SIGSEGV);
  pthread_sigmask(SIG_BLOCK, &own, nullptr);
  driver.join();
  return code;
}

}  // namespace
}  // namespace palpate

int main(int count, char** arguments) {
  if (count != 3) {
    std::fprintf(stderr, "usage: guarded_engine PORT BEHAVIOUR\n");
    return 2;
  }
  return palpate::run(arguments[1], arguments[2]);
}
