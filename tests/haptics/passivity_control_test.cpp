// The governor around a tip in simulated time: a point mass that a light grip presses against a
// spring, with a delay of whole ticks. The loop is the test's own; no scene takes part.

#include "haptics/passivity_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iostream>
#include <limits>
#include <type_traits>
#include <utility>

#include <gtest/gtest.h>

#include "engine/simulation/mass_damper.h"
#include "haptics/record_vectors.h"
#include "haptics/safety_governor.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

struct PressedLoop {
  double stiffness_N_per_m = 1000.0;
  int delay_ticks = 1;
  double rate_Hz = 1000.0;
  double stated_delay_s = -1.0;  // < 0: the true one
  double mass_kg = 0.1;          // the true one; the device states 0.1
  double grip_N_per_m = 100.0;
  double quantum_m = 0.0;
  bool watches_energy = true;
  int bad_every = 0;  // ticks; each such sample is not a number; 0: none
};

struct Settled {
  double swing_m = 0.0;  // half of the way in the last quarter
  bool has_tripped = false;
  TripReason reason = TripReason::kNone;
  std::uint32_t rules = 0;
  double counted_J = 0.0, true_J = 0.0;
  double worked_J = 0.0;
};

// Presses along an oblique line, 10 mm past the wall, for some seconds.
Settled press(const PressedLoop& loop, double seconds = 4.0) {
  const double dt_s = 1.0 / loop.rate_Hz;
  const Vec3 out = Vec3(2.0, 1.0, -2.0) / 3.0;  // of the wall
  DeviceDescription device;
  device.motor_count = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    device.motors[i].direction_device = {};
    device.motors[i].direction_device[i] = 1.0;
  }
  device.peak_force_N = 10.0;
  device.workspace_low_m.fill(-0.5);
  device.workspace_high_m.fill(0.5);
  device.mass_kg = 0.1;
  device.damping_Ns_per_m = 0.5;
  device.rate_Hz = loop.rate_Hz;
  device.encoder_quantum_m = loop.quantum_m;
  const double delay_s = loop.stated_delay_s < 0.0 ? loop.delay_ticks * dt_s : loop.stated_delay_s;
  device.delay = {delay_s, std::max(delay_s, 1e-12)};
  GovernorSettings settings;
  settings.watches_energy = loop.watches_energy;
  SafetyGovernor governor(device, 10.0, settings);
  MassDamper tip(loop.mass_kg, 0.5);
  tip.put(0.005 * out, Vec3::Zero());
  std::deque<Vec3> on_the_way(static_cast<std::size_t>(loop.delay_ticks), Vec3::Zero());
  Settled settled;
  double low_m = std::numeric_limits<double>::infinity(), high_m = -low_m;
  const int ticks = static_cast<int>(seconds / dt_s);
  for (int n = -ticks / 2; n < ticks; ++n) {
    DeviceSample sample;
    sample.sequence = static_cast<std::uint64_t>(n + ticks);
    for (int k = 0; k < 3; ++k) {
      const double p_m = tip.position_m()[k];
      sample.position_m[static_cast<std::size_t>(k)] =
          loop.quantum_m > 0.0 ? loop.quantum_m * std::round(p_m / loop.quantum_m) : p_m;
    }
    const DeviceSample& used = governor.begin_tick(sample, {dt_s, 0, 0});
    TickRecord record;
    record.tick = sample.sequence;
    const bool is_bad = loop.bad_every > 0 && (n + ticks) % loop.bad_every == 0;
    if (is_bad) record.faults = kFaultNonFiniteSample;
    std::copy_n(used.position_m.begin(), 3, record.device_m);
    const double depth_m = is_bad ? 0.0 : std::max(0.0, -vec3(record.device_m).dot(out));
    if (is_bad) {
      std::fill_n(record.device_m, 3, std::numeric_limits<double>::quiet_NaN());
    }
    record.contact = depth_m > 0.0;
    put(Vec3(loop.stiffness_N_per_m * depth_m * out), record.full_force_device_N);
    put(Vec3(loop.stiffness_N_per_m * depth_m * out), record.force_device_N);
    ForceSources sources;
    sources.stiffness_N_per_m = loop.stiffness_N_per_m;
    sources.lag_m = depth_m;
    governor.govern(record, sources);
    settled.rules |= record.rules;
    EXPECT_TRUE(vec3(record.force_device_N).allFinite()) << n;
    EXPECT_TRUE(std::isfinite(governor.status().given_J + governor.status().account_J)) << n;
    on_the_way.push_back(vec3(record.force_device_N));
    const Vec3 motors_N = on_the_way.front();
    on_the_way.pop_front();
    // The grip pulls to a place outside at first, then into the wall, and holds the tip on the
    // line.
    const double wanted_m = n < 0 ? 0.005 : -0.010;
    const Vec3 before_m = tip.position_m();
    constexpr int kParts = 20;  // the grip's spring changes along the way
    for (int part = 0; part < kParts; ++part) {
      const Vec3 grip_N = loop.grip_N_per_m * (wanted_m * out - tip.position_m());
      tip.advance(motors_N + grip_N, dt_s / kParts);
    }
    const double work_J = motors_N.dot(tip.position_m() - before_m);
    settled.true_J += n + 1 < ticks ? work_J : 0.0;  // the last way has no sample after it
    settled.worked_J += std::abs(work_J);
    if (n >= ticks * 3 / 4) {
      low_m = std::min(low_m, tip.position_m().dot(out));
      high_m = std::max(high_m, tip.position_m().dot(out));
    }
    settled.has_tripped = governor.status().trips > 0;
    settled.reason = governor.status().trip.reason;
    if (settled.has_tripped) break;
  }
  settled.swing_m = 0.5 * (high_m - low_m);
  settled.counted_J = governor.status().given_J;
  return settled;
}

