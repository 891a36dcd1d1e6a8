#pragma once

// Replaces fields of settings, which the library's messages name, by options of the command line.

#include <string>

#include "geometry/base/result.h"

namespace palpate {

// Returns the text with every `Struct::field` in backquotes replaced by its option. A name in a
// file that is written in this form is replaced as well.
std::string with_option_names(std::string text);

// Returns the error with its element replaced by the option, if it is a field, and its texts
// changed as above.
Error with_option_names(Error error);

}  // namespace palpate
