#include "geometry/mesh/surface_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include <OpenMesh/Tools/Utils/MeshCheckerT.hh>
#include <gtest/gtest.h>

#include "geometry/base/fixed_array.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Soup;

using Key = std::array<double, 3>;  // a position that can be a key; -0 equals +0 there too
Key key_of(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

// ---- Soups. Coordinates are small integers, so that areas and collinearity are exact in double.

// Every triangle has separate corners, as after reading a file with seams everywhere.
Soup with_seams(const Soup& soup) {
  Soup seams;
  for (const Triangle& t : soup.triangles) {
    const auto first = static_cast<std::uint32_t>(seams.positions.size());
    for (const std::uint32_t v : t) seams.positions.push_back(soup.positions[v]);
    seams.triangles.push_back({first, first + 1, first + 2});
  }
  return seams;
}

Soup posed(Soup soup, test::Random& random) {
  const RigidTransform pose = random.pose(10.0);
  for (Vec3& p : soup.positions) p = pose.point(p);
  return soup;
}

Soup tetrahedron(const Vec3& corner = Vec3::Zero(), double size = 1.0) {
  return {{corner, corner + size * Vec3::UnitX(), corner + size * Vec3::UnitY(),
           corner + size * Vec3::UnitZ()},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

Soup cube() {
  Soup soup;
  for (int i = 0; i < 8; ++i) soup.positions.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  soup.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return soup;
}

// A grid of nu x nv quads, closed in both directions.
Soup torus(std::uint32_t nu, std::uint32_t nv) {
  Soup soup;
  for (std::uint32_t i = 0; i < nu; ++i) {
    for (std::uint32_t j = 0; j < nv; ++j) {
      const double u = 2.0 * std::numbers::pi * i / nu;
      const double v = 2.0 * std::numbers::pi * j / nv;
      const double radius = 3.0 + std::cos(v);
      soup.positions.emplace_back(radius * std::cos(u), radius * std::sin(u), std::sin(v));
      const std::uint32_t i1 = (i + 1) % nu;
      const std::uint32_t j1 = (j + 1) % nv;
      soup.triangles.push_back({i * nv + j, i1 * nv + j, i1 * nv + j1});
      soup.triangles.push_back({i * nv + j, i1 * nv + j1, i * nv + j1});
    }
  }
  return soup;
}

// Apex and rim, open (a disc) or closed to a full turn.
Soup fan(std::uint32_t rim_count, bool closed, double apex_height = 1.0) {
  Soup soup;
  soup.positions.emplace_back(0.0, 0.0, apex_height);
  for (std::uint32_t i = 0; i < rim_count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / rim_count;
    soup.positions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    if (closed || i + 1 < rim_count) soup.triangles.push_back({0, 1 + i, 1 + (i + 1) % rim_count});
  }
  return soup;
}

Soup moebius_strip(std::uint32_t quads) {
  Soup soup;
  for (std::uint32_t i = 0; i < quads; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / quads;
    const Vec3 radial(std::cos(angle), std::sin(angle), 0.0);
    const Vec3 across = std::cos(angle / 2.0) * radial + std::sin(angle / 2.0) * Vec3::UnitZ();
    soup.positions.push_back(3.0 * radial + across);
    soup.positions.push_back(3.0 * radial - across);
    const bool last = i + 1 == quads;  // after a half twist, the sides are exchanged
    const std::uint32_t next = last ? 1 : 2 * i + 2;
    const std::uint32_t next_across = last ? 0 : 2 * i + 3;
    soup.triangles.push_back({2 * i, next, 2 * i + 1});
    soup.triangles.push_back({next, next_across, 2 * i + 1});
  }
  return soup;
}

// Fins around one edge, oriented by the bits of `orientations`.
Soup fins(std::uint32_t count, std::uint32_t orientations) {
  Soup soup;
  soup.positions = {Vec3::Zero(), Vec3::UnitZ()};
  for (std::uint32_t i = 0; i < count; ++i) {
    soup.positions.emplace_back(1.0, static_cast<double>(i), 0.0);
    const bool flipped = (orientations >> i) & 1;
    soup.triangles.push_back(flipped ? Triangle{1, 0, 2 + i} : Triangle{0, 1, 2 + i});
  }
  return soup;
}

void append(Soup& soup, const Soup& more) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), more.positions.begin(), more.positions.end());
  for (const Triangle& t : more.triangles) {
    soup.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

// Triangles between few points of a coarse grid, with many defects of every kind.
Soup random_soup(test::Random& random) {
  Soup soup;
  const auto half = static_cast<double>(1 + random.index(3));
  const std::size_t position_count = 3 + random.index(30);
  for (std::size_t i = 0; i < position_count; ++i) {
    Vec3 p = random.in_box(half + 0.5).array().round();
    if (random.index(4) == 0) p = -p;  // makes -0
    soup.positions.push_back(p);
  }
  const std::size_t triangle_count = random.index(150);
  for (std::size_t i = 0; i < triangle_count; ++i) {
    Triangle t;
    for (std::uint32_t& v : t) v = static_cast<std::uint32_t>(random.index(position_count));
    soup.triangles.push_back(t);
  }
  return soup;
}

// A closed surface with some faces reversed, repeated and removed, a few arbitrary faces added, and
// all faces in another order.
Soup damaged_surface(test::Random& random) {
  const auto size = [&] { return static_cast<std::uint32_t>(3 + random.index(5)); };
  Soup soup = random.index(2) == 0 ? torus(size(), size()) : cube();
  if (random.index(2) == 0) append(soup, tetrahedron());
  const std::uint64_t rarity = 2 + random.index(20);
  std::vector<Triangle> triangles;
  for (Triangle t : soup.triangles) {
    if (random.index(rarity) == 0) continue;
    if (random.index(rarity) == 0) std::swap(t[0], t[1]);
    triangles.push_back(t);
    if (random.index(rarity) == 0) triangles.push_back({t[2], t[0], t[1]});
    if (random.index(rarity) == 0) {
      triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(random.index(8))});
    }
  }
  for (std::size_t i = triangles.size(); i > 1; --i) {
    std::swap(triangles[i - 1], triangles[random.index(i)]);
  }
  soup.triangles = triangles;
  return random.index(2) == 0 ? soup : with_seams(soup);
}

