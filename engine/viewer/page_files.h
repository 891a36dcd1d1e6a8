#pragma once

// The files of the page of `palpate view`, which the program embeds.

#include <span>
#include <string_view>

namespace palpate {

struct PageFile {
  std::string_view path;  // as in a request: "/", "/page.js"
  std::string_view content_type;
  std::string_view bytes;
  std::string_view gzip;  // the same, compressed
};

// The embedded files; none if the program was built without PALPATE_VIEWER.
std::span<const PageFile> embedded_page_files() noexcept;

// The licences of what the files contain; empty if there are no files.
std::string_view page_licences() noexcept;

}  // namespace palpate
