#pragma once

// A file that the system does not let us write.

#include <string>
#include <system_error>

#include "geometry/base/result.h"

namespace palpate {

// reason: as of errno.
inline Error write_error(const std::string& path, int reason) {
  return {ErrorCode::kFileUnwritable, path, "",
          "cannot be written: " + std::error_code(reason, std::generic_category()).message(),
          "check the folder, its permissions and the space left"};
}

}  // namespace palpate