// ---- Properties of every soup

// Computed in double. Exact for the soups above: their coordinates are small integers, or in
// general position, where the area is zero only for a repeated corner.
bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return (b - a).cross(c - a) != Vec3::Zero();
}

struct Reference {  // a slow implementation of the rules of SurfaceMesh
  std::vector<std::uint32_t> kept;
  std::size_t degenerate = 0;
  std::size_t duplicate = 0;
};

Reference clean(const Soup& soup) {
  Reference reference;
  std::set<std::set<Key>> seen;
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
    const Triangle& v = soup.triangles[t];
    const auto& p = soup.positions;
    if (!has_area(p[v[0]], p[v[1]], p[v[2]])) {
      ++reference.degenerate;
    } else if (!seen.insert({key_of(p[v[0]]), key_of(p[v[1]]), key_of(p[v[2]])}).second) {
      ++reference.duplicate;
    } else {
      reference.kept.push_back(t);
    }
  }
  return reference;
}

void expect_no_area_lost(const Soup& soup, const SurfaceMesh& mesh) {
  const Reference reference = clean(soup);
  const CleaningReport& report = mesh.report();
  EXPECT_EQ(report.triangles_in, soup.triangles.size());
  EXPECT_EQ(report.triangles, reference.kept.size());
  EXPECT_EQ(report.dropped_degenerate, reference.degenerate);
  EXPECT_EQ(report.dropped_duplicate, reference.duplicate);
  ASSERT_EQ(mesh.face_count(), reference.kept.size());
  std::set<Key> used;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    ASSERT_EQ(mesh.source_triangle(f), reference.kept[f]);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3& position = mesh.welded_positions()[mesh.face(f)[i]];
      ASSERT_EQ(position, soup.positions[soup.triangles[reference.kept[f]][i]]);
      used.insert(key_of(position));
      for (const double x : position) ASSERT_FALSE(x == 0.0 && std::signbit(x));
    }
  }
  EXPECT_EQ(mesh.welded_positions().size(), used.size());
  EXPECT_EQ(report.welded_vertices, used.size());
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;  // welded vertices, the lower one first
struct EdgeUse {
  std::vector<std::uint32_t> faces;
  int balance = 0;  // upward uses minus downward uses
};

