// Stiffness limits, compared with simulated closed loops and with the published criteria.

#include "engine/devices/stability_limits.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <deque>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "engine/simulation/mass_damper.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A device, a coupling and a servo with realistic values.
struct Case {
  DeviceMechanics device;
  double coupling_damping = 0.0;
  ServoTiming timing;

  static Case draw(Random& random, bool held) {
    Case c;
    c.device.mass_kg = random.uniform(0.05, 0.5);
    c.device.damping_Ns_per_m = random.uniform(0.2, 3.0);
    if (held) {
      c.device.hand = HandImpedance{random.uniform(0.0, 0.6), random.uniform(0.0, 8.0),
                                    random.uniform(0.0, 300.0)};
    }
    c.coupling_damping = random.uniform(0.0, 3.0);
    c.timing.period_s = random.uniform(0.1e-3, 2e-3);
    c.timing.delay_s = static_cast<double>(random.index(4)) * c.timing.period_s;
    return c;
  }
  StabilityLimits limits() const {
    return stability_limits(device, coupling_damping, timing).value();
  }
};

// The closed loop, one axis: a list of forces with the times at which each begins to act.
// MassDamper has no spring; with a hand the classical Runge-Kutta method advances the plant in
// steps so short that its error is below rounding.
class ClosedLoop {
 public:
  ClosedLoop(const Case& c, double stiffness_N_per_m)
      : case_(c),
        stiffness_N_per_m_(stiffness_N_per_m),
        plant_(c.device.mass_kg, c.device.damping_Ns_per_m),
        before_m_(static_cast<std::size_t>(c.timing.velocity_ticks), 1e-6) {
    plant_.put({1e-6, 0.0, 0.0}, Vec3::Zero());
  }

  double tick() {
    const double T = case_.timing.period_s;
    const double change_m = at_m_ - before_m_.front();
    before_m_.pop_front();
    before_m_.push_back(at_m_);
    coming_.push_back({time_s_ + case_.timing.delay_s,
                       -stiffness_N_per_m_ * at_m_ -
                           case_.coupling_damping * change_m / (T * case_.timing.velocity_ticks)});
    const double end_s = ++ticks_ * T;
    while (!coming_.empty() && coming_.front().begin_s < end_s) {
      advance_to(coming_.front().begin_s);
      force_N_ = coming_.front().force_N;
      coming_.pop_front();
    }
    advance_to(end_s);
    return std::abs(at_m_);
  }

 private:
  static constexpr int kCuts = 8;

  struct Coming {
    double begin_s, force_N;
  };

  void advance_to(double time_s) {
    const double dt_s = std::max(0.0, time_s - time_s_);
    time_s_ = time_s;
    if (dt_s == 0.0) return;
    if (case_.device.hand) {
      for (int i = 0; i < kCuts; ++i) runge_kutta(force_N_, dt_s / kCuts);
    } else {
      plant_.advance({force_N_, 0.0, 0.0}, dt_s);
      at_m_ = plant_.position_m().x();
    }
  }

  void runge_kutta(double force_N, double dt_s) {
    const HandImpedance& hand = *case_.device.hand;
    const auto pull = [&](double x, double v) {
      const double damping = case_.device.damping_Ns_per_m + hand.damping_Ns_per_m;
      return (force_N - damping * v - hand.stiffness_N_per_m * x) /
             (case_.device.mass_kg + hand.mass_kg);
    };
    const double v1 = speed_, a1 = pull(at_m_, v1);
    const double v2 = speed_ + 0.5 * dt_s * a1, a2 = pull(at_m_ + 0.5 * dt_s * v1, v2);
    const double v3 = speed_ + 0.5 * dt_s * a2, a3 = pull(at_m_ + 0.5 * dt_s * v2, v3);
    const double v4 = speed_ + dt_s * a3, a4 = pull(at_m_ + dt_s * v3, v4);
    at_m_ += dt_s / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    speed_ += dt_s / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }

  const Case& case_;
  double stiffness_N_per_m_;
  MassDamper plant_;
  double time_s_ = 0.0;
  int ticks_ = 0;
  double at_m_ = 1e-6;
  double speed_ = 0.0;
  double force_N_ = 0.0;
  std::deque<double> before_m_;
  std::deque<Coming> coming_;
};

