// The guard with real processes and a fake board on a pseudo-terminal. Nothing here depends on how
// fast the machine is: each test waits up to 2 s for what must come.

#include "engine/devices/motor_guard.h"

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sys/socket.h>

#include <gtest/gtest.h>

#include "engine/devices/hapi_zero.h"
#include "engine/devices/monotonic_clock.h"
#include "tests/engine/devices/board_terminal.h"
#include "tests/engine/devices/engine_process.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

using Entry = FakeBoardTerminal::Entry;

void sleep_ms(int ms) {
  std::this_thread::sleep_for(std::chrono::milliseconds(ms));
}

// The tick messages with force that the board read after the first zero since `from_ns`.
std::uint64_t forces_after_zero(const std::vector<Entry>& log, std::int64_t from_ns) {
  std::uint64_t forces = 0;
  bool was_zero = false;
  for (const Entry& entry : log) {
    was_zero = was_zero || (entry.is_zero && entry.last_ns >= from_ns);
    if (was_zero && !entry.is_zero) forces += entry.count;
  }
  return forces;
}

class MotorGuardProcess : public ::testing::Test {
 protected:
  void SetUp() override { PALPATE_NEEDS(test::lack_of_terminals()); }
  // Starts an engine and waits until its force has reached the board.
  void start(const std::string& behaviour) {
    process = std::make_unique<EngineProcess>(PALPATE_GUARDED_ENGINE, board.port(), behaviour);
    ASSERT_TRUE(process->has_started());
    if (behaviour == "unarmed") return;
    ASSERT_TRUE(wait_for([&] { return !board.is_zero(); }, 20.0));
  }

  // Expects that the force ends and stays zero. A command that the engine was about to write may
  // slip, which the guard's next zero ends.
  void expect_zero_for_ever(std::int64_t from_ns) {
    ASSERT_TRUE(wait_for([&] { return board.is_zero(); }));
    sleep_ms(300);
    EXPECT_TRUE(board.is_zero());
    EXPECT_LE(forces_after_zero(board.log(), from_ns), 1u);
  }

  void expect_guard_ends_well() { EXPECT_EQ(process->guard().status_at_end(), 0); }

  FakeBoardTerminal board;
  std::unique_ptr<EngineProcess> process;
};

TEST_F(MotorGuardProcess, StopsTheMotorsOfAKilledEngine) {
  ASSERT_NO_FATAL_FAILURE(start("run"));
  const std::int64_t fault_ns = monotonic_ns();
  process->engine().send(SIGKILL);
  expect_zero_for_ever(fault_ns);
  expect_guard_ends_well();
}

TEST_F(MotorGuardProcess, StopsTheMotorsWithoutRealtimeScheduling) {
  ASSERT_NO_FATAL_FAILURE(start("no-fifo"));
  EXPECT_FALSE(process->has_fifo());
  const std::int64_t fault_ns = monotonic_ns();
  process->engine().send(SIGKILL);
  expect_zero_for_ever(fault_ns);
  expect_guard_ends_well();
}

TEST_F(MotorGuardProcess, StopsTheMotorsOfAStoppedEngineWhichCanRearm) {
  ASSERT_NO_FATAL_FAILURE(start("run"));
  const std::int64_t stop_ns = monotonic_ns();
  process->engine().send(SIGSTOP);
  expect_zero_for_ever(stop_ns);
  const std::int64_t go_on_ns = monotonic_ns();
  process->engine().send(SIGCONT);
  // The engine commands 50 zeros after it has rearmed, and then its force. A slipped command
  // comes alone.
  const auto has_rearmed = [&] { return board.log().back().count > 1 && !board.is_zero(); };
  ASSERT_TRUE(wait_for(has_rearmed, 20.0));
  std::uint64_t slipped = 0;
  const auto log = board.log();
  for (std::size_t i = 0; i + 1 < log.size(); ++i) {
    if (!log[i].is_zero && log[i].first_ns > go_on_ns) slipped += log[i].count;
  }
  EXPECT_LE(slipped, 1u);
  EXPECT_GE(log[log.size() - 2].count, 50u);
  const std::int64_t kill_ns = monotonic_ns();
  process->engine().send(SIGKILL);
  expect_zero_for_ever(kill_ns);
  expect_guard_ends_well();
}

