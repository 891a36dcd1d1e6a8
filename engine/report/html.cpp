#include "engine/report/html.h"

#include <array>
#include <cctype>

#include "geometry/base/printable.h"

namespace palpate {
namespace {

// Removes all elements of this name, which do not nest in gnuplot's output.
std::string without_elements(std::string_view svg, const std::string& name) {
  std::string out;
  const std::string open = "<" + name + ">", close = "</" + name + ">";
  for (;;) {
    const std::size_t begin = svg.find(open);
    const std::size_t end = begin == std::string_view::npos ? begin : svg.find(close, begin);
    if (end == std::string_view::npos) return out += svg;
    out += svg.substr(0, begin);
    svg.remove_prefix(end + close.size());
  }
}

// Changes tags only: text content may look like an id.
std::string with_prefixed_ids(std::string_view svg, std::string_view prefix) {
  constexpr std::array<std::string_view, 5> kBeforeId = {" id=\"", " id='", "href=\"#", "href='#",
                                                         "url(#"};
  std::string out;
  bool in_tag = false;
  for (std::size_t i = 0; i < svg.size();) {
    if (svg[i] == '<') in_tag = true;
    if (svg[i] == '>') in_tag = false;
    std::string_view matched;
    for (const std::string_view before : kBeforeId) {
      if (in_tag && svg.substr(i).starts_with(before)) matched = before;
    }
    if (matched.empty()) {
      out += svg[i++];
      continue;
    }
    out += matched;
    out += prefix;
    i += matched.size();
  }
  return out;
}

// The value of an attribute of the first tag.
std::string_view attribute(std::string_view svg, const std::string& name) {
  const std::string before = " " + name + "=\"";
  const std::size_t begin = svg.find(before);
  if (begin == std::string_view::npos) return "";
  const std::size_t end = svg.find('"', begin + before.size());
  return svg.substr(begin + before.size(), end - begin - before.size());
}

}  // namespace

std::string html_escaped(std::string_view text) {
  std::string out;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string html_element(std::string_view tag, std::string_view content) {
  std::string out = "<";
  out.append(tag).append(">").append(content).append("</");
  return out.append(tag.substr(0, tag.find(' '))).append(">");
}

std::string html_page(std::string_view title, std::string_view style, std::string_view body) {
  // An empty icon, because browsers request one otherwise.
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n" +
      html_element("title", html_escaped(title)) + "\n<style>";
  out.append(style).append("</style>\n</head>\n<body>\n").append(body);
  return out + "</body>\n</html>\n";
}

std::string inline_svg(std::string_view svg, std::string_view id_prefix, std::string_view title) {
  const std::size_t root = svg.find("<svg");
  if (root == std::string_view::npos) return "";
  svg.remove_prefix(root);
  const std::size_t content = svg.find('>') + 1;
  const std::string name = html_escaped(title);
  std::string out =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "xmlns:xlink=\"http://www.w3.org/1999/xlink\" viewBox=\"";
  out += attribute(svg.substr(0, content), "viewBox");
  out += "\" role=\"img\" aria-label=\"" + name + "\">\n<title>" + name + "</title>\n";
  const std::string bare = without_elements(without_elements(svg.substr(content), "title"), "desc");
  out += with_prefixed_ids(bare, id_prefix);
  while (std::isspace(static_cast<unsigned char>(out.back()))) out.pop_back();
  return out + "\n";
}

}  // namespace palpate
