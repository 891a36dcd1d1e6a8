#pragma once

// The memory limit of a scene, and the memory that parts of the scene need.

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "io/scene_description.h"

namespace palpate {

// Parses a number of bytes as a user writes it, e.g. "500M", "2G" or "1.5GiB". K, M, G and T, with
// or without a B, are powers of 1000; KiB, MiB, GiB and TiB are powers of 1024. Upper and lower
// case are equivalent. The result is at least 1 byte.
Result<std::uint64_t> parse_bytes(const std::string& text);

// The files in which Linux reports free memory. A missing file imposes no limit.
struct MemorySources {
  std::string meminfo = "/proc/meminfo";
  std::string own_groups = "/proc/self/cgroup";
  std::string group_root = "/sys/fs/cgroup";
  std::string own_pages = "/proc/self/statm";
};

// The default limit is half of the free memory. The free memory is the least of three amounts:
// - the memory that the machine has available (MemAvailable);
// - the memory left in the control groups of the process and in all their parent groups (cgroup
//   version 1 or 2), where file cache counts as free memory;
// - the memory left under the limits of the process (ulimit -v and -d).
MemoryLimit default_memory_limit(const MemorySources& sources = {});

// A limit of max_bytes (--max-memory), or the default limit if max_bytes is 0.
MemoryLimit memory_limit(std::uint64_t max_bytes);

// Heap memory of a string, in bytes.
inline std::uint64_t text_bytes(const std::string& text) {
  constexpr std::size_t kInside = 15;  // characters
  constexpr std::uint64_t kBlock = 16;
  return text.capacity() > kInside ? text.capacity() + kBlock : 0;
}

// Heap memory of a description, in bytes.
std::uint64_t memory_bytes(const SceneDescription& description);

// The memory need of several jobs together. At most `at_once` of the jobs run at the same time. The
// sum includes the results of all jobs, because all results are kept. It includes the temporary
// memory of those `at_once` jobs that need the most temporary memory.
MemoryNeed sum_of(std::vector<MemoryNeed> needs, std::size_t at_once);

}  // namespace palpate
