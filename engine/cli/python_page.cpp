#include "engine/cli/python_page.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <iostream>
#include <poll.h>
#include <string_view>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include "engine/cli/command_output.h"
#include "engine/cli/program_signals.h"
#include "geometry/base/printable.h"

extern char** environ;

namespace palpate {
namespace {

namespace fs = std::filesystem;

// The exit codes of kStart are apart from those of an interpreter or a script that fails by itself.
constexpr int kMadeCode = 64, kRefusedCode = 66, kFailedCode = 65, kPackagesCode = 93;
constexpr int kNotStarted = 127;
constexpr int kKilled = 128;  // plus the number of the signal

// Arguments: the folder of the package palpate, then those of palpate.analysis.
// Ends without the interpreter's own end, which PYTHONINSPECT changes.
constexpr const char* kStart = R"py(
import os, sys
def end(code):
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
try:
    from importlib.util import find_spec
    needed = ("numpy", "scipy", "pandas", "statsmodels", "matplotlib", "jinja2")
    # A removed package may leave a folder, which is found without a loader.
    missing = [name for name in needed if getattr(find_spec(name), "loader", None) is None]
    if missing:
        print(*missing)
        end(93)
    sys.path.insert(0, sys.argv.pop(1))
    from palpate.analysis.__main__ import main
    code = main(sys.argv[1:])
except ImportError as error:
    print(error.name or "", f"({error})")
    end(93)
except BaseException:
    import traceback
    traceback.print_exc()
    end(65)
end(64 + code)
)py";

constexpr std::string_view kErrorMark = "palpate: ";
constexpr std::string_view kWarningMark = "palpate: warning: ";

constexpr const char* kHint =
    "install python3-numpy, python3-scipy, python3-pandas, python3-statsmodels, "
    "python3-matplotlib and python3-jinja2, or set PALPATE_PYTHON to a Python 3.11 or later that "
    "has these packages";

// The folder that has the package palpate: beside the program, or in the project that it was built
// in. Never the working folder.
std::optional<std::string> package_folder() {
  std::error_code failed;
  fs::path folder = fs::read_symlink("/proc/self/exe", failed).parent_path();
  constexpr int kMostAbove = 4;
  for (int above = 0; !failed && above <= kMostAbove; ++above) {
    for (const fs::path& candidate : {folder / "python", folder / "engine" / "python"}) {
      std::error_code ignored;
      if (fs::exists(candidate / "palpate" / "analysis" / "__main__.py", ignored)) {
        return candidate.string();
      }
    }
    folder = folder.parent_path();
  }
  return std::nullopt;
}

class Pipe {
 public:
  Pipe() { is_open_ = ::pipe2(ends_.data(), O_CLOEXEC) == 0; }
  ~Pipe() {
    close_read();
    close_write();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  bool is_open() const { return is_open_; }
  int read_end() const { return ends_[0]; }
  int write_end() const { return ends_[1]; }
  void close_read() { close(ends_[0]); }
  void close_write() { close(ends_[1]); }

 private:
  static void close(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }

  std::array<int, 2> ends_ = {-1, -1};
  bool is_open_ = false;
};

// The environment of this program, with one thread for BLAS and UTF-8 for all texts.
std::vector<std::string> python_environment() {
  constexpr std::array<std::string_view, 6> kOwn = {"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1",
                                                    "MKL_NUM_THREADS=1",      "MPLBACKEND=svg",
                                                    "PYTHONUTF8=1",           "PYTHONHASHSEED=0"};
  std::vector<std::string> all(kOwn.begin(), kOwn.end());
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const std::string_view name = text.substr(0, text.find('=') + 1);
    const bool is_own = std::any_of(kOwn.begin(), kOwn.end(), [&](std::string_view own) {
      return !name.empty() && own.starts_with(name);
    });
    if (!is_own) all.emplace_back(text);
  }
  return all;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// What the child does between fork and exec; only calls that are safe there.
[[noreturn]] void become(const char* program, char* const* arguments, char* const* environment,
                         int out, int err, pid_t parent) {
  // Only the parent ends it: Ctrl-C reaches the whole group of the terminal.
  sigset_t blocked;
  sigemptyset(&blocked);
  for (const int signal : kEndingSignals) sigaddset(&blocked, signal);
  ::sigprocmask(SIG_SETMASK, &blocked, nullptr);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kNotStarted);  // it ended before the line above
  const int in = ::open("/dev/null", O_RDONLY);
  if (in >= 0) ::dup2(in, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(err, STDERR_FILENO);
  ::execvpe(program, arguments, environment);
  ::_exit(kNotStarted);
}

struct Ended {
  int code = kNotStarted;
  bool is_interrupted = false;
  std::string out, err;
};

// Reads what is there. False at the end.
bool read_some(int end, std::string& text) {
  std::array<char, 1 << 16> buffer;
  const ssize_t count = ::read(end, buffer.data(), buffer.size());
  if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
  return count > 0 || (count < 0 && errno == EINTR);
}

// Reads both streams until the process has closed them, or kills it after a signal.
void follow(pid_t process, int out, int err, Ended& ended) {
  constexpr int kWait_ms = 50;  // until the next look at the signals
  std::array<pollfd, 2> streams = {{{out, POLLIN, 0}, {err, POLLIN, 0}}};
  std::array<std::string*, 2> texts = {&ended.out, &ended.err};
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    if (signal_flag().requested() && !ended.is_interrupted) {
      ended.is_interrupted = true;
      ::kill(process, SIGKILL);
    }
    if (::poll(streams.data(), streams.size(), kWait_ms) <= 0) continue;
    for (std::size_t i = 0; i < streams.size(); ++i) {
      if (streams[i].fd >= 0 && streams[i].revents != 0 && !read_some(streams[i].fd, *texts[i])) {
        streams[i].fd = -1;
      }
    }
  }
}

Ended run_python(const std::string& interpreter, std::vector<std::string> arguments) {
  Ended ended;
  Pipe out, err;
  if (!out.is_open() || !err.is_open()) return ended;
  arguments.insert(arguments.begin(), {interpreter, "-P", "-c", kStart});
  std::vector<std::string> environment = python_environment();
  const std::vector<char*> words = pointers_to(arguments);
  const std::vector<char*> variables = pointers_to(environment);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process == 0) {
    become(interpreter.c_str(), words.data(), variables.data(), out.write_end(), err.write_end(),
           parent);
  }
  out.close_write();
  err.close_write();
  if (process < 0) return ended;
  follow(process, out.read_end(), err.read_end(), ended);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return ended;
  }
  // A signal for the whole group may have ended the process before it was seen here.
  if (signal_flag().requested()) ended.is_interrupted = true;
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : kKilled + WTERMSIG(status);
  return ended;
}

