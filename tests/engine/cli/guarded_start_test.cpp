// `palpate run --device` whose guard is killed, stopped, or finds that the machine was suspended,
// at each step of its start. The simulated board's log is the judge of the force. The guard is the
// real one with a fault (tests/helpers/faulty_guard.cpp), beside a link to the program.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/devices/monotonic_clock.h"
#include "engine/simulation/board_terminal.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::Outcome;

constexpr int kRefused = 2;  // exit codes
constexpr int kTripped = 3;
constexpr int kMostRuns = 6;  // until the guard's fault comes before one of a busy machine
// A program that waits for a frozen guard takes 7 s: 5 s for its answer, and 2 s for its end.
constexpr std::int64_t kLongestEnd_ns = 5 * kSecond_ns;

// In the order of time. The guard's first word is its first send(); recv() gets the bell that arms
// it, which its second send() answers; ppoll() is its wait.
struct GuardStep {
  const char* call;
  const char* name;
};
constexpr GuardStep kBeforeReady[] = {{"recvmsg 1 before", "WaitsForItsOrders"},
                                      {"recvmsg 1 after", "HasTheDevice"},
                                      {"mlockall 1 before", "HasMappedTheMemory"},
                                      {"send 1 before", "IsAboutToSayThatItIsReady"}};
constexpr GuardStep kBeforeArmed[] = {{"send 1 after", "HasSaidThatItIsReady"},
                                      {"recv 1 before", "IsToBeArmed"},
                                      {"recv 1 after", "HasHeardThatItIsArmed"},
                                      {"send 2 before", "IsAboutToAnswer"}};
constexpr GuardStep kArmed[] = {{"send 2 after", "HasAnswered"},
                                {"ppoll 8 before", "IsAboutToWait"},
                                {"ppoll 8 after", "HasWatched"}};

struct GuardCase {
  GuardStep step;
  std::string fault;
  int exit_code;
  std::string words;
};

std::vector<GuardCase> all_cases() {
  std::vector<GuardCase> cases;
  for (const GuardStep& step : kBeforeReady) {
    cases.push_back({step, "kill", kRefused,
                     "palpate-guard: ended, or said nothing for 5 s, before it was ready"});
    cases.push_back(
        {step, "stop", kRefused, "palpate-guard: was stopped by a signal before it was ready"});
  }
  for (const GuardStep& step : kBeforeArmed) {
    cases.push_back({step, "kill", kRefused, "palpate-guard: has ended or does not answer"});
    cases.push_back({step, "stop", kRefused, "palpate-guard: is frozen"});
  }
  for (const GuardStep& step : kArmed) {
    cases.push_back({step, "kill", kTripped, "the guard of the motors has ended"});
    cases.push_back({step, "stop", kTripped, "the guard of the motors is frozen"});
  }
  // The engine has read the clock for the bell; a machine that was suspended before loses nothing.
  for (const GuardStep& step :
       {kBeforeArmed[1], kBeforeArmed[2], kBeforeArmed[3], kArmed[0], kArmed[1], kArmed[2]}) {
    cases.push_back({step, "suspend", kTripped, "the machine was suspended"});
  }
  return cases;
}

// What the guard has written when its fault came; process 0: it did not come.
struct GuardHit {
  int process = 0;
  std::int64_t time_ns = 0;
};

bool is_zero(const BoardCommand& command) {
  return std::abs(command.torques[0]) < 0x1p-119f && std::abs(command.torques[1]) < 0x1p-119f;
}

class GuardedStart : public ::testing::TestWithParam<GuardCase> {
 protected:
  void SetUp() override {
    PALPATE_NEEDS(test::lack_of_terminals());
    link_or_copy(PALPATE_PROGRAM, "palpate");
    link_or_copy(PALPATE_FAULTY_GUARD, "palpate-guard");
  }
  void TearDown() override {
    unsetenv("PALPATE_GUARD_STEP");
    unsetenv("PALPATE_GUARD_HIT");
  }

