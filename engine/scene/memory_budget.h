#pragma once

// How much memory a scene may take, and what its parts do.

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "io/scene_description.h"

namespace palpate {

// A number of bytes as a user writes it: "500M", "2G", "1.5GiB". K, M, G and T are of 1000, with or
// without a B; KiB, MiB, GiB and TiB of 1024; upper or lower case. 1 byte at least.
Result<std::uint64_t> parse_bytes(const std::string& text);

// Where the system tells how much memory is free. Files that are not there limit nothing.
struct MemorySources {
  std::string meminfo = "/proc/meminfo";
  std::string own_groups = "/proc/self/cgroup";
  std::string group_root = "/sys/fs/cgroup";
  std::string own_pages = "/proc/self/statm";
};

// Half of what is free by the least of: the machine (MemAvailable); the control groups of the
// process and all above them, of either version, in which what only caches files counts as free;
// and the limits of the process (ulimit -v and -d).
MemoryLimit default_memory_limit(const MemorySources& sources = {});

// The same for 0; else these bytes, as given by --max-memory.
MemoryLimit memory_limit(std::uint64_t max_bytes);

// What a text takes outside of the object.
inline std::uint64_t text_bytes(const std::string& text) {
  constexpr std::size_t kInside = 15;  // characters
  constexpr std::uint64_t kBlock = 16;
  return text.capacity() > kInside ? text.capacity() + kBlock : 0;
}

// What a description takes.
std::uint64_t memory_bytes(const SceneDescription& description);

// Of needs that are met at the same time, `at_once` of them being worked on.
MemoryNeed sum_of(std::vector<MemoryNeed> needs, std::size_t at_once);

}  // namespace palpate
