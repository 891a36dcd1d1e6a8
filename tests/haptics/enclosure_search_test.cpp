// Which closed surfaces enclose a point: boxes in closed form, in random poses.

#include "haptics/enclosure_search.h"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::OwnedWorld;
using test::Random;
using test::Soup;

struct PlacedBox {
  Vec3 half_m;
  Vec3 centre_m;

  bool contains(const Vec3& p) const {
    return ((p - centre_m).cwiseAbs() - half_m).maxCoeff() < 0.0;
  }
  double distance_to_surface_m(const Vec3& p) const {
    return std::abs(((p - centre_m).cwiseAbs() - half_m).maxCoeff());
  }
  void add_to(Soup& soup) const {
    const Soup box = test::box_soup(half_m);
    for (const Triangle& t : box.triangles) {
      soup.add(box.positions[t[0]] + centre_m, box.positions[t[1]] + centre_m,
               box.positions[t[2]] + centre_m);
    }
  }
};

PlacedBox random_box(Random& random) {
  return {Vec3(random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1)),
          random.in_box(0.7)};
}

EnclosingBodySearch::State searched(const OwnedWorld& world, const ClosedParts& parts,
                                    const Vec3& p_scene, WorkUnits units, int& calls) {
  const LiveWorld live(world.world());
  const std::vector<const ClosedParts*> of_bodies{&parts};
  EnclosingBodySearch search(of_bodies);
  search.begin();
  auto state = EnclosingBodySearch::State::kSearches;
  for (calls = 0; state == EnclosingBodySearch::State::kSearches && calls < 100'000; ++calls) {
    WorkMeter work(units);
    state = search.search(live, world.world().to_solver(p_scene), work);
  }
  return state;
}

// A point is enclosed if any of the boxes contains it: overlaps and cavities, too. Plates enclose
// nothing. However little work a call may do, the result is the same.
TEST(EnclosureSearch, FindsWhetherAnyClosedPartEnclosesAPoint) {
  Random random(4601);
  constexpr WorkUnits kAll = std::numeric_limits<WorkUnits>::max();
  int inside = 0, outside = 0, cut_short = 0;
  for (int scene = 0; scene < 40; ++scene) {
    Soup soup;
    std::vector<PlacedBox> boxes;
    for (int n = static_cast<int>(random.index(4)); n >= 0; --n) {
      boxes.push_back(random_box(random));
      boxes.back().add_to(soup);
    }
    for (int plate = static_cast<int>(random.index(4)); plate > 0; --plate) {
      const Vec3 at = random.in_box(1.0);
      soup.add_quad(at, at + Vec3(1, 0.1, 0), at + Vec3(1, 1, 0.2), at + Vec3(0, 1, 0.1));
    }
    const RigidTransform T_scene_body{random.rotation(), random.in_box(3.0)};
    const OwnedWorld world(soup, T_scene_body);
    const ClosedParts parts = closed_parts(world.mesh().faces());
    ASSERT_EQ(parts.count, boxes.size());
    for (int k = 0; k < 25; ++k) {
      const Vec3 p = random.in_box(1.1);
      bool is_inside = false, is_near = false;
      for (const PlacedBox& box : boxes) {
        is_inside = is_inside || box.contains(p);
        is_near = is_near || box.distance_to_surface_m(p) < 1e-6;
      }
      if (is_near) continue;
      (is_inside ? inside : outside) += 1;
      const auto expected =
          is_inside ? EnclosingBodySearch::State::kInside : EnclosingBodySearch::State::kOutside;
      int calls = 0;
      EXPECT_EQ(searched(world, parts, T_scene_body.point(p), kAll, calls), expected);
      EXPECT_EQ(calls, 1);
      EXPECT_EQ(searched(world, parts, T_scene_body.point(p), 1, calls), expected);
      cut_short += calls > 1;
    }
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
  EXPECT_GT(cut_short, 100);
}

TEST(EnclosureSearch, HasNoAnswerOnASurface) {
  const OwnedWorld world(test::box_soup({1, 1, 1}));
  const ClosedParts parts = closed_parts(world.mesh().faces());
  int calls = 0;
  const LiveWorld live(world.world());
  const std::vector<const ClosedParts*> of_bodies{&parts};
  EnclosingBodySearch search(of_bodies);
  search.begin();
  for (; calls < 10; ++calls) {
    WorkMeter work(std::numeric_limits<WorkUnits>::max());
    EXPECT_EQ(search.search(live, Vec3(1, 0.25, 0.5), work), EnclosingBodySearch::State::kSearches);
  }
  // Once the point is off the surface, there is one.
  WorkMeter work(std::numeric_limits<WorkUnits>::max());
  EXPECT_EQ(search.search(live, Vec3(0.5, 0.25, 0.5), work), EnclosingBodySearch::State::kInside);
  EXPECT_EQ(search.body(), 0u);
}

}  // namespace
}  // namespace palpate
