// The nearest surface point of a moving point, against a search of all triangles.

#include "haptics/strategies/nearest_place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/exact/triangle.h"
#include "geometry/index/simd.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::OwnedBodies;
using test::Random;

constexpr WorkUnits kEnough = 1'000'000'000;

// Two hard bodies at random poses, with and without a tree over them.
OwnedBodies nearby_bodies(Random& random) {
  std::vector<OwnedBodies::Placed> placed;
  for (int b = 0; b < 3; ++b) {
    const auto kind = test::kAllHardKinds[random.index(std::size(test::kAllHardKinds))];
    placed.push_back({hard_scene(kind, random).soup, random.pose(0.1)});
  }
  return OwnedBodies(placed, 0.0, random.index(2) == 0);
}

double least_distance_m(const LiveWorld& world, const Vec3& p) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const ContactBody& body : world.bodies()) {
    for (std::uint32_t pack = 0; pack < body.index->pack_count(); ++pack) {
      for (int lane = 0; lane < body.index->pack(pack).count; ++lane) {
        const TriangleGeometry& t = body.index->triangle(SurfaceIndex::slot(pack, lane));
        least_m = std::min(least_m, closest_point_on_triangle(t, body.to_body(p)).distance);
      }
    }
  }
  return least_m;
}

TEST(NearestPlace, IsTheNearestOfAllTriangles) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const OwnedBodies bodies = nearby_bodies(random);
    LiveWorld world(bodies.world());
    world.place(1, random.pose(0.1));
    NearestPlace nearest;
    for (int n = 0; n < 50; ++n) {
      nearest.forget();
      const Vec3 p = random.in_box(0.2);
      const double reach_m = random.uniform(1e-3, 0.1);
      WorkMeter work(kEnough);
      const auto place = nearest.update(world, p, reach_m, work);
      const double least_m = least_distance_m(world, p);
      ASSERT_FALSE(nearest.is_cut_short());
      ASSERT_EQ(place.has_value(), least_m <= reach_m) << "seed " << seed << ", point " << n;
      if (!place) continue;
      ++found;
      ASSERT_EQ(place->distance_m, least_m) << "seed " << seed << ", point " << n;
      const double rounding_m = 64 * 0x1p-52;
      ASSERT_NEAR((p - place->point_m).norm(), place->distance_m, rounding_m);
      ASSERT_NEAR(place->direction.norm(), 1.0, 8 * 0x1p-52);
    }
  }
  EXPECT_GT(found, 500);
}

// While p moves by small steps, q is never farther than the nearest point by more than kNearer_m,
// and it is the nearest point whenever a step has made it jump.
TEST(NearestPlace, IsFollowedToWithinTheMargin) {
  int jumps = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const OwnedBodies bodies = nearby_bodies(random);
    const LiveWorld world(bodies.world());
    NearestPlace nearest;
    constexpr double kReach_m = 0.05;
    Vec3 p = random.in_box(0.15);
    Vec3 heading = random.unit_vector();
    std::optional<SurfacePlace> last;
    Vec3 last_p = p;
    for (int n = 0; n < 400; ++n) {
      if (n % 80 == 0) heading = (random.in_box(0.1) - p).normalized();
      p += 2e-4 * heading;
      WorkMeter work(kEnough);
      const auto place = nearest.update(world, p, kReach_m, work);
      const double least_m = least_distance_m(world, p);
      if (place) {
        ASSERT_LE(place->distance_m, least_m + NearestPlace::kNearer_m);
        const double slid_m = last ? (place->point_m - last->point_m).norm() : 0.0;
        const double most_m = NearestPlace::kSlide * (p - last_p).norm() + 1e-9;
        if (last && place->face != last->face && slid_m > most_m) {
          ++jumps;
          ASSERT_EQ(place->distance_m, least_m) << "seed " << seed << ", tick " << n;
        }
      } else {
        ASSERT_GT(least_m + NearestPlace::kNearer_m, kReach_m);
      }
      last = place;
      last_p = p;
    }
  }
  EXPECT_GT(jumps, 20);
}

test::Soup square(double half_m, int strips) {
  test::Soup soup;
  const double width_m = 2 * half_m / strips;
  for (int i = 0; i < strips; ++i) {
    const double x = -half_m + i * width_m;
    soup.add_quad({x, -half_m, 0}, {x + width_m, -half_m, 0}, {x + width_m, half_m, 0},
                  {x, half_m, 0});
  }
  return soup;
}

