#pragma once

#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// Writes a text to a file, replacing its content, and returns the path. If any byte cannot be
// written, returns an error and removes the incomplete file. Not for the haptic thread.
Result<std::string> write_text_file(const std::string& path, std::string_view text);

}  // namespace palpate
