#pragma once

// Lets shards of one run share a folder, each with units of its own.

#include <optional>
#include <string>
#include <vector>

namespace palpate {

// Locks on a file in the folder, one for each unit. They end with the process, and a program that
// the process starts does not have them. Where the file system has no locks, all functions succeed.
// Only one thread may use an object.
class ShardLocks {
 public:
  // Opens the file, or creates an empty one, and waits until no other process prepares the folder.
  explicit ShardLocks(const std::string& path);
  ~ShardLocks();
  ShardLocks(ShardLocks&& other) noexcept;
  ShardLocks& operator=(ShardLocks&&) = delete;

  // Whether another process holds the lock of some unit.
  bool are_others_running() const;
  // Takes the locks of these units, which are at least 1. Returns the first one whose lock another
  // process holds; no value if all are taken.
  std::optional<int> take(const std::vector<int>& units);
  // From now on, other processes may prepare the folder.
  void end_preparation();

 private:
  int descriptor_;
};

}  // namespace palpate
