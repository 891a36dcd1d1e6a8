// The haptic thread: what it calls, with what, and how it ends. Never how long anything took.

#include "engine/session/haptic_thread.h"

#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <limits>
#include <set>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/vector_device.h"
#include "engine/session/haptic_session.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/made.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Plays positions and keeps what it is told. Memory is set aside before the start.
class PlayedDevice final : public VectorDevice {
 public:
  explicit PlayedDevice(std::vector<Vec3> positions) : positions_(std::move(positions)) {
    time_steps_s.reserve(100'000);
    commands_N.reserve(100'000);
  }
  Vec3 read_position_m(double dt_s) noexcept override {
    if (delay.count() > 0 && time_steps_s.size() == delayed_tick)
      std::this_thread::sleep_for(delay);
    const std::size_t n = std::min(time_steps_s.size(), positions_.size() - 1);
    if (time_steps_s.size() < time_steps_s.capacity()) time_steps_s.push_back(dt_s);
    return positions_[n];
  }
  void command_force_N(const Vec3& force_device) noexcept override {
    if (commands_N.size() < commands_N.capacity()) commands_N.push_back(force_device);
  }

  std::vector<double> time_steps_s;
  std::vector<Vec3> commands_N;
  std::chrono::milliseconds delay{0};
  std::size_t delayed_tick = 0;

 private:
  std::vector<Vec3> positions_;
};

class KeptRecords final : public TickObserver {
 public:
  KeptRecords() { records.reserve(100'000); }
  void on_tick(const TickRecord& record) noexcept override {
    if (records.size() < records.capacity()) records.push_back(record);
  }
  std::vector<TickRecord> records;
};

// Presses further and further into the top of a box.
std::vector<Vec3> pressing_path(std::size_t ticks) {
  std::vector<Vec3> path;
  for (std::size_t n = 0; n < ticks; ++n) {
    path.emplace_back(1e-6 * static_cast<double>(n), 0.0, 0.10105 - 1e-4 * static_cast<double>(n));
  }
  return path;
}

struct ThreadRig {
  explicit ThreadRig(std::vector<Vec3> path)
      : world(test::box_soup(Vec3::Constant(0.1))),
        loop(test::made(
            HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 3), settings()))),
        device(std::move(path)),
        session(loop, device, {.observers = {&observer}}) {}

  static HapticSettings settings() {
    HapticSettings s;
    s.a4.enabled = false;
    s.coupling.damping_Ns_per_m = 0.0;
    return s;
  }

  test::OwnedWorld world;
  HapticLoop loop;
  PlayedDevice device;
  KeptRecords observer;
  HapticSession session;
};

void wait_for_ticks(const HapticThread& thread, std::uint64_t ticks) {
  while (thread.ticks() < ticks) std::this_thread::yield();
}

TEST(HapticThread, RunsTheTicksAskedForWithTheNominalTimeStep) {
  for (const double rate_Hz : {1000.0, 333.0, 4000.0}) {
    ThreadRig rig(pressing_path(60));
    HapticThread thread(rig.session, {rate_Hz, 60});
    thread.start();
    thread.join();
    EXPECT_FALSE(thread.running());
    EXPECT_EQ(thread.ticks(), 60u);
    ASSERT_EQ(rig.device.time_steps_s.size(), 60u);
    for (const double dt_s : rig.device.time_steps_s) EXPECT_EQ(dt_s, 1.0 / rate_Hz);
    ASSERT_EQ(rig.observer.records.size(), 60u);
    for (std::size_t n = 0; n < 60; ++n) EXPECT_EQ(rig.observer.records[n].tick, n);
  }
}

TEST(HapticThread, CommandsZeroForceLast) {
  ThreadRig rig(pressing_path(50));
  HapticThread thread(rig.session, {2000.0, 50});
  thread.start();
  thread.join();
  ASSERT_EQ(rig.device.commands_N.size(), 51u);
  EXPECT_GT(rig.device.commands_N[49].z(), 1.0) << "the hand presses to the end";
  EXPECT_EQ(rig.device.commands_N[50], Vec3::Zero());
}

TEST(HapticThread, StopsWhenAskedToAndCommandsZeroForceLast) {
  ThreadRig rig(pressing_path(30));
  HapticThread thread(rig.session, {4000.0, 0});
  thread.start();
  EXPECT_TRUE(thread.running());
  wait_for_ticks(thread, 40);
  EXPECT_TRUE(thread.running());
  thread.stop();
  EXPECT_FALSE(thread.running());
  const std::uint64_t ticks = thread.ticks();
  EXPECT_EQ(rig.device.time_steps_s.size(), ticks);
  ASSERT_EQ(rig.device.commands_N.size(), ticks + 1);
  EXPECT_GT(rig.device.commands_N[ticks - 1].z(), 1.0);
  EXPECT_EQ(rig.device.commands_N[ticks], Vec3::Zero());
  thread.stop();  // once more changes nothing
  EXPECT_EQ(thread.ticks(), ticks);
  EXPECT_EQ(rig.device.commands_N.size(), ticks + 1);
}

// The signals that the thread it runs on takes.
class SignalsOfItsThread final : public TickObserver {
 public:
  void on_tick(const TickRecord&) noexcept override {
    pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
  }
  sigset_t blocked{};
};

TEST(HapticThread, LeavesSignalsToOtherThreads) {
  ThreadRig rig(pressing_path(5));
  SignalsOfItsThread signals;
  HapticSession session(rig.loop, rig.device, {.observers = {&signals}});
  sigset_t before;
  pthread_sigmask(SIG_SETMASK, nullptr, &before);
  HapticThread thread(session, {2000.0, 5});
  thread.start();
  thread.join();
  sigset_t after;
  pthread_sigmask(SIG_SETMASK, nullptr, &after);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGALRM, SIGCHLD}) {
    EXPECT_TRUE(sigismember(&signals.blocked, signal)) << signal;
    EXPECT_EQ(sigismember(&after, signal), sigismember(&before, signal)) << signal;
  }
}

