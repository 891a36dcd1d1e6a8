#include "engine/cli/open_browser.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>
#include <utility>

namespace palpate {
namespace {

constexpr const char* kOpener = "xdg-open";

Error failed(const std::string& what, int error) {
  return {ErrorCode::kFileUnwritable, "", "--open", what + ": " + std::strerror(error),
          "open the printed address yourself"};
}

std::string folder() {
  const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
  return runtime != nullptr && *runtime != '\0' ? runtime : "/tmp";
}

std::string forwarding_page(const std::string& address) {
  return "<!doctype html><meta charset=\"utf-8\"><title>Palpate</title>\n"
         "<meta name=\"referrer\" content=\"no-referrer\">\n"
         "<meta http-equiv=\"refresh\" content=\"0;url=" +
         address + "\">\n<a href=\"" + address + "\">Palpate</a>\n";
}

// mkstemps() creates the file with mode 0600.
Result<std::string> write_forwarding_file(const std::string& address) {
  constexpr std::string_view kEnding = ".html";
  std::string path = folder() + "/palpate-XXXXXX" + std::string(kEnding);
  const int file = ::mkstemps(path.data(), static_cast<int>(kEnding.size()));
  if (file < 0) return failed("no file in " + folder() + " can be made", errno);
  const std::string page = forwarding_page(address);
  const bool is_written =
      ::write(file, page.data(), page.size()) == static_cast<ssize_t>(page.size());
  const int error = errno;
  ::close(file);
  if (is_written) return path;
  ::unlink(path.c_str());
  return failed(path + " cannot be written", error);
}

}  // namespace

Result<std::unique_ptr<OpenedBrowser>> OpenedBrowser::open(const std::string& address) {
  auto path = write_forwarding_file(address);
  if (!path) return path.error();
  std::unique_ptr<OpenedBrowser> opened(new OpenedBrowser(std::move(*path)));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // The browser's messages do not belong among those of this program.
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  }
  // The browser may outlive this program: it must not keep the server's sockets, and Ctrl-C in this
  // program's terminal must not end it.
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  std::string program = kOpener;
  std::array<char*, 3> argv = {program.data(), opened->path_.data(), nullptr};
  pid_t process = 0;
  const int error = ::posix_spawnp(&process, kOpener, &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return failed("xdg-open cannot be started", error);
  return opened;
}

OpenedBrowser::~OpenedBrowser() {
  ::unlink(path_.c_str());
}

}  // namespace palpate
