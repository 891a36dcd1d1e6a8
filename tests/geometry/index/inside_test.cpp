#include "geometry/index/inside.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "models/primitives.h"
#include "tests/geometry/index/surface_of.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;
using test::surface_of;

void append(TriangleMesh& mesh, const TriangleMesh& more, const Vec3& at = Vec3::Zero()) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const Vec3& p : more.positions_m) mesh.positions_m.push_back(p + at);
  for (const Triangle& t : more.triangles) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

// A random map with rotation, translation, scale and, with probability 1/2, a mirror.
AffineMap random_map(Random& random) {
  AffineMap map;
  map.linear = random.rotation().toRotationMatrix() * random.uniform(0.01, 10.0);
  if (random.index(2) == 0) map.linear.col(0) *= -1.0;
  map.translation_m = random.in_box(3.0);
  return map;
}

// The smallest distance of a face's plane from the origin: the radius of a ball inside an
// icosphere.
double inradius(const TriangleMesh& mesh) {
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.positions_m[t[0]];
    const Vec3 normal = (mesh.positions_m[t[1]] - a).cross(mesh.positions_m[t[2]] - a).normalized();
    least = std::min(least, normal.dot(a));
  }
  return least;
}

// The winding number: the solid angle of all triangles seen from p, divided by the full solid angle
// (A. van Oosterom and J. Strackee, "The Solid Angle of a Plane Triangle", 1983, eq. 8).
double winding_number(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles,
                      const Vec3& p) {
  double turns = 0.0;
  for (const Triangle& t : triangles) {
    const Vec3 a = (positions[t[0]] - p).normalized();
    const Vec3 b = (positions[t[1]] - p).normalized();
    const Vec3 c = (positions[t[2]] - p).normalized();
    turns += std::atan2(a.dot(b.cross(c)), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
  }
  return turns / (2.0 * std::numbers::pi);
}

// ---- Cells of the integer lattice: closed, full of edges with four faces and of coplanar faces.

using Cell = std::array<int, 3>;

// Each face has separate corners.
TriangleMesh faces_of(const std::set<Cell>& cells) {
  TriangleMesh mesh;
  for (const Cell& cell : cells) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        Cell neighbour = cell;
        neighbour[static_cast<std::size_t>(axis)] += side == 1 ? 1 : -1;
        if (cells.count(neighbour)) continue;
        Vec3 corner(cell[0], cell[1], cell[2]);
        corner[axis] += side;
        const Vec3 u = Vec3::Unit((axis + 1) % 3);
        const Vec3 v = Vec3::Unit((axis + 2) % 3);
        const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
        mesh.positions_m.insert(mesh.positions_m.end(),
                                {corner, corner + u, corner + u + v, corner + v});
        if (side == 1) {
          mesh.triangles.push_back({first, first + 1, first + 2});
          mesh.triangles.push_back({first, first + 2, first + 3});
        } else {
          mesh.triangles.push_back({first, first + 2, first + 1});
          mesh.triangles.push_back({first, first + 3, first + 2});
        }
      }
    }
  }
  return mesh;
}

std::set<Cell> random_cells(Random& random, int size) {
  std::set<Cell> cells;
  for (std::size_t i = 1 + random.index(40); i > 0; --i) {
    const auto coordinate = [&] {
      return static_cast<int>(random.index(static_cast<std::uint64_t>(size)));
    };
    const int x = coordinate();
    const int y = coordinate();
    cells.insert({x, y, coordinate()});
  }
  return cells;
}

// No value on the surface, that is, if the cells around p differ.
std::optional<bool> in_cells(const std::set<Cell>& cells, const Vec3& p) {
  bool any = false;
  bool all = true;
  for (int around = 0; around < 8; ++around) {
    Cell cell;
    for (int k = 0; k < 3; ++k) {
      const double low = std::floor(p[k]);
      const bool between = low == p[k] && ((around >> k) & 1);
      cell[static_cast<std::size_t>(k)] = static_cast<int>(low) - (between ? 1 : 0);
    }
    (cells.count(cell) ? any : all) = cells.count(cell) != 0;
  }
  if (any != all) return std::nullopt;
  return any;
}