TEST(PassivityControl, BringsToRestWhatSwingsWithoutIt) {
  for (const auto& [stiffness_N_per_m, delay_ticks] :
       {std::pair{1000.0, 1}, {2000.0, 1}, {3500.0, 1}, {500.0, 3}, {1000.0, 3}, {5000.0, 0}}) {
    PressedLoop loop{.stiffness_N_per_m = stiffness_N_per_m, .delay_ticks = delay_ticks};
    const Settled calm = press(loop);
    EXPECT_FALSE(calm.has_tripped) << stiffness_N_per_m;
    EXPECT_LE(calm.swing_m, 1e-4) << stiffness_N_per_m << ' ' << delay_ticks;
    EXPECT_NE(calm.rules & kRuleDamping, 0u);
    loop.watches_energy = false;
    const Settled wild = press(loop);
    EXPECT_TRUE(wild.has_tripped || wild.swing_m > 1e-3) << stiffness_N_per_m << ' ' << delay_ticks;
  }
}

TEST(PassivityControl, CalmsAnEncoderWithSteps) {
  for (const double quantum_m : {20e-6, 45e-6}) {
    const Settled calm = press({.stiffness_N_per_m = 1000.0, .quantum_m = quantum_m});
    EXPECT_FALSE(calm.has_tripped);
    // Without friction, rounding keeps a motion within two steps up (Diolaiti et al. 2006).
    EXPECT_LE(calm.swing_m, std::max(1e-4, 2.0 * quantum_m)) << quantum_m;
    // In a tick of this servo the hand moves by a tenth of a step.
    for (const double stiffness_N_per_m : {600.0, 1500.0, 2500.0}) {
      const Settled fast = press({.stiffness_N_per_m = stiffness_N_per_m,
                                  .delay_ticks = 8,
                                  .rate_Hz = 5000.0,
                                  .quantum_m = quantum_m});
      EXPECT_FALSE(fast.has_tripped);
      EXPECT_LE(fast.swing_m, std::max(1e-4, 2.0 * quantum_m)) << stiffness_N_per_m;
    }
  }
}

// The controller goes on with the next good sample, and no number that is not finite stays.
TEST(PassivityControl, ForgetsABadSample) {
  const Settled calm = press({.stiffness_N_per_m = 1000.0, .bad_every = 150});
  EXPECT_FALSE(calm.has_tripped);
  EXPECT_LE(calm.swing_m, 5e-3);
  EXPECT_NE(calm.rules & kRuleDamping, 0u);
}

// The device is lighter and its delay much longer than it states.
TEST(PassivityControl, TripsIfALoopIsUnstableAllTheSame) {
  const Settled wild = press(
      {.stiffness_N_per_m = 6000.0, .delay_ticks = 8, .stated_delay_s = 8e-3, .mass_kg = 0.03});
  EXPECT_TRUE(wild.has_tripped || wild.swing_m <= 1e-4);
  EXPECT_NE(wild.rules & kRuleSoft, 0u);
  if (wild.has_tripped) {
    EXPECT_TRUE(wild.reason == TripReason::kUnstable || wild.reason == TripReason::kSpeed);
  }
}

