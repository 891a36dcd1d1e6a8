// The command `view`, started as a script starts it.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/viewer/page_files.h"
#include "tests/engine/cli/run_program.h"
#include "tests/engine/viewer/raw_client.h"

namespace palpate {
namespace {

using test::content_of;
using test::kStar;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

constexpr const char* kNoPage =
    "needs a program with the page of view, which ./run.sh view and .ci/run build";

// The same in a program with the page and in one without it.
TEST(ViewCommand, RefusesBadArgumentsInOneLine) {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"view"},
        {"view", "no-such.glb"},
        {"view", kStar, "--port", "65536"},
        {"view", kStar, "--port", "-1"},
        {"view", kStar, "--a4", "compare"},
        {"view", kStar, "--strategy", "a4", "--a4", "on"},
        {"view", kStar, "--strategy", "anisotropic:17"},
        {"view", kStar, "--cpu", "0"},
        {"view", kStar, "--display", "none"},
        {"view", kStar, "--display-rate", "60"},
        {"view", kStar, "--display", "full", "--display-scale", "1"},
        {"view", kStar, "--display", "paper", "--display-rate", "0"},
        {"view", kStar, "--display", "paper", "--display-scale", "-1"},
        {"view", kStar, "--allow-host", "desk.example:80"},
        {"view", kStar, "--allow-host", "2001:db8::1"},
        {"view", kStar, "--allow-host", ""},
        {"view", kStar, "--allow-origin", "desk.example"},
        {"view", kStar, "--allow-origin", "https://desk.example/lab/"},
        {"view", kStar, "--allow-origin", "null"},
        {"view", kStar, "--allow-origin", "https://*.example"},
        {"view", kStar, "--allow-origin", ""},
        {"view", kStar, "--device", "hapi:port=/no/such/port"}}) {
    const Outcome outcome = run_program(folder, arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(ViewCommand, SaysWhatToRunWithoutThePage) {
  if (embedded_page()) GTEST_SKIP() << "skipped: the program has the page; see ServesUntilCtrlC";
  const TemporaryFolder folder;
  const Outcome outcome = run_program(folder, {"view", kStar});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err,
            "palpate: view: is not complete: the program has no page (run ./run.sh view, which "
            "installs npm if it is missing and builds the page)\n");
}

// A program that serves, and the port that it has printed.
class Serving {
 public:
  Serving(const TemporaryFolder& folder, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"view", kStar});
    program_ = test::start_program(folder, arguments);
    const auto end = std::chrono::steady_clock::now() + test::kPatience;
    while (content_of(program_.out).find('\n') == std::string::npos &&
           std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    address = content_of(program_.out);
    const std::size_t colon = address.rfind(':', address.find('#'));
    port = colon == std::string::npos ? 0 : std::stoi(address.substr(colon + 1));
  }
  Outcome end_with(int signal) {
    ::kill(program_.process, signal);
    return test::outcome_of(program_);
  }
  pid_t process() const { return program_.process; }

  std::string address;
  int port = 0;

 private:
  test::StartedProgram program_;
};

TEST(ViewCommand, ServesUntilCtrlC) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  const TemporaryFolder folder;
  Serving serving(folder, {});
  ASSERT_GT(serving.port, 0);
  const auto port = static_cast<std::uint16_t>(serving.port);
  const std::string start = "http://127.0.0.1:" + std::to_string(port) + "/#";
  ASSERT_EQ(serving.address.rfind(start, 0), 0u) << serving.address;
  const std::string token = serving.address.substr(start.size(), 32);
  EXPECT_EQ(serving.address, start + token + "\n");
  test::WebSocketClient page(port);
  page.send_text(R"({"type":"token","token":")" + token + "\"}");
  page.read_text_with("\"hello\"");
  const TemporaryFolder other;  // whose output does not overwrite that of the first program
  const Outcome taken = run_program(other, {"view", kStar, "--port", std::to_string(port)});
  EXPECT_EQ(taken.exit_code, 2);
  EXPECT_EQ(taken.err, "palpate: --port: is " + std::to_string(port) +
                           ", which is taken; expected a free port (choose another one, or 0 for "
                           "any)\n");
  const Outcome outcome = serving.end_with(SIGINT);
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_NE(outcome.out.find("\nticks: "), std::string::npos) << outcome.out;
  page.read_text_with("\"kind\":\"end\"");
  EXPECT_EQ(page.read_to_close(), 1001);
}

// The address holds a secret.
TEST(ViewCommand, MakesALogOfItsAddressPrivate) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  const TemporaryFolder folder;
  const std::string log = folder.write("stdout", "");
  ASSERT_EQ(::chmod(log.c_str(), 0664), 0);
  Serving serving(folder, {});
  ASSERT_GT(serving.port, 0);
  struct stat file {};
  ASSERT_EQ(::stat(log.c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777, 0600u);
  const Outcome outcome = serving.end_with(SIGINT);
  EXPECT_NE(outcome.err.find("stdout is a file that others could read; it is now only yours"),
            std::string::npos)
      << outcome.err;
}