// Between two walls 20 mm apart, a hand that trembles by less than half the margin keeps its wall.
TEST(NearestPlace, DoesNotAlternateBetweenTwoWalls) {
  Random random(41);
  const RigidTransform frame = random.pose(0.1);
  const auto at = [&](double x, double y, double z) { return frame.point({x, y, z}); };
  const OwnedBodies bodies({{square(0.1, 8), {frame.rotation, at(0, 0, 0)}},
                            {square(0.1, 8), {frame.rotation, at(0, 0, 0.02)}}});
  const LiveWorld world(bodies.world());
  NearestPlace nearest;
  const auto body_at = [&](const Vec3& p) {
    WorkMeter work(kEnough);
    return nearest.update(world, p, 0.015, work)->face.body;
  };
  EXPECT_EQ(body_at(at(0, 0, 0.0098)), 0u);
  for (int n = 0; n < 1000; ++n) {
    const double z = 0.01 + random.uniform(-0.24e-3, 0.24e-3);
    ASSERT_EQ(body_at(at(0.05 * std::sin(0.01 * n), 0.0, z)), 0u) << n;
  }
  EXPECT_EQ(body_at(at(0, 0, 0.01 + 0.26e-3)), 1u);
  for (int n = 0; n < 1000; ++n) {
    ASSERT_EQ(body_at(at(0, 0, 0.01 + random.uniform(-0.24e-3, 0.24e-3))), 1u) << n;
  }
}

// q follows p over the faces of a wall in every tick: the margin is between places, not faces.
TEST(NearestPlace, SlidesOverTheFacesOfAWall) {
  Random random(42);
  const RigidTransform frame = random.pose(0.1);
  const OwnedBodies bodies({{square(0.1, 200), frame}});
  const LiveWorld world(bodies.world());
  NearestPlace nearest;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 along(-0.09 + 1.8e-4 * n, 0.02, 0.0);
    WorkMeter work(kEnough);
    const auto place = nearest.update(world, frame.point(along + Vec3(0, 0, 0.015)), 0.02, work);
    ASSERT_TRUE(place);
    ASSERT_LT((place->point_m - frame.point(along)).norm(), 1e-15) << n;
  }
}

// A search that has spent its budget has no result, and the next one goes on with the last q. The
// work of a search is the same at every width of the vector instructions.
TEST(NearestPlace, HasNoResultWithoutBudget) {
  Random random(43);
  for (int trial = 0; trial < 20; ++trial) {
    const OwnedBodies bodies = nearby_bodies(random);
    const LiveWorld world(bodies.world());
    const Vec3 p = random.in_box(0.1);
    WorkMeter whole(kEnough);
    NearestPlace nearest;
    const auto place = nearest.update(world, p, 0.1, whole);
    if (!place) continue;
    for (const SimdLevel level : {SimdLevel::kBaseline, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
      const SimdLevel widest = widest_simd_level();
      limit_simd_level(level);
      NearestPlace other;
      WorkMeter work(kEnough);
      const auto same = other.update(world, p, 0.1, work);
      limit_simd_level(widest);
      ASSERT_TRUE(same);
      EXPECT_EQ(same->face, place->face);
      EXPECT_EQ(same->point_m, place->point_m);
      EXPECT_EQ(work.used(), whole.used());
    }
    NearestPlace poor;
    WorkMeter less(whole.used());
    EXPECT_FALSE(poor.update(world, p, 0.1, less));
    EXPECT_TRUE(poor.is_cut_short());
    WorkMeter one(1);
    EXPECT_FALSE(nearest.update(world, p, 0.1, one));
    WorkMeter again(kEnough);
    const auto kept = nearest.update(world, p, 0.1, again);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->distance_m, place->distance_m);
  }
}

// A search of the whole world counts each body and each pack.
TEST(NearestPlace, CountsItsWork) {
  Random random(44);
  const OwnedBodies bodies({{square(0.1, 400), random.pose(0.1)}});
  const LiveWorld world(bodies.world());
  const auto packs = static_cast<WorkUnits>(world.body(0).index->pack_count());
  ASSERT_GE(packs, 50);
  NearestPlace nearest;
  WorkMeter work(kEnough);
  // The first ball, a sixteenth of the reach, already holds the world.
  ASSERT_TRUE(nearest.update(world, random.in_box(0.1), 16.0, work));
  EXPECT_GE(work.used(),
            price_of(Work::kBody) + packs * price_of(Work::kPack) + price_of(Work::kNearestPoint));
  EXPECT_LE(work.used(),
            price_of(Work::kBody) + packs * (price_of(Work::kPack) + price_of(Work::kBoxes) +
                                             16 * price_of(Work::kNearestPoint)));
}

}  // namespace
}  // namespace palpate
