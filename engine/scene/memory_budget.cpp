#include "engine/scene/memory_budget.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <sys/resource.h>
#include <unistd.h>
#include <utility>

#include "geometry/base/memory_breakdown.h"

namespace palpate {
namespace {

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

// --- Numbers of bytes that a user writes ---------------------------------------------------------

// The number of bytes in a unit; 0 for an unknown unit.
double bytes_in(std::string unit) {
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (unit.empty() || unit == "b") return 1.0;
  constexpr std::string_view kPrefixes = "kmgt";
  const std::size_t power = kPrefixes.find(unit.front());
  if (power == std::string_view::npos) return 0.0;
  const std::string rest = unit.substr(1);
  const double step = rest.empty() || rest == "b" ? 1000.0 : rest == "ib" ? 1024.0 : 0.0;
  return step > 0.0 ? std::pow(step, static_cast<double>(power + 1)) : 0.0;
}

// --- Free memory that the system reports ---------------------------------------------------------

// The memory that may still be allocated, and the limit that determines it.
struct FreeMemory {
  std::uint64_t bytes = kUnlimited;
  std::string of;  // "the machine has free"
};

void keep_less(FreeMemory& least, std::uint64_t bytes, const std::string& of) {
  if (bytes < least.bytes) least = {bytes, of};
}

std::uint64_t difference(std::uint64_t limit, std::uint64_t used) {
  return limit - std::min(used, limit);
}

// The number at the beginning of a file; no value if the file does not exist or contains "max".
std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (file >> number) return number;
  return std::nullopt;
}

// The number after a name, in a file whose lines are a name and a number.
std::optional<std::uint64_t> number_named(const std::string& path, std::string_view name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string key;
    std::uint64_t number = 0;
    if (words >> key >> number && key == name) return number;
  }
  return std::nullopt;
}

// The files in which a control group of one version reports its limit and its use.
struct GroupFiles {
  const char* limit;
  const char* used;
  const char* cached[2];  // names in memory.stat
};
constexpr GroupFiles kVersion1{
    "memory.limit_in_bytes", "memory.usage_in_bytes", {"total_inactive_file", "total_active_file"}};
constexpr GroupFiles kVersion2{"memory.max", "memory.current", {"inactive_file", "active_file"}};

void read_group(const std::string& folder, const std::string& name, const GroupFiles& files,
                FreeMemory& least) {
  const auto limit = number_in(folder + "/" + files.limit);
  const auto used = number_in(folder + "/" + files.used);
  if (!limit || !used) return;
  std::uint64_t cached = 0;
  for (const char* key : files.cached) {
    cached += number_named(folder + "/memory.stat", key).value_or(0);
  }
  keep_less(least, difference(*limit, difference(*used, cached)),
            "the control group " + (name.empty() ? "/" : name) + " has free");
}

// Reads a group and all its parent groups. A container may show only the outermost of them.
void read_groups(const std::string& root, std::string name, const GroupFiles& files,
                 FreeMemory& least) {
  if (name.find("..") != std::string::npos) name.clear();
  while (true) {
    read_group(root + name, name, files, least);
    if (name.empty()) return;
    const std::size_t last = name.rfind('/');
    name.erase(last == name.npos ? 0 : last);
  }
}

// Lines of /proc/self/cgroup: "0::/name" of version 2, "4:memory:/name" of version 1.
void read_all_groups(const MemorySources& sources, FreeMemory& least) {
  std::ifstream file(sources.own_groups);
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == line.npos ? line.npos : line.find(':', first + 1);
    if (second == line.npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    std::string name = line.substr(second + 1);
    if (name == "/") name.clear();
    if (controllers == ",,") {
      read_groups(sources.group_root, name, kVersion2, least);
    } else if (controllers.find(",memory,") != std::string::npos) {
      read_groups(sources.group_root + "/memory", name, kVersion1, least);
    }
  }
}

