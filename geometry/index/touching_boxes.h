#pragma once

#include <span>
#include <vector>

#include "geometry/base/box.h"

namespace palpate {

// For each box whether it is one of two that meet, one of which at least is marked. All such are
// found; where boxes crowd, some are named that are not. O(n log n) where few crowd. Deterministic.
std::vector<bool> may_touch_marked(std::span<const Box> boxes, const std::vector<bool>& marked);

}  // namespace palpate