TEST(HapticThread, EndsWithItsOwner) {
  ThreadRig rig(pressing_path(30));
  {
    HapticThread thread(rig.session, {4000.0, 0});
    thread.start();
    wait_for_ticks(thread, 40);
  }
  ASSERT_FALSE(rig.device.commands_N.empty());
  EXPECT_EQ(rig.device.commands_N.back(), Vec3::Zero());
  HapticThread never_started(rig.session, {});
  never_started.stop();
  EXPECT_FALSE(never_started.running());
}

TEST(HapticThread, StopsRightAfterTheStart) {
  for (int i = 0; i < 50; ++i) {
    ThreadRig rig(pressing_path(2));
    HapticThread thread(rig.session, {1000.0, 0});
    thread.start();
    thread.stop();
    EXPECT_FALSE(thread.running());
    EXPECT_EQ(rig.device.commands_N.back(), Vec3::Zero());
  }
}

// A late tick must not change what the loop computes, only be counted.
TEST(HapticThread, CountsALateTickAndKeepsTheNominalTimeStep) {
  ThreadRig rig(pressing_path(20));
  rig.device.delayed_tick = 5;
  rig.device.delay = std::chrono::milliseconds(8);
  HapticThread thread(rig.session, {1000.0, 20});
  thread.start();
  thread.join();
  EXPECT_GE(thread.missed_deadlines(), 1u);
  EXPECT_LE(thread.missed_deadlines(), 20u) << "due times left out are not caught up one by one";
  EXPECT_EQ(thread.ticks(), 20u);
  for (const double dt_s : rig.device.time_steps_s) EXPECT_EQ(dt_s, 1e-3);
}

TEST(HapticThread, ExplainsWhatTheSystemDidNotGrant) {
  ThreadRig rig(pressing_path(2));
  HapticThread thread(rig.session, {1000.0, 2});
  const RealtimeStatus status = thread.start();
  thread.join();
  EXPECT_EQ(status.explanation.empty(), status.fifo_priority && status.locked_memory);
  EXPECT_EQ(status.explanation.find("SCHED_FIFO") != std::string::npos, !status.fifo_priority);
  EXPECT_EQ(status.explanation.find("locked") != std::string::npos, !status.locked_memory);
  EXPECT_EQ(status.explanation.find('\n'), std::string::npos);
}

TEST(HapticThread, ComputesTheSameAsTheLoopWithoutAThread) {
  const std::vector<Vec3> path = pressing_path(200);
  ThreadRig threaded(path);
  HapticThread thread(threaded.session, {4000.0, path.size()});
  thread.start();
  thread.join();
  ThreadRig plain(path);
  plain.session.start();
  for (std::size_t n = 0; n < path.size(); ++n) plain.session.tick(1.0 / 4000.0);
  ASSERT_EQ(threaded.observer.records.size(), path.size());
  for (std::size_t n = 0; n < path.size(); ++n) {
    const TickRecord& a = threaded.observer.records[n];
    const TickRecord& b = plain.observer.records[n];
    EXPECT_EQ(vec3(a.proxy_scene_m), vec3(b.proxy_scene_m));
    EXPECT_EQ(vec3(a.force_device_N), vec3(b.force_device_N));
    EXPECT_EQ(a.time_s, b.time_s);
  }
}

// ---- what other threads see --------------------------------------------------------------------

struct Seen {
  std::uint64_t snapshots = 0;
  std::uint64_t steps_back = 0;
  std::uint64_t mixtures = 0;
};

