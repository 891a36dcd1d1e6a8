// The rules of the safety governor, one by one. governor_property_test.cpp has them together.

#include "haptics/safety_governor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/decompositions.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;
using Limits = GovernorLimits;

constexpr double kPeriod_s = 1e-3;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Three orthogonal motors of 10 N in a workspace of 0.2 m.
DeviceDescription motor_device() {
  DeviceDescription device;
  device.name = "three motors";
  device.motor_count = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    device.motors[i].direction_device = {};
    device.motors[i].direction_device[i] = 1.0;
    device.motors[i].peak_force_N = 10.0;
  }
  device.peak_force_N = 8.0;
  device.workspace_low_m.fill(-0.1);
  device.workspace_high_m.fill(0.1);
  return device;
}

// A governor with a clock: each tick gives it a sample and a wanted force.
class Rig {
 public:
  explicit Rig(const DeviceDescription& device = motor_device(),
               std::optional<double> max_force_N = {}, double period_s = kPeriod_s)
      : governor(device, SafetyGovernor::clamp_of(device, max_force_N)), dt_s(period_s) {}

  // Runs a tick and returns the commanded force.
  Vec3 tick(const Vec3& wanted_N) {
    if (is_new) ++sequence;
    is_new = true;
    DeviceSample sample;
    sample.position_m = {position_m.x(), position_m.y(), position_m.z()};
    sample.sequence = sequence;
    sample.is_valid = (next_faults & kFaultInvalidSample) == 0;
    sample.asks_for_trip = asks_for_trip;
    now_ns += std::llround((dt_s + late_s) * 1e9);
    used = governor.begin_tick(sample, {dt_s, std::llround(late_s * 1e9), now_ns});
    record = {};
    record.tick = ticks++;
    record.contact = in_contact ? 1 : 0;
    record.faults = next_faults;
    std::copy_n(used.position_m.begin(), 3, record.device_m);
    put(wanted_N, record.full_force_device_N);
    put(next_faults & kFaultsWithoutForce ? Vec3(Vec3::Zero()) : wanted_N, record.force_device_N);
    late_s = 0.0;
    next_faults = kFaultNone;
    governor.govern(record, sources);
    return vec3(record.force_device_N);
  }

  // A tick of a paused session.
  void pause() {
    now_ns += std::llround(dt_s * 1e9);
    governor.pause();
  }

  // Lets the rule *start* pass without contact, so that the governor runs.
  void run_in() {
    in_contact = false;
    const int ticks_of_start = static_cast<int>(std::ceil(1.0 / dt_s));
    for (int n = 0; n < ticks_of_start; ++n) tick(Vec3::Zero());
    in_contact = true;
    EXPECT_EQ(governor.status().state, GovernorState::kRuns);
  }
  // Raises the force slowly enough for the slew rule.
  Vec3 push(const Vec3& wanted_N, int count = 10) {
    Vec3 force_N = Vec3::Zero();
    for (int n = 0; n < count; ++n) force_N = tick(wanted_N);
    return force_N;
  }

  SafetyGovernor governor;
  double dt_s;
  Vec3 position_m = Vec3::Zero();
  std::uint64_t sequence = 0;
  std::int64_t now_ns = 1'000'000'000;
  std::uint64_t ticks = 0;
  TickRecord record;
  DeviceSample used;
  ForceSources sources;

  // For the next tick only:
  bool is_new = true;
  double late_s = 0.0;
  std::uint32_t next_faults = kFaultNone;

  bool asks_for_trip = false;
  bool in_contact = false;
};

// The force that `factor` leaves of a force, up to the rounding that keeps it below a limit.
void expect_scaled(const Vec3& force_N, const Vec3& wanted_N, double factor) {
  const double tolerance_N = 32 * std::numeric_limits<double>::epsilon() * wanted_N.norm();
  EXPECT_LE((force_N - factor * wanted_N).norm(), tolerance_N)
      << force_N.transpose() << " instead of " << factor << " of " << wanted_N.transpose();
}

std::uint32_t rules_of(const TickRecord& record) {
  return record.rules;
}

