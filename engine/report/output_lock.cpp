#include "engine/report/output_lock.h"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <mutex>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace palpate {
namespace {

using FolderId = std::pair<dev_t, ino_t>;

std::string reason_text(int reason) {
  return std::error_code(reason, std::generic_category()).message();
}

Error lock_error(const std::string& folder, std::string problem, std::string hint) {
  return {ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`", std::move(problem),
          std::move(hint)};
}

}  // namespace

struct OutputLock::Held {
  Held(int descriptor_given, FolderId id_given) : descriptor(descriptor_given), id(id_given) {}
  ~Held() { ::close(descriptor); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

  // Returns 0 or errno.
  int lock(FolderUse wanted) {
    const bool is_alone = wanted == FolderUse::kAlone;
    int code = 0;
    do {
      code = ::flock(descriptor, (is_alone ? LOCK_EX : LOCK_SH) | LOCK_NB);
    } while (code != 0 && errno == EINTR);
    if (code != 0) return errno;
    if (!is_alone && !set_mark(wanted)) return EWOULDBLOCK;
    use = wanted;
    return 0;
  }

  // Marks the folder's byte of this use, and returns whether no other process has marked that of
  // the other shared use. True on a file system without such marks.
  bool set_mark(FolderUse wanted) const {
    struct flock mark = {};
    mark.l_type = F_RDLCK;
    mark.l_whence = SEEK_SET;
    mark.l_start = wanted == FolderUse::kShard ? 0 : 1;
    mark.l_len = 1;
    if (::fcntl(descriptor, F_OFD_SETLK, &mark) != 0) return true;
    struct flock other = mark;
    other.l_start = 1 - mark.l_start;
    other.l_type = F_UNLCK;  // the mark of an earlier use
    ::fcntl(descriptor, F_OFD_SETLK, &other);
    other.l_type = F_WRLCK;  // what a read lock of another process keeps out
    return ::fcntl(descriptor, F_OFD_GETLK, &other) != 0 || other.l_type == F_UNLCK;
  }

  int descriptor;
  FolderId id;
  FolderUse use = FolderUse::kFile;
};

namespace {

// The locks of this process, and the folders without one.
struct ProcessLocks {
  std::mutex mutex;
  std::map<FolderId, std::weak_ptr<void>> held;
  std::map<std::filesystem::path, std::string> unlocked;  // with their lines

  void add_unlocked(const std::filesystem::path& folder, int reason) {
    for (auto around = folder; around.has_relative_path(); around = around.parent_path()) {
      if (unlocked.contains(around)) return;
    }
    unlocked[folder] = folder.string() + " cannot be locked (" + reason_text(reason) +
                       "); make sure that no other command writes there";
  }
};

ProcessLocks& process_locks() {
  static ProcessLocks locks;
  return locks;
}

}  // namespace

Result<OutputLock> OutputLock::take(const std::string& folder, FolderUse use) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0 && errno != EACCES) {
    return lock_error(folder, "cannot be opened: " + reason_text(errno),
                      "name a folder that can be written to");
  }
  ProcessLocks& locks = process_locks();
  const std::lock_guard guard(locks.mutex);
  if (descriptor < 0) {  // it can be written to, but not read
    locks.add_unlocked(folder, EACCES);
    return OutputLock();
  }
  struct stat status = {};
  ::fstat(descriptor, &status);
  auto opened = std::make_shared<Held>(descriptor, FolderId(status.st_dev, status.st_ino));
  auto held = std::static_pointer_cast<Held>(locks.held[opened->id].lock());
  if (held && (held->use == FolderUse::kAlone || use == held->use || use == FolderUse::kFile)) {
    return OutputLock(std::move(held));
  }
  if (!held) held = std::move(opened);
  const FolderUse before = held->use;
  const int reason = held->lock(use);
  if (reason == EWOULDBLOCK) {
    held->lock(before);  // a failed change loses the lock
    return lock_error(folder, "is in use: another command is writing its results there",
                      "wait until that command has ended, or choose another folder");
  }
  if (reason != 0) locks.add_unlocked(folder, reason);
  locks.held[held->id] = held;
  return OutputLock(std::move(held));
}

Result<OutputLock> OutputLock::take_for_file(const std::string& path) {
  const auto parent = std::filesystem::path(path).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  std::error_code failed;
  if (!std::filesystem::is_directory(folder, failed)) return OutputLock();
  auto taken = take(folder, FolderUse::kFile);
  if (taken) return taken;
  Error error = taken.error();
  error.element.clear();
  return error;
}

bool OutputLock::is_at(const std::string& folder) const {
  if (!held_) return true;
  struct stat there = {};
  return ::stat(folder.c_str(), &there) == 0 && held_->id == FolderId(there.st_dev, there.st_ino);
}

std::vector<std::string> unlocked_folders() {
  ProcessLocks& locks = process_locks();
  const std::lock_guard guard(locks.mutex);
  std::vector<std::string> lines;
  for (const auto& [folder, line] : locks.unlocked) lines.push_back(line);
  return lines;
}

}  // namespace palpate
