// The bytes of the pages, as the build has made them.

#include <cstddef>

#include "engine/viewer/page_files.h"

#ifdef PALPATE_PAGE_FOLDER

// .incbin copies a file at once; a literal of this size would take seconds to compile.
#define PALPATE_EMBED(name, file)                                   \
  asm(".section .rodata\n"                                          \
      ".global palpate_" #name "\n.global palpate_" #name           \
      "_end\n"                                                      \
      "palpate_" #name ":\n.incbin \"" PALPATE_PAGE_FOLDER "/" file \
      "\"\n"                                                        \
      "palpate_" #name "_end:\n.byte 0\n.previous\n");              \
  extern "C" const char palpate_##name[];                           \
  extern "C" const char palpate_##name##_end[];

PALPATE_EMBED(page_html, "index.html")
PALPATE_EMBED(page_script, "page.js")
PALPATE_EMBED(page_style, "page.css")
PALPATE_EMBED(page_icon, "icon.svg")
PALPATE_EMBED(live_html, "live.html")
PALPATE_EMBED(live_script, "live.js")
PALPATE_EMBED(live_style, "live.css")
PALPATE_EMBED(page_licences, "licences.txt")

namespace palpate {
namespace {

std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::optional<PageFiles> embedded_page() noexcept {
  return PageFiles{between(palpate_page_html, palpate_page_html_end),
                   between(palpate_page_script, palpate_page_script_end),
                   between(palpate_page_style, palpate_page_style_end),
                   between(palpate_page_icon, palpate_page_icon_end)};
}

std::optional<PageFiles> embedded_live_page() noexcept {
  return PageFiles{between(palpate_live_html, palpate_live_html_end),
                   between(palpate_live_script, palpate_live_script_end),
                   between(palpate_live_style, palpate_live_style_end),
                   between(palpate_page_icon, palpate_page_icon_end)};
}

std::string_view embedded_licences() noexcept {
  return between(palpate_page_licences, palpate_page_licences_end);
}

}  // namespace palpate

#else

namespace palpate {

std::optional<PageFiles> embedded_page() noexcept {
  return std::nullopt;
}

std::optional<PageFiles> embedded_live_page() noexcept {
  return std::nullopt;
}

std::string_view embedded_licences() noexcept {
  return {};
}

}  // namespace palpate

#endif
