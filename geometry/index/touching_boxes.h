#pragma once

#include <span>
#include <vector>

#include "geometry/base/box.h"

namespace palpate {

// Returns for each box whether it may belong to a pair of boxes that meet, at least one of which is
// marked. The function finds every box of such a pair; where many boxes overlap, it may also report
// other boxes. O(n log n) if few boxes overlap. Deterministic.
std::vector<bool> may_touch_marked(std::span<const Box> boxes, const std::vector<bool>& marked);

}  // namespace palpate