TEST_F(MotorGuardProcess, StopsTheMotorsOfAnEngineThatIsStoppedAndKilled) {
  ASSERT_NO_FATAL_FAILURE(start("run"));
  const std::int64_t stop_ns = monotonic_ns();
  process->engine().send(SIGSTOP);
  expect_zero_for_ever(stop_ns);
  process->engine().send(SIGKILL);
  expect_zero_for_ever(stop_ns);
  expect_guard_ends_well();
}

class MotorGuardFaults : public MotorGuardProcess,
                         public ::testing::WithParamInterface<const char*> {};

TEST_P(MotorGuardFaults, EndWithZeroForce) {
  ASSERT_NO_FATAL_FAILURE(start(GetParam()));
  long long fault_ns = 0;
  ASSERT_EQ(std::sscanf(process->read_line().c_str(), "fault %lld", &fault_ns), 1);
  expect_zero_for_ever(fault_ns);
}

INSTANTIATE_TEST_SUITE_P(All, MotorGuardFaults,
                         ::testing::Values("segv", "throw", "exit", "destroy", "hang-tick",
                                           "end-thread"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_F(MotorGuardProcess, StopsTheMotorsWhenTheQueueOfTheBoardIsFull) {
  ASSERT_NO_FATAL_FAILURE(start("full"));
  board.pause(true);
  ASSERT_EQ(process->read_line(), "full");
  sleep_ms(500);  // the guard flushes the queue meanwhile
  const std::uint64_t read_before = board.bytes_read();
  std::uint64_t forces_before = 0;
  for (const Entry& entry : board.log()) forces_before += entry.is_zero ? 0 : entry.count;
  board.pause(false);
  ASSERT_TRUE(wait_for([&] { return board.bytes_read() > read_before && board.is_zero(); }));
  sleep_ms(300);
  EXPECT_TRUE(board.is_zero());
  std::uint64_t forces = 0;
  for (const Entry& entry : board.log()) forces += entry.is_zero ? 0 : entry.count;
  // The 4,096 bytes that a terminal's reading side holds cannot be flushed; the rest must be. They
  // may begin with the rest of a message that the board has read in part.
  EXPECT_LE(forces - forces_before, 4096u / HostMessages::tick(1, 0, {0.5f, 0.5f}).size() + 1);
}

TEST_F(MotorGuardProcess, StopsABoardThatWaitsUntilItsAnswersAreRead) {
  ASSERT_NO_FATAL_FAILURE(start("run"));
  const std::int64_t fault_ns = monotonic_ns();
  process->engine().send(SIGSTOP);
  board.flood();
  expect_zero_for_ever(fault_ns);
}

TEST_F(MotorGuardProcess, SeesTheEndOfAnEngineWhoseChildKeepsItsDescriptors) {
  ASSERT_NO_FATAL_FAILURE(start("fork"));
  pid_t child = 0;
  ASSERT_EQ(std::sscanf(process->read_line().c_str(), "child %d", &child), 1);
  const WatchedProcess watched_child(child);
  const std::int64_t fault_ns = monotonic_ns();
  process->engine().send(SIGKILL);
  expect_zero_for_ever(fault_ns);
  expect_guard_ends_well();
  watched_child.send(SIGKILL);
  watched_child.status_at_end();
}

TEST_F(MotorGuardProcess, SurvivesTheHangUpOfItsTerminal) {
  ASSERT_NO_FATAL_FAILURE(start("run"));
  board.hang_up();
  sleep_ms(300);
  EXPECT_FALSE(process->guard().has_ended());
  process->engine().send(SIGKILL);
  expect_guard_ends_well();
}

TEST_F(MotorGuardProcess, IgnoresTheSignalsOfTheTerminalWhileArmed) {
  ASSERT_NO_FATAL_FAILURE(start("run"));
  for (const int signal : {SIGINT, SIGHUP, SIGTERM, SIGPIPE}) process->guard().send(signal);
  sleep_ms(100);
  EXPECT_FALSE(process->guard().has_ended());
  const std::int64_t fault_ns = monotonic_ns();
  process->engine().send(SIGKILL);
  expect_zero_for_ever(fault_ns);
  expect_guard_ends_well();
}

TEST_F(MotorGuardProcess, CanBeEndedWhileNotArmed) {
  ASSERT_NO_FATAL_FAILURE(start("unarmed"));
  process->guard().send(SIGTERM);
  EXPECT_TRUE(wait_for([&] { return process->guard().has_ended(); }));
}

TEST_F(MotorGuardProcess, WritesOneZeroIfAnEngineThatIsNotArmedDies) {
  ASSERT_NO_FATAL_FAILURE(start("unarmed"));
  const std::uint64_t set_up_bytes =
      HostMessages::reset().size() + HostMessages::set_up(1, 2, 2, 0, 0).size();
  ASSERT_TRUE(wait_for([&] { return board.bytes_read() == set_up_bytes; }));
  process->engine().send(SIGKILL);
  expect_guard_ends_well();
  HapiMotors motors;
  motors.ports = 3;
  const std::uint64_t zero_bytes = hapi_zero_bytes(motors).size();
  EXPECT_TRUE(wait_for([&] { return board.bytes_read() == set_up_bytes + zero_bytes; }));
  EXPECT_TRUE(board.is_zero());
}

TEST_F(MotorGuardProcess, WritesNothingIfTheEngineEndsInOrder) {
  ASSERT_NO_FATAL_FAILURE(start("end"));
  EXPECT_EQ(process->engine().status_at_end(), 0);
  EXPECT_TRUE(process->guard().has_ended());
  ASSERT_TRUE(wait_for([&] { return board.is_zero(); }));
  sleep_ms(50);
  EXPECT_EQ(board.log().back().count, 1u);  // the engine's own zero
}

TEST_F(MotorGuardProcess, IsMissedByTheEngineWhenKilled) {
  ASSERT_NO_FATAL_FAILURE(start("watch"));
  process->guard().send(SIGKILL);
  EXPECT_EQ(process->read_line(), "lost");
  EXPECT_TRUE(wait_for([&] { return board.is_zero(); }));
}

TEST_F(MotorGuardProcess, IsMissedByTheEngineWhenFrozen) {
  ASSERT_NO_FATAL_FAILURE(start("watch"));
  process->guard().send(SIGSTOP);
  EXPECT_EQ(process->read_line(), "lost");
  EXPECT_TRUE(wait_for([&] { return board.is_zero(); }));
}

// A guard of this process, on one end of a pair of sockets.
class MotorGuardClient : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
    spec.descriptor = ends[0];
    spec.zero_bytes = {1, 2, 3};
  }
  void TearDown() override {
    for (const int end : ends) ::close(end);
  }

  void spawn() {
    auto result = MotorGuard::spawn(spec);
    ASSERT_TRUE(result.ok()) << result.error().to_string();
    guard = std::move(*result);
  }
  // The bytes that the guard has written since the last call.
  std::string written() {
    std::string bytes(100'000, '\0');
    const ssize_t size = ::read(ends[1], bytes.data(), bytes.size());
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(0, size)));
    return bytes;
  }
  // Waits for several zeros.
  bool writes_zeros() {
    std::size_t size = 0;
    return wait_for([&] { return (size += written().size()) >= 5 * spec.zero_bytes.size(); });
  }
  void beat() { guard->beat(monotonic_ns()); }
  std::string spawn_error() {
    const auto result = MotorGuard::spawn(spec);
    return result.ok() ? "no error" : result.error().to_string();
  }

  int ends[2] = {-1, -1};
  GuardSpec spec;
  std::unique_ptr<MotorGuard> guard;
};

