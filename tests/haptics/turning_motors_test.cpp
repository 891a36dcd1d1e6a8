// Motors whose directions depend on the pose of the device.

#include <cstring>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kTick_s;
using test::OwnedWorld;
using test::Random;

bool same_bits(const TickRecord& a, const TickRecord& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

// A hand that wanders around a box, in and out of it.
std::vector<Vec3> wandering_path(std::uint64_t seed, bool planar) {
  Random random(seed);
  std::vector<Vec3> path{{0.13, 0.0, 0.0}};
  Vec3 aim = path.front();
  for (int n = 0; n < 2000; ++n) {
    if (n % 100 == 0) aim = 0.12 * random.unit_vector();
    path.push_back(path.back() + 0.01 * (aim - path.back()));
    if (planar) path.back().z() = 0.0;
  }
  return path;
}

ActuationModel some_motors(Random& random, int sensors, int motors) {
  for (;;) {
    std::vector<Vec3> axes;
    for (int i = 0; i < motors; ++i) {
      Vec3 axis = random.unit_vector();
      if (sensors == 2) axis.z() = 0.0;
      axes.push_back(axis);
    }
    if (auto model = ActuationModel::from_axes(sensors, axes)) return *model;
  }
}

TEST(TurningMotors, SetBeforeTheFirstTickEqualThoseOfTheConstructor) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const int sensors = 2 + static_cast<int>(random.index(2));
    const int motors = static_cast<int>(random.index(static_cast<std::uint64_t>(sensors) + 1));
    const ActuationModel first = some_motors(random, sensors, motors);
    const ActuationModel later = some_motors(random, sensors, motors);
    auto changed = test::made(HapticLoop::create(world.world(), first, {}));
    auto fresh = test::made(HapticLoop::create(world.world(), later, {}));
    changed.set_actuation(later);
    for (const Vec3& p : wandering_path(seed, sensors == 2)) {
      ASSERT_TRUE(same_bits(changed.tick(p, kTick_s), fresh.tick(p, kTick_s))) << "seed " << seed;
    }
  }
}

TEST(TurningMotors, ChangeNoBitIfTheModelStaysTheSame) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const int motors = static_cast<int>(random.index(4));
    const ActuationModel model = some_motors(random, 3, motors);
    auto changed = test::made(HapticLoop::create(world.world(), model, {}));
    auto left = test::made(HapticLoop::create(world.world(), model, {}));
    for (const Vec3& p : wandering_path(seed, false)) {
      changed.set_actuation(model);
      ASSERT_TRUE(same_bits(changed.tick(p, kTick_s), left.tick(p, kTick_s))) << "seed " << seed;
    }
  }
}

// Without A4, the pose does not depend on the motors. Whatever the earlier motors were, a tick
// equals that of a loop that has had the present motors from the start.
TEST(TurningMotors, GiveInEachTickTheResultOfALoopBuiltWithThem) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  HapticSettings settings;
  settings.a4.enabled = false;
  int contacts = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    std::vector<ActuationModel> models;
    std::vector<HapticLoop> fresh;
    fresh.reserve(8);
    for (int i = 0; i < 8; ++i) {
      models.push_back(some_motors(random, 3, i % 4));
      fresh.push_back(test::made(HapticLoop::create(world.world(), models.back(), settings)));
    }
    auto turning = test::made(HapticLoop::create(world.world(), models.front(), settings));
    for (const Vec3& p : wandering_path(seed, false)) {
      const auto now = static_cast<std::size_t>(random.index(models.size()));
      turning.set_actuation(models[now]);
      const TickRecord& record = turning.tick(p, kTick_s);
      for (std::size_t i = 0; i < fresh.size(); ++i) {
        const TickRecord& expected = fresh[i].tick(p, kTick_s);
        if (i != now) continue;
        ASSERT_TRUE(same_bits(record, expected)) << "seed " << seed;
      }
      contacts += record.contact;
    }
  }
  EXPECT_GT(contacts, 1000);
}

// After half a turn, a motor is equivalent to before, because it pushes in both directions. A4
// keeps the side to which it was turning.
TEST(TurningMotors, KeepTheDirectionOfAlignment) {
  const ActuationModel start = *ActuationModel::from_axes(3, {Vec3::UnitX()});
  TheoreticalRotation rotation(start, Table1Form::kCorrected);
  // The normal is undecided, within the hysteresis, and is being aligned with -A1.
  rotation.update(-Vec3::UnitX());
  const double inside_rad = 1.0 * std::numbers::pi / 180.0;
  for (int degree = 0; degree <= 180; ++degree) {
    const double turn_rad = degree * std::numbers::pi / 180.0;
    const Vec3 axis(std::cos(turn_rad), std::sin(turn_rad), 0.0);
    rotation.set_actuation(*ActuationModel::from_axes(3, {axis}));
    // A normal nearly perpendicular to the axis, slightly on the other side than the one it is
    // aligned with. A new contact would choose that side.
    const Vec3 across(-std::sin(turn_rad), std::cos(turn_rad), 0.0);
    const Vec3 normal = std::cos(inside_rad) * across + std::sin(inside_rad) * axis;
    const AxisAngle turn = rotation.update(normal);
    EXPECT_NEAR(turn.angle_rad, std::numbers::pi / 2 + inside_rad, 1e-12) << degree;
  }
}

TEST(TurningMotors, WithOtherSensedAxesAreRefusedWithAFault) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  auto changed =
      test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), {}));
  auto left = test::made(HapticLoop::create(world.world(), *ActuationModel::from_counts(3, 1), {}));
  for (const Vec3& p : wandering_path(3, false)) {
    const bool refused = changed.tick(p, kTick_s).tick % 7 == 3;
    TickRecord expected = left.tick(p, kTick_s);
    TickRecord record = changed.tick(p, 0.0);  // a tick that changes nothing
    EXPECT_NE(record.faults & kFaultBadTimeStep, 0u);
    left.tick(p, 0.0);
    if (!refused) continue;
    changed.set_actuation(*ActuationModel::from_counts(2, 1));
    record = changed.tick(p, kTick_s);
    expected = left.tick(p, kTick_s);
    EXPECT_EQ(record.faults, expected.faults | kFaultBadActuation);
    record.faults = expected.faults;
    ASSERT_TRUE(same_bits(record, expected));
  }
}

TEST(TurningMotors, AreTheSameFromBothFactories) {
  Random random(1602);
  for (int n = 0; n < 2000; ++n) {
    const int sensors = static_cast<int>(random.index(5));
    std::vector<Vec3> axes;
    for (std::uint64_t i = random.index(5); i > 0; --i) {
      Vec3 axis = random.unit_vector();
      if (random.index(3) == 0) axis.z() = 0.0;
      if (random.index(9) == 0) axis.setZero();
      if (random.index(5) == 0 && !axes.empty()) axis = 2.0 * axes.back();
      axes.push_back(axis);
    }
    const auto with_text = ActuationModel::from_axes(sensors, axes);
    const auto without = ActuationModel::from_axes_at_pose(sensors, axes);
    ASSERT_EQ(with_text.ok(), without.has_value());
    if (!without) continue;
    ASSERT_TRUE(*with_text == *without);
  }
}

}  // namespace
}  // namespace palpate
