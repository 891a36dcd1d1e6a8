// The force pulse on impact has the right impulse and only brakes.

#include "haptics/effects/restitution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptics/proxy/body_hand.h"

namespace palpate {
namespace {

using test::BodyHand;
using test::effect_entry;
using test::effect_number;
using test::hand_settings;
using test::Random;
using test::square_soup;

constexpr double kDuration_s = 0.005;

BodyHand crisp(double restitution, double mass_kg, const RigidTransform& pose,
               double duration_s = kDuration_s) {
  BodyHand hand({square_soup(0.1)}, pose);
  hand.effects.add_body({effect_entry<RestitutionEffect>({restitution, mass_kg, duration_s})});
  return hand;
}

// The force of the last tick minus the spring's.
double pulse_N(const BodyHand& hand, double depth_m) {
  return hand.force().z() - (depth_m > 0.0 ? 1000.0 * depth_m : 0.0);
}

TEST(Restitution, GivesTheImpulseOfNewtonsLawAtAnyRate) {
  Random random(6601);
  for (const double dt_s : {1e-4, 1e-3, 1.7e-3, 5e-3, 1.2e-2}) {
    for (int run = 0; run < 20; ++run) {
      const double e = random.uniform(0.1, 1.0);
      const double mass = random.uniform(0.01, 0.2);
      const double speed = random.uniform(0.05, 0.5);
      BodyHand hand = crisp(e, mass, random.pose(0.3));
      hand.begin(hand_settings());
      double z = speed * dt_s * random.uniform(2.0, 3.0);
      const double side = random.uniform(-0.2, 0.2);
      double impulse_Ns = 0.0;
      int ticks = 0;
      for (int tick = 0; tick < 5 + 2 * kDuration_s / dt_s; ++tick) {
        hand.go_to({side * dt_s * tick, 0, z}, dt_s);
        const double pulse = pulse_N(hand, -z);
        ASSERT_GE(pulse, -1e-7);
        ASSERT_LE(hand.force().head<2>().norm(), 1e-7);
        if (hand.has_active_effect(effect_number<RestitutionEffect>())) {
          impulse_Ns += pulse * dt_s;
          ++ticks;
          // Half a sine: never above its peak.
          const double crest = std::numbers::pi / 2 / kDuration_s;
          ASSERT_LE(pulse, e * mass * speed * std::min(crest, 1.0 / dt_s) * (1 + 1e-6) + 1e-7);
        } else {
          ASSERT_NEAR(pulse, 0.0, 1e-7);
        }
        z -= speed * dt_s;
      }
      EXPECT_NEAR(impulse_Ns, e * mass * speed, 1e-6 * e * mass * speed);
      EXPECT_EQ(ticks, static_cast<int>(std::ceil(kDuration_s / dt_s - 1e-9)));
    }
  }
}

// A hand with mass is thrown at the surface and bounces. The pulse removes energy. Only in the tick
// in which the hand reverses, its force is held too long. It then returns the energy of that tick's
// motion, which began with less inward speed than the forces reverse within the tick.
TEST(Restitution, OnlyBrakes) {
  Random random(6602);
  constexpr double kDt_s = 1e-3;
  double most_given = 0.0;
  for (int run = 0; run < 300; ++run) {
    const double e = random.uniform(0.1, 1.0);
    const double mass = random.uniform(0.03, 0.2);
    const double K = random.uniform(500.0, 2000.0) * mass / 0.05;
    BodyHand hand = crisp(e, mass * random.uniform(0.1, 1.0), random.pose(0.3));
    hand.begin(hand_settings(K));
    double z = random.uniform(5e-4, 1.5e-3);
    double speed = -random.uniform(0.05, 0.5);
    const double kinetic_J = 0.5 * mass * speed * speed;
    double work_J = 0.0;
    int given_ticks = 0;
    for (int tick = 0; tick < 100; ++tick) {
      hand.go_to({0, 0, z}, kDt_s);
      const double force = hand.force().z();
      speed += force / mass * kDt_s;
      const double step = speed * kDt_s;
      if (hand.has_active_effect(effect_number<RestitutionEffect>())) {
        const double pulse = force - K * -z;
        const double given_J = pulse * step;
        work_J += given_J;
        if (given_J > 0.0) {
          ++given_ticks;
          ASSERT_LE(given_J, pulse * kDt_s * force * kDt_s / mass);
          most_given = std::max(most_given, given_J / kinetic_J);
        }
      }
      z += step;
    }
    EXPECT_LE(given_ticks, 1) << "run " << run;
    EXPECT_LT(work_J, 0.0) << "run " << run;
  }
  std::printf("a held tick gives back %.3f of the kinetic energy at most\n", most_given);
}

TEST(Restitution, PulsesAgainAfterTheSurfaceWasLeft) {
  constexpr double kDt_s = 1e-3;
  const auto number = effect_number<RestitutionEffect>();
  BodyHand hand = crisp(0.8, 0.05, {});
  hand.begin(hand_settings());
  double z = 0.0035;
  const auto move = [&](double speed, int ticks) {
    int active = 0;
    for (int i = 0; i < ticks; ++i) {
      z += speed * kDt_s;
      hand.go_to({0, 0, z}, kDt_s);
      active += hand.has_active_effect(number);
    }
    return active;
  };
  hand.go_to({0, 0, z}, kDt_s);
  EXPECT_EQ(move(-1.0, 3), 0);
  EXPECT_EQ(move(-1.0, 20), 5);  // once, for its duration
  EXPECT_EQ(move(1.0, 20), 0);   // away from the surface, 0.5 mm
  EXPECT_EQ(move(-1.0, 2), 0);   // chatter: the return is too early
  EXPECT_EQ(move(1.0, 10), 0);
  EXPECT_EQ(move(-1.0, 15), 5);  // a second pulse
  // A pulse that ended early because the hand reversed does not continue.
  EXPECT_EQ(move(1.0, 20), 0);
  EXPECT_EQ(move(-1.0, 15), 2);
  EXPECT_EQ(move(1.0, 1), 0);
  EXPECT_EQ(move(-1.0, 3), 0);
}

TEST(Restitution, IsInactiveWhileSliding) {
  Random random(6604);
  constexpr double kDt_s = 1e-3;
  BodyHand hand({test::soup_of(icosphere(3, 0.05))}, random.pose(0.3));
  hand.effects.add_body({effect_entry<RestitutionEffect>({1.0, 0.1, 0.005})});
  hand.begin(hand_settings());
  hand.go_to({0.06, 0, 0}, kDt_s);
  for (int tick = 0; tick < 3000; ++tick) {
    const double angle = 0.01 * tick;
    const double r = 0.048 + 0.001 * std::sin(0.05 * tick);
    hand.go_to({r * std::cos(angle), r * std::sin(angle), 0}, kDt_s);
    ASSERT_TRUE(tick < 10 || !hand.has_active_effect(effect_number<RestitutionEffect>())) << tick;
  }
}

}  // namespace
}  // namespace palpate
