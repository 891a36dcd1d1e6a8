// The road of a tick, and how it ends.

#include "engine/session/haptic_session.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <sys/mman.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/path_device.h"
#include "engine/session/haptic_thread.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/made.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kTick_s;

constexpr double kHalf_m = 0.1;

// The calls that a device received, in memory that a child process shares with its parent.
struct Log {
  std::atomic<int> starts{0};
  std::atomic<int> stops{0};
  std::atomic<int> commands{0};
  std::atomic<int> commands_at_stop{0};
  std::atomic<double> last_N{0.0};
  std::atomic<double> largest_N{0.0};
};

class SharedLog {
 public:
  SharedLog() {
    void* memory =
        ::mmap(nullptr, sizeof(Log), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
    log_ = new (memory) Log;
  }
  ~SharedLog() { ::munmap(log_, sizeof(Log)); }
  SharedLog(const SharedLog&) = delete;
  SharedLog& operator=(const SharedLog&) = delete;
  Log& operator*() const { return *log_; }
  Log* operator->() const { return log_; }

 private:
  Log* log_;
};

// A hand that keeps pressing into the top of a box: every command of a tick is some newtons.
class LoggingDevice final : public Device {
 public:
  explicit LoggingDevice(Log& log) : log_(log) {
    description_.name = "logging";
    description_.moves_motors = false;
  }
  const DeviceDescription& description() const noexcept override { return description_; }
  std::optional<std::string> start() override {
    ++log_.starts;
    if (throws_at_start) throw std::runtime_error("no such device");
    if (refuses) return "the cable is not connected: connect it";
    return std::nullopt;
  }
  DeviceSample read(double) noexcept override {
    DeviceSample sample;
    sample.position_m = {0.0, 0.0, ++samples_ == 1 ? kHalf_m + 0.01 : kHalf_m - 0.003};
    sample.sequence = samples_;
    sample.is_valid = samples_ != invalid_sample;
    return sample;
  }
  void command(const DeviceCommand& command) noexcept override {
    const double force_N = Vec3(command.force_N.data()).norm();
    log_.last_N = force_N;
    log_.largest_N = std::max(log_.largest_N.load(), force_N);
    ++log_.commands;
  }
  void stop() noexcept override {
    ++log_.stops;
    log_.commands_at_stop = log_.commands.load();
  }

  bool refuses = false;
  bool throws_at_start = false;
  std::uint64_t invalid_sample = 0;

 private:
  Log& log_;
  std::uint64_t samples_ = 0;
  DeviceDescription description_;
};

struct SessionRig {
  explicit SessionRig(Log& log, SessionParts parts = {})
      : world(test::box_soup(Vec3::Constant(kHalf_m))),
        loop(test::made(
            HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 3), settings()))),
        device(log),
        session(loop, device, std::move(parts)) {}
  static HapticSettings settings() {
    HapticSettings s;
    s.a4.enabled = false;
    return s;
  }
  void run(int ticks) {
    for (int n = 0; n < ticks; ++n) session.tick(kTick_s);
  }

  test::OwnedWorld world;
  HapticLoop loop;
  LoggingDevice device;
  HapticSession session;
};

class CallLogger final : public TickObserver {
 public:
  explicit CallLogger(std::vector<std::string>& calls, std::string name)
      : calls_(calls), name_(std::move(name)) {}
  void on_tick(const TickRecord& record) noexcept override {
    calls_.push_back(name_);
    last = record;
  }
  TickRecord last;

 private:
  std::vector<std::string>& calls_;
  std::string name_;
};

class Changer final : public BeforeTick {
 public:
  explicit Changer(std::vector<std::string>& calls) : calls_(calls) {}
  void before_tick(double, LoopChanges) noexcept override { calls_.push_back("change"); }

 private:
  std::vector<std::string>& calls_;
};

TEST(HapticSession, GoesTheRoadInItsOrder) {
  std::vector<std::string> calls;
  Changer change(calls);
  CallLogger first(calls, "first");
  CallLogger second(calls, "second");
  SharedLog log;
  SessionRig rig(*log, {.changes = {&change}, .observers = {&first, &second}});
  ASSERT_FALSE(rig.session.start());
  rig.run(3);
  const std::vector<std::string> once{"change", "first", "second"};
  std::vector<std::string> expected;
  for (int n = 0; n < 3; ++n) expected.insert(expected.end(), once.begin(), once.end());
  EXPECT_EQ(calls, expected);
  EXPECT_EQ(first.last.tick, 2u);
  EXPECT_GT(first.last.step_ns, 0);
  EXPECT_EQ(first.last.late_ns, 0);
  rig.session.tick(kTick_s, 1234);
  EXPECT_EQ(second.last.late_ns, 1234);
  TickRecord latest;
  ASSERT_TRUE(rig.session.latest(latest));
  EXPECT_EQ(std::memcmp(&latest, &second.last, sizeof latest), 0);
  EXPECT_EQ(log->last_N, vec3(latest.force_device_N).norm());
  EXPECT_GT(log->last_N, 1.0);
}

