// The zones of stiffness of a device that moves motors, judged by simulated ticks.

#include "engine/devices/stiffness_zones.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/coupling_dampers.h"
#include "engine/devices/stability_limits.h"
#include "engine/simulation/mass_damper.h"
#include "haptics/effects/virtual_coupling.h"
#include "tests/helpers/random.h"
#include "tests/helpers/tick_map.h"

namespace palpate {
namespace {

using test::Random;
using test::TickMap;

DeviceDescription board(double mass_kg, double damping_Ns_per_m, DelayInterval delay) {
  DeviceDescription device;
  device.name = "board";
  device.moves_motors = true;
  device.mass_kg = mass_kg;
  device.damping_Ns_per_m = damping_Ns_per_m;
  device.delay = delay;
  device.rate_Hz = 0.0;  // a sample in every tick
  return device;
}

DeviceMechanics tip_of(const StiffnessZones& zones) {
  return {zones.mechanics.mass_kg, zones.mechanics.damping_Ns_per_m};
}

TEST(StiffnessZones, AnUnknownDeviceHasThoseOfABareTipAtTheLongestDelayOfItsClass) {
  const StiffnessZones zones = stiffness_zones(board(0.0, 0.0, {}), 0.0, 1e-3).value();
  EXPECT_TRUE(zones.mechanics.assumes_mass && zones.mechanics.assumes_damping &&
              zones.mechanics.assumes_delay);
  const ServoTiming timing{1e-3, 3.1e-3};
  const auto limits = stability_limits({0.1, 0.5}, 0.0, timing);
  EXPECT_EQ(zones.stable_N_per_m, limits->stable_N_per_m);
  EXPECT_EQ(zones.passive_N_per_m, limits->passive_N_per_m);
  EXPECT_EQ(zones.auto_N_per_m, 0.5 * limits->stable_N_per_m);
}

// The newest sample is up to 3 ms older.
TEST(StiffnessZones, RareSamplesAreALongerDelay) {
  DeviceDescription device = board(0.1, 0.5, {1e-3, 2e-3});
  device.rate_Hz = 250.0;
  const StiffnessZones zones = stiffness_zones(device, 0.0, 1e-3).value();
  const StiffnessZones late = stiffness_zones(board(0.1, 0.5, {1e-3, 5e-3}), 0.0, 1e-3).value();
  EXPECT_NEAR(zones.stable_N_per_m, late.stable_N_per_m, 1e-9 * late.stable_N_per_m);
  EXPECT_NEAR(zones.calm_N_per_m, late.calm_N_per_m, 1e-9 * late.calm_N_per_m);
  EXPECT_LT(zones.calm_N_per_m,
            0.5 * stiffness_zones(board(0.1, 0.5, {1e-3, 2e-3}), 0.0, 1e-3)->calm_N_per_m);
}

TEST(StiffnessZones, ABareTipHasTheLimitsOfTheNotesAtOneAndThreeMilliseconds) {
  const auto at = [](double delay_s) {
    return stiffness_zones(board(0.1, 0.5, {delay_s, delay_s}), 0.0, 1e-3).value();
  };
  EXPECT_NEAR(at(1e-3).stable_N_per_m, 333.0, 1.0);
  EXPECT_NEAR(at(3e-3).stable_N_per_m, 143.0, 0.5);
  EXPECT_FALSE(at(1e-3).mechanics.assumes_any());
  // 1,000 N/m, the default of a simulated run.
  EXPECT_EQ(at(1e-9).zone_of(1000.0), StiffnessZone::kStable);
  EXPECT_EQ(at(1e-3).zone_of(1000.0), StiffnessZone::kControlled);
  EXPECT_EQ(at(5e-3).zone_of(1000.0), StiffnessZone::kRefused);
}

// The table of docs/concepts/time.md, to its last digit.
TEST(StiffnessZones, AreThoseOfTheTableOfThePage) {
  struct Row {
    double delay_s, stable, passive, damping, calm;
  };
  for (const Row& row : {Row{1e-9, 1001, 1000, 25.0, 14627},
                         {1e-3, 334, 333, 16.7, 4014},
                         {2e-3, 200, 200, 12.5, 1925},
                         {3e-3, 143, 143, 10.0, 1140},
                         {3.1e-3, 139, 139, 9.8, 1089},
                         {5e-3, 91, 91, 7.1, 542}}) {
    const StiffnessZones zones =
        stiffness_zones(board(0.1, 0.5, {row.delay_s, row.delay_s}), 0.0, 1e-3).value();
    EXPECT_EQ(std::round(zones.stable_N_per_m), row.stable);
    EXPECT_EQ(std::round(zones.passive_N_per_m), row.passive);
    EXPECT_EQ(std::round(10.0 * zones.damping_Ns_per_m) / 10.0, row.damping);
    EXPECT_EQ(std::round(zones.calm_N_per_m), row.calm);
  }
}

TEST(StiffnessZones, TheLongerEndOfTheDelayDecides) {
  Random random(4911);
  for (int trial = 0; trial < 100; ++trial) {
    const double mass = random.uniform(0.05, 1.0), damping = random.uniform(0.1, 2.0);
    const double least = random.uniform(0.0, 3e-3), most = least + random.uniform(0.0, 2e-3);
    const double period = random.uniform(0.2e-3, 4e-3);
    const auto of = [&](double least_s, double most_s) {
      return stiffness_zones(board(mass, damping, {least_s, most_s}), 0.0, period).value();
    };
    const StiffnessZones both = of(least, most), late = of(most, most);
    EXPECT_EQ(both.stable_N_per_m, late.stable_N_per_m);
    EXPECT_EQ(both.passive_N_per_m, late.passive_N_per_m);
    EXPECT_EQ(both.calm_N_per_m, late.calm_N_per_m);
    EXPECT_EQ(both.damping_Ns_per_m, late.damping_Ns_per_m);
    EXPECT_LE(both.passive_N_per_m, both.stable_N_per_m * (1.0 + 1e-9));
    EXPECT_LE(both.stable_N_per_m, both.calm_N_per_m);
  }
}

// The largest damping by itself must not swing, at any age and for any window.
TEST(StiffnessZones, TheLargestDampingAloneIsStableWithAMarginOfThree) {
  Random random(4912);
  for (int trial = 0; trial < 200; ++trial) {
    const double mass = random.uniform(0.05, 1.0);
    const ServoTiming timing{random.uniform(0.1e-3, 4e-3), random.uniform(0.0, 5e-3)};
    const int window = controller_velocity_ticks(timing.period_s);
    const double damping = largest_damping_Ns_per_m(mass, timing.delay_s, timing.period_s, window);
    const DeviceMechanics tip{mass, 0.5};
    EXPECT_TRUE(TickMap(tip, 1.0, {{3.0 * damping, window}}, timing).decays()) << "trial " << trial;
    EXPECT_DOUBLE_EQ(damping, mass / (2.0 * damper_age_s(timing.delay_s, timing.period_s, window)));
  }
}

TEST(StiffnessZones, TheWindowOfTheControllerIsTwoMillisecondsInWholeTicks) {
  static_assert(controller_velocity_ticks(1e-3) == 2);
  static_assert(controller_velocity_ticks(1.0 / 250.0) == 1);
  static_assert(controller_velocity_ticks(2e-3) == 1);
  static_assert(controller_velocity_ticks(1e-4) == 20);
  static_assert(controller_velocity_ticks(1e-9) == kMostControllerTicks);
  EXPECT_EQ(stiffness_zones(board(0.1, 0.5, {1e-3, 1e-3}), 0.0, 0.25e-3)->velocity_ticks, 8);
}

struct DrawnBoard {
  DeviceDescription device;
  double period_s;

