#include "engine/report/gnuplot.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <memory>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "geometry/base/printable.h"

extern char** environ;

namespace palpate {
namespace {

constexpr const char* kHint = "install gnuplot-nox";
constexpr int kNotFound = 127;  // exit code if the program could not be executed

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
// A temporary file without a name, which the system removes in any event.
using NamelessFile = std::unique_ptr<std::FILE, Close>;

NamelessFile nameless_file() {
  return NamelessFile(std::tmpfile());
}

Error gnuplot_error(const std::string& problem) {
  return {ErrorCode::kUnsupported, "", "gnuplot", problem, kHint};
}

Error no_room() {
  return {ErrorCode::kFileUnwritable, "", "gnuplot", "its temporary files cannot be written",
          "check TMPDIR and the free disk space"};
}

std::string content_of(std::FILE* file) {
  std::string content;
  std::rewind(file);
  std::array<char, 1 << 16> buffer;
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), file)) {
    content.append(buffer.data(), count);
  }
  return content;
}

// The last line of gnuplot's error text: the problem. The lines before it show its position.
std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  text.erase(0, text.rfind('\n') + 1);  // all of it if npos
  text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
  return printable(text);
}

// Standard input, output and error of a process to start.
class Streams {
 public:
  Streams(std::FILE* in, std::FILE* out, std::FILE* err) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, fileno(in), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, fileno(out), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, fileno(err), STDERR_FILENO);
  }
  ~Streams() { posix_spawn_file_actions_destroy(&actions_); }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;

  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

// Attributes of a process that ignores Ctrl-C and the end of its terminal, so that only its parent
// ends it.
class Unsignalled {
 public:
  Unsignalled() {
    sigset_t blocked;
    sigemptyset(&blocked);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&blocked, signal);
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setsigmask(&attributes_, &blocked);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK);
  }
  ~Unsignalled() { posix_spawnattr_destroy(&attributes_); }
  Unsignalled(const Unsignalled&) = delete;
  Unsignalled& operator=(const Unsignalled&) = delete;

  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_;
};

// The exit code of gnuplot, kNotFound without one.
int run_gnuplot(const Streams& streams) {
  std::array<char, 8> name = {"gnuplot"};
  std::array<char, 3> no_settings = {"-d"};
  const std::array<char*, 3> arguments = {name.data(), no_settings.data(), nullptr};
  pid_t process = 0;
  const Unsignalled unsignalled;
  if (posix_spawnp(&process, name.data(), streams.get(), unsignalled.get(), arguments.data(),
                   environ) != 0) {
    return kNotFound;
  }
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return kNotFound;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

Result<std::string> gnuplot_svg(const std::string& script, int width_px, int height_px,
                                int font_px) {
  const NamelessFile in = nameless_file(), out = nameless_file(), err = nameless_file();
  if (!in || !out || !err) return no_room();
  // `noenhanced`: an underscore in a name does not make a subscript.
  const std::string all = "set encoding utf8\nset terminal svg noenhanced size " +
                          std::to_string(width_px) + "," + std::to_string(height_px) +
                          " font 'sans-serif," + std::to_string(font_px) +
                          "' background 'white'\n" + script + "\nunset output\n";
  if (std::fwrite(all.data(), 1, all.size(), in.get()) != all.size() ||
      std::fflush(in.get()) != 0) {
    return no_room();
  }
  std::rewind(in.get());
  const int code = run_gnuplot(Streams(in.get(), out.get(), err.get()));
  if (code == kNotFound) return gnuplot_error("could not be started");
  std::string svg = content_of(out.get());
  if (code != 0) return gnuplot_error("did not draw: " + last_line(content_of(err.get())));
  if (svg.find("</svg>") == std::string::npos) return gnuplot_error("drew no complete picture");
  return svg;
}

std::string gnuplot_quoted(std::string_view text) {
  // In single quotes gnuplot misreads a leading quote and two consecutive quotes; in double quotes
  // it executes text in backquotes. Every special character is therefore written in octal.
  std::string quoted = "\"";
  for (const char c : printable(text)) {
    switch (c) {
      case '\'':
        quoted += "\\047";
        break;
      case '"':
        quoted += "\\042";
        break;
      case '\\':
        quoted += "\\134";
        break;
      case '`':
        quoted += "\\140";
        break;
      case '@':
        quoted += "\\100";
        break;
      default:
        quoted += c;
    }
  }
  return quoted + "\"";
}

std::string gnuplot_tick(std::string_view text) {
  std::string doubled;
  for (const char c : text) {
    if (c == '%') doubled += '%';
    doubled += c;
  }
  return gnuplot_quoted(doubled);
}

}  // namespace palpate
