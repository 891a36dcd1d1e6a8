#pragma once

// Explanations for a reader of the report: the terms, and what the statistics can state.

#include <string>

#include "engine/analysis/analysis.h"

namespace palpate {

// The levels of force and rotation, in one paragraph.
std::string levels_html();

// Explains why there are two analyses, what the p values mean and which choices are ours, and lists
// the terms.
std::string explanations_html(const ExperimentAnalysis& analysis);

}  // namespace palpate
