#include "geometry/mesh/section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

struct Mesh {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

struct Plane {
  Vec3 normal;
  double offset_m;
};

Mesh posed(Mesh mesh, const RigidTransform& pose) {
  for (Vec3& p : mesh.positions) p = pose.point(p);
  return mesh;
}

// The plane through a point, in the target frame of a pose.
Plane posed_plane(const Vec3& normal, const Vec3& point, const RigidTransform& pose) {
  const Vec3 n = pose.direction(normal).normalized();
  return {n, n.dot(pose.point(point))};
}

std::vector<Polyline> section(const Mesh& mesh, const Plane& plane) {
  return plane_section(mesh.positions, mesh.triangles, plane.normal, plane.offset_m);
}

// Positive if the inside is on the left, seen from the tip of the normal.
double signed_area_m2(const Polyline& curve, const Vec3& normal) {
  Vec3 twice = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < curve.points_m.size(); ++i) {
    twice +=
        (curve.points_m[i] - curve.points_m[0]).cross(curve.points_m[i + 1] - curve.points_m[0]);
  }
  return 0.5 * normal.dot(twice);
}

Mesh box(const Vec3& half_extent) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back(((i & 1) ? 1 : -1) * half_extent.x(),
                                ((i & 2) ? 1 : -1) * half_extent.y(),
                                ((i & 4) ? 1 : -1) * half_extent.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// Points of the unit sphere by longitude and latitude.
Mesh unit_sphere(std::uint32_t meridians, std::uint32_t parallels) {
  Mesh mesh;
  mesh.positions = {Vec3(0, 0, 1), Vec3(0, 0, -1)};
  const auto at = [&](std::uint32_t i, std::uint32_t j) {
    return 2 + (i % meridians) * parallels + j;
  };
  for (std::uint32_t i = 0; i < meridians; ++i) {
    for (std::uint32_t j = 0; j < parallels; ++j) {
      const double u = 2.0 * std::numbers::pi * i / meridians;
      const double v = std::numbers::pi * (j + 1) / (parallels + 1);
      mesh.positions.emplace_back(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u),
                                  std::cos(v));
      if (j + 1 == parallels) continue;
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
    mesh.triangles.push_back({0, at(i, 0), at(i + 1, 0)});
    mesh.triangles.push_back({1, at(i + 1, parallels - 1), at(i, parallels - 1)});
  }
  return mesh;
}

// The welded surface of a set of unit cells. It is closed, and not manifold where cells meet only
// at an edge or a corner.
using Cell = std::array<int, 3>;
Mesh welded_faces_of(const std::set<Cell>& cells) {
  Mesh mesh;
  std::map<Cell, std::uint32_t> vertices;
  const auto vertex = [&](const Cell& at) {
    const auto [it, added] = vertices.emplace(at, static_cast<std::uint32_t>(vertices.size()));
    if (added) mesh.positions.emplace_back(at[0], at[1], at[2]);
    return it->second;
  };
  for (const Cell& cell : cells) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        Cell neighbour = cell;
        neighbour[axis] += side == 1 ? 1 : -1;
        if (cells.count(neighbour)) continue;
        std::array<Cell, 4> corners;
        corners.fill(cell);
        for (Cell& corner : corners) corner[axis] += side;
        const std::size_t u = (axis + 1) % 3;
        const std::size_t v = (axis + 2) % 3;
        ++corners[1][u], ++corners[2][u], ++corners[2][v], ++corners[3][v];
        if (side == 0) std::swap(corners[1], corners[3]);
        mesh.triangles.push_back({vertex(corners[0]), vertex(corners[1]), vertex(corners[2])});
        mesh.triangles.push_back({vertex(corners[0]), vertex(corners[2]), vertex(corners[3])});
      }
    }
  }
  return mesh;
}

// The section of a convex body: the points where the plane meets the box's twelve edges, in order
// around the middle.
std::vector<Vec3> convex_section_of_box(const std::vector<Vec3>& corners, const Plane& plane) {
  std::vector<Vec3> points;
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < 8; ++i) {
    for (const std::size_t bit : {1u, 2u, 4u}) {
      const std::size_t j = i | bit;
      if (i == j) continue;
      const double hi = plane.normal.dot(corners[i]) - plane.offset_m;
      const double hj = plane.normal.dot(corners[j]) - plane.offset_m;
      if (hi * hj >= 0.0) continue;
      points.push_back((corners[i] * hj - corners[j] * hi) / (hj - hi));
      middle += points.back();
    }
  }
  middle /= static_cast<double>(points.size());
  const Vec3 u = plane.normal.unitOrthogonal();
  const Vec3 v = plane.normal.cross(u);
  const auto angle = [&](const Vec3& p) {
    return std::atan2((p - middle).dot(v), (p - middle).dot(u));
  };
  std::sort(points.begin(), points.end(),
            [&](const Vec3& a, const Vec3& b) { return angle(a) < angle(b); });
  return points;
}

