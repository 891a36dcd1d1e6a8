#pragma once

// Work in child processes that are killed, for tests of what remains of killed work.

#include <chrono>
#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

namespace palpate::test {

// Waits for a child process. True if it ended by itself, false if it was killed.
inline bool has_ended(pid_t child) {
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  if (WIFEXITED(status)) {
    EXPECT_EQ(WEXITSTATUS(status), 0);
    return true;
  }
  EXPECT_EQ(WTERMSIG(status), SIGKILL);
  return false;
}

// Runs in a child process, which kills itself in some cases. True if it ended. work: returns
// whether it succeeded.
template <typename Work>
bool run_in_child(const Work& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work() ? 0 : 1);
  return has_ended(child);
}

// Runs in a child process, which is killed after `life` unless it has ended. True if it ended.
template <typename Work>
bool run_in_child(std::chrono::microseconds life, const Work& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work() ? 0 : 1);
  const auto end = std::chrono::steady_clock::now() + life;
  siginfo_t ended{};
  while (std::chrono::steady_clock::now() < end && ended.si_pid == 0) {
    ::usleep(100);
    ::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
  }
  ::kill(child, SIGKILL);
  return has_ended(child);
}

}  // namespace palpate::test