// A hand wanders in a spring that the device's damping holds by itself: K (tau + T / 2) <= b.
TEST(SafetyGovernor, KeepsTheBitsOfForcesThatKeepAllRules) {
  Random random(1);
  for (const double delay_s : {0.0, 1e-3, 1.3e-3, 3e-3}) {
    DeviceDescription device = motor_device();
    device.mass_kg = 0.1;
    device.damping_Ns_per_m = 0.5;
    device.delay = {delay_s, std::max(delay_s, 1e-12)};
    Rig rig(device);
    rig.run_in();
    const double stiffness_N_per_m = 0.999 * 0.5 / (delay_s + 0.5 * kPeriod_s);
    const Vec3 start_m = random.in_box(0.05);
    Vec3 velocity = Vec3::Zero();
    for (int n = 0; n < 5000; ++n) {
      velocity = 0.95 * velocity + 0.02 * random.in_box(1.0);
      rig.position_m += kPeriod_s * velocity;
      Vec3 lag_m = start_m - rig.position_m;
      const double most_m = 7.9 / stiffness_N_per_m;
      if (lag_m.norm() > most_m) rig.position_m = start_m - most_m / lag_m.norm() * lag_m;
      lag_m = start_m - rig.position_m;
      if (n < 100) {
        rig.position_m = lag_m = Vec3::Zero();  // the spring begins without a jump
        rig.position_m = start_m;
      }
      rig.sources.stiffness_N_per_m = stiffness_N_per_m;
      rig.sources.lag_m = lag_m.norm();
      const Vec3 wanted_N = stiffness_N_per_m * lag_m;
      EXPECT_EQ(rig.tick(wanted_N), wanted_N);
      ASSERT_EQ(rig.record.faults, kFaultNone) << n;
      ASSERT_EQ(rig.record.rules, 0u) << n << ' ' << delay_s;
    }
  }
}

TEST(SafetyGovernor, ClampsTheLengthOfAForceAndKeepsItsDirection) {
  for (const auto& [limit, clamp_N] :
       {std::pair<std::optional<double>, double>{std::nullopt, 8.0}, {5.0, 5.0}, {100.0, 8.0}}) {
    Rig rig(motor_device(), limit);
    rig.run_in();
    const Vec3 wanted_N = 9.0 * Vec3(1, 2, -2) / 3.0;
    const Vec3 force_N = rig.push(wanted_N);
    expect_scaled(force_N, wanted_N, clamp_N / 9.0);
    EXPECT_LE(force_N.norm(), clamp_N);
    EXPECT_EQ(rules_of(rig.record), std::uint32_t{kRuleClamp});
  }
  DeviceDescription unknown = motor_device();
  unknown.peak_force_N = 0.0;
  EXPECT_EQ(SafetyGovernor::clamp_of(unknown, {}), 3.0);
  unknown.moves_motors = false;
  EXPECT_EQ(SafetyGovernor::clamp_of(unknown, {}), std::numeric_limits<double>::infinity());
  EXPECT_EQ(SafetyGovernor::clamp_of(unknown, 2.0), 2.0);
  EXPECT_EQ(SafetyGovernor::clamp_of(motor_device(), -1.0), 0.0) << "never a force the other way";
  EXPECT_EQ(SafetyGovernor::clamp_of(motor_device(), kNoNumber), 8.0);
  EXPECT_EQ(SafetyGovernor::clamp_of(motor_device(), 1e9), 8.0);
}

TEST(SafetyGovernor, DropsWhatTheMotorsCannotPush) {
  DeviceDescription device = motor_device();
  device.motor_count = 2;
  Rig rig(device);
  rig.run_in();
  EXPECT_EQ(rig.push({1.0, 2.0, 3.0}), Vec3(1.0, 2.0, 0.0));
  EXPECT_EQ(rules_of(rig.record), std::uint32_t{kRuleMotors});
  device.motor_count = 0;
  Rig none(device);
  none.run_in();
  EXPECT_EQ(none.push({1.0, 2.0, 3.0}), Vec3(0.0, 0.0, 0.0));
}

// The efforts of oblique motors are chosen first, and the force is their sum.
TEST(SafetyGovernor, ASaturatedMotorKeepsTheDirectionOfTheForce) {
  const std::uint64_t seed = 7;
  std::cout << "seed " << seed << "\n";
  Random random(seed);
  int saturated = 0;
  for (int n = 0; n < 1000; ++n) {
    DeviceDescription device = motor_device();
    device.peak_force_N = 1000.0;
    device.motor_count = 1 + n % 3;
    Vec3 wanted_N = Vec3::Zero();
    double overload = 1.0;
    Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
    for (int i = 0; i < device.motor_count; ++i) {
      directions.col(i) = random.unit_vector();
      MotorDescription& motor = device.motors[static_cast<std::size_t>(i)];
      std::copy_n(directions.col(i).data(), 3, motor.direction_device.begin());
      motor.peak_force_N = random.uniform(1.0, 5.0);
      const double effort_N = random.uniform(-6.0, 6.0);
      wanted_N += effort_N * directions.col(i);
      overload = std::max(overload, std::abs(effort_N) / motor.peak_force_N);
    }
    Rig rig(device);
    rig.run_in();
    const Vec3 force_N = rig.push(wanted_N, 20);
    // The rounding of an effort grows with the condition of the directions.
    const double smallest = singular_values(directions)[device.motor_count - 1];
    const double tolerance_N =
        1e3 * std::numeric_limits<double>::epsilon() * 10.0 / smallest / smallest;
    EXPECT_LE((force_N - wanted_N / overload).norm(), tolerance_N) << n;
    EXPECT_EQ((rig.record.rules & kRulePeak) != 0, overload > 1.0) << n;
    saturated += overload > 1.0;
  }
  EXPECT_GT(saturated, 300);
}

