#pragma once

// The differences between the variants of a plan, in the report of an experiment.

#include <string>

#include "engine/analysis/analysis.h"

namespace palpate {

// A section with one table; empty if the file has one variant.
std::string differences_html(const ExperimentAnalysis& analysis);

}  // namespace palpate