TEST_F(MotorGuardClient, TripsWithoutBeatsAndWatchesAgainAfterTheAcknowledgement) {
  spec.period_s = 0.05;  // stale after half a second, so that a busy machine causes no trip
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  for (int i = 0; i < 20; ++i) {
    beat();
    sleep_ms(10);
    EXPECT_EQ(guard->trip_epoch(), 0u);
  }
  EXPECT_TRUE(guard->is_quiet());
  EXPECT_EQ(written(), "");

  ASSERT_TRUE(wait_for([&] { return !guard->is_quiet(); }));
  EXPECT_TRUE(writes_zeros());
  EXPECT_EQ(guard->trip_epoch(), 1u);  // seen now
  ASSERT_TRUE(wait_for([&] {
    beat();
    return guard->is_quiet();
  }));
  written();
  for (int i = 0; i < 20; ++i) {
    beat();
    sleep_ms(10);
  }
  EXPECT_EQ(written(), "");  // the driver could set up the device
  guard->acknowledge(1);
  for (int i = 0; i < 80; ++i) {  // longer than a heartbeat lives
    beat();
    sleep_ms(10);
  }
  EXPECT_EQ(guard->trip_epoch(), 1u);
  EXPECT_EQ(written(), "");
  EXPECT_TRUE(wait_for([&] { return guard->trip_epoch() == 2; }));
}