TEST(SafetyGovernor, LimitsTheGrowthOfAForceAndNeverDelaysAFall) {
  Rig rig;
  rig.run_in();
  for (int n = 1; n <= 4; ++n) {  // 1 kHz: by at most 5 N in a tick
    const Vec3 force_N = rig.tick({2.0, 0.0, 0.0});
    EXPECT_EQ(force_N, Vec3(2.0, 0.0, 0.0));
  }
  const Vec3 up_N = rig.tick({7.5, 0.0, 0.0});
  expect_scaled(up_N, {7.0, 0.0, 0.0}, 1.0);
  EXPECT_EQ(rules_of(rig.record), std::uint32_t{kRuleSlew});
  EXPECT_EQ(rig.tick({7.5, 0.0, 0.0}), Vec3(7.5, 0.0, 0.0));
  EXPECT_EQ(rig.tick({0.5, 0.0, 0.0}), Vec3(0.5, 0.0, 0.0));
  rig.push({7.5, 0.0, 0.0}, 5);
  expect_scaled(rig.tick({-7.5, 0.0, 0.0}), {-5.0, 0.0, 0.0}, 1.0);  // from zero
  expect_scaled(rig.tick({0.0, 7.5, 0.0}), {0.0, 5.0, 0.0}, 1.0);    // to the side: from zero
  // A measured period counts, up to two periods.
  rig.push({0.5, 0.0, 0.0}, 5);
  rig.late_s = 0.7e-3;
  EXPECT_EQ(rig.tick({7.5, 0.0, 0.0}), Vec3(7.5, 0.0, 0.0));
  DeviceDescription strong = motor_device();
  strong.peak_force_N = 100.0;
  for (MotorDescription& motor : strong.motors) motor.peak_force_N = 100.0;
  Rig late(strong);
  late.run_in();
  late.late_s = 5e-3;
  expect_scaled(late.tick({50.0, 0.0, 0.0}), {10.0, 0.0, 0.0}, 1.0);
}

// Moves with a speed for some ticks under a force, and returns whether the governor tripped.
bool trips_at(double speed_m_per_s, double force_N, double dt_s = kPeriod_s) {
  DeviceDescription device = motor_device();
  device.workspace_low_m.fill(-10.0);
  device.workspace_high_m.fill(10.0);
  Rig rig(device, {}, dt_s);
  rig.run_in();
  rig.push({force_N, 0.0, 0.0});
  const int ticks = std::max(30, static_cast<int>(0.03 / dt_s));
  for (int n = 0; n < ticks; ++n) {
    rig.position_m += Vec3(0.0, speed_m_per_s * dt_s, 0.0);
    rig.tick({force_N, 0.0, 0.0});
  }
  EXPECT_TRUE(rig.governor.status().trips == 0 ||
              rig.governor.status().trip.reason == TripReason::kSpeed);
  return rig.governor.status().trips > 0;
}

TEST(SafetyGovernor, TripsIfTheDeviceIsTooFastWhileItPushes) {
  for (const double dt_s : {1e-2, 1e-3, 1e-4, 2e-5}) {
    EXPECT_TRUE(trips_at(1.55, 2.0, dt_s)) << dt_s;
    EXPECT_FALSE(trips_at(1.45, 2.0, dt_s)) << dt_s;
    EXPECT_FALSE(trips_at(5.0, 0.79, dt_s)) << dt_s;  // a tenth of the clamp is 0.8 N
  }
  // One encoder step is no speed: 5 mm in a tick are 1 m/s over the window.
  Rig rig;
  rig.run_in();
  rig.push({2.0, 0.0, 0.0});
  rig.position_m.x() += 5e-3;
  rig.push({2.0, 0.0, 0.0});
  EXPECT_EQ(rig.governor.status().trips, 0u);
  rig.position_m.x() += 8e-3;
  rig.push({2.0, 0.0, 0.0});
  EXPECT_EQ(rig.governor.status().trip.reason, TripReason::kSpeed);
  EXPECT_NEAR(rig.governor.status().trip.value, 1.6, 1e-9);
  EXPECT_EQ(rig.governor.status().trip.limit, 1.5);
  // At 100 Hz, 20 mm in a tick are 1 m/s over the window of two periods.
  Rig slow(motor_device(), {}, 10e-3);
  slow.run_in();
  slow.push({2.0, 0.0, 0.0});
  slow.position_m.x() += 20e-3;
  slow.push({2.0, 0.0, 0.0});
  EXPECT_EQ(slow.governor.status().trips, 0u);
}

