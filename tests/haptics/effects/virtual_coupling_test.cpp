#include "haptics/effects/virtual_coupling.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::kTick_s;
using test::Random;

// The error relative to the largest term of the force: four roundings per component.
constexpr double kForceRoundoff = 8 * std::numeric_limits<double>::epsilon();

struct RandomCoupling {
  CouplingSettings settings;
  VirtualCoupling coupling;
};

// A coupling whose damper acts on the whole lag, on any surface.
Vec3 whole_force_N(VirtualCoupling& coupling, const Vec3& lag_m, const Vec3& normal, double dt_s) {
  const Vec3 rate = coupling.lag_rate_m_per_s(lag_m, dt_s);
  return coupling.force_N(lag_m, rate, normal);
}

RandomCoupling random_coupling(Random& random) {
  const double stiffness = std::pow(10.0, random.uniform(0.0, 4.0));
  const CouplingSettings settings{stiffness, std::pow(10.0, random.uniform(-2.0, 1.0))};
  return {settings, VirtualCoupling(settings)};
}

TEST(VirtualCoupling, IsASpringAloneInTheFirstTickOfAContact) {
  Random random(3201);
  for (int i = 0; i < 1000; ++i) {
    auto [settings, coupling] = random_coupling(random);
    for (int contact = 0; contact < 3; ++contact) {
      const Vec3 lag_m = random.in_box(0.01);
      ASSERT_EQ(whole_force_N(coupling, lag_m, lag_m.normalized(), kTick_s),
                Vec3(settings.stiffness_N_per_m * lag_m));
      whole_force_N(coupling, random.in_box(0.01), Vec3::Zero(), kTick_s);
      coupling.reset();
    }
  }
}

TEST(VirtualCoupling, DampsByTheBackwardDifferenceOfTheLag) {
  Random random(3202);
  for (int i = 0; i < 1000; ++i) {
    auto [settings, coupling] = random_coupling(random);
    Vec3 last_m = random.in_box(0.01);
    whole_force_N(coupling, last_m, Vec3::Zero(), kTick_s);
    for (int tick = 0; tick < 5; ++tick) {
      const Vec3 lag_m = random.in_box(0.01);
      const double dt_s = random.uniform(1e-4, 1e-2);
      const Vec3 spring = settings.stiffness_N_per_m * lag_m;
      const Vec3 damper = settings.damping_Ns_per_m / dt_s * (lag_m - last_m);
      // The damper uses the difference of the last two ticks, never an earlier one.
      const Vec3 force = whole_force_N(coupling, lag_m, Vec3::Zero(), dt_s);
      ASSERT_LE((force - (spring + damper)).norm(),
                kForceRoundoff * (spring.norm() + damper.norm()));
      last_m = lag_m;
    }
  }
}

TEST(VirtualCoupling, UsesTheBackwardDifferenceForAWindowOfOneTickWithAnyMethod) {
  Random random(3205);
  for (const VelocityMethod method :
       {VelocityMethod::kDifference, VelocityMethod::kLineFit, VelocityMethod::kAdaptive}) {
    VirtualCoupling coupling({1000.0, 2.0, {method, 1, 1e-5}});
    Vec3 last_m = random.in_box(0.01);
    ASSERT_EQ(coupling.lag_rate_m_per_s(last_m, kTick_s), Vec3(Vec3::Zero()));
    for (int tick = 0; tick < 1000; ++tick) {
      const Vec3 lag_m = random.in_box(0.01);
      const double dt_s = random.uniform(1e-4, 1e-2);
      ASSERT_EQ(coupling.lag_rate_m_per_s(lag_m, dt_s), Vec3((lag_m - last_m) / dt_s));
      last_m = lag_m;
    }
  }
}

TEST(VirtualCoupling, DampsByTheEstimateOfItsSettings) {
  Random random(3206);
  for (const VelocityMethod method :
       {VelocityMethod::kDifference, VelocityMethod::kLineFit, VelocityMethod::kAdaptive}) {
    const VelocitySettings velocity{method, 8, 1e-3};
    VirtualCoupling coupling({1000.0, 2.0, velocity});
    for (int contact = 0; contact < 10; ++contact) {
      VelocityEstimator estimator(velocity);
      for (int tick = 0; tick < 30; ++tick) {
        const Vec3 lag_m = random.in_box(0.01);
        ASSERT_EQ(coupling.lag_rate_m_per_s(lag_m, kTick_s), estimator.add(lag_m, kTick_s));
      }
      coupling.reset();
    }
  }
}

TEST(VirtualCoupling, NeverPullsIntoTheSurface) {
  Random random(3203);
  int would_have_pulled = 0;
  for (int i = 0; i < 1000; ++i) {
    auto [settings, coupling] = random_coupling(random);
    Vec3 last_m = Vec3::Zero();
    for (int tick = 0; tick < 5; ++tick) {
      const Vec3 normal = random.unit_vector();
      const Vec3 lag_m = random.uniform(0.0, 0.01) * normal;
      const Vec3 spring = settings.stiffness_N_per_m * lag_m;
      const Vec3 damper = settings.damping_Ns_per_m / kTick_s * (lag_m - last_m);
      const Vec3 unclamped = tick == 0 ? spring : Vec3(spring + damper);
      const double rounding = kForceRoundoff * (spring.norm() + damper.norm());
      const Vec3 force = whole_force_N(coupling, lag_m, normal, kTick_s);
      ASSERT_GE(force.dot(normal), -rounding);
      ASSERT_LE(std::abs(force.dot(normal) - std::max(0.0, unclamped.dot(normal))), rounding);
      // The removed part is along the normal only.
      ASSERT_LE((force - unclamped).cross(normal).norm(), rounding);
      would_have_pulled += unclamped.dot(normal) < 0.0;
      last_m = lag_m;
    }
  }
  EXPECT_GT(would_have_pulled, 100);
}

TEST(VirtualCoupling, DoesNotChangeTheForceWhereNormalsCancel) {
  VirtualCoupling coupling({1000.0, 2.0});
  whole_force_N(coupling, {0.004, 0, 0}, Vec3::Zero(), kTick_s);
  const Vec3 force = whole_force_N(coupling, {0.001, 0, 0}, Vec3::Zero(), kTick_s);
  EXPECT_DOUBLE_EQ(force.x(), 1.0 - 6.0);
}

TEST(VirtualCoupling, IsASpringWithoutDamping) {
  Random random(3204);
  VirtualCoupling coupling({500.0, 0.0});
  for (int tick = 0; tick < 100; ++tick) {
    const Vec3 lag_m = random.in_box(0.01);
    EXPECT_EQ(whole_force_N(coupling, lag_m, Vec3::Zero(), kTick_s), Vec3(500.0 * lag_m));
  }
}

}  // namespace
}  // namespace palpate
