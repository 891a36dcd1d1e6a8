#pragma once

// A secret on stdout.

#include <optional>
#include <string>

namespace palpate {

// Call this before a secret is printed. A file or a named pipe behind stdout that others may read
// is made private (mode 0600, or less). Returns what the user must know about it, in one line; no
// value: nothing, as with a terminal.
std::optional<std::string> make_output_private();

}  // namespace palpate
