// The work of a tick is limited, and a tick that runs out of work only delays the result. The tests
// use the inputs that need the most work.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "benchmarks/worst_inputs.h"
#include "geometry/base/random.h"
#include "geometry/index/simd.h"
#include "haptics/check_settings.h"
#include "haptics/proxy/god_object.h"
#include "tests/haptics/proxy/work_budgets.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using bench::worst_kinds;
using bench::WorstInput;
using bench::WorstKind;
using test::kNoBudget;

struct BudgetTick {
  std::size_t held;  // number of bodies held back
  ProxyState state;
};

BudgetTick next_tick(GodObject& god_object, const WorstInput& input, std::size_t tick) {
  const std::size_t held = input.motions.empty() ? 0 : god_object.move_bodies(input.motions[tick]);
  return {held, god_object.move_to(input.goals_m[tick])};
}

GodObject god_object_of(const WorstInput& input, WorkUnits budget, bool reuse_candidates = true) {
  GodObjectSettings settings{input.proxy_radius_m, test::with_budget({}, budget)};
  settings.accuracy.reuse_candidates = reuse_candidates;
  auto god_object = test::made(GodObject::create(input.world, settings));
  god_object.place(input.goals_m.front());
  return god_object;
}

std::vector<BudgetTick> run_input(const WorstInput& input, WorkUnits budget) {
  GodObject god_object = god_object_of(input, budget);
  std::vector<BudgetTick> run;
  for (std::size_t i = 0; i < input.goals_m.size(); ++i) {
    run.push_back(next_tick(god_object, input, i));
  }
  return run;
}

bool is_same(const ProxyState& a, const ProxyState& b) {
  return std::memcmp(a.proxy.data(), b.proxy.data(), 3 * sizeof(double)) == 0 &&
         std::memcmp(a.normal.data(), b.normal.data(), 3 * sizeof(double)) == 0 &&
         a.capped == b.capped && a.active_planes == b.active_planes && a.work == b.work;
}

class WorkBudget : public testing::TestWithParam<WorstKind> {
 protected:
  WorkBudget() : input_(GetParam().make(GetParam().least)) {}
  ~WorkBudget() override { limit_simd_level(SimdLevel::kAvx512); }

  WorstInput input_;
};

// The largest work of a tick beyond its budget. The tick completes the present pack, or tests the
// doubtful triangles of a shortened step, each of which may need exact signs; and it completes the
// solver's own work, at most that of its largest number of steps.
constexpr WorkUnits kMostBeyond =
    DoubtfulTriangles::kMost * (price_of(Work::kTriangle) + 4 * price_of(Work::kNearestPoint) +
                                5 * price_of(Work::kSignByExpansions)) +
    Accuracy{}.iterations * (price_of(Work::kStep) + kMaxContactPlanes * price_of(Work::kPlane) +
                             3 * price_of(Work::kContact));

TEST_P(WorkBudget, LimitsTheWorkOfEachTick) {
  ASSERT_EQ(input_.goals_m.size(), GetParam().ticks);
  const WorkUnits budget = Accuracy::balanced().work_budget;
  WorkUnits most = 0;
  for (const BudgetTick& tick : run_input(input_, budget)) most = std::max(most, tick.state.work);
  EXPECT_LE(most, budget + kMostBeyond);
}

TEST_P(WorkBudget, NeverMovesTheProxyAwayFromTheGoal) {
  for (const WorkUnits budget : {100, 2000, 20000}) {
    GodObject god_object = god_object_of(input_, budget);
    for (std::size_t i = 0; i < input_.goals_m.size(); ++i) {
      if (!input_.motions.empty()) god_object.move_bodies(input_.motions[i]);
      const Vec3 before = god_object.proxy();
      const Vec3& goal = input_.goals_m[i];
      const ProxyState state = god_object.move_to(goal);
      ASSERT_TRUE(state.proxy.allFinite());
      const double rounding_m = 1e-15 * (input_.world.size_m + goal.norm());
      ASSERT_LE((state.proxy - goal).norm(), (before - goal).norm() + rounding_m) << "tick " << i;
    }
  }
}

TEST_P(WorkBudget, DoesNotChangeTheBitsOfTicksBeforeTheFirstThatRunsOut) {
  for (const bool reuse_candidates : {true, false}) {
    for (const WorkUnits budget : {500, 5000, 50000}) {
      GodObject without = god_object_of(input_, kNoBudget, reuse_candidates);
      GodObject with = god_object_of(input_, budget, reuse_candidates);
      for (std::size_t i = 0; i < input_.goals_m.size(); ++i) {
        const BudgetTick expected = next_tick(without, input_, i);
        if (expected.state.work >= budget / 2) break;  // pushes may use half of the budget
        const BudgetTick tick = next_tick(with, input_, i);
        ASSERT_EQ(tick.held, expected.held) << "tick " << i;
        ASSERT_TRUE(is_same(tick.state, expected.state)) << "tick " << i;
      }
    }
  }
}

