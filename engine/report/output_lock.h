#pragma once

// Keeps a second command out of the folder of its results.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

enum class FolderUse : std::uint8_t {
  kAlone,  // no other command may write there
  kShard,  // other commands with this use may, which are shards of one run
  kFile    // others with this use may: each writes a file that it names, among any other files
};

// The lock of a folder. It leaves nothing in the folder. It ends when the last copy is destroyed or
// with the process, however the process ends; a program that the process starts does not have it. A
// process can take the lock of one folder several times; the first use but kFile then stays, and
// kAlone is the strongest.
// Thread-safe.
class OutputLock {
 public:
  // folder: a folder that exists. Returns an error if another process has the lock. Without an
  // error, the lock is not held where the file system has no locks (unlocked_folders()).
  static Result<OutputLock> take(const std::string& folder, FolderUse use);

  // The lock kFile of the folder of a file; of no folder if that folder does not exist. An error
  // has no element, because the path is not that of an option for a folder.
  static Result<OutputLock> take_for_file(const std::string& path);

  OutputLock() = default;  // of no folder

  // Whether the folder still has its name: another command may have removed it before the lock was
  // taken.
  bool is_at(const std::string& folder) const;

 private:
  struct Held;
  explicit OutputLock(std::shared_ptr<Held> held) : held_(std::move(held)) {}

  std::shared_ptr<Held> held_;
};

// One line for each folder whose lock this process could not take because its file system has no
// locks: nothing keeps a second command out of it. A folder inside such a folder has no line.
std::vector<std::string> unlocked_folders();

}  // namespace palpate
