// BoxTree finds all boxes near a point or a segment, in order, with the same result every time.

#include "geometry/index/box_tree.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/index/simd.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

std::vector<std::uint32_t> boxes_near(const BoxTree& tree, const Vec3& p, double radius_m,
                                      NearSearch search) {
  std::vector<std::uint32_t> found;
  tree.visit_near(
      p, radius_m, search,
      [](void* state, std::uint32_t box) {
        static_cast<std::vector<std::uint32_t>*>(state)->push_back(box);
        return true;
      },
      &found);
  return found;
}

std::vector<std::uint32_t> boxes_along(const BoxTree& tree, const Vec3& p, const Vec3& d,
                                       double radius_m, std::uint32_t first) {
  std::vector<std::uint32_t> found;
  tree.visit_along(
      p, d, radius_m, first,
      [](void* state, std::uint32_t box) {
        static_cast<std::vector<std::uint32_t>*>(state)->push_back(box);
        return true;
      },
      &found);
  return found;
}

std::vector<Box> some_boxes(Random& random, std::size_t count, double size_m) {
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 low = random.in_box(1.0);
    boxes.push_back({low, low + random.in_box(size_m).cwiseAbs()});
  }
  return boxes;
}

// Few boxes, so that Embree finds all of them at once, and very many boxes.
TEST(BoxTree, FindsEachBoxInOrderWithEachInstructionSet) {
  Random random(41);
  constexpr double kSweep_m = 0.1;
  for (const auto& [count, size_m] : {std::pair(17, 0.5), {300, 0.3}, {5000, 0.05}, {2000, 1.5}}) {
    const auto boxes = some_boxes(random, static_cast<std::size_t>(count), size_m);
    const BoxTree tree(boxes, kSweep_m);
    for (int trial = 0; trial < 100; ++trial) {
      const Vec3 p = random.in_box(1.5);
      const Vec3 d = random.in_box(1.0);
      const double radius_m = random.uniform(0.0, kSweep_m);
      limit_simd_level(SimdLevel::kAvx512);
      const auto near_p = boxes_near(tree, p, radius_m, NearSearch::kInOrder);
      const auto along_d = boxes_along(tree, p, d, radius_m, 0);
      ASSERT_TRUE(std::is_sorted(near_p.begin(), near_p.end()));
      ASSERT_TRUE(std::is_sorted(along_d.begin(), along_d.end()));
      for (const SimdLevel level : {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kBaseline}) {
        limit_simd_level(level);
        ASSERT_EQ(boxes_near(tree, p, radius_m, NearSearch::kWithEmbree), near_p);
        ASSERT_EQ(boxes_near(tree, p, radius_m, NearSearch::kInOrder), near_p);
        ASSERT_EQ(boxes_along(tree, p, d, radius_m, 0), along_d);
      }
      for (std::uint32_t i = 0; i < boxes.size(); ++i) {
        const Box& box = boxes[i];
        if (box.squared_distance(p) <= radius_m * radius_m) {
          ASSERT_TRUE(std::binary_search(near_p.begin(), near_p.end(), i));
        }
        double enter = 0.0;
        double leave = 1.0;
        if (box.clip(p, d, enter, leave)) {
          ASSERT_TRUE(std::binary_search(along_d.begin(), along_d.end(), i));
        }
      }
      if (along_d.empty()) continue;
      const std::size_t from = random.index(along_d.size());
      const std::vector<std::uint32_t> rest(along_d.begin() + static_cast<std::ptrdiff_t>(from),
                                            along_d.end());
      ASSERT_EQ(boxes_along(tree, p, d, radius_m, along_d[from]), rest);
    }
  }
}

TEST(BoxTree, StopsWhenTheVisitorReturnsFalse) {
  Random random(42);
  const BoxTree tree(some_boxes(random, 5000, 1.5), 0.0);
  for (const auto search : {NearSearch::kWithEmbree, NearSearch::kInOrder}) {
    int visited = 0;
    tree.visit_near(
        Vec3::Zero(), 0.1, search,
        [](void* state, std::uint32_t) { return ++*static_cast<int*>(state) < 3; }, &visited);
    EXPECT_EQ(visited, 3);
  }
}

}  // namespace
}  // namespace palpate
