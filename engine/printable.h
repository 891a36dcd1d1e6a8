#pragma once

// Text that comes from outside (names in files, arguments), made fit for one line of a document.

#include <string>
#include <string_view>

namespace palpate {

// The same text, with a space for each control character and "?" for each byte that is not part of
// valid UTF-8. XML knows neither.
std::string printable(std::string_view text);

}  // namespace palpate
