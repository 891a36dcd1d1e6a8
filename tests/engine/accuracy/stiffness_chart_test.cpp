// The chart of the stiffness: its limits decide between loops that decay and loops that grow, its
// picture shows each number in its place.

#include "engine/accuracy/stiffness_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/stiffness_picture.h"
#include "engine/simulation/port_loop.h"
#include "geometry/base/random.h"
#include "tests/helpers/made.h"

namespace palpate {
namespace {

DeviceDescription charted_device(double mass_kg, double damping_Ns_per_m, DelayInterval delay) {
  DeviceDescription device;
  device.mass_kg = mass_kg;
  device.damping_Ns_per_m = damping_Ns_per_m;
  device.delay = delay;
  return device;
}

// The eigenvalues of the loop with this hand, a part below and above its limit.
void expect_divides(double limit_N_per_m, const AssumedMechanics& mechanics,
                    std::optional<HandImpedance> hand, double delay_s, double rate_Hz) {
  constexpr double kPart = 1e-3;
  DeviceMechanics device{mechanics.mass_kg, mechanics.damping_Ns_per_m};
  device.hand = hand;
  const ServoTiming timing{1.0 / rate_Hz, delay_s};
  EXPECT_LT(spectral_radius(device, {(1.0 - kPart) * limit_N_per_m, 0.0}, timing), 1.0) << delay_s;
  EXPECT_GT(spectral_radius(device, {(1.0 + kPart) * limit_N_per_m, 0.0}, timing), 1.0) << delay_s;
}

TEST(StiffnessChart, ItsLimitsDivideDecayFromGrowthForEachGrip) {
  const std::uint64_t seed = 49;
  std::printf("seed %d\n", static_cast<int>(seed));
  SeededRandom random(seed);
  for (int n = 0; n < 3; ++n) {
    const double mass_kg = random.uniform(0.05, 0.5);
    const double damping = random.uniform(0.2, 2.0);
    const StiffnessChart chart =
        test::made(stiffness_chart(charted_device(mass_kg, damping, {}), {500.0, 0.0}, 1000.0));
    for (const ChartedRate& rate : chart.rates) {
      const ChartedLimits& at = rate.limits[random.index(rate.limits.size())];
      const AssumedMechanics& mechanics = at.zones.mechanics;
      expect_divides(at.zones.stable_N_per_m, mechanics, {}, at.delay_s, rate.rate_Hz);
      expect_divides(at.light_N_per_m, mechanics, kLightGrip, at.delay_s, rate.rate_Hz);
      expect_divides(at.firm_N_per_m, mechanics, kFirmGrip, at.delay_s, rate.rate_Hz);
    }
  }
}

// b / (T / 2 + D) at delays of whole periods.
TEST(StiffnessChart, BeginsWithoutDelayAndEndsAtItsLongest) {
  const StiffnessChart chart =
      test::made(stiffness_chart(charted_device(0.1, 0.5, {}), {500.0, 0.0}, 1000.0));
  ASSERT_EQ(chart.rates.size(), 4u);
  for (const ChartedRate& rate : chart.rates) {
    ASSERT_EQ(rate.limits.size(), std::size_t{StiffnessChartRange::kDelays});
    EXPECT_EQ(rate.limits.front().delay_s, 0.0);
    EXPECT_EQ(rate.limits.back().delay_s, StiffnessChartRange::kLongestDelay_s);
    EXPECT_TRUE(std::is_sorted(rate.limits.begin(), rate.limits.end(), [](auto& a, auto& b) {
      return a.zones.stable_N_per_m > b.zones.stable_N_per_m;
    }));
  }
  const ChartedRate& at_1_kHz = chart.rates[1];
  // A delay of a nanosecond stands for none.
  EXPECT_NEAR(at_1_kHz.limits.front().zones.passive_N_per_m, 1000.0, 1000.0 * 1e-5);
  EXPECT_NEAR(at_1_kHz.limits.back().zones.passive_N_per_m, 0.5 / 5.5e-3, 1e-9 * 0.5 / 5.5e-3);
}

TEST(StiffnessChart, JudgesItsOwnStiffnessAtTheLongestDelayOfTheDevice) {
  const auto own = [](double stiffness, DelayInterval delay) {
    return test::made(stiffness_chart(charted_device(0.1, 0.5, delay), {stiffness, 0.0}, 1000.0));
  };
  EXPECT_EQ(own(300.0, {0.5e-3, 1e-3}).own_zone(), StiffnessZone::kStable);
  EXPECT_EQ(own(300.0, {0.5e-3, 3e-3}).own_zone(), StiffnessZone::kControlled);
  EXPECT_EQ(own(3000.0, {0.5e-3, 3e-3}).own_zone(), StiffnessZone::kRefused);
  // Unknown: that of its class, which the text names.
  const StiffnessChart unknown = own(3000.0, {});
  EXPECT_EQ(unknown.own_zone(), StiffnessZone::kRefused);
  EXPECT_EQ(assumed_text(unknown.own.mechanics),
            "mass 0.1 kg, damping 0.5 N s/m, delay at most 3.1 ms (assumed, of a bare tip)");
  EXPECT_EQ(zone_text(3000.0, unknown.own),
            "K 3 kN/m is refused; stable below 139 N/m, calm by the controller up to 1089 N/m");
}

TEST(StiffnessChart, ItsRateTakesThePlaceOfTheNearestOne) {
  const auto rates = [](double rate_Hz) {
    const StiffnessChart chart =
        test::made(stiffness_chart(charted_device(0.1, 0.5, {1e-3, 1e-3}), {500.0, 0.0}, rate_Hz));
    std::vector<double> all;
    for (const ChartedRate& rate : chart.rates) all.push_back(rate.rate_Hz);
    return all;
  };
  EXPECT_EQ(rates(1000.0), (std::vector<double>{250.0, 1000.0, 4000.0, 10'000.0}));
  EXPECT_EQ(rates(2500.0), (std::vector<double>{250.0, 1000.0, 2500.0, 10'000.0}));
  EXPECT_EQ(rates(300.0), (std::vector<double>{300.0, 1000.0, 4000.0, 10'000.0}));
}

std::size_t count_of(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    ++count;
  }
  return count;
}

// The places of the circles of a document, "x y" each.
std::vector<std::string> circles(const std::string& svg) {
  std::vector<std::string> places;
  for (std::size_t at = svg.find("<circle "); at != std::string::npos;
       at = svg.find("<circle ", at + 1)) {
    double x = 0.0, y = 0.0;
    EXPECT_EQ(std::sscanf(svg.c_str() + at, "<circle cx=\"%lf\" cy=\"%lf\"", &x, &y), 2);
    places.push_back(std::to_string(std::lround(x)) + " " + std::to_string(std::lround(y)));
  }
  return places;
}

// 1 ms is a fifth of the axis from 62 to 466 px; 100 N/m is at 274 px, 20,000 at 30.
TEST(StiffnessChart, ItsPictureShowsTheOwnPointOnceInItsPanelAndInTheLegend) {
  const StiffnessChart chart = test::made(
      stiffness_chart(charted_device(0.1, 0.5, {0.5e-3, 1e-3}), {20'000.0, 0.0}, 1000.0));
  const std::string svg = stiffness_chart_svg(chart);
  // The picture, four rates and the legend, each with an origin of its own.
  EXPECT_EQ(count_of(svg, "<svg "), 6u);
  EXPECT_EQ(count_of(svg, "</svg>"), 6u);
  EXPECT_EQ(circles(svg), (std::vector<std::string>{"143 30", "28 132"}));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("the setting, 20 kN/m at a delay of 1 ms: refused"), std::string::npos);
}

TEST(StiffnessChart, ItsTableHasALineForEachRateAndDelay) {
  const StiffnessChart chart =
      test::made(stiffness_chart(charted_device(0.1, 0.5, {}), {500.0, 0.0}, 1000.0));
  const std::string csv = stiffness_chart_csv(chart);
  EXPECT_EQ(count_of(csv, "\n"), 1u + 4u * StiffnessChartRange::kDelays);
}

}  // namespace
}  // namespace palpate