std::map<Edge, EdgeUse> edges_of(const SurfaceMesh& mesh) {
  std::map<Edge, EdgeUse> edges;
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t from = mesh.face(f)[e];
      const std::uint32_t to = mesh.face(f)[(e + 1) % 3];
      EdgeUse& use = edges[{std::min(from, to), std::max(from, to)}];
      use.faces.push_back(f);
      use.balance += from < to ? 1 : -1;
    }
  }
  return edges;
}

void expect_true_neighbours(const SurfaceMesh& mesh) {
  const std::map<Edge, EdgeUse> edges = edges_of(mesh);
  std::size_t boundary = 0;
  std::size_t non_manifold = 0;
  for (const auto& [edge, use] : edges) {
    boundary += use.faces.size() == 1 ? 1 : 0;
    non_manifold += use.faces.size() > 2 || (use.faces.size() == 2 && use.balance != 0) ? 1 : 0;
  }
  EXPECT_EQ(mesh.report().boundary_edges, boundary);
  EXPECT_EQ(mesh.report().non_manifold_edges, non_manifold);
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    for (int e = 0; e < 3; ++e) {
      const std::uint32_t from = mesh.face(f)[static_cast<std::size_t>(e)];
      const std::uint32_t to = mesh.face(f)[static_cast<std::size_t>((e + 1) % 3)];
      const EdgeUse& use = edges.at({std::min(from, to), std::max(from, to)});
      std::uint32_t expected = SurfaceMesh::kNone;
      if (use.faces.size() == 2) expected = use.faces[0] == f ? use.faces[1] : use.faces[0];
      ASSERT_EQ(mesh.welded_neighbour(f, e), expected) << "face " << f << " edge " << e;
    }
  }
}

// OpenMesh's faces are the welded faces, connected exactly across edges with two faces oriented
// alike.
void expect_faithful_open_mesh(const SurfaceMesh& mesh) {
  const OpenMeshSurface& surface = mesh.surface();
  ASSERT_EQ(surface.n_faces(), mesh.face_count());
  ASSERT_EQ(surface.n_vertices(), mesh.report().welded_vertices + mesh.report().split_vertices);
  const std::map<Edge, EdgeUse> edges = edges_of(mesh);
  for (const auto face : surface.faces()) {
    std::size_t i = 0;
    for (const auto vertex : face.vertices()) {
      const std::uint32_t welded = mesh.welded_vertex(static_cast<std::size_t>(vertex.idx()));
      ASSERT_EQ(welded, mesh.face(static_cast<std::size_t>(face.idx()))[i++]);
      ASSERT_EQ(surface.point(vertex), mesh.welded_positions()[welded]);
    }
    ASSERT_EQ(i, 3u);
  }
  for (const auto edge : surface.edges()) {
    const std::uint32_t u = mesh.welded_vertex(static_cast<std::size_t>(edge.v0().idx()));
    const std::uint32_t v = mesh.welded_vertex(static_cast<std::size_t>(edge.v1().idx()));
    const EdgeUse& use = edges.at({std::min(u, v), std::max(u, v)});
    ASSERT_EQ(!edge.is_boundary(), use.faces.size() == 2 && use.balance == 0);
  }
}

