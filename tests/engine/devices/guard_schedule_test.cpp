// Random schedules of faults with real processes. The board's log is the judge.

#include <csignal>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/random.h"
#include "tests/engine/devices/board_terminal.h"
#include "tests/engine/devices/engine_process.h"
#include "tests/helpers/needs.h"
#include "tests/helpers/sanitizers.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using Entry = FakeBoardTerminal::Entry;

constexpr std::uint64_t kZerosBeforeForce = 50;  // of guarded_engine after a trip

constexpr int kSchedules = test::kHasSanitizer ? 10 : 50;

void sleep_for_ms(double ms) {
  std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(ms));
}

// Something from which the engine recovers.
void disturb(SeededRandom& random, FakeBoardTerminal& board, const EngineProcess& process) {
  switch (random.index(4)) {
    case 0:  // shorter or longer than a stale heartbeat
      process.engine().send(SIGSTOP);
      sleep_for_ms(random.uniform(0.0, 60.0));
      process.engine().send(SIGCONT);
      break;
    case 1:
      board.pause(true);
      sleep_for_ms(random.uniform(0.0, 40.0));
      board.pause(false);
      break;
    case 2:
      process.guard().send(random.index(2) == 0 ? SIGTERM : SIGHUP);
      break;
    default:
      process.engine().send(SIGSTOP);
      board.flood();
      sleep_for_ms(random.uniform(0.0, 40.0));
      process.engine().send(SIGCONT);
      // A board that still waits for room after the end of the guard could read no zero.
      EXPECT_TRUE(wait_for([&] { return !board.is_flooding(); }, 20.0));
  }
  sleep_for_ms(random.uniform(0.0, 100.0));
}

// Something after which no force may come. Returns its name.
const char* end_force(SeededRandom& random, const EngineProcess& process) {
  switch (random.index(5)) {
    case 0:
      process.engine().send(SIGKILL);
      return "engine killed";
    case 1:
      process.engine().send(SIGSEGV);
      return "engine crashed";
    case 2:
      process.engine().send(SIGSTOP);
      return "engine frozen";
    case 3:
      process.engine().send(SIGSTOP);
      sleep_for_ms(random.uniform(0.0, 30.0));
      process.engine().send(SIGKILL);
      return "engine frozen and killed";
    default:
      process.guard().send(SIGKILL);
      return "guard killed";
  }
}

// A force after a zero is the one command that slipped, or follows the zeros of a rearmed engine.
void expect_only_slips(const std::vector<Entry>& log) {
  for (std::size_t i = 1; i < log.size(); ++i) {
    if (log[i].is_zero) continue;
    EXPECT_TRUE(log[i].count == 1 || log[i - 1].count >= kZerosBeforeForce)
        << "entry " << i << ": " << log[i].count << " forces after " << log[i - 1].count
        << " zeros";
  }
}

void run_schedule(std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  SeededRandom random(seed);
  const BusyProcesses load(random.index(2) == 0 ? 0 : 4);
  FakeBoardTerminal board(FakeBoardTerminal::Kind::kTerminal, random.index(2) == 0
                                                                  ? ResetKind::kGivesMotorsToDevice0
                                                                  : ResetKind::kKeepsEverything);
  const EngineProcess process(PALPATE_GUARDED_ENGINE, board.port(),
                              random.index(2) == 0 ? "watch" : "watch-no-fifo");
  ASSERT_TRUE(process.has_started());
  // A busy machine may delay the engine so that it trips and rearms several times.
  ASSERT_TRUE(wait_for([&] { return !board.is_zero(); }, 20.0));
  for (std::uint64_t i = random.index(4); i > 0; --i) disturb(random, board, process);
  const char* name = end_force(random, process);
  EXPECT_TRUE(wait_for([&] { return board.is_zero(); })) << name;
  sleep_for_ms(150.0);
  EXPECT_TRUE(wait_for([&] { return board.is_zero(); })) << name;
  const std::size_t entries = board.log().size();
  sleep_for_ms(100.0);
  EXPECT_EQ(board.log().size(), entries) << name;  // still zero
  expect_only_slips(board.log());
}

TEST(GuardSchedules, EndWithZeroForce) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const std::uint64_t first = test::from_environment("PALPATE_FIRST_SEED", 1);
  const int count = test::in_soak_or_else(500, kSchedules);
  std::printf("seeds from %d on, %d schedules\n", static_cast<int>(first), count);
  for (int i = 0; i < count && !::testing::Test::HasFailure(); ++i) {
    run_schedule(first + static_cast<std::uint64_t>(i));
  }
}

}  // namespace
}  // namespace palpate
