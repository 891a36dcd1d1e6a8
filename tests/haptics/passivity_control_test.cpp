// The governor around a tip in simulated time: a point mass that a light grip presses against a
// spring, with a delay of whole ticks. The loop is the test's own; no scene takes part.

#include "haptics/passivity_control.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iostream>
#include <limits>

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
    // Without friction, rounding keeps a motion of some steps up (Diolaiti et al. 2006).
    EXPECT_LE(calm.swing_m, std::max(1e-4, 4.0 * quantum_m)) << quantum_m;
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

TEST(LargestDamping, IsTheMassOverTwiceTheAgeOfTheVelocity) {
  const AssumedMechanics device{.mass_kg = 0.1, .damping_Ns_per_m = 0.5, .delay = {1e-3, 1e-3}};
  PassivityControl control(device, 0.0);
  control.set_period(1e-3);
  // The delay, the hold and half of a window of two ticks: 3 ms.
  EXPECT_NEAR(control.largest_damping_Ns_per_m(), 0.1 / (2.0 * 3e-3), 1e-12);
}

}  // namespace
}  // namespace palpate