  static DrawnBoard draw(Random& random) {
    const double mass = random.uniform(0.05, 1.0), damping = random.uniform(0.2, 1.0);
    const double delay_s = random.uniform(0.05e-3, 5e-3);
    const double rate_Hz = 250.0 * std::pow(40.0, random.uniform(0.0, 1.0));
    return {board(mass, damping, {0.5 * delay_s, delay_s}), 1.0 / rate_Hz};
  }
};

// Each zone at every delay of the interval.
TEST(StiffnessZones, LoopsDecayInTheirZonesAndNotBeyond) {
  Random random(4913);
  for (int trial = 0; trial < 60; ++trial) {
    const auto [device, period_s] = DrawnBoard::draw(random);
    const StiffnessZones zones = stiffness_zones(device, 0.0, period_s).value();
    const LoopDamper controller{zones.damping_Ns_per_m, zones.velocity_ticks};
    const auto decays = [&](double stiffness, const LoopDamper& damper, double delay_s) {
      return TickMap(tip_of(zones), stiffness, {damper}, {period_s, delay_s}).decays();
    };
    const DelayInterval delay = zones.mechanics.delay;
    for (const double delay_s :
         {delay.least_s, random.uniform(delay.least_s, delay.most_s), delay.most_s}) {
      EXPECT_TRUE(decays(zones.auto_N_per_m, {}, delay_s)) << "trial " << trial;
      EXPECT_TRUE(decays(0.999 * zones.stable_N_per_m, {}, delay_s)) << "trial " << trial;
      EXPECT_TRUE(decays(zones.calm_N_per_m, controller, delay_s)) << "trial " << trial;
    }
    EXPECT_FALSE(decays(1.001 * zones.stable_N_per_m, {}, delay.most_s)) << "trial " << trial;
    ASSERT_GT(zones.calm_N_per_m, zones.stable_N_per_m);
    EXPECT_TRUE(decays(1.999 * zones.calm_N_per_m, controller, delay.most_s)) << "trial " << trial;
    EXPECT_FALSE(decays(2.001 * zones.calm_N_per_m, controller, delay.most_s)) << "trial " << trial;
  }
}

// What kCalmPart promises: with the controller, the slowest motion decays at least as fast as that
// of the tip on a spring without delay. Also if a hand makes the tip heavier than the controller
// supposes, and if the delay is shorter.
TEST(StiffnessZones, ACalmTipComesToRestAsFastAsOneWithoutDelay) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const double mass : {0.05, 0.1, 0.3, 1.0}) {
    for (const double rate_Hz : {250.0, 500.0, 1000.0, 4000.0, 10000.0}) {
      for (const double delay_s : {1e-9, 0.5e-3, 1e-3, 3.1e-3, 5e-3}) {
        const double period_s = 1.0 / rate_Hz;
        const StiffnessZones zones =
            stiffness_zones(board(mass, 0.5, {delay_s, delay_s}), 0.0, period_s).value();
        const auto times_faster = [&](double heavier, double delay) {
          const DeviceMechanics tip{heavier * mass, 0.5};
          const double radius = spectral_radius(tip, {zones.calm_N_per_m, zones.damping_Ns_per_m},
                                                {period_s, delay, zones.velocity_ticks});
          return -std::log(radius) / period_s / (0.5 / (2.0 * heavier * mass));
        };
        least = std::min(least, times_faster(1.0, delay_s));
        most = std::max(most, times_faster(1.0, delay_s));
        EXPECT_GT(times_faster(1.0, delay_s), 3.7) << mass << " " << rate_Hz << " " << delay_s;
        EXPECT_GT(times_faster(1.0, 0.5 * delay_s), 1.0);
        for (const double heavier : {1.5, 4.0, 10.0}) {
          EXPECT_GT(times_faster(heavier, delay_s), 1.0)
              << mass << " x " << heavier << " " << rate_Hz << " " << delay_s;
        }
      }
    }
  }
  EXPECT_NEAR(least, 3.8, 0.05);
  EXPECT_NEAR(most, 430.0, 5.0);
}