void expect_sound_open_mesh(const OpenMeshSurface& surface) {
  std::ostringstream complaints;
  OpenMesh::Utils::MeshCheckerT<OpenMeshSurface> checker(surface);
  EXPECT_TRUE(checker.check(OpenMesh::Utils::MeshCheckerT<OpenMeshSurface>::CHECK_ALL, complaints))
      << complaints.str();
  for (const auto vertex : surface.vertices()) {
    ASSERT_TRUE(surface.is_manifold(vertex));
    ASSERT_GT(surface.valence(vertex), 1u);
  }
}

// OpenMesh's own builder accepts every split face, in any order.
void expect_add_face_accepts(const OpenMeshSurface& surface, test::Random& random, bool shuffle) {
  std::vector<std::array<OpenMesh::VertexHandle, 3>> faces;
  for (const auto face : surface.faces()) {
    std::array<OpenMesh::VertexHandle, 3> corners;
    std::size_t i = 0;
    for (const auto vertex : face.vertices()) corners[i++] = vertex;
    faces.push_back(corners);
  }
  for (std::size_t i = faces.size(); shuffle && i > 1; --i) {
    std::swap(faces[i - 1], faces[random.index(i)]);
  }
  OpenMeshSurface rebuilt;
  for (const auto vertex : surface.vertices()) rebuilt.add_vertex(surface.point(vertex));
  for (const auto& corners : faces) {
    ASSERT_TRUE(rebuilt.add_face(corners[0], corners[1], corners[2]).is_valid());
  }
  ASSERT_EQ(rebuilt.n_faces(), surface.n_faces());
}

SurfaceMesh checked_mesh(const Soup& soup, test::Random& random) {
  SurfaceMesh mesh = SurfaceMesh::build(soup.positions, soup.triangles);
  expect_no_area_lost(soup, mesh);
  expect_true_neighbours(mesh);
  expect_faithful_open_mesh(mesh);
  expect_sound_open_mesh(mesh.surface());
  expect_add_face_accepts(mesh.surface(), random, false);
  expect_add_face_accepts(mesh.surface(), random, true);
  return mesh;
}

// ---- Arbitrary input

TEST(SurfaceMesh, KeepsEveryFaceWithAreaOfRandomSoups) {
  test::Random random(201);
  for (int trial = 0; trial < 1500 && !testing::Test::HasFailure(); ++trial) {
    SCOPED_TRACE(trial);
    const SurfaceMesh mesh = checked_mesh(random_soup(random), random);
  }
}

TEST(SurfaceMesh, KeepsEveryFaceWithAreaOfDamagedSurfaces) {
  test::Random random(202);
  for (int trial = 0; trial < 1500 && !testing::Test::HasFailure(); ++trial) {
    SCOPED_TRACE(trial);
    const SurfaceMesh mesh = checked_mesh(damaged_surface(random), random);
  }
}

TEST(SurfaceMesh, KeepsEveryFinOfAnEdgeInAnyOrientation) {
  test::Random random(203);
  for (std::uint32_t count = 1; count <= 6; ++count) {
    for (std::uint32_t orientations = 0; orientations < 1u << count; ++orientations) {
      const SurfaceMesh mesh = checked_mesh(fins(count, orientations), random);
      EXPECT_EQ(mesh.face_count(), count);
    }
  }
}

TEST(FixedArray, IsEmptyAfterAMove) {
  FixedArray<int> array(3);
  FixedArray<int> taken = std::move(array);
  EXPECT_EQ(taken.size(), 3u);
  EXPECT_TRUE(array.empty());  // NOLINT(bugprone-use-after-move): the tested state
  array = std::move(taken);
  EXPECT_EQ(array.size(), 3u);
  EXPECT_TRUE(taken.empty());  // NOLINT(bugprone-use-after-move)
}