// A device whose motors turn with it, and whose hand does what the test says.
class MotorDevice final : public Device {
 public:
  MotorDevice() {
    description_.name = "motors";
    description_.motor_count = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      description_.motors[i].direction_device = {};
      description_.motors[i].direction_device[i] = 1.0;
    }
    description_.peak_force_N = 10.0;
  }
  const DeviceDescription& description() const noexcept override { return description_; }
  DeviceSample read(double) noexcept override {
    DeviceSample sample;
    sample.position_m = {0.0, 0.0, height_m};
    sample.sequence = ++samples_;
    sample.asks_for_trip = asks_for_trip;
    return sample;
  }
  void command(const DeviceCommand& command) noexcept override {
    force_N = Vec3(command.force_N.data());
  }
  std::span<const MotorDescription> motors_now() const noexcept override { return motors; }

  double height_m = kHalf_m + 1e-3;
  bool asks_for_trip = false;
  std::vector<MotorDescription> motors;
  Vec3 force_N = Vec3::Zero();

 private:
  std::uint64_t samples_ = 0;
  DeviceDescription description_;
};

class TripLogger final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override { last_tick = record.tick; }
  void on_trip(const GovernorTrip& trip) noexcept override {
    ++trips;
    last = trip;
    last_tick_before = last_tick;
  }
  int trips = 0;
  GovernorTrip last;
  std::uint64_t last_tick = 0, last_tick_before = 0;
};

struct MotorRig {
  explicit MotorRig(SessionParts parts = {})
      : world(test::box_soup(Vec3::Constant(kHalf_m))),
        loop(test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 3),
                                           SessionRig::settings()))),
        session(loop, device, with(std::move(parts), trips)) {
    session.start();
  }
  static SessionParts with(SessionParts parts, TickObserver& observer) {
    parts.observers.push_back(&observer);
    return parts;
  }
  void run(int ticks) {
    for (int n = 0; n < ticks; ++n) session.tick(kTick_s);
  }
  void press(double depth_m) {  // slowly
    for (; device.height_m > kHalf_m - depth_m; device.height_m -= 1e-5) session.tick(kTick_s);
  }

  test::OwnedWorld world;
  HapticLoop loop;
  MotorDevice device;
  TripLogger trips;
  HapticSession session;
};

TEST(HapticSession, StartsTheMotorsOnlyWithACalmHandAndThenGivesTheForceOfTheLoop) {
  MotorRig pressing;
  pressing.device.height_m = kHalf_m - 2e-3;  // 2 N at once
  pressing.run(1000);
  EXPECT_EQ(pressing.device.force_N, Vec3(Vec3::Zero()));
  MotorRig rig;
  rig.run(700);
  rig.press(2e-3);
  TickRecord record;
  ASSERT_TRUE(rig.session.latest(record));
  EXPECT_GT(record.full_force_device_N[2], 1.9);
  EXPECT_EQ(rig.device.force_N, vec3(record.full_force_device_N));
  EXPECT_EQ(record.faults, kFaultNone);
  EXPECT_EQ(record.rules, 0u);
}

TEST(HapticSession, LimitsTheForceToTheUsersLimit) {
  MotorRig rig({.max_force_N = 1.0});
  rig.run(700);
  rig.press(2e-3);
  EXPECT_NEAR(rig.device.force_N.z(), 1.0, 1e-12);
  EXPECT_LE(rig.device.force_N.norm(), 1.0);
}

TEST(HapticSession, ReportsATripToObserversAndToOtherThreadsAndRearms) {
  MotorRig rig;
  rig.run(700);
  rig.press(2e-3);
  rig.device.asks_for_trip = true;
  rig.run(1);
  EXPECT_EQ(rig.device.force_N, Vec3(Vec3::Zero()));
  rig.device.asks_for_trip = false;
  rig.run(100);
  EXPECT_EQ(rig.trips.trips, 1);
  EXPECT_EQ(rig.trips.last.reason, TripReason::kDevice);
  EXPECT_EQ(rig.trips.last.tick, rig.trips.last_tick_before + 1) << "before the tick's record";
  EXPECT_GT(rig.trips.last.wanted_N[2], 1.9);
  GovernorStatus status;
  ASSERT_TRUE(rig.session.latest(status));
  EXPECT_EQ(status.state, GovernorState::kTripped);
  EXPECT_EQ(status.trips, 1u);
  rig.session.rearm();
  rig.device.height_m = kHalf_m + 1e-3;
  rig.run(700);
  rig.press(2e-3);
  EXPECT_GT(rig.device.force_N.z(), 1.9);
}