// Repeats the same sample for a time, and returns the forces.
std::vector<double> forces_without_new_sample(Rig& rig, double time_s, double force_N) {
  std::vector<double> forces;
  for (int n = 0; n < static_cast<int>(std::lround(time_s / rig.dt_s)); ++n) {
    rig.is_new = false;
    forces.push_back(rig.tick({force_N, 0.0, 0.0}).x());
  }
  return forces;
}

TEST(SafetyGovernor, StopsWhileSamplesAreStaleThenEasesTheForceIn) {
  for (const double dt_s : {1e-3, 5e-3}) {  // 10 ms, and five periods of 5 ms
    Rig rig(motor_device(), {}, dt_s);
    rig.run_in();
    rig.push({2.0, 0.0, 0.0});
    const double stale_s = std::max(10e-3, 5 * dt_s);
    const auto forces = forces_without_new_sample(rig, stale_s + 5 * dt_s, 2.0);
    for (std::size_t n = 0; n < forces.size(); ++n) {
      const double age_s = dt_s * static_cast<double>(n + 1);
      EXPECT_EQ(forces[n], age_s > stale_s + 1e-9 ? 0.0 : 2.0) << age_s;
    }
    EXPECT_EQ(rules_of(rig.record) & kRuleStale, std::uint32_t{kRuleStale});
    for (double eased_s = dt_s; eased_s < 0.1 - 1e-9; eased_s += dt_s) {
      expect_scaled(rig.tick({2.0, 0.0, 0.0}), {2.0, 0.0, 0.0}, eased_s / 0.1);
      EXPECT_EQ(rules_of(rig.record), std::uint32_t{kRuleEase});
    }
    rig.tick({2.0, 0.0, 0.0});
    EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}).x(), 2.0);
    EXPECT_EQ(rig.governor.status().trips, 0u);
  }
}

TEST(SafetyGovernor, TripsIfSamplesStayStale) {
  Rig rig;
  rig.run_in();
  rig.push({2.0, 0.0, 0.0});
  forces_without_new_sample(rig, 99e-3, 2.0);
  EXPECT_EQ(rig.governor.status().trips, 0u);
  forces_without_new_sample(rig, 3e-3, 2.0);
  EXPECT_EQ(rig.governor.status().trip.reason, TripReason::kStale);
}

TEST(SafetyGovernor, MeasuresTheAgeOfASampleByItsTime) {
  Rig rig;
  rig.run_in();
  DeviceSample sample;
  sample.sequence = rig.sequence + 1;
  rig.now_ns += 1'000'000;
  sample.time_ns = rig.now_ns - 11'000'000;
  rig.governor.begin_tick(sample, {kPeriod_s, 0, rig.now_ns});
  TickRecord record;
  record.force_device_N[0] = 1.0;
  rig.governor.govern(record);
  EXPECT_EQ(record.force_device_N[0], 0.0);
  EXPECT_NE(record.rules & kRuleStale, 0u);
}

TEST(SafetyGovernor, IgnoresASampleThatIsOlderThanTheLast) {
  Rig rig;
  rig.position_m = {0.01, 0.0, 0.0};
  rig.run_in();
  rig.push({2.0, 0.0, 0.0});
  rig.sequence -= 3;
  rig.position_m = {0.05, 0.0, 0.0};
  EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}).x(), 2.0);
  EXPECT_EQ(rig.used.position_m[0], 0.01);
  EXPECT_EQ(rules_of(rig.record), std::uint32_t{kRuleOrder});
}

