// The budget of the effects near objects: which of them act, and what a capped tick leaves out.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/index/simd.h"
#include "haptics/effects/effect_runner.h"
#include "haptics/effects/magnet.h"
#include "haptics/effects/nearest_search.h"
#include "haptics/effects/viscosity.h"
#include "models/primitives.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/mesh_soup.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::effect_entry;
using test::OwnedBodies;
using test::Random;
using test::Soup;

constexpr WorkUnits kEnough = WorkUnits{1} << 40;

GodObjectSettings with_effects_budget(WorkUnits units, CountingRule rule = CountingRule::kSecond) {
  GodObjectSettings settings;
  settings.accuracy.work_budget = (units - 1) * Accuracy::kEffectsPart;
  settings.accuracy.counting = rule;
  return settings;
}

bool are_same(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

// A proxy in free space, which an effect runner follows.
class FreeProxy {
 public:
  FreeProxy(const ContactWorld& world, const GodObjectSettings& settings)
      : live_(world), runner_(world, settings, CouplingSettings{}, false) {}

  Vec3 force_N(const Vec3& p, const Vec3& velocity_m_per_s = Vec3::Zero()) {
    ProxyState state;
    state.proxy = p;
    EffectMotion motion;
    motion.dt_s = motion.longest_dt_s = 1e-3;
    motion.goal_m = p;
    motion.velocity_m_per_s = velocity_m_per_s;
    runner_.begin_tick();
    const Vec3 force_N = runner_.surroundings_force_N(live_, state, Vec3::Zero(), motion);
    runner_.end_tick();
    return force_N;
  }
  bool is_capped() const { return runner_.is_capped(); }
  WorkUnits work() const { return runner_.work().used(); }
  LiveWorld& world() { return live_; }

 private:
  LiveWorld live_;
  EffectRunner runner_;
};

// Small magnetic triangles at random places. The pull of each is known from the definition.
class Magnets {
 public:
  static constexpr double kForce_N = 1.5;
  static constexpr double kRange_m = 3.0;

  Magnets(Random& random, std::size_t count) {
    std::vector<OwnedBodies::Placed> placed;
    for (std::size_t i = 0; i < count; ++i) {
      Soup soup;
      soup.add({0, 0, 0}, {1e-6, 0, 0}, {0, 1e-6, 0});
      placed.push_back({soup, random.pose(1.0)});
    }
    bodies_.emplace(placed);
    EffectProgramBuilder builder;
    builder.program.bodies.resize(count);
    for (std::uint32_t b = 0; b < count; ++b) {
      builder.program.magnets.push_back({b, 0, bodies_->world().bodies[b].index});
      builder.add_surroundings(
          effect_entry<MagnetEffect>({kForce_N, kRange_m, &builder.program.magnets.back()}));
    }
    bodies_->set_effects(std::make_shared<const EffectProgram>(std::move(builder).finish()));
  }

  const ContactWorld& world() const { return bodies_->world(); }

  // The numbers of the magnets, the nearest first.
  std::vector<std::size_t> by_distance(const Vec3& p) const {
    std::vector<std::size_t> order(world().bodies.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return nearest(a, p).distance < nearest(b, p).distance;
    });
    return order;
  }
  Vec3 pull_N(std::size_t b, const Vec3& p) const {
    const TrianglePoint point = nearest(b, p);
    const double part = 1.0 - point.distance / kRange_m;
    return -kForce_N * part * part * (world().bodies[b].T_solver_body.rotation * point.direction);
  }

 private:
  TrianglePoint nearest(std::size_t b, const Vec3& p) const {
    const ContactBody& body = world().bodies[b];
    return closest_point_on_triangle(body.index->triangle(0), body.to_body(p));
  }

  std::optional<OwnedBodies> bodies_;
};

TEST(EffectsBudget, ANearMagnetPullsBeforeAFartherOne) {
  Random random(7301);
  int capped = 0;
  for (int scene = 0; scene < 60; ++scene) {
    const std::size_t count = 2 + static_cast<std::size_t>(scene) % 30;
    const Magnets magnets(random, count);
    const WorkUnits budget =
        1 + static_cast<WorkUnits>(random.uniform(0.0, 20.0 * static_cast<double>(count)));
    FreeProxy proxy(magnets.world(), with_effects_budget(budget));
    const Vec3 p = random.in_box(1.0);
    const Vec3 force_N = proxy.force_N(p);
    // The sum of the pulls of the nearest k, for one k.
    std::size_t k = 0;
    Vec3 sum_N = Vec3::Zero();
    const auto is_sum = [&] {
      return (force_N - sum_N).norm() <= 1e-12 * static_cast<double>(count);
    };
    const auto order = magnets.by_distance(p);
    while (!is_sum() && k < count) sum_N += magnets.pull_N(order[k++], p);
    ASSERT_TRUE(is_sum()) << "scene " << scene << ", budget " << budget;
    ASSERT_TRUE(proxy.is_capped() || k == count) << "scene " << scene << ", budget " << budget;
    capped += proxy.is_capped();
  }
  EXPECT_GT(capped, 20);
}

