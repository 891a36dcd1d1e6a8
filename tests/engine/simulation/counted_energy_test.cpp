// The energy that the governor counts, against the account of the plant behind the device; and
// what the controller leaves alone.

#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include <gtest/gtest.h>

#include "engine/simulation/port_loop.h"
#include "haptics/strategies/anisotropic.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

struct Exploration {
  PortLoopSettings settings;
  double push_N = 3.0;  // the hand wanders with this force
  double seconds = 2.0;
};

// A hand that presses and wanders at random. Returns the sum of the sizes of all works.
double explore(PortLoop& loop, const Exploration& exploration, SeededRandom& random,
               std::vector<Vec3>* forces_N = nullptr) {
  double worked_J = 0.0, before_J = 0.0;
  Vec3 at_m(0.02, 0.0, 0.0), to_m = at_m;
  loop.tip().set_hand(loop.to_device(at_m));
  loop.run(1.5);  // the governor starts
  const int ticks = static_cast<int>(exploration.seconds / loop.dt_s());
  int next = 0;
  for (int n = 0; n < ticks; ++n) {
    if (n == next) {
      next += static_cast<int>(random.uniform(0.05, 0.3) / loop.dt_s());
      to_m = Vec3(random.uniform(-0.02, 0.01), random.uniform(-0.05, 0.05), 0.0);
    }
    at_m += 0.01 * (to_m - at_m);
    loop.tip().set_hand(loop.to_device(at_m));
    loop.tick();
    if (forces_N != nullptr) forces_N->push_back(Vec3(loop.last().force_device_N));
    const double now_J = loop.tip().account().motors_J;
    worked_J += std::abs(now_J - before_J);
    before_J = now_J;
  }
  return worked_J;
}

Exploration random_exploration(Random& random) {
  Exploration e;
  e.settings.shape = random.index(2) == 0 ? PortShape::kWall : PortShape::kGroove;
  e.settings.turn_rad = random.uniform(-1.0, 1.0);
  e.settings.rate_Hz = random.index(2) == 0 ? 1000.0 : 2000.0;
  e.settings.coupling.stiffness_N_per_m = random.uniform(100.0, 2000.0);
  e.settings.device.device =
      motor_device(2 + static_cast<int>(random.index(2)), 10.0, e.settings.rate_Hz);
  e.settings.device.tip.hand = random.index(2) == 0 ? kLightGrip : kFirmGrip;
  const double turn_rad = e.settings.turn_rad;
  e.settings.device.start_m = 0.02 * Vec3(std::cos(turn_rad), std::sin(turn_rad), 0.0);
  return e;
}

// With a delay of whole ticks the count is exact: only its sums round.
TEST(CountedEnergy, IsThatOfThePlantWhereTheDelayIsWholeTicks) {
  const std::uint64_t seed = 9;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  for (int delay_ticks = 0; delay_ticks <= 4; ++delay_ticks) {
    for (int n = 0; n < 4; ++n) {
      Exploration e = random_exploration(random);
      const double delay_s = delay_ticks / e.settings.rate_Hz;
      e.settings.device.delay_s = delay_s;
      // No delay at all is a thousandth of a nanosecond: 0 means unknown.
      e.settings.device.device.delay = {delay_s, std::max(delay_s, 1e-12)};
      auto loop = test::made(PortLoop::create(e.settings));
      const double worked_J = explore(*loop, e, random);
      const double counted_J = loop->governor().given_J;
      ASSERT_GT(worked_J, 1e-3) << n;
      EXPECT_NEAR(counted_J, loop->tip().account().motors_J, 1e-9 * worked_J) << delay_ticks;
      // 1e-9 of a period later.
      EXPECT_NEAR(loop->governor().given_late_J, counted_J, 1e-8 * worked_J);
    }
  }
}

