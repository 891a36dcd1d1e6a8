#pragma once

// Artificial knobs with all cases that a report must handle. They are measured like real knobs, but
// their runs take no time.

#include <vector>

#include "engine/accuracy/measurement.h"

namespace palpate::test {

// Order 2 down to a floor. The default takes longer than necessary.
KnobResult sample_mesh();
// Three methods: one of order 1, one of order 4 and one at the floor. Coarse levels are unstable,
// and a preset fails.
KnobResult sample_integrator();
// A negative order, and errors of exactly 0 without a floor.
KnobResult sample_iterations();
// Six methods at levels that the user cannot choose. One level has the value 0.
KnobResult sample_estimators();
// No error at any level, and times that hardly differ.
KnobResult sample_without_error();
// A method with a long name and three levels, one of which always fails. It has no order.
KnobResult sample_arithmetic();
// Texts with markup, quotation marks, commas, line breaks, `command` (a shell command), and bytes
// that are not UTF-8.
KnobResult sample_hostile(const std::string& command);

std::vector<KnobResult> all_samples();

}  // namespace palpate::test
