#pragma once

// Reads files that an untrusted asset may name.

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "geometry/base/fixed_array.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"

namespace palpate {

using FileBytes = FixedArray<std::uint8_t>;

inline constexpr std::uint64_t kWholeFile = std::numeric_limits<std::uint64_t>::max();

// A regular file that is open for reading. A folder, pipe, socket or device causes an error; no
// function waits for data from it. Error::path is the given path. Thread-safe.
class RegularFile {
 public:
  static Result<RegularFile> open(const std::string& path);
  RegularFile(RegularFile&& other) noexcept;
  RegularFile& operator=(RegularFile&& other) noexcept;
  ~RegularFile();

  // When the file was opened.
  std::uint64_t size() const { return size_; }
  // Requires begin + length <= size(). An error if the file has become shorter than that.
  Result<FileBytes> read(std::uint64_t begin, std::uint64_t length) const;
  // An error if the file has more than this number of bytes.
  std::optional<Error> check_size(std::uint64_t max_bytes) const;

 private:
  RegularFile(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::string path_;
  int descriptor_;
  std::uint64_t size_ = 0;
};

// The first wanted_bytes of a regular file, or all of its bytes if it has fewer. A file of more
// than max_bytes causes an error. A folder, pipe, socket or device also causes an error; the
// function never waits for data from it. Error::path is the given path. memory: counts the bytes in
// its current step before they are allocated; may be null. Thread-safe.
Result<FileBytes> read_regular_file(const std::string& path, std::uint64_t max_bytes,
                                    std::uint64_t wanted_bytes = kWholeFile,
                                    MemoryLedger* memory = nullptr);

// Makes the file that a URI of an asset names an input of the program (file_roles.h), whether it is
// read or not, and whether resolve_inside() takes it or not: with the scheme "file", with a query
// or a fragment, with "\" as a separator, and with a percent sign that is no escape. folder: the
// folder of the asset. Data URIs and missing files have no effect.
std::optional<Error> add_referenced_input(const std::string& folder, const std::string& uri);

// The file that a relative URI reference of an asset names, percent-decoded. folder: the folder of
// the asset; the current directory is never used. Errors: a scheme, an absolute path, an invalid
// escape, and a path outside the folder after "..", links and escapes are resolved. Thread-safe.
Result<std::string> resolve_inside(const std::string& folder, const std::string& uri);

}  // namespace palpate