// Otherwise the true energy lies between the counts for the ends of the delay. The straight line
// between two samples, and what a whole tick less or more would change, are small beside them.
TEST(CountedEnergy, IsWithinTheIntervalOfTheDelay) {
  const std::uint64_t seed = 10;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  int outside = 0;
  double widest = 0.0;
  for (int n = 0; n < 40; ++n) {
    Exploration e = random_exploration(random);
    const double delay_s = random.uniform(0.2e-3, 4e-3);
    const double uncertain_s = random.uniform(0.05e-3, 0.2e-3);
    e.settings.device.delay_s = delay_s + random.uniform(-0.9, 0.9) * uncertain_s;
    e.settings.device.device.delay = {std::max(0.0, delay_s - uncertain_s), delay_s + uncertain_s};
    auto loop = test::made(PortLoop::create(e.settings));
    const double worked_J = explore(*loop, e, random);
    const double true_J = loop->tip().account().motors_J;
    const auto [least_J, most_J] =
        std::minmax(loop->governor().given_J, loop->governor().given_late_J);
    const double slack_J = 1e-3 * worked_J;
    outside += true_J < least_J - slack_J || true_J > most_J + slack_J;
    widest = std::max(widest, (most_J - least_J) / worked_J);
  }
  EXPECT_EQ(outside, 0);
  std::cout << "the widest interval: " << 100.0 * widest << " % of all work\n";
}

// An encoder with steps leaves the place of the hand uncertain by half a step, at the beginning, at
// the end, and where the force changes.
TEST(CountedEnergy, IsWithinTheIntervalOfTheDelayAndTheStepsOfTheEncoder) {
  Random random(12);
  std::cout << "seed " << random.seed() << "\n";
  double largest_share = 0.0;
  for (int n = 0; n < 40; ++n) {
    Exploration e = random_exploration(random);
    const double delay_s = random.uniform(0.2e-3, 4e-3);
    const double uncertain_s = random.uniform(0.05e-3, 0.2e-3);
    const double quantum_m = random.uniform(5e-6, 60e-6);
    e.settings.device.delay_s = delay_s + random.uniform(-0.9, 0.9) * uncertain_s;
    e.settings.device.device.delay = {std::max(0.0, delay_s - uncertain_s), delay_s + uncertain_s};
    e.settings.device.device.encoder_quantum_m = quantum_m;
    auto loop = test::made(PortLoop::create(e.settings));
    const double worked_J = explore(*loop, e, random);
    const GovernorStatus& status = loop->governor();
    const double true_J = loop->tip().account().motors_J;
    const auto [least_J, most_J] = std::minmax(status.given_J, status.given_late_J);
    const double slack_J =
        1e-3 * worked_J + 0.5 * quantum_m * Vec3(loop->last().force_device_N).lpNorm<1>();
    const double outside_J = std::max({0.0, least_J - true_J, true_J - most_J}) - slack_J;
    ASSERT_GT(status.encoder_J, 0.0);
    EXPECT_LE(outside_J, status.encoder_J) << n;
    largest_share = std::max(largest_share, outside_J / status.encoder_J);
  }
  std::cout << "outside of the delay's interval: at most " << 100.0 * largest_share
            << " % of what the steps allow\n";
}

// A slow press of a spring: the hand gets back what it has put in, but for the delay. If each step
// counted as a jump, it would seem to get K q^2 / 2 more for each: all that the steps allow.
TEST(CountedEnergy, OfASlowPressIsNotThatOfTheStepsOfTheEncoder) {
  for (const double quantum_m : {20e-6, 45e-6}) {
    PortLoopSettings settings;
    settings.coupling.stiffness_N_per_m = 1000.0;
    settings.device.device.encoder_quantum_m = quantum_m;
    settings.device.delay_s = 0.2e-3;
    settings.device.device.delay = {0.2e-3, 0.2e-3};
    settings.device.tip.hand = kFirmGrip;
    settings.device.start_m = Vec3(1e-3, 0.0, 0.0);
    auto loop = test::made(PortLoop::create(settings));
    loop->run(1.5);
    const double turn_s = 1.0;
    for (const double speed_m_per_s : {-10e-3, 10e-3}) {
      loop->tip().set_hand(loop->tip().hand_m(), Vec3(speed_m_per_s, 0.0, 0.0));
      loop->run(turn_s);
    }
    const GovernorStatus& status = loop->governor();
    ASSERT_GT(status.encoder_J, 1.0 * quantum_m);  // it pressed with more than 1 N, in and out
    EXPECT_LE(std::abs(status.given_J - loop->tip().account().motors_J), 0.1 * status.encoder_J)
        << quantum_m;
  }
}

