#pragma once

// What a reader of the report must know: the words, and what the statistics can state.

#include <string>

#include "engine/experiment/analysis.h"

namespace palpate {

// The levels of force and rotation, in one paragraph.
std::string levels_html();

// Why there are two analyses, what p values are about, what is our choice, and a list of words.
std::string explanations_html(const ExperimentAnalysis& analysis);

}  // namespace palpate
