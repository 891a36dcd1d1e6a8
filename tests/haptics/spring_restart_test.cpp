// A spring never gives back more than the hand has put in, but for the tank.

#include "haptics/spring_restart.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kRestartStep_s = 1e-3;

// A hand in a spring along one axis, and the energy of the force, without delay and hold.
class Spring {
 public:
  // Moves to a depth. The work between two ticks is that of the mean of both forces: a force that
  // changes evenly.
  double move_to(double depth_m) {
    tick_.way_m = std::abs(depth_m - depth_m_);
    tick_.spring_N = std::max(0.0, stiffness_N_per_m * (depth_m - node_m));
    tick_.stiffness_N_per_m = stiffness_N_per_m;
    tick_.step_s = kRestartStep_s;
    tick_.work_J = force_N_ * (depth_m - depth_m_);
    const double factor = restart_.factor(tick_);
    force_N = tick_.is_interrupted ? 0.0 : factor * tick_.spring_N;
    given_J += 0.5 * (force_N_ + force_N) * (depth_m_ - depth_m);
    force_N_ = force_N;
    depth_m_ = depth_m;
    tick_.is_interrupted = tick_.is_gap = tick_.nodes_moved = false;
    return force_N;
  }
  void press(double depth_m, int ticks = 200) {
    const double from_m = depth_m_;
    for (int n = 1; n <= ticks; ++n) move_to(from_m + (depth_m - from_m) * n / ticks);
  }
  // Ticks without a force, while the hand moves on to a depth.
  void interrupt(double depth_m, int ticks) {
    const double from_m = depth_m_;
    for (int n = 1; n <= ticks; ++n) {
      tick_.is_interrupted = true;
      move_to(from_m + (depth_m - from_m) * n / ticks);
    }
  }
  SpringRestart::Tick& next() { return tick_; }
  double withheld_N() const { return restart_.withheld_N(); }

  double stiffness_N_per_m = 1000.0;
  double node_m = 0.0;  // the depth of the surface
  double force_N = 0.0;
  double given_J = 0.0;  // to the hand, since the beginning

 private:
  SpringRestart restart_;
  SpringRestart::Tick tick_;
  double depth_m_ = 0.0;
  double force_N_ = 0.0;
};

TEST(SpringRestart, WithholdsNothingFromAHandThatMovesByItself) {
  Random random(4);
  Spring spring;
  double depth_m = 0.0, rate = 0.0;
  for (int n = 0; n < 20'000; ++n) {
    rate = 0.98 * rate + random.uniform(-1e-5, 1e-5);
    depth_m = std::clamp(depth_m + rate, -0.002, 0.02);
    EXPECT_EQ(spring.move_to(depth_m), std::max(0.0, 1000.0 * depth_m)) << n;
  }
}

// The hand falls in without a force, and lets go.
TEST(SpringRestart, GivesBackAtMostWhatWasStoredAfterAnInterruption) {
  Random random(5);
  for (int n = 0; n < 1000; ++n) {
    Spring spring;
    spring.stiffness_N_per_m = random.uniform(100.0, 3000.0);
    const double pressed_m = random.uniform(1.0, 10.0) / spring.stiffness_N_per_m;
    spring.press(pressed_m);
    const double stored_J = -spring.given_J;
    const double fallen_m = pressed_m + random.uniform(0.0, 0.04);
    spring.interrupt(fallen_m, 1 + static_cast<int>(random.index(90)));
    const double before_J = spring.given_J;
    // It waits for a while, may press on, and lets go.
    for (int k = 0; k < static_cast<int>(random.index(200)); ++k) spring.move_to(fallen_m);
    const double deeper_m = fallen_m + (random.index(2) == 0 ? 0.0 : random.uniform(0.0, 0.01));
    spring.press(deeper_m, 50);
    spring.press(-0.001, 300);
    EXPECT_LE(spring.given_J - before_J, stored_J + SpringRestart::kTank_J + 1e-9) << n;
    EXPECT_EQ(spring.force_N, 0.0);
    spring.press(pressed_m);
    EXPECT_EQ(spring.withheld_N(), 0.0) << "a new contact is whole";
  }
}