void read_process_limits(const MemorySources& sources, FreeMemory& least) {
  std::ifstream file(sources.own_pages);
  std::uint64_t all = 0;
  std::uint64_t ignored = 0;
  std::uint64_t data = 0;
  if (!(file >> all >> ignored >> ignored >> ignored >> ignored >> data)) return;
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const auto read_limit = [&](auto resource, std::uint64_t pages, const char* of) {
    rlimit limit{};
    if (::getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
    keep_less(least, difference(limit.rlim_cur, pages * page), of);
  };
  read_limit(RLIMIT_AS, all, "the process may still reserve (ulimit -v)");
  read_limit(RLIMIT_DATA, data, "the process may still use for data (ulimit -d)");
}

}  // namespace

Result<std::uint64_t> parse_bytes(const std::string& text) {
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, failed] = std::from_chars(text.data(), end, number, std::chars_format::fixed);
  const double bytes = failed == std::errc() ? number * bytes_in(std::string(rest, end)) : 0.0;
  constexpr double kTooMany = 0x1p63;
  if (bytes >= 1.0 && bytes < kTooMany) return static_cast<std::uint64_t>(bytes);  // false for NaN
  return Error{ErrorCode::kInvalidArgument, "", "max_memory_bytes",
               "is \"" + text + "\"; expected a number of bytes",
               "write for example 500M, 1.5G (powers of 1000) or 2GiB (powers of 1024)"};
}

MemoryLimit default_memory_limit(const MemorySources& sources) {
  FreeMemory least;
  constexpr std::uint64_t kBytesPerKb = 1024;
  if (const auto available = number_named(sources.meminfo, "MemAvailable:")) {
    keep_less(least, kBytesPerKb * *available, "the machine has free");
  }
  read_all_groups(sources, least);
  read_process_limits(sources, least);
  if (least.bytes == kUnlimited) return {};
  return {least.bytes / 2, "half of the " + bytes_text(least.bytes) + " that " + least.of,
          "`SceneSettings::max_memory_bytes`"};
}

MemoryLimit memory_limit(std::uint64_t max_bytes) {
  if (max_bytes == 0) return default_memory_limit();
  return {max_bytes, "given by `SceneSettings::max_memory_bytes`",
          "`SceneSettings::max_memory_bytes`"};
}

std::uint64_t memory_bytes(const SceneDescription& description) {
  std::uint64_t bytes = bytes_of(description.meshes) + bytes_of(description.nodes) +
                        bytes_of(description.tree) + bytes_of(description.images) +
                        bytes_of(description.contours);
  for (const MeshDescription& mesh : description.meshes) {
    bytes += text_bytes(mesh.name) + bytes_of(mesh.positions) + bytes_of(mesh.triangles) +
             bytes_of(mesh.material_runs) + bytes_of(mesh.texture_uv) + bytes_of(mesh.friction_uv);
  }
  for (const NodeDescription& node : description.nodes) bytes += text_bytes(node.name);
  for (const TreeNode& node : description.tree) bytes += text_bytes(node.name);
  for (const ContourDescription& contour : description.contours) {
    bytes += text_bytes(contour.node) + text_bytes(contour.element) + text_bytes(contour.problem) +
             text_bytes(contour.hint);
  }
  for (const ImageDescription& image : description.images) bytes += bytes_of(image.rgb);
  return bytes;
}

MemoryNeed sum_of(std::vector<MemoryNeed> needs, std::size_t at_once) {
  const auto temporary = [](const MemoryNeed& need) { return need.peak - need.kept; };
  MemoryNeed sum;
  for (const MemoryNeed& need : needs) sum.kept += need.kept;
  sum.peak = sum.kept;
  const std::size_t most = std::min(at_once, needs.size());
  std::nth_element(
      needs.begin(), needs.begin() + static_cast<std::ptrdiff_t>(most), needs.end(),
      [&](const MemoryNeed& x, const MemoryNeed& y) { return temporary(x) > temporary(y); });
  for (std::size_t i = 0; i < most; ++i) sum.peak += temporary(needs[i]);
  return sum;
}

}  // namespace palpate
