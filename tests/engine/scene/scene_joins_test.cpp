// Boundaries that meet within the rounding of the file, and gaps (SceneSettings::close_gaps_m).

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "engine/scene/scene_contours.h"
#include "haptics/haptic_loop.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/generators.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::compiled;
using test::GeneratedMesh;
using test::Generators;
using test::Random;
using test::Soup;

SceneDescription described(const Soup& soup, const Mat3& linear = Mat3::Identity()) {
  SceneDescription description;
  description.path = "made.glb";
  MeshDescription mesh;
  mesh.name = "mesh";
  mesh.positions = soup.positions;
  mesh.triangles = soup.triangles;
  description.meshes.push_back(std::move(mesh));
  NodeDescription node;
  node.name = "node";
  node.linear_scene_mesh = linear;
  description.nodes.push_back(node);
  return description;
}

double extent_m(const Scene& scene) {
  return scene.statistics().extent_m.maxCoeff();
}

// Every tick gives the same bits on both scenes, along paths that cross the first column and the
// poles, where the generators repeat vertices.
void expect_same_forces(const Scene& scene, const Scene& twin, Random& random) {
  const double size_m = extent_m(scene);
  const Vec3 centre =
      0.5 * (scene.statistics().bounds_scene.low + scene.statistics().bounds_scene.high);
  auto loop = test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(3, 3), {}));
  auto other = test::made(HapticLoop::create(twin.world(), *ActuationModel::from_counts(3, 3), {}));
  int contacts = 0;
  for (int way = 0; way < 8; ++way) {
    const Vec3 axes[] = {Vec3::UnitX(),  -Vec3::UnitX(), Vec3::UnitZ(),
                         -Vec3::UnitZ(), Vec3::UnitY(),  -Vec3::UnitY()};
    const Vec3 out = way < 6 ? axes[way] : random.in_box(1.0).normalized();
    const Vec3 across = 0.02 * size_m * random.in_box(1.0);
    for (int n = 0; n < 120; ++n) {
      const double t = n / 119.0;
      const Vec3 goal = centre + (1.2 - 0.9 * t) * 0.6 * size_m * out + (t - 0.5) * across;
      const TickRecord a = loop.tick(goal, 1e-3), b = other.tick(goal, 1e-3);
      contacts += a.contact != 0 ? 1 : 0;
      for (int k = 0; k < 3; ++k) {
        ASSERT_EQ(a.force_device_N[k], b.force_device_N[k]) << "way " << way << ", tick " << n;
        ASSERT_EQ(a.proxy_scene_m[k], b.proxy_scene_m[k]) << "way " << way << ", tick " << n;
      }
    }
    for (int n = 0; n < 5; ++n) {  // out again
      loop.tick(centre + 2 * size_m * out, 1e-3);
      other.tick(centre + 2 * size_m * out, 1e-3);
    }
  }
  EXPECT_GT(contacts, 100);
}

template <typename Real>
void expect_forces_of_twins() {
  Random random(4520);
  for (const GeneratedMesh& mesh : Generators<Real>::kinds(24)) {
    SCOPED_TRACE(mesh.name);
    const Scene scene = compiled(described(mesh.soup));
    const Scene twin = compiled(described(test::twin_of(mesh.soup)));
    EXPECT_EQ(scene.statistics().cleaning.boundary_edges, 0u);
    EXPECT_GT(scene.statistics().rounding_joins.joined_vertices, 0u);
    EXPECT_EQ(twin.statistics().rounding_joins.joined_vertices, 0u);
    const auto contours = scene_contours(scene), others = scene_contours(twin);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_TRUE((*contours)[axis].is_closed);
      EXPECT_EQ((*contours)[axis].longest_m, (*others)[axis].longest_m);
    }
    expect_same_forces(scene, twin, random);
  }
}

TEST(SceneJoins, ForcesAtSeamsOfDoubleGeneratorsAreThoseOfTheTwins) {
  expect_forces_of_twins<double>();
}

TEST(SceneJoins, ForcesAtSeamsOfFloatGeneratorsAreThoseOfTheTwins) {
  expect_forces_of_twins<float>();
}

// A scene of before: no join.
TEST(SceneJoins, WithoutJoiningASceneIsAsBefore) {
  const Soup sphere = Generators<double>::sphere(0.05, 24, 12);
  SceneSettings before;
  before.joins_within_rounding = false;
  const Scene scene = compiled(described(sphere), before);
  EXPECT_EQ(scene.statistics().cleaning.boundary_edges,
            WeldedSurface(sphere.positions, sphere.triangles).report().boundary_edges);
  EXPECT_GT(scene.statistics().cleaning.boundary_edges, 0u);
  EXPECT_TRUE(scene.statistics().notes.empty());
}

// Two squares of 1 m with a gap of 2 mm along y.
Soup two_squares() {
  Soup soup;
  for (const double y : {0.0, 1.002}) {
    soup.add({0, y, 0}, {1, y, 0}, {1, y + 1, 0});
    soup.add({0, y, 0}, {1, y + 1, 0}, {0, y + 1, 0});
  }
  return soup;
}

