// The force after a trip: it only resists, and what it gives to a hand is bounded.

#include "haptics/gentle_release.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/motor_limits.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr int kFallTicks = 30;
constexpr double kRound = std::numeric_limits<double>::epsilon();

MotorLimits motors_along(const std::vector<Vec3>& directions) {
  std::vector<MotorDescription> motors(directions.size());
  for (std::size_t i = 0; i < motors.size(); ++i) {
    std::copy_n(directions[i].data(), 3, motors[i].direction_device.begin());
    motors[i].peak_force_N = 20.0;
  }
  return MotorLimits(motors);
}

const MotorLimits& three_motors() {
  static const MotorLimits motors = motors_along({Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()});
  return motors;
}

// A smooth motion: two turning vectors and a drift, some mm, at 0 to 60 Hz.
class RandomMotion {
 public:
  explicit RandomMotion(Random& random)
      : drift_m_per_s_(random.uniform(0.0, 0.5) * random.unit_vector()) {
    for (Wave& wave : waves_) {
      wave.way_m = random.uniform(0.0, 3e-3) * random.unit_vector();
      wave.per_s = random.uniform(0.0, 60.0);
      wave.phase = random.uniform(0.0, 6.0);
    }
  }
  Vec3 at(double time_s) const {
    Vec3 p_m = time_s * drift_m_per_s_;
    for (const Wave& wave : waves_) {
      p_m += std::sin(2 * std::numbers::pi * wave.per_s * time_s + wave.phase) * wave.way_m;
    }
    return p_m;
  }

 private:
  struct Wave {
    Vec3 way_m;
    double per_s = 0.0, phase = 0.0;
  };
  Vec3 drift_m_per_s_;
  std::array<Wave, 2> waves_;
};

// The part of a vector in the span of orthonormal axes.
Vec3 part_along(const Vec3& v, const std::vector<Vec3>& axes) {
  Vec3 part = Vec3::Zero();
  for (const Vec3& axis : axes) part += axis.dot(v) * axis;
  return part;
}

