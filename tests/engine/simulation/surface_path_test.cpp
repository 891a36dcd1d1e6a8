// Paths over surfaces: the properties of geodesics, and the limits of the paths.

#include "engine/simulation/surface_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "models/primitives.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct PlacedMesh {
  std::vector<Vec3> positions_m;
  std::vector<Triangle> triangles;
  Mat3 linear = Mat3::Identity();
  Vec3 middle_m = Vec3::Zero();
};

Scene scene_of(const std::vector<PlacedMesh>& parts) {
  SceneDescription description;
  for (const PlacedMesh& part : parts) {
    const std::string name = "part " + std::to_string(description.nodes.size());
    const auto mesh = static_cast<std::uint32_t>(description.meshes.size());
    description.meshes.push_back({name, part.positions_m, part.triangles});
    description.nodes.push_back({name, mesh, part.linear, part.middle_m});
  }
  auto scene = Scene::compile(std::move(description));
  EXPECT_TRUE(scene) << scene.error().to_string();
  return std::move(*scene);
}

PlacedMesh placed(const TriangleMesh& mesh) {
  return {mesh.positions_m, mesh.triangles};
}
PlacedMesh placed(const test::Soup& soup) {
  return {soup.positions, soup.triangles};
}

// A prism with this many sides about the z axis, and its caps.
TriangleMesh cylinder(int sides, double radius_m, double half_height_m) {
  Contour contour;
  for (int i = 0; i < sides; ++i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / sides;
    contour.emplace_back(radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad));
  }
  return *prism(contour, -half_height_m, half_height_m);
}

test::Soup sheet(double half_m) {
  test::Soup soup;
  soup.add_quad({-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0},
                {-half_m, half_m, 0});
  return soup;
}

SurfacePath path_over(const Scene& scene, std::uint64_t seed, double length_m = 1.0,
                      double room_m = 4e-3) {
  SurfacePathSettings settings;
  settings.length_m = length_m;
  settings.leg_m = 0.12 * length_m;
  settings.room_m = room_m;
  settings.seed = seed;
  auto path = plan_surface_path(scene, settings);
  EXPECT_TRUE(path);
  return path ? *path : SurfacePath{};
}

// Rotation, uneven scale and shear; every second transform mirrors.
Mat3 random_linear(Random& random) {
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = random.uniform(-0.5, 0.5);
  const double mirror = random.index(2) == 0 ? -1.0 : 1.0;
  const Vec3 scales(mirror * random.uniform(0.5, 2.0), random.uniform(0.5, 2.0), 1.0);
  return random.rotation().toRotationMatrix() * shear * scales.asDiagonal();
}

// Whether p lies in a triangle, to within an error.
bool is_in(const Vec3& p, const std::array<Vec3, 3>& corners, const Vec3& normal, double error_m) {
  if (std::abs((p - corners[0]).dot(normal)) > error_m) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 out = (corners[(k + 1) % 3] - corners[k]).normalized().cross(normal);
    if ((p - corners[k]).dot(out) > error_m) return false;
  }
  return true;
}

// Every leg lies in a triangle of the scene and is touched from its front.
void expect_on_surface(const Scene& scene, const HandPath& path) {
  std::vector<Vec3> positions_m;
  std::vector<Triangle> triangles;
  scene.append_triangles_scene(positions_m, triangles);
  double size_m = 0.0;
  for (const Vec3& p : positions_m) size_m = std::max(size_m, p.cwiseAbs().maxCoeff());
  const double error_m = 1000 * kEpsilon * size_m;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const HandPath::Point& from = path.points[i];
    const Vec3& to_m = path.points[i + 1].p_m;
    const bool is_there = std::any_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
      const std::array<Vec3, 3> corners{positions_m[t[0]], positions_m[t[1]], positions_m[t[2]]};
      const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
      return (from.inward + normal).norm() < 1e-6 && is_in(from.p_m, corners, normal, error_m) &&
             is_in(to_m, corners, normal, error_m);
    });
    ASSERT_TRUE(is_there) << "leg " << i << " of " << path.points.size();
  }
}

