#include "geometry/index/crease_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/exact/exact.h"
#include "models/primitives.h"
#include "tests/geometry/index/surface_of.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::kFloatRoundoff;
using test::Random;
using test::surface_of;

constexpr double kDegree = std::numbers::pi / 180.0;

Vec3 to_vec3(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

void expect_near(const std::array<float, 3>& normal, const Vec3& expected, double bound) {
  EXPECT_NEAR((to_vec3(normal) - expected).norm(), 0.0, bound)
      << to_vec3(normal).transpose() << " is not " << expected.transpose();
}

Vec3 face_normal(const SurfaceMesh& mesh, std::size_t f) {
  const Triangle face = mesh.face(f);
  const auto p = mesh.welded_positions();
  return accurate_unit_normal(p[face[0]], p[face[1]], p[face[2]]);
}

// ---- A slow implementation of the definition: from every corner to all connected faces around its
// vertex, through a table of welded edges.

std::vector<CornerNormals> reference(const SurfaceMesh& mesh, double crease_angle_rad) {
  const auto positions = mesh.welded_positions();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::pair<std::size_t, bool>>>
      edges;
  const auto rising = [](std::uint32_t from, std::uint32_t to) {
    return std::pair(std::min(from, to), std::max(from, to));
  };
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Triangle face = mesh.face(f);
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t from = face[e];
      const std::uint32_t to = face[(e + 1) % 3];
      edges[rising(from, to)].push_back({f, from < to});
    }
  }
  std::vector<CornerNormals> all(mesh.face_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.face(f)[corner];
      std::map<std::size_t, double> reached = {{f, 1.0}};
      std::vector<std::size_t> open = {f};
      while (!open.empty()) {
        const std::size_t here = open.back();
        open.pop_back();
        for (const std::uint32_t other : mesh.face(here)) {
          if (other == vertex) continue;
          const auto& uses = edges.at(rising(vertex, other));
          if (uses.size() != 2) continue;
          const std::size_t there = uses[0].first == here ? uses[1].first : uses[0].first;
          const double sense = uses[0].second == uses[1].second ? -1.0 : 1.0;
          const Vec3 n = face_normal(mesh, here);
          const Vec3 m = sense * face_normal(mesh, there);
          if (std::atan2(n.cross(m).norm(), n.dot(m)) > crease_angle_rad) continue;
          if (reached.emplace(there, sense * reached.at(here)).second) open.push_back(there);
        }
      }
      Vec3 sum = Vec3::Zero();
      for (const auto& [face, sense] : reached) {
        const Triangle v = mesh.face(face);
        const std::size_t at = v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
        const Vec3 to_next = positions[v[(at + 1) % 3]] - positions[vertex];
        const Vec3 to_last = positions[v[(at + 2) % 3]] - positions[vertex];
        const double angle =
            std::acos(std::clamp(to_next.normalized().dot(to_last.normalized()), -1.0, 1.0));
        sum += sense * angle * face_normal(mesh, face);
      }
      if (sum.norm() < 1e-9) sum = face_normal(mesh, f);
      sum.normalize();
      for (int k = 0; k < 3; ++k)
        all[f][corner][static_cast<std::size_t>(k)] = static_cast<float>(sum[k]);
    }
  }
  return all;
}

void expect_as_defined(const SurfaceMesh& mesh, double crease_angle_rad) {
  const std::vector<CornerNormals> normals = crease_normals(mesh, {}, crease_angle_rad);
  const std::vector<CornerNormals> expected = reference(mesh, crease_angle_rad);
  ASSERT_EQ(normals.size(), expected.size());
  for (std::size_t f = 0; f < normals.size(); ++f) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      // Angles from acos have half of the digits.
      ASSERT_NEAR((to_vec3(normals[f][corner]) - to_vec3(expected[f][corner])).norm(), 0.0, 1e-6)
          << "face " << f << " corner " << corner;
    }
  }
}

// A sheet of n x n quads over [-1, 1]^2, bent to z = bend (x^2 + x y).
TriangleMesh sheet(std::uint32_t n, double bend) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= n; ++i) {
    for (std::uint32_t j = 0; j <= n; ++j) {
      const double x = 2.0 * i / n - 1.0;
      const double y = 2.0 * j / n - 1.0;
      mesh.positions_m.emplace_back(x, y, bend * (x * x + x * y));
      if (i == n || j == n) continue;
      const std::uint32_t at = i * (n + 1) + j;
      mesh.triangles.push_back({at, at + n + 1, at + n + 2});
      mesh.triangles.push_back({at, at + n + 2, at + 1});
    }
  }
  return mesh;
}