TEST(SafetyGovernor, ALateTickEasesInAndAVeryLateOneStartsAgain) {
  struct LateCase {
    double dt_s, late_s;
    bool is_late, starts;
  };
  for (const LateCase& c :
       {LateCase{1e-3, 19e-3, false, false}, LateCase{1e-3, 21e-3, true, false},
        LateCase{1e-3, 49e-3, true, false}, LateCase{1e-3, 51e-3, true, true},
        LateCase{1e-2, 49e-3, false, false}, LateCase{1e-2, 52e-3, true, true}}) {
    Rig rig(motor_device(), {}, c.dt_s);
    rig.run_in();
    rig.push({2.0, 0.0, 0.0});
    rig.late_s = c.late_s;
    EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}).x(), c.is_late ? 0.0 : 2.0) << c.late_s;
    EXPECT_EQ((rig.record.rules & kRuleLate) != 0, c.is_late);
    EXPECT_EQ(rig.governor.status().state, c.starts ? GovernorState::kWaits : GovernorState::kRuns);
    const double next_N = rig.tick({2.0, 0.0, 0.0}).x();
    if (c.starts) {
      EXPECT_EQ(next_N, 0.0);
    }
    if (c.is_late && !c.starts) expect_scaled({next_N, 0, 0}, {2.0, 0.0, 0.0}, c.dt_s / 0.1);
    EXPECT_EQ(rig.governor.status().trips, 0u);
  }
}

// However short a pause is, the next tick has no force, and the force grows by the rule *start*.
TEST(SafetyGovernor, StartsAgainAfterAPause) {
  for (const int ticks : {1, 10, 30, 1000}) {
    Rig rig;
    rig.run_in();
    ASSERT_EQ(rig.push({2.0, 0.0, 0.0}).x(), 2.0);
    rig.position_m.x() = 0.01;
    for (int n = 0; n < ticks; ++n) rig.pause();
    EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}), Vec3(Vec3::Zero())) << ticks;
    EXPECT_EQ(rig.governor.status().state, GovernorState::kWaits);
    EXPECT_EQ(rules_of(rig.record) & ~std::uint32_t{kRuleStart}, 0u) << "the tick is not late";
    EXPECT_EQ(rig.governor.status().given_J, 0.0) << "no force was commanded on the way";
    rig.in_contact = false;
    int calm = 0;
    for (; rig.governor.status().state == GovernorState::kWaits && calm < 200; ++calm) {
      rig.tick(Vec3::Zero());
    }
    EXPECT_GE(calm, 100);
    rig.in_contact = true;
    EXPECT_LT(rig.tick({2.0, 0.0, 0.0}).x(), 0.01);
    EXPECT_EQ(rig.push({2.0, 0.0, 0.0}, 500).x(), 2.0);
  }
}

TEST(SafetyGovernor, ATripOutlastsAPause) {
  Rig rig;
  rig.run_in();
  rig.asks_for_trip = true;
  rig.tick({2.0, 0.0, 0.0});
  rig.asks_for_trip = false;
  rig.pause();
  rig.tick({2.0, 0.0, 0.0});
  EXPECT_EQ(rig.governor.status().state, GovernorState::kTripped);
}

// Trips a rig that pushes along x by a fast motion along y.
void trip_by_speed(Rig& rig, double force_N) {
  for (int n = 0; rig.governor.status().trips == 0 && n < 20; ++n) {
    rig.position_m.y() += 1.6e-3;
    rig.tick({force_N, 0.0, 0.0});
  }
  ASSERT_EQ(rig.governor.status().trip.reason, TripReason::kSpeed);
}

// The hand turns against the force that it had before the trip.
TEST(SafetyGovernor, AReleaseGrowsNoFasterThanAnyForce) {
  Rig rig;
  rig.run_in();
  rig.push({7.5, 0.0, 0.0});
  trip_by_speed(rig, 7.5);
  EXPECT_EQ(rig.tick({7.5, 0.0, 0.0}), Vec3(Vec3::Zero())) << "across the force";
  rig.position_m.x() -= 1e-3;
  expect_scaled(rig.tick({7.5, 0.0, 0.0}), {5.0, 0.0, 0.0}, 1.0);
  EXPECT_NE(rig.record.rules & kRuleRelease, 0u);
  EXPECT_NE(rig.record.rules & kRuleSlew, 0u);
}

// Whatever takes the trust in samples or force ends a release, for good.
TEST(SafetyGovernor, AReleaseEndsWithTheTrustInSamplesAndForce) {
  const std::array<void (*)(Rig&), 5> distrust = {
      [](Rig& rig) { rig.next_faults = kFaultInvalidSample; },
      [](Rig& rig) { rig.next_faults = kFaultNonFiniteForce; },
      [](Rig& rig) { rig.asks_for_trip = true; },
      [](Rig& rig) { rig.late_s = 25e-3; },
      [](Rig&) {},
  };
  for (std::size_t n = 0; n < distrust.size(); ++n) {
    Rig rig;
    rig.run_in();
    rig.push({2.0, 0.0, 0.0});
    rig.position_m.x() -= 8e-3;  // 1.6 m/s over the window, against the force
    EXPECT_LT(0.0, rig.tick({2.0, 0.0, 0.0}).x());
    ASSERT_EQ(rig.governor.status().trip.reason, TripReason::kSpeed);
    rig.position_m.x() -= 1e-3;
    EXPECT_LT(0.0, rig.tick({2.0, 0.0, 0.0}).x());
    const bool is_trusted = n + 1 == distrust.size();
    distrust[n](rig);
    rig.position_m.x() -= 1e-3;
    EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}).x() > 0.0, is_trusted) << n;
    rig.asks_for_trip = false;
    rig.position_m.x() -= 1e-3;
    EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}).x() > 0.0, is_trusted) << n;
  }
}

