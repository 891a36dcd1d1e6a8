#pragma once

// Parts of HTML5 documents.

#include <string>
#include <string_view>

namespace palpate {

// The text escaped for an element or a quoted attribute.
std::string html_escaped(std::string_view text);

// Converts a gnuplot SVG document to an element for an HTML document: without prolog, scaled to its
// container, and with `title` as its accessible name (escaped here). Its ids and all references to
// them are prefixed with `id_prefix` (letters, digits and hyphens).
std::string inline_svg(std::string_view svg, std::string_view id_prefix, std::string_view title);

}  // namespace palpate
