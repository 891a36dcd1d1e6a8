#include "geometry/index/surface_index.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/exact/segment_triangle.h"
#include "geometry/index/simd.h"
#include "models/primitives.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Random;

struct NamedMesh {
  const char* name;
  SurfaceMesh mesh;
};

SurfaceMesh random_surface(Random& random, int triangles) {
  test::Soup soup;
  for (int i = 0; i < triangles; ++i) {
    const Vec3 a = random.in_box(1.0);
    soup.add(a, a + random.in_box(0.2), a + random.in_box(0.2));
  }
  return SurfaceMesh::build(soup.positions, soup.triangles);
}

std::vector<NamedMesh> meshes(Random& random) {
  std::vector<NamedMesh> all;
  const auto sphere = icosphere(3, 1.0);
  const auto ring = torus(1.0, 0.25, 2);
  all.push_back({"sphere", SurfaceMesh::build(sphere.positions_m, sphere.triangles)});
  all.push_back({"torus", SurfaceMesh::build(ring.positions_m, ring.triangles)});
  all.push_back({"soup", random_surface(random, 500)});
  all.push_back({"one triangle", random_surface(random, 1)});
  return all;
}

// The reference: every triangle, one by one.
double brute_force_distance(const SurfaceIndex& index, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::uint32_t id = 0; id < index.pack_count(); ++id) {
    for (int lane = 0; lane < index.pack(id).count; ++lane) {
      nearest = std::min(
          nearest,
          closest_point_on_triangle(index.triangle(SurfaceIndex::slot(id, lane)), p).distance);
    }
  }
  return nearest;
}

TEST(SurfaceIndex, FindsTheClosestPointWithinTheRadiusOrReturnsNoValue) {
  Random random(31);
  for (const NamedMesh& named : meshes(random)) {
    SCOPED_TRACE(named.name);
    const SurfaceIndex index(named.mesh);
    for (int trial = 0; trial < 300; ++trial) {
      const Vec3 p = random.in_box(1.5);
      const double expected = brute_force_distance(index, p);
      const double radius = random.uniform(0.0, 1.0);
      const auto found = index.closest_point(p, radius);
      ASSERT_EQ(found.has_value(), expected <= radius);
      if (!found) continue;
      ASSERT_EQ(found->distance_m, expected);
      ASSERT_NEAR((found->point_m - p).norm(), expected, 1e-15 * (1 + p.norm()));
    }
  }
}

TEST(SurfaceIndex, MeasuresDistanceToASphereWithinItsFacets) {
  Random random(32);
  const int level = 4;
  const TriangleMesh sphere = icosphere(level, 0.1);
  const SurfaceMesh mesh = SurfaceMesh::build(sphere.positions_m, sphere.triangles);
  const SurfaceIndex index(mesh);
  double edge_m = 0.0;
  for (const Triangle& t : sphere.triangles) {
    edge_m = std::max(edge_m, (sphere.positions_m[t[0]] - sphere.positions_m[t[1]]).norm());
  }
  const double sagitta_m = edge_m * edge_m / (6 * 0.1) * 1.01;  // h^2 / (6 R), plus 1 %
  for (int trial = 0; trial < 1000; ++trial) {
    const Vec3 p = random.uniform(0.0, 0.2) * random.unit_vector();
    const auto found = index.closest_point(p, 1.0);
    ASSERT_TRUE(found);
    ASSERT_NEAR(found->distance_m, std::abs(p.norm() - 0.1), sagitta_m);
  }
}

TEST(SurfaceIndex, ListsThePackOfEveryTriangleNearby) {
  Random random(33);
  for (const NamedMesh& named : meshes(random)) {
    SCOPED_TRACE(named.name);
    const SurfaceIndex index(named.mesh);
    std::vector<std::uint32_t> packs(index.pack_count());
    for (int trial = 0; trial < 100; ++trial) {
      const Vec3 p = random.in_box(1.2);
      const double radius = random.uniform(0.0, 0.3);
      const std::size_t count = index.packs_near(p, radius, packs);
      const auto listed = [&](std::uint32_t id) {
        return std::find(packs.begin(), packs.begin() + static_cast<std::ptrdiff_t>(count), id) !=
               packs.begin() + static_cast<std::ptrdiff_t>(count);
      };
      for (std::uint32_t id = 0; id < index.pack_count(); ++id) {
        for (int lane = 0; lane < index.pack(id).count; ++lane) {
          const auto nearest =
              closest_point_on_triangle(index.triangle(SurfaceIndex::slot(id, lane)), p);
          if (nearest.distance <= radius) {
            ASSERT_TRUE(listed(id));
          }
        }
      }
    }
  }
}