// Across an edge a geodesic keeps its angle with the edge; between coplanar faces it keeps its
// direction. Counts the edges.
void expect_straight(const HandPath& path, int& crossed) {
  for (std::size_t i = 1; i + 1 < path.points.size(); ++i) {
    const HandPath::Point& at = path.points[i];
    if (at.is_turn) continue;
    const Vec3 in = (at.p_m - path.points[i - 1].p_m).normalized();
    const Vec3 out = (path.points[i + 1].p_m - at.p_m).normalized();
    const Vec3 edge = path.points[i - 1].inward.cross(at.inward);
    const double length_m = std::min((at.p_m - path.points[i - 1].p_m).norm(),
                                     (path.points[i + 1].p_m - at.p_m).norm());
    if (length_m < 1e-4) continue;  // its direction is rounded
    ++crossed;
    if (edge.norm() < 1e-6) {
      ASSERT_LT((in - out).norm(), 1e-6) << i;
    } else {
      ASSERT_NEAR(in.dot(edge.normalized()), out.dot(edge.normalized()), 1e-6) << i;
      const double angle_rad = std::atan2(edge.norm(), path.points[i - 1].inward.dot(at.inward));
      ASSERT_NEAR(std::abs(at.fold_rad), angle_rad, 1e-9);
      ASSERT_EQ(at.fold_rad > 0.0, at.inward.dot(in) < 0.0) << "convex if the path leads down";
    }
  }
}

TEST(SurfacePath, IsAGeodesicOnNodesWithAnyTransform) {
  Random random(8101);
  const std::vector<TriangleMesh> meshes{box({0.2, 0.15, 0.1}), icosphere(3, 0.1),
                                         torus(0.1, 0.04, 1), cylinder(12, 0.05, 0.1)};
  int crossed = 0;
  for (int i = 0; i < 40; ++i) {
    PlacedMesh part = placed(meshes[random.index(meshes.size())]);
    part.linear = random_linear(random);
    part.middle_m = random.in_box(1.0);
    const Scene scene = scene_of({part});
    const HandPath path = path_over(scene, random.index(1000)).path;
    ASSERT_GE(path.points.size(), 3u);
    EXPECT_GT(path.lengths_m().back(), 0.3);
    expect_on_surface(scene, path);
    expect_straight(path, crossed);
  }
  EXPECT_GT(crossed, 500);
}

// Unrolled, the path is a straight line, so its slope along the axis is constant.
TEST(SurfacePath, KeepsItsSlopeOnACylinder) {
  const Scene scene = scene_of({placed(cylinder(200, 0.08, 0.4))});
  for (const std::uint64_t seed : {1, 2, 3}) {
    const HandPath path = path_over(scene, seed).path;
    double slope = 0.0;
    for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
      const Vec3 way = path.points[i + 1].p_m - path.points[i].p_m;
      const bool is_mantle = std::abs(path.points[i].inward.z()) < 1e-9;
      const bool goes_on = i > 0 && !path.points[i].is_turn && is_mantle &&
                           std::abs(path.points[i - 1].inward.z()) < 1e-9;
      if (way.norm() < 1e-5) continue;
      if (goes_on) {
        ASSERT_NEAR(way.z() / way.norm(), slope, 1e-5);
      }
      slope = way.z() / way.norm();
    }
  }
}

// The largest distance of a leg from the plane of a great circle, relative to the radius.
double off_great_circle(int subdivisions) {
  const double radius_m = 0.1;
  const Scene scene = scene_of({placed(icosphere(subdivisions, radius_m))});
  double farthest = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const HandPath path = path_over(scene, seed).path;
    Vec3 normal = Vec3::Zero();
    for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
      const Vec3 way = path.points[i + 1].p_m - path.points[i].p_m;
      if (i == 0 || path.points[i].is_turn) normal = path.points[i].p_m.cross(way).normalized();
      farthest = std::max(farthest, std::abs(path.points[i].p_m.dot(normal)) / radius_m);
    }
  }
  return farthest;
}

TEST(SurfacePath, TendsToGreatCirclesOnFinerSpheres) {
  const double coarse = off_great_circle(2);
  const double fine = off_great_circle(5);
  EXPECT_LT(fine, 0.25 * coarse);
  EXPECT_LT(fine, 0.02);
}

TEST(SurfacePath, TurnsAtTheEdgesOfASheet) {
  const Scene scene = scene_of({placed(sheet(0.1))});
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SurfacePath path = path_over(scene, seed);
    EXPECT_TRUE(path.is_open);
    EXPECT_EQ(path.free_m, std::numeric_limits<double>::infinity());
    EXPECT_GT(path.path.lengths_m().back(), 0.9);
    for (const HandPath::Point& point : path.path.points) {
      EXPECT_LE(point.p_m.cwiseAbs().maxCoeff(), 0.1);
    }
  }
}