TEST(SceneJoins, TheNearestGapIsMeasuredInTheSceneAndCloses) {
  Random random(4521);
  for (int round = 0; round < 20; ++round) {
    const Vec3 stretch(random.uniform(0.2, 3), random.uniform(0.2, 3), random.uniform(0.2, 3));
    const Mat3 linear = random.rotation().toRotationMatrix() * Mat3(stretch.asDiagonal());
    SceneSettings settings;
    settings.measures_gaps = true;
    settings.scale = random.uniform(0.1, 10);
    const Scene open = compiled(described(two_squares(), linear), settings);
    const double gap_m = 0.002 * stretch.y() * settings.scale;
    ASSERT_TRUE(open.statistics().nearest_gap_m);
    EXPECT_NEAR(*open.statistics().nearest_gap_m, gap_m, 1e-9 * settings.scale);
    EXPECT_EQ(open.statistics().cleaning.boundary_edges, 8u);
    settings.close_gaps_m = *open.statistics().nearest_gap_m;
    const Scene closed = compiled(described(two_squares(), linear), settings);
    EXPECT_EQ(closed.statistics().cleaning.boundary_edges, 6u);
    EXPECT_EQ(closed.statistics().gap_joins.joined_edges, 1u);
    EXPECT_EQ(closed.statistics().gap_joins.joined_vertices, 2u);
    ASSERT_EQ(closed.statistics().notes.size(), 1u);
    EXPECT_NE(closed.statistics().notes[0].find("1 pairs of edges"), std::string::npos);
    EXPECT_FALSE(closed.statistics().nearest_gap_m);
    settings.close_gaps_m = std::nextafter(*open.statistics().nearest_gap_m, 0.0);
    EXPECT_EQ(
        compiled(described(two_squares(), linear), settings).statistics().cleaning.boundary_edges,
        8u);
  }
}

// The larger of two scales counts: no node has a closed gap that is wider than demanded.
TEST(SceneJoins, AGapOfTwoNodesIsAsWideAsThatOfTheLargerOne) {
  SceneDescription description = described(two_squares());
  description.nodes.push_back(description.nodes[0]);
  description.nodes[1].linear_scene_mesh *= 3;
  description.nodes[1].translation_m = {9, 0, 0};
  SceneSettings settings;
  settings.measures_gaps = true;
  const Scene scene = compiled(description, settings);
  ASSERT_TRUE(scene.statistics().nearest_gap_m);
  EXPECT_NEAR(*scene.statistics().nearest_gap_m, 0.006, 1e-12);
}

TEST(SceneJoins, AGapThatIsNoGapIsRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double gap_m : {-1e-3, nan, infinity, 2.0, 0.3}) {
    SceneSettings settings;
    settings.close_gaps_m = gap_m;
    const auto scene = Scene::compile(described(two_squares()), settings);
    ASSERT_FALSE(scene) << gap_m;
    EXPECT_EQ(scene.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(scene.error().element, "close_gaps_m");
  }
}

// A gap as wide as the squares of the mesh: joins are not one to one, and a warning says so.
TEST(SceneJoins, AGapThatMeetsSeveralEdgesGivesAWarning) {
  Soup soup;
  for (int k = 0; k < 3; ++k) {
    const double y = 0.01 * k;
    soup.add({0, y, 0}, {1, y, 0}, {0.5, 2, k - 1.0});
  }
  std::swap(soup.triangles[1][0], soup.triangles[1][1]);
  SceneSettings settings;
  settings.close_gaps_m = 0.05;
  const Scene scene = compiled(described(soup), settings);
  EXPECT_GT(scene.statistics().gap_joins.ambiguous_edges, 0u);
  ASSERT_EQ(scene.statistics().warnings.size(), 1u);
  EXPECT_NE(scene.statistics().warnings[0].find("stay open"), std::string::npos);
}

// A texture coordinate is linear on a square, also where an edge of it was divided.
TEST(SceneJoins, EdgesThatAreNotExaminedGiveAWarning) {
  Random random(4509);
  Soup soup;
  for (int i = 0; i < 1000; ++i) {
    const double in = 0.499e-3 * i;
    soup.add({in, 0, 0}, {1 - in, 0, 0}, {0.5, random.uniform(-1, 1), random.uniform(0.1, 1)});
  }
  SceneDescription description = described(soup);
  const Scene scene = compiled(std::move(description));
  const SceneStatistics& s = scene.statistics();
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_NE(s.warnings[0].find(" boundary edges stay open, because very many edges or vertices"),
            std::string::npos)
      << s.warnings[0];
}

TEST(SceneJoins, PiecesKeepMaterialsAndSources) {
  SceneDescription description = described(two_squares());
  MeshDescription& mesh = description.meshes[0];
  for (Vec3& p : mesh.positions) p.y() -= p.y() > 1.001 ? 0.002 : 0.0;
  // The upper square has its lower edge in two pieces.
  mesh.positions.push_back({0.4, std::nextafter(1.0f, 2.0f), 0});
  const auto middle = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  const Triangle upper = mesh.triangles[2];
  mesh.triangles[2] = {upper[0], middle, upper[2]};
  mesh.triangles.push_back({middle, upper[1], upper[2]});
  mesh.material_runs = {{0, 0}, {2, 1}};
  description.materials.resize(2);
  const Scene scene = compiled(description);
  const CleaningReport& report = scene.statistics().cleaning;
  EXPECT_EQ(report.divided_edges, 1u);
  EXPECT_EQ(report.added_triangles, 1u);
  EXPECT_EQ(report.boundary_edges, 6u);
  ASSERT_EQ(scene.mesh(0).face_count(), 6u);
  for (std::size_t f = 0; f < 6; ++f) {
    const auto source = scene.mesh(0).source_triangle(f);
    EXPECT_EQ(scene.material(0, f), source < 2 ? 0u : 1u) << "face " << f;
  }
}

}  // namespace
}  // namespace palpate