TEST(PlaneSection, OfABoxAcrossAnAxisIsARectangle) {
  test::Random random(301);
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 half(random.uniform(0.1, 1.0), random.uniform(0.1, 1.0), random.uniform(0.1, 1.0));
    const RigidTransform pose = random.pose(2.0);
    const int axis = static_cast<int>(random.index(3));
    const double sign = random.index(2) == 0 ? 1.0 : -1.0;
    const Plane plane = posed_plane(
        sign * Vec3::Unit(axis), Vec3::Unit(axis) * random.uniform(-0.9, 0.9) * half[axis], pose);
    const std::vector<Polyline> curves = section(posed(box(half), pose), plane);
    ASSERT_EQ(curves.size(), 1u);
    EXPECT_TRUE(curves[0].closed);
    EXPECT_EQ(curves[0].points_m.size(), 4u);  // points between the corners are collinear
    const double a = 2.0 * half[(axis + 1) % 3];
    const double b = 2.0 * half[(axis + 2) % 3];
    EXPECT_NEAR(length_m(curves[0]), 2.0 * (a + b), 1e-13);
    EXPECT_NEAR(signed_area_m2(curves[0], plane.normal), a * b, 1e-13);
  }
}

TEST(PlaneSection, OfABoxByAnyPlaneIsAConvexPolygonThroughItsEdges) {
  test::Random random(302);
  for (int trial = 0; trial < 1000; ++trial) {
    const RigidTransform pose = random.pose(2.0);
    const Mesh mesh = posed(box(Vec3(0.3, 0.5, 0.8)), pose);
    const Plane plane = posed_plane(random.unit_vector(), random.in_box(0.3), pose);
    const std::vector<Polyline> curves = section(mesh, plane);
    ASSERT_EQ(curves.size(), 1u);
    ASSERT_TRUE(curves[0].closed);
    const Polyline expected{convex_section_of_box(mesh.positions, plane), true};
    EXPECT_NEAR(length_m(curves[0]), length_m(expected), 1e-11);
    EXPECT_NEAR(signed_area_m2(curves[0], plane.normal), signed_area_m2(expected, plane.normal),
                1e-11);
    for (const Vec3& p : curves[0].points_m) {
      EXPECT_NEAR(plane.normal.dot(p), plane.offset_m, 1e-14);
    }
  }
}

TEST(PlaneSection, OfASphereIsACircleToSecondOrder) {
  test::Random random(303);
  const std::uint32_t count = 120;
  const double step_rad = 2.0 * std::numbers::pi / count;
  const Mesh sphere = unit_sphere(count, count / 2);
  for (int trial = 0; trial < 30; ++trial) {
    const RigidTransform pose = random.pose(5.0);
    const double height_m = random.uniform(-0.8, 0.8);
    const Vec3 direction = random.unit_vector();
    const Plane plane = posed_plane(direction, height_m * direction, pose);
    const std::vector<Polyline> curves = section(posed(sphere, pose), plane);
    ASSERT_EQ(curves.size(), 1u);
    ASSERT_TRUE(curves[0].closed);
    const double radius_m = std::sqrt(1.0 - height_m * height_m);
    // The error of a chord of one step is step^2 / 8; a face's diagonal is sqrt(2) steps long.
    const double error_m = step_rad * step_rad / 4.0 / radius_m;
    const double perimeter_m = 2.0 * std::numbers::pi * radius_m;
    EXPECT_LT(length_m(curves[0]), perimeter_m);
    EXPECT_NEAR(length_m(curves[0]), perimeter_m, 2.0 * std::numbers::pi * error_m);
    EXPECT_NEAR(signed_area_m2(curves[0], plane.normal), std::numbers::pi * radius_m * radius_m,
                perimeter_m * error_m);
    for (const Vec3& p : curves[0].points_m) {
      EXPECT_NEAR((p - pose.translation_m - height_m * plane.normal).norm(), radius_m, error_m);
    }
  }
}

