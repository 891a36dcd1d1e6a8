#include "engine/recording/log_space.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace palpate {

LogSpace::LogSpace(const std::string& path)
    : descriptor_(::open(path.c_str(), O_WRONLY | O_CLOEXEC)),
      problem_(descriptor_ < 0 ? errno : 0) {}

LogSpace::~LogSpace() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

LogSpace::LogSpace(LogSpace&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      problem_(other.problem_),
      reserved_(other.reserved_) {}

LogSpace& LogSpace::operator=(LogSpace&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  problem_ = other.problem_;
  reserved_ = other.reserved_;
  return *this;
}

int LogSpace::reserve(std::uint64_t bytes) {
  if (problem_ != 0) return problem_;
  if (bytes <= reserved_) return 0;
  int failed = 0;
  do {
    failed = ::fallocate(descriptor_, 0, 0, static_cast<off_t>(bytes)) == 0 ? 0 : errno;
  } while (failed == EINTR);
  // Not every file system can take space without a write.
  if (failed == EOPNOTSUPP || failed == ENOSYS) failed = write_zeros(bytes);
  if (failed == 0) reserved_ = bytes;
  return failed;
}

int LogSpace::write_zeros(std::uint64_t bytes) const {
  constexpr std::array<char, 4096> kZeros{};
  struct stat file {};
  if (::fstat(descriptor_, &file) != 0) return errno;
  for (auto at = static_cast<std::uint64_t>(file.st_size); at < bytes;) {
    const std::size_t count = std::min<std::uint64_t>(kZeros.size(), bytes - at);
    const ssize_t written = ::pwrite(descriptor_, kZeros.data(), count, static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written < 0 ? errno : ENOSPC;
    at += static_cast<std::uint64_t>(written);
  }
  return 0;
}

void LogSpace::cut(std::uint64_t bytes) {
  if (descriptor_ >= 0 && ::ftruncate(descriptor_, static_cast<off_t>(bytes)) == 0) {
    reserved_ = std::min(reserved_, bytes);
  }
}

}  // namespace palpate
