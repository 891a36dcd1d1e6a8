#pragma once

#include <string>

namespace palpate {

// A section that the caller adds to the report, before the knobs.
struct ReportSection {
  std::string title;
  std::string html;  // inserted unchanged: html_escaped() and inline_svg() are in html.h
};

}  // namespace palpate