TEST(SafetyGovernor, AReleaseWarmsNoMotorBeyondItsContinuousForce) {
  DeviceDescription device = motor_device();
  for (MotorDescription& motor : device.motors) motor.continuous_force_N = 1.0;
  Rig rig(device);
  rig.run_in();
  double mean_square = 0.0;
  const auto warm = [&](const Vec3& force_N) {
    mean_square += -std::expm1(-kPeriod_s / 10.0) * (force_N.squaredNorm() - mean_square);
  };
  while (mean_square < 0.955) warm(rig.tick({7.5, 0.0, 0.0}));
  EXPECT_EQ(rules_of(rig.record), 0u);
  rig.position_m.x() -= 8e-3;  // 1.6 m/s over the window, against the force
  warm(rig.tick({7.5, 0.0, 0.0}));
  ASSERT_EQ(rig.governor.status().trip.reason, TripReason::kSpeed);
  std::uint32_t rules = 0;
  for (int n = 0; n < 40; ++n) {
    rig.position_m.x() -= 1e-3;
    warm(rig.tick({7.5, 0.0, 0.0}));
    rules |= rules_of(rig.record);
  }
  EXPECT_EQ(rules & (kRuleRelease | kRuleHeat), std::uint32_t{kRuleRelease | kRuleHeat});
  EXPECT_LE(mean_square, 1.0);
  EXPECT_GT(mean_square, 0.98) << "the hand is not dropped";
}

TEST(SafetyGovernor, FadesTheForceOutsideTheWorkspace) {
  constexpr double kSmall_N = 0.02;  // its work along the workspace is within the budgets
  for (int axis = 0; axis < 3; ++axis) {
    for (const double middle_m : {0.0, 0.07}) {
      DeviceDescription device = motor_device();
      device.workspace_low_m[static_cast<std::size_t>(axis)] += middle_m;
      device.workspace_high_m[static_cast<std::size_t>(axis)] += middle_m;
      Rig rig(device);
      rig.run_in();
      for (const double beyond_m : {-0.125, -0.12, -0.115, -0.11, -0.1, 0.0, 0.1, 0.105, 0.1199}) {
        double& p_m = rig.position_m[axis];
        while (std::abs(p_m - middle_m - beyond_m) > 1e-12) {  // slowly
          p_m += std::clamp(middle_m + beyond_m - p_m, -1e-3, 1e-3);
          rig.tick({kSmall_N, 0.0, 0.0});
        }
        const double factor = std::clamp((0.12 - std::abs(beyond_m)) / 0.02, 0.0, 1.0);
        EXPECT_NEAR(rig.tick({kSmall_N, 0.0, 0.0}).x() / kSmall_N, factor, 1e-9)
            << axis << ' ' << beyond_m;
        EXPECT_EQ((rig.record.rules & kRuleWorkspace) != 0, factor < 1.0 - 1e-9) << beyond_m;
      }
    }
  }
}

TEST(SafetyGovernor, ABadSampleEasesInAndThreeWithin100MillisecondsTrip) {
  for (const std::uint32_t fault :
       {std::uint32_t{kFaultNonFiniteSample}, std::uint32_t{kFaultInvalidSample},
        std::uint32_t{kFaultJump}, std::uint32_t{kFaultFarSample}}) {
    for (const int apart : {1, 49, 50, 51, 60}) {  // ticks between two of three bad samples
      Rig rig;
      rig.run_in();
      rig.push({2.0, 0.0, 0.0});
      for (int bad = 0; bad < 3; ++bad) {
        rig.next_faults = fault;
        EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}).x(), 0.0);
        EXPECT_NE(rig.record.rules & kRuleBadSample, 0u);
        for (int n = 1; n < apart; ++n) {
          const Vec3 force_N = rig.tick({2.0, 0.0, 0.0});
          if (bad < 2) expect_scaled(force_N, {2.0, 0.0, 0.0}, std::min(1.0, n * 0.01));
        }
      }
      EXPECT_EQ(rig.governor.status().trips, apart <= 50 ? 1u : 0u) << apart;
      if (apart <= 50) {
        EXPECT_EQ(rig.governor.status().trip.reason, TripReason::kBadSamples);
        EXPECT_EQ(rig.push({2.0, 0.0, 0.0}).x(), 0.0);
      }
    }
  }
}

