#pragma once

// Lines that pass an edge, from easy to extremely hard cases, and the exact side on which they
// pass.

#include <cstddef>
#include <vector>

#include "benchmarks/side_tests.h"

namespace palpate::bench {

// Lengths are typical for a proxy: edges of 0.3 mm at 0.1 m from the origin, and steps of a
// millimetre. Each class has a fixed seed.

// Random lines, not aimed at the edge.
std::vector<SideInput> easy_side_inputs(std::size_t count);

// Aimed at a point of the edge; rounding moves the line off the point. The filter is undecided, but
// a moderate number of bits beyond those of a double decides.
std::vector<SideInput> near_side_inputs(std::size_t count);

// Through a point of the edge exactly.
std::vector<SideInput> exact_side_inputs(std::size_t count);

// Past the edge by less than 113 bits can represent: the volume is the least that 50-bit
// coordinates can span. Unrealistic inputs, which distinguish an exact method from a good
// approximation.
std::vector<SideInput> hidden_side_inputs(std::size_t count);

// The side, computed in rational arithmetic.
int true_side(const SideInput& input);

}  // namespace palpate::bench
