#pragma once

#include <string>

namespace palpate {

// A section that the caller adds to the report. It precedes the knobs.
struct ReportSection {
  std::string title;
  std::string html;  // inserted unchanged; html.h has html_escaped() and inline_svg()
};

}  // namespace palpate
