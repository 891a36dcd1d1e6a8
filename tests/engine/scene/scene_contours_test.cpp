// Tests contours through the centre of a scene against closed forms.

#include "engine/scene/scene_contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/mesh/section.h"
#include "models/primitives.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

// Tolerance of lengths, relative to the size of the cut surface: a few rounding errors in each of
// some hundred segments.
constexpr double kRoundoff = 1e-13;

MeshDescription mesh_of(const TriangleMesh& mesh) {
  return {"mesh", mesh.positions_m, mesh.triangles};
}

NodeDescription node_of(std::uint32_t mesh, const Mat3& linear, const Vec3& translation_m) {
  NodeDescription node;
  node.name = "node";
  node.mesh = mesh;
  node.linear_scene_mesh = linear;
  node.translation_m = translation_m;
  return node;
}

Scene compiled_parts(std::vector<MeshDescription> meshes, std::vector<NodeDescription> nodes,
                     const SceneSettings& settings = {}) {
  SceneDescription description;
  description.meshes = std::move(meshes);
  description.nodes = std::move(nodes);
  auto scene = Scene::compile(std::move(description), settings);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return std::move(*scene);
}

std::array<SceneContour, 3> contours_of(const Scene& scene) {
  const auto contours = scene_contours(scene);
  EXPECT_TRUE(contours);
  return contours.value_or(std::array<SceneContour, 3>{});
}

// The outline of a box cut by the plane perpendicular to an axis through its centre: the points on
// the twelve edges of the box, ordered around the centre.
double outline_m(const Vec3& size_m, const Mat3& linear, int axis) {
  std::vector<Vec3> points;
  for (int along = 0; along < 3; ++along) {
    for (int edge = 0; edge < 4; ++edge) {
      Vec3 from = 0.5 * size_m;
      from[along] *= -1.0;
      if (edge & 1) from[(along + 1) % 3] *= -1.0;
      if (edge & 2) from[(along + 2) % 3] *= -1.0;
      Vec3 to = from;
      to[along] *= -1.0;
      const Vec3 a = linear * from;
      const Vec3 b = linear * to;
      if ((a[axis] < 0.0) != (b[axis] < 0.0)) {
        points.push_back(a + a[axis] / (a[axis] - b[axis]) * (b - a));
      }
    }
  }
  const auto angle = [&](const Vec3& p) {
    return std::atan2(p[(axis + 2) % 3], p[(axis + 1) % 3]);
  };
  std::sort(points.begin(), points.end(),
            [&](const Vec3& p, const Vec3& q) { return angle(p) < angle(q); });
  double length = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    length += (points[(i + 1) % points.size()] - points[i]).norm();
  }
  return length;
}

// A random rotation, stretch and shear; every second matrix is also a mirror.
Mat3 random_stretch(Random& random) {
  Mat3 stretch = Mat3::Identity();
  stretch(0, 1) = random.uniform(-1, 1);
  const Vec3 scales(random.index(2) == 0 ? -1.0 : 1.0, random.uniform(0.3, 3), 1.0);
  return random.rotation().toRotationMatrix() * stretch * scales.asDiagonal() *
         random.rotation().toRotationMatrix();
}

TEST(SceneContours, EqualTheOutlinesOfABoxInAnyPose) {
  Random random(41);
  for (int round = 0; round < 100; ++round) {
    const Vec3 size_m(random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1));
    const Mat3 linear = random_stretch(random);
    const Vec3 place_m = random.in_box(10.0);
    const Scene scene = compiled_parts({mesh_of(box(size_m))}, {node_of(0, linear, place_m)});
    const auto contours = contours_of(scene);
    // The corners of a model are floats.
    const Vec3 stored_m = size_m.cast<float>().cast<double>();
    for (int axis = 0; axis < 3; ++axis) {
      const SceneContour& c = contours[axis];
      EXPECT_NEAR(c.offset_m, place_m[axis], 1e-14);
      EXPECT_EQ(c.curves, 1u);
      EXPECT_TRUE(c.is_closed);
      EXPECT_NEAR(c.longest_m, outline_m(stored_m, linear, axis), 1e-6);
    }
  }
}

TEST(SceneContours, EqualTheGreatCirclesOfASphere) {
  Random random(42);
  for (const double radius_m : {1e-6, 0.1, 1e4}) {
    const Mat3 rotation = random.rotation().toRotationMatrix();
    const Scene scene =
        compiled_parts({mesh_of(icosphere(5, radius_m))},
                       {node_of(0, rotation, 3.0 * radius_m * random.unit_vector())});
    const double circle_m = 2.0 * std::numbers::pi * radius_m;
    for (const SceneContour& c : contours_of(scene)) {
      EXPECT_EQ(c.curves, 1u);
      EXPECT_TRUE(c.is_closed);
      // The edges of an icosphere with five subdivisions are a thirtieth of its radius long.
      EXPECT_LT(c.longest_m, circle_m * (1.0 + 1e-6));
      EXPECT_GT(c.longest_m, circle_m * (1.0 - 1e-3));
    }
  }
}