TEST(SurfaceIndex, ReportsMorePacksNearThanFit) {
  Random random(34);
  const SurfaceMesh mesh = random_surface(random, 500);
  const SurfaceIndex index(mesh);
  std::vector<std::uint32_t> few(5);
  EXPECT_GT(index.packs_near(Vec3::Zero(), 3.0, few), few.size());
}

std::vector<std::uint32_t> packs_along(const SurfaceIndex& index, const Vec3& p, const Vec3& d,
                                       double radius, std::optional<std::uint32_t> first) {
  std::vector<std::uint32_t> packs;
  index.visit_packs_along(
      p, d, radius, first,
      [](void* state, std::span<const std::uint32_t> some, bool in_order) {
        auto& found = *static_cast<std::vector<std::uint32_t>*>(state);
        found.insert(found.end(), some.begin(), some.end());
        EXPECT_TRUE(!in_order || std::is_sorted(some.begin(), some.end()));
        return QueryFraction::end();
      },
      &packs);
  // The packs near the start may be visited twice.
  if (!first) {
    std::sort(packs.begin(), packs.end());
    packs.erase(std::unique(packs.begin(), packs.end()), packs.end());
  }
  return packs;
}

std::vector<std::uint32_t> packs_near(const SurfaceIndex& index, const Vec3& p, double radius,
                                      std::uint32_t first) {
  std::vector<std::uint32_t> packs;
  index.visit_packs_near(
      p, radius, first,
      [](void* state, std::span<const std::uint32_t> some) {
        auto& all = *static_cast<std::vector<std::uint32_t>*>(state);
        all.insert(all.end(), some.begin(), some.end());
        return true;
      },
      &packs);
  return packs;
}

// Points and boxes on a lattice, so that many touch each other exactly.
TEST(SurfaceIndex, VisitsTheSamePacksInOrderFromAnyStartWithEachInstructionSet) {
  Random random(37);
  test::Soup soup;
  for (int i = 0; i < 40'000; ++i) {
    const Vec3 a = (16.0 * random.in_box(1.0)).array().round() / 16.0;
    soup.add(a, a + Vec3::Unit(random.index(3)) / 16.0, a + random.in_box(0.1));
  }
  constexpr double kSweep = 0.5;
  const SurfaceIndex index(SurfaceMesh::build(soup.positions, soup.triangles), {}, kSweep);
  int most = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const bool on_lattice = trial % 2 == 0;
    const Vec3 raw = random.in_box(1.0);
    const Vec3 p = on_lattice ? Vec3((16.0 * raw).array().round() / 16.0) : raw;
    const Vec3 d =
        on_lattice
            ? Vec3(static_cast<double>(random.index(32)) / 16.0 * Vec3::Unit(random.index(3)))
            : Vec3(std::pow(10.0, random.uniform(-9.0, 0.0)) * random.in_box(1.0));
    const double radius =
        on_lattice ? static_cast<double>(random.index(9)) / 16.0 : random.uniform(0.0, kSweep);
    limit_simd_level(SimdLevel::kAvx512);
    const auto all = packs_along(index, p, d, radius, 0);
    const auto near = packs_near(index, p, radius, 0);
    most = std::max(most, static_cast<int>(all.size()));
    for (const SimdLevel level : {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kBaseline}) {
      limit_simd_level(level);
      ASSERT_EQ(packs_along(index, p, d, radius, 0), all);
      ASSERT_EQ(packs_along(index, p, d, radius, std::nullopt), all) << "in the order of Embree";
      ASSERT_EQ(packs_near(index, p, radius, 0), near);
      std::vector<std::uint32_t> found(index.pack_count());
      found.resize(index.packs_near(p, radius, found));
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, near) << "in the order of Embree";
    }
    ASSERT_TRUE(std::is_sorted(all.begin(), all.end()));
    for (std::size_t i = 0; i < all.size(); i += 1 + all.size() / 7) {
      const std::vector<std::uint32_t> rest(all.begin() + static_cast<std::ptrdiff_t>(i),
                                            all.end());
      ASSERT_EQ(packs_along(index, p, d, radius, all[i]), rest);
    }
    for (std::size_t i = 0; i < near.size(); i += 1 + near.size() / 7) {
      const std::vector<std::uint32_t> rest(near.begin() + static_cast<std::ptrdiff_t>(i),
                                            near.end());
      ASSERT_EQ(packs_near(index, p, radius, near[i]), rest);
    }
  }
  EXPECT_GT(most, 256) << "too few packs to exceed the capacity of one search";
}