// The device moves by a known amount a tick, so that a snapshot gives itself away.
void watch(const HapticSession& session, const std::vector<Vec3>& path, Seen& seen) {
  std::uint64_t newest = 0;
  while (newest < path.size()) {
    TickRecord s;
    if (!session.latest(s)) {
      std::this_thread::yield();
      continue;
    }
    ++seen.snapshots;
    if (s.tick + 1 < newest) ++seen.steps_back;
    newest = std::max(newest, s.tick + 1);
    const Vec3& device = path[s.tick];
    const bool whole = s.device_m[0] == device.x() && s.device_m[2] == device.z() &&
                       (s.contact == 1) == (s.force_device_N[2] > 0.0) &&
                       std::abs(s.time_s - 2.5e-4 * static_cast<double>(s.tick)) < 1e-9;
    if (!whole) ++seen.mixtures;
  }
}

TEST(HapticThread, PublishesWholeSnapshotsInOrderToSeveralReaders) {
  const std::vector<Vec3> path = pressing_path(800);
  ThreadRig rig(path);
  TickRecord before;
  EXPECT_FALSE(rig.session.latest(before)) << "nothing has happened yet";
  std::array<Seen, 3> seen;
  std::vector<std::thread> readers;
  for (Seen& s : seen) readers.emplace_back([&rig, &path, &s] { watch(rig.session, path, s); });
  HapticThread thread(rig.session, {4000.0, path.size()});
  thread.start();
  thread.join();
  for (std::thread& reader : readers) reader.join();
  for (const Seen& s : seen) {
    EXPECT_GT(s.snapshots, 0u);
    EXPECT_EQ(s.steps_back, 0u);
    EXPECT_EQ(s.mixtures, 0u);
  }
  TickRecord last;
  ASSERT_TRUE(rig.session.latest(last));
  EXPECT_EQ(last.tick + 1, path.size());
  EXPECT_EQ(last.contact, 1u);
}

// The snapshot shows the pose after the elementary rotation, the record the one before it.
TEST(HapticSession, PublishesThePoseToDisplay) {
  const test::OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  HapticSettings settings;
  settings.initial_pose.rotation = Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ()));
  auto loop =
      test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), settings));
  const auto at = [&](double x) { return settings.initial_pose.point({x, 0.0, 0.0}); };
  PlayedDevice device({at(0.11), at(0.099), at(0.098), at(0.097)});
  KeptRecords kept;
  HapticSession session(loop, device, {.observers = {&kept}});
  session.start();
  for (int n = 0; n < 4; ++n) session.tick(1e-3);
  TickRecord s;
  ASSERT_TRUE(session.latest(s));
  EXPECT_EQ(s.tick, 3u);
  const ScenePose shown = pose_after(s);
  EXPECT_EQ(shown.rotation.coeffs(), loop.T_device_scene().rotation.coeffs());
  EXPECT_EQ(shown.translation_m, loop.T_device_scene().translation_m);
  const TickRecord& r = kept.records.back();
  ASSERT_TRUE(r.contact);
  EXPECT_GT(shown.rotation.angularDistance(pose_before(r).rotation), 1e-5);
  EXPECT_EQ(Vec3(s.proxy_scene_m[0], s.proxy_scene_m[1], s.proxy_scene_m[2]),
            vec3(r.proxy_scene_m));
  EXPECT_EQ(s.alpha_rad, r.alpha_rad);
  EXPECT_EQ(s.contact, 1u);
}

// ---- bad samples -------------------------------------------------------------------------------

TEST(HapticThread, MarksBadSamplesCommandsNoForceForThemAndCarriesOn) {
  std::vector<Vec3> path = pressing_path(100);
  const std::set<std::size_t> bad{0, 40, 41, 42, 60, 99};
  for (const std::size_t n : bad) path[n] = Vec3(n % 2 ? kNan : 0.0, 0.0, n % 2 ? 0.0 : HUGE_VAL);
  ThreadRig rig(path);
  HapticThread thread(rig.session, {4000.0, path.size()});
  thread.start();
  thread.join();
  ASSERT_EQ(rig.observer.records.size(), path.size());
  for (std::size_t n = 0; n < path.size(); ++n) {
    const TickRecord& r = rig.observer.records[n];
    if (bad.contains(n)) {
      EXPECT_EQ(r.faults, kFaultNonFiniteSample) << n;
      EXPECT_EQ(rig.device.commands_N[n], Vec3::Zero()) << n;
    } else {
      EXPECT_EQ(r.faults, kFaultNone) << n;
      EXPECT_EQ(r.contact, n > 10) << n;
      EXPECT_EQ(rig.device.commands_N[n].z() > 0.0, n > 10) << n;
    }
    EXPECT_TRUE(vec3(r.proxy_scene_m).allFinite() && vec3(r.goal_scene_m).allFinite()) << n;
    EXPECT_TRUE(rig.device.commands_N[n].allFinite()) << n;
  }
  TickRecord last;
  ASSERT_TRUE(rig.session.latest(last));
  EXPECT_EQ(last.faults, kFaultNonFiniteSample);
}

}  // namespace
}  // namespace palpate
