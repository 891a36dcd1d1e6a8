// Boxes that may meet a marked box, and boundary vertices of a mesh. The references apply the
// definitions to every pair of boxes and to every edge.

#include "geometry/index/touching_boxes.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/mesh/boundary_vertices.h"
#include "geometry/mesh/point_grid.h"
#include "geometry/mesh/shared_cells.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

bool meet(const Box& a, const Box& b) {
  for (int k = 0; k < 3; ++k) {
    if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
  }
  return true;
}

std::vector<bool> by_definition(const std::vector<Box>& boxes, const std::vector<bool>& marked) {
  std::vector<bool> touches(boxes.size(), false);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if ((marked[i] || marked[j]) && meet(boxes[i], boxes[j])) touches[i] = touches[j] = true;
    }
  }
  return touches;
}

struct Crowd {
  std::vector<Box> boxes;
  std::vector<bool> marked;
};

Crowd random_crowd(Random& random, std::size_t count, double size, double marked) {
  Crowd crowd;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 middle = random.in_box(1.0);
    const Vec3 half = 0.5 * random.uniform(0.0, size) * Vec3::Ones();
    crowd.boxes.push_back({middle - half, middle + half});
    crowd.marked.push_back(random.uniform(0.0, 1.0) < marked);
  }
  return crowd;
}

TEST(TouchingBoxes, MatchTheDefinitionIfFewBoxesOverlap) {
  Random random(41);
  for (int trial = 0; trial < 200; ++trial) {
    const Crowd crowd = random_crowd(random, 2 + random.index(500), random.uniform(0.0, 0.2),
                                     random.uniform(0.0, 1.0));
    const std::vector<bool> found = may_touch_marked(crowd.boxes, crowd.marked);
    EXPECT_EQ(found, by_definition(crowd.boxes, crowd.marked));
  }
}

TEST(TouchingBoxes, IncludeEveryBoxInACrowd) {
  Random random(42);
  for (int trial = 0; trial < 100; ++trial) {
    const Crowd crowd = random_crowd(random, 2 + random.index(500), random.uniform(0.0, 4.0), 0.1);
    const std::vector<bool> found = may_touch_marked(crowd.boxes, crowd.marked);
    const std::vector<bool> expected = by_definition(crowd.boxes, crowd.marked);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_LE(expected[i], found[i]);
  }
}

TEST(TouchingBoxes, ExcludeBoxesOfALatticeThatAlmostTouches) {
  std::vector<Box> boxes;
  for (int i = 0; i < 8000; ++i) {
    const Vec3 low(i % 20, i / 20 % 20, i / 400);
    boxes.push_back({low, (low.array() + 0.99).matrix()});
  }
  const std::vector<bool> marked(boxes.size(), true);
  EXPECT_EQ(may_touch_marked(boxes, marked), std::vector<bool>(boxes.size(), false));
  for (Box& box : boxes) box.high.array() += 0.01;
  EXPECT_EQ(may_touch_marked(boxes, marked), std::vector<bool>(boxes.size(), true));
}

TEST(BoundaryVertices, AreAtTheEndsOfWeldedEdgesWithOneFace) {
  Random random(43);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Vec3> positions;
    for (int v = 0; v < 12; ++v) positions.push_back(random.in_box(1.0));
    std::vector<Triangle> triangles;
    for (std::uint64_t t = 1 + random.index(30); t > 0; --t) {
      Triangle corners;
      for (auto& corner : corners) corner = static_cast<std::uint32_t>(random.index(12));
      triangles.push_back(corners);
    }
    const WeldedSurface mesh(positions, triangles);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> faces_at;
    for (const Triangle& t : mesh.faces()) {
      for (std::size_t i = 0; i < 3; ++i) {
        ++faces_at[std::minmax({t[i], t[(i + 1) % 3]})];
      }
    }
    std::vector<std::uint32_t> expected;
    for (const auto& [edge, faces] : faces_at) {
      if (faces == 1) expected.insert(expected.end(), {edge.first, edge.second});
    }
    std::sort(expected.begin(), expected.end());
    expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
    EXPECT_EQ(boundary_vertices(mesh), expected);
  }
}

TEST(PointGrid, VisitsAllPointsNearby) {
  Random random(44);
  std::vector<Vec3> points;
  for (int i = 0; i < 500; ++i) points.push_back(random.in_box(1.0));
  PointGrid grid(0.11, points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) grid.insert(points[i], i);
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 p = random.in_box(1.1);
    std::vector<bool> named(points.size(), false);
    EXPECT_TRUE(grid.visit_near(p, 0.05, [&](std::uint32_t i) { return named[i] = true; }));
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_TRUE(named[i] || (points[i] - p).norm() > 0.05);
    }
  }
}

TEST(OccupiedCells, IncludeAllPointsNearbyAndFewOthers) {
  Random random(45);
  for (const bool is_flat : {false, true}) {
    std::vector<Vec3> points;
    for (int i = 0; i < 50; ++i) {
      points.push_back(random.in_box(1.0));
      if (is_flat) points.back().z() = 0.25;
    }
    Box box{points[0], points[0]};
    for (const Vec3& p : points) box = box.united({p, p});
    const double margin = 1e-3;
    OccupiedCells cells(is_flat ? box : box.grown(margin), margin);
    for (const Vec3& p : points) cells.mark(p);
    for (const Vec3& p : points) EXPECT_TRUE(cells.may_hold(p));
    int named = 0;
    for (int trial = 0; trial < 10'000; ++trial) {
      const Vec3 p = random.index(2) == 0 ? random.in_box(1.1)
                                          : Vec3(points[random.index(50)] + random.in_box(margin));
      const auto is_near = [&](const Vec3& q) { return (p - q).norm() <= margin; };
      const bool expected = std::any_of(points.begin(), points.end(), is_near);
      named += cells.may_hold(p) ? 1 : 0;
      EXPECT_TRUE(cells.may_hold(p) || !expected || !box.contains(p));
    }
    EXPECT_LT(named, 6000);
  }
}

