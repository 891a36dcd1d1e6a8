// The work budget that is measured at the start of a run.

#include "engine/session/work_price.h"

#include <gtest/gtest.h>

#include "engine/session/run_setup.h"
#include "haptics/proxy/accuracy.h"

namespace palpate {
namespace {

TEST(WorkPrice, TheBudgetIsHalfOfATickForTheProxyAndTheEffects) {
  for (const double dt_s : {1e-4, 1e-3, 1e-2, 1.0}) {
    for (const double unit_ns : {0.5, 7.3, 18.0, 40.0}) {
      const MeasuredBudget budget = work_budget_for(dt_s, unit_ns);
      Accuracy accuracy;
      accuracy.work_budget = budget.units;
      const double all_ns = unit_ns * static_cast<double>(budget.units + accuracy.effects_budget());
      if (budget.units > 100) {
        EXPECT_LE(all_ns, 0.5e9 * dt_s + unit_ns) << dt_s << " s, " << unit_ns << " ns";
        EXPECT_GE(all_ns, 0.5e9 * dt_s * 0.9) << dt_s << " s, " << unit_ns << " ns: two digits";
      }
      EXPECT_GE(budget.units, 100);
    }
  }
}

TEST(WorkPrice, IsMeasuredOnceInAProcess) {
  const double price_ns = unit_price_ns();
  EXPECT_GT(price_ns, 0.0);
  EXPECT_EQ(unit_price_ns(), price_ns);
  RunSettings settings;
  settings.measures_work_budget = true;
  const auto setup = make_setup(settings);
  ASSERT_TRUE(setup);
  ASSERT_TRUE(setup->measured_budget);
  EXPECT_EQ(setup->measured_budget->unit_ns, price_ns);
  EXPECT_EQ(setup->measured_budget->units, work_budget_for(setup->dt_s, price_ns).units);
  EXPECT_EQ(setup->haptics.god_object.accuracy.work_budget, setup->measured_budget->units);
  settings.work_budget = 1000;
  const auto both = make_setup(settings);
  ASSERT_FALSE(both);
  EXPECT_EQ(both.error().element, "work_budget");
}

}  // namespace
}  // namespace palpate
