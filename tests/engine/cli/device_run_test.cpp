// `palpate run --device`: the program with its guard, and a simulated board behind a
// pseudo-terminal. The board's log is the judge. No test asserts a time: each one waits until
// something happens.
//
// A busy machine can delay an answer of the board so far that the run trips, as it must. What every
// run owes is expected then as well; the test makes another run for the rest.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <linux/capability.h>
#include <memory>
#include <optional>
#include <string>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/cli/program_signals.h"
#include "engine/devices/five_bar.h"
#include "engine/devices/stiffness_zones.h"
#include "engine/simulation/board_terminal.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::content_of;
using test::Outcome;
using test::outcome_of;
using test::run_program;
using test::start_program;
using test::StartedProgram;
using test::TemporaryFolder;

// In the frame of the linkage. The board starts in its rest pose; the wall of wall_scene() is 13 mm
// further along y.
const Vec2 kRest_m(0.01, 0.0360555);
const Vec2 kPressed_m(0.01, 0.070);
constexpr double kWall_m = 0.0496;
constexpr int kMostRuns = 6;  // until one has no trip
constexpr int kTripped = 3;   // exit code

bool wait_until(const std::function<bool()>& is_true) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < end) {
    if (is_true()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

bool is_zero(const BoardCommand& command) {
  return std::abs(command.torques[0]) < 0x1p-119f && std::abs(command.torques[1]) < 0x1p-119f;
}

bool has_force(const BoardTerminal& board) {
  const auto log = board.log();
  return std::any_of(log.begin(), log.end(), [](const BoardCommand& c) { return !is_zero(c); });
}

// A box of 0.04 m, whose front is at y = -0.005 m in the frame of the device. The origin of that
// frame is the middle of the workspace: (0.01, 0.0546) m in the frame of the linkage.
std::string wall_scene(const TemporaryFolder& folder,
                       std::optional<double> stiffness_N_per_m = {}) {
  test::GltfBuilder gltf;
  std::vector<Eigen::Vector3f> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back((k & 1) != 0 ? 0.02f : -0.02f, (k & 2) != 0 ? 0.035f : -0.005f,
                         (k & 4) != 0 ? 0.02f : -0.02f);
  }
  const auto positions = gltf.add_positions(corners);
  const auto indices = gltf.add_indices({0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
  gltf.add_mesh({{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}});
  if (stiffness_N_per_m) {
    gltf.json["materials"] = {
        {{"name", "hard"}, {"extras", {{"palpate", {{"stiffness", *stiffness_N_per_m}}}}}}};
    gltf.json["meshes"][0]["primitives"][0]["material"] = 0;
  }
  gltf.add_node({{"mesh", 0}});
  return gltf.write_glb(folder);
}

// Whether a child process has ended; it is not yet waited for.
bool has_ended(const StartedProgram& started) {
  siginfo_t state = {};
  return ::waitid(P_PID, static_cast<id_t>(started.process), &state, WEXITED | WNOHANG | WNOWAIT) ==
             0 &&
         state.si_pid != 0;
}

// The guard of a program; 0: none.
pid_t guard_of(const StartedProgram& started) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream file(entry.path() / "stat");
    std::string number, command, state;
    pid_t parent = 0;
    file >> number >> command >> state >> parent;
    if (parent == started.process && command == "(palpate-guard)") return std::stoi(number);
  }
  return 0;
}

class DeviceRunProgram : public ::testing::Test {
 protected:
  DeviceRunProgram() : scene(wall_scene(folder)) {
    std::signal(SIGHUP, SIG_DFL);  // the program inherits it
  }
  void SetUp() override {
    PALPATE_NEEDS(test::lack_of_terminals());
    open_board();
  }

  void open_board() {
    board.reset();
    auto opened = BoardTerminal::open({});
    ASSERT_TRUE(opened) << opened.error().to_string();
    board = std::move(*opened);
  }
  std::string device() const {
    return "hapi:port=" + board->path() + ",torque-per-Nm=1,peak-torque=0.1";
  }
  // The tests must also run where the system refuses SCHED_FIFO. The simulated hand holds the
  // device firmly, so that 1,000 N/m is calm also where a busy machine makes the delay long.
  std::vector<std::string> arguments(const std::string& seconds,
                                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = {
        "run",   scene,   "--device",         device(), "--seconds",
        seconds, "--out", folder.path("out"), "--json", "--without-realtime"};
    if (std::find(more.begin(), more.end(), "--stiffness") == more.end()) {
      all.insert(all.end(), {"--stiffness", "1000", "--allow-unstable", "a firm simulated hand"});
    }
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  bool has_trace() const { return std::filesystem::exists(folder.path("out/trace-off.csv")); }

  // Waits for this number of further commands. False if the program ends before.
  bool wait_for_commands(const StartedProgram& started, std::uint64_t count) const {
    const std::uint64_t wanted = board->commands() + count;
    return wait_until([&] { return board->commands() >= wanted || has_ended(started); }) &&
           !has_ended(started);
  }
  // Presses in, after the hand was calm for long enough that the governor has let the force grow,
  // until the board gets a force. On a busy machine the hand may have pressed in too early; then
  // the governor waits until it is calm again. False if the program ends before.
  bool press(const StartedProgram& started) const {
    for (int n = 0; n < kMostRuns; ++n) {
      board->set_hand(kRest_m);
      if (!wait_for_commands(started, 800)) return false;
      board->set_hand(kPressed_m);
      if (!wait_for_commands(started, 300)) return false;
      if (has_force(*board)) return true;
    }
    return false;
  }
  // Starts a run of a minute on a new board, and returns when the board gets a force.
  StartedProgram start_pressed(const std::vector<std::string>& more = {}) {
    for (int n = 0; n < kMostRuns; ++n) {
      open_board();
      const StartedProgram started = start_program(folder, arguments("60", more));
      if (press(started)) return started;
      ::kill(started.process, SIGTERM);
      const Outcome outcome = outcome_of(started);
      expect_zero_at_last();
      EXPECT_TRUE(outcome.exit_code == kTripped) << outcome.exit_code << " " << outcome.err;
    }
    ADD_FAILURE() << "no run without a trip";
    return {};
  }
  void expect_zero_at_last() const {
    EXPECT_TRUE(wait_until([&] { return is_zero(board->log().back()); }));
  }
  // One line that contains the text, exit code 2, and no force.
  // lines: on stderr; a run on an open device has told its limits before.
  void expect_refused(const Outcome& outcome, const std::string& text, int lines = 1) const {
    EXPECT_EQ(outcome.exit_code, 2) << text;
    EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), lines) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_FALSE(std::filesystem::exists(folder.path("out"))) << text;
    EXPECT_FALSE(has_force(*board)) << text;
  }

  TemporaryFolder folder;
  std::string scene;
  std::unique_ptr<BoardTerminal> board;
};

