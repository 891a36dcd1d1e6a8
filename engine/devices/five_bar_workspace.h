#pragma once

// The part of a pantograph's plane in which it gets its full force.

#include <optional>

#include "engine/devices/five_bar.h"

namespace palpate {

// A rectangle along the axes, in the frame of FiveBar.
struct PlaneBox {
  Vec2 low_m = Vec2::Zero();
  Vec2 high_m = Vec2::Zero();
};

// The largest rectangle in front of the motors, symmetric to the middle of the base, in which the
// condition is at most kFullForceCondition. It is searched on a grid of kGridSteps points along the
// reach of the links. No value if the links have no such rectangle.
inline constexpr int kGridSteps = 100;
std::optional<PlaneBox> full_force_workspace(const FiveBar& bar);

}  // namespace palpate