TEST(SurfaceMesh, IsEmptyForNoTrianglesOrNoArea) {
  test::Random random(204);
  EXPECT_EQ(checked_mesh({}, random).face_count(), 0u);
  const Soup line = {{Vec3::Zero(), Vec3::Ones(), 2.0 * Vec3::Ones()}, {{0, 1, 2}, {0, 0, 1}}};
  const SurfaceMesh mesh = checked_mesh(line, random);
  EXPECT_EQ(mesh.report().dropped_degenerate, 2u);
  EXPECT_TRUE(mesh.welded_positions().empty());
}

TEST(SurfaceMesh, KeepsAFanOfManyFacesAtOneVertex) {
  const std::uint32_t count = 200000;
  const Soup soup = fan(count, true);
  const SurfaceMesh mesh = SurfaceMesh::build(soup.positions, soup.triangles);
  EXPECT_EQ(mesh.report().triangles, count);
  EXPECT_EQ(mesh.report().boundary_edges, count);
  EXPECT_EQ(mesh.report().split_vertices, 0u);
}

// ---- Known surfaces

long euler_characteristic(const OpenMeshSurface& surface) {
  return static_cast<long>(surface.n_vertices()) - static_cast<long>(surface.n_edges()) +
         static_cast<long>(surface.n_faces());
}

void expect_closed(const Soup& soup, long euler, test::Random& random) {
  const SurfaceMesh mesh = checked_mesh(with_seams(posed(soup, random)), random);
  EXPECT_EQ(euler_characteristic(mesh.surface()), euler);
  EXPECT_EQ(mesh.report().boundary_edges, 0u);
  EXPECT_EQ(mesh.report().non_manifold_edges, 0u);
  EXPECT_EQ(mesh.report().split_vertices, 0u);
  EXPECT_EQ(mesh.face_count(), soup.triangles.size());
  EXPECT_EQ(mesh.welded_positions().size(), soup.positions.size());
}

TEST(SurfaceMesh, WeldsSeamsOfClosedSurfacesAndKeepsTheirEulerCharacteristic) {
  test::Random random(205);
  for (int trial = 0; trial < 20; ++trial) {
    expect_closed(tetrahedron(), 2, random);
    expect_closed(cube(), 2, random);
    expect_closed(torus(5, 7), 0, random);
    Soup two = torus(8, 4);
    append(two, tetrahedron(Vec3(20.0, 0.0, 0.0)));
    expect_closed(two, 2, random);
  }
}

TEST(SurfaceMesh, DoesNotSplitAClosedPillow) {
  test::Random random(206);
  Soup pillow = fan(9, true, 0.25);
  Soup back = fan(9, true, -0.25);
  for (Triangle& t : back.triangles) std::swap(t[1], t[2]);
  append(pillow, back);
  const SurfaceMesh mesh = checked_mesh(pillow, random);
  EXPECT_EQ(euler_characteristic(mesh.surface()), 2);
  EXPECT_EQ(mesh.report().split_vertices, 0u);
}

TEST(SurfaceMesh, KeepsOneSideOfASheetGivenTwice) {
  test::Random random(207);
  Soup sheet = fan(9, true);
  const std::size_t faces = sheet.triangles.size();
  for (std::size_t f = 0; f < faces; ++f) {
    const Triangle t = sheet.triangles[f];
    sheet.triangles.push_back({t[1], t[0], t[2]});
  }
  const SurfaceMesh mesh = checked_mesh(sheet, random);
  EXPECT_EQ(mesh.report().dropped_duplicate, faces);
  EXPECT_EQ(mesh.report().non_manifold_edges, 0u);
}

TEST(SurfaceMesh, SplitsTheVertexOfABowTie) {
  test::Random random(208);
  const Soup open = {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(-1, 0, 0), Vec3(-1, -1, 0)},
                     {{0, 1, 2}, {0, 3, 4}}};
  EXPECT_EQ(checked_mesh(open, random).report().split_vertices, 1u);
  Soup closed = tetrahedron();
  append(closed, tetrahedron(Vec3::Zero(), -1.0));
  const SurfaceMesh mesh = checked_mesh(closed, random);
  EXPECT_EQ(mesh.report().split_vertices, 1u);
  EXPECT_EQ(mesh.report().non_manifold_edges, 0u);
  EXPECT_EQ(euler_characteristic(mesh.surface()), 4);
}

