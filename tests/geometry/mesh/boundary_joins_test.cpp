#include "geometry/mesh/boundary_joins.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/mesh/boundary_vertices.h"
#include "geometry/mesh/point_tree.h"
#include "tests/helpers/generators.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::GeneratedMesh;
using test::Generators;
using test::Random;
using test::Soup;

WeldedSurface joined(const Soup& soup, const GapLimit& limit = {}) {
  auto surface = WeldedSurface::with_unused_positions(soup.positions, soup.triangles);
  surface.change(find_boundary_joins(surface, limit).changes);
  return surface;
}

bool same_bits(const Vec3& p, const Vec3& q) {
  for (int k = 0; k < 3; ++k) {
    if (std::bit_cast<std::uint64_t>(p[k]) != std::bit_cast<std::uint64_t>(q[k])) return false;
  }
  return true;
}

// Equal numbers, positions, faces and sources.
void expect_equal(const WeldedSurface& a, const WeldedSurface& b) {
  ASSERT_EQ(a.positions().size(), b.positions().size());
  ASSERT_EQ(a.face_count(), b.face_count());
  for (std::size_t v = 0; v < a.positions().size(); ++v) {
    ASSERT_TRUE(same_bits(a.positions()[v], b.positions()[v])) << "vertex " << v;
  }
  for (std::size_t f = 0; f < a.face_count(); ++f) {
    ASSERT_EQ(a.faces()[f], b.faces()[f]) << "face " << f;
    ASSERT_EQ(a.source_triangle(f), b.source_triangle(f)) << "face " << f;
  }
  EXPECT_EQ(a.report().dropped_degenerate, b.report().dropped_degenerate);
}

template <typename Real>
std::vector<GeneratedMesh> all_generated(Random& random) {
  std::vector<GeneratedMesh> all;
  for (const int columns : {3, 4, 7, 32, 50}) {
    for (GeneratedMesh& mesh : Generators<Real>::kinds(columns)) all.push_back(std::move(mesh));
  }
  for (int i = 0; i < 10; ++i) {
    const int rows = 3 + static_cast<int>(random.uniform(0, 20));
    const auto profile =
        Generators<Real>::vase(rows, static_cast<Real>(std::exp(random.uniform(-4, 4))),
                               static_cast<Real>(random.uniform(-0.3, 0.3)));
    const int columns = 3 + static_cast<int>(random.uniform(0, 40));
    const auto start = static_cast<Real>(i < 3 ? 0.0 : random.uniform(0, 6.28));
    all.push_back({"lathe " + std::to_string(i), Generators<Real>::lathe(profile, columns, start)});
  }
  return all;
}

template <typename Real>
void expect_twins() {
  Random random(4501);
  std::size_t open = 0;
  for (const GeneratedMesh& mesh : all_generated<Real>(random)) {
    SCOPED_TRACE(mesh.name + ", " + std::to_string(mesh.soup.positions.size()) + " positions");
    const Soup twin = test::twin_of(mesh.soup);
    const WeldedSurface exact(mesh.soup.positions, mesh.soup.triangles);
    open += exact.report().boundary_edges > 0 ? 1 : 0;
    const WeldedSurface surface = joined(mesh.soup);
    EXPECT_EQ(surface.report().boundary_edges, 0u);
    EXPECT_EQ(surface.report().non_manifold_edges, 0u);
    expect_equal(surface, WeldedSurface(twin.positions, twin.triangles));
  }
  EXPECT_GT(open, 20u);  // the generators do leave open seams
}

TEST(BoundaryJoins, GeneratorsInDoubleEqualTheirTwins) {
  expect_twins<double>();
}

TEST(BoundaryJoins, GeneratorsInFloatEqualTheirTwins) {
  expect_twins<float>();
}

// The file of a program that places a generated mesh, in float.
TEST(BoundaryJoins, GeneratorsPlacedInFloatHaveNoBoundary) {
  Random random(4502);
  for (const GeneratedMesh& mesh : Generators<float>::kinds(24)) {
    for (int i = 0; i < 5; ++i) {
      Soup placed = mesh.soup;
      const Vec3 by = random.in_box(i == 0 ? 0.0 : 3.0);
      for (Vec3& p : placed.positions) p = (p + by).cast<float>().cast<double>();
      EXPECT_EQ(joined(placed).report().boundary_edges, 0u) << mesh.name;
    }
  }
}