TEST(PlaneSection, OfASlabWithAHoleHasTheOutlineFirstAndTheHoleReversed) {
  test::Random random(304);
  std::set<Cell> cells;
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 4; ++y) {
      if (x != 2 || y != 1) cells.insert({x, y, 0});
    }
  }
  const Mesh slab = welded_faces_of(cells);
  for (int trial = 0; trial < 100; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    const double sign = random.index(2) == 0 ? 1.0 : -1.0;
    const Plane plane = posed_plane(Vec3(0, 0, sign), Vec3(0, 0, random.uniform(0.1, 0.9)), pose);
    const std::vector<Polyline> curves = section(posed(slab, pose), plane);
    ASSERT_EQ(curves.size(), 2u);
    EXPECT_TRUE(curves[0].closed && curves[1].closed);
    EXPECT_EQ(curves[0].points_m.size(), 4u);
    EXPECT_EQ(curves[1].points_m.size(), 4u);
    EXPECT_NEAR(length_m(curves[0]), 18.0, 1e-12);
    EXPECT_NEAR(length_m(curves[1]), 4.0, 1e-12);
    EXPECT_NEAR(signed_area_m2(curves[0], plane.normal), 20.0, 1e-12);
    EXPECT_NEAR(signed_area_m2(curves[1], plane.normal), -1.0, 1e-12);
  }
}

// Random cells have many edges with four faces, and lattice planes contain whole faces. The plane z
// = k counts as just below k, so the section is layer k - 1.
TEST(PlaneSection, OfRandomCellsIsClosedAndEnclosesTheMaterialOfTheLayer) {
  test::Random random(305);
  for (int trial = 0; trial < 400; ++trial) {
    std::set<Cell> cells;
    for (std::size_t i = random.index(80); i > 0; --i) {
      const auto coordinate = [&] { return static_cast<int>(random.index(4)); };
      const int x = coordinate();
      const int y = coordinate();
      cells.insert({x, y, coordinate()});
    }
    const Mesh mesh = welded_faces_of(cells);
    const std::size_t axis = random.index(3);
    const double sign = random.index(2) == 0 ? 1.0 : -1.0;
    const double level = 0.5 * static_cast<double>(random.index(9));
    // With a reversed normal, "just below" along the normal is just above along the axis.
    const int layer = static_cast<int>(sign > 0.0 ? std::ceil(level) - 1.0 : std::floor(level));
    double area = 0.0;
    double perimeter = 0.0;
    for (const Cell& cell : cells) {
      if (cell[axis] != layer) continue;
      area += 1.0;
      for (const std::size_t across : {(axis + 1) % 3, (axis + 2) % 3}) {
        for (const int side : {-1, 1}) {
          Cell neighbour = cell;
          neighbour[across] += side;
          perimeter += cells.count(neighbour) ? 0.0 : 1.0;
        }
      }
    }
    const Plane plane = {sign * Vec3::Unit(static_cast<int>(axis)), sign * level};
    double found_area = 0.0;
    double found_perimeter = 0.0;
    for (const Polyline& curve : section(mesh, plane)) {
      EXPECT_TRUE(curve.closed);
      found_area += signed_area_m2(curve, plane.normal);
      found_perimeter += length_m(curve);
    }
    ASSERT_DOUBLE_EQ(found_area, area) << "trial " << trial;
    ASSERT_DOUBLE_EQ(found_perimeter, perimeter) << "trial " << trial;
  }
}

TEST(PlaneSection, SeparatesMaterialThatMeetsAtAnEdge) {
  test::Random random(306);
  const Mesh two = welded_faces_of({{0, 0, 0}, {1, 1, 0}});
  const Mesh four = welded_faces_of({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {0, 2, 0}});
  for (int trial = 0; trial < 100; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    const double sign = random.index(2) == 0 ? 1.0 : -1.0;
    const Plane plane = posed_plane(Vec3(0, 0, sign), Vec3(0, 0, random.uniform(0.1, 0.9)), pose);
    for (const auto& [mesh, count] : {std::pair(&two, 2u), std::pair(&four, 4u)}) {
      const std::vector<Polyline> curves = section(posed(*mesh, pose), plane);
      ASSERT_EQ(curves.size(), count);
      for (const Polyline& curve : curves) {
        EXPECT_TRUE(curve.closed);
        EXPECT_EQ(curve.points_m.size(), 4u);
        EXPECT_NEAR(signed_area_m2(curve, plane.normal), 1.0, 1e-13);
      }
    }
  }
}