TEST(GentleRelease, DoesPositiveWorkOnlyInATickInWhichTheMotionTurns) {
  Random random(4911);
  int turned = 0, resisting = 0;
  for (int run = 0; run < 10'000; ++run) {
    const Mat3 turn = random.rotation().toRotationMatrix();
    const int count = 1 + static_cast<int>(random.index(3));
    std::vector<Vec3> axes;
    for (int i = 0; i < count; ++i) axes.push_back(turn.col(i));
    const MotorLimits motors = motors_along(axes);
    const Vec3 before_N =
        random.uniform(1.0, 20.0) * part_along(random.unit_vector(), axes).normalized();
    const RandomMotion motion(random);
    const auto at = [&](int tick) { return motion.at(1e-3 * tick); };
    GentleRelease release;
    release.begin(before_N);
    int positive = 0;
    for (int tick = 0; tick <= kFallTicks + 5; ++tick) {
      const Vec3 way_m = at(tick) - at(tick - 1);
      const Vec3 force_N = release.force(way_m, tick == 0 ? 0 : kTick_ns, motors);
      const double left = std::max(0.0, 1.0 - tick / double{kFallTicks});
      ASSERT_LE(force_N.norm(), left * before_N.norm() * (1 + 8 * kRound)) << "run " << run;
      ASSERT_LE((force_N - part_along(force_N, axes)).norm(), 16 * kRound * force_N.norm());
      ASSERT_LE(force_N.dot(way_m), 0.0);  // it resists the motion of this tick
      resisting += force_N.norm() > 0.0;
      // It is held along the next way.
      const Vec3 next_m = at(tick + 1) - at(tick);
      if (!(force_N.dot(next_m) > 0.0)) continue;
      ++positive;
      const Vec3 from = part_along(way_m, axes), to = part_along(next_m, axes);
      ASSERT_LT(from.dot(to), 0.0) << "run " << run << ", tick " << tick;
    }
    ASSERT_LE(positive, 2);
    turned += positive;
  }
  EXPECT_GT(turned, 500);
  EXPECT_GT(resisting, 50'000);
}

TEST(GentleRelease, FallsLinearlyToZeroWhereItResistsASteadyMotion) {
  Random random(4912);
  for (int run = 0; run < 200; ++run) {
    const Vec3 before_N = random.uniform(1.0, 20.0) * random.unit_vector();
    GentleRelease release;
    release.begin(before_N);
    const Vec3 way_m = -1e-4 * before_N.normalized();
    for (int tick = 0; tick <= kFallTicks; ++tick) {
      const Vec3 force_N = release.force(way_m, tick == 0 ? 0 : kTick_ns, three_motors());
      const Vec3 expected_N = std::max(0.0, 1.0 - tick / double{kFallTicks}) * before_N;
      EXPECT_LE((force_N - expected_N).norm(), 16 * kRound * before_N.norm()) << tick;
    }
    EXPECT_FALSE(release.is_active());
  }
}

// At 60 degrees to the force, the part along the motion is half of it; what is across is dropped.
TEST(GentleRelease, KeepsOnlyThePartAgainstTheMotion) {
  GentleRelease release;
  release.begin({8.0, 0.0, 0.0});
  const Vec3 direction(-0.5, std::sqrt(0.75), 0.0);
  const Vec3 force_N = release.force(1e-5 * direction, 0, three_motors());
  EXPECT_LE((force_N + 4.0 * direction).norm(), 16 * kRound);
}

TEST(GentleRelease, IsZeroAtOnceAlongTheMotion) {
  GentleRelease release;
  release.begin({8.0, 0.0, 0.0});
  EXPECT_EQ(release.force({1e-5, -1e-3, 0.0}, 0, three_motors()), Vec3::Zero());
  EXPECT_TRUE(release.is_active());
  // The hand comes back: the force resists again, and not above what is left of it.
  const Vec3 in_m(-1e-5, 0.0, 0.0);
  const Vec3 force_N = release.force(in_m, 15 * kTick_ns, three_motors());
  EXPECT_LE((force_N - Vec3(4.0, 0.0, 0.0)).norm(), 16 * kRound);
  // The way that led to the trip was no turn: one turn ends nothing yet.
  EXPECT_EQ(release.force(-in_m, kTick_ns, three_motors()), Vec3::Zero());
  EXPECT_GT(release.force(in_m, kTick_ns, three_motors()).x(), 3.0);
}

// Only the part of the motion that the motor can feel counts. A motion across the motor is none.
TEST(GentleRelease, LooksAtTheMotionWithinTheSpanOfTheMotors) {
  const MotorLimits motor = motors_along({Vec3::UnitX()});
  GentleRelease release;
  release.begin({-6.0, 0.0, 0.0});
  EXPECT_EQ(release.force({0.0, 0.3e-3, 0.1e-3}, 0, motor), Vec3(-6.0, 0.0, 0.0));
  EXPECT_EQ(release.force({1e-5, 1e-3, 1e-3}, 0, motor), Vec3(-6.0, 0.0, 0.0));
  EXPECT_EQ(release.force({-1e-5, 1e-3, 1e-3}, kTick_ns, motor), Vec3::Zero());
}

// Across a motor, up to rounding, a motion has no direction that the motor could resist.
// The motors of a linkage turn with the device, also while the force falls.
TEST(GentleRelease, StaysInTheSpanOfMotorsThatTurn) {
  GentleRelease release;
  release.begin({3.0, 4.0, 0.0});
  for (int n = 0; n < kFallTicks; ++n) {
    const double angle = 0.01 * n;
    const Vec3 direction(std::cos(angle), std::sin(angle), 0.0);
    const MotorLimits motor = motors_along({direction});
    const Vec3 way_m = n < 5 ? Vec3(Vec3::Zero()) : Vec3(-1e-4 * direction);
    const Vec3 force_N = release.force(way_m, kTick_ns, motor);
    EXPECT_LE((force_N - force_N.dot(direction) * direction).norm(), 16 * kRound * 5.0) << n;
    EXPECT_EQ(force_N.isZero(0.0), n + 1 == kFallTicks) << n;
  }
}

TEST(GentleRelease, TakesRoundingForNoMotion) {
  Random random(4913);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 axis = random.unit_vector();
    const MotorLimits motor = motors_along({axis});
    const Vec3 across = axis.cross(random.unit_vector());
    GentleRelease release;
    release.begin(5.0 * axis);
    EXPECT_EQ(release.force(1e-3 * across, 0, motor), Vec3(5.0 * axis));
  }
}

TEST(GentleRelease, CarriesAHandThatRests) {
  GentleRelease release;
  release.begin({0.0, 3.0, 0.0});
  for (int tick = 0; tick < kFallTicks; ++tick) {
    const Vec3 force_N = release.force(Vec3::Zero(), tick == 0 ? 0 : kTick_ns, three_motors());
    EXPECT_LE((force_N - Vec3(0.0, 3.0 * (1.0 - tick / double{kFallTicks}), 0.0)).norm(),
              16 * kRound);
  }
}

