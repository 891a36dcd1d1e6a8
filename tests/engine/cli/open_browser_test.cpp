// The browser that `view --open` starts, played by a script.

#include "engine/cli/open_browser.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <sys/stat.h>
#include <thread>

#include <gtest/gtest.h>

#include "tests/engine/cli/run_program.h"
#include "tests/helpers/environment_variable.h"

namespace palpate {
namespace {

using test::content_of;
using Variable = test::EnvironmentVariable;
using test::TemporaryFolder;

// A script in place of xdg-open. It writes its arguments and the file that it gets.
void write_opener(const TemporaryFolder& folder) {
  const std::string path =
      folder.write("bin/xdg-open",
                   "#!/bin/sh\necho \"$@\" > \"$SEEN.part\"\ncat \"$1\" >> \"$SEEN.part\"\n"
                   "mv \"$SEEN.part\" \"$SEEN\"\n");
  ::chmod(path.c_str(), 0700);
}

TEST(OpenBrowser, HandsOverAPrivateFileThatForwards) {
  const TemporaryFolder folder;
  write_opener(folder);
  const Variable path("PATH", folder.path("bin") + ":" + std::getenv("PATH"));
  const Variable runtime("XDG_RUNTIME_DIR", folder.path());
  const Variable seen("SEEN", folder.path("seen"));
  const std::string address = "http://127.0.0.1:1234/#0123456789abcdef0123456789abcdef";
  std::string file;
  {
    const auto opened = OpenedBrowser::open(address);
    ASSERT_TRUE(opened) << opened.error().to_string();
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (content_of(folder.path("seen")).empty() && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const std::string text = content_of(folder.path("seen"));
    file = text.substr(0, text.find('\n'));
    EXPECT_EQ(file.find(address), std::string::npos) << "everybody can read arguments";
    EXPECT_NE(text.find("content=\"0;url=" + address + "\""), std::string::npos) << text;
    struct stat status {};
    ASSERT_EQ(::stat(file.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u);
  }
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(OpenBrowser, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const Variable path("PATH", folder.path("empty"));
  const Variable runtime("XDG_RUNTIME_DIR", folder.path());
  const auto opened = OpenedBrowser::open("http://127.0.0.1:1/#0");
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().element, "--open");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  const Variable nowhere("XDG_RUNTIME_DIR", folder.path("nowhere"));
  EXPECT_FALSE(OpenedBrowser::open("http://127.0.0.1:1/#0"));
}

}  // namespace
}  // namespace palpate