TEST(SurfaceMesh, CutsAMoebiusStripOnceAndKeepsItsWeldedNeighbours) {
  test::Random random(209);
  const Soup strip = moebius_strip(12);
  const SurfaceMesh mesh = checked_mesh(strip, random);
  EXPECT_EQ(mesh.report().non_manifold_edges, 1u);
  EXPECT_EQ(mesh.report().split_vertices, 2u);
  EXPECT_EQ(mesh.report().boundary_edges, 24u);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    int neighbours = 0;
    for (int e = 0; e < 3; ++e) neighbours += mesh.welded_neighbour(f, e) != SurfaceMesh::kNone;
    EXPECT_EQ(neighbours, 2);
  }
}

TEST(SurfaceMesh, SeparatesAFinWithoutCuttingTheSurfaceBelowIt) {
  test::Random random(210);
  Soup finned = cube();
  finned.positions.emplace_back(-1.0, -1.0, 0.0);
  finned.triangles.insert(finned.triangles.begin(), {0, 4, 8});
  const SurfaceMesh mesh = checked_mesh(finned, random);
  EXPECT_EQ(mesh.report().non_manifold_edges, 1u);
  EXPECT_EQ(mesh.report().boundary_edges, 2u);
  EXPECT_EQ(mesh.report().split_vertices, 2u);
}

TEST(SurfaceMesh, KeepsOutwardFacesOutwardInOpenMesh) {
  test::Random random(211);
  const Soup soup = posed(cube(), random);
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : soup.positions) centre += p / 8.0;
  const SurfaceMesh mesh = checked_mesh(soup, random);
  const OpenMeshSurface& surface = mesh.surface();
  for (const auto face : surface.faces()) {
    const Vec3 outwards = surface.calc_face_centroid(face) - centre;
    EXPECT_NEAR(surface.calc_face_normal(face).dot(outwards), 0.5, 1e-14);
  }
}

TEST(SurfaceMesh, FindsTheSourceTriangleOfEveryFaceDespiteDroppedTriangles) {
  // A repeated pattern: a triangle without area, a kept one, a duplicate pair, a kept one.
  Soup soup = torus(6, 6);
  const std::vector<Triangle> whole = soup.triangles;
  soup.triangles.clear();
  std::vector<std::uint32_t> kept;
  const auto add = [&](const Triangle& t) {
    soup.triangles.push_back(t);
    return static_cast<std::uint32_t>(soup.triangles.size() - 1);
  };
  for (const Triangle& t : whole) {
    add({t[0], t[0], t[1]});
    kept.push_back(add(t));
    add({t[1], t[0], t[2]});
    add({t[2], t[2], t[2]});
  }
  const SurfaceMesh mesh = SurfaceMesh::build(soup.positions, soup.triangles);
  ASSERT_EQ(mesh.face_count(), whole.size());
  EXPECT_EQ(mesh.report().dropped_degenerate, 2 * whole.size());
  EXPECT_EQ(mesh.report().dropped_duplicate, whole.size());
  EXPECT_EQ(mesh.faces(), whole);
  for (std::size_t f = 0; f < whole.size(); ++f) ASSERT_EQ(mesh.source_triangle(f), kept[f]);
}

TEST(SurfaceMesh, CopiesShareNoMutableState) {
  test::Random random(212);
  const Soup soup = torus(6, 6);
  SurfaceMesh mesh = checked_mesh(soup, random);
  const SurfaceMesh copy = mesh;
  const std::size_t bytes = mesh.memory_bytes();
  mesh = SurfaceMesh::build({}, {});
  EXPECT_EQ(copy.surface().n_faces(), soup.triangles.size());
  EXPECT_LT(mesh.memory_bytes(), bytes);
}

}  // namespace
}  // namespace palpate