TEST(BoundaryJoins, AClosedSurfaceStaysTheSame) {
  for (const GeneratedMesh& mesh : Generators<double>::kinds(16)) {
    const Soup twin = test::twin_of(mesh.soup);
    const WeldedSurface exact(twin.positions, twin.triangles);
    ASSERT_EQ(exact.report().boundary_edges, 0u);
    EXPECT_TRUE(find_boundary_joins(exact).changes.empty());
  }
}

// A sheet of unit squares along x, of two rows that do not share vertices: the upper row has its
// vertices at other places, and is `gap` away.
struct Strip {
  Soup soup;
  std::size_t lower, upper;  // squares of the rows
};

Strip strip(std::size_t lower, std::size_t upper, double gap) {
  Strip strip{{}, lower, upper};
  const auto row = [&](std::size_t count, double from_y) {
    const auto first = static_cast<std::uint32_t>(strip.soup.positions.size());
    for (std::size_t i = 0; i <= count; ++i) {
      const double x = static_cast<double>(i) / static_cast<double>(count);
      strip.soup.positions.push_back({x, from_y, 0});
      strip.soup.positions.push_back({x, from_y + 0.25, 0});
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t a = first + 2 * i;
      strip.soup.triangles.push_back({a, a + 2, a + 1});
      strip.soup.triangles.push_back({a + 1, a + 2, a + 3});
    }
  };
  row(lower, 0.0);
  row(upper, 0.25 + gap);
  return strip;
}

double area_m2(const WeldedSurface& surface) {
  double area = 0.0;
  for (const Triangle& f : surface.faces()) {
    const auto p = surface.positions();
    area += 0.5 * (p[f[1]] - p[f[0]]).cross(p[f[2]] - p[f[0]]).norm();
  }
  return area;
}

// The corners of each face, from the positions of its source triangle.
void expect_pieces_of_sources(const WeldedSurface& surface, const Soup& soup, double near_m) {
  for (std::size_t f = 0; f < surface.face_count(); ++f) {
    const Triangle& source = soup.triangles[surface.source_triangle(f)];
    const FacePiece* piece = surface.sources().piece(f);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& p = surface.positions()[surface.faces()[f][i]];
      Vec3 expected = soup.positions[source[i]];
      if (piece) {
        const auto [second, third] = piece->corners[i];
        expected = (1 - second - third) * soup.positions[source[0]] +
                   second * soup.positions[source[1]] + third * soup.positions[source[2]];
      }
      EXPECT_LT((p - expected).norm(), near_m) << "face " << f << ", corner " << i;
    }
  }
}

TEST(BoundaryJoins, EdgesAreDividedAtVerticesThatLieOnThem) {
  Random random(4503);
  for (int round = 0; round < 60; ++round) {
    const auto lower = static_cast<std::size_t>(random.uniform(1, 12));
    const auto upper = static_cast<std::size_t>(random.uniform(1, 12));
    Strip s = strip(lower, upper, 0.0);
    const RigidTransform pose{random.rotation(), random.in_box(round % 3 == 0 ? 0.0 : 2.0)};
    const double far = round % 2 == 0 ? 1.0 : 1e-4;  // sizes
    for (std::size_t i = 0; i < s.soup.positions.size(); ++i) {
      Vec3& p = s.soup.positions[i];
      p = pose.point(far * p).cast<float>().cast<double>();
      if (i % 2 == 0) p[0] = std::nextafter(static_cast<float>(p[0]), 9.0f);  // no two are equal
    }
    SCOPED_TRACE(std::to_string(lower) + " and " + std::to_string(upper) + " squares");
    const WeldedSurface exact(s.soup.positions, s.soup.triangles);
    const WeldedSurface surface = joined(s.soup);
    // By definition, the edges of the perimeter stay open.
    if (far == 1.0) {
      EXPECT_EQ(surface.report().boundary_edges, lower + upper + 4);
      std::set<std::pair<std::size_t, std::size_t>> places;
      for (std::size_t i = 0; i <= lower; ++i) places.insert({i * upper, 0});
      for (std::size_t i = 0; i <= upper; ++i) places.insert({i * lower, 0});
      EXPECT_EQ(surface.report().joined_edges, places.size() - 1);
      EXPECT_EQ(surface.report().welded_vertices, lower + upper + 2 + places.size());
      EXPECT_NEAR(area_m2(surface), 0.5, 1e-5);
    }
    EXPECT_EQ(surface.report().non_manifold_edges, 0u);
    const CleaningReport& r = surface.report();
    EXPECT_EQ(r.triangles_in + r.added_triangles,
              r.triangles + r.dropped_degenerate + r.dropped_duplicate);
    expect_pieces_of_sources(surface, s.soup, 1e-5);
  }
}

