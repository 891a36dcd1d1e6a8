#pragma once

// The files of the pages, embedded in the program.

#include <optional>
#include <string_view>

namespace palpate {

// Not empty.
struct PageFiles {
  std::string_view html;
  std::string_view script;
  std::string_view style;
  std::string_view icon;  // an SVG
};

// No value: the program was built without the page (PALPATE_VIEWER).
std::optional<PageFiles> embedded_page() noexcept;

// The page of a participant of an experiment (page/live.ts), under the same condition. It asks for
// its script, style and icon under the same names as the page of `view`.
std::optional<PageFiles> embedded_live_page() noexcept;

// The licences of what is embedded in the pages; empty without the page.
std::string_view embedded_licences() noexcept;

}  // namespace palpate