// The force at the tip that a command means.
Vec2 force_of(const BoardCommand& command) {
  const auto jacobian = FiveBar(FiveBarLinks{}).jacobian(command.joints_rad);
  const Vec2 torques_Nm(static_cast<double>(command.torques[0]),
                        static_cast<double>(command.torques[1]));
  return jacobian ? Vec2(jacobian->transpose().inverse() * torques_Nm) : Vec2::Zero();
}

TEST_F(DeviceRunProgram, AHandFeelsTheWallAfterTheStartRampAndNothingAtTheEnd) {
  for (int n = 0; n < kMostRuns; ++n) {
    open_board();
    const StartedProgram started = start_program(folder, arguments("3"));
    const bool has_pressed = press(started);
    const Outcome outcome = outcome_of(started);
    expect_zero_at_last();
    ASSERT_TRUE(has_trace()) << outcome.err;
    const json result = json::parse(outcome.out);
    if (!has_pressed || result.at("tripped")) continue;
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(result.at("interrupted"), false);
    EXPECT_EQ(result.at("device").at("guard"), true);
    EXPECT_EQ(result.at("device").at("problem"), nullptr);
    ASSERT_EQ(result.at("runs").size(), 1u);
    const json& run = result.at("runs").at(0);
    EXPECT_EQ(run.at("a4"), false);
    EXPECT_GT(run.at("contact_ticks"), 0);
    EXPECT_FALSE(run.contains("comparable"));
    const std::string trace = content_of(folder.path("out/trace-off.csv"));
    EXPECT_EQ(std::count(trace.begin(), trace.end(), '\n'), 1 + run.at("ticks").get<long>());
    // The chart of the stiffness has its setting in it.
    EXPECT_NE(
        content_of(folder.path("out/stiffness.svg")).find("the setting, 1 kN/m at a delay of "),
        std::string::npos);
    EXPECT_EQ(content_of(folder.path("out/stiffness.csv")).find("rate_Hz,delay_s,"), 0u);

    const auto log = board->log();
    const auto first =
        std::find_if(log.begin(), log.end(), [](const auto& c) { return !is_zero(c); });
    ASSERT_NE(first, log.end());
    // The governor waits for a calm hand for 100 ms; a busy machine only prolongs this.
    EXPECT_GE(first->time_ns - log.front().time_ns, 100'000'000);
    const auto last =
        std::find_if(log.rbegin(), log.rend(), [](const auto& c) { return !is_zero(c); });
    EXPECT_LT(force_of(*last).y(), 0.0) << "the wall pushes back";
    EXPECT_GT(last->tip_m.y(), kWall_m) << "the hand presses into the wall";
    EXPECT_LT(last->tip_m.y(), 0.5 * (kWall_m + kPressed_m.y())) << "the wall holds the hand";
    return;
  }
  ADD_FAILURE() << "no run without a trip";
}

