#pragma once

// Parts of HTML5 documents.

#include <string>
#include <string_view>

namespace palpate {

// The text escaped for an element or a quoted attribute.
std::string html_escaped(std::string_view text);

// "<tag>content</tag>". tag: the name, optionally followed by a space and attributes, as in
// `td class="number"`; the caller escapes the content.
std::string html_element(std::string_view tag, std::string_view content);

// An HTML5 document (UTF-8) that needs no other file and no network. This function escapes the
// title; style is a style sheet, and body the content of the element `body`.
std::string html_page(std::string_view title, std::string_view style, std::string_view body);

// Converts an SVG document of gnuplot to an element of an HTML document. The element has no prolog,
// is scaled to its container and has `title` as its accessible name; this function escapes the
// title. All ids, and the references to them, get the prefix `id_prefix` (letters, digits and
// hyphens).
std::string inline_svg(std::string_view svg, std::string_view id_prefix, std::string_view title);

}  // namespace palpate
