#pragma once

// Replaces fields of settings, which the library's messages name, by options of the command line.

#include <string>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// Returns the text with every `Struct::field` in backquotes replaced by its option. A name from a
// scene file that has this form is replaced as well.
std::string with_option_names(std::string text);

// The same for each line.
std::vector<std::string> with_option_names(std::vector<std::string> lines);

// Returns the error with its texts changed in the same way. If the element of the error is a field,
// the option replaces it.
Error with_option_names(Error error);

}  // namespace palpate
