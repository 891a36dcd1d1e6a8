#pragma once

// The error for a file that the system refuses to write.

#include <string>
#include <system_error>

#include "geometry/base/result.h"

namespace palpate {

// reason: a value of errno.
inline Error write_error(const std::string& path, int reason) {
  return {ErrorCode::kFileUnwritable, path, "",
          "cannot be written: " + std::error_code(reason, std::generic_category()).message(),
          "check the folder, its permissions and the free disk space"};
}

}  // namespace palpate
