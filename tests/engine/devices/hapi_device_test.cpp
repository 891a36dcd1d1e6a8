// The driver with its thread, on a pseudo-terminal with a simulated board behind it. No test
// asserts a time: each one waits until something happens.

#include "engine/devices/hapi_device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <functional>
#include <memory>
#include <span>
#include <stdlib.h>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "engine/devices/serial_port.h"
#include "engine/simulation/board_terminal.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

using Kind = BoardFault::Kind;

constexpr std::int64_t kForEver_ns = std::int64_t{1} << 62;

bool wait_until(const std::function<bool()>& is_true) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end) {
    if (is_true()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

std::unique_ptr<BoardTerminal> open_board() {
  auto board = BoardTerminal::open({});
  EXPECT_TRUE(board) << board.error().to_string();
  return board ? std::move(*board) : nullptr;
}

HapiSettings settings_of(const BoardTerminal& board) {
  HapiSettings settings;
  settings.port = board.path();
  settings.torque_per_Nm = 1.0;
  settings.peak_torque_Nm = 0.1;
  settings.works_without_guard = true;
  return settings;
}

BoardFault fault_now(Kind kind, std::int64_t time_ns) {
  BoardFault fault;
  fault.kind = kind;
  fault.from_ns = BoardTerminal::now_ns();
  fault.until_ns = time_ns == kForEver_ns ? kForEver_ns : fault.from_ns + time_ns;
  return fault;
}

bool is_zero(const BoardCommand& command) {
  return std::abs(command.torques[0]) < 0x1p-119f && std::abs(command.torques[1]) < 0x1p-119f;
}

// A guard that the test commands.
class AtomicGuard final : public WriteGuard {
 public:
  void beat(std::int64_t, std::int64_t) noexcept override { ++beats; }
  std::uint64_t trip_epoch() const noexcept override { return epoch; }
  void acknowledge(std::uint64_t of_epoch) noexcept override { acknowledged = of_epoch; }
  bool was_suspended() const noexcept override { return suspended; }
  GuardState state(std::int64_t) const noexcept override { return at_present; }

  std::atomic<std::uint64_t> epoch{0}, acknowledged{0}, beats{0};
  std::atomic<GuardState> at_present{GuardState::kAlive};
  std::atomic<bool> suspended{false};
};

// Ticks at about 1 kHz until something happens. As the governor does, a tick commands zero if the
// device asks for a trip: a loaded machine may well delay the board's answers.
bool push_until(HapiDevice& device, const std::function<bool(const DeviceSample&)>& is_true) {
  return wait_until([&] {
    const DeviceSample sample = device.read(1e-3);
    if (sample.asks_for_trip) {
      device.command({});
    } else {
      device.command({{0.3, 0.2, 0.0}});
    }
    return is_true(sample);
  });
}

// On a busy machine the board may be late three times in a row, and the device then gives up.
// Another board and another start show the rest.
TEST(HapiDevice, GivesSamplesSendsForcesAndEndsWithZero) {
  PALPATE_NEEDS(test::lack_of_terminals());
  constexpr int kMostStarts = 10;
  for (int started = 1;; ++started) {
    const auto board = open_board();
    HapiDevice device(settings_of(*board));
    const auto problem = device.start();
    ASSERT_FALSE(problem) << *problem;
    std::uint64_t last = 0;
    const bool has_pushed = push_until(device, [&](const DeviceSample& sample) {
      if (!device.health().is_good) return true;
      EXPECT_TRUE(sample.is_valid);
      EXPECT_GE(sample.sequence, last);
      last = sample.sequence;
      return last > 100 && !is_zero(board->log().back());
    });
    EXPECT_TRUE(has_pushed);
    const DeviceHealth health = device.health();
    const bool was_late = health.problem.find("did not answer") != std::string::npos;
    if (was_late && started < kMostStarts) continue;
    ASSERT_TRUE(health.is_good) << health.problem;
    EXPECT_EQ(device.motors_now().size(), 2u);
    EXPECT_GE(device.descriptor(), 0);
    // The session commands zero before stop(); the driver sends it.
    device.command({});
    device.stop();
    EXPECT_TRUE(wait_until([&] { return is_zero(board->log().back()); }));
    EXPECT_GE(device.counts().answers, 100u);
    EXPECT_NE(device.summary().find(" answers, "), std::string::npos);
    EXPECT_EQ(device.descriptor(), -1);
    return;
  }
}

// On a busy machine the thread may be late; then another start measures again.
TEST(HapiDevice, StatesItsDelayAndTheRateOfItsLineFromTheStartOn) {
  PALPATE_NEEDS(test::lack_of_terminals());
  for (const std::int64_t answer_ns : {300'000, 3'000'000}) {
    BoardSettings board_settings;
    board_settings.answer_ns = answer_ns;
    auto board = BoardTerminal::open(board_settings);
    ASSERT_TRUE(board) << board.error().to_string();
    HapiDevice device(settings_of(**board));
    EXPECT_FALSE(device.description().delay.is_known());
    EXPECT_EQ(device.line_rate().at_start_Hz, 0.0);
    ASSERT_FALSE(device.start());
    for (const BoardCommand& command : (*board)->log()) EXPECT_TRUE(is_zero(command));
    const DelayInterval stated = device.description().delay;
    ASSERT_TRUE(stated.is_known());
    ASSERT_TRUE(is_delay(stated));
    // The thread sends a message only after the answer to the last one.
    EXPECT_GE(stated.most_s, 1e-9 * static_cast<double>(answer_ns));
    const LineRate at_start = device.line_rate();
    EXPECT_EQ(at_start.asked_Hz, 1000.0);
    EXPECT_GT(at_start.at_start_Hz, 0.0);
    EXPECT_LE(at_start.at_start_Hz, std::min(1000.0, 1e9 / static_cast<double>(answer_ns)));
    EXPECT_EQ(at_start.delay, DelayInterval{});
    EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.sequence > 400; }));
    EXPECT_GT(device.line_rate().delay.least_s, 0.0);
    EXPECT_GT(device.line_rate().in_session_Hz, 0.0);
    EXPECT_EQ(device.description().delay, stated);
    device.command({});
    device.stop();
  }
}