// At an edge of two faces with opposite orientations, and at an edge of three faces.
TEST(SurfacePath, TurnsAtNonManifoldAndInconsistentlyOrientedEdges) {
  test::Soup turned = sheet(0.1);
  turned.add_quad({0.1, -0.1, 0}, {0.1, 0.1, 0}, {0.3, 0.1, 0}, {0.3, -0.1, 0});
  test::Soup three = sheet(0.1);
  three.add_quad({0.1, -0.1, 0}, {0.3, -0.1, 0}, {0.3, 0.1, 0}, {0.1, 0.1, 0});
  three.add_quad({0.1, -0.1, 0}, {0.1, -0.1, -0.2}, {0.1, 0.1, -0.2}, {0.1, 0.1, 0});
  for (const test::Soup& soup : {turned, three}) {
    const Scene scene = scene_of({placed(soup)});
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const HandPath path = path_over(scene, seed).path;
      const auto is_left = [](const HandPath::Point& p) { return p.p_m.x() <= 0.1 + 1e-12; };
      const auto is_right = [](const HandPath::Point& p) { return p.p_m.x() >= 0.1 - 1e-12; };
      EXPECT_TRUE(std::all_of(path.points.begin(), path.points.end(), is_left) ||
                  std::all_of(path.points.begin(), path.points.end(), is_right));
    }
  }
}

// Whichever way boxes overlap, the path stays outside all boxes except its own, within the distance
// between two tests.
TEST(SurfacePath, DoesNotEnterOtherBodies) {
  Random random(8102);
  for (int i = 0; i < 60; ++i) {
    struct Solid {
      Vec3 half_m;
      Mat3 rotation;
      Vec3 middle_m;
      double depth_m(const Vec3& p) const {
        return (half_m - (rotation.transpose() * (p - middle_m)).cwiseAbs()).minCoeff();
      }
    };
    std::vector<Solid> solids;
    std::vector<PlacedMesh> parts;
    for (int k = 0; k < 4; ++k) {
      const Vec3 half_m(random.uniform(0.02, 0.1), random.uniform(0.02, 0.1),
                        random.uniform(0.02, 0.1));
      solids.push_back({half_m, random.rotation().toRotationMatrix(), random.in_box(0.1)});
      parts.push_back(placed(test::box_soup(half_m)));
      parts.back().linear = solids.back().rotation;
      parts.back().middle_m = solids.back().middle_m;
    }
    const Scene scene = scene_of(parts);
    const SurfacePath found = path_over(scene, random.index(1000));
    if (std::isfinite(found.free_m)) continue;  // may begin in a closed gap
    for (const HandPath::Point& point : found.path.points) {
      for (const Solid& solid : solids) {
        ASSERT_LT(solid.depth_m(point.p_m), 0.25 * 4e-3 + 1e-9) << i;
      }
    }
  }
}

TEST(SurfacePath, DependsOnlyOnTheSeed) {
  const Scene scene = scene_of({placed(torus(0.1, 0.04, 2))});
  const HandPath a = path_over(scene, 7).path;
  const HandPath b = path_over(scene, 7).path;
  const HandPath c = path_over(scene, 8).path;
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    ASSERT_EQ(a.points[i].p_m, b.points[i].p_m);
    ASSERT_EQ(a.points[i].inward, b.points[i].inward);
  }
  EXPECT_NE(a.points.front().p_m, c.points.front().p_m);
}

// A triangle, slivers, and sizes far from a metre, with a hand of matching size.
TEST(SurfacePath, IsFoundOnAnyMesh) {
  Random random(8103);
  for (int i = 0; i < 60; ++i) {
    const double size_m = std::pow(10.0, random.uniform(-6.0, 6.0));
    test::Soup soup;
    const int triangles = i % 3 == 0 ? 1 : 40;
    for (int t = 0; t < triangles; ++t) {
      const Vec3 a = random.in_box(size_m);
      const Vec3 b = random.in_box(size_m);
      const double thin = i % 3 == 1 ? std::pow(10.0, random.uniform(-12.0, 0.0)) : 1.0;
      soup.add(a, b, a + random.uniform(0.0, 1.0) * (b - a) + thin * random.in_box(size_m));
    }
    const Scene scene = scene_of({placed(soup)});
    SurfacePathSettings settings;
    settings.length_m = 4.0 * size_m;
    settings.leg_m = 0.5 * size_m;
    settings.room_m = 0.02 * size_m;
    settings.seed = random.index(1000);
    const auto found = plan_surface_path(scene, settings);
    if (triangles == 1) {
      ASSERT_TRUE(found);
    }
    if (!found) continue;
    ASSERT_GE(found->path.points.size(), 2u);
    EXPECT_LE(found->path.lengths_m().back(), 5.0 * size_m);
    for (const HandPath::Point& point : found->path.points) {
      ASSERT_TRUE(point.p_m.allFinite());
      ASSERT_NEAR(point.inward.norm(), 1.0, 1e-9);
      ASSERT_LE(point.p_m.cwiseAbs().maxCoeff(), 3.0 * size_m);
    }
  }
}

