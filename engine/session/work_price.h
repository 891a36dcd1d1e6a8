#pragma once

// The time that a unit of work takes on this machine, and the work budget that follows from it.

#include <cstdint>

#include "haptics/proxy/work.h"

namespace palpate {

// A work budget for one rate.
struct MeasuredBudget {
  WorkUnits units = 0;   // of the proxy; effects have a budget of their own beside it
  double unit_ns = 0.0;  // unit_price_ns()
};

// The part of a tick's period that the proxy and the effects may use together: the rest is for the
// device, the system and the forces.
inline constexpr double kWorkPerPeriod = 0.5;

// The time of a unit of the dearest of some kinds of work (CountingRule::kSecond), ns. The first
// call measures it for some tens of milliseconds; later calls return the same number, so that one
// process has one number. Not for the haptic thread: allocates. Thread-safe.
double unit_price_ns();

// The budget with which the proxy and the effects of a tick take at most kWorkPerPeriod of dt_s, to
// two digits, rounded down; at least 100 units. Not for the haptic thread.
MeasuredBudget measured_work_budget(double dt_s);
// The same for a given price.
MeasuredBudget work_budget_for(double dt_s, double unit_ns);

}  // namespace palpate