TEST(IsClosed, MeansThatEveryEdgeHasAnEvenNumberOfFaces) {
  TriangleMesh sphere = icosphere(2, 1.0);
  EXPECT_TRUE(is_closed(surface_of(sphere)));
  std::swap(sphere.triangles[7][0], sphere.triangles[7][1]);
  EXPECT_TRUE(is_closed(surface_of(sphere)));  // a reversed face leaves no gap
  TriangleMesh open = sphere;
  open.triangles.pop_back();
  EXPECT_FALSE(is_closed(surface_of(open)));
  TriangleMesh finned = icosphere(1, 1.0);
  finned.positions_m.push_back(Vec3::Zero());
  const Triangle& t = finned.triangles[0];
  finned.triangles.push_back(
      {t[0], t[1], static_cast<std::uint32_t>(finned.positions_m.size() - 1)});
  EXPECT_FALSE(is_closed(surface_of(finned)));
  // Two tetrahedra that share a face: the edges of this face have three faces, and no edge has one
  // face.
  const SurfaceMesh three = SurfaceMesh::build(
      {{1, 0, 0}, {0, 1, 0}, {-1, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {1, 0, 4}, {2, 1, 4}, {0, 2, 4}, {0, 1, 2}});
  ASSERT_EQ(three.report().boundary_edges, 0u);
  EXPECT_FALSE(is_closed(three));
  const SurfaceMesh four = surface_of(faces_of({{0, 0, 0}, {1, 1, 0}, {0, 1, 1}}));
  ASSERT_GT(four.report().non_manifold_edges, 0u);
  EXPECT_TRUE(is_closed(four));
  EXPECT_TRUE(is_closed(SurfaceMesh::build({}, {})));
}

TEST(IsInside, IsCorrectForASphereInAnyPose) {
  Random random(701);
  for (int trial = 0; trial < 60; ++trial) {
    const TriangleMesh sphere = icosphere(trial % 5, 1.0);
    const double least = inradius(sphere) * (1 - 1e-12);
    const AffineMap map = random_map(random);
    const SurfaceIndex index(surface_of(sphere), map);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = random.in_box(1.1);
      const double radius = p.norm();
      // Undecided: between the ball inside and the sphere. Vertices are rounded to float.
      if (radius > least && radius < 1.0 + 1e-6) continue;
      ASSERT_EQ(is_inside(index, map(p)), radius < 1.0) << p.transpose();
    }
  }
}

TEST(IsInside, IsCorrectForATorusInAnyPose) {
  Random random(702);
  const int level = 3;
  const double around = 8 << level;
  // The loss due to chords: R (1 - cos(pi / n)) across the ring, and the same for the tube.
  const double cut = 1.4 * (1 - std::cos(std::numbers::pi / around)) +
                     0.4 * (1 - std::cos(2 * std::numbers::pi / around));
  const SurfaceMesh mesh = surface_of(torus(1.0, 0.4, level));
  for (int trial = 0; trial < 30; ++trial) {
    const AffineMap map = random_map(random);
    const SurfaceIndex index(mesh, map);
    int inside = 0;
    for (int i = 0; i < 300; ++i) {
      Vec3 p = random.in_box(1.5);
      p.z() *= 0.3;
      const double radius = std::hypot(std::hypot(p.x(), p.y()) - 1.0, p.z());
      if (std::abs(radius - 0.4) < 1.5 * cut) continue;
      ASSERT_EQ(is_inside(index, map(p)), radius < 0.4) << p.transpose();
      inside += radius < 0.4 ? 1 : 0;
    }
    EXPECT_GT(inside, 50);
  }
}

TEST(IsInside, DistinguishesTheSidesOfAFaceNextToTheFace) {
  Random random(703);
  // A cavity, so that the box test does not decide.
  TriangleMesh mesh = box(Vec3(4, 4, 4));
  append(mesh, box(Vec3(2, 2, 2)));
  const SurfaceIndex index(surface_of(mesh));
  for (int trial = 0; trial < 2000; ++trial) {
    const int axis = static_cast<int>(random.index(3));
    const double side = random.index(2) == 0 ? 1.0 : -1.0;
    // Any point on a face of the cavity, and points directly above its edges and vertices.
    Vec3 p = random.in_box(1.0);
    if (trial % 3 == 1) p = 4.0 * p.array().round() / 4.0;
    if (trial % 3 == 2) p = p.array().sign();
    p[axis] = side;
    ASSERT_EQ(is_inside(index, p), std::nullopt) << p.transpose();
    for (const double away : {std::numeric_limits<double>::epsilon(), 1e-12, 1e-3}) {
      Vec3 outer = p;
      outer[axis] = side * (1.0 + away);
      ASSERT_EQ(is_inside(index, outer), true) << outer.transpose();
      Vec3 inner = p;
      inner[axis] = side * (1.0 - away);
      const bool in_cavity = inner.cwiseAbs().maxCoeff() < 1.0;
      ASSERT_EQ(is_inside(index, inner), in_cavity ? std::optional(false) : std::nullopt)
          << inner.transpose();
    }
  }
}

TEST(IsInside, ReturnsNoValueOnTheSurface) {
  const SurfaceIndex index(surface_of(box(Vec3(2, 2, 2))));
  for (const Vec3& p : {Vec3(1, 0.25, 0.5), Vec3(-1, 0, 0), Vec3(1, 1, 0.3), Vec3(1, 1, -1)}) {
    EXPECT_EQ(is_inside(index, p), std::nullopt) << p.transpose();
  }
}

