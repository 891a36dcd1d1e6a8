#pragma once

// A hand that presses one wall after another, and how deep a strategy lets it in.

#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "haptics/strategies/strategy.h"

namespace palpate::bench {

// Means over the presses of one loop.
struct PressMeans {
  Strategy strategy;
  double pause_s = 0.0;
  double depth_m = 0.0;           // at which the hand rests
  double turning_energy_J = 0.0;  // StrategyMeasures, of one press
};

// A spring of 400 N/m aims 10 mm deep into a wall of 1000 N/m, for 3 s: longer than A4 turns from
// any angle. It rests at its balance in each tick and moves along the normal of the wall alone.
// Each press begins at another contact angle, 5 to 85 deg; all are in one loop, in ticks of 1 ms,
// on a device with two sensors and a motor along A1. Between two presses, the hand is off the walls
// for pause_s, [0.2, 1000]; a contact that begins later than TurnBudget::kRest_s has its own
// budget. Deterministic; thread-safe.
Result<PressMeans> press_walls(const Strategy& strategy, double pause_s);

// Two pauses, one shorter and one longer than TurnBudget::kRest_s, of each strategy. An Error names
// the strategy that parse_strategy() refuses.
Result<std::vector<PressMeans>> press_walls(const std::vector<std::string>& strategies);

// The table in CSV: strategy, pause_s, depth_m, turning_energy_J; nine significant digits.
std::string wall_presses_csv(const std::vector<PressMeans>& presses);

}  // namespace palpate::bench
