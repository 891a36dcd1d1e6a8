// The rule *heat* within the governor: what a pause, and what damping, do to the motors' heat.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>

#include "haptics/motor_heat.h"
#include "haptics/record_vectors.h"
#include "haptics/safety_governor.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

constexpr std::int64_t kHeatTick_ns = 1'000'000;

// A motor of 8 N along x, of which it bears a part for ever. 0: unknown.
DeviceDescription warm_device(double continuous_N) {
  DeviceDescription device;
  device.name = "a motor that becomes warm";
  device.motor_count = 1;
  device.motors[0].direction_device = {1.0, 0.0, 0.0};
  device.motors[0].peak_force_N = 8.0;
  device.motors[0].continuous_force_N = continuous_N;
  device.peak_force_N = 8.0;
  device.mass_kg = 0.1;
  device.damping_Ns_per_m = 0.5;
  device.delay = {1e-3, 1e-3};
  return device;
}

// A hand at a governed motor, in real time. The force is a stiff spring towards x = 0: with a
// delay, a hand that moves to and fro makes the controller damp.
class WarmHand {
 public:
  explicit WarmHand(double stiffness_N_per_m, double continuous_N = 2.0)
      : governor_(warm_device(continuous_N),
                  SafetyGovernor::clamp_of(warm_device(continuous_N), {})),
        stiffness_N_per_m_(stiffness_N_per_m) {
    for (int n = 0; n < 1000; ++n) tick(0.0);  // the rule *start* passes
  }

  // The commanded force at a position, N.
  double tick(double x_m) {
    now_ns_ += kHeatTick_ns;
    ++sample_.sequence;
    sample_.position_m = {x_m, 0.0, 0.0};
    governor_.begin_tick(sample_, {1e-3, 0, now_ns_});
    record_.device_m[0] = x_m;
    record_.contact = x_m < 0.0 ? 1 : 0;
    const Vec3 force_N(-stiffness_N_per_m_ * std::min(0.0, x_m), 0.0, 0.0);
    put(force_N, record_.full_force_device_N);
    put(force_N, record_.force_device_N);
    ForceSources sources;
    if (x_m < 0.0) sources = {stiffness_N_per_m_, -x_m};
    governor_.govern(record_, sources);
    return record_.force_device_N[0];
  }
  void pause(int ticks) {
    for (int n = 0; n < ticks; ++n) {
      now_ns_ += kHeatTick_ns;
      governor_.pause();
    }
  }
  std::uint32_t rules() const { return record_.rules; }

 private:
  SafetyGovernor governor_;
  double stiffness_N_per_m_;
  DeviceSample sample_;
  TickRecord record_;
  std::int64_t now_ns_ = kHeatTick_ns;
};

constexpr double kWarmDepth_m = 0.06;
constexpr int kPressTicks = 200;  // ticks: 0.3 m/s

// Presses with 6 N. Returns the ticks until the rule *heat* acts.
int ticks_until_warm(WarmHand& hand) {
  for (int n = 1; n <= 20'000; ++n) {
    hand.tick(-kWarmDepth_m * std::min(n, kPressTicks) / kPressTicks);
    if (hand.rules() & kRuleHeat) return n;
  }
  return 0;
}
void keep_warm_and_let_go(WarmHand& hand) {
  for (int n = 0; n < 20'000; ++n) hand.tick(-kWarmDepth_m);
  for (int n = kPressTicks; n >= 0; --n) hand.tick(-kWarmDepth_m * n / kPressTicks);
}

// A press of 6 N, a load of 3, warms a cold motor in about 1 s. After a pause of two time
// constants, e^-2 = 0.135 of the mean square is left, and the press lasts nearly as long.
TEST(GovernorHeat, MotorsCoolInAPauseByItsTime) {
  WarmHand hand(100.0);
  const int cold = ticks_until_warm(hand);
  ASSERT_GT(cold, 0);
  keep_warm_and_let_go(hand);
  hand.pause(100);
  for (int n = 0; n < 1000; ++n) hand.tick(0.0);
  const int warm = ticks_until_warm(hand);
  EXPECT_GT(warm, 0);
  EXPECT_LT(warm, cold / 2);
  keep_warm_and_let_go(hand);
  hand.pause(20'000);
  for (int n = 0; n < 1000; ++n) hand.tick(0.0);
  EXPECT_GT(ticks_until_warm(hand), 3 * cold / 4);
}

// The mean square of what is commanded, damping included, never exceeds that of 2 N.
TEST(GovernorHeat, DampingDoesNotHeatAMotorBeyondItsContinuousForce) {
  test::Random random(4949);
  int damped = 0;
  for (int run = 0; run < 20; ++run) {
    const double frequency_Hz = random.uniform(15.0, 40.0);
    const double depth_m = random.uniform(0.001, 0.004);
    const double swing_m = depth_m * random.uniform(0.5, 1.2);
    WarmHand hand(2000.0);
    double mean_square_N2 = 0.0;
    const double share = warming_share(kHeatTick_ns);
    for (int n = 0; n < 10'000; ++n) {
      const double time_s = 1e-3 * n;
      const double ramp = std::min(1.0, time_s);
      const double force_N = hand.tick(
          -ramp * (depth_m + swing_m * std::sin(2.0 * std::numbers::pi * frequency_Hz * time_s)));
      if (hand.rules() & kRuleDamping) ++damped;
      mean_square_N2 += share * (force_N * force_N - mean_square_N2);
      ASSERT_LE(std::sqrt(mean_square_N2), 1.02 * 2.0) << "run " << run << ", tick " << n;
    }
  }
  EXPECT_GT(damped, 1000);
}

// Light forces, damping included, are the same for a warm motor and for one without a limit.
TEST(GovernorHeat, AWarmMotorGivesALightForceWhole) {
  WarmHand warm(2000.0), other(2000.0, 0.0);
  for (int n = 0; n < 20'000; ++n) {  // 6 N
    warm.tick(-3e-3);
    other.tick(-3e-3);
  }
  EXPECT_NE(warm.rules() & kRuleHeat, 0u);
  int damped = 0;
  for (WarmHand* hand : {&warm, &other}) {
    hand->pause(1);
    for (int n = 0; n < 1000; ++n) hand->tick(0.0);
  }
  for (int n = 0; n < 5000; ++n) {
    const double x_m = -1e-4 - 1e-4 * std::sin(2.0 * std::numbers::pi * 40.0 * 1e-3 * n);
    ASSERT_EQ(warm.tick(x_m), other.tick(x_m)) << n;
    damped += (warm.rules() & kRuleDamping) != 0;
  }
  EXPECT_GT(damped, 100);
}

}  // namespace
}  // namespace palpate
