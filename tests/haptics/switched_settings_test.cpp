// Settings of a loop that change while it runs.

#include <cstring>
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

bool have_same_bits(const TickRecord& a, const TickRecord& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

// A hand that begins outside of a box of 0.2 m and wanders in and out of it.
std::vector<Vec3> path_into_box(std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> path{{0.15, 0.0, 0.0}};
  Vec3 aim = path.front();
  for (int n = 0; n < 1500; ++n) {
    if (n % 100 == 0) aim = 0.12 * random.unit_vector();
    path.push_back(path.back() + 0.01 * (aim - path.back()));
  }
  return path;
}

HapticSettings some_settings(Random& random) {
  HapticSettings settings;
  settings.a4.enabled = random.index(2) == 0;
  settings.force = static_cast<ForceMode>(random.index(3));
  settings.coupling.stiffness_N_per_m = random.uniform(0.0, 3000.0);
  settings.coupling.damping_Ns_per_m = random.uniform(0.0, 3.0);
  return settings;
}

void switch_to(const HapticSettings& settings, HapticLoop& loop) {
  loop.set_a4(settings.a4.enabled);
  loop.set_force(settings.force);
  loop.set_coupling(settings.coupling.stiffness_N_per_m, settings.coupling.damping_Ns_per_m);
}

ActuationModel one_motor() {
  return *ActuationModel::from_counts(3, 1);
}

// Outside of contact, no state depends on these settings: until the first contact, a switch in any
// tick gives the bits of a loop that was constructed so.
TEST(SwitchedSettings, BeforeTheFirstContactEqualThoseOfTheConstructor) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  int contacts = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const HapticSettings first = some_settings(random);
    const HapticSettings later = some_settings(random);
    auto switched = test::made(HapticLoop::create(world.world(), one_motor(), first));
    auto fresh = test::made(HapticLoop::create(world.world(), one_motor(), later));
    const std::vector<Vec3> path = path_into_box(seed);
    const std::size_t free_ticks = 20;  // the path is at least 0.04 m outside then
    const std::size_t when = random.index(free_ticks);
    for (std::size_t n = 0; n < path.size(); ++n) {
      if (n == when) switch_to(later, switched);
      const TickRecord& record = switched.tick(path[n], kTick_s);
      ASSERT_TRUE(have_same_bits(record, fresh.tick(path[n], kTick_s)))
          << "seed " << seed << ", tick " << n << ", switched in tick " << when;
      ASSERT_TRUE(n >= free_ticks || record.contact == 0);
      contacts += record.contact;
    }
  }
  EXPECT_GT(contacts, 1000);
}

// Without A4, the contact does not depend on force and coupling. Whatever they were before, a tick
// equals that of a loop that has had the present ones from the start.
TEST(SwitchedSettings, GiveInEachTickTheResultOfALoopBuiltWithThem) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  int contacts = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    std::vector<HapticSettings> all;
    std::vector<HapticLoop> fresh;
    fresh.reserve(6);
    for (int i = 0; i < 6; ++i) {
      all.push_back(some_settings(random));
      all.back().a4.enabled = false;
      fresh.push_back(test::made(HapticLoop::create(world.world(), one_motor(), all.back())));
    }
    auto switched = test::made(HapticLoop::create(world.world(), one_motor(), all.front()));
    for (const Vec3& p : path_into_box(seed)) {
      const auto now = static_cast<std::size_t>(random.index(all.size()));
      switch_to(all[now], switched);
      const TickRecord& record = switched.tick(p, kTick_s);
      for (std::size_t i = 0; i < fresh.size(); ++i) {
        const TickRecord& expected = fresh[i].tick(p, kTick_s);
        if (i == now) {
          ASSERT_TRUE(have_same_bits(record, expected)) << "seed " << seed;
        }
      }
      contacts += record.contact;
    }
  }
  EXPECT_GT(contacts, 500);
}

TEST(SwitchedSettings, A4TurnsTheSceneOnlyWhileItIsOn) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  // The hand first touches the face towards A1, whose normal is perpendicular to this motor.
  const ActuationModel motor = *ActuationModel::from_axes(3, {Vec3(0, 1, 0)});
  int turns = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    auto loop = test::made(HapticLoop::create(world.world(), motor, {}));
    int n = 0;
    for (const Vec3& p : path_into_box(seed)) {
      const bool is_on = n++ / 150 % 2 == 0;
      loop.set_a4(is_on);
      const TickRecord& record = loop.tick(p, kTick_s);
      if (is_on) {
        turns += record.rotation_rad > 0.0 ? 1 : 0;
      } else {
        ASSERT_EQ(record.rotation_rad, 0.0) << "seed " << seed;
      }
    }
  }
  EXPECT_GT(turns, 100);
}

// A loop that calls set_a4(true) in every tick keeps its direction like one that does not.
TEST(SwitchedSettings, ChangeNoBitIfTheyStayTheSame) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    const HapticSettings settings = some_settings(random);
    auto switched = test::made(HapticLoop::create(world.world(), one_motor(), settings));
    auto left = test::made(HapticLoop::create(world.world(), one_motor(), settings));
    for (const Vec3& p : path_into_box(seed)) {
      switch_to(settings, switched);
      ASSERT_TRUE(have_same_bits(switched.tick(p, kTick_s), left.tick(p, kTick_s)))
          << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace palpate