// The faces in another order, each starting with another corner. order[i] is the new position of
// face i.
TriangleMesh shuffled(TriangleMesh mesh, Random& random, std::vector<std::size_t>& order,
                      std::vector<std::size_t>& turns) {
  const TriangleMesh before = mesh;
  order.resize(mesh.triangles.size());
  turns.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);
  for (std::size_t i = 0; i < order.size(); ++i) {
    turns[i] = random.index(3);
    for (std::size_t e = 0; e < 3; ++e) {
      mesh.triangles[order[i]][e] = before.triangles[i][(e + turns[i]) % 3];
    }
  }
  return mesh;
}

// The largest errors of corner normals and of face normals against the normals of the shape.
struct Deviation {
  double corners = 0.0;
  double faces = 0.0;
};
template <typename NormalAt>
Deviation deviation(const SurfaceMesh& mesh, NormalAt normal_at) {
  const std::vector<CornerNormals> normals = crease_normals(mesh, {}, 60 * kDegree);
  Deviation worst;
  for (std::size_t f = 0; f < normals.size(); ++f) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3 expected = normal_at(mesh.welded_positions()[mesh.face(f)[corner]]);
      worst.corners = std::max(worst.corners, (to_vec3(normals[f][corner]) - expected).norm());
      worst.faces = std::max(worst.faces, (face_normal(mesh, f) - expected).norm());
    }
  }
  return worst;
}

// The error of a mean is at most the error of its worst face, which is the face's circumradius:
// O(h). The errors cancel to this order if a ring of faces is symmetric about its vertex. Along
// edges of coarser levels, the rings of an icosphere are not quite symmetric.
TEST(CreaseNormals, OfASphereAreRadialUpToTheSkewOfTheMesh) {
  double before = 0.0;
  for (const int level : {0, 1, 2, 3, 4, 5}) {
    const Deviation worst =
        deviation(surface_of(icosphere(level, 0.5)), [&](const Vec3& p) { return p.normalized(); });
    EXPECT_LT(worst.corners, worst.faces / 9.0) << level;
    if (level == 0) {
      EXPECT_LT(worst.corners, 8 * kFloatRoundoff);  // five equal faces
    }
    if (level > 2) {
      EXPECT_LT(worst.corners, before / 1.9) << level;
    }
    before = worst.corners;
  }
}

// The rings of a smooth grid are symmetric up to O(h), so that corner normals have an error of
// O(h^2).
TEST(CreaseNormals, OfATorusAreAccurateToSecondOrder) {
  double before = 0.0;
  for (const int level : {2, 3, 4, 5}) {
    const Deviation worst = deviation(surface_of(torus(1.0, 0.4, level)), [](const Vec3& p) {
      return Vec3(p - Vec3(p.x(), p.y(), 0.0).normalized()).normalized();
    });
    // The error of faces is about h / 2, so this bound is h^2 / 2.
    EXPECT_LT(worst.corners, 2.0 * worst.faces * worst.faces) << level;
    if (before > 0.0) {
      EXPECT_LT(worst.corners, before / 3.5) << level;
    }
    before = worst.corners;
  }
}

TEST(CreaseNormals, OfABoxAreFaceNormalsOrCornerNormals) {
  Random random(601);
  for (int trial = 0; trial < 20; ++trial) {
    TriangleMesh cube = box(Vec3(0.2, 0.3, 0.7));
    std::vector<std::size_t> order, turns;
    cube = shuffled(cube, random, order, turns);
    const SurfaceMesh mesh = surface_of(cube);
    const AffineMap map{random.rotation().toRotationMatrix(), random.in_box(3.0)};
    const std::vector<CornerNormals> sharp = crease_normals(mesh, map, 60 * kDegree);
    const std::vector<CornerNormals> round = crease_normals(mesh, map, 100 * kDegree);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const Vec3 position = mesh.welded_positions()[mesh.face(f)[corner]];
        expect_near(sharp[f][corner], map.linear * face_normal(mesh, f), 4 * kFloatRoundoff);
        expect_near(round[f][corner],
                    map.linear * position.array().sign().matrix() / std::sqrt(3.0),
                    4 * kFloatRoundoff);
      }
    }
  }
}

TEST(CreaseNormals, KeepTheCapsOfACylinderFlatAndItsSideRound) {
  Contour contour;
  const int sides = 24;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    contour.push_back({std::cos(angle), std::sin(angle)});
  }
  const SurfaceMesh mesh = surface_of(prism(contour, -1.0, 1.5).value());
  const std::vector<CornerNormals> normals = crease_normals(mesh, {}, 40 * kDegree);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Vec3 own = face_normal(mesh, f);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3 p = mesh.welded_positions()[mesh.face(f)[corner]];
      const bool cap = std::abs(own.z()) > 0.5;
      // The contour is rounded to float, over sides of 0.26.
      expect_near(normals[f][corner], cap ? own : Vec3(p.x(), p.y(), 0.0), 16 * kFloatRoundoff);
    }
  }
}

