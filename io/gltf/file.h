#pragma once

// Reading files that an untrusted asset may have named.

#include <cstdint>
#include <limits>
#include <string>

#include "geometry/base/fixed_array.h"
#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"

namespace palpate {

using FileBytes = FixedArray<std::uint8_t>;

inline constexpr std::uint64_t kWholeFile = std::numeric_limits<std::uint64_t>::max();

// The content of a regular file of at most max_bytes, or its beginning if no more than
// wanted_bytes are called for. A folder, pipe, socket or device is refused without being waited
// for. Error::path is the path given. memory: if there is one, it counts the bytes, in its present
// step, before they are taken. Thread-safe.
Result<FileBytes> read_regular_file(const std::string& path, std::uint64_t max_bytes,
                                    std::uint64_t wanted_bytes = kWholeFile,
                                    MemoryLedger* memory = nullptr);

// The file that a relative URI reference of an asset names, percent-decoded. folder: that of the
// asset. Refused: a scheme, an absolute path, a broken escape, and whatever lies outside the folder
// once "..", links and escapes are resolved. Never the current directory. Thread-safe.
Result<std::string> resolve_inside(const std::string& folder, const std::string& uri);

}  // namespace palpate