TEST(StiffnessZones, TheCouplingsDampingIsNotTheControllersToAdd) {
  const DeviceDescription device = board(0.1, 0.5, {1e-3, 1e-3});
  const double period_s = 1e-3;
  const StiffnessZones none = stiffness_zones(device, 0.0, period_s).value();
  const StiffnessZones some = stiffness_zones(device, 2.0, period_s).value();
  EXPECT_GT(some.stable_N_per_m, none.stable_N_per_m);
  EXPECT_EQ(some.passive_N_per_m, 0.0);
  const double rest = none.damping_Ns_per_m - 2.0;
  const auto decays = [&](double stiffness) {
    return TickMap({0.1, 0.5}, stiffness, {{2.0, 1}, {rest, none.velocity_ticks}}, {period_s, 1e-3})
        .decays();
  };
  EXPECT_TRUE(decays(1.999 * some.calm_N_per_m));
  EXPECT_FALSE(decays(2.001 * some.calm_N_per_m));
}

// A coupling that damps more than the controller could leaves the controller nothing.
TEST(StiffnessZones, ACouplingWithMuchDampingHasNoControlledZoneBelowItsStableLimit) {
  const StiffnessZones zones = stiffness_zones(board(0.1, 0.5, {1e-3, 1e-3}), 30.0, 1e-3).value();
  EXPECT_EQ(zones.calm_N_per_m, zones.stable_N_per_m);
  EXPECT_EQ(zones.zone_of(1.01 * zones.stable_N_per_m), StiffnessZone::kRefused);
}

