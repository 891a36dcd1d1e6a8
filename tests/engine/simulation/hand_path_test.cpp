// Paths that a hand follows several times.

#include "engine/simulation/hand_path.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

HandPath random_path(test::Random& random, bool is_closed) {
  HandPath path;
  for (int i = 0; i < 6; ++i) {
    path.points.push_back({random.in_box(1.0), random.in_box(1.0).normalized(),
                           i == 0 ? 0.0 : random.uniform(-1.0, 1.0), i == 3});
  }
  if (is_closed) path.points.back().p_m = path.points.front().p_m;
  path.points.back().inward = path.points[path.points.size() - 2].inward;
  return path;
}

TEST(HandPath, RepeatedPassesEachLegOncePerLap) {
  test::Random random(6);
  const HandPath path = random_path(random, true);
  const std::size_t legs = path.points.size() - 1;
  for (const int laps : {1, 2, 5}) {
    const HandPath all = repeated(path, laps);
    ASSERT_EQ(all.points.size(), static_cast<std::size_t>(laps) * legs + 1);
    for (std::size_t i = 0; i < all.points.size(); ++i) {
      EXPECT_EQ(all.points[i].p_m, path.points[i % legs].p_m) << i;
      if (i + 1 == all.points.size()) continue;
      EXPECT_EQ(all.points[i].inward, path.points[i % legs].inward) << i;
    }
  }
}

TEST(HandPath, ToAndFroTurnsAtTheEndsAndStaysOnItsSideOfTheWalls) {
  test::Random random(7);
  const HandPath path = random_path(random, false);
  const std::size_t legs = path.points.size() - 1;
  for (const int laps : {1, 2, 3, 4}) {
    const HandPath all = to_and_fro(path, laps);
    ASSERT_EQ(all.points.size(), static_cast<std::size_t>(laps) * legs + 1);
    for (std::size_t i = 0; i < all.points.size(); ++i) {
      const std::size_t along = i % (2 * legs);
      const bool is_back = along > legs || (along == legs && i + 1 < all.points.size());
      const std::size_t point = along > legs ? 2 * legs - along : along;
      EXPECT_EQ(all.points[i].p_m, path.points[point].p_m) << i;
      if (i + 1 == all.points.size()) continue;
      EXPECT_EQ(all.points[i].inward, path.points[is_back ? point - 1 : point].inward) << i;
      EXPECT_TRUE(all.points[i].is_turn || i == 0 || i % legs != 0) << i;
    }
  }
}

}  // namespace
}  // namespace palpate
