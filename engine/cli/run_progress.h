#pragma once

// The progress of runs that are dealt to shards and jobs.

#include <functional>
#include <string>

#include "engine/cli/command_output.h"
#include "engine/experiment/dealt_run.h"

namespace palpate {

// "12 s", "3 min 20 s", "2 h 5 min"
std::string duration_text(double seconds);

// A function that shows the progress in the bar, with the time left once it is known. The bar must
// outlive the function.
std::function<void(const RunProgress&)> shown_in(ProgressBar& bar, const std::string& label);

}  // namespace palpate