TEST(EffectsBudget, ChangesNoBitWhileItSuffices) {
  Random random(7302);
  const Magnets magnets(random, 12);
  FreeProxy with(magnets.world(), {});
  FreeProxy without(magnets.world(), with_effects_budget(kEnough));
  FreeProxy as_before(magnets.world(), with_effects_budget(1, CountingRule::kFirst));
  for (int tick = 0; tick < 2000; ++tick) {
    const Vec3 p = random.in_box(4.0);
    const Vec3 force_N = without.force_N(p);
    ASSERT_TRUE(are_same(with.force_N(p), force_N)) << tick;
    ASSERT_FALSE(with.is_capped());
    ASSERT_LE(with.work(), Accuracy{}.effects_budget());
    ASSERT_TRUE(are_same(as_before.force_N(p), force_N)) << tick;
    ASSERT_FALSE(as_before.is_capped()) << "the first rule has no budget";
  }
}

// A magnet of many triangles that are about equally near: the search of one tick does not end
// within the budget. The point found in a tick is one of the surface, no later one is farther while
// the hand rests, and in the end it is the nearest one.
TEST(EffectsBudget, ACappedMagnetPullsTowardsItsSurfaceAndSettlesWhenTheHandRests) {
  Random random(7303);
  Soup soup;
  constexpr double kRadius_m = 0.1;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 a = kRadius_m * random.unit_vector();
    soup.add(a, a + random.in_box(1e-3), a + random.in_box(1e-3));
  }
  OwnedBodies bodies({{soup, random.pose(0.2)}});
  const ContactBody& body = bodies.world().bodies[0];
  EffectProgramBuilder builder;
  builder.program.bodies.resize(1);
  builder.program.magnets.push_back({0, 0, body.index});
  builder.add_surroundings(effect_entry<MagnetEffect>({1.0, 1.0, &builder.program.magnets.back()}));
  bodies.set_effects(std::make_shared<const EffectProgram>(std::move(builder).finish()));
  double greatest_gain_m = 0.0;
  for (const WorkUnits budget : {1, 60, 1000}) {
    FreeProxy proxy(bodies.world(), with_effects_budget(budget));
    for (int place = 0; place < 20; ++place) {
      const Vec3 p = body.to_solver(random.in_box(1e-3));
      const double least_m = body.index->closest_point(body.to_body(p), 1.0)->distance_m;
      double last_m = 1.0;
      int ticks = 0;
      do {
        const Vec3 force_N = proxy.force_N(p);
        const double distance_m = 1.0 - std::sqrt(force_N.norm());
        const Vec3 end = p + distance_m * force_N.normalized();
        ASSERT_LE(body.index->closest_point(body.to_body(end), 1.0)->distance_m, 1e-12);
        ASSERT_LE(distance_m, last_m + 1e-15) << "tick " << ticks;
        ASSERT_GE(distance_m, least_m - 1e-15);
        if (ticks > 0) greatest_gain_m = std::max(greatest_gain_m, last_m - distance_m);
        last_m = distance_m;
      } while (proxy.is_capped() && ++ticks < 10'000);
      ASSERT_LT(ticks, 10'000) << "budget " << budget;
      ASSERT_GT(ticks, 0) << "budget " << budget;
      ASSERT_NEAR(last_m, least_m, 1e-15);
      ASSERT_TRUE(are_same(proxy.force_N(p), proxy.force_N(p))) << "at rest";
      ASSERT_FALSE(proxy.is_capped());
    }
  }
  EXPECT_GT(greatest_gain_m, 1e-5);
}

// Against all triangles one by one; with and without a stretch.
TEST(EffectsBudget, FindsTheNearestPointOfASurface) {
  Random random(7307);
  for (int scene = 0; scene < 40; ++scene) {
    Soup soup;
    const int count = 1 << (scene % 13);
    for (int i = 0; i < count; ++i) {
      const Vec3 a = random.in_box(0.5);
      const double size = std::pow(10.0, random.uniform(-3.0, 0.0));
      const Vec3 c = a + random.in_box(size);
      soup.add(a, a + random.in_box(size), c);
    }
    const SurfaceIndex index(SurfaceMesh::build(soup.positions, soup.triangles));
    const double along_y = random.uniform(0.2, 5.0);
    const Vec3 factors(random.uniform(0.2, 5.0), along_y, 1.0);
    const Mat3 linear = random.rotation().toRotationMatrix() * factors.asDiagonal();
    const Stretch stretch(linear, index.box());
    for (int query = 0; query < 30; ++query) {
      const Stretch* const used = query % 2 == 0 ? nullptr : &stretch;
      const Vec3 p = random.in_box(2.0);
      const double range = random.uniform(0.0, 4.0);
      double least = range;
      for (std::uint32_t slot = 0; slot < index.pack_count() * TrianglePack::kLanes; ++slot) {
        const TriangleGeometry& t = index.triangle(slot);
        const double distance = closest_point_on_triangle(used ? used->triangle(t) : t, p).distance;
        least = std::min(least, distance);
      }
      WorkMeter work(kEnough);
      NearestCursor cursor;
      const NearestResult found = find_nearest(index, used, p, range, true, cursor, work);
      ASSERT_FALSE(found.is_cut_short);
      ASSERT_EQ(found.nearest.has_value(), least < range) << "scene " << scene;
      if (!found.nearest) continue;
      ASSERT_EQ(found.nearest->distance, least) << "scene " << scene << ", query " << query;
      // Few packs are visited, not all of them.
      EXPECT_TRUE(count < 4096 || work.used() < 40 * static_cast<WorkUnits>(index.pack_count()));
    }
  }
}

// Media of closed meshes, each no obstacle, on a path through them. Each search takes many ticks.
TEST(EffectsBudget, ACappedMediumFindsItsSideWhenTheHandRests) {
  Random random(7304);
  const TriangleMesh ball = icosphere(3, 0.05);
  const SurfaceIndex index(SurfaceMesh::build(ball.positions_m, ball.triangles));
  Soup speck;
  speck.add({0.5, 0.5, 0.5}, {0.51, 0.5, 0.5}, {0.5, 0.51, 0.5});
  speck.add({-0.5, -0.5, -0.5}, {-0.51, -0.5, -0.5}, {-0.5, -0.51, -0.5});
  OwnedBodies bodies({{speck, {}}});
  constexpr std::size_t kMedia = 5;
  std::vector<Vec3> centres_m;
  EffectProgramBuilder builder;
  builder.program.bodies.resize(1);
  for (std::size_t i = 0; i < kMedia; ++i) {
    centres_m.push_back(random.in_box(0.03));
    MediumRegion region;
    region.shape = MediumRegion::Shape::kThrough;
    region.index = &index;
    region.p_region_solver.translation_m = -centres_m.back();
    builder.program.media.push_back(region);
    builder.add_surroundings(effect_entry<ViscosityEffect>(
        {std::ldexp(1.0, static_cast<int>(i)), &builder.program.media.back()}));
  }
  bodies.set_effects(std::make_shared<const EffectProgram>(std::move(builder).finish()));
  const Vec3 velocity(1.0, 0.0, 0.0);
  int capped = 0;
  int sides = 0;
  for (const WorkUnits budget : {1, 20, 100}) {
    FreeProxy proxy(bodies.world(), with_effects_budget(budget));
    FreeProxy free(bodies.world(), with_effects_budget(kEnough));
    for (int rest = 0; rest < 40; ++rest) {
      for (int tick = 0; tick < rest % 7; ++tick) {  // the hand moves while searches are cut short
        const Vec3 force_N = proxy.force_N(random.in_box(0.08), velocity);
        ASSERT_GE(0.0, force_N.x()) << "drag never pushes";
        capped += proxy.is_capped();
      }
      const Vec3 p = random.in_box(0.08);
      int ticks = 0;
      do {
        proxy.force_N(p, velocity);
      } while (proxy.is_capped() && ++ticks < 5000);
      ASSERT_LT(ticks, 5000) << "budget " << budget;
      const Vec3 force_N = proxy.force_N(p, velocity);
      double drag = 0.0;
      for (std::size_t i = 0; i < kMedia; ++i) {
        const double off_m = (p - centres_m[i]).norm() - 0.05;
        const bool is_certain = std::abs(off_m) > 2e-3;  // of the facets
        if (is_certain && off_m < 0.0) drag += std::ldexp(1.0, static_cast<int>(i));
        if (!is_certain) drag = NAN;
      }
      ASSERT_TRUE(are_same(force_N, free.force_N(p, velocity))) << "budget " << budget;
      if (std::isnan(drag)) continue;
      ASSERT_EQ(force_N.x(), -drag) << "budget " << budget << ", rest " << rest;
      ++sides;
    }
  }
  EXPECT_GT(capped, 100);
  EXPECT_GT(sides, 60);
}

TEST(EffectsBudget, LimitsTheWorkAndDoesNotDependOnTheInstructionSet) {
  // Beyond the budget: the distances of all places, and one pack whose triangles need exact signs.
  constexpr WorkUnits kMostBeyond =
      16 * (price_of(Work::kTriangle) + 9 * price_of(Work::kSignByExpansions)) +
      price_of(Work::kPack) + 64;
  Random random(7305);
  const Magnets magnets(random, 200);
  for (const WorkUnits budget : {1, 500, 5000}) {
    std::vector<Vec3> widest_N;
    for (const SimdLevel level : {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kBaseline}) {
      limit_simd_level(level);
      Random goals(7306);
      FreeProxy proxy(magnets.world(), with_effects_budget(budget));
      for (std::size_t tick = 0; tick < 300; ++tick) {
        const Vec3 force_N = proxy.force_N(goals.in_box(1.0));
        ASSERT_LE(proxy.work(), budget + kMostBeyond + 200 * price_of(Work::kPlace));
        if (level == SimdLevel::kAvx512) {
          widest_N.push_back(force_N);
        } else {
          ASSERT_TRUE(are_same(force_N, widest_N[tick])) << "budget " << budget << " " << tick;
        }
      }
    }
    limit_simd_level(SimdLevel::kAvx512);
  }
}

}  // namespace
}  // namespace palpate
