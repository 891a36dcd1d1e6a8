#pragma once

// Starts the program guarded_engine and its guard, and processes that keep the machine busy.

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <functional>
#include <memory>
#include <poll.h>
#include <spawn.h>
#include <string>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

extern "C" char** environ;

namespace palpate {

// Waits until the condition holds, at most `seconds`. Returns whether it holds.
inline bool wait_for(const std::function<bool()>& condition, double seconds = 2.0) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

// Processes that compute without end.
class BusyProcesses {
 public:
  explicit BusyProcesses(int count) {
    for (int i = 0; i < count; ++i) {
      const pid_t process = fork();
      if (process == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        std::atomic<unsigned> n{0};
        for (;;) n.fetch_add(1, std::memory_order_relaxed);
      }
      processes_.push_back(process);
    }
  }
  ~BusyProcesses() {
    for (const pid_t process : processes_) {
      ::kill(process, SIGKILL);
      waitpid(process, nullptr, 0);
    }
  }
  BusyProcesses(const BusyProcesses&) = delete;
  BusyProcesses& operator=(const BusyProcesses&) = delete;

 private:
  std::vector<pid_t> processes_;
};

// A process that may end, and whose number may then belong to another process.
class WatchedProcess {
 public:
  explicit WatchedProcess(pid_t number)
      : number_(number), pidfd_(static_cast<int>(syscall(SYS_pidfd_open, number, 0))) {}
  ~WatchedProcess() {
    if (pidfd_ >= 0) ::close(pidfd_);
  }
  WatchedProcess(const WatchedProcess&) = delete;
  WatchedProcess& operator=(const WatchedProcess&) = delete;

  void send(int signal) const { syscall(SYS_pidfd_send_signal, pidfd_, signal, nullptr, 0); }
  bool has_ended() const {
    pollfd end{pidfd_, POLLIN, 0};
    return pidfd_ < 0 || poll(&end, 1, 0) > 0;
  }
  // Waits for the end, at most 5 s. Returns the status as waitpid() does; -1 if the process has not
  // ended or was no child of this process.
  int status_at_end() const {
    int status = -1;
    if (!wait_for([&] { return has_ended(); }, 5.0)) return -1;
    const bool is_read =
        wait_for([&] { return waitpid(number_, &status, WNOHANG) != 0; }, 1.0) && status >= 0;
    return is_read ? status : -1;
  }

 private:
  pid_t number_;
  int pidfd_;
};

// A guarded_engine. Its guard becomes a child of this process when the engine ends, so that the
// guard's exit status can be read. The destructor ends both.
class EngineProcess {
 public:
  EngineProcess(const char* program, const std::string& port, const std::string& behaviour) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    std::array<int, 2> ends;
    if (pipe2(ends.data(), O_CLOEXEC) != 0) return;
    output_ = ends[0];
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDOUT_FILENO);
    std::array<std::string, 3> words = {program, port, behaviour};
    const std::array<char*, 4> arguments = {words[0].data(), words[1].data(), words[2].data(),
                                            nullptr};
    pid_t number = 0;
    if (posix_spawn(&number, program, &files, nullptr, arguments.data(), environ) == 0) {
      engine_ = std::make_unique<WatchedProcess>(number);
    }
    posix_spawn_file_actions_destroy(&files);
    ::close(ends[1]);
    int fifo = 0;
    if (std::sscanf(read_line().c_str(), "guard %d %d", &number, &fifo) == 2) {
      guard_ = std::make_unique<WatchedProcess>(number);
    }
    has_fifo_ = fifo != 0;
  }
  ~EngineProcess() {
    for (const auto* process : {guard_.get(), engine_.get()}) {
      if (process != nullptr) process->send(SIGKILL);
    }
    for (const auto* process : {engine_.get(), guard_.get()}) {
      if (process != nullptr) process->status_at_end();
    }
    if (output_ >= 0) ::close(output_);
  }
  EngineProcess(const EngineProcess&) = delete;
  EngineProcess& operator=(const EngineProcess&) = delete;

  bool has_started() const { return engine_ != nullptr && guard_ != nullptr; }
  const WatchedProcess& engine() const { return *engine_; }
  const WatchedProcess& guard() const { return *guard_; }
  bool has_fifo() const { return has_fifo_; }

  // Waits for a line of output, at most 10 s.
  std::string read_line() const {
    std::string line;
    char c = 0;
    pollfd readable{output_, POLLIN, 0};
    while (poll(&readable, 1, 10'000) > 0 && ::read(output_, &c, 1) == 1 && c != '\n') line += c;
    return line;
  }

 private:
  std::unique_ptr<WatchedProcess> engine_;
  std::unique_ptr<WatchedProcess> guard_;
  bool has_fifo_ = false;
  int output_ = -1;
};

}  // namespace palpate