// Factor of the amplitude from one window to the next. At 5 % from the limit a twentieth of the
// damping is missing or in excess, so the amplitude changes by a factor e within 2 m / (b / 20).
// The first window is left out: other modes decay in it.
double growth(const Case& c, double stiffness_N_per_m) {
  const HandImpedance hand = c.device.hand.value_or(HandImpedance{0.0, 0.0, 0.0});
  const double mass = c.device.mass_kg + hand.mass_kg;
  const double damping = c.device.damping_Ns_per_m + hand.damping_Ns_per_m + c.coupling_damping;
  const double window_s = 2.0 * mass / (0.05 * damping);
  const auto ticks = static_cast<int>(window_s / c.timing.period_s);
  ClosedLoop loop(c, stiffness_N_per_m);
  double amplitude_m[3] = {};
  for (double& largest : amplitude_m) {
    for (int n = 0; n < ticks; ++n) largest = std::max(largest, loop.tick());
  }
  return amplitude_m[2] / amplitude_m[1];
}

TEST(StabilityLimits, HaveTheExpectedValuesForALightDeviceAtOneKilohertz) {
  const StabilityLimits limits = stability_limits({0.1, 0.5}, 1.0, {1e-3}).value();
  EXPECT_NEAR(limits.stable_N_per_m, 2972.7, 0.05);
  EXPECT_DOUBLE_EQ(limits.stable_first_order_N_per_m, 3000.0);
  EXPECT_TRUE(limits.is_stable(2972.0));
  EXPECT_FALSE(limits.is_stable(2973.0));
}

TEST(StabilityLimits, SeparateDecayingFromGrowingLoops) {
  Random random(1601);
  int held = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Case c = Case::draw(random, trial % 2 == 1);
    const StabilityLimits limits = c.limits();
    if (limits.stable_N_per_m == 0.0) continue;
    EXPECT_LT(growth(c, 0.95 * limits.stable_N_per_m), 1.0) << "trial " << trial;
    EXPECT_GT(growth(c, 1.05 * limits.stable_N_per_m), 1.0) << "trial " << trial;
    held += c.device.hand.has_value();
  }
  EXPECT_GT(held, 50);
}

TEST(StabilityLimits, HaveASpectralRadiusOfOne) {
  Random random(1602);
  for (int trial = 0; trial < 200; ++trial) {
    const Case c = Case::draw(random, trial % 2 == 1);
    const double limit = c.limits().stable_N_per_m;
    if (limit == 0.0) continue;
    const auto radius = [&](double stiffness) {
      return spectral_radius(c.device, {stiffness, c.coupling_damping}, c.timing);
    };
    EXPECT_NEAR(radius(limit), 1.0, 1e-12);
    EXPECT_LT(radius(0.9 * limit), 1.0);
    EXPECT_GT(radius(1.1 * limit), 1.0);
  }
}

// Without a wall a tick is the plant alone: e^(s T), s the slower root of m s^2 + b s + k.
TEST(StabilityLimits, HaveTheSpectralRadiusOfThePlantWithoutAWall) {
  Random random(1606);
  int overdamped = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Case c = Case::draw(random, true);
    HandImpedance& hand = *c.device.hand;
    hand.damping_Ns_per_m = random.uniform(0.0, 50.0);
    const std::complex<double> m = c.device.mass_kg + hand.mass_kg;
    const std::complex<double> b = c.device.damping_Ns_per_m + hand.damping_Ns_per_m;
    const std::complex<double> root = std::sqrt(b * b - 4.0 * m * hand.stiffness_N_per_m);
    const double rate = ((root - b) / (2.0 * m)).real();
    EXPECT_NEAR(spectral_radius(c.device, {0.0, 0.0}, c.timing), std::exp(rate * c.timing.period_s),
                1e-11);
    overdamped += root.real() > 0.0;
  }
  EXPECT_GT(overdamped, 50);
}

// For a short period the higher orders of w T vanish.
TEST(StabilityLimits, ApproachTheFirstOrderAsThePeriodShrinks) {
  Random random(1603);
  for (int trial = 0; trial < 50; ++trial) {
    Case c = Case::draw(random, trial % 2 == 1);
    const double delay_ticks = std::round(c.timing.delay_s / c.timing.period_s);
    double last_off = kInfinity;
    for (const double period_s : {4e-5, 2e-5, 1e-5, 5e-6}) {
      c.timing = {period_s, delay_ticks * period_s};
      const StabilityLimits limits = c.limits();
      const double off = std::abs(limits.stable_N_per_m / limits.stable_first_order_N_per_m - 1.0);
      EXPECT_LT(off, 0.6 * last_off);
      last_off = off;
    }
    EXPECT_LT(last_off, 0.01);
  }
}

