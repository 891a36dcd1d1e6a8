#pragma once

// Work budgets for tests. Without a limit, a test judges only the solver; with a small budget, most
// ticks exhaust it.

#include <cmath>
#include <cstdint>
#include <limits>

#include "haptics/proxy/accuracy.h"

namespace palpate::test {

inline constexpr WorkUnits kNoBudget = std::numeric_limits<WorkUnits>::max() / 64;

inline Accuracy with_budget(Accuracy accuracy, WorkUnits budget) {
  accuracy.work_budget = budget;
  return accuracy;
}

// The accuracy for a scene. One of four scenes has a budget so small that most ticks exhaust it,
// one has the budget of its preset, and two have no limit.
inline Accuracy with_some_budget(const Accuracy& accuracy, std::uint64_t scene) {
  switch (scene % 4) {
    case 0:
      return with_budget(
          accuracy, std::lround(30.0 * std::pow(10.0, 0.5 * static_cast<double>(scene / 4 % 5))));
    case 1:
      return accuracy;
    default:
      return with_budget(accuracy, kNoBudget);
  }
}

}  // namespace palpate::test
