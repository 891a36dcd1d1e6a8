#include "tests/helpers/deadly_rename.h"

#include <atomic>
#include <csignal>
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

namespace {

std::atomic<int> renames_left{0};  // 0 or less: the process lives on

}  // namespace

namespace palpate::test {

void die_at_rename(int count) {
  renames_left.store(count);
}

}  // namespace palpate::test

extern "C" int rename(const char* from, const char* to) noexcept {
  if (renames_left.fetch_sub(1) == 1) ::kill(::getpid(), SIGKILL);
  return ::renameat(AT_FDCWD, from, AT_FDCWD, to);
}
