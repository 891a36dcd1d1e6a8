#pragma once

// The part of the report about one kind of operator: one following, or people.

#include <string>
#include <vector>

#include "engine/analysis/analysis.h"

namespace palpate {

// Figures, means, effects, comparisons and missing trials. leads: the operator is the first in the
// report; the tables of the others are folded away. Appends to `warnings` a sentence if figures
// could not be drawn; the report shows the reason in their place.
std::string operator_html(const OperatorAnalysis& analysis, bool leads,
                          std::vector<std::string>& warnings);

}  // namespace palpate