TEST(HapiDevice, StopSendsZeroAlsoWithoutAZeroCommand) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  {
    HapiDevice device(settings_of(*board));
    ASSERT_FALSE(device.start());
    EXPECT_TRUE(push_until(device, [&](const auto&) { return !is_zero(board->log().back()); }));
  }
  EXPECT_TRUE(wait_until([&] { return is_zero(board->log().back()); }));
}

TEST(HapiDevice, StartsAgainAfterAStop) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiDevice device(settings_of(*board));
  for (int again = 0; again < 3; ++again) {
    const auto problem = device.start();
    ASSERT_FALSE(problem) << *problem;
    const DeviceSample sample = device.read(1e-3);
    EXPECT_TRUE(sample.is_valid);
    EXPECT_GE(sample.sequence, 1u);
    device.command({});
    device.stop();
  }
  EXPECT_GE(board->set_ups(), 3u);
}

TEST(HapiDevice, PositionMovesAsTheTipOfTheBoard) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiDevice device(settings_of(*board));
  ASSERT_FALSE(device.start());
  const DeviceSample rest = device.read(1e-3);
  const Vec2 rest_m = board->log().back().tip_m;
  const Vec2 hand_m(0.02, 0.06);
  board->set_hand(hand_m);
  // The encoders round each joint by half a step, twice. If a loaded machine has delayed answers,
  // so that the board was set up again, the hand has moved by less than 1 mm meanwhile.
  const double quantum_m = device.description().encoder_quantum_m;
  EXPECT_TRUE(wait_until([&] {
    const DeviceSample sample = device.read(1e-3);
    const Vec2 moved_m(sample.position_m[0] - rest.position_m[0],
                       sample.position_m[1] - rest.position_m[1]);
    const double bound_m = 4.0 * quantum_m + 1e-3 * static_cast<double>(board->set_ups() - 1);
    return (moved_m - (hand_m - rest_m)).norm() <= bound_m;
  }));
  device.command({});
  device.stop();
}

