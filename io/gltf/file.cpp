#include "io/gltf/file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <mutex>
#include <optional>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include "geometry/base/file_roles.h"
#include "geometry/base/parallel.h"
#include "io/ascii.h"
#include "io/gltf/error.h"
#include "io/open_error.h"

namespace palpate {
namespace {

Error file_error(ErrorCode code, const std::string& path, std::string problem,
                 std::string hint = {}) {
  return {code, path, {}, std::move(problem), std::move(hint)};
}

// Reads a part of the bytes, of which the first is at `offset` in the file. If that fails, returns
// the byte at which reading stopped.
std::optional<std::size_t> read_part(int descriptor, std::uint64_t offset, std::size_t begin,
                                     std::size_t end, FileBytes& bytes) {
  while (begin < end) {
    const ssize_t got =
        ::pread(descriptor, &bytes[begin], end - begin, static_cast<off_t>(offset + begin));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return begin;
    begin += static_cast<std::size_t>(got);
  }
  return std::nullopt;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<std::string> percent_decoded(const std::string& uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      decoded += uri[i];
      continue;
    }
    if (uri.size() - i < 3) return std::nullopt;
    const int high = hex_digit(uri[i + 1]);
    const int low = hex_digit(uri[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return decoded;
}

// RFC 3986, section 3.1: a letter, then letters, digits, "+", "-" or "." up to a colon.
bool has_scheme(const std::string& uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string::npos || colon == 0) return false;
  const std::string allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-.";
  return uri.find_first_not_of(allowed) == colon;
}

// The path of file:///path, file://host/path and file:path; any other URI as it is.
std::string without_file_scheme(const std::string& uri) {
  const std::string scheme = "file:";
  if (!starts_with_ignoring_case(uri, scheme)) return uri;
  std::string path = uri.substr(scheme.size());
  if (!path.starts_with("//")) return path;
  const std::size_t begin = path.find('/', 2);
  return begin == std::string::npos ? path.substr(2) : path.substr(begin);
}

// Every name that some reader may take the URI for: with and without its query and fragment, with
// "\\" as a separator, percent-decoded and as it is. None for a data URI.
std::vector<std::string> possible_names(const std::string& uri) {
  if (uri.empty() || starts_with_ignoring_case(uri, "data:")) return {};
  std::vector<std::string> names = {without_file_scheme(uri)};
  // Adds the changed form of each name found so far.
  const auto vary = [&](const auto& changed) {
    const std::size_t count = names.size();
    for (std::size_t i = 0; i < count; ++i) {
      std::optional<std::string> name = changed(names[i]);
      if (name && !name->empty() && *name != names[i]) names.push_back(std::move(*name));
    }
  };
  using Name = std::optional<std::string>;
  vary([](const std::string& name) { return Name(name.substr(0, name.find('#'))); });
  vary([](const std::string& name) { return Name(name.substr(0, name.find('?'))); });
  vary([](std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    return Name(std::move(name));
  });
  vary(percent_decoded);
  return names;
}

bool lies_inside(const std::filesystem::path& folder, const std::filesystem::path& file) {
  auto part = file.begin();
  for (const auto& expected : folder) {
    if (part == file.end() || *part != expected) return false;
    ++part;
  }
  return part != file.end();
}

}  // namespace

Result<RegularFile> RegularFile::open(const std::string& path) {
  if (path.find('\0') != std::string::npos) {
    return file_error(ErrorCode::kFileNotFound, path.substr(0, path.find('\0')),
                      "the name contains a zero byte");
  }
  // Non-blocking, because opening a pipe otherwise waits for its writer.
  RegularFile file(path, ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY));
  if (file.descriptor_ < 0) return open_error(path, errno);
  struct stat status {};
  if (::fstat(file.descriptor_, &status) != 0) return open_error(path, errno);
  if (!S_ISREG(status.st_mode)) {
    return file_error(
        ErrorCode::kFileUnreadable, path,
        S_ISDIR(status.st_mode) ? "is a folder; expected a file" : "is not a regular file");
  }
  if (auto error = add_input(file.descriptor_, path)) return *error;
  file.size_ = static_cast<std::uint64_t>(status.st_size);
  return file;
}

RegularFile::RegularFile(RegularFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

RegularFile& RegularFile::operator=(RegularFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

RegularFile::~RegularFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::optional<Error> RegularFile::check_size(std::uint64_t max_bytes) const {
  if (size_ <= max_bytes) return std::nullopt;
  return file_error(ErrorCode::kLimitExceeded, path_,
                    "has " + std::to_string(size_) + " bytes; at most " +
                        std::to_string(max_bytes) + " are read");
}

Result<FileBytes> RegularFile::read(std::uint64_t begin, std::uint64_t length) const {
  constexpr std::size_t kBytesWorthAThread = std::size_t{1} << 21;  // a millisecond of work
  FileBytes bytes(length);
  std::mutex mutex;
  std::optional<std::size_t> missing;
  run_ranges(bytes.size(), kBytesWorthAThread, [&](std::size_t from, std::size_t to) {
    const auto failed = read_part(descriptor_, begin, from, to, bytes);
    if (!failed) return;
    const std::lock_guard lock(mutex);
    missing = missing ? std::min(*missing, *failed) : *failed;
  });
  if (!missing) return bytes;
  return file_error(ErrorCode::kFileUnreadable, path_,
                    "cannot be read past byte " + std::to_string(begin + *missing) + " of " +
                        std::to_string(begin + length));
}

Result<FileBytes> read_regular_file(const std::string& path, std::uint64_t max_bytes,
                                    std::uint64_t wanted_bytes, MemoryLedger* memory) {
  const auto file = RegularFile::open(path);
  if (!file) return file.error();
  if (auto error = file->check_size(max_bytes)) return *error;
  const std::uint64_t length = std::min(file->size(), wanted_bytes);
  if (memory != nullptr) {
    if (auto error = memory->take(length)) {
      error->path = path;
      return *error;
    }
  }
  return file->read(0, length);
}

std::optional<Error> add_referenced_input(const std::string& folder, const std::string& uri) {
  for (const std::string& name : possible_names(uri)) {
    if (auto error = add_input((std::filesystem::path(folder) / name).string())) return error;
  }
  return std::nullopt;
}

Result<std::string> resolve_inside(const std::string& folder, const std::string& uri) {
  const std::string hint =
      "keep the files of an asset in its folder, and name them relative to the folder";
  if (has_scheme(uri)) {
    return gltf_error(ErrorCode::kUnsupported, {}, "the URI " + in_quotes(uri) + " is not relative",
                      hint);
  }
  const auto decoded = percent_decoded(uri);
  if (!decoded || decoded->find('\0') != std::string::npos) {
    return gltf_invalid({},
                        "the URI " + in_quotes(uri) + " has a broken escape; expected %20 to %FF",
                        "write a literal percent sign as %25");
  }
  if (decoded->empty() || decoded->front() == '/') {
    return gltf_invalid({}, "the URI " + in_quotes(uri) + " is not a relative path", hint);
  }
  std::error_code failed;
  const std::filesystem::path inside =
      std::filesystem::canonical(folder.empty() ? "." : folder, failed);
  if (failed) return file_error(ErrorCode::kFileUnreadable, folder, failed.message());
  const auto file = std::filesystem::weakly_canonical(inside / *decoded, failed);
  if (failed) {
    return gltf_error(ErrorCode::kFileNotFound, {},
                      "the URI " + in_quotes(uri) + " names no file: " + failed.message());
  }
  if (!lies_inside(inside, file)) {
    return gltf_invalid({}, "the URI " + in_quotes(uri) + " leads out of the folder of the asset",
                        hint);
  }
  return file.string();
}

}  // namespace palpate