TEST(PointGrid, ExaminesOnlyTheDocumentedNumberOfPointsOfACrowd) {
  PointGrid grid(1.0, 100'000);
  for (std::uint32_t i = 0; i < 100'000; ++i) grid.insert(Vec3(0.5, 0.5, 0.5), i);
  std::size_t visited = 0;
  EXPECT_FALSE(grid.visit_near(Vec3(0.5, 0.5, 0.5), 0.1, [&](std::uint32_t) {
    ++visited;
    return true;
  })) << "the return value does not report the incomplete visit";
  EXPECT_EQ(visited, PointGrid::kMostVisited);
}

TEST(PointGrid, StopsWhenTheVisitorReturnsFalse) {
  PointGrid grid(1.0, 100'000);
  for (std::uint32_t i = 0; i < 100'000; ++i) grid.insert(Vec3(0.5, 0.5, 0.5), i);
  std::size_t visited = 0;
  EXPECT_TRUE(
      grid.visit_near(Vec3(0.5, 0.5, 0.5), 0.1, [&](std::uint32_t) { return ++visited < 3; }));
  EXPECT_EQ(visited, 3u);
}

TEST(SharedCells, IncludeAllPointsNearOtherOwnersAndFewOthers) {
  Random random(46);
  constexpr double kNear_m = 1e-3;
  std::vector<std::pair<Vec3, std::uint32_t>> points;  // with their owners
  for (int i = 0; i < 3000; ++i) {
    const bool is_by_another = i > 0 && random.index(3) == 0;
    const Vec3 p = is_by_another ? Vec3(points[random.index(i)].first + random.in_box(kNear_m))
                                 : random.in_box(1.0);
    points.emplace_back(p, static_cast<std::uint32_t>(random.index(4)));
  }
  SharedCells cells(64 * kNear_m / 10, points.size());
  for (const auto& [p, owner] : points) EXPECT_TRUE(cells.add(p, owner));
  for (const auto& [p, owner] : points) cells.share_near(p, kNear_m, owner);
  int named = 0;
  int expected = 0;
  for (const auto& point : points) {
    const bool is_met = std::any_of(points.begin(), points.end(), [&](const auto& other) {
      return other.second != point.second && (other.first - point.first).norm() <= kNear_m;
    });
    EXPECT_TRUE(cells.is_shared(point.first) || !is_met);
    named += cells.is_shared(point.first) ? 1 : 0;
    expected += is_met ? 1 : 0;
  }
  EXPECT_GT(expected, 500);
  EXPECT_LT(named, 2 * expected);
  EXPECT_FALSE(SharedCells(1.0, 10).share_near(Vec3(0.5, 0.5, 0.5), 0.1, 0))
      << "an empty grid has no shared cell";
}

TEST(SharedCells, FindAllPointsOfAMeshNearAddedPointsAndFewOthers) {
  Random random(47);
  constexpr double kNear_m = 1e-9;
  std::vector<Vec3> mesh;
  for (int i = 0; i < 3000; ++i) mesh.push_back(random.in_box(1.0));
  for (const double offset_m : {0.0, 1.0, 1e5}) {
    SharedCells::Map map{Mat3::Zero(), offset_m * random.in_box(1.0), Vec3::Ones()};
    for (int k = 0; k < 3; ++k) map.linear.row(k) = random.in_box(2.0).transpose();
    const auto mapped = [&](std::size_t i) -> Vec3 {
      return map.linear * mesh[i] + map.translation;
    };
    SharedCells cells(64 * kNear_m, 3000);
    for (int i = 0; i < 3000; ++i) {
      const bool is_near = i % 3 == 0;
      const Vec3 p = is_near ? Vec3(mapped(random.index(mesh.size())) + random.in_box(kNear_m))
                             : Vec3(map.linear * random.in_box(1.0) + map.translation);
      EXPECT_TRUE(cells.add(p, 0));
    }
    std::vector<std::uint32_t> near;
    cells.find_near(SharedCells::Points(mesh), map, kNear_m, near);
    EXPECT_TRUE(std::is_sorted(near.begin(), near.end()));
    std::size_t expected = 0;
    for (std::uint32_t i = 0; i < mesh.size(); ++i) {
      if (!cells.share_near(mapped(i), kNear_m, 1)) continue;
      ++expected;
      EXPECT_TRUE(std::binary_search(near.begin(), near.end(), i)) << "point " << i;
    }
    EXPECT_GT(expected, 500u);
    // A hundredth of the marks is used, so that few others share one.
    EXPECT_LT(near.size(), expected + mesh.size() / 10) << "offset " << offset_m;
  }
}

TEST(SharedCells, ReportACrowdOfOneOwner) {
  SharedCells cells(1.0, 200);
  const Vec3 p(0.5, 0.5, 0.5);
  for (std::uint32_t owner = 0; owner < 100; ++owner) EXPECT_TRUE(cells.add(p, owner));
  for (std::uint64_t i = 1; i < SharedCells::kCrowd; ++i) EXPECT_TRUE(cells.add(p, 100));
  EXPECT_FALSE(cells.add(p, 100));
  EXPECT_TRUE(cells.add(p, 101));
  EXPECT_TRUE(cells.is_shared(p));
}

}  // namespace
}  // namespace palpate
