#pragma once

#include <string>

namespace palpate {

// A section of the report that the caller provides. It stands before the knobs.
struct ReportSection {
  std::string title;
  std::string html;  // inserted unchanged; html.h has html_escaped() and inline_svg()
};

}  // namespace palpate