TEST_P(WorkBudget, GivesTheSameBitsWithEachInstructionSet) {
  for (const WorkUnits budget : {300, 4000}) {
    limit_simd_level(SimdLevel::kAvx512);
    const std::vector<BudgetTick> widest = run_input(input_, budget);
    for (const SimdLevel level : {SimdLevel::kAvx2, SimdLevel::kBaseline}) {
      limit_simd_level(level);
      const std::vector<BudgetTick> run = run_input(input_, budget);
      for (std::size_t i = 0; i < run.size(); ++i) {
        ASSERT_EQ(run[i].held, widest[i].held) << "tick " << i;
        ASSERT_TRUE(is_same(run[i].state, widest[i].state)) << "tick " << i;
      }
    }
  }
}

// The proxy starts from its position after some limited ticks, with their interrupted searches.
TEST_P(WorkBudget, ReachesAConstantGoalInAtMostFourTimesTheTicksOfItsWork) {
  constexpr double kMostTimes = 4.0;
  constexpr int kTicksBefore = 3;
  constexpr int kMostTicksWithout = 30;
  const std::size_t count = input_.goals_m.size();
  for (const WorkUnits budget : {1000, 20000}) {
    double worst = 0.0;
    for (std::size_t trial = 0; trial < 16; ++trial) {
      const std::size_t first = trial / 2 * count / 8;
      const Vec3 goal = trial % 2 ? input_.away_m : input_.goals_m[(7 * first + 13) % count];
      GodObject without = god_object_of(input_, kNoBudget);
      GodObject with = god_object_of(input_, budget);
      double work = 0.0;
      for (int i = 0; i < kTicksBefore; ++i) {
        work += static_cast<double>(without.move_to(input_.goals_m[first]).work);
        with.move_to(input_.goals_m[first]);
      }
      // The work from the present position, if that is more.
      GodObject afresh = god_object_of(input_, kNoBudget);
      afresh.place(with.proxy());
      double work_afresh = 0.0;
      const auto settles = [&](GodObject& god_object, double& total) {
        for (int i = 0; i < kMostTicksWithout; ++i) {
          const ProxyState state = god_object.move_to(goal);
          total += static_cast<double>(state.work);
          if (!state.capped) return true;
        }
        return false;
      };
      // Some rests depend on rounding and stay capped.
      if (!settles(without, work) || !settles(afresh, work_afresh)) continue;
      const double fills =
          std::max(1.0, std::ceil(std::max(work, work_afresh) / static_cast<double>(budget)));
      const int most = static_cast<int>(kMostTimes * fills) + 1;
      int ticks = 1;
      while (with.move_to(goal).capped && ticks <= most) ++ticks;
      worst = std::max(worst, ticks / fills);
      EXPECT_LE(ticks, kMostTimes * fills) << "trial " << trial << ", budget " << budget;
    }
    std::printf("budget %lld: at most %.2f times\n", static_cast<long long>(budget), worst);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, WorkBudget, testing::ValuesIn(worst_kinds()),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST(WorkBudgets, AreAtLeastOneUnit) {
  const test::OwnedWorld world(test::box_soup(Vec3::Ones()));
  GodObjectSettings settings;
  for (const WorkUnits wrong : {0, -1}) {
    settings.accuracy.work_budget = wrong;
    const auto error = check_settings(world.world(), settings);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->element, "accuracy.work_budget");
  }
  settings.accuracy.work_budget = 1;
  EXPECT_FALSE(check_settings(world.world(), settings));
}

// Every body and the hand have their turns; none waits for ever.
TEST(WorkBudgets, AreSharedByBodiesAndTheHand) {
  const WorstKind& kind =
      *std::find_if(worst_kinds().begin(), worst_kinds().end(),
                    [](const WorstKind& k) { return k.name == "moving_bodies"; });
  const WorstInput input = kind.make(kind.least);
  for (const WorkUnits budget : {50, 500}) {
    GodObject god_object = god_object_of(input, budget);
    const Vec3 goal = input.goals_m.front() + Vec3(0.01, 0.0, 0.0);
    int ticks_to_goal = 0;
    for (std::size_t i = 0; i < 20; ++i) {
      EXPECT_GT(god_object.move_bodies(input.motions[i]), 0u);
      ticks_to_goal += god_object.move_to(goal).proxy != goal;
    }
    EXPECT_LT(ticks_to_goal, 20) << "the hand never had its turn";
    std::size_t held = 1;
    int ticks = 0;
    for (; held > 0 && ticks < 10'000; ++ticks) {
      held = god_object.move_bodies(input.motions[20]);
      god_object.move_to(goal);
    }
    EXPECT_EQ(held, 0u) << "after " << ticks << " ticks";
  }
}

// A body with many triangles that moves in each tick takes the ticks that its pushes need; the
// other bodies keep moving.
TEST(WorkBudgets, LetOtherBodiesMoveWhileOneBodyNeedsManyTicks) {
  test::Soup heavy;
  SeededRandom random(11);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 a = random.in_box(0.05);
    heavy.add(a, a + random.in_box(0.02), a + random.in_box(0.02));
  }
  const test::Soup light = test::box_soup(Vec3::Constant(0.01));
  const RigidTransform far{Quat::Identity(), Vec3(1.0, 0.0, 0.0)};
  const test::OwnedBodies bodies({{heavy, {}}, {light, far}});
  auto god_object =
      test::made(GodObject::create(bodies.world(), {0.0, test::with_budget({}, 300)}));
  god_object.place(Vec3(0.0, 0.0, 0.02));
  double heavy_least_m = 1.0;
  double light_least_m = 1.0;
  for (int tick = 1; tick < 2000; ++tick) {
    const double moved_m = 1e-5 * tick;
    const BodyMotion motions[] = {{0, {Quat::Identity(), Vec3(moved_m, 0.0, 0.0)}},
                                  {1, {Quat::Identity(), Vec3(1.0 + moved_m, 0.0, 0.0)}}};
    god_object.move_bodies(motions);
    god_object.move_to(Vec3(0.0, 0.0, 0.02));
    if (tick < 1000) continue;
    const auto behind_m = [&](std::uint32_t b) {
      return (god_object.world().body(b).T_solver_body.translation_m -
              motions[b].T_solver_body.translation_m)
          .norm();
    };
    heavy_least_m = std::min(heavy_least_m, behind_m(0));
    light_least_m = std::min(light_least_m, behind_m(1));
  }
  EXPECT_LT(heavy_least_m, 5e-3) << "the body with many triangles did not move";
  EXPECT_LT(light_least_m, 5e-3) << "the body with few triangles never had its turn";
}

