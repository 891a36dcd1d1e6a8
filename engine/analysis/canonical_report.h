#pragma once

// The report of a canonical run: one page for readers.

#include <string>
#include <vector>

#include "engine/trials/canonical/canonical_rows.h"

namespace palpate {

// What the report states about the run, besides its rows.
struct CanonicalFacts {
  std::string plan_name;
  std::uint64_t seed = 0;
  int participants = 0;
  std::string operator_name;
};

// An HTML5 document (UTF-8) that needs no other file, no network and no script: the figures over
// the angle, the means as tables, and how to read them. Appends to `warnings` if figures could not
// be drawn, once for each reason.
std::string canonical_report_html(const std::vector<CanonicalRow>& rows,
                                  const CanonicalFacts& facts, std::vector<std::string>& warnings);

}  // namespace palpate
