#pragma once

// What a reader of a PowerStudy must know.

#include <string>
#include <vector>

#include "engine/analysis/power_study.h"

namespace palpate {

// Sentences: what is assumed, what is not normal, and what the numbers of people leave out. The
// first ones warn of what may be a mistake.
std::vector<std::string> power_notes(const PowerStudy& study);

}  // namespace palpate