TEST(SurfacePath, BeginsAnywhereOnNodesThatShareAMesh) {
  SceneDescription description;
  test::Soup box = test::box_soup(Vec3::Constant(0.02));
  description.meshes = {{"box", box.positions, box.triangles}};
  constexpr int kSide = 45;
  for (int k = 0; k < kSide * kSide; ++k) {
    description.nodes.push_back({"box " + std::to_string(k), 0, Mat3::Identity(),
                                 Vec3(0.1 * (k % kSide), 0.1 * (k / kSide), 0)});
  }
  const auto scene = Scene::compile(std::move(description));
  ASSERT_TRUE(scene);
  double least = HUGE_VAL;
  double most = -HUGE_VAL;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const double y = path_over(*scene, seed).path.points.front().p_m.y();
    least = std::min(least, y);
    most = std::max(most, y);
  }
  EXPECT_LT(least, 1.0);
  EXPECT_GT(most, 3.4);
}

// ---- simplified paths ---------------------------------------------------------------------------

double distance_m(const Vec3& p, const HandPath& path) {
  double nearest_m = HUGE_VAL;
  for (std::size_t i = 0; i + 1 < path.points.size(); ++i) {
    const Vec3 along = path.points[i + 1].p_m - path.points[i].p_m;
    const double part =
        std::clamp((p - path.points[i].p_m).dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest_m = std::min(nearest_m, (p - path.points[i].p_m - part * along).norm());
  }
  return nearest_m;
}

TEST(HandPath, IsSimplifiedWithinItsToleranceAndKeepsItsTurns) {
  for (const int subdivisions : {2, 5}) {
    const Scene scene = scene_of({placed(icosphere(subdivisions, 0.1))});
    const HandPath path = path_over(scene, 3).path;
    for (const double tolerance_m : {1e-4, 1e-3}) {
      const HandPath simple = simplified(path, tolerance_m);
      EXPECT_LE(simple.points.size(), path.points.size());
      if (subdivisions == 5) {
        EXPECT_LT(simple.points.size(), path.points.size() / 2);
      }
      EXPECT_EQ(simple.points.front().p_m, path.points.front().p_m);
      EXPECT_EQ(simple.points.back().p_m, path.points.back().p_m);
      for (const HandPath::Point& p : path.points) {
        ASSERT_LE(distance_m(p.p_m, simple), tolerance_m * (1.0 + 1e-9));
      }
      const auto turns = [](const HandPath& of) {
        return std::count_if(of.points.begin(), of.points.end(),
                             [](const HandPath::Point& p) { return p.is_turn; });
      };
      EXPECT_EQ(turns(simple), turns(path));
    }
  }
}

// Over the edge of a plate thinner than the tolerance, and into an equally thin slit.
TEST(HandPath, DistinguishesAnEdgeFromASlitIfBothTurnBack) {
  const Vec3 down = -Vec3::UnitZ();
  HandPath plate;
  plate.points = {{{0, 0, 0}, down},
                  {{0.1, 0, 0}, -Vec3::UnitX(), std::numbers::pi / 2},
                  {{0.1, 0, -1e-4}, -down, std::numbers::pi / 2},
                  {{0, 0, -1e-4}, -down}};
  HandPath slit;
  slit.points = {{{0, 0, 0}, down},
                 {{0.1, 0, 0}, Vec3::UnitX(), -std::numbers::pi / 2},
                 {{0.1, 0, 1e-4}, -down, -std::numbers::pi / 2},
                 {{0, 0, 1e-4}, -down}};
  // The same if the path back bends to the other side of the path there.
  HandPath bent_plate = plate;
  bent_plate.points.back().p_m = {0.0, 0.05, 0.01};
  HandPath bent_slit = slit;
  bent_slit.points.back().p_m = {0.0, 0.05, -0.01};
  for (const HandPath& path : {plate, slit, bent_plate, bent_slit}) {
    const HandPath simple = simplified(path, 1e-3);
    ASSERT_EQ(simple.points.size(), 3u);
    EXPECT_NEAR(std::abs(simple.points[1].fold_rad), std::numbers::pi, 0.1);
    EXPECT_EQ(simple.points[1].fold_rad > 0.0, path.points[1].fold_rad > 0.0);
  }
}

TEST(HandPath, HasPlacesAtEqualDistances) {
  HandPath path;
  path.points = {
      {{0, 0, 0}, Vec3::UnitZ()}, {{0.3, 0, 0}, Vec3::UnitZ()}, {{0.3, 0.4, 0}, Vec3::UnitZ()}};
  const std::vector<Vec3> places = places_along(path, 0.11);
  ASSERT_EQ(places.size(), 8u);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double along = 0.1 * static_cast<double>(i);
    const Vec3 expected = along <= 0.3 ? Vec3(along, 0, 0) : Vec3(0.3, along - 0.3, 0);
    EXPECT_LT((places[i] - expected).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace palpate