  // The program looks for its guard in its own folder.
  void link_or_copy(const char* from, const char* name) {
    std::error_code failed;
    std::filesystem::create_hard_link(from, folder.path(name), failed);
    if (failed) std::filesystem::copy_file(from, folder.path(name));
  }

  void run(const GuardCase& c) {
    auto opened = BoardTerminal::open({});
    ASSERT_TRUE(opened) << opened.error().to_string();
    board = std::move(*opened);
    std::filesystem::remove_all(folder.path("out"));
    std::filesystem::remove(folder.path("hit"));
    setenv("PALPATE_GUARD_STEP", (std::string(c.step.call) + " " + c.fault).c_str(), 1);
    setenv("PALPATE_GUARD_HIT", folder.path("hit").c_str(), 1);
    const std::string port = "hapi:port=" + board->path() + ",torque-per-Nm=1,peak-torque=0.1";
    outcome = test::outcome_of(
        test::start_program(folder,
                            {"run", test::kStar, "--fit", "auto", "--device", port, "--seconds",
                             "60", "--out", folder.path("out"), "--json", "--without-realtime"},
                            {}, folder.path("palpate").c_str()));
    end_ns = monotonic_ns();
    hit = {};
    std::ifstream(folder.path("hit")) >> hit.process >> hit.time_ns;
  }

  // What holds also if a busy machine made the end.
  void expect_zero() const {
    const auto log = board->log();
    EXPECT_TRUE(std::all_of(log.begin(), log.end(), is_zero));
    EXPECT_TRUE(outcome.exit_code == kRefused || outcome.exit_code == kTripped)
        << outcome.exit_code << " " << outcome.err;
  }

  // What was told of the guard; empty if something else ended the run before.
  std::string told() const {
    if (hit.process == 0) return {};
    if (outcome.exit_code != kTripped) return outcome.err;
    const json problem = json::parse(outcome.out).at("device").at("problem");
    return problem.is_string() ? problem.get<std::string>() : std::string();
  }

  void expect_results() const {
    const json result = json::parse(outcome.out);
    EXPECT_EQ(result.at("tripped"), true);
    EXPECT_EQ(result.at("runs").at(0).at("governor").at("last_trip").at("reason"), "device");
    EXPECT_GT(result.at("runs").at(0).at("ticks"), 0);
    EXPECT_TRUE(std::filesystem::exists(folder.path("out/trace-off.csv")));
  }

  test::TemporaryFolder folder;
  std::unique_ptr<BoardTerminal> board;
  Outcome outcome;
  GuardHit hit;
  std::int64_t end_ns = 0;
};

TEST_P(GuardedStart, EndsWithZeroForceAndTheReason) {
  const GuardCase& c = GetParam();
  for (int n = 0; n < kMostRuns; ++n) {
    ASSERT_NO_FATAL_FAILURE(run(c));
    expect_zero();
    if (told().find(c.words) == std::string::npos) {
      std::cout << "something else came first: " << outcome.err;
      continue;
    }
    EXPECT_EQ(outcome.exit_code, c.exit_code) << outcome.err;
    EXPECT_NE(::kill(hit.process, 0), 0);  // the guard is not left behind
    EXPECT_LT(end_ns - hit.time_ns, kLongestEnd_ns);
    if (c.exit_code == kTripped) {
      expect_results();
    } else {
      EXPECT_EQ(outcome.out, "");
      EXPECT_FALSE(std::filesystem::exists(folder.path("out")));
    }
    return;
  }
  ADD_FAILURE() << "no run that ended because of the guard";
}

INSTANTIATE_TEST_SUITE_P(Guard, GuardedStart, ::testing::ValuesIn(all_cases()),
                         [](const auto& instance) {
                           return instance.param.step.name + ("_" + instance.param.fault);
                         });

}  // namespace
}  // namespace palpate