TEST_F(MotorGuardClient, WritesZerosAgainIfTheDriverFallsSilentBeforeItAcknowledges) {
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  ASSERT_TRUE(wait_for([&] { return guard->trip_epoch() == 1; }));
  EXPECT_TRUE(wait_for([&] {
    guard->trip_epoch();
    return guard->is_quiet();
  }));
  EXPECT_TRUE(wait_for([&] { return !guard->is_quiet(); }));
  written();
  EXPECT_TRUE(writes_zeros());
  EXPECT_EQ(guard->trip_epoch(), 1u);  // the same trip
}

// A command may slip until the driver has seen the trip.
TEST_F(MotorGuardClient, WritesAZeroAfterTheDriverHasSeenTheTrip) {
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  ASSERT_TRUE(wait_for([&] { return !guard->is_quiet(); }));
  sleep_ms(20);
  ::kill(guard->process(), SIGSTOP);
  sleep_ms(50);
  written();
  EXPECT_EQ(guard->trip_epoch(), 1u);
  EXPECT_FALSE(guard->is_quiet());
  ::kill(guard->process(), SIGCONT);
  ASSERT_TRUE(wait_for([&] { return guard->is_quiet(); }));
  EXPECT_GE(written().size(), spec.zero_bytes.size());
}

TEST_F(MotorGuardClient, AnOldTickIsStaleThoughTheDriverBeats) {
  spawn();
  const std::int64_t tick_ns = monotonic_ns();
  ASSERT_EQ(guard->arm(), std::nullopt);
  EXPECT_TRUE(wait_for([&] {
    guard->beat(tick_ns);
    return guard->trip_epoch() == 1;
  }));
}

TEST_F(MotorGuardClient, ADriverWhoseThreadHasEndedIsStaleBeforeItsHeartbeatIs) {
  spec.period_s = 1.0;  // the heartbeat is stale after ten seconds
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  std::thread([&] { beat(); }).join();
  EXPECT_TRUE(wait_for([&] { return guard->trip_epoch() == 1; }, 5.0));
}

TEST_F(MotorGuardClient, TheThreadOfAnEarlierDriverIsForgotten) {
  spec.period_s = 1.0;
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  std::thread([&] { beat(); }).join();
  ASSERT_EQ(guard->disarm(), std::nullopt);
  ASSERT_EQ(guard->arm(), std::nullopt);
  sleep_ms(3000);  // a heartbeat is looked at after two seconds
  EXPECT_EQ(guard->trip_epoch(), 0u);
}

TEST_F(MotorGuardClient, DisarmedItDoesNotTrip) {
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  beat();
  ASSERT_EQ(guard->disarm(), std::nullopt);
  const std::uint64_t epoch = guard->trip_epoch();
  written();
  sleep_ms(200);
  EXPECT_EQ(guard->trip_epoch(), epoch);
  EXPECT_EQ(written(), "");
  EXPECT_TRUE(guard->is_alive());
}

TEST_F(MotorGuardClient, AnEndedGuardIsNotAliveAndCannotBeArmed) {
  spawn();
  EXPECT_TRUE(guard->is_alive());
  ::kill(guard->process(), SIGKILL);
  EXPECT_TRUE(wait_for([&] { return !guard->is_alive(); }));
  const auto problem = guard->arm();
  ASSERT_NE(problem, std::nullopt);
  EXPECT_EQ(
      problem->to_string(),
      "palpate-guard: has ended or does not answer (nobody stops the motors; start it again)");
}

// The waits for an answer and for the end would last 7 s together.
TEST_F(MotorGuardClient, AFrozenGuardIsToldAsSuchAndHoldsUpNothing) {
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  const pid_t process = guard->process();
  ::kill(process, SIGSTOP);
  const std::int64_t frozen_ns = monotonic_ns();
  EXPECT_TRUE(wait_for([&] { return guard->state(monotonic_ns()) == GuardState::kFrozen; }));
  EXPECT_FALSE(guard->is_alive());
  const auto problem = guard->disarm();
  ASSERT_NE(problem, std::nullopt);
  EXPECT_EQ(problem->to_string(),
            "palpate-guard: is frozen: it does not run, and stops no motors (let it run again, by "
            "`kill -CONT` or by the debugger that holds it, or start again)");
  guard.reset();
  EXPECT_NE(::kill(process, 0), 0);  // ended, and waited for
  EXPECT_LT(monotonic_ns() - frozen_ns, 5 * kSecond_ns);
}