TEST(HapiDevice, NamesAMissingPort) {
  HapiSettings settings;
  settings.port = "/dev/palpate-no-such-port";
  const auto problem = HapiDevice(settings).start();
  ASSERT_TRUE(problem);
  EXPECT_EQ(*problem,
            "/dev/palpate-no-such-port: is missing; expected the serial port of a board (connect "
            "the board; the command ls /dev/ttyACM* lists ports)");
}

TEST(HapiDevice, NamesAPortThatIsNoTerminal) {
  for (const char* path : {"/dev/null", "/dev"}) {
    HapiSettings settings;
    settings.port = path;
    const auto problem = HapiDevice(settings).start();
    ASSERT_TRUE(problem);
    EXPECT_EQ(problem->find(std::string(path) + ": is not a terminal; expected"), 0u) << *problem;
  }
}

// Also for the superuser, whom TIOCEXCL does not stop.
TEST(HapiDevice, NamesABusyPort) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiDevice first(settings_of(*board));
  ASSERT_FALSE(first.start());
  HapiDevice second(settings_of(*board));
  const auto problem = second.start();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->find(board->path() + ": is used by another program; expected a free port"), 0u)
      << *problem;
  // The first driver goes on.
  const std::uint64_t before = first.read(1e-3).sequence;
  EXPECT_TRUE(wait_until([&] { return first.read(1e-3).sequence > before + 10; }));
  first.stop();
  EXPECT_FALSE(second.start());
}

// A terminal that is not raw echoes bytes, ends lines, and takes some bytes as commands.
TEST(SerialPort, PassesEveryByteInBothDirections) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const int board = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(board, 0);
  ASSERT_EQ(::grantpt(board), 0);
  ASSERT_EQ(::unlockpt(board), 0);
  auto port = SerialPort::open(::ptsname(board));
  ASSERT_TRUE(port) << port.error().to_string();
  std::array<std::uint8_t, 256> all;
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<std::uint8_t>(k);
  // read() never waits.
  std::array<std::uint8_t, 512> bytes;
  EXPECT_EQ(port->read(bytes), 0u);
  ASSERT_EQ(::write(board, all.data(), all.size()), std::ssize(all));
  std::size_t count = 0;
  EXPECT_TRUE(wait_until([&] {
    count += port->read(std::span(bytes).subspan(count)).value();
    return count >= all.size();
  }));
  EXPECT_TRUE(std::equal(all.begin(), all.end(), bytes.begin(), bytes.begin() + count));
  EXPECT_EQ(port->write(all), all.size());
  for (std::size_t read = 0; read < all.size();) {
    const ssize_t more = ::read(board, bytes.data() + read, bytes.size() - read);
    ASSERT_GT(more, 0);
    read += static_cast<std::size_t>(more);
  }
  EXPECT_TRUE(std::equal(all.begin(), all.end(), bytes.begin()));
  ::close(board);
  EXPECT_TRUE(wait_until([&] { return !port->read(bytes); }));
}

TEST(SerialPort, NamesTheGroupOfAPortThatIsNotPermitted) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  ASSERT_EQ(::chmod(board->path().c_str(), 0), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    // The superuser may open everything.
    if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) ::_exit(2);
    const auto port = SerialPort::open(board->path());
    const std::string text = port ? "" : port.error().to_string();
    const bool is_good =
        text.find(": is not permitted; expected a user in the group ") != std::string::npos &&
        text.find("sudo usermod -aG ") != std::string::npos;
    ::_exit(is_good ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(HapiDevice, NamesAPortWithoutAnAnswer) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  board->add_fault(fault_now(Kind::kSilence, kForEver_ns));
  HapiDevice device(settings_of(*board));
  const auto problem = device.start();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->find(board->path() + ": nobody answers within 2 s; expected a hAPI board"), 0u)
      << *problem;
  // A session still calls these.
  device.command({});
  device.stop();
}