std::vector<std::string> lines_in(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end > begin) lines.push_back(printable(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return lines;
}

// Libraries write warnings of their own to stderr, which are not for the user.
void take_warnings(const std::string& err, PageOutcome& outcome) {
  for (const std::string& line : lines_in(err)) {
    if (line.starts_with(kWarningMark)) {
      outcome.warnings.push_back(line.substr(kWarningMark.size()));
    } else if (line.starts_with(kErrorMark)) {
      outcome.problem = line.substr(kErrorMark.size());
    }
  }
}

// Of a process that began the analysis.
std::string failure_text(const std::string& interpreter, const Ended& ended) {
  if (ended.code > kKilled) {
    return interpreter + " was killed by signal " + std::to_string(ended.code - kKilled);
  }
  const std::vector<std::string> lines = lines_in(ended.err);
  return interpreter + " failed" + (lines.empty() ? "" : ": " + lines.back());
}

// Why this interpreter cannot be used: it did not come as far as the analysis. No value: it did.
std::optional<std::string> problem_of(const std::string& interpreter, const Ended& ended) {
  if (ended.code == kNotStarted) return interpreter + " could not be started";
  if (ended.code == kPackagesCode) {
    std::string names;
    for (const std::string& line : lines_in(ended.out)) names += line;
    return interpreter + " has no package " + names;
  }
  const bool has_begun = ended.code == kMadeCode || ended.code == kRefusedCode ||
                         ended.code == kFailedCode || ended.code > kKilled;
  if (has_begun) return std::nullopt;
  // An older Python does not know -P; a broken one, or a script in its place, ends in any way.
  const std::vector<std::string> lines = lines_in(ended.err);
  return interpreter + " does not work as Python 3.11 or later (exit code " +
         std::to_string(ended.code) + (lines.empty() ? ")" : ": " + lines.back() + ")");
}

std::vector<std::string> interpreters() {
  const char* const chosen = std::getenv("PALPATE_PYTHON");
  if (chosen != nullptr && *chosen != '\0') return {chosen};
  return {"python3", "/usr/bin/python3"};
}

PageOutcome outcome_of(const std::string& interpreter, const Ended& ended) {
  PageOutcome outcome;
  take_warnings(ended.err, outcome);
  if (ended.code == kMadeCode) {
    outcome.text = ended.out;
  } else if (ended.code == kRefusedCode) {
    outcome.end = PageEnd::kRefused;
  } else {
    outcome.end = PageEnd::kFailed;
    outcome.problem = failure_text(interpreter, ended);
  }
  return outcome;
}

}  // namespace