TEST_F(MotorGuardClient, AFrozenGuardCannotBeArmed) {
  spawn();
  ::kill(guard->process(), SIGSTOP);
  const auto problem = guard->arm();
  ASSERT_NE(problem, std::nullopt);
  EXPECT_NE(problem->to_string().find("is frozen"), std::string::npos) << problem->to_string();
  ::kill(guard->process(), SIGCONT);
}

// The guard compares two clocks of the machine with how they were when it was armed. An older
// difference looks as if the machine had been suspended since.
TEST_F(MotorGuardClient, TripsOnceWhenTheMachineWasSuspended) {
  spec.period_s = 1.0;  // the heartbeat is stale after ten seconds
  spawn();
  beat();
  ASSERT_EQ(guard->arm(most_boot_ahead_ns() - kSecond_ns), std::nullopt);
  ASSERT_TRUE(wait_for([&] { return guard->trip_epoch() == 1; }));
  EXPECT_TRUE(guard->was_suspended());
  ASSERT_TRUE(wait_for([&] {
    beat();
    return guard->is_quiet();
  }));
  EXPECT_GE(written().size(), spec.zero_bytes.size());
  guard->acknowledge(1);
  EXPECT_FALSE(guard->was_suspended());
  for (int i = 0; i < 30; ++i) {
    beat();
    sleep_ms(10);
  }
  EXPECT_EQ(guard->trip_epoch(), 1u);
}

TEST_F(MotorGuardClient, TellsAStaleHeartbeatFromASuspendedMachine) {
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  ASSERT_TRUE(wait_for([&] { return guard->trip_epoch() == 1; }));
  EXPECT_FALSE(guard->was_suspended());
}

TEST_F(MotorGuardClient, WritesWholeZerosThoughTheirPortTakesThemInPieces) {
  spec.zero_bytes.resize(4093);
  for (std::size_t i = 0; i < spec.zero_bytes.size(); ++i) {
    spec.zero_bytes[i] = static_cast<std::uint8_t>(i * 7 % 251);
  }
  PALPATE_NEEDS(test::lack_of_terminals());
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  grantpt(terminal);
  unlockpt(terminal);
  spec.descriptor = open_raw(ptsname(terminal));
  spawn();
  ASSERT_EQ(guard->arm(), std::nullopt);
  sleep_ms(500);  // the guard fills the queue, which holds 16 zeros or so
  std::string all;
  EXPECT_TRUE(wait_for([&] {
    std::array<char, 4096> bytes;
    const ssize_t size = ::read(terminal, bytes.data(), bytes.size());
    if (size > 0) all.append(bytes.data(), static_cast<std::size_t>(size));
    return all.size() >= 40 * spec.zero_bytes.size();
  }));
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(static_cast<std::uint8_t>(all[i]), spec.zero_bytes[i % spec.zero_bytes.size()]) << i;
  }
  ::close(spec.descriptor);
  ::close(terminal);
}

// Whether this process may use the guard's real-time priority.
bool may_use_fifo() {
  bool may = false;
  std::thread([&] {
    const sched_param fifo{kGuardPriority};
    may = pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo) == 0;
  }).join();
  return may;
}

TEST_F(MotorGuardClient, SaysWhetherItRunsInRealTime) {
  spawn();
  EXPECT_EQ(guard->has_fifo(), may_use_fifo());
  EXPECT_EQ(guard->has_fifo(), guard->fifo_problem().empty());
  EXPECT_EQ(sched_getscheduler(guard->process()), guard->has_fifo() ? SCHED_FIFO : SCHED_OTHER);
  EXPECT_EQ(getsid(guard->process()), guard->process());
}

TEST_F(MotorGuardClient, MayRunOnAllProcessors) {
  cpu_set_t all;
  cpu_set_t guards;
  ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
  std::thread([&] {
    cpu_set_t first;
    CPU_ZERO(&first);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&first) == 0; ++cpu) {
      if (CPU_ISSET(cpu, &all)) CPU_SET(cpu, &first);
    }
    sched_setaffinity(0, sizeof first, &first);
    spawn();
  }).join();
  ASSERT_EQ(sched_getaffinity(guard->process(), sizeof guards, &guards), 0);
  EXPECT_GE(CPU_COUNT(&guards), CPU_COUNT(&all));
}

