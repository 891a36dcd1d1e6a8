#pragma once

// Periods of a servo with late, early and missed ticks.

#include "geometry/base/random.h"

namespace palpate {

// Each period is drawn uniformly within +- half_width of the nominal period. Each tick is left out
// with the probability left_out; its period is then added to the next one.
struct TickPeriods {
  double nominal_s = 1e-3;  // > 0
  double half_width = 0.0;  // share of the nominal period, [0, 1)
  double left_out = 0.0;    // probability, [0, 1)

  double draw_s(SeededRandom& random) const;

  // The mean period E[T], and the effective period E[T^2] / E[T]. The mean age of a held force is
  // that of equal periods of the effective length, because long ticks hold a force for longer. With
  // T0 = nominal_s, q = left_out, w = half_width and a geometric number of periods per tick,
  //   E[T] = T0 / (1 - q)   and   E[T^2] / E[T] = T0 ((1 + q) / (1 - q) + w^2 / 3).
  double mean_s() const;
  double effective_s() const;
};

}  // namespace palpate