// A device may be opened long before its session. What happened then was at zero force.
TEST(HapiDevice, ATripBeforeTheSessionIsNotATripOfTheSession) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiDevice device(settings_of(*board));
  ASSERT_FALSE(device.start());
  EXPECT_FALSE(device.read(1e-3).asks_for_trip);
  const std::uint64_t set_ups = board->set_ups();
  board->add_fault(fault_now(Kind::kSilence, 100'000'000));
  EXPECT_TRUE(wait_until([&] { return board->set_ups() > set_ups; }));
  EXPECT_TRUE(wait_until([&] { return !device.start() && !device.read(1e-3).asks_for_trip; }));
  device.command({});
  device.stop();
}

TEST(HapiDevice, AHangUpAsksForATrip) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiDevice device(settings_of(*board));
  ASSERT_FALSE(device.start());
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.sequence > 10; }));
  board->hang_up();
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.asks_for_trip; }));
  EXPECT_FALSE(device.health().is_good);
  EXPECT_NE(device.health().problem.find("disconnected"), std::string::npos);
  device.command({});
  device.stop();  // does not hang
}

TEST(HapiDevice, AHangUpBeforeTheFirstAnswerIsAnError) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiSettings settings = settings_of(*board);
  board->hang_up();
  EXPECT_TRUE(HapiDevice(settings).start());
}

TEST(HapiDevice, CountsLateAnswersAndGoesOn) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiDevice device(settings_of(*board));
  ASSERT_FALSE(device.start());
  const HapiCounts before = device.counts();
  BoardFault fault = fault_now(Kind::kDelay, 3'000'000);
  fault.delay_ns = 8'000'000;
  board->add_fault(fault);
  EXPECT_TRUE(push_until(device, [&](const auto&) {
    const HapiCounts now = device.counts();
    return now.missed > before.missed && now.late > before.late;
  }));
  const std::uint64_t answers = device.counts().answers;
  EXPECT_TRUE(
      push_until(device, [&](const auto&) { return device.counts().answers > answers + 50; }));
}

TEST(HapiDevice, SilenceAsksForATripAndTheBoardIsSetUpAgain) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiDevice device(settings_of(*board));
  ASSERT_FALSE(device.start());
  EXPECT_TRUE(push_until(device, [&](const auto&) { return !is_zero(board->log().back()); }));
  const std::uint64_t set_ups = board->set_ups();
  board->add_fault(fault_now(Kind::kSilence, 100'000'000));
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.asks_for_trip; }));
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return !sample.asks_for_trip; }));
  EXPECT_GT(board->set_ups(), set_ups);
  EXPECT_NE(device.health().problem.find("did not answer"), std::string::npos);
}

TEST(HapiDevice, CommandsZeroUntilItHasAGuardAndTripsWhenTheGuardHasGone) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiSettings settings = settings_of(*board);
  settings.works_without_guard = false;
  AtomicGuard guard;
  HapiDevice device(settings);
  ASSERT_FALSE(device.start());
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.sequence > 100; }));
  for (const BoardCommand& command : board->log()) ASSERT_TRUE(is_zero(command));
  device.set_guard(&guard);
  EXPECT_TRUE(push_until(device, [&](const auto&) { return !is_zero(board->log().back()); }));
  EXPECT_GT(guard.beats, 0u);
  guard.epoch = 1;
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.asks_for_trip; }));
  EXPECT_TRUE(push_until(device, [&](const auto&) { return guard.acknowledged == 1; }));
  guard.at_present = GuardState::kFrozen;
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.asks_for_trip; }));
  EXPECT_TRUE(wait_until([&] { return is_zero(board->log().back()); }));
  EXPECT_NE(device.health().problem.find("the guard of the motors is frozen"), std::string::npos);
  device.set_guard(nullptr);
}

TEST(HapiDevice, SaysHowToCalibrate) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const auto board = open_board();
  HapiSettings settings = settings_of(*board);
  settings.torque_per_Nm.reset();
  HapiDevice device(settings);
  ASSERT_FALSE(device.start());
  EXPECT_TRUE(device.motors_now().empty());
  EXPECT_NE(device.health().problem.find("to calibrate: "), std::string::npos);
  EXPECT_TRUE(push_until(device, [](const auto& sample) { return sample.sequence > 20; }));
  for (const BoardCommand& command : board->log()) ASSERT_TRUE(is_zero(command));
}

}  // namespace
}  // namespace palpate
