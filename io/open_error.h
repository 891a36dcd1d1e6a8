#pragma once

// The error for a file that the system cannot open.

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "geometry/base/result.h"

namespace palpate {

// reason: a value of errno.
inline Error open_error(const std::string& path, int reason, std::string hint = "") {
  const bool is_missing = reason == ENOENT || reason == ENOTDIR;
  return {is_missing ? ErrorCode::kFileNotFound : ErrorCode::kFileUnreadable, path, "",
          "cannot be opened: " + std::error_code(reason, std::generic_category()).message(),
          std::move(hint)};
}

}  // namespace palpate
