#pragma once

// Lines that pass an edge, in easy to extremely hard cases, and the exact side on which they pass.

#include <cstddef>
#include <vector>

#include "benchmarks/side_tests.h"

namespace palpate::bench {

// Lengths are typical for a proxy: edges of 0.3 mm at 0.1 m from the origin, and steps of a
// millimetre. Each class has a fixed seed.

// Random lines that are not aimed at the edge.
std::vector<SideInput> easy_side_inputs(std::size_t count);

// Lines aimed at a point of the edge; rounding moves each line off its point. The filter does not
// decide these inputs, but a moderate number of bits beyond those of a double suffices.
std::vector<SideInput> near_side_inputs(std::size_t count);

// Lines that pass exactly through a point of the edge.
std::vector<SideInput> exact_side_inputs(std::size_t count);

// Lines that pass the edge so closely that 113 bits do not decide the side: the line and the edge
// span the smallest volume that vectors with 50-bit coordinates can span. These inputs are
// unrealistic; they distinguish an exact method from a good approximation.
std::vector<SideInput> hidden_side_inputs(std::size_t count);

// The side, computed in rational arithmetic.
int true_side(const SideInput& input);

}  // namespace palpate::bench