TEST(StabilityLimits, FallAsPeriodAndDelayGrow) {
  Random random(1604);
  for (int trial = 0; trial < 100; ++trial) {
    Case c = Case::draw(random, trial % 2 == 1);
    const StabilityLimits before = c.limits();
    Case slower = c;
    slower.timing.period_s *= random.uniform(1.01, 2.0);
    Case later = c;
    later.timing.delay_s += c.timing.period_s;
    for (const StabilityLimits& after : {slower.limits(), later.limits()}) {
      EXPECT_LE(after.passive_N_per_m, before.passive_N_per_m);
      EXPECT_LT(after.stable_first_order_N_per_m, before.stable_first_order_N_per_m);
      if (before.stable_N_per_m > 0.0) {
        EXPECT_LT(after.stable_N_per_m, before.stable_N_per_m);
      }
    }
  }
}

// Colgate & Schenkel: b > T / 2 / (1 - cos w T) Re((1 - e^-jwT) H(e^jwT)) for all w up to that of
// Nyquist, with H = (K + B (z - 1) / (T z)) z^-d: the maximum of the right side over many w.
double required_damping(const Case& c, double stiffness_N_per_m) {
  const double T = c.timing.period_s;
  double most = -kInfinity;
  for (int i = 1; i <= 20000; ++i) {
    const double angle = std::numbers::pi * i / 20000;
    const std::complex<double> back = std::polar(1.0, -angle);
    const std::complex<double> wall = (stiffness_N_per_m + c.coupling_damping / T * (1.0 - back)) *
                                      std::polar(1.0, -angle * c.timing.delay_s / T);
    most = std::max(most, 0.5 * T / (1.0 - std::cos(angle)) * ((1.0 - back) * wall).real());
  }
  return most;
}

TEST(StabilityLimits, AgreeWithTheCriterionOfPassivity) {
  Random random(1605);
  int checked = 0;
  for (int trial = 0; trial < 100; ++trial) {
    Case c = Case::draw(random, false);
    c.coupling_damping = trial % 2 == 0 ? 0.0 : random.uniform(0.0, c.device.damping_Ns_per_m);
    const double limit = c.limits().passive_N_per_m;
    ASSERT_GT(limit, 0.0);
    EXPECT_LT(required_damping(c, 0.999 * limit), c.device.damping_Ns_per_m);
    // With both a damper and a delay the bound is sufficient, not necessary.
    if (c.coupling_damping > 0.0 && c.timing.delay_s > 0.0) continue;
    EXPECT_GT(required_damping(c, 1.001 * limit), c.device.damping_Ns_per_m);
    ++checked;
  }
  EXPECT_GT(checked, 50);
}

TEST(StabilityLimits, NameTheEncoderAsTheBound) {
  DeviceMechanics device{0.1, 0.5, 20e-6, 5e-3};
  const StabilityLimits coarse = stability_limits(device, 0.0, {1e-3}).value();
  EXPECT_DOUBLE_EQ(coarse.passive_encoder_N_per_m, 500.0);
  EXPECT_DOUBLE_EQ(coarse.passive_sampling_N_per_m, 1000.0);
  EXPECT_DOUBLE_EQ(coarse.passive_N_per_m, 500.0);
  EXPECT_EQ(coarse.passivity_bound, PassivityBound::kEncoder);
  device.encoder_quantum_m = 5e-6;
  const StabilityLimits fine = stability_limits(device, 0.0, {1e-3}).value();
  EXPECT_DOUBLE_EQ(fine.passive_N_per_m, 1000.0);
  EXPECT_EQ(fine.passivity_bound, PassivityBound::kSampling);
  device.encoder_quantum_m = 0.0;
  EXPECT_EQ(stability_limits(device, 0.0, {1e-3})->passive_encoder_N_per_m, kInfinity);
}

// b, B and the rate are decimal numbers that have no exact binary form: a wall at the limit of
// their exact values is passive, and one beyond it by 1e-9 is not. 2 (b - B) / T and 2 f / D are
// computed from whole thousandths.
TEST(StabilityLimits, AWallAtTheLimitIsPassiveHoweverItsNumbersRound) {
  Random random(46);
  for (int trial = 0; trial < 100; ++trial) {
    const int b = 1 + static_cast<int>(random.index(5000));
    const int B = static_cast<int>(random.index(static_cast<std::size_t>(b)));
    const int rate_Hz = 100 + static_cast<int>(random.index(9900));
    const double exact = 2.0 * (b - B) * rate_Hz / 1000.0;
    const double period_s = 1.0 / rate_Hz;
    const auto limits = stability_limits({10.0, b / 1000.0}, B / 1000.0, {period_s});
    ASSERT_TRUE(limits);
    EXPECT_TRUE(limits->is_passive(exact)) << b << " " << B << " " << rate_Hz;
    EXPECT_FALSE(limits->is_passive(exact * (1.0 + 1e-9)));
    EXPECT_TRUE(limits->allows_passive_walls());
  }
  // Three tenths, computed in two ways, leave nothing.
  const auto nothing = stability_limits({10.0, 0.1 + 0.2}, 0.3, {1e-3});
  EXPECT_FALSE(nothing->allows_passive_walls());
  EXPECT_EQ(nothing->passivity_bound, PassivityBound::kDamper);
}

