#pragma once

// What was measured of knobs, as one page for people.

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/accuracy/accuracy_plots.h"
#include "engine/accuracy/measurement.h"
#include "geometry/base/result.h"

namespace palpate {

struct KnobChapter {
  KnobResult result;
  Result<WorkPrecisionPanels> panels;  // of an error the page tells in their place
};

// A section of the caller's own, before the knobs.
struct ReportSection {
  std::string title;
  std::string html;  // put in as it is: html_escaped() and inline_svg() are in html.h
};

struct AccuracyReport {
  std::string title;
  std::string introduction;  // a paragraph of plain text; may be empty
  // Name and value: machine, compiler, flags, commit, seed, repeats, date.
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<KnobChapter> chapters;
  std::vector<ReportSection> sections;
};

// An HTML5 document (UTF-8) that needs no other file, no network and no script: the facts, a
// summary of all knobs, then for each its diagrams, its levels, what failed and why, and what is
// recommended. All texts but ReportSection::html are escaped.
std::string report_html(const AccuracyReport& report);

// The chapters of these results: draws their diagrams.
std::vector<KnobChapter> chapters_of(std::span<const KnobResult> results);

}  // namespace palpate