TEST(PassivityControl, CountsTheEnergyOfTheLoopExactly) {
  Random random(8);
  std::cout << "seed 8\n";
  for (int n = 0; n < 20; ++n) {
    const PressedLoop loop{.stiffness_N_per_m = random.uniform(100.0, 3000.0),
                           .delay_ticks = static_cast<int>(random.index(5)),
                           .grip_N_per_m = random.uniform(50.0, 300.0)};
    const Settled settled = press(loop, 2.0);
    if (settled.has_tripped) continue;
    EXPECT_NEAR(settled.counted_J, settled.true_J, 1e-9 * settled.worked_J) << n;
  }
}

// The observer by its definition, with the whole history.
class Observer {
 public:
  Observer(const AssumedMechanics& device, double period_s)
      : device_(device), period_s_(period_s) {}

  void add(const PassivityControl::Tick& tick, const Vec3& way_m) {
    const Vec3 last_N = back(forces_N_, 0);
    const Vec3 even_N = 0.5 * (last_N + tick.force_N);
    const Vec3 late_N = acting(forces_N_, device_.delay.most_s);
    const bool has_force = !last_N.isZero(0.0) || !tick.force_N.isZero(0.0) || !late_N.isZero(0.0);
    double common_J = tick.given_J;
    double damped_J = 0.0;
    if (has_force) {
      const auto whole =
          static_cast<std::size_t>(DelayTicks::of(device_.delay.most_s, period_s_).whole);
      common_J += acting(dampings_N_, device_.delay.most_s).dot(way_m) - back(booked_J_, whole);
      const double motion =
          std::max(along2(way_m, tick.force_N - last_N), along2(way_m, late_N - even_N));
      damped_J = tick.is_disturbed ? 0.0 : device_.damping_Ns_per_m * motion / tick.way_s;
    }
    for (const bool is_late : {false, true}) {
      double& account_J = accounts_J_[is_late];
      account_J += common_J;
      const Vec3 acts_N = acting(forces_N_, is_late ? device_.delay.most_s : device_.delay.least_s);
      if (has_force) account_J += (acts_N - even_N).dot(way_m) - damped_J;
      account_J = std::max(account_J, -PassivityLimits::kMostCredit_J);
      if (account_J > 0.0) account_J *= 1.0 - period_s_ / PassivityLimits::kForget_s;
    }
  }
  void command(const Vec3& force_N, const Vec3& damping_N, const Vec3& velocity_m_per_s) {
    forces_N_.push_front(force_N);
    dampings_N_.push_front(damping_N);
    booked_J_.push_front(damping_N.dot(velocity_m_per_s) * period_s_);
    for (double& account_J : accounts_J_) account_J += booked_J_.front();
  }
  double account_J() const { return std::max(accounts_J_[0], accounts_J_[1]); }

 private:
  static double along2(const Vec3& way_m, const Vec3& force_N) {
    return force_N.isZero(0.0) ? 0.0 : std::pow(way_m.dot(force_N.normalized()), 2);
  }
  template <typename T>
  static T back(const std::deque<T>& values, std::size_t ticks) {
    if constexpr (std::is_same_v<T, double>) {
      return ticks < values.size() ? values[ticks] : 0.0;
    } else {
      return ticks < values.size() ? values[ticks] : T(T::Zero());
    }
  }
  // The delay in periods is a multiple of a half.
  Vec3 acting(const std::deque<Vec3>& forces_N, double delay_s) const {
    const double halves = std::round(2.0 * delay_s / period_s_);
    const auto whole = static_cast<std::size_t>(halves) / 2;
    const Vec3 newer_N = back(forces_N, whole);
    const bool is_whole = static_cast<std::size_t>(halves) % 2 == 0;
    return is_whole ? newer_N : Vec3(0.5 * (newer_N + back(forces_N, whole + 1)));
  }

  AssumedMechanics device_;
  double period_s_;
  std::deque<Vec3> forces_N_, dampings_N_;
  std::deque<double> booked_J_;
  std::array<double, 2> accounts_J_ = {-PassivityLimits::kMostCredit_J,
                                       -PassivityLimits::kMostCredit_J};
};

