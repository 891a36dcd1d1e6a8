// Whatever a hand does at a wall or in a groove, with whatever stiffness, delay and rate: the tip
// comes to rest, or the engine has said why not, and it never gives back more than it may.

#include "engine/simulation/calm_chart.h"

#include <array>
#include <cstdio>
#include <iostream>
#include <string>

#include <gtest/gtest.h>

#include "engine/devices/stability_limits.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

std::string text_of(const ChartCase& c, const ChartResult& r) {
  std::array<char, 400> text{};
  std::snprintf(
      text.data(), text.size(),
      "%s, %s tip, %s; %.0f N/m (stable %.0f, calm %.0f), %.2f ms, %.0f Hz: %s; rest after "
      "%.2f s, amplitude %.3f mm, returned %.2f mJ, given %.2f mJ, %.2f m/s, trip %s, rules %x",
      name_of(c.shape).data(), name_of(c.grip).data(), name_of(c.contact).data(),
      c.stiffness_N_per_m, r.zones.stable_N_per_m, r.zones.calm_N_per_m, 1e3 * c.delay_s, c.rate_Hz,
      kChartOutcomeNames[static_cast<std::size_t>(r.outcome)].data(), r.rest_time_s,
      1e3 * r.amplitude_m, 1e3 * r.returned_J, 1e3 * r.given_J, r.largest_speed_m_per_s,
      kTripReasonNames[static_cast<std::size_t>(r.trip.reason)].data(), r.rules);
  return text.data();
}

void expect_promises(std::uint64_t seed, std::uint64_t cases, double encoder_quantum_m = 0.0) {
  std::array<int, std::size(kChartOutcomeNames)> outcomes{};
  int touched = 0;
  for (std::uint64_t number = 0; number < cases; ++number) {
    ChartCase chart_case = ChartCase::random(seed, number);
    chart_case.encoder_quantum_m = encoder_quantum_m;
    const ChartResult result = test::made(run_chart_case(chart_case));
    ++outcomes[static_cast<std::size_t>(result.outcome)];
    touched += result.has_touched;
    EXPECT_TRUE(result.keeps_promises())
        << "case " << number << ": " << text_of(chart_case, result);
  }
  for (std::size_t n = 0; n < outcomes.size(); ++n) {
    std::cout << kChartOutcomeNames[n] << " " << outcomes[n] << "\n";
  }
  const int run =
      static_cast<int>(cases) - outcomes[static_cast<std::size_t>(ChartOutcome::kRefused)];
  EXPECT_GT(run, static_cast<int>(cases) / 4);
  EXPECT_GT(touched, run * 9 / 10);
  EXPECT_GT(outcomes[static_cast<std::size_t>(ChartOutcome::kStable)], 0);
  EXPECT_GT(outcomes[static_cast<std::size_t>(ChartOutcome::kControlled)], 0);
}

// Half of the cases are always the same; PALPATE_SEED changes the other half.
TEST(CalmChart, TheTipComesToRestAndGetsNoMoreThanTheBudgetOrTheReasonIsGiven) {
  expect_promises(49, 100);
}

TEST(CalmChart, KeepsItsPromisesInOtherCases) {
  const Random random(50);
  std::cout << "seed " << random.seed() << "\n";
  expect_promises(random.seed(), 100);
}

// Encoders of 20 um, and of 45 um as those of a pantograph. Without friction, what is left is below
// two steps, the encoder's own uncertainty.
TEST(CalmChart, KeepsItsPromisesOnEncodersWithSteps) {
  const Random random(52);
  std::cout << "seed " << random.seed() << "\n";
  expect_promises(random.seed(), 60, 20e-6);
  expect_promises(random.seed() + 1, 100, 45e-6);
}

// A device that samples in every second to fourth tick only.
TEST(CalmChart, KeepsItsPromisesWhereSamplesAreRarerThanTicks) {
  const Random random(53);
  std::cout << "seed " << random.seed() << "\n";
  int controlled = 0;
  for (std::uint64_t number = 0; number < 100; ++number) {
    ChartCase chart_case = ChartCase::random(random.seed(), number);
    chart_case.ticks_per_sample = 2 + static_cast<int>(number % 3);
    const ChartResult result = test::made(run_chart_case(chart_case));
    SCOPED_TRACE(text_of(chart_case, result));
    EXPECT_TRUE(result.keeps_promises()) << chart_case.ticks_per_sample << " ticks a sample";
    controlled += result.outcome == ChartOutcome::kControlled;
  }
  EXPECT_GT(controlled, 10);
}

// The judge can say no: without the controller, a tip that a grip holds at the wall swings wherever
// the limit of stability with this hand is clearly exceeded, and rests wherever it is not reached.
TEST(CalmChart, WithoutTheControllerTheTipSwingsWhereTheLoopIsUnstable) {
  int swung = 0;
  int rested = 0;
  for (std::uint64_t number = 0; number < 300; ++number) {
    ChartCase chart_case = ChartCase::random(51, number);
    chart_case.contact = ChartContact::kPressed;
    if (chart_case.grip == ChartGrip::kBare) continue;
    const TipSettings tip;
    const DeviceMechanics mechanics{tip.mass_kg, tip.damping_Ns_per_m, 0.0, 0.0,
                                    hand_of(chart_case.grip)};
    const ServoTiming timing{.period_s = 1.0 / chart_case.rate_Hz, .delay_s = chart_case.delay_s};
    const double limit = test::made(stability_limits(mechanics, 0.0, timing)).stable_N_per_m;
    const double share = chart_case.stiffness_N_per_m / limit;
    // A light grip damps little: half of the limit, and the decay of a third of a second.
    if (share > 0.5 && share < 1.5) continue;
    const ChartResult result =
        test::made(run_chart_case(chart_case, {.runs_refused = true, .is_governed = false}));
    SCOPED_TRACE(text_of(chart_case, result));
    EXPECT_EQ(result.trip.reason, TripReason::kNone);
    if (share > 1.0) {
      EXPECT_FALSE(result.keeps_promises()) << share;
      ++swung;
    } else {
      EXPECT_TRUE(result.keeps_promises()) << share;
      ++rested;
    }
  }
  EXPECT_GT(swung, 50);
  EXPECT_GT(rested, 30);
}

}  // namespace
}  // namespace palpate
