#pragma once

// Made-up knobs with all that a report must cope with, measured as real ones are: in no time.

#include <vector>

#include "engine/accuracy/measurement.h"

namespace palpate::test {

// Order 2 down to a floor; the default takes longer than necessary.
KnobResult sample_mesh();
// Three methods, of orders 1, 4 and at the floor; coarse levels are unstable; a preset fails.
KnobResult sample_integrator();
// A negative order, and errors of exactly 0 without a floor.
KnobResult sample_iterations();
// Levels that are given, six methods; one level is 0.
KnobResult sample_estimators();
// No error at any level, and times that hardly differ.
KnobResult sample_without_error();
// Two levels with long names, one of which fails always; no order.
KnobResult sample_arithmetic();
// Texts that are no names: markup, quotes, commas, line breaks, commands, bytes that are no UTF-8.
KnobResult sample_hostile(const std::string& command);

std::vector<KnobResult> all_samples();

}  // namespace palpate::test