PageOutcome make_page(const std::vector<std::string>& arguments, const OutputFiles& files) {
  const auto folder = package_folder();
  if (!folder) {
    return {PageEnd::kMissing,
            "",
            {},
            "the folder python beside the program is missing (install "
            "the program with it)"};
  }
  std::vector<std::string> words = {*folder};
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.insert(words.begin() + 2, "--out=" + files.hidden_folder());
  std::string problem;
  for (const std::string& interpreter : interpreters()) {
    const Ended ended = run_python(interpreter, words);
    if (ended.is_interrupted) return {PageEnd::kInterrupted, "", {}, ""};
    const auto unusable = problem_of(interpreter, ended);
    if (!unusable) return outcome_of(interpreter, ended);
    problem += (problem.empty() ? "" : "; ") + *unusable;
  }
  return {PageEnd::kMissing, "", {}, problem + " (" + kHint + ")"};
}

int finish_page(const PageOutcome& outcome, OutputFiles& files) {
  switch (outcome.end) {
    case PageEnd::kMade:
      break;
    case PageEnd::kInterrupted:
      std::cerr << "palpate: interrupted; nothing is written\n";
      return exit_code_after_signals(0);
    case PageEnd::kFailed:
      std::cerr << "palpate: " << outcome.problem << "; nothing is written\n";
      return 1;
    default:
      std::cerr << "palpate: " << outcome.problem << "\n";
      return kBadInput;
  }
  {
    const SignalPhaseScope not_now(SignalPhase::kDeferred);
    if (signal_flag().requested()) {
      std::cerr << "palpate: interrupted; nothing is written\n";
      return exit_code_after_signals(0);
    }
    if (const auto error = files.move_into_place()) return refuse(*error);
  }
  std::cout << outcome.text;
  return exit_code_after_signals(finish_output(with_page_warnings({}, outcome)));
}

Result<PageOutcome> place_with_page(const std::vector<std::string>& arguments,
                                    const std::vector<std::string>& page_names,
                                    OutputFiles& files) {
  PageOutcome outcome = make_page(arguments, files);
  if (outcome.end != PageEnd::kMade) {
    for (const std::string& name : page_names) {
      std::error_code ignored;
      fs::remove(files.path(name), ignored);
    }
  }
  const SignalPhaseScope not_now(SignalPhase::kDeferred);
  if (signal_flag().requested()) outcome.end = PageEnd::kInterrupted;
  if (outcome.end == PageEnd::kInterrupted) return outcome;
  if (auto error = files.move_into_place()) return *error;
  return outcome;
}

std::vector<std::string> with_page_warnings(std::vector<std::string> warnings,
                                            const PageOutcome& outcome) {
  warnings.insert(warnings.end(), outcome.warnings.begin(), outcome.warnings.end());
  if (outcome.end != PageEnd::kMade) warnings.push_back("the page is missing: " + outcome.problem);
  return warnings;
}

}  // namespace palpate
