// Faces that are close together are consecutive in the order, however small they are compared with
// the scene.

#include "geometry/index/face_order.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/box.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Soup;

// Small triangles at random positions in a box.
Soup confetti(test::Random& random, std::size_t count, double size_m) {
  Soup soup;
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    const Vec3 middle = random.in_box(size_m);
    for (int k = 0; k < 3; ++k) {
      soup.positions.push_back(middle + random.in_box(0.01 * size_m));
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

std::vector<std::uint32_t> order_of(const Soup& soup) {
  std::vector<std::uint32_t> order(soup.triangles.size());
  order_faces({soup.positions, soup.triangles, {}}, order);
  return order;
}

// The mean extent of the boxes around groups of sixteen faces. Only groups whose faces are all
// below `count` are included; nearly all such faces must be in these groups.
double mean_extent(const Soup& soup, std::size_t count) {
  const std::vector<std::uint32_t> order = order_of(soup);
  double sum = 0.0;
  std::size_t packs = 0;
  for (std::size_t begin = 0; begin + 16 <= order.size(); begin += 16) {
    const auto faces = std::span(order).subspan(begin, 16);
    if (*std::max_element(faces.begin(), faces.end()) >= count) continue;
    Box box{soup.positions[soup.triangles[faces[0]][0]],
            soup.positions[soup.triangles[faces[0]][0]]};
    for (const std::uint32_t f : faces) {
      for (const std::uint32_t v : soup.triangles[f]) {
        box = box.united({soup.positions[v], soup.positions[v]});
      }
    }
    sum += (box.high - box.low).sum();
    ++packs;
  }
  EXPECT_GT(packs, (count / 16) * 9 / 10);
  return sum / static_cast<double>(packs);
}

TEST(FaceOrder, HasEveryFaceOnce) {
  test::Random random(7205);
  for (const std::size_t count : {0, 1, 15, 16, 17, 255, 256, 257, 4096, 5000, 30011}) {
    std::vector<std::uint32_t> order = order_of(confetti(random, count, 1.0));
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(order[i], i) << count;
  }
}

// By definition, a median split of 512 faces puts the 256 faces of each half on their side along
// the widest axis, to the precision of the places.
TEST(FaceOrder, PutsTheHalvesOnTheirSidesOfTheMedian) {
  test::Random random(7206);
  for (int i = 0; i < 50; ++i) {
    Soup soup = confetti(random, 512, 1.0);
    for (Vec3& p : soup.positions) p.y() *= 3.0;
    const std::vector<std::uint32_t> order = order_of(soup);
    const auto place = [&](std::uint32_t f) {
      const Triangle& t = soup.triangles[f];
      return soup.positions[t[0]].y() + soup.positions[t[1]].y() + soup.positions[t[2]].y();
    };
    double low = -1e9;
    double high = 1e9;
    for (std::size_t k = 0; k < 256; ++k) low = std::max(low, place(order[k]));
    for (std::size_t k = 256; k < 512; ++k) high = std::min(high, place(order[k]));
    EXPECT_LE(low, high + 18 * 0x1p-24);  // three coordinates of up to 3, rounded to single
  }
}

void add(const Soup& part, const Vec3& middle, Soup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (const Vec3& p : part.positions) soup.positions.push_back(middle + p);
  for (const Triangle& t : part.triangles) {
    soup.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
}

// A cluster of faces that is very small compared with the scene is ordered as if it were alone. The
// cluster is around the origin, where coordinates keep their precision. It has most, half or few of
// the faces.
TEST(FaceOrder, OrdersAClusterHoweverSmallComparedWithTheScene) {
  constexpr std::size_t kCount = 20000;
  for (const std::size_t others : {40, 10000, 20000, 100000}) {
    for (const double size_m : {1e-3, 1e-6, 1e-9, 1e-12, 1e-50, 1e-150}) {
      // The middle of the scene is inside or outside the cluster, or the other faces surround the
      // cluster.
      for (const double side : {-10.0, -11.0, 0.0}) {
        test::Random random(7207);
        Soup soup = confetti(random, kCount, size_m);
        const double alone = mean_extent(soup, kCount);
        Soup other = confetti(random, others / 2, side == 0.0 ? 10.0 : 1.0);
        add(other, -side * Vec3(1.0, 0.1, 0.1), soup);
        for (Vec3& p : other.positions) p = -p;
        add(other, side * Vec3(1.0, 0.1, 0.1), soup);
        EXPECT_LE(mean_extent(soup, kCount), 1.1 * alone)
            << size_m << " m beside " << others << " at " << side;
      }
    }
  }
}

TEST(FaceOrder, SeparatesTheFacesOfTwoSmallClusters) {
  constexpr std::size_t kCount = 16384;
  for (const double size_m : {1e-3, 1e-5, 1e-7, 1e-9}) {
    test::Random random(7210);
    const Soup cluster = confetti(random, kCount, size_m);
    Soup two;
    for (const double side : {-1.0, 1.0}) add(cluster, Vec3(side, 0.0, 0.0), two);
    EXPECT_LE(mean_extent(two, 2 * kCount), 1.1 * mean_extent(cluster, kCount)) << size_m;
  }
}

// Sizes below the range of single precision, and all faces in one place.
TEST(FaceOrder, AcceptsAnySize) {
  constexpr std::size_t kCount = 3000;
  test::Random random(7208);
  const Soup unit = confetti(random, kCount, 1.0);
  const double of_unit = mean_extent(unit, kCount);
  for (const double scale : {1e-290, 1e-120, 1e-50, 1e50, 1e120}) {
    Soup soup = unit;
    for (Vec3& p : soup.positions) p *= scale;
    EXPECT_NEAR(mean_extent(soup, kCount) / scale, of_unit, 0.1 * of_unit) << scale;
  }
  // A power of two causes no rounding. For the largest power, the sum of three corners and the
  // extent of the scene exceed the range of a double.
  const std::vector<std::uint32_t> order_of_unit = order_of(unit);
  for (const int exponent : {-900, -60, 60, 900, 1022, 1023}) {
    Soup soup = unit;
    for (Vec3& p : soup.positions) p *= std::ldexp(1.0, exponent);
    EXPECT_EQ(order_of(soup), order_of_unit) << "2^" << exponent;
  }
  Soup stack = unit;
  for (Triangle& t : stack.triangles) t = {0, 1, 2};
  std::vector<std::uint32_t> order = order_of(stack);
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < kCount; ++i) ASSERT_EQ(order[i], i);
}

// Nested clusters of decreasing size: in every round, most faces are in one bin.
TEST(FaceOrder, TerminatesForNestedClusters) {
  test::Random random(7209);
  Soup soup;
  double size_m = 1.0;
  for (int level = 0; level < 100; ++level, size_m /= 1000.0) {
    add(confetti(random, 200, size_m), Vec3::Zero(), soup);
  }
  std::vector<std::uint32_t> order = order_of(soup);
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
}

}  // namespace
}  // namespace palpate