// Whether a tip that is let go at 1 mm in a wall comes to rest. The loop is that of the engine: its
// coupling with its estimator of the velocity, the controller's damper over its window, and a force
// that acts some whole ticks later and is held.
class LetGo {
 public:
  LetGo(const StiffnessZones& zones, const CouplingSettings& coupling, int delay_ticks)
      : coupling_settings_(coupling),
        coupling_(coupling),
        tip_(zones.mechanics.mass_kg, zones.mechanics.damping_Ns_per_m),
        period_s_(zones.period_s),
        forces_N_(static_cast<std::size_t>(delay_ticks) + 1, 0.0) {
    controller_ = VelocityEstimator({VelocityMethod::kDifference, zones.velocity_ticks});
    tip_.put({1e-3, 0.0, 0.0}, Vec3::Zero());
  }
  void add_controller(double damping_Ns_per_m) { controller_Ns_per_m_ = damping_Ns_per_m; }

  // The largest depth of the last fifth of a time, by that of the fifth before.
  double growth(int ticks) {
    double before_m = 0.0, last_m = 0.0;
    for (int n = 0; n < ticks; ++n) {
      const double depth_m = tick();
      if (n >= ticks - 2 * ticks / 5 && n < ticks - ticks / 5) {
        before_m = std::max(before_m, depth_m);
      }
      if (n >= ticks - ticks / 5) last_m = std::max(last_m, depth_m);
    }
    return last_m > kNothing_m ? last_m / before_m : 0.0;
  }

 private:
  static constexpr double kNothing_m = 1e-100;  // what decays becomes denormal, and stays there

  double tick() {
    const Vec3 x_m = tip_.position_m();
    const Vec3 lag_m = -x_m;
    const Vec3 rate = coupling_.lag_rate_m_per_s(lag_m, period_s_);
    double force_N = coupling_settings_.stiffness_N_per_m * lag_m.x() +
                     coupling_settings_.damping_Ns_per_m * rate.x();
    force_N -= controller_Ns_per_m_ * controller_.add(x_m, period_s_).x();
    forces_N_.push_back(force_N);
    tip_.advance({forces_N_[forces_N_.size() - last_], 0.0, 0.0}, period_s_);
    return std::abs(x_m.x());
  }

  CouplingSettings coupling_settings_;
  VirtualCoupling coupling_;
  VelocityEstimator controller_{VelocitySettings{}};
  double controller_Ns_per_m_ = 0.0;
  MassDamper tip_;
  double period_s_;
  std::vector<double> forces_N_;
  std::size_t last_ = forces_N_.size();
};