TEST(ViewCommand, PrintsTheAddressThroughAProxyThatIsNamed) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  const TemporaryFolder folder;
  Serving serving(folder, {"--allow-origin", "HTTPS://Desk.example:443/", "--allow-origin",
                           "http://[2001:DB8::0:1]:8080"});
  const std::string token = serving.address.substr(serving.address.find('#'), 33);
  const Outcome outcome = serving.end_with(SIGINT);
  for (const char* origin : {"https://desk.example/", "http://[2001:db8::1]:8080/"}) {
    EXPECT_NE(outcome.out.find("through a proxy: " + std::string(origin) + token),
              std::string::npos)
        << outcome.out;
  }
}

std::uint64_t open_files_of(pid_t process) {
  const std::filesystem::directory_iterator files("/proc/" + std::to_string(process) + "/fd");
  return static_cast<std::uint64_t>(std::distance(begin(files), end(files)));
}

// Strangers take every file that the process may open, and a page is served all the same: not after
// those that came before it have been patient for five seconds each, four at a time.
TEST(ViewCommand, ServesAPageWhenStrangersTakeAllFiles) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  constexpr int kStrangers = 200;
  constexpr rlim_t kFilesLeft = 4;
  static_assert(kStrangers / kFilesLeft * std::chrono::seconds(5) > 2 * test::kPatience);
  const TemporaryFolder folder;
  Serving serving(folder, {});
  ASSERT_GT(serving.port, 0);
  const auto port = static_cast<std::uint16_t>(serving.port);
  const rlim_t most = open_files_of(serving.process()) + kFilesLeft;
  const rlimit few{most, most};
  ASSERT_EQ(::prlimit(serving.process(), RLIMIT_NOFILE, &few, nullptr), 0);
  std::vector<test::RawClient> crowd;
  for (int i = 0; i < kStrangers; ++i) crowd.emplace_back(port);
  const std::string token = serving.address.substr(serving.address.find('#') + 1, 32);
  test::WebSocketClient page(port);
  page.send_text(R"({"type":"token","token":")" + token + "\"}");
  page.read_text_with("\"hello\"");
  const std::string host = "127.0.0.1:" + std::to_string(port);
  EXPECT_EQ(test::status_of(test::answer_to(port, test::get_request("/page.js", host))), 200);
  EXPECT_EQ(serving.end_with(SIGINT).exit_code, 130);
}

TEST(ViewCommand, PrintsTheLicencesOfThePage) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  const TemporaryFolder folder;
  const Outcome outcome = run_program(folder, {"view", "--licences"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* part : {"three", "uPlot", "Copyright", "MIT"}) {
    EXPECT_NE(outcome.out.find(part), std::string::npos) << part;
  }
}

TEST(ViewCommand, RecordsTheSession) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  const TemporaryFolder folder;
  Serving serving(folder, {"--record", "live.palpate"});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const Outcome outcome = serving.end_with(SIGINT);
  EXPECT_EQ(outcome.exit_code, 130);
  EXPECT_NE(outcome.out.find("recording in live.palpate: "), std::string::npos) << outcome.out;
  const Outcome proved = run_program(folder, {"replay", "live.palpate"});
  EXPECT_EQ(proved.exit_code, 0) << proved.err << proved.out;
  const Outcome again = run_program(folder, {"view", kStar, "--record", "live.palpate"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("live.palpate: exists"), std::string::npos) << again.err;
}

TEST(ViewCommand, WarnsOfAnAddressThatOthersReach) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  const TemporaryFolder folder;
  Serving serving(folder, {"--listen", "0.0.0.0"});
  const Outcome outcome = serving.end_with(SIGTERM);
  EXPECT_EQ(outcome.exit_code, 143);
  EXPECT_NE(outcome.err.find("warning: --listen: others on the network"), std::string::npos)
      << outcome.err;
}

TEST(ViewCommand, ServesAnotherLoopbackAddressWithoutAWarning) {
  if (!embedded_page()) GTEST_SKIP() << kNoPage;
  const TemporaryFolder folder;
  Serving serving(folder, {"--listen", "127.0.0.2"});
  const std::string host = "127.0.0.2:" + std::to_string(serving.port);
  const std::string answer = test::answer_to(static_cast<std::uint16_t>(serving.port),
                                             test::get_request("/page.js", host), "127.0.0.2");
  EXPECT_EQ(test::status_of(answer), 200) << answer;
  EXPECT_EQ(serving.end_with(SIGTERM).err.find("--listen"), std::string::npos);
}

}  // namespace
}  // namespace palpate