TEST(SpringRestart, ReturnsTheForceOfBeforeWithin100Milliseconds) {
  Spring spring;
  spring.press(5e-3);
  spring.interrupt(6e-3, 12);
  for (int n = 0; n < 101; ++n) spring.move_to(6e-3);
  // The force of before, and what the tank pays: f u + u^2 / 2 = K E.
  EXPECT_GE(spring.force_N, 5.0 - 1e-9);
  EXPECT_LE(spring.force_N, std::sqrt(25.0 + 2.0 * 1000.0 * SpringRestart::kTank_J) + 1e-9);
  const double before_N = spring.force_N;
  spring.press(7e-3, 10);
  EXPECT_NEAR(spring.force_N - before_N, 1.0, 1e-9) << "further pressing meets the full stiffness";
}

// The force grows by nothing but the tank and the returning force: 1 % of it in the first tick.
TEST(SpringRestart, AWayWithoutAForceStoresNothing) {
  Spring spring;
  spring.press(5e-3);
  spring.interrupt(5e-3, 12);
  const double most_N = std::sqrt(2.0 * 1000.0 * SpringRestart::kTank_J) + 0.01 * 5.0;
  EXPECT_LE(spring.move_to(25e-3), most_N + 1e-9);
}

TEST(SpringRestart, TheStartFollowsAHandThatRetreats) {
  Spring spring;
  spring.interrupt(10e-3, 12);
  EXPECT_EQ(spring.move_to(10e-3), 0.0);
  spring.press(2e-3);
  EXPECT_EQ(spring.force_N, 0.0);
  spring.press(5e-3);
  EXPECT_NEAR(spring.force_N, 3.0, 1e-9);
}

TEST(SpringRestart, WhatAStartHoldsBackStaysWithheld) {
  for (const double share : {0.0, 0.3, 0.7}) {
    Spring spring;
    spring.next().share = share;
    spring.press(5e-3);
    spring.next().share = 1.0;
    EXPECT_NEAR(spring.move_to(5e-3), share * 5.0, 1e-9);
    spring.press(6e-3);
    EXPECT_NEAR(spring.force_N, share * 5.0 + 1.0, 1e-9);
  }
}

TEST(SpringRestart, AJumpOfANodeAStepOfStiffnessAndAStartGiveAtMostTheTank) {
  Random random(6);
  for (int n = 0; n < 1000; ++n) {
    Spring spring;
    spring.stiffness_N_per_m = random.uniform(100.0, 1000.0);
    const double pressed_m = random.uniform(0.5, 10.0) / spring.stiffness_N_per_m;
    if (n % 3 == 2) spring.next().share = 0.0;
    spring.press(pressed_m);
    const double stored_J = -spring.given_J;
    switch (n % 3) {
      case 0:
        spring.node_m = -random.uniform(0.0, 0.02);
        spring.next().nodes_moved = true;
        break;
      case 1:
        spring.stiffness_N_per_m *= random.uniform(1.0, 10.0);
        break;
      case 2:
        spring.next().share = 1.0;
        break;
    }
    spring.move_to(pressed_m);
    const double before_J = spring.given_J;
    spring.press(spring.node_m - 0.001, 300);
    EXPECT_LE(spring.given_J - before_J, stored_J + SpringRestart::kTank_J +
                                             SpringRestart::kNodePower_W * kRestartStep_s + 1e-9)
        << n;
  }
}

// A node that moves steadily pushes a hand that holds still, within its power.
TEST(SpringRestart, ANodeThatMovesSteadilyPushesWithItsPower) {
  Spring spring;
  spring.press(1e-3);
  double stored_J = 0.0;
  constexpr int kPushed = 500;
  for (int n = 0; n < kPushed; ++n) {
    spring.node_m -= 20e-6;  // 20 mm/s
    spring.next().nodes_moved = true;
    spring.move_to(1e-3);
    const double was_J = stored_J;
    stored_J = 0.5 * spring.force_N * spring.force_N / spring.stiffness_N_per_m;
    EXPECT_LE(stored_J - was_J,
              SpringRestart::kTank_J + SpringRestart::kNodePower_W * kRestartStep_s);
  }
  EXPECT_GT(spring.force_N, 5.0) << "it pushes";
  const double most_J =
      0.5e-3 + SpringRestart::kTank_J + SpringRestart::kNodePower_W * kPushed * kRestartStep_s;
  EXPECT_LE(stored_J, most_J + 1e-9);
}

}  // namespace
}  // namespace palpate