// With very many packs, the packs behind a hit are not visited.
TEST(SurfaceIndex, VisitsOnlyTheNeededOfVeryManyPacks) {
  Random random(38);
  test::Soup soup;
  for (int i = 0; i < 40'000; ++i) {
    const Vec3 a = random.in_box(1.0).cwiseProduct(Vec3(1.0, 0.01, 0.01));
    soup.add(a, a + random.in_box(0.02), a + random.in_box(0.02));
  }
  const SurfaceIndex index(SurfaceMesh::build(soup.positions, soup.triangles));
  const Vec3 p(-1.1, 0.0, 0.0);
  const Vec3 d(2.2, 0.0, 0.0);
  ASSERT_GT(packs_along(index, p, d, 0.0, 0).size(), 256u);
  int visited = 0;
  index.visit_packs_along(
      p, d, 0.0, std::nullopt,
      [](void* state, std::span<const std::uint32_t> some, bool) {
        *static_cast<int*>(state) += static_cast<int>(some.size());
        return QueryFraction(0.05);
      },
      &visited);
  EXPECT_LT(visited, 256);
}

TEST(SurfaceIndex, FindsTheFirstHitOfASegment) {
  Random random(35);
  for (const NamedMesh& named : meshes(random)) {
    SCOPED_TRACE(named.name);
    const SurfaceIndex index(named.mesh);
    for (int trial = 0; trial < 500; ++trial) {
      const Vec3 p = random.in_box(1.5);
      const Vec3 d = random.in_box(2.0);
      double expected = std::numeric_limits<double>::infinity();
      for (std::uint32_t id = 0; id < index.pack_count(); ++id) {
        for (int lane = 0; lane < index.pack(id).count; ++lane) {
          const auto crossing =
              cross_segment(index.triangle(SurfaceIndex::slot(id, lane)), p, p + d);
          if (crossing.kind == SegmentCrossing::Kind::kMiss) continue;
          expected = std::min(expected, crossing.fraction);
        }
      }
      const auto found = index.first_hit(p, d);
      ASSERT_EQ(found.has_value(), expected <= 1.0);
      if (found) {
        ASSERT_EQ(found->fraction, expected);
      }
    }
  }
}

// Hard case 2: a segment exactly through an edge or a vertex of a closed surface finds no gap.
TEST(SurfaceIndex, NeverMissesASegmentThroughAnEdgeOrVertex) {
  Random random(36);
  const TriangleMesh sphere = icosphere(3, 1.0);
  const SurfaceMesh mesh = SurfaceMesh::build(sphere.positions_m, sphere.triangles);
  const SurfaceIndex index(mesh);
  constexpr int kTrials = 100000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Triangle& t = sphere.triangles[random.index(sphere.triangles.size())];
    const Vec3& a = sphere.positions_m[t[0]];
    const Vec3& b = sphere.positions_m[t[1]];
    const double along = trial % 2 ? 0.0 : random.uniform(0.0, 1.0);
    const Vec3 aim = a + along * (b - a);
    const Vec3 outside = aim * random.uniform(1.01, 2.0) + random.in_box(0.01);
    const Vec3 inside = aim + (aim - outside) * random.uniform(0.5, 1.0);
    if (inside.norm() > 0.95) continue;
    ASSERT_TRUE(index.first_hit(outside, inside - outside)) << "trial " << trial;
  }
}

TEST(SurfaceIndex, AppliesItsMapAndReversesMirroredFaces) {
  Random random(37);
  const TriangleMesh sphere = icosphere(2, 1.0);
  const SurfaceMesh mesh = SurfaceMesh::build(sphere.positions_m, sphere.triangles);
  const AffineMap map{Vec3(-1.0, 2.0, 0.5).asDiagonal(), {0.1, 0.2, 0.3}};
  const SurfaceIndex index(mesh, map);
  for (std::uint32_t id = 0; id < index.pack_count(); ++id) {
    const TriangleGeometry t = index.triangle(SurfaceIndex::slot(id, 0));
    const Vec3 centre = (t.a + t.b + t.c) / 3.0 - map.translation_m;
    ASSERT_GT(t.normal.dot(centre), 0.0);
    ASSERT_GT((t.b - t.a).cross(t.c - t.a).dot(t.normal), 0.0);
  }
}

}  // namespace
}  // namespace palpate
