#pragma once

// Periods of a servo with late, early and missed ticks.

#include "geometry/base/random.h"

namespace palpate {

// Each period is uniform within +- half_width of the nominal period, and each tick is left out with
// the probability left_out, so that its period is added to the next one.
struct TickPeriods {
  double nominal_s = 1e-3;  // > 0
  double half_width = 0.0;  // part of the nominal period, [0, 1)
  double left_out = 0.0;    // [0, 1)

  double draw_s(SeededRandom& random) const;

  // E[T], and E[T^2] / E[T]: the mean age of a held force is that of even periods of this length,
  // because long ticks hold a force for longer. With a geometric number of periods per tick,
  //   E[T] = T0 / (1 - q)   and   E[T^2] / E[T] = T0 ((1 + q) / (1 - q) + w^2 / 3).
  double mean_s() const;
  double effective_s() const;
};

}  // namespace palpate