// A body that has moved outside of the earlier bounds can be touched there, even if no work was
// left for the other bodies.
TEST(WorkBudgets, KeepEveryMovedBodyWithinTheBounds) {
  const test::Soup wall = test::box_soup(Vec3(0.1, 0.1, 0.01));
  std::vector<test::OwnedBodies::Placed> placed;
  for (int i = 0; i < 40; ++i) placed.push_back({wall, {Quat::Identity(), Vec3(0, 0, -0.1 * i)}});
  const test::OwnedBodies bodies(placed);
  std::vector<BodyMotion> motions;
  for (std::uint32_t b = 0; b < 40; ++b) {
    motions.push_back({b, {Quat::Identity(), Vec3(0.0, 0.0, b == 0 ? 30.0 : -0.1 * b + 0.01)}});
  }
  const Vec3 aside(0.0, 0.5, 20.0);  // not on the path of the body
  const Vec3 below(0.01, 0.02, 20.0);
  const Vec3 above(0.01, 0.02, 40.0);
  for (const WorkUnits budget : {10, 20, 40, 100, 1000}) {
    auto god_object =
        test::made(GodObject::create(bodies.world(), {0.0, test::with_budget({}, budget)}));
    god_object.place(aside);
    const auto is_there = [&] {
      return god_object.world().body(0).T_solver_body.translation_m.z() == 30.0;
    };
    for (int tick = 0; tick < 2000; ++tick) {
      god_object.move_bodies(motions);
      if (is_there()) break;
      god_object.move_to(aside);
    }
    ASSERT_TRUE(is_there()) << budget;
    for (const Vec3& goal : {below, above}) {
      for (int tick = 0; tick < 1000; ++tick) god_object.move_to(goal);
    }
    EXPECT_LT(god_object.proxy().z(), 30.0) << "with a budget of " << budget;
  }
}

// The work used by earlier ticks does not limit place().
TEST(WorkBudgets, DoNotPreventTheLiftOfAPlacedProxy) {
  const test::OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  auto god_object = test::made(GodObject::create(world.world(), {0.0, test::with_budget({}, 1)}));
  god_object.place(Vec3(0.0, 0.0, 0.3));
  for (int tick = 0; tick < 3; ++tick) god_object.move_to(Vec3(0.01 * tick, 0.0, 0.0));
  const double just_above_m = 0.1 + 0.1 * god_object.scale().stand_off_m;
  ASSERT_TRUE(god_object.place(Vec3(0.01, 0.02, just_above_m)));
  EXPECT_GE(god_object.proxy().z() - 0.1, 0.5 * god_object.scale().stand_off_m);
}

}  // namespace
}  // namespace palpate
