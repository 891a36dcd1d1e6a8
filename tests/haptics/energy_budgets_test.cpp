// Budgets: what a source may give, judged by sums over all intervals.

#include "haptics/energy_budgets.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kBudgetStep_s = 1e-3;

GivenByDesign::Work work_of(EnergySource source, double work_J) {
  GivenByDesign::Work work;
  work.even_J = work_J;
  work.in_contact = true;
  work.step_s = kBudgetStep_s;
  if (source == EnergySource::kMotors) work.motors_J = work_J;
  if (source == EnergySource::kNodes) work.nodes_J = work_J;
  const auto n = static_cast<std::size_t>(source);
  if (n >= kFirstGivingEffect && source != EnergySource::kOther) {
    work.effects_J[n - kFirstGivingEffect] = work_J;
  }
  return work;
}

// Over any interval, what was given and not told is at most tank + power times time: the oracle
// looks at all intervals that end in a tick.
TEST(GivenByDesign, TellsAllThatExceedsABudget) {
  const EnergyBudgets budgets;
  for (std::size_t n = 0; n + 1 < kEnergySourceCount; ++n) {
    Random random(7 + n);
    const EnergyBudget budget = budgets.of[n];
    GivenByDesign design(budgets);
    double allowed_J = budget.tank_J, worst_J = 0.0, told_J = 0.0;
    for (int k = 0; k < 20'000; ++k) {
      const double work_J = (k / 4000 % 2 == 0 ? 5.0 : 0.5) * budget.power_W * kBudgetStep_s *
                            random.uniform(-1.0, 1.6);
      const double beyond_J = design.add(work_of(static_cast<EnergySource>(n), work_J));
      ASSERT_GE(beyond_J, 0.0);
      told_J += beyond_J;
      allowed_J =
          std::min(budget.tank_J, allowed_J + budget.power_W * kBudgetStep_s) - work_J + beyond_J;
      worst_J = std::min(worst_J, allowed_J);
    }
    EXPECT_GE(worst_J, -budget.power_W * kBudgetStep_s - 1e-12) << kEnergySourceNames[n];
    EXPECT_GT(told_J, 0.0) << kEnergySourceNames[n] << ": the random work exceeds the budget";
  }
}

TEST(GivenByDesign, ASpringMayGiveBackWhatTheHandHasPutIn) {
  GivenByDesign design{EnergyBudgets{}};
  const auto add = [&](double work_J) { return design.add(work_of(EnergySource::kOther, work_J)); };
  for (int n = 0; n < 100; ++n) EXPECT_EQ(add(-1e-3), 0.0);
  for (int n = 0; n < 100; ++n) EXPECT_EQ(add(1e-3), 0.0);
  double beyond_J = 0.0;
  for (int n = 0; n < 100; ++n) beyond_J += add(1e-3);
  const EnergyBudget other = EnergyBudgets{}.of[static_cast<std::size_t>(EnergySource::kOther)];
  EXPECT_NEAR(beyond_J, 0.1 - other.tank_J - 100 * kBudgetStep_s * other.power_W, 1e-3);
}

}  // namespace
}  // namespace palpate
