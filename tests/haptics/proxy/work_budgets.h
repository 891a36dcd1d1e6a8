#pragma once

// Budgets of work for tests: with none, the solver is judged alone; with a small one most ticks run
// out.

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

// Of four scenes one has so little that most of its ticks run out, one what the preset gives, and
// two all they want.
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