// The damper of a coupling with a window of many ticks acts later. The limits are those at which
// the engine's own loop begins to swing.
TEST(StiffnessZones, AWindowOfTheCouplingsVelocityCountsAsItsLoopDoes) {
  Random random(4914);
  for (int trial = 0; trial < 40; ++trial) {
    const bool is_line = trial % 2 == 1;
    const int window = 2 + static_cast<int>(random.index(30));
    const int delay_ticks = static_cast<int>(random.index(4));
    const double period_s = 1e-3, mass = random.uniform(0.1, 0.5);
    const double delay_s = std::max(1e-12, delay_ticks * period_s);
    const VelocitySettings velocity{
        is_line ? VelocityMethod::kLineFit : VelocityMethod::kDifference, window};
    const double damping =
        random.uniform(0.1, 0.9) * largest_damping_Ns_per_m(mass, delay_s, period_s, window);
    const DeviceDescription device = board(mass, 0.5, {delay_s, delay_s});
    const StiffnessZones zones = stiffness_zones(device, damping, period_s, velocity).value();
    ASSERT_GT(zones.stable_N_per_m, 0.0);
    const auto growth = [&](double stiffness, double controller) {
      LetGo loop(zones, {stiffness, damping, velocity}, delay_ticks);
      loop.add_controller(controller);
      return loop.growth(20'000);
    };
    EXPECT_LT(growth(0.97 * zones.stable_N_per_m, 0.0), 1.0) << "trial " << trial;
    EXPECT_GT(growth(1.03 * zones.stable_N_per_m, 0.0), 1.0) << "trial " << trial;
    const double rest = std::max(0.0, zones.damping_Ns_per_m - damping);
    EXPECT_LT(growth(0.99 * zones.calm_N_per_m, rest), 1.0) << "trial " << trial;
    if (zones.calm_N_per_m == zones.stable_N_per_m) continue;
    EXPECT_LT(growth(1.9 * zones.calm_N_per_m, rest), 1.0) << "trial " << trial;
    EXPECT_GT(growth(2.1 * zones.calm_N_per_m, rest), 1.0) << "trial " << trial;
  }
}

TEST(StiffnessZones, AreSmallerForALongerWindow) {
  const DeviceDescription device = board(0.1, 0.5, {1e-3, 1e-3});
  const auto with = [&](VelocityMethod method, int window) {
    return stiffness_zones(device, 2.0, 1e-3, {method, window, 1e-5}).value();
  };
  const StiffnessZones one = with(VelocityMethod::kDifference, 1);
  const StiffnessZones same = stiffness_zones(device, 2.0, 1e-3).value();
  EXPECT_EQ(one.stable_N_per_m, same.stable_N_per_m);
  EXPECT_EQ(one.calm_N_per_m, same.calm_N_per_m);
  for (const VelocityMethod method :
       {VelocityMethod::kDifference, VelocityMethod::kLineFit, VelocityMethod::kAdaptive}) {
    const StiffnessZones many = with(method, 20);
    EXPECT_LT(many.stable_N_per_m, one.stable_N_per_m);
    EXPECT_LT(many.calm_N_per_m, one.calm_N_per_m);
    EXPECT_EQ(many.passive_N_per_m, one.passive_N_per_m);
    EXPECT_EQ(with(method, 1).stable_N_per_m, one.stable_N_per_m);
  }
  // The adaptive method may have any of its windows.
  EXPECT_LE(with(VelocityMethod::kAdaptive, 20).stable_N_per_m,
            with(VelocityMethod::kDifference, 20).stable_N_per_m);
  // Without a damper, no window counts.
  const auto undamped = stiffness_zones(device, 0.0, 1e-3, {VelocityMethod::kLineFit, 20});
  EXPECT_EQ(undamped->stable_N_per_m, stiffness_zones(device, 0.0, 1e-3)->stable_N_per_m);
}

// The weights of a line are those of the engine's estimator, at random positions.
TEST(CouplingDampers, AreTheForceOfTheEnginesEstimator) {
  Random random(4915);
  for (int trial = 0; trial < 200; ++trial) {
    const int window = 1 + static_cast<int>(random.index(VelocityEstimator::kMostTicks));
    const VelocitySettings settings{
        trial % 2 == 0 ? VelocityMethod::kLineFit : VelocityMethod::kDifference, window};
    VelocityEstimator estimator(settings);
    std::vector<double> x_m;
    double velocity = 0.0;
    for (int n = 0; n <= window; ++n) {
      x_m.push_back(random.uniform(-1e-2, 1e-2));
      velocity = estimator.add({x_m.back(), 0.0, 0.0}, 1e-3).x();
    }
    const auto entries = coupling_dampers(3.0, settings);
    ASSERT_EQ(entries.size(), 1u);
    double force_N = 0.0, whole = 0.0, size_N = 0.0;
    for (const LoopDamper& damper : entries.front()) {
      const double back_m = x_m[x_m.size() - 1 - static_cast<std::size_t>(damper.velocity_ticks)];
      const double part_N =
          damper.damping_Ns_per_m * (x_m.back() - back_m) / (damper.velocity_ticks * 1e-3);
      force_N += part_N;
      size_N += std::abs(part_N);
      whole += damper.damping_Ns_per_m;
    }
    EXPECT_NEAR(force_N, 3.0 * velocity, 1e-12 * size_N);  // some hundred roundings
    EXPECT_NEAR(whole, 3.0, 1e-12);
  }
}

TEST(StiffnessZones, HaveNames) {
  EXPECT_STREQ(name_of(StiffnessZone::kStable), "stable");
  EXPECT_STREQ(name_of(StiffnessZone::kControlled), "calm only by the controller");
  EXPECT_STREQ(name_of(StiffnessZone::kRefused), "refused");
}

TEST(StiffnessZones, AnUnknownDelayCountsOnlyWhereMotorsMove) {
  DeviceDescription device = board(0.1, 0.5, {});
  EXPECT_EQ(wall_delay_s(device), kBareTip.delay.most_s);
  device.moves_motors = false;
  EXPECT_EQ(wall_delay_s(device), 0.0);
  device.delay = {1e-3, 2e-3};
  EXPECT_EQ(wall_delay_s(device), 2e-3);
}

TEST(StiffnessZones, RefuseADelayOfTooManyPeriods) {
  const auto zones = stiffness_zones(board(0.1, 0.5, {0.0, 0.5}), 0.0, 1e-3);
  ASSERT_FALSE(zones.ok());
  EXPECT_EQ(zones.error().element, "delay");
}

}  // namespace
}  // namespace palpate