TEST(CreaseNormals, OfAnOpenSheetPointToItsFront) {
  const SurfaceMesh flat = surface_of(sheet(6, 0.0));
  for (const CornerNormals& face : crease_normals(flat, {}, 30 * kDegree)) {
    for (const auto& normal : face) EXPECT_EQ(to_vec3(normal), Vec3::UnitZ());
  }
  const SurfaceMesh bent = surface_of(sheet(7, 0.4));
  for (const double angle : {0.0, 2 * kDegree, 5 * kDegree, 8 * kDegree, 180 * kDegree}) {
    expect_as_defined(bent, angle);
  }
}

TEST(CreaseNormals, DoNotTreatAReversedFaceAsACrease) {
  Random random(602);
  for (int trial = 0; trial < 50; ++trial) {
    TriangleMesh mesh = trial % 2 == 0 ? sheet(5, 0.3) : icosphere(2, 1.0);
    const std::vector<CornerNormals> before = crease_normals(surface_of(mesh), {}, 60 * kDegree);
    std::vector<bool> turned(mesh.triangles.size(), false);
    for (std::size_t i = 1 + random.index(trial < 25 ? 1 : 60); i > 0; --i) {
      const std::size_t f = random.index(turned.size());
      turned[f] = !turned[f];
      std::swap(mesh.triangles[f][1], mesh.triangles[f][2]);
    }
    const SurfaceMesh surface = surface_of(mesh);
    const std::vector<CornerNormals> after = crease_normals(surface, {}, 60 * kDegree);
    for (std::size_t f = 0; f < turned.size(); ++f) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::size_t now = turned[f] ? (3 - corner) % 3 : corner;
        expect_near(after[f][now], (turned[f] ? -1.0 : 1.0) * to_vec3(before[f][corner]),
                    4 * kFloatRoundoff);
      }
    }
    expect_as_defined(surface, 60 * kDegree);
  }
}

TEST(CreaseNormals, DoNotCrossAnEdgeOfThreeFaces) {
  // A roof of two gentle slopes, and the same roof with a wall under its ridge.
  TriangleMesh roof;
  roof.positions_m = {{0, -1, 0}, {0, 1, 0}, {1, 0, -0.2}, {-1, 0, -0.2}, {0, 0, -1}};
  roof.triangles = {{0, 2, 1}, {1, 3, 0}};
  const std::vector<CornerNormals> smooth = crease_normals(surface_of(roof), {}, 60 * kDegree);
  for (const std::size_t f : {0u, 1u}) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      if (roof.triangles[f][corner] < 2)
        expect_near(smooth[f][corner], Vec3::UnitZ(), 4 * kFloatRoundoff);
    }
  }
  roof.triangles.push_back({0, 1, 4});
  const SurfaceMesh walled = surface_of(roof);
  const std::vector<CornerNormals> sharp = crease_normals(walled, {}, 180 * kDegree);
  for (std::size_t f = 0; f < 3; ++f) {
    for (const auto& normal : sharp[f])
      expect_near(normal, face_normal(walled, f), 4 * kFloatRoundoff);
  }
}

// A map only changes positions. Under a mirroring map, faces must be reversed to face outwards
// again.
TEST(CreaseNormals, MatchTheCornersOfTheIndexUnderAnyMap) {
  Random random(603);
  for (int trial = 0; trial < 30; ++trial) {
    const TriangleMesh mesh = trial % 2 == 0 ? torus(1.0, 0.4, 1) : icosphere(1, 1.0);
    const SurfaceMesh surface = surface_of(mesh);
    AffineMap map;
    for (int i = 0; i < 9; ++i) map.linear(i / 3, i % 3) = random.uniform(-1, 1);
    if (trial < 4) map.linear = Vec3(trial < 2 ? -1.0 : 2.0, 1.0, 1.0).asDiagonal();
    map.translation_m = random.in_box(1.0);
    const bool mirrored = map.linear.determinant() < 0.0;
    TriangleMesh mapped = mesh;
    for (Vec3& p : mapped.positions_m) p = map(p);
    for (Triangle& t : mapped.triangles) {
      if (mirrored) std::swap(t[1], t[2]);
    }
    const double angle = random.uniform(10, 120) * kDegree;
    const std::vector<CornerNormals> normals = crease_normals(surface, map, angle);
    const std::vector<CornerNormals> expected = reference(surface_of(mapped), angle);
    const SurfaceIndex index(surface, map);
    for (std::uint32_t slot = 0; slot < index.pack_count() * TrianglePack::kLanes; ++slot) {
      const std::uint32_t f = index.face(slot);
      const TriangleGeometry& t = index.triangle(slot);
      const std::array<Vec3, 3> corners = {t.a, t.b, t.c};
      for (std::size_t corner = 0; corner < 3; ++corner) {
        ASSERT_EQ(corners[corner], mapped.positions_m[mapped.triangles[f][corner]]);
        expect_near(normals[f][corner], to_vec3(expected[f][corner]), 1e-6);
        if (trial < 2 && mesh.triangles.size() == 80) {
          EXPECT_GT(to_vec3(normals[f][corner]).dot(corners[corner] - map.translation_m), 0.9);
        }
      }
    }
  }
}

