#include "engine/accuracy/tick_periods.h"

namespace palpate {

double TickPeriods::draw_s(SeededRandom& random) const {
  double period_s = 0.0;
  do {
    period_s += nominal_s * random.uniform(1.0 - half_width, 1.0 + half_width);
  } while (random.uniform(0.0, 1.0) < left_out);
  return period_s;
}

double TickPeriods::mean_s() const {
  return nominal_s / (1.0 - left_out);
}

double TickPeriods::effective_s() const {
  return nominal_s * ((1.0 + left_out) / (1.0 - left_out) + half_width * half_width / 3.0);
}

}  // namespace palpate
