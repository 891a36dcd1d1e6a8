#include "engine/trials/deal/shard_locks.h"

#include <cerrno>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace palpate {
namespace {

constexpr off_t kPreparation = 0;  // the byte whose lock means that a process prepares the folder
constexpr off_t kToTheEnd = 0;     // as the length of a lock: all bytes from its start on

// Locks of open file descriptions: the ones of a process would end when it closes the file
// elsewhere. Returns 0 or errno.
int set_lock(int descriptor, int command, short type, off_t start, off_t length) {
  struct flock lock = {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = start;
  lock.l_len = length;
  int code = 0;
  do {
    code = ::fcntl(descriptor, command, &lock);
  } while (code != 0 && errno == EINTR);
  return code == 0 ? 0 : errno;
}

bool is_held_by_another(int reason) {
  return reason == EAGAIN || reason == EACCES;
}

}  // namespace

ShardLocks::ShardLocks(const std::string& path)
    : descriptor_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOCTTY, 0666)) {
  set_lock(descriptor_, F_OFD_SETLKW, F_WRLCK, kPreparation, 1);
}

ShardLocks::~ShardLocks() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

ShardLocks::ShardLocks(ShardLocks&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

bool ShardLocks::are_others_running() const {
  const int reason = set_lock(descriptor_, F_OFD_SETLK, F_WRLCK, kPreparation + 1, kToTheEnd);
  if (reason == 0) set_lock(descriptor_, F_OFD_SETLK, F_UNLCK, kPreparation + 1, kToTheEnd);
  return is_held_by_another(reason);
}

std::optional<int> ShardLocks::take(const std::vector<int>& units) {
  for (const int unit : units) {
    if (is_held_by_another(set_lock(descriptor_, F_OFD_SETLK, F_WRLCK, kPreparation + unit, 1))) {
      return unit;
    }
  }
  return std::nullopt;
}

void ShardLocks::end_preparation() {
  set_lock(descriptor_, F_OFD_SETLK, F_UNLCK, kPreparation, 1);
}

}  // namespace palpate