TEST(IsInside, TreatsACavityAsOutsideAndASolidInTheCavityAsInside) {
  Random random(704);
  TriangleMesh nested = icosphere(3, 1.0);
  append(nested, icosphere(2, 0.6));
  append(nested, icosphere(1, 0.3));
  const double third = inradius(icosphere(1, 0.3));
  const double second = inradius(icosphere(2, 0.6));
  const double first = inradius(icosphere(3, 1.0));
  for (int trial = 0; trial < 20; ++trial) {
    const AffineMap map = random_map(random);
    const SurfaceIndex index(surface_of(nested), map);
    for (int i = 0; i < 200; ++i) {
      const Vec3 direction = random.unit_vector();
      const auto at = [&](double low, double high) {
        return map(random.uniform(low, high) * direction);
      };
      ASSERT_EQ(is_inside(index, at(0.0, third)), true);
      ASSERT_EQ(is_inside(index, at(0.301, second)), false);
      ASSERT_EQ(is_inside(index, at(0.601, first)), true);
      ASSERT_EQ(is_inside(index, at(1.001, 3.0)), false);
    }
  }
}

// Vertices and edges of a star-shaped surface lie on the first segments.
TEST(IsInside, TriesAnotherSegmentIfOneMeetsAnEdgeOrVertex) {
  const TriangleMesh cage = box(Vec3(32, 32, 32));  // determines the box
  const Vec3 p = Vec3::Zero();
  const Box bounds = SurfaceIndex(surface_of(cage)).box();
  for (int blocked = 0; blocked <= kMostTries; ++blocked) {
    TriangleMesh star = icosphere(3, 1.0);
    std::set<std::size_t> used;
    for (int attempt = 0; attempt < blocked; ++attempt) {
      const Vec3 end = probe_end(bounds, p, attempt);
      std::size_t nearest = 0;
      for (std::size_t v = 0; v < star.positions_m.size(); ++v) {
        const auto along = [&](std::size_t i) {
          return star.positions_m[i].normalized().dot(end.normalized());
        };
        if (along(v) > along(nearest)) nearest = v;
      }
      ASSERT_TRUE(used.insert(nearest).second);
      star.positions_m[nearest] = end * 0x1p-5;  // exactly on the segment from the origin
    }
    append(star, cage);
    const SurfaceMesh mesh = surface_of(star);
    ASSERT_TRUE(is_closed(mesh));
    const SurfaceIndex index(mesh);
    for (int attempt = 0; attempt < kMostTries; ++attempt) {
      ASSERT_FALSE(bounds.contains(probe_end(bounds, p, attempt)));
      const auto odd = crosses_odd(index, p, probe_end(bounds, p, attempt));
      ASSERT_EQ(odd, attempt < blocked ? std::nullopt : std::optional(false)) << attempt;
    }
    EXPECT_EQ(is_inside(index, p), blocked < kMostTries ? std::optional(false) : std::nullopt);
  }
}

TEST(IsInside, AgreesWithTheWindingNumber) {
  Random random(705);
  for (int trial = 0; trial < 100; ++trial) {
    // Rough enough to intersect itself.
    TriangleMesh mesh = trial % 2 == 0 ? icosphere(2, 1.0) : torus(1.0, 0.5, 1);
    const double noise = random.uniform(0.0, 0.4);
    for (Vec3& p : mesh.positions_m) p += random.in_box(noise);
    if (trial % 3 == 0) append(mesh, icosphere(1, 0.7), random.in_box(1.0));
    const AffineMap map = random_map(random);
    std::vector<Vec3> mapped;
    for (const Vec3& p : mesh.positions_m) mapped.push_back(map(p));
    const SurfaceMesh surface = surface_of(mesh);
    ASSERT_TRUE(is_closed(surface));
    const SurfaceIndex index(surface, map);
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = map(random.in_box(1.5));
      const double turns = winding_number(mapped, mesh.triangles, p);
      ASSERT_NEAR(turns, std::round(turns), 1e-6);
      ASSERT_EQ(is_inside(index, p), std::lround(turns) % 2 != 0) << turns;
    }
  }
}

TEST(IsInside, IsCorrectForCellsAtEveryPointOfAFinerLattice) {
  Random random(706);
  for (int trial = 0; trial < 60; ++trial) {
    const std::set<Cell> cells = random_cells(random, 4);
    const SurfaceMesh mesh = surface_of(faces_of(cells));
    ASSERT_TRUE(is_closed(mesh));
    const SurfaceIndex index(mesh);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = (random.in_box(2.5).array() + 2.0).unaryExpr([](double x) {
        return std::round(4.0 * x) / 4.0;
      });
      const std::optional<bool> expected = in_cells(cells, p);
      ASSERT_EQ(is_inside(index, p), expected) << p.transpose();
    }
  }
}