// Two rings of vertices lie in the plane, one outside and one inside.
TEST(SceneContours, EqualThePolygonsOfATorus) {
  const Scene scene =
      compiled_parts({mesh_of(torus(1.0, 0.25, 2))}, {node_of(0, Mat3::Identity(), Vec3::Zero())});
  const SceneContour across_z = contours_of(scene)[2];
  EXPECT_EQ(across_z.offset_m, 0.0);
  EXPECT_EQ(across_z.curves, 2u);
  EXPECT_TRUE(across_z.is_closed);
  constexpr int kCorners = 32;
  // The corners of a model are floats.
  EXPECT_NEAR(across_z.longest_m, 2 * kCorners * 1.25 * std::sin(std::numbers::pi / kCorners),
              1e-5);
}

TEST(SceneContours, GrowWithTheScene) {
  const std::vector<NodeDescription> nodes = {node_of(0, Mat3::Identity(), Vec3(1, 2, 3))};
  const auto once = contours_of(compiled_parts({mesh_of(box(Vec3(1, 2, 4)))}, nodes));
  SceneSettings fit;
  fit.fit_size_m = 0.5;
  const auto fitted = contours_of(compiled_parts({mesh_of(box(Vec3(1, 2, 4)))}, nodes, fit));
  const std::array<double, 3> lengths = {12.0, 10.0, 6.0};
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(once[axis].longest_m, lengths[axis], kRoundoff * 12.0);
    EXPECT_NEAR(fitted[axis].longest_m, lengths[axis] / 8.0, kRoundoff);
    EXPECT_NEAR(fitted[axis].offset_m, once[axis].offset_m / 8.0, kRoundoff);
  }
}

TEST(SceneContours, AreOpenForAnOpenMeshAndEmptyIfThePlaneCutsNothing) {
  // A wall in the plane y = 0. The plane perpendicular to y has the wall on one side.
  const MeshDescription wall = {
      "wall", {{0, 0, 0}, {3, 0, 0}, {3, 0, 1}, {0, 0, 1}}, {{0, 1, 2}, {0, 2, 3}}};
  const auto contours =
      contours_of(compiled_parts({wall}, {node_of(0, Mat3::Identity(), Vec3::Zero())}));
  EXPECT_EQ(contours[0].curves, 1u);
  EXPECT_FALSE(contours[0].is_closed);
  EXPECT_NEAR(contours[0].longest_m, 1.0, kRoundoff);
  EXPECT_EQ(contours[1].curves, 0u);
  EXPECT_EQ(contours[1].longest_m, 0.0);
  EXPECT_NEAR(contours[2].longest_m, 3.0, kRoundoff);
}

TEST(SceneContours, CountTheCurvesOfAllNodesAndReportTheLongest) {
  // Three boxes in a row along x, the last one mirrored and twice as large.
  const Mat3 mirrored = Vec3(-2, 2, 2).asDiagonal();
  const Scene scene =
      compiled_parts({mesh_of(box(Vec3(1, 1, 1)))}, {node_of(0, Mat3::Identity(), Vec3(0, 0, 0)),
                                                     node_of(0, Mat3::Identity(), Vec3(4, 0, 0)),
                                                     node_of(0, mirrored, Vec3(10, 0, 0))});
  const auto contours = contours_of(scene);
  EXPECT_EQ(contours[0].curves, 0u);  // at x = 5.25
  for (const int axis : {1, 2}) {
    EXPECT_EQ(contours[axis].curves, 3u);
    EXPECT_TRUE(contours[axis].is_closed);
    EXPECT_NEAR(contours[axis].longest_m, 8.0, 8.0 * kRoundoff);
  }
}

// `palpate run` cuts all triangles at once.
TEST(SceneContours, EqualThoseOfTheWholeSceneCutAtOnce) {
  Random random(43);
  for (int round = 0; round < 20; ++round) {
    std::vector<NodeDescription> nodes;
    for (std::size_t n = 1 + random.index(12); n > 0; --n) {
      nodes.push_back(node_of(static_cast<std::uint32_t>(random.index(3)), random_stretch(random),
                              random.in_box(2.0)));
    }
    nodes.push_back(node_of(0, Mat3::Identity(), Vec3::Zero()));
    nodes.push_back(node_of(1, Mat3::Identity(), Vec3::Zero()));
    nodes.push_back(node_of(2, Mat3::Identity(), Vec3::Zero()));
    const Scene scene = compiled_parts(
        {mesh_of(torus(1.0, 0.3, 2)), mesh_of(icosphere(3, 1.0)), mesh_of(box(Vec3(1, 2, 3)))},
        nodes);
    std::vector<Vec3> positions_m;
    std::vector<Triangle> triangles;
    scene.append_triangles_scene(positions_m, triangles);
    const auto contours = contours_of(scene);
    for (int axis = 0; axis < 3; ++axis) {
      const auto curves =
          plane_section(positions_m, triangles, Vec3::Unit(axis), contours[axis].offset_m);
      EXPECT_EQ(contours[axis].curves, curves.size());
      if (curves.empty()) continue;
      EXPECT_EQ(contours[axis].is_closed, curves.front().closed);
      const double length = length_m(curves.front());
      EXPECT_NEAR(contours[axis].longest_m, length, kRoundoff * length);
    }
  }
}

TEST(SceneContours, AreNotComputedForTooManyFaces) {
  const std::vector<NodeDescription> nodes(10, node_of(0, Mat3::Identity(), Vec3::Zero()));
  const Scene scene = compiled_parts({mesh_of(icosphere(2, 1.0))}, nodes);
  EXPECT_FALSE(scene_contours(scene, 3 * 10 * 320 - 1));
  EXPECT_TRUE(scene_contours(scene, 3 * 10 * 320));
}

}  // namespace
}  // namespace palpate