TEST_F(MotorGuardClient, RefusesAWrongSpecification) {
  spec.zero_bytes.clear();
  EXPECT_EQ(spawn_error(), "zero_bytes: is 0 bytes long; expected 1 to 4096");
  spec.zero_bytes.resize(4097);
  EXPECT_EQ(spawn_error(), "zero_bytes: is 4097 bytes long; expected 1 to 4096");
  spec.zero_bytes = {0};
  for (const double period_s : {0.0, -1.0, 1.5, std::nan(""), HUGE_VAL}) {
    spec.period_s = period_s;
    EXPECT_NE(spawn_error().find("period_s: is "), std::string::npos) << period_s;
  }
  spec.period_s = 0.001;
  fcntl(ends[0], F_SETFL, 0);
  EXPECT_EQ(
      spawn_error(),
      "descriptor: is blocking; expected O_NONBLOCK (a write that blocks would stop the guard)");
  spec.descriptor = -1;
  EXPECT_EQ(spawn_error(), "descriptor: is not open; expected the descriptor of the device");
}

TEST(StaleHeartbeat, IsTwentyMillisecondsOrTenPeriods) {
  EXPECT_EQ(stale_heartbeat_ns(0.0001), 20'000'000);
  EXPECT_EQ(stale_heartbeat_ns(0.001), 20'000'000);
  EXPECT_EQ(stale_heartbeat_ns(0.002), 20'000'000);
  EXPECT_EQ(stale_heartbeat_ns(0.004), 40'000'000);
}

// What a command writes to stdout and stderr, and its exit code in the last line.
std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = popen((command + " 2>&1; echo $?").c_str(), "r");
  if (pipe == nullptr) return output;
  for (int c = fgetc(pipe); c != EOF; c = fgetc(pipe)) output += static_cast<char>(c);
  pclose(pipe);
  return output;
}

// A copy of guarded_engine in a folder without a guard.
class MotorGuardProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    PALPATE_NEEDS(test::lack_of_terminals());
    folder =
        std::filesystem::path(::testing::TempDir()) / ("palpate_guard_" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    std::filesystem::copy_file(PALPATE_GUARDED_ENGINE, folder / "engine");
    command = (folder / "engine").string() + " " + board.port() + " end";
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  FakeBoardTerminal board;
  std::filesystem::path folder;
  std::string command;
};

TEST_F(MotorGuardProgram, IsSoughtBesideTheProgramAndThenInTheEnvironment) {
  EXPECT_EQ(output_of("env -u PALPATE_GUARD " + command),
            "palpate-guard: is not in " + folder.string() +
                ", and PALPATE_GUARD is not set (put the program there, or name it in this "
                "environment variable)\n2\n");
  EXPECT_EQ(output_of("PALPATE_GUARD=/missing/guard " + command),
            "palpate-guard: PALPATE_GUARD is /missing/guard; expected a program (No such file or "
            "directory)\n2\n");
  const std::string found = output_of("PALPATE_GUARD=" PALPATE_GUARD_PROGRAM " " + command);
  EXPECT_EQ(found.substr(0, 6), "guard ") << found;
  EXPECT_EQ(found.substr(found.size() - 3), "\n0\n") << found;
}

TEST_F(MotorGuardProgram, IsRefusedIfItIsAnotherProgram) {
  EXPECT_EQ(output_of("PALPATE_GUARD=/bin/true " + command),
            "palpate-guard: ended, or said nothing for 5 s, before it was ready (its message, if "
            "any, is above)\n2\n");
}

TEST_F(MotorGuardProgram, IsToldAsStoppedIfItStopsBeforeItsFirstWord) {
  const std::string stops = (folder / "stops").string();
  std::ofstream(stops) << "#!/bin/sh\nkill -STOP $$\n";
  std::filesystem::permissions(stops, std::filesystem::perms::owner_all);
  EXPECT_EQ(output_of("PALPATE_GUARD=" + stops + " " + command),
            "palpate-guard: was stopped by a signal before it was ready (let it run again, by "
            "`kill -CONT` or by the debugger that holds it, or start again)\n2\n");
}

TEST_F(MotorGuardProgram, RefusesToRunWithoutAnEngine) {
  EXPECT_EQ(output_of(PALPATE_GUARD_PROGRAM " 3< /dev/null"),
            "palpate-guard: descriptor 3 is no socket of an engine: an engine starts this "
            "program\n2\n");
}

}  // namespace
}  // namespace palpate