TEST_F(DeviceRunProgram, ASignalEndsTheRunWithZeroAndResults) {
  for (const int signal : kEndingSignals) {
    const StartedProgram started = start_pressed();
    ASSERT_NE(started.process, 0);
    ::kill(started.process, signal);
    const Outcome outcome = outcome_of(started);
    EXPECT_EQ(outcome.exit_code, 128 + signal) << outcome.err;
    expect_zero_at_last();
    EXPECT_TRUE(has_trace());
    const json result = json::parse(outcome.out);
    EXPECT_EQ(result.at("interrupted"), true);
    EXPECT_LT(result.at("runs").at(0).at("ticks"), 60'000);
    EXPECT_GT(result.at("runs").at(0).at("contact_ticks"), 0);
  }
}

TEST_F(DeviceRunProgram, APulledCableIsATripWithResults) {
  const StartedProgram started = start_pressed();
  ASSERT_NE(started.process, 0);
  board->hang_up();
  const Outcome outcome = outcome_of(started);
  EXPECT_EQ(outcome.exit_code, kTripped) << outcome.err;
  EXPECT_NE(outcome.err.find("the force was cut, and the run ended: "), std::string::npos)
      << outcome.err;
  EXPECT_TRUE(has_trace());
  const json result = json::parse(outcome.out);
  EXPECT_EQ(result.at("tripped"), true);
  EXPECT_EQ(result.at("interrupted"), false);
  EXPECT_EQ(result.at("runs").at(0).at("interrupted"), false);
  EXPECT_LT(result.at("runs").at(0).at("ticks"), 60'000) << "the trip ends the run";
  EXPECT_EQ(result.at("runs").at(0).at("governor").at("last_trip").at("reason"), "device");
  const std::string problem = result.at("device").at("problem");
  EXPECT_NE(problem.find("the port was disconnected"), std::string::npos) << problem;
}

TEST_F(DeviceRunProgram, AKilledGuardIsATripWithZeroAndResults) {
  for (int n = 0; n < kMostRuns; ++n) {
    const StartedProgram started = start_pressed();
    ASSERT_NE(started.process, 0);
    const pid_t guard = guard_of(started);
    if (guard != 0) ::kill(guard, SIGKILL);
    const Outcome outcome = outcome_of(started);
    EXPECT_EQ(outcome.exit_code, kTripped) << outcome.err;
    expect_zero_at_last();
    EXPECT_TRUE(has_trace());
    const json result = json::parse(outcome.out);
    const std::string problem = result.at("device").at("problem");
    if (problem.find("the guard of the motors has ended") != std::string::npos) return;
    std::cout << "another trip came first: " << outcome.err;
  }
  ADD_FAILURE() << "no run in which the guard was killed before another trip";
}

TEST_F(DeviceRunProgram, AFrozenGuardIsATripToldAsSuchWithZeroAndResults) {
  for (int n = 0; n < kMostRuns; ++n) {
    const StartedProgram started = start_pressed();
    ASSERT_NE(started.process, 0);
    const pid_t guard = guard_of(started);
    if (guard != 0) ::kill(guard, SIGSTOP);
    const Outcome outcome = outcome_of(started);
    EXPECT_EQ(outcome.exit_code, kTripped) << outcome.err;
    expect_zero_at_last();
    EXPECT_TRUE(has_trace());
    EXPECT_NE(::kill(guard, 0), 0);  // it is not left behind
    const json result = json::parse(outcome.out);
    const std::string problem = result.at("device").at("problem");
    if (problem.find("the guard of the motors is frozen") == std::string::npos) {
      std::cout << "another trip came first: " << outcome.err;
      continue;
    }
    EXPECT_NE(outcome.err.find("palpate-guard: is frozen"), std::string::npos) << outcome.err;
    return;
  }
  ADD_FAILURE() << "no run in which the guard was frozen before another trip";
}

// The trace needs a few hundred bytes a tick.
TEST_F(DeviceRunProgram, OnAFullDiskTheResultsArePrinted) {
  StartedProgram started;
  {
    const test::FileSizeLimit limit(300'000);
    started = start_program(folder, arguments("2"));
  }
  const Outcome outcome = outcome_of(started);
  expect_zero_at_last();
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_FALSE(has_trace());
  EXPECT_NE(outcome.err.find(folder.path("out") + "/trace-off.csv"), std::string::npos)
      << outcome.err;
  const json result = json::parse(outcome.out);
  EXPECT_EQ(result.at("runs").size(), 1u);
  EXPECT_EQ(result.at("device").at("guard"), true);
}

TEST_F(DeviceRunProgram, TheGuardStopsTheMotorsOfAKilledProgram) {
  const StartedProgram started = start_pressed();
  ASSERT_NE(started.process, 0);
  ::kill(started.process, SIGKILL);
  EXPECT_EQ(outcome_of(started).exit_code, -1);
  expect_zero_at_last();
}

TEST_F(DeviceRunProgram, WithA4ItWritesItsOwnTrace) {
  const StartedProgram started = start_pressed({"--a4", "on", "--cpu", "0"});
  ASSERT_NE(started.process, 0);
  ::kill(started.process, SIGINT);
  const Outcome outcome = outcome_of(started);
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder.path("out/trace-on.csv")));
  EXPECT_FALSE(has_trace());
  EXPECT_EQ(json::parse(outcome.out)["runs"][0]["a4"], true);
  expect_zero_at_last();
}

// Contact, turning motors, a trip by the device or none: a recording replays to the bit.
TEST_F(DeviceRunProgram, RecordsWhatReplaysToTheBit) {
  const std::string recording = folder.path("pressed.palpate");
  StartedProgram started;
  for (int n = 0; n < kMostRuns && started.process == 0; ++n) {
    std::filesystem::remove(recording);
    open_board();
    started = start_program(folder, arguments("60", {"--a4", "on", "--record", recording}));
    if (press(started)) break;
    ::kill(started.process, SIGTERM);
    outcome_of(started);
    started = {};
  }
  ASSERT_NE(started.process, 0) << "no run without a trip";
  board->hang_up();
  const Outcome outcome = outcome_of(started);
  EXPECT_EQ(outcome.exit_code, kTripped) << outcome.err;
  const json result = json::parse(outcome.out);
  ASSERT_EQ(result.at("recordings").size(), 1u);
  EXPECT_EQ(result.at("recordings").at(0).at("ticks"), result.at("runs").at(0).at("ticks"));
  EXPECT_GT(result.at("runs").at(0).at("contact_ticks"), 0);
  const Outcome info = run_program(folder, {"recording", "info", recording});
  EXPECT_NE(info.out.find("  ended         trip ("), std::string::npos) << info.out;
  const Outcome replayed = run_program(folder, {"replay", recording});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
}

// The box is moved over the rest pose. The recording holds what was decided, and replays.
TEST_F(DeviceRunProgram, ARecordingSaysThatTheHandBeganInside) {
  const std::string inside = "the hand begins inside the closed surface of node \"node 0\"";
  for (const std::string choice : {"leave", "stay"}) {
    const std::string recording = folder.path(choice + ".palpate");
    const Outcome outcome =
        run_program(folder, arguments("2", {"--place", "0 -0.03 0 1 0 0 0", "--start-inside",
                                            choice, "--record", recording}));
    ASSERT_NE(outcome.out, "") << outcome.err;
    const json result = json::parse(outcome.out);
    EXPECT_EQ(result.at("start_inside").at("node"), "node 0") << outcome.err;
    const Outcome info = run_program(folder, {"recording", "info", recording, "--json"});
    const std::string expected =
        inside + (choice == "stay" ? " and stays there; force begins"
                                   : "; there is no force until it has left");
    EXPECT_EQ(json::parse(info.out)[0]["start_inside"], expected);
    const Outcome text = run_program(folder, {"recording", "info", recording});
    EXPECT_NE(text.out.find("\n  start         " + expected + "\n"), std::string::npos) << text.out;
    const Outcome replayed = run_program(folder, {"replay", recording});
    EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
    open_board();
  }
  const std::string recording = folder.path("outside.palpate");
  run_program(folder, arguments("2", {"--record", recording}));
  const Outcome info = run_program(folder, {"recording", "info", recording, "--json"});
  EXPECT_TRUE(json::parse(info.out)[0]["start_inside"].is_null()) << info.out;
}

TEST_F(DeviceRunProgram, WithoutAGuardTheRunWarnsAndWorks) {
  const StartedProgram started = start_pressed({"--no-guard"});
  ASSERT_NE(started.process, 0);
  EXPECT_EQ(guard_of(started), 0);
  ::kill(started.process, SIGINT);
  const Outcome outcome = outcome_of(started);
  EXPECT_EQ(outcome.exit_code, 130);
  EXPECT_NE(outcome.err.find("palpate: warning: no process guards the motors"), std::string::npos)
      << outcome.err;
  EXPECT_EQ(json::parse(outcome.out)["device"]["guard"], false);
  expect_zero_at_last();
}

// Also as root, whom the lock of a terminal does not stop.
TEST_F(DeviceRunProgram, RefusesABusyPort) {
  for (int n = 0; n < kMostRuns; ++n) {
    const StartedProgram started = start_program(folder, arguments("60"));
    const bool has_begun = wait_for_commands(started, 1);
    const TemporaryFolder other;
    const Outcome second =
        run_program(other, {"run", scene, "--device", device(), "--without-realtime"});
    const bool has_gone_on = has_begun && wait_for_commands(started, 10);
    ::kill(started.process, SIGTERM);
    const Outcome first = outcome_of(started);
    if (!has_gone_on) continue;
    EXPECT_EQ(first.exit_code, 143) << first.err;
    EXPECT_EQ(second.exit_code, 2);
    EXPECT_EQ(second.err.find("palpate: " + board->path() + ": is used by another program"), 0u)
        << second.err;
    EXPECT_FALSE(std::filesystem::exists(other.path("out")));
    return;
  }
  ADD_FAILURE() << "no run without a trip";
}

TEST_F(DeviceRunProgram, RefusesBadOptionsInOneLine) {
  const std::string port = "hapi:port=" + board->path();
  struct Case {
    std::vector<std::string> arguments;
    std::string text;
  };
  for (const Case& c : std::vector<Case>{
           {{"--device", "falcon:port=x"}, "--device: driver is \"falcon\"; expected hapi"},
           {{"--device", "hapi"}, "--device: port: is missing"},
           {{"--device", port + ",color=red"}, "--device: key is \"color\"; expected one of"},
           {{"--device", "hapi:port=/dev/palpate-none"}, "/dev/palpate-none: is missing"},
           {{"--device", "hapi:port=/dev/null"}, "/dev/null: is not a terminal"},
           {{"--device", port, "--virtual"}, "--virtual: is for the simulated hand"},
           {{"--device", port, "--seed", "2"}, "--seed: is for the simulated hand"},
           {{"--device", port, "--workspace", "1"}, "--workspace: is for the simulated hand"},
           {{"--device", port, "--a4", "compare"}, "--a4: is compare; expected on or off"},
           {{"--device", port, "--sensors", "3"}, "--sensors: is 3; expected 2"},
           {{"--device", port, "--strategy", "full", "--a4", "off"},
            "--strategy: is given beside --a4"},
           {{"--device", port, "--strategy", "full", "--actuators", "1"},
            "--strategy: is full; expected another one for a device with 2 sensors and 1 motor"},
           {{"--device", port + ",torque-per-Nm=1,peak-torque=0.1", "--max-force", "100"},
            "--max-force: is 100 N; expected at most"},
           {{"--device", port, "--seconds", "1"}, "--seconds: "},
           {{"--no-guard"}, "--no-guard: is given alone; expected --device beside it"},
           {{"--stiffness", "auto"}, "--stiffness: is auto; expected a number without --device"},
           {{"--allow-unstable", "x"}, "--allow-unstable: is given alone; expected --device"},
           {{"--device", port, "--allow-unstable", ""}, "--allow-unstable: has an empty value"},
           {{"--cpu", "0"}, "--cpu: is given alone; expected --device beside it"},
           {{"--energy-budget", "motors=1"}, "--energy-budget: is given alone; expected --device"},
           {{"--device", port, "--energy-budget", "motors"},
            "--energy-budget: is \"motors\"; expected SOURCE=MJ or SOURCE=MJ,W with 0 to 1000 mJ "
            "and 0 to 1 W"},
           {{"--device", port, "--energy-budget", "motor=1"},
            "\"motor=1\", whose source is none of motors, nodes, vibration, restitution, magnet, "
            "gravity, other; expected SOURCE=MJ"},
           {{"--device", port, "--energy-budget", "motors=1,2,3"}, "--energy-budget: is \"motors"},
           {{"--device", port, "--energy-budget", "motors=1,"}, "--energy-budget: is \"motors"},
           {{"--device", port, "--energy-budget", "motors=,1"}, "--energy-budget: is \"motors"},
           {{"--device", port, "--energy-budget", "motors=1001"}, "--energy-budget: is \"motors"},
           {{"--device", port, "--energy-budget", "motors=1,1.1"}, "--energy-budget: is \"motors"},
           {{"--device", port, "--energy-budget", "motors=-1"}, "--energy-budget: is \"motors"},
           {{"--device", port, "--energy-budget", "motors=1", "--energy-budget", "motors=2"},
            "\"motors=2\", which states the source again; expected"},
       }) {
    std::vector<std::string> arguments = {"run", scene};
    arguments.insert(arguments.end(), c.arguments.begin(), c.arguments.end());
    expect_refused(run_program(folder, arguments), c.text);
  }
}

// The line that begins with this text; empty if there is none.
std::string line_with(const std::string& text, const std::string& begin) {
  const std::size_t at = text.find(begin);
  return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
}

// The program measures the delay of the board, and takes half of the stable limit at its worst end.
TEST_F(DeviceRunProgram, WithoutAStiffnessItTakesTheStableOneOfTheMeasuredDelay) {
  const Outcome outcome =
      run_program(folder, {"run", scene, "--device", device(), "--seconds", "2", "--json",
                           "--without-realtime", "--out", folder.path("out")});
  ASSERT_NE(outcome.out, "") << outcome.err;
  const json result = json::parse(outcome.out);
  const json& stiffness = result.at("stiffness");
  EXPECT_EQ(stiffness.at("auto"), true);
  EXPECT_EQ(stiffness.at("zone"), "stable");
  EXPECT_EQ(stiffness.at("mass_kg"), 0.1);
  EXPECT_EQ(stiffness.at("assumed").at("mass_of"), "bare tip");
  EXPECT_TRUE(stiffness.at("assumed").at("delay_of").is_null());
  const double most_s = stiffness.at("delay_s").at(1);
  EXPECT_GT(most_s, 0.3e-3) << "the board answers after 0.3 ms";
  EXPECT_DOUBLE_EQ(stiffness.at("stiffness_N_per_m"),
                   kAutoPart * stiffness.at("stable_N_per_m").get<double>());
  EXPECT_GT(stiffness.at("stable_N_per_m"), stiffness.at("passive_N_per_m"));
  EXPECT_GT(result.at("device").at("line").at("at_start_Hz"), 0.0);
  EXPECT_NE(line_with(outcome.err,
                      "palpate: the device: mass 0.1 kg (assumed, of a bare tip), "
                      "damping 0.5 N s/m (assumed, of a bare tip), delay from a "
                      "sample to its force "),
            "")
      << outcome.err;
  const std::string chosen = line_with(outcome.err, "palpate: stiffness ");
  EXPECT_NE(chosen.find(" N/m (auto: 0.5 of the stable limit): stable"), std::string::npos)
      << outcome.err;
}

// 1,000 N/m is more than a bare tip holds without damping, and less than it holds with the largest.
TEST_F(DeviceRunProgram, AStiffnessBeyondTheStableLimitIsCalmOnlyByTheController) {
  const Outcome outcome = run_program(folder, arguments("2", {"--stiffness", "500"}));
  ASSERT_NE(outcome.out, "") << outcome.err;
  EXPECT_EQ(json::parse(outcome.out).at("stiffness").at("zone"), "calm only by the controller");
  EXPECT_NE(outcome.err.find("palpate: stiffness 500 N/m: calm only by the controller"),
            std::string::npos)
      << outcome.err;
}

TEST_F(DeviceRunProgram, RefusesAStiffnessThatNoDampingHoldsWithTheValueThatFits) {
  const std::string expected = "--stiffness: is 100000 N/m; expected at most ";
  const Outcome refused = run_program(folder, arguments("2", {"--stiffness", "100000"}));
  expect_refused(refused, expected);
  const std::size_t at = refused.err.find(expected) + expected.size();
  const std::string fitting = refused.err.substr(at, refused.err.find(' ', at) - at);
  EXPECT_GT(std::stod(fitting), 0.0) << refused.err;
  const TemporaryFolder other;
  scene = wall_scene(other, 100'000.0);
  expect_refused(run_program(folder, arguments("2", {"--stiffness", "auto"})),
                 "material \"hard\": stiffness: is 100000 N/m; expected at most ");
  scene = wall_scene(other);
  const std::string recording = folder.path("unstable.palpate");
  const Outcome allowed =
      run_program(folder, arguments("2", {"--stiffness", "100000", "--allow-unstable",
                                          "a test of the limits", "--record", recording}));
  ASSERT_NE(allowed.out, "") << allowed.err;
  const json stiffness = json::parse(allowed.out).at("stiffness");
  EXPECT_EQ(stiffness.at("zone"), "refused");
  EXPECT_EQ(stiffness.at("allow_unstable"), "a test of the limits");
  EXPECT_NE(allowed.err.find("unstable, and allowed, because: a test of the limits"),
            std::string::npos)
      << allowed.err;
  const Outcome info = run_program(folder, {"recording", "info", recording, "--json"});
  EXPECT_EQ(json::parse(info.out)[0]["meta"]["allow_unstable"], "a test of the limits") << info.out;
  EXPECT_EQ(run_program(folder, {"replay", recording}).exit_code, 0);
}

TEST_F(DeviceRunProgram, TellsEnergyBudgetsThatAreNotTheInitialOnesAndKeepsThem) {
  const std::string recording = folder.path("budgets.palpate");
  const Outcome outcome = run_program(
      folder, arguments("2", {"--energy-budget", "motors=100", "--energy-budget", "nodes=0,0.2",
                              "--record", recording, "--stiffness", "auto"}));
  ASSERT_NE(outcome.out, "") << outcome.err;
  EXPECT_NE(outcome.err.find("palpate: energy budgets: motors 100 mJ at once and 0.25 W for ever "
                             "(default 250 mJ and 0.25 W); nodes 0 mJ at once and 0.2 W for ever "
                             "(default 50 mJ and 0.5 W)\n"),
            std::string::npos)
      << outcome.err;
  const json budgets = json::parse(outcome.out).at("device").at("energy_budgets");
  EXPECT_EQ(budgets.at("motors").at("tank_J"), 0.1);
  EXPECT_EQ(budgets.at("gravity").at("tank_J"), 1.0);
  const Outcome info = run_program(folder, {"recording", "info", recording, "--json"});
  const json meta = json::parse(info.out)[0]["meta"];
  EXPECT_EQ(meta.at("session.energy_budgets.motors_J"), 0.1);
  EXPECT_EQ(meta.at("session.energy_budgets.nodes_W"), 0.2);
  EXPECT_EQ(run_program(folder, {"replay", recording}).exit_code, 0);
  const Outcome usual =
      run_program(folder, arguments("2", {"--stiffness", "auto", "--energy-budget", "motors=250"}));
  EXPECT_EQ(usual.err.find("energy budgets"), std::string::npos) << usual.err;
}

TEST_F(DeviceRunProgram, RefusesSlowTicksSlowMessagesAndASlowLine) {
  expect_refused(run_program(folder, arguments("2", {"--rate", "80"})),
                 "--rate: is 80 Hz; expected at least 250 for a device that moves motors");
  open_board();
  std::vector<std::string> slow = arguments("2");
  slow[3] += ",rate=80";
  slow.insert(slow.end(), {"--rate", "1000"});
  expect_refused(run_program(folder, slow), "is asked for 80 messages per second");
  BoardSettings far;
  far.answer_ns = 4'500'000;
  board = std::move(*BoardTerminal::open(far));
  expect_refused(run_program(folder, arguments("2")), " of 1000 messages per second");
}

// Calls the function on a thread whose children get no SCHED_FIFO, not even those of root.
void without_fifo(const std::function<void()>& function) {
  rlimit before{};
  getrlimit(RLIMIT_RTPRIO, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_RTPRIO, &none);
  std::thread thread([&] {
    prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0);
    function();
  });
  thread.join();
  setrlimit(RLIMIT_RTPRIO, &before);
}

TEST_F(DeviceRunProgram, RefusesMotorsWithoutRealTimeScheduling) {
  without_fifo([&] {
    const Outcome outcome = run_program(folder, {"run", scene, "--device", device()});
    expect_refused(outcome, "write `* - rtprio 90` to /etc/security/limits.d/palpate.conf", 4);
    EXPECT_NE(outcome.err.find("--without-realtime"), std::string::npos) << outcome.err;
  });
}

// A device without a calibration pushes nothing, so that it cannot keep a force.
TEST_F(DeviceRunProgram, WithoutACalibrationTheBoardGetsZeroOnly) {
  without_fifo([&] {
    for (int n = 0; n < kMostRuns; ++n) {
      open_board();
      const StartedProgram started =
          start_program(folder, {"run", scene, "--device", "hapi:port=" + board->path()});
      bool has_pressed = wait_for_commands(started, 800);
      board->set_hand(kPressed_m);
      has_pressed = has_pressed && wait_for_commands(started, 500);
      ::kill(started.process, SIGINT);
      const Outcome outcome = outcome_of(started);
      EXPECT_FALSE(has_force(*board));
      if (!has_pressed) continue;
      EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
      EXPECT_NE(outcome.err.find("commands no force without torque-per-Nm"), std::string::npos)
          << outcome.err;
      EXPECT_NE(outcome.out.find("0 actuators"), std::string::npos) << outcome.out;
      return;
    }
    ADD_FAILURE() << "no run without a trip";
  });
}

}  // namespace
}  // namespace palpate