TEST(HapticSession, StartsTheMotorsAgainAfterAPause) {
  MotorRig rig;
  rig.run(700);
  rig.press(2e-3);
  ASSERT_GT(rig.device.force_N.z(), 1.9);
  rig.session.set_paused(true);
  rig.run(10);
  EXPECT_EQ(rig.device.force_N, Vec3(Vec3::Zero()));
  rig.session.set_paused(false);
  rig.run(1000);  // the hand presses, so it is not calm
  EXPECT_EQ(rig.device.force_N, Vec3(Vec3::Zero()));
  rig.device.height_m = kHalf_m + 1e-3;
  rig.run(700);
  rig.press(2e-3);
  EXPECT_GT(rig.device.force_N.z(), 1.9);
}

TEST(HapticSession, TakesTheMotorsOfADeviceThatTurnsThem) {
  for (const bool takes : {true, false}) {
    MotorRig rig({.takes_motors = takes});
    const Vec3 direction = Vec3(0.6, 0.0, 0.8);
    rig.device.motors = {{{0.6, 0.0, 0.8}, 5.0, 1.0}};
    rig.run(700);
    rig.press(2e-3);
    TickRecord record;
    ASSERT_TRUE(rig.session.latest(record));
    const Vec3 full_N = vec3(record.full_force_device_N);
    EXPECT_LE((rig.device.force_N - direction.dot(full_N) * direction).norm(), 1e-12);
    // The loop that keeps its three axes leaves the rest to the governor.
    EXPECT_EQ((record.rules & kRuleMotors) != 0, !takes);
    EXPECT_NEAR(record.alpha_rad, takes ? std::acos(0.8) : 0.0, 1e-12);
  }
}

TEST(HapticSession, GivesNoForceForASampleThatTheDeviceCallsInvalid) {
  SharedLog log;
  SessionRig rig(*log);
  rig.device.invalid_sample = 3;
  rig.session.start();
  rig.run(2);
  TickRecord before;
  ASSERT_TRUE(rig.session.latest(before));
  ASSERT_GT(log->last_N, 1.0);
  rig.run(1);
  TickRecord record;
  ASSERT_TRUE(rig.session.latest(record));
  EXPECT_EQ(record.faults, kFaultInvalidSample);
  EXPECT_EQ(log->last_N, 0.0);
  EXPECT_EQ(vec3(record.proxy_scene_m), vec3(before.proxy_scene_m));
  rig.run(1);
  EXPECT_GT(log->last_N, 1.0) << "the next good sample carries on";
}

TEST(HapticSession, DoesNothingBeforeItsStartAndAfterItsStop) {
  SharedLog log;
  SessionRig rig(*log);
  rig.run(5);
  rig.session.stop();
  TickRecord record;
  EXPECT_FALSE(rig.session.latest(record));
  EXPECT_EQ(log->commands, 0);
  EXPECT_EQ(log->stops, 0) << "what was not started is not stopped";
  rig.session.start();
  rig.run(2);
  rig.session.stop();
  const int commands = log->commands;
  rig.run(5);
  EXPECT_EQ(log->commands, commands);
  EXPECT_EQ(log->last_N, 0.0);
}

TEST(PathDevice, IsInvalidBeyondItsEnd) {
  const std::vector<Vec3> path{{1, 2, 3}};
  PathDevice device(path);
  EXPECT_TRUE(device.read(kTick_s).is_valid);
  EXPECT_FALSE(device.read(kTick_s).is_valid);
}

// ---- ways out ----------------------------------------------------------------------------------

// One way in which a session or its process ends while the device pushes.
struct WayOut {
  const char* name;
  std::function<void(Log&)> go;  // in a process of its own
  bool ends_with_zero_force;     // false: a promise of the safety governor's, not yet of ours
};

void run_on_thread(Log& log, const HapticThreadSettings& settings,
                   const std::function<void(HapticThread&)>& then) {
  SessionRig rig(log);
  HapticThread thread(rig.session, settings);
  thread.start();
  while (thread.running() && thread.ticks() < 20) std::this_thread::yield();
  then(thread);
}

void fail(std::uint64_t tick) {
  if (tick == 10) throw std::runtime_error("an observer must not throw");
}

