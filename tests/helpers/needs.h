#pragma once

// What a test needs of the machine. Where the machine lacks it, the test is not run and says so in
// one line that begins with "needs ". test.sh lists these lines at its end; .ci/run fails on any.
// needs.py is the same for tests in Python.

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <stdlib.h>
#include <string>
#include <system_error>
#include <unistd.h>

// Ends the test as not run if the text, of one of the functions below, is not empty. In a fixture,
// call it in SetUp(). Needs <gtest/gtest.h>.
#define PALPATE_NEEDS(lack)                                  \
  do {                                                       \
    const std::string palpate_lack = (lack);                 \
    if (!palpate_lack.empty()) GTEST_SKIP() << palpate_lack; \
  } while (false)

namespace palpate::test {

inline std::string reason_of_errno() {
  return std::generic_category().message(errno);
}

// Empty if a pseudo-terminal can be made and its other side can be opened.
inline std::string lack_of_terminals() {
  const int board = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  std::array<char, 128> path{};
  const bool is_made = board >= 0 && ::grantpt(board) == 0 && ::unlockpt(board) == 0 &&
                       ::ptsname_r(board, path.data(), path.size()) == 0;
  const int host = is_made ? ::open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC) : -1;
  const std::string reason = host >= 0 ? "" : reason_of_errno();
  if (host >= 0) ::close(host);
  if (board >= 0) ::close(board);
  return host >= 0 ? ""
                   : "needs a pseudo-terminal: " + reason +
                         "; mount devpts on /dev/pts, and make /dev/ptmx";
}

// Empty if the file is a device that refuses each write as a full disk does.
inline std::string lack_of_full_disk() {
  const int full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
  const bool refuses = full >= 0 && ::write(full, "x", 1) < 0 && errno == ENOSPC;
  if (full >= 0) ::close(full);
  return refuses ? "" : "needs /dev/full, which refuses each write; mknod /dev/full c 1 7";
}

}  // namespace palpate::test