TEST(SafetyGovernor, TripsAtAForceThatIsNotFinite) {
  for (const double bad : {kNoNumber, std::numeric_limits<double>::infinity()}) {
    Rig rig;
    rig.run_in();
    EXPECT_EQ(rig.tick({0.0, bad, 0.0}), Vec3(0.0, 0.0, 0.0));
    EXPECT_NE(rig.record.faults & kFaultNonFiniteForce, 0u);
    EXPECT_EQ(rig.governor.status().trip.reason, TripReason::kBadForce);
  }
  Rig rig;
  rig.run_in();
  rig.next_faults = kFaultNonFiniteForce;  // the loop has noticed it
  rig.tick(Vec3::Zero());
  EXPECT_EQ(rig.governor.status().trip.reason, TripReason::kBadForce);
}

TEST(SafetyGovernor, TripsIfTheDeviceAsksForIt) {
  Rig rig;
  rig.run_in();
  rig.push({2.0, 0.0, 0.0});
  rig.asks_for_trip = true;
  EXPECT_EQ(rig.tick({2.0, 0.0, 0.0}).x(), 0.0);
  EXPECT_EQ(rig.governor.status().trip.reason, TripReason::kDevice);
  rig.push({2.0, 0.0, 0.0});
  EXPECT_EQ(rig.governor.status().trips, 1u) << "a trip that lasts counts once";
}

TEST(SafetyGovernor, ATripLastsUntilItIsRearmedAndThenStartsAgain) {
  Rig rig;
  rig.run_in();
  rig.governor.rearm();  // without a trip: nothing
  EXPECT_EQ(rig.push({2.0, 0.0, 0.0}).x(), 2.0);
  rig.tick({kNoNumber, 0.0, 0.0});
  EXPECT_EQ(rig.push({2.0, 0.0, 0.0}, 2000).x(), 0.0);
  EXPECT_EQ(rig.governor.status().trips, 1u);
  rig.late_s = 0.2;  // the start that follows a very late tick does not end it
  rig.push({2.0, 0.0, 0.0});
  EXPECT_EQ(rig.governor.status().state, GovernorState::kTripped);
  rig.governor.rearm();
  EXPECT_EQ(rig.push({2.0, 0.0, 0.0}, 2000).x(), 0.0) << "the hand presses into the wall";
  EXPECT_EQ(rig.push({0.25, 0.0, 0.0}, 700).x(), 0.25);
  EXPECT_EQ(rig.push({2.0, 0.0, 0.0}).x(), 2.0);
}

TEST(SafetyGovernor, StartsOnlyWithACalmHandAndThenSlowly) {
  const auto first_force_tick = [](auto before_tick) {
    Rig rig;
    rig.in_contact = true;
    int n = 0;
    for (; n < 3000; ++n) {
      const double wanted_N = before_tick(rig, n);
      const double force_N = rig.tick({wanted_N, 0.0, 0.0}).x();
      if (force_N > 0.0) break;
    }
    return n;
  };
  // The speed is known after 5 ticks, and the hand must then be calm for 100.
  EXPECT_EQ(first_force_tick([](Rig&, int) { return 0.29; }), 5 + 100);
  EXPECT_EQ(first_force_tick([](Rig&, int) { return 0.31; }), 3000);
  EXPECT_EQ(first_force_tick([](Rig&, int n) { return n == 90 ? 1.0 : 0.2; }), 91 + 100);
  EXPECT_EQ(first_force_tick([](Rig& rig, int n) {
              rig.position_m.x() = n < 200 ? 2.1e-4 * n : 2.1e-4 * 200;  // 0.21 m/s
              return 0.2;
            }),
            201 + 100);  // from 201 on, four of the window's five steps are slow enough
  // Without contact, an effect such as gravity may want any force.
  EXPECT_EQ(first_force_tick([](Rig& rig, int) {
              rig.in_contact = false;
              return 2.0;
            }),
            5 + 100);
  Rig rig;
  rig.push({0.0, 0.0, 0.0}, 5 + 100);
  for (int n = 1; n < 500; ++n) expect_scaled(rig.tick({2.0, 0, 0}), {2.0, 0.0, 0.0}, n / 500.0);
  EXPECT_EQ(rig.push({2.0, 0.0, 0.0}, 2).x(), 2.0);
}