TEST(CrossesOdd, IsCorrectWheneverItReturnsAValue) {
  Random random(707);
  int answers = 0;
  int undecided = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const std::set<Cell> cells = random_cells(random, 4);
    TriangleMesh mesh = faces_of(cells);
    for (Triangle& t : mesh.triangles) {  // so that an edge can be any edge of its face
      std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random.index(3)), t.end());
    }
    const SurfaceIndex index(surface_of(mesh));
    Vec3 p = Vec3(-0.5, 0.5, 0.5);
    for (int i = 0; i < 500; ++i) {
      // Every second step is along an axis. Steps end on a lattice, so that many meet edges and
      // vertices.
      Vec3 q = (random.in_box(2.5).array() + 2.0).unaryExpr([](double x) {
        return std::round(8.0 * x) / 8.0;
      });
      if (i % 2 == 0) {
        const auto axis = static_cast<Eigen::Index>(random.index(3));
        const double x = q[axis];
        q = p;
        q[axis] = x;
      }
      const std::optional<bool> before = in_cells(cells, p);
      const std::optional<bool> after = in_cells(cells, q);
      const std::optional<bool> odd = crosses_odd(index, p, q);
      if (!before || !after) {
        // p == q has no crossing at any position.
        if (p != q) {
          ASSERT_EQ(odd, std::nullopt) << p.transpose() << " to " << q.transpose();
        }
      } else if (odd) {
        ASSERT_EQ(*odd, *before != *after) << p.transpose() << " to " << q.transpose();
        ++answers;
      } else {
        ++undecided;
      }
      p = q;
    }
  }
  EXPECT_GT(answers, 1000);
  EXPECT_GT(undecided, 1000);
}

TEST(CrossesOdd, TracksAPointThroughSmallSteps) {
  Random random(708);
  for (int trial = 0; trial < 20; ++trial) {
    const AffineMap map = random_map(random);
    const SurfaceIndex index(surface_of(torus(1.0, 0.4, 2)), map);
    const double size = map.linear.col(1).norm();
    Vec3 p = map(Vec3(0.0, 0.0, 0.1));
    bool inside = is_inside(index, p).value();
    EXPECT_FALSE(inside);
    int changes = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3 home = 0.05 * (map.translation_m - p);
      const Vec3 q = p + home + size * random.in_box(0.3);
      const auto odd = crosses_odd(index, p, q);
      ASSERT_TRUE(odd.has_value());
      inside = inside != *odd;
      changes += *odd ? 1 : 0;
      ASSERT_EQ(is_inside(index, q), inside) << i;
      p = q;
    }
    EXPECT_GT(changes, 10);
  }
}

TEST(CrossesOdd, CountsUpToALimit) {
  TriangleMesh stack;
  const int slabs = kMostCrossings / 2;
  for (int i = 0; i < slabs; ++i) {
    append(stack, box(Vec3(1.0, 1.0, 0.5)), Vec3(0.0, 0.0, i));
  }
  const auto below = Vec3(0.1, 0.2, -1.0);
  const auto above = Vec3(0.1, 0.2, slabs + 0.3);
  const SurfaceIndex full(surface_of(stack));
  EXPECT_EQ(crosses_odd(full, below, above), false);
  append(stack, box(Vec3(1.0, 1.0, 0.5)), Vec3(0.0, 0.0, slabs));
  const SurfaceIndex too_full(surface_of(stack));
  EXPECT_EQ(crosses_odd(too_full, below, Vec3(0.1, 0.2, slabs + 1.0)), std::nullopt);
  EXPECT_EQ(crosses_odd(too_full, below, Vec3(0.1, 0.2, slabs - 1.0)), true);
  EXPECT_EQ(is_inside(too_full, Vec3(0.1, 0.2, slabs / 2)), true);
  EXPECT_EQ(is_inside(too_full, Vec3(0.1, 0.2, slabs / 2 + 0.5)), false);
}

TEST(CrossesOdd, IsFalseForAnEmptyMesh) {
  const SurfaceIndex index(SurfaceMesh::build({}, {}));
  EXPECT_EQ(crosses_odd(index, Vec3(1, 2, 3), Vec3(-1, -2, -3)), false);
  EXPECT_EQ(is_inside(index, Vec3::Zero()), false);
  const SurfaceIndex cube(surface_of(box(Vec3(1, 1, 1))));
  EXPECT_EQ(crosses_odd(cube, Vec3::Zero(), Vec3::Zero()), false);
}

}  // namespace
}  // namespace palpate
