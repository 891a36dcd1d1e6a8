// The command `devices`, started as a script starts it.

#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <spawn.h>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "engine/drivers/drivers.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

using test::content_of;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

TEST(DevicesCommand, ListsTheKeysThatTheOptionAccepts) {
  const TemporaryFolder folder;
  const Outcome list = run_program(folder, {"devices"});
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_EQ(list.err, "");
  EXPECT_NE(list.out.find("delay from a sample to the force: unknown\n"), std::string::npos);
  EXPECT_NE(list.out.find("its walls at 1000 Hz and a delay of 3.1 ms: "), std::string::npos)
      << list.out;
  EXPECT_NE(list.out.find("(of a bare tip: 0.1 kg, 0.5 N s/m, 3.1 ms)\n"), std::string::npos);
  // The error of an unknown key names them all.
  const std::string error =
      make_device("--device", "hapi:no-such-key=1", false).error().to_string();
  std::string names = error.substr(error.find("one of ") + 7);
  for (std::size_t end = 0; end != std::string::npos; names.erase(0, end + 2)) {
    end = names.find(", ");
    EXPECT_NE(list.out.find(names.substr(0, end)), std::string::npos) << names.substr(0, end);
    if (end == std::string::npos) break;
  }
}

TEST(DevicesCommand, RefusesBadArguments) {
  const TemporaryFolder folder;
  const Outcome unknown = run_program(folder, {"devices", "--simulate", "falcon"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("--simulate: is \"falcon\"; expected hapi"), std::string::npos);
  EXPECT_EQ(unknown.out, "");
  EXPECT_EQ(run_program(folder, {"devices", "--seconds", "1"}).exit_code, 2);
  EXPECT_EQ(run_program(folder, {"devices", "--simulate", "hapi", "--seconds", "0"}).exit_code, 2);
  EXPECT_EQ(run_program(folder, {"devices", "--plant", "0.1,0.5,light,0.001"}).exit_code, 2);
  for (const char* plant : {"0.1,0.5,light", "0.1,0.5,light,0.001,1", "0,0.5,light,0.001",
                            "0.1,nan,light,0.001", "0.1,0.5,loose,0.001", "0.1,0.5,light,-1"}) {
    const Outcome refused =
        run_program(folder, {"devices", "--simulate", "hapi", "--plant", plant});
    EXPECT_EQ(refused.exit_code, 2) << plant;
    EXPECT_NE(refused.err.find("--plant: "), std::string::npos) << refused.err;
    EXPECT_EQ(refused.out, "");
  }
}

TEST(DevicesCommand, StatesWhatBecameOfThePlant) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const TemporaryFolder folder;
  const Outcome done = run_program(folder, {"devices", "--simulate", "hapi", "--plant",
                                            "0.1,0.5,light,0.001", "--seconds", "0.1"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_NE(done.out.find("0 set-ups, 0 commands"), std::string::npos);
  EXPECT_NE(done.out.find("plant: 0 probes"), std::string::npos);
}

TEST(DevicesCommand, EndsAfterTheGivenTime) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const TemporaryFolder folder;
  const Outcome done = run_program(folder, {"devices", "--simulate", "hapi", "--seconds", "0.1"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_NE(done.out.find("a simulated hAPI board at /dev/pts/"), std::string::npos);
  EXPECT_NE(done.out.find("0 set-ups, 0 commands"), std::string::npos);
}

// The program, running in the background with its output in a file.
class Background {
 public:
  explicit Background(const TemporaryFolder& folder) : out_(folder.path("board")) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0600);
    std::string words[] = {PALPATE_PROGRAM, "devices", "--simulate", "hapi"};
    char* argv[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
    EXPECT_EQ(posix_spawn(&child_, PALPATE_PROGRAM, &actions, nullptr, argv, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  // The port that the program has printed; empty if it prints none.
  std::string port() const {
    for (int n = 0; n < 3000; ++n) {
      const std::string out = content_of(out_);
      const std::size_t at = out.find("/dev/");
      const std::size_t end = out.find('\n');
      if (at != std::string::npos && end != std::string::npos) return out.substr(at, end - at);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return "";
  }
  int end(int signal) {
    ::kill(child_, signal);
    int status = 0;
    ::waitpid(child_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string out() const { return content_of(out_); }

 private:
  std::string out_;
  pid_t child_ = 0;
};

TEST(DevicesCommand, SimulatesABoardForADriverUntilASignal) {
  PALPATE_NEEDS(test::lack_of_terminals());
  const TemporaryFolder folder;
  Background program(folder);
  const std::string port = program.port();
  ASSERT_NE(port, "") << program.out();
  const auto made = make_device("--device", "hapi:port=" + port, false);
  ASSERT_TRUE(made);
  GuardableDevice& device = **made;
  const auto problem = device.start();
  EXPECT_FALSE(problem) << *problem;
  EXPECT_TRUE(device.read(1e-3).is_valid);
  device.command({});
  device.stop();
  EXPECT_EQ(program.end(SIGTERM), 143);
  EXPECT_NE(program.out().find("1 set-ups, "), std::string::npos) << program.out();
}

}  // namespace
}  // namespace palpate