TEST(SafetyGovernor, OfADeviceWithoutMotorsOnlyClampsAndDropsForces) {
  DeviceDescription device = motor_device();
  device.moves_motors = false;
  Rig rig(device);
  rig.in_contact = true;
  EXPECT_EQ(rig.tick({7.5, 0.0, 0.0}), Vec3(7.5, 0.0, 0.0));
  EXPECT_EQ(rig.tick({-7.5, 0.0, 0.0}), Vec3(-7.5, 0.0, 0.0));
  rig.late_s = 1.0;
  rig.position_m = {5.0, 0.0, 0.0};
  EXPECT_EQ(rig.tick({7.5, 0.0, 0.0}), Vec3(7.5, 0.0, 0.0));
  for (int n = 0; n < 500; ++n) rig.is_new = false, rig.tick({7.5, 0.0, 0.0});
  EXPECT_EQ(rig.tick({7.5, 0.0, 0.0}), Vec3(7.5, 0.0, 0.0));
  for (int n = 0; n < 5; ++n) rig.next_faults = kFaultInvalidSample, rig.tick({7.5, 0.0, 0.0});
  EXPECT_EQ(rig.tick({7.5, 0.0, 0.0}), Vec3(7.5, 0.0, 0.0));
  EXPECT_EQ(rules_of(rig.record), 0u);
  expect_scaled(rig.tick({9.0, 0.0, 0.0}), {8.0, 0.0, 0.0}, 1.0);
  EXPECT_EQ(rig.tick({kNoNumber, 0.0, 0.0}), Vec3(0.0, 0.0, 0.0));
  EXPECT_EQ(rig.governor.status().trips, 0u);
  device.motor_count = 0;  // a recorded path: nothing is known
  device.peak_force_N = 0.0;
  Rig path(device);
  EXPECT_EQ(path.tick({900.0, 20.0, 0.0}), Vec3(900.0, 20.0, 0.0));
}

// What the delay makes of a vibration does not swing by itself, whatever the hand does.
TEST(SafetyGovernor, DoesNotDampAVibrationWithinItsBudget) {
  constexpr double kVibration_rad_per_s = 2.0 * std::numbers::pi * 100.0;
  for (int n = 0; n < 8; ++n) {
    Rig rig;
    rig.run_in();
    for (int k = 0; k < 300; ++k) {
      const double phase = kVibration_rad_per_s * kPeriod_s * k;
      rig.position_m.x() = 0.2e-3 * std::sin(phase + n * std::numbers::pi / 4.0);
      const Vec3 force_N(0.5 * std::sin(phase), 0.0, 0.0);
      rig.sources.has_effects = true;
      rig.sources.effects_N[0] = force_N;
      EXPECT_EQ(rig.tick(force_N), force_N);
      ASSERT_EQ(rig.record.rules & kRuleDamping, 0u) << n << ' ' << k;
    }
  }
}

// The work that the motors give, and what masking gives by design: the hand of
// docs/inside/haptics.md.
TEST(SafetyGovernor, SumsTheWorkThatMissingMotorsGive) {
  constexpr double kStiffness_N_per_m = 100.0;
  constexpr double kDepth_m = 5e-3;
  DeviceDescription device = motor_device();
  device.motor_count = 1;  // along x
  Rig rig(device);
  rig.run_in();
  const double a = 0.7;
  const Vec3 normal(std::cos(a), std::sin(a), 0.0);
  constexpr int kSteps = 1000;
  for (int n = 0; n <= kSteps; ++n) {  // presses at the angle a
    const double depth_m = kDepth_m * n / kSteps;
    rig.position_m = -depth_m * normal;
    rig.tick(kStiffness_N_per_m * depth_m * normal);
  }
  // A4 turns the scene until the normal lies along x; the hand lets go along it.
  const Vec3 pressed_m = rig.position_m;
  for (int n = kSteps; n >= 0; --n) {
    const double depth_m = kDepth_m * n / kSteps;
    rig.position_m = pressed_m + Vec3(kDepth_m - depth_m, 0.0, 0.0);
    rig.tick({kStiffness_N_per_m * depth_m, 0.0, 0.0});
  }
  const double full_J = 0.5 * kStiffness_N_per_m * kDepth_m * kDepth_m;
  const double given_J = full_J * std::sin(a) * std::sin(a);
  EXPECT_NEAR(rig.governor.status().given_J, given_J, 2.0 / kSteps * full_J);
  EXPECT_NEAR(rig.governor.status().given_by_design_J, given_J, 2.0 / kSteps * full_J);
}

}  // namespace
}  // namespace palpate