TriangleMesh random_closed_mesh(Random& random) {
  TriangleMesh mesh;
  switch (random.index(3)) {
    case 0:
      mesh = icosphere(2, 1.0);
      break;
    case 1:
      mesh = torus(1.0, 0.5, 1);
      break;
    default:
      mesh = box(Vec3(1.0, 1.0, 1.0));
  }
  const double noise = random.uniform(0.0, 0.2);
  for (Vec3& p : mesh.positions_m) p += random.in_box(noise);
  return mesh;
}

TEST(CreaseNormals, DoNotDependOnTheOrderOfFaces) {
  Random random(604);
  for (int trial = 0; trial < 60; ++trial) {
    const TriangleMesh mesh = random_closed_mesh(random);
    std::vector<std::size_t> order, turns;
    const TriangleMesh other = shuffled(mesh, random, order, turns);
    const double angle = random.uniform(0, 120) * kDegree;
    const std::vector<CornerNormals> normals = crease_normals(surface_of(mesh), {}, angle);
    const std::vector<CornerNormals> others = crease_normals(surface_of(other), {}, angle);
    for (std::size_t f = 0; f < normals.size(); ++f) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        expect_near(others[order[f]][corner], to_vec3(normals[f][(corner + turns[f]) % 3]),
                    4 * kFloatRoundoff);
      }
    }
    expect_as_defined(surface_of(mesh), angle);
  }
}

// All kinds of defects: faces removed, reversed and added at random.
TEST(CreaseNormals, MatchTheDefinitionOnDamagedMeshes) {
  Random random(605);
  for (int trial = 0; trial < 100; ++trial) {
    TriangleMesh mesh = random_closed_mesh(random);
    std::vector<Triangle> triangles;
    const std::uint64_t rarity = 2 + random.index(20);
    for (Triangle t : mesh.triangles) {
      if (random.index(rarity) == 0) continue;
      if (random.index(rarity) == 0) std::swap(t[0], t[1]);
      triangles.push_back(t);
      if (random.index(rarity) == 0) {
        triangles.push_back(
            {t[0], t[1], static_cast<std::uint32_t>(random.index(mesh.positions_m.size()))});
      }
    }
    mesh.triangles = triangles;
    expect_as_defined(surface_of(mesh), random.uniform(0, 180) * kDegree);
  }
}

TEST(CreaseNormals, AreFaceNormalsIfTheSumCancels) {
  // A square without thickness, whose two sides are divided along different diagonals.
  TriangleMesh pillow;
  pillow.positions_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  pillow.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  const SurfaceMesh mesh = surface_of(pillow);
  ASSERT_EQ(mesh.report().boundary_edges, 0u);
  const AffineMap map{Quat(0.3, 0.4, 0.5, 0.6).normalized().toRotationMatrix(), Vec3(1, 2, 3)};
  const std::vector<CornerNormals> normals = crease_normals(mesh, map, 180 * kDegree);
  for (std::size_t f = 0; f < 4; ++f) {
    for (const auto& normal : normals[f]) {
      expect_near(normal, map.linear * face_normal(mesh, f), 1e-6);
    }
  }
}

TEST(CreaseNormals, OfSliversAreNormalsOfTheirSheet) {
  // A strip whose middle row of vertices is next to one of its sides.
  TriangleMesh strip;
  const std::uint32_t n = 20;
  for (std::uint32_t i = 0; i <= n; ++i) {
    const double x = 0.1 * i;
    for (const double y : {0.0, 1e-13, 1.0}) strip.positions_m.emplace_back(x, y, 0.3 * y);
    if (i == n) continue;
    for (const std::uint32_t row : {0u, 1u}) {
      const std::uint32_t at = 3 * i + row;
      strip.triangles.push_back({at, at + 3, at + 4});
      strip.triangles.push_back({at, at + 4, at + 1});
    }
  }
  const Vec3 expected = Vec3(0, -0.3, 1).normalized();
  for (const CornerNormals& face : crease_normals(surface_of(strip), {}, 30 * kDegree)) {
    for (const auto& normal : face) expect_near(normal, expected, 1e-3);
  }
}

TEST(CreaseNormals, AreEmptyForAnEmptyMesh) {
  EXPECT_TRUE(crease_normals(SurfaceMesh::build({}, {}), {}, 1.0).empty());
}

}  // namespace
}  // namespace palpate
