// The effects of the settings of Accuracy, and the properties that no setting may change.

#include "haptics/proxy/accuracy.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/index/simd.h"
#include "haptics/proxy/float_trace.h"
#include "haptics/proxy/god_object.h"
#include "models/primitives.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::OwnedWorld;
using test::Random;
using test::Soup;

const Vec3 kHalf_m(0.08, 0.06, 0.05);

// Device points around and inside the box, some of them far apart.
std::vector<Vec3> wander(Random& random, int count) {
  std::vector<Vec3> goals_m{{0.0, 0.0, 0.2}};
  while (static_cast<int>(goals_m.size()) < count) {
    const bool leaps = random.index(50) == 0;
    const Vec3 next = leaps ? random.in_box(0.15) : Vec3(goals_m.back() + random.in_box(2e-3));
    goals_m.push_back(next.cwiseMin(0.15).cwiseMax(-0.15));
  }
  return goals_m;
}

std::vector<ProxyState> follow(const ContactWorld& world, const Accuracy& accuracy,
                               const std::vector<Vec3>& goals_m, double radius_m = 0.0) {
  auto god_object =
      test::made(GodObject::create(world, {.radius_m = radius_m, .accuracy = accuracy}));
  god_object.place(goals_m.front());
  std::vector<ProxyState> states;
  for (const Vec3& goal : goals_m) states.push_back(god_object.move_to(goal));
  return states;
}

double outside_box_m(const Vec3& p) {
  return (p.cwiseAbs() - kHalf_m).maxCoeff();
}

TEST(Accuracy, HasThreePresetsByName) {
  EXPECT_FALSE(accuracy_preset("faster").has_value());
  const Accuracy fast = accuracy_preset("fast").value();
  const Accuracy balanced = accuracy_preset("balanced").value();
  const Accuracy exact = accuracy_preset("exact").value();
  EXPECT_LT(fast.iterations, balanced.iterations);
  EXPECT_LT(balanced.iterations, exact.iterations);
  EXPECT_GT(fast.tolerance, balanced.tolerance);
  EXPECT_GT(balanced.tolerance, exact.tolerance);
  EXPECT_FALSE(fast.certify);
  EXPECT_EQ(balanced.narrow_phase, NarrowPhase::kDouble);
  EXPECT_TRUE(balanced.certify);
  EXPECT_EQ(GodObjectSettings{}.accuracy.iterations, balanced.iterations);
}

class EveryPreset : public testing::TestWithParam<const char*> {};

Accuracy named(const std::string& name) {
  if (const auto preset = accuracy_preset(name)) return *preset;
  Accuracy in_float;
  in_float.narrow_phase = NarrowPhase::kFloat;
  return in_float;
}

TEST_P(EveryPreset, StaysOutsideTheBoxAndNeverMovesAwayFromTheGoal) {
  Random random(81);
  const OwnedWorld world(box_soup(kHalf_m));
  const std::vector<Vec3> goals_m = wander(random, 20000);
  const auto states = follow(world.world(), named(GetParam()), goals_m);
  int contacts = 0;
  for (std::size_t n = 1; n < states.size(); ++n) {
    ASSERT_GT(outside_box_m(states[n].proxy), 0.0) << "tick " << n;
    const double before_m = (states[n - 1].proxy - goals_m[n]).norm();
    ASSERT_LE((states[n].proxy - goals_m[n]).norm(), before_m * (1 + 1e-14)) << "tick " << n;
    contacts += states[n].in_contact ? 1 : 0;
  }
  EXPECT_GT(contacts, 1000);
}

INSTANTIATE_TEST_SUITE_P(Named, EveryPreset,
                         testing::Values("fast", "balanced", "exact", "in_float"),
                         [](const auto& preset) { return std::string(preset.param); });

// Over one face, where no edge affects the result, the float result differs from the exact one by
// its own stand-off at most.
TEST(NarrowPhaseInFloat, DiffersByAStandOffFromTheExactResult) {
  Random random(82);
  const OwnedWorld world(box_soup(kHalf_m));
  Accuracy in_float;
  in_float.narrow_phase = NarrowPhase::kFloat;
  const double reach_m = world.index().largest_pack_reach_m();
  const double stand_off_m = float_stand_off_m(reach_m);
  EXPECT_LT(stand_off_m, 1e-4 * reach_m);
  auto god_object =
      test::made(GodObject::create(world.world(), {.radius_m = 0.0, .accuracy = in_float}));
  EXPECT_EQ(god_object.scale().stand_off_m, stand_off_m);
  god_object.place({0.0, 0.0, 0.1});
  for (int n = 0; n < 5000; ++n) {
    const Vec3 goal(random.uniform(-0.07, 0.07), random.uniform(-0.05, 0.05),
                    random.uniform(0.01, 0.049));
    const ProxyState state = god_object.move_to(goal);
    ASSERT_TRUE(state.in_contact);
    ASSERT_LE((state.proxy - Vec3(goal.x(), goal.y(), kHalf_m.z())).norm(), 2 * stand_off_m);
    ASSERT_GT(state.proxy.z(), kHalf_m.z());
  }
}