TEST(BoundaryJoins, AGapBeyondTheBoundStaysOpenAndClosesOnDemand) {
  Random random(4504);
  for (const double gap : {3e-6, 1e-4, 2e-3}) {
    for (const auto& [lower, upper] : {std::pair(5, 5), {5, 3}, {1, 4}}) {
      Strip s = strip(lower, upper, gap);
      const RigidTransform pose = random.pose(0.5);
      for (Vec3& p : s.soup.positions) p = pose.point(p);
      const WeldedSurface exact(s.soup.positions, s.soup.triangles);
      EXPECT_TRUE(find_boundary_joins(exact).changes.empty());
      const auto below = find_boundary_joins(exact, {Mat3::Identity(), 0.999 * gap});
      EXPECT_TRUE(below.changes.empty());
      const GapLimit above{Mat3::Identity(), 1.001 * gap};
      EXPECT_NEAR(find_boundary_joins(exact, above).nearest_m, gap, 1e-9);
      EXPECT_EQ(joined(s.soup, above).report().boundary_edges,
                static_cast<std::size_t>(lower + upper + 4));
    }
  }
}

// Details smaller than the bound: nothing may vanish.
TEST(BoundaryJoins, ASurfaceSmallerThanTheBoundKeepsItsFaces) {
  Random random(4505);
  for (int round = 0; round < 200; ++round) {
    const double size = std::exp(random.uniform(-18, -10));
    Soup soup;
    const Vec3 far = random.in_box(1.0);
    for (int i = 0; i < 12; ++i) {
      const Vec3 a = far + size * random.in_box(1.0);
      soup.add((a + size * random.in_box(0.5)).cast<float>().cast<double>(),
               (a + size * random.in_box(0.5)).cast<float>().cast<double>(),
               (a + size * random.in_box(0.5)).cast<float>().cast<double>());
    }
    const WeldedSurface exact(soup.positions, soup.triangles);
    const WeldedSurface surface = joined(soup);
    EXPECT_EQ(surface.report().dropped_degenerate, exact.report().dropped_degenerate);
  }
}

// A ribbon that is narrower than the bound has its two sides within the bound of each other.
TEST(BoundaryJoins, ARibbonNarrowerThanTheBoundStaysOpen) {
  Soup soup;
  for (int i = 0; i <= 20; ++i) {
    soup.positions.push_back({0.05 * i, 0.0, 0.0});
    soup.positions.push_back({0.05 * i, 1e-8, 0.0});
  }
  for (std::uint32_t i = 0; i < 40; i += 2) {
    soup.triangles.push_back({i, i + 2, i + 1});
    soup.triangles.push_back({i + 1, i + 2, i + 3});
  }
  const WeldedSurface surface = joined(soup);
  EXPECT_EQ(surface.face_count(), 40u);
  EXPECT_EQ(surface.report().joined_vertices, 0u);
}

// Three sheets that end at one line: no pair is one to one.
TEST(BoundaryJoins, ThreeSheetsAtALineStayOpen) {
  Soup soup;
  for (int k = 0; k < 3; ++k) {
    const double a = 2.1 * k, off = 1e-9 * k;
    soup.add({0, 0, off}, {1, 0, off}, {0.5, std::cos(a), std::sin(a)});
  }
  std::swap(soup.triangles[1][0], soup.triangles[1][1]);
  EXPECT_TRUE(find_boundary_joins(WeldedSurface(soup.positions, soup.triangles)).changes.empty());
}