TEST(StabilityLimits, NameTheDamperAsTheBound) {
  const StabilityLimits limits = stability_limits({0.1, 0.5}, 1.0, {1e-3}).value();
  EXPECT_EQ(limits.passive_N_per_m, 0.0);
  EXPECT_EQ(limits.passivity_bound, PassivityBound::kDamper);
  EXPECT_STREQ(name_of(limits.passivity_bound), "damper");
  EXPECT_FALSE(limits.is_passive(0.0));
  EXPECT_TRUE(limits.is_stable(1000.0));
}

TEST(StabilityLimits, AHandChangesStabilityAndNotPassivity) {
  const DeviceMechanics released{0.1, 0.5};
  DeviceMechanics held = released;
  held.hand = HandImpedance{};
  const StabilityLimits alone = stability_limits(released, 0.2, {1e-3}).value();
  const StabilityLimits with_hand = stability_limits(held, 0.2, {1e-3}).value();
  EXPECT_EQ(with_hand.passive_N_per_m, alone.passive_N_per_m);
  EXPECT_GT(with_hand.stable_N_per_m, 5.0 * alone.stable_N_per_m);
}

TEST(StabilityLimits, AreZeroIfNoStiffnessIsStable) {
  EXPECT_EQ(stability_limits({0.1, 0.0}, 0.0, {1e-3})->stable_N_per_m, 0.0);
  // A damper that reverses the velocity within a period.
  EXPECT_EQ(stability_limits({0.1, 0.5}, 500.0, {1e-3})->stable_N_per_m, 0.0);
}

TEST(StabilityLimits, RefuseNumbersOutOfRange) {
  const auto refused = [](const DeviceMechanics& device, double damping,
                          const ServoTiming& timing) {
    const Result<StabilityLimits> limits = stability_limits(device, damping, timing);
    return limits.ok() ? std::string() : limits.error().element;
  };
  EXPECT_EQ(refused({0.0, 0.5}, 0.0, {1e-3}), "mass");
  EXPECT_EQ(refused({0.1, -0.5}, 0.0, {1e-3}), "damping");
  EXPECT_EQ(refused({0.1, 0.5, -1.0}, 0.0, {1e-3}), "encoder quantum");
  EXPECT_EQ(refused({0.1, 0.5, 0.0, kInfinity}, 0.0, {1e-3}), "Coulomb friction");
  EXPECT_EQ(refused({0.1, 0.5, 0.0, 0.0, HandImpedance{-1.0}}, 0.0, {1e-3}), "mass of the hand");
  EXPECT_EQ(refused({0.1, 0.5}, -1.0, {1e-3}), "damping of the coupling");
  EXPECT_EQ(refused({0.1, 0.5}, 0.0, {0.0}), "period");
  EXPECT_EQ(refused({0.1, 0.5}, 0.0, {1e-3, -1e-9}), "delay");
  EXPECT_EQ(refused({0.1, 0.5}, 0.0, {1e-3, 256.001e-3}), "delay");
  EXPECT_EQ(refused({0.1, 0.5}, 0.0, {1e-3, 256e-3}), "");
}

// The search would not end: numbers overflow or lose all digits.
TEST(StabilityLimits, RefuseAPlantWithNegligibleMass) {
  for (const DeviceMechanics& device :
       {DeviceMechanics{1e-300, 0.5}, DeviceMechanics{0.1, 1e300}, DeviceMechanics{1e-20, 0.5}}) {
    const auto limits = stability_limits(device, 0.0, {1e-3, 0});
    ASSERT_FALSE(limits.ok()) << device.mass_kg << " kg, " << device.damping_Ns_per_m << " N s/m";
    EXPECT_EQ(limits.error().element, "mass");
  }
}

// A plant with negligible mass obeys x += T f / b: with f = -K x it is stable below 2 b / T. The
// mass raises the limit by the factor 1 / (1 - 2 m / (b T)).
TEST(StabilityLimits, ApproachThoseOfADamperAsTheMassShrinks) {
  for (const double mass_kg : {1e-6, 1e-8, 1e-10}) {
    const double limit = stability_limits({mass_kg, 0.5}, 0.0, {1e-3, 0}).value().stable_N_per_m;
    const double expected = 2.0 * 0.5 / 1e-3 / (1.0 - 2.0 * mass_kg / (0.5 * 1e-3));
    EXPECT_NEAR(limit, expected, 0x1p-26 * expected) << mass_kg;  // half the digits of double
  }
}

}  // namespace
}  // namespace palpate