TEST(PlaneSection, ThroughVerticesContainsThemExactly) {
  const Mesh octahedron = {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Vec3 normal = sign * Vec3::Unit(axis);
      const std::vector<Polyline> curves = section(octahedron, {normal, 0.0});
      ASSERT_EQ(curves.size(), 1u);
      EXPECT_TRUE(curves[0].closed);
      ASSERT_EQ(curves[0].points_m.size(), 4u);
      for (const Vec3& p : curves[0].points_m) {
        EXPECT_EQ(std::count(octahedron.positions.begin(), octahedron.positions.end(), p), 1);
      }
      EXPECT_DOUBLE_EQ(signed_area_m2(curves[0], normal), 2.0);
      // A plane through a single tip gives no curve, because the curve has no length.
      EXPECT_TRUE(section(octahedron, {normal, 1.0}).empty());
      EXPECT_TRUE(section(octahedron, {normal, -1.0}).empty());
    }
  }
}

TEST(PlaneSection, OfAnOpenSheetIsOpenAndEndsOnItsBoundary) {
  test::Random random(307);
  for (int trial = 0; trial < 100; ++trial) {
    const RigidTransform pose = random.pose(1.0);
    const Mesh sheet =
        posed({{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}}, pose);
    const double x = random.uniform(0.1, 1.9);
    const Plane plane = posed_plane(Vec3::UnitX(), Vec3(x, 0, 0), pose);
    const std::vector<Polyline> curves = section(sheet, plane);
    ASSERT_EQ(curves.size(), 1u);
    EXPECT_FALSE(curves[0].closed);
    ASSERT_EQ(curves[0].points_m.size(), 2u);
    // Seen from the tip of x with z up, y points right: the back side, -z, is on the left of a
    // curve towards -y.
    EXPECT_LE((curves[0].points_m[0] - pose.point(Vec3(x, 1, 0))).norm(), 1e-14);
    EXPECT_LE((curves[0].points_m[1] - pose.point(Vec3(x, 0, 0))).norm(), 1e-14);
  }
}

TEST(PlaneSection, EndsBetweenNeighboursOfOppositeOrientation) {
  Mesh mesh = box(Vec3::Ones());
  for (const std::size_t t : {4u, 5u}) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  const std::vector<Polyline> curves = section(mesh, {Vec3::UnitZ(), 0.25});
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_FALSE(curves[0].closed || curves[1].closed);
  EXPECT_DOUBLE_EQ(length_m(curves[0]), 6.0);
  EXPECT_DOUBLE_EQ(length_m(curves[1]), 2.0);
}

TEST(PlaneSection, OfAnySoupHasTheLengthOfAllSegments) {
  test::Random random(308);
  for (int trial = 0; trial < 500; ++trial) {
    Mesh soup;
    for (int i = 0; i < 12; ++i) soup.positions.push_back(random.in_box(1.0));
    for (std::size_t i = random.index(60); i > 0; --i) {
      Triangle t;
      for (std::uint32_t& v : t) v = static_cast<std::uint32_t>(random.index(12));
      soup.triangles.push_back(t);
    }
    const Plane plane = posed_plane(random.unit_vector(), random.in_box(0.5), {});
    double expected = 0.0;
    for (const Triangle& t : soup.triangles) {
      std::vector<Vec3> ends;
      for (std::size_t e = 0; e < 3; ++e) {
        const Vec3& a = soup.positions[t[e]];
        const Vec3& b = soup.positions[t[(e + 1) % 3]];
        const double ha = plane.normal.dot(a) - plane.offset_m;
        const double hb = plane.normal.dot(b) - plane.offset_m;
        if (ha * hb < 0.0) ends.push_back((a * hb - b * ha) / (hb - ha));
      }
      if (ends.size() == 2) expected += (ends[0] - ends[1]).norm();
    }
    double found = 0.0;
    double longest = std::numeric_limits<double>::infinity();
    for (const Polyline& curve : section(soup, plane)) {
      found += length_m(curve);
      EXPECT_LE(length_m(curve), longest);
      longest = length_m(curve);
    }
    ASSERT_NEAR(found, expected, 1e-9) << "trial " << trial;
  }
}

TEST(PlaneSection, IsEmptyBesideTheSurface) {
  EXPECT_TRUE(section(box(Vec3::Ones()), {Vec3::UnitX(), 1.5}).empty());
  EXPECT_TRUE(section(box(Vec3::Ones()), {Vec3::UnitX(), -1.5}).empty());
  EXPECT_TRUE(plane_section({}, {}, Vec3::UnitX(), 0.0).empty());
}

}  // namespace
}  // namespace palpate
