#pragma once

#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// Puts a text into a file, in place of what was there. Returns the path; an error if any byte could
// not be written, and then leaves no part of it behind. Not for the haptic thread.
Result<std::string> write_text_file(const std::string& path, std::string_view text);

}  // namespace palpate
