#pragma once

// The options of the command line, for the fields of settings that the library names.

#include <string>

#include "geometry/base/result.h"

namespace palpate {

// The library names a field in a text as `Struct::field`, in backquotes. The same text with the
// option in its place; so is a name in a file that is written so.
std::string with_option_names(std::string text);

// An error whose element is a field has the option in its place; its texts are as above.
Error with_option_names(Error error);

}  // namespace palpate
