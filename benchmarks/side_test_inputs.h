#pragma once

// Lines that pass an edge in ways from easy to impossible, and the side on which they really do.

#include <cstddef>
#include <vector>

#include "benchmarks/side_tests.h"

namespace palpate::bench {

// Every class is of the size of what a proxy meets: edges of 0.3 mm, 0.1 m from the origin, and
// steps of a millimetre. A fixed seed each.

// In every way, none aimed at the edge.
std::vector<SideInput> easy_side_inputs(std::size_t count);

// Aimed at a point of the edge, past which rounding takes them: the filter fails, but some
// half of the bits beyond those of double decide.
std::vector<SideInput> near_side_inputs(std::size_t count);

// Through a point of the edge exactly.
std::vector<SideInput> exact_side_inputs(std::size_t count);

// Past the edge by less than 113 bits can hold: the volume is the least that 50-bit coordinates can
// span. Not of this world, but what tells an exact answer from a good one.
std::vector<SideInput> hidden_side_inputs(std::size_t count);

// The side in rational arithmetic.
int true_side(const SideInput& input);

}  // namespace palpate::bench
