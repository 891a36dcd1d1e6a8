#pragma once

// The results as one page for readers: first the advice, then the knobs, last the facts about the
// build.

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/accuracy/accuracy_plots.h"
#include "engine/accuracy/advice.h"
#include "engine/accuracy/measurement.h"
#include "engine/accuracy/report_section.h"
#include "geometry/base/result.h"

namespace palpate {

struct KnobChapter {
  KnobResult result;
  Result<WorkPrecisionPanels> panels;  // if this is an error, the page shows its text
};

struct AccuracyReport {
  std::string title;
  std::string introduction;  // a paragraph of plain text; may be empty
  std::optional<Advice> advice;
  // Name and value of each fact: machine, compiler, flags, seed, repeats, date.
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<KnobChapter> chapters;
  std::vector<ReportSection> sections;
};

// An HTML5 document (UTF-8) that needs no other file, no network and no script: the advice, the
// sections, a summary of all knobs, then each knob with its diagrams, recommendation, failures and
// levels, and the facts. All texts except ReportSection::html are escaped.
std::string report_html(const AccuracyReport& report);

// The chapters of these results, with their diagrams drawn.
std::vector<KnobChapter> chapters_of(std::span<const KnobResult> results);

}  // namespace palpate