// The float stand-off depends on the size of the packs and not of the scene, so that a fine mesh
// has a small stand-off.
TEST(NarrowPhaseInFloat, LosesLittleAccuracyOnAFineMesh) {
  const TriangleMesh sphere = icosphere(6, 0.1);
  const OwnedWorld world({sphere.positions_m, sphere.triangles});
  EXPECT_LT(float_stand_off_m(world.index().largest_pack_reach_m()), 1e-5 * 0.1);
}

TEST(Iterations, AtTheLimitGiveAFeasibleMonotoneResultReportedAsCapped) {
  Random random(83);
  const OwnedWorld world(box_soup(kHalf_m));
  for (const int iterations : {1, 2, 3}) {
    Accuracy few;
    few.iterations = iterations;
    int capped = 0;
    for (int trial = 0; trial < 200; ++trial) {
      auto god_object =
          test::made(GodObject::create(world.world(), {.radius_m = 0.0, .accuracy = few}));
      god_object.place(0.5 * random.in_box(1.0).cwiseProduct(kHalf_m));
      const Vec3 before = god_object.proxy();
      const Vec3 goal = random.unit_vector().cwiseSign() * 0.2;  // into a corner
      const ProxyState state = god_object.move_to(goal);
      capped += state.capped ? 1 : 0;
      ASSERT_LE(state.iterations, iterations);
      ASSERT_LT(outside_box_m(state.proxy), 0.0);
      ASSERT_LE((state.proxy - goal).norm(), (before - goal).norm());
    }
    EXPECT_GT(capped, 0) << iterations;
  }
}

// Ticks that reuse the candidates of the last tick and ticks that search anew give the same
// results.
TEST(Candidates, GiveTheSameBitsWhetherKeptOrNot) {
  Random random(84);
  const TriangleMesh sphere = icosphere(4, 0.1);
  for (const double radius_m : {0.0, 3e-3}) {
    const OwnedWorld world({sphere.positions_m, sphere.triangles}, {}, radius_m);
    const std::vector<Vec3> goals_m = wander(random, 3000);
    Accuracy searching;
    searching.reuse_candidates = false;
    const auto kept = follow(world.world(), {}, goals_m, radius_m);
    const auto searched = follow(world.world(), searching, goals_m, radius_m);
    for (std::size_t n = 0; n < goals_m.size(); ++n) {
      ASSERT_EQ(kept[n].proxy, searched[n].proxy) << "tick " << n << " radius " << radius_m;
    }
  }
}

class EverySimdLevel : public testing::TestWithParam<SimdLevel> {
 protected:
  ~EverySimdLevel() override { limit_simd_level(SimdLevel::kAvx512); }
};

TEST_P(EverySimdLevel, GivesTheSameBits) {
  Random random(85);
  const TriangleMesh sphere = icosphere(4, 0.1);
  for (const double radius_m : {0.0, 3e-3}) {
    const OwnedWorld world({sphere.positions_m, sphere.triangles}, {}, radius_m);
    const std::vector<Vec3> goals_m = wander(random, 3000);
    const auto run = [&] {
      auto god_object = test::made(GodObject::create(world.world(), {.radius_m = radius_m}));
      god_object.place(goals_m.front());
      std::vector<Vec3> proxies;
      for (const Vec3& goal : goals_m) {
        proxies.push_back(god_object.move_to(goal).proxy);
        if (const auto near = world.index().closest_point(goal, 0.05)) {
          proxies.push_back(near->point_m);
        }
      }
      return proxies;
    };
    const std::vector<Vec3> widest = run();
    limit_simd_level(GetParam());
    EXPECT_LE(simd_level(), GetParam());
    EXPECT_EQ(run(), widest);
    limit_simd_level(SimdLevel::kAvx512);
  }
}

INSTANTIATE_TEST_SUITE_P(Limited, EverySimdLevel,
                         testing::Values(SimdLevel::kBaseline, SimdLevel::kAvx2,
                                         SimdLevel::kAvx512),
                         [](const auto& level) {
                           return std::string(kSimdLevelNames[static_cast<int>(level.param)]);
                         });

}  // namespace
}  // namespace palpate