// A known device in a firm grip, and 0.1 to 0.4 of the stiffness that is stable without the grip.
void make_stable(Exploration& e, Random& random) {
  const double delay_s = random.uniform(0.0, 4e-3);
  e.settings.device.delay_s = delay_s;
  e.settings.device.device.delay = {delay_s, delay_s};
  e.settings.device.device.mass_kg = 0.1;
  e.settings.device.device.damping_Ns_per_m = 0.5;
  e.settings.coupling.stiffness_N_per_m =
      random.uniform(0.1, 0.4) * 0.5 / (delay_s + 0.5 / e.settings.rate_Hz);
  e.settings.device.tip.hand = kFirmGrip;
}

// How far the lag grows in a tick of contact, by the way of the hand.
class LagGrowth final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    const Vec3 goal_m(record.goal_scene_m), proxy_m(record.proxy_scene_m);
    const double lag_m = (proxy_m - goal_m).norm(), way_m = (goal_m - last_goal_m_).norm();
    if (was_in_contact_ && record.contact != 0 && way_m > kLeastWay_m) {
      most_ = std::max(most_, (lag_m - last_lag_m_) / way_m);
    }
    was_in_contact_ = record.contact != 0;
    last_goal_m_ = goal_m;
    last_lag_m_ = lag_m;
  }
  double most() const { return most_; }

 private:
  static constexpr double kLeastWay_m = 1e-6;  // rounding is nothing beside it
  bool was_in_contact_ = false;
  Vec3 last_goal_m_ = Vec3::Zero();
  double last_lag_m_ = 0.0;
  double most_ = 0.0;
};

// Each force is that of a governor without the energy rules, to the bit. most_growth: of the lag;
// it keeps the larger value.
void expect_no_controller(Exploration e, std::uint64_t hand_seed, double* most_growth = nullptr) {
  std::vector<std::vector<Vec3>> forces_N(2);
  for (const bool watches : {false, true}) {
    e.settings.governor.watches_energy = watches;
    auto loop = test::made(PortLoop::create(e.settings));
    LagGrowth growth;
    loop->rig().session().observe(growth);
    SeededRandom hand(hand_seed);
    explore(*loop, e, hand, &forces_N[watches ? 1 : 0]);
    if (most_growth != nullptr) *most_growth = std::max(*most_growth, growth.most());
  }
  ASSERT_EQ(forces_N[0].size(), forces_N[1].size());
  for (std::size_t k = 0; k < forces_N[0].size(); ++k) {
    ASSERT_EQ(forces_N[0][k], forces_N[1][k]) << "hand " << hand_seed << ", tick " << k;
  }
}

// A loop that comes to rest by itself feels no controller: each force is that of a governor without
// the energy rules, to the bit. Near the limit of stability a swing lasts, and the controller may
// damp it (PassivityLimits::kSwingLeak).
TEST(StableContact, FeelsNoController) {
  const std::uint64_t seed = 11;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  for (int n = 0; n < 20; ++n) {
    Exploration e = random_exploration(random);
    make_stable(e, random);
    expect_no_controller(e, random.index(1'000'000));
  }
}

// With the strategy `anisotropic`, the lag grows by more than the way of the hand: along a wall,
// and across the motors. That is no jump.
TEST(StableContact, FeelsNoControllerWithAnAnisotropicSpring) {
  const std::uint64_t seed = 12;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  double stretched = 0.0;
  for (int n = 0; n < 20; ++n) {
    Exploration e;
    e.settings.turn_rad = random.uniform(-1.2, 1.2);
    e.settings.device.device = motor_device(1, 10.0, 1000.0);
    // The first ones are the most extreme.
    const double exponent = n < 4 ? (n % 2 == 0 ? 4.0 : -4.0) : random.uniform(-4.0, 4.0);
    e.settings.strategy = {&kAnisotropicStrategy, std::exp2(exponent)};
    e.settings.device.start_m =
        0.02 * Vec3(std::cos(e.settings.turn_rad), std::sin(e.settings.turn_rad), 0.0);
    // The strategy gives energy by design, and what exceeds its budget is damped.
    e.settings.governor.budgets.of.fill({EnergyBudget::kMost_J, EnergyBudget::kMost_W});
    make_stable(e, random);
    expect_no_controller(e, random.index(1'000'000), &stretched);
  }
  EXPECT_GT(stretched, 1.2) << "the most that a lag grew in a tick, by the way of the hand";
}

}  // namespace
}  // namespace palpate
