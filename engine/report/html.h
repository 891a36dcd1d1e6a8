#pragma once

// Parts of HTML5 documents.

#include <string>
#include <string_view>

namespace palpate {

// The text escaped for an element or a quoted attribute.
std::string html_escaped(std::string_view text);

// Converts an SVG document of gnuplot to an element of an HTML document. The element has no prolog,
// is scaled to its container and has `title` as its accessible name; this function escapes the
// title. All ids, and the references to them, get the prefix `id_prefix` (letters, digits and
// hyphens).
std::string inline_svg(std::string_view svg, std::string_view id_prefix, std::string_view title);

}  // namespace palpate