// A position that alternates between two steps of the encoder does not turn the motion.
TEST(GentleRelease, TakesAStepOfTheEncoderForNoMotion) {
  constexpr double kQuantum_m = 20e-6;
  GentleRelease release(kQuantum_m);
  release.begin({5.0, 0.0, 0.0});
  release.force({-3 * kQuantum_m, 0.0, 0.0}, 0, three_motors());
  double given_J = 0.0;
  Vec3 force_N = Vec3::Zero();
  for (int tick = 1; tick < kFallTicks; ++tick) {
    const Vec3 way_m((tick == 5 ? 1.0 : 0.0) * kQuantum_m, 0.0, 0.0);
    given_J += force_N.dot(way_m);
    force_N = release.force(way_m, kTick_ns, three_motors());
    EXPECT_GT(force_N.x(), 0.0) << tick;
  }
  EXPECT_LE(given_J, 5.0 * kQuantum_m);
}

TEST(GentleRelease, EndsForAHandThatSwings) {
  GentleRelease release;
  release.begin({5.0, 0.0, 0.0});
  std::vector<double> forces_N;
  for (int tick = 0; tick < 12; ++tick) {
    const double way_m = tick / 2 % 2 == 0 ? -1e-4 : 1e-4;
    forces_N.push_back(
        release.force({way_m, 0.0, 0.0}, tick == 0 ? 0 : kTick_ns, three_motors()).x());
  }
  const auto resists = [&](int tick) { return forces_N[static_cast<std::size_t>(tick)] > 0.0; };
  EXPECT_TRUE(resists(0) && resists(1) && !resists(2) && !resists(3));
  EXPECT_TRUE(resists(4) && resists(5) && !resists(6) && !resists(7));
  EXPECT_TRUE(!resists(8) && !resists(9));
  EXPECT_FALSE(release.is_active());
}

TEST(GentleRelease, StopsAtOnceOnRequestAndForWhatIsNotFinite) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const Vec3 way_m(-1e-5, 0.0, 0.0);
  GentleRelease release;
  EXPECT_EQ(release.force(way_m, kTick_ns, three_motors()), Vec3::Zero());  // no trip yet
  release.begin({5.0, 0.0, 0.0});
  release.stop();
  EXPECT_EQ(release.force(way_m, 0, three_motors()), Vec3::Zero());
  release.begin({5.0, kNone, 0.0});
  EXPECT_EQ(release.force(Vec3::Zero(), 0, three_motors()), Vec3::Zero());
  release.begin({5.0, 0.0, 0.0});
  EXPECT_EQ(release.force({kNone, 0.0, 0.0}, 0, three_motors()), Vec3::Zero());
  EXPECT_EQ(release.force(way_m, kTick_ns, three_motors()), Vec3::Zero());
}

TEST(GentleRelease, BeginsAnewWithEachTrip) {
  const Vec3 way_m(-1e-5, 0.0, 0.0);
  GentleRelease release;
  release.begin({5.0, 0.0, 0.0});
  release.force(way_m, 20 * kTick_ns, three_motors());
  release.force(-way_m, kTick_ns, three_motors());  // a turn
  release.begin({2.0, 0.0, 0.0});
  EXPECT_EQ(release.force(Vec3::Zero(), 0, three_motors()), Vec3(2.0, 0.0, 0.0));
  release.force(way_m, kTick_ns, three_motors());
  release.force(-way_m, kTick_ns, three_motors());
  EXPECT_GT(release.force(way_m, kTick_ns, three_motors()).x(), 1.0);
}

// A hand that presses against a force of 10 N, with the inertia of a light tip. Dropped at once, it
// has 10 N t / m after a time t; the force that falls linearly takes half of that.
TEST(GentleRelease, HalvesTheSpeedOfAHandThatFalls) {
  constexpr double kForce_N = 10.0, kMass_kg = 0.1, kStep_s = 1e-3;
  GentleRelease release;
  release.begin({kForce_N, 0.0, 0.0});
  double speed_m_per_s = 0.0, way_m = 0.0;
  for (int tick = 0; tick < kFallTicks; ++tick) {
    const Vec3 force_N = release.force({way_m, 0.0, 0.0}, tick == 0 ? 0 : kTick_ns, three_motors());
    const double before = speed_m_per_s;
    speed_m_per_s += (force_N.x() - kForce_N) / kMass_kg * kStep_s;
    way_m = 0.5 * (before + speed_m_per_s) * kStep_s;
  }
  const double dropped_m_per_s = -kForce_N / kMass_kg * kFallTicks * kStep_s;
  EXPECT_NEAR(speed_m_per_s / dropped_m_per_s, 0.5 * (1.0 - 1.0 / kFallTicks), 1e-12);
}

}  // namespace
}  // namespace palpate
