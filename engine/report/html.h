#pragma once

// Pieces of HTML5 documents.

#include <string>
#include <string_view>

namespace palpate {

// The text as it is to be read, in an element or in a quoted attribute.
std::string html_escaped(std::string_view text);

// A gnuplot SVG document as an element to be put into HTML: without prolog, with its ids and all
// references to them behind `id_prefix` (letters, digits and hyphens), scaled to what it is put
// into, and told of to those who do not see it as `title` (escaped here).
std::string inline_svg(std::string_view svg, std::string_view id_prefix, std::string_view title);

}  // namespace palpate