// A hand in a spring, whose force a rule may shorten, and now and then energy beyond a budget. The
// delay is a multiple of half a period.
TEST(PassivityControl, KeepsTheAccountOfItsDefinitionAndItsLargestDamping) {
  Random random(9);
  std::cout << "seed " << random.seed() << "\n";
  int damped = 0;
  for (int n = 0; n < 200; ++n) {
    const double period_s = 1.0 / random.uniform(250.0, 10'000.0);
    const double least_s = 0.5 * period_s * static_cast<double>(random.index(6));
    const AssumedMechanics device{
        .mass_kg = random.uniform(0.05, 0.5),
        .damping_Ns_per_m = random.uniform(0.1, 2.0),
        .delay = {least_s, least_s + 0.5 * period_s * static_cast<double>(random.index(6))}};
    PassivityControl control(device, 0.0);
    control.set_period(period_s);
    Observer observer(device, period_s);
    const int window = controller_velocity_ticks(period_s);
    const double stiffness_N_per_m = random.uniform(500.0, 5000.0);
    std::deque<std::pair<double, Vec3>> places = {{0.0, Vec3::Zero()}};
    Vec3 velocity = Vec3::Zero();
    bool is_active = false;
    double time_s = 0.0, largest_J = 1e-3;
    for (int k = 0; k < 500; ++k) {
      velocity = 0.98 * velocity + 0.05 * random.in_box(1.0);
      PassivityControl::Tick tick;
      tick.way_s = random.index(10) == 0 ? 2.0 * period_s : period_s;
      time_s += tick.way_s;
      tick.now_ns = std::llround(time_s * 1e9);
      tick.p_device_m = places.front().second + tick.way_s * velocity;
      tick.has_way = k > 0;
      tick.force_N = -stiffness_N_per_m * tick.p_device_m.cwiseMax(0.0);
      tick.is_disturbed = random.index(5) == 0;
      tick.given_J = random.index(20) == 0 ? random.uniform(0.0, 2e-3) : 0.0;
      tick.longest_hold_s = random.index(2) == 0 ? 0.0 : random.uniform(0.0, 5.0 * period_s);
      const Vec3 way_m = tick.p_device_m - places.front().second;
      places.emplace_front(static_cast<double>(tick.now_ns) * 1e-9, tick.p_device_m);
      if (k == 0) places.resize(1);
      if (k > 0) observer.add(tick, way_m);
      const Vec3 damping_N = control.damping_N(tick);
      if (observer.account_J() > 0.0) is_active = true;
      if (observer.account_J() <= -PassivityLimits::kMostCredit_J) is_active = false;
      if (!is_active) {
        ASSERT_TRUE(damping_N.isZero(0.0)) << n << ' ' << k;
      }
      Vec3 mean = Vec3::Zero();
      // As many samples as fit into the window, at least one.
      const bool is_held = tick.longest_hold_s > period_s;
      const double samples =
          is_held ? std::max(1.0, std::round(window * period_s / tick.longest_hold_s)) : window;
      const std::size_t ticks = std::min(static_cast<std::size_t>(samples), places.size() - 1);
      if (ticks > 0) {
        mean = (places[0].second - places[ticks].second) / (places[0].first - places[ticks].first);
      }
      const double longer_s = std::max(0.0, samples * tick.longest_hold_s - window * period_s);
      const double late_s = is_held ? tick.longest_hold_s - period_s + 0.5 * longer_s : 0.0;
      const double most_Ns_per_m =
          largest_damping_Ns_per_m(device.mass_kg, device.delay.most_s + late_s, period_s, window);
      ASSERT_LE(damping_N.norm(), most_Ns_per_m * mean.norm() * (1.0 + 1e-12)) << n << ' ' << k;
      damped += !damping_N.isZero(0.0);
      const double left = random.index(3) == 0 ? random.uniform(0.0, 1.0) : 1.0;
      control.command(left * tick.force_N, left * damping_N);
      observer.command(left * tick.force_N, left * damping_N, mean);
      largest_J = std::max(largest_J, std::abs(observer.account_J()));
      ASSERT_NEAR(control.account_J(), observer.account_J(), 1e-9 * largest_J) << n << ' ' << k;
    }
  }
  EXPECT_GT(damped, 1000);
}

// Between two samples that are three ticks apart, three forces have acted.
TEST(PassivityControl, CountsAllForcesThatActedBetweenTwoSamples) {
  PassivityControl control({.mass_kg = 0.1, .damping_Ns_per_m = 0.5, .delay = {0.0, 0.0}}, 0.0);
  constexpr double kTickTime_s = 1e-3, kGiven_J = 1e-3;
  control.set_period(kTickTime_s);
  const Vec3 forces_N[] = {{1.0, 0.0, 0.0}, {4.0, 0.0, 0.0}, {2.0, 0.0, 0.0}};
  PassivityControl::Tick tick;
  tick.is_disturbed = true;  // the device's damping does not count
  tick.force_N = forces_N[0];
  control.damping_N(tick);
  for (const Vec3& force_N : forces_N) control.command(force_N, Vec3::Zero());
  tick.p_device_m = {-1e-3, 0.0, 0.0};
  tick.has_way = true;
  tick.way_s = tick.longest_hold_s = 3 * kTickTime_s;
  tick.now_ns = 3'000'000;
  tick.force_N = {3.0, 0.0, 0.0};
  tick.given_J = kGiven_J;
  control.damping_N(tick);
  const double leak_J = ((1.0 + 4.0 + 2.0) / 3.0 - 0.5 * (2.0 + 3.0)) * -1e-3;
  const double account_J = kGiven_J - PassivityLimits::kMostCredit_J + leak_J;
  EXPECT_NEAR(control.account_J(), account_J * (1.0 - kTickTime_s / PassivityLimits::kForget_s),
              1e-15);
}

// The velocity of a sample before an interruption is too old.
TEST(PassivityControl, HoldsNoDampingOverAnInterruption) {
  PassivityControl control({.mass_kg = 0.1, .damping_Ns_per_m = 0.5, .delay = {1e-3, 1e-3}}, 0.0);
  control.set_period(1e-3);
  for (int n = 1; n <= 3; ++n) {
    PassivityControl::Tick tick;
    tick.p_device_m = {-1e-4 * n, 0.0, 0.0};
    tick.has_way = true;
    tick.way_s = 1e-3;
    tick.force_N = {1.0 * n, 0.0, 0.0};
    tick.given_J = 1e-3;
    tick.now_ns = n * 1'000'000;
    control.command(tick.force_N, control.damping_N(tick));
  }
  EXPECT_FALSE(control.held_damping_N().isZero(0.0));
  control.lose_way();
  EXPECT_TRUE(control.held_damping_N().isZero(0.0));
}

// A hand that pushes with a force, or without one, while energy comes from elsewhere.
TEST(PassivityControl, IsUnstableOnlyWithAForceAndStiffensTheNextContact) {
  for (const bool has_force : {true, false}) {
    PassivityControl control({.mass_kg = 0.1, .damping_Ns_per_m = 0.5, .delay = {1e-3, 1e-3}}, 0.0);
    control.set_period(1e-3);
    PassivityControl::Tick tick;
    const auto run = [&](double force_N, double given_J) {
      tick.has_way = true;
      tick.way_s = 1e-3;
      tick.now_ns += 1'000'000;
      tick.force_N = {force_N, 0.0, 0.0};
      tick.given_J = given_J;
      const Vec3 damping_N = control.damping_N(tick);
      control.command(tick.force_N, damping_N);
    };
    for (int n = 0; n < 500; ++n) run(has_force ? 1.0 : 0.0, 1e-3);
    EXPECT_EQ(control.stiffness(), PassivityLimits::kLeastStiffness);
    EXPECT_EQ(control.is_unstable(), has_force);
    // The account is forgotten within some seconds; then a contact has its full stiffness.
    for (int n = 0; n < 8000; ++n) run(0.0, 0.0);
    EXPECT_FALSE(control.is_unstable());
    EXPECT_EQ(control.stiffness(), 1.0);
  }
}

TEST(LargestDamping, IsTheMassOverTwiceTheAgeOfTheVelocity) {
  const AssumedMechanics device{.mass_kg = 0.1, .damping_Ns_per_m = 0.5, .delay = {1e-3, 1e-3}};
  PassivityControl control(device, 0.0);
  control.set_period(1e-3);
  // The delay, the hold and half of a window of two ticks: 3 ms.
  EXPECT_NEAR(control.largest_damping_Ns_per_m(), 0.1 / (2.0 * 3e-3), 1e-12);
}

}  // namespace
}  // namespace palpate