class Thrower final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override { fail_(record.tick); }

 private:
  void (*volatile fail_)(std::uint64_t) = &fail;  // so that no compiler sees it coming
};

std::vector<WayOut> ways_out() {
  const HapticThreadSettings quick{4000.0, 0};
  return {
      {"stop() of a session",
       [](Log& log) {
         SessionRig rig(log);
         rig.session.start();
         rig.run(20);
         rig.session.stop();
         rig.session.stop();
       },
       true},
      {"destroying a session",
       [](Log& log) {
         SessionRig rig(log);
         rig.session.start();
         rig.run(20);
       },
       true},
      {"destroying a thread", [=](Log& log) { run_on_thread(log, quick, [](HapticThread&) {}); },
       true},
      {"stop() of a thread",
       [=](Log& log) { run_on_thread(log, quick, [](HapticThread& thread) { thread.stop(); }); },
       true},
      {"max_ticks",
       [=](Log& log) {
         run_on_thread(log, {4000.0, 40}, [](HapticThread& thread) { thread.join(); });
       },
       true},
      {"a refused start",
       [](Log& log) {
         SessionRig rig(log);
         rig.device.refuses = true;
         rig.session.start();
         rig.run(20);
       },
       true},
      {"a refused start of a thread",
       [=](Log& log) {
         SessionRig rig(log);
         rig.device.refuses = true;
         HapticThread thread(rig.session, quick);
         const RealtimeStatus status = thread.start();
         if (status.device_problem.empty() || thread.running()) std::_Exit(9);
       },
       true},
      {"an exception out of the device's start",
       [](Log& log) {
         try {
           SessionRig rig(log);
           rig.device.throws_at_start = true;
           rig.session.start();
         } catch (const std::runtime_error&) {
         }
       },
       true},
      {"an exception of the caller's between ticks",
       [](Log& log) {
         try {
           SessionRig rig(log);
           rig.session.start();
           rig.run(20);
           throw std::runtime_error("a caller's");
         } catch (const std::runtime_error&) {
         }
       },
       true},
      {"an exception of the caller's while a thread runs",
       [=](Log& log) {
         try {
           run_on_thread(log, quick, [](HapticThread&) { throw std::runtime_error("a caller's"); });
         } catch (const std::runtime_error&) {
         }
       },
       true},
      {"an exception of an observer, which must not throw",
       [](Log& log) {
         Thrower thrower;
         SessionRig rig(log, {.observers = {&thrower}});
         rig.session.start();
         rig.run(20);
       },
       false},
      {"exit()", [=](Log& log) { run_on_thread(log, quick, [](HapticThread&) { std::_Exit(0); }); },
       false},
      {"SIGTERM",
       [=](Log& log) {
         run_on_thread(log, quick, [](HapticThread&) { ::kill(::getpid(), SIGTERM); });
       },
       false},
      {"SIGSEGV",
       [=](Log& log) {
         run_on_thread(log, quick, [](HapticThread&) { ::kill(::getpid(), SIGSEGV); });
       },
       false},
      {"SIGKILL",
       [=](Log& log) {
         run_on_thread(log, quick, [](HapticThread&) { ::kill(::getpid(), SIGKILL); });
       },
       false},
  };
}

TEST(WaysOut, EndWithZeroForceAndOneStopOrAreKnownNotTo) {
  std::string table;
  for (const WayOut& way : ways_out()) {
    SharedLog log;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (const int signal : {SIGTERM, SIGSEGV, SIGABRT}) std::signal(signal, SIG_DFL);
      way.go(*log);
      std::_Exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_FALSE(WIFEXITED(status) && WEXITSTATUS(status) != 0) << way.name;
    table += "  " + std::string(way.name) + ": last command " + std::to_string(log->last_N) +
             " N, stop() called " + std::to_string(log->stops) + " times\n";
    EXPECT_EQ(log->starts, 1) << way.name;
    if (way.ends_with_zero_force) {
      EXPECT_EQ(log->last_N, 0.0) << way.name;
      EXPECT_EQ(log->stops, 1) << way.name;
      EXPECT_GT(log->commands, 0) << way.name << ": zero force is commanded, not assumed";
      EXPECT_EQ(log->commands_at_stop, log->commands) << way.name << ": stop() comes last";
    } else {
      EXPECT_GT(log->last_N, 1.0) << way.name << " has learned to end well: say so here";
      EXPECT_EQ(log->stops, 0) << way.name;
    }
  }
  std::printf("%s", table.c_str());
}

}  // namespace
}  // namespace palpate