TEST(BoundaryJoins, ManyEdgesAtFewPointsTakeBoundedWork) {
  Random random(4506);
  Soup soup;
  std::vector<Vec3> points;
  for (int i = 0; i < 40; ++i) points.push_back(random.in_box(1.0));
  const auto near = [&] {
    const auto i = static_cast<std::size_t>(random.uniform(0, 39.99));
    return Vec3(points[i] + random.in_box(1e-9));
  };
  for (int i = 0; i < 20000; ++i) soup.add(near(), near(), near());
  const WeldedSurface exact(soup.positions, soup.triangles);
  const BoundaryJoins joins = find_boundary_joins(exact);
  EXPECT_GT(joins.ambiguous_edges, 10000u);
  EXPECT_EQ(joined(soup).report().dropped_degenerate, exact.report().dropped_degenerate);
}

// Triangles that all cross each other have edges that pass many vertices.
TEST(BoundaryJoins, LongEdgesOfManyTrianglesTakeBoundedWork) {
  Random random(4610);
  Soup soup;
  constexpr std::size_t kTriangles = 40000;
  for (std::size_t i = 0; i < kTriangles; ++i) {
    soup.add(random.in_box(1.0), random.in_box(1.0), random.in_box(1.0));
  }
  const BoundaryJoins joins = find_boundary_joins(WeldedSurface(soup.positions, soup.triangles));
  EXPECT_LE(joins.examined_leaves, (std::size_t{1} << 21) + 2 * 6 * kTriangles);
  EXPECT_GT(joins.capped_edges, 0u);
}

// Every edge on a line passes all vertices of the shorter ones.
TEST(BoundaryJoins, EdgesThatPassAllVerticesTakeBoundedWorkAndAreCounted) {
  const auto nested = [](int count) {
    Random random(4508);
    Soup soup;
    for (int i = 0; i < count; ++i) {
      const double in = 0.499 * i / count;
      soup.add({in, 0, 0}, {1 - in, 0, 0}, {0.5, random.uniform(-1, 1), random.uniform(0.1, 1)});
    }
    return find_boundary_joins(WeldedSurface(soup.positions, soup.triangles));
  };
  const BoundaryJoins few = nested(1000);
  const BoundaryJoins many = nested(8000);
  EXPECT_GT(few.capped_edges, 500u);
  EXPECT_GT(many.capped_edges, 4000u);
  EXPECT_LE(many.capped_edges, many.ambiguous_edges);
  EXPECT_LT(many.examined_leaves, 16 * few.examined_leaves);
}

TEST(PointTree, FindsThePointsInABoxAndNearASegment) {
  Random random(4507);
  for (const std::size_t count : {0u, 1u, 8u, 9u, 100u, 3000u}) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) {
      Vec3 p = random.in_box(1.0);
      if (i % 3 == 0) p = (8 * p).array().round() / 8;  // equal coordinates
      points.push_back(p);
    }
    const PointTree tree(points);
    for (int round = 0; round < 50; ++round) {
      const Vec3 a = (8 * random.in_box(1.0)).array().round() / 8, b = random.in_box(1.0);
      const Box box{a.cwiseMin(b), a.cwiseMax(b)};
      std::set<std::uint32_t> found, expected;
      tree.visit_box(box, [&](std::uint32_t i) { return found.insert(i).second; });
      for (std::uint32_t i = 0; i < count; ++i) {
        if (box.contains(points[i])) expected.insert(i);
      }
      EXPECT_EQ(found, expected);
      const double margin = 0.1;
      std::set<std::uint32_t> near;
      std::size_t leaves = 10000;
      tree.visit_segment(a, b, Vec3::Constant(margin), leaves,
                         [&](std::uint32_t i) { return near.insert(i).second; });
      for (std::uint32_t i = 0; i < count; ++i) {
        const double t = std::clamp((points[i] - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
        if ((points[i] - a - t * (b - a)).norm() < 0.999 * margin) {
          EXPECT_TRUE(near.contains(i));
        }
      }
    }
  }
}

}  // namespace
}  // namespace palpate
