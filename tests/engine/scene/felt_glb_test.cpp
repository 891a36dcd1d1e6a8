// The GLB of a compiled scene, read back by the project's own loader.

#include "engine/scene/felt_glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/scene/scene.h"
#include "haptics/haptic_loop.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

struct Shape {
  std::vector<Vec3> corners_m;
  std::vector<Triangle> triangles;
};

Shape shape_of(const Scene& scene) {
  Shape shape;
  scene.append_triangles_scene(shape.corners_m, shape.triangles);
  return shape;
}

Scene read_back(const FeltGlb& felt) {
  const TemporaryFolder folder;
  auto scene = Scene::load(folder.write("felt.glb", felt.bytes));
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return std::move(*scene);
}

// A corner is rounded to float in the frame of its body: by at most 2^-24 of each coordinate, which
// is at most the body's reach. The poses add roundings of doubles.
double rounding_m(const Scene& scene) {
  double reach_m = 0.0;
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    for (const Vec3& p : scene.mesh(scene.objects()[i].mesh).welded_positions()) {
      reach_m = std::max(reach_m, scene.deformation(i)(p).norm());
    }
  }
  double far_m = 0.0;
  for (const Vec3& p : shape_of(scene).corners_m) far_m = std::max(far_m, p.norm());
  return std::sqrt(3.0) * 0x1p-24 * reach_m + 0x1p-46 * far_m;
}

// Each triangle is there, in the same place, with the same side in front.
void expect_same_shape(const Scene& compiled) {
  const auto felt = encode_felt_scene(compiled);
  ASSERT_TRUE(felt) << felt.error().to_string();
  const Scene back = read_back(*felt);
  ASSERT_EQ(back.objects().size(), compiled.objects().size());
  const Shape expected = shape_of(compiled);
  const Shape actual = shape_of(back);
  ASSERT_EQ(actual.triangles.size(), expected.triangles.size());
  EXPECT_EQ(felt->triangles, expected.triangles.size());
  EXPECT_EQ(felt->shown_triangles, expected.triangles.size());
  const double tolerance_m = 2 * rounding_m(compiled);
  for (std::size_t t = 0; t < expected.triangles.size(); ++t) {
    const auto corner = [](const Shape& shape, const Triangle& triangle, std::size_t k) {
      return shape.corners_m[triangle[k]];
    };
    // The loader may begin a triangle with another corner, but runs round it in the same sense.
    double best_m = 1e9;
    for (std::size_t first = 0; first < 3; ++first) {
      double worst_m = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        worst_m = std::max(worst_m, (corner(actual, actual.triangles[t], (first + k) % 3) -
                                     corner(expected, expected.triangles[t], k))
                                        .norm());
      }
      best_m = std::min(best_m, worst_m);
    }
    ASSERT_LE(best_m, tolerance_m) << "triangle " << t;
  }
}

TEST(FeltGlb, OfEveryModelIsTheCompiledScene) {
  int models = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PALPATE_MODELS_DIR)) {
    if (entry.path().extension() != ".glb") continue;
    SCOPED_TRACE(entry.path().filename().string());
    const auto scene = Scene::load(entry.path().string());
    ASSERT_TRUE(scene) << scene.error().to_string();
    if (scene->objects().empty()) continue;
    expect_same_shape(*scene);
    ++models;
  }
  EXPECT_GT(models, 10);
}

// A tetrahedron, front sides out, with float corners as in a file.
MeshDescription bent_tetrahedron(Random& random) {
  MeshDescription mesh{"solid", {}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    const Vec3 corner = p + random.in_box(0.2);
    mesh.positions.push_back(corner.cast<float>().cast<double>());
  }
  return mesh;
}

TEST(FeltGlb, KeepsMirroredStretchedAndFarBodies) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    SceneDescription description;
    description.path = "made.glb";
    description.meshes = {bent_tetrahedron(random), bent_tetrahedron(random)};
    for (int i = 0; i < 4; ++i) {
      NodeDescription node;
      node.name = "node " + std::to_string(i);
      node.mesh = static_cast<std::uint32_t>(i % 2);
      const Vec3 scales(i % 2 == 0 ? -1.0 : 1.0, random.uniform(0.5, 2.0),
                        random.uniform(0.5, 2.0));
      node.linear_scene_mesh = random.rotation().toRotationMatrix() * scales.asDiagonal() *
                               random.rotation().toRotationMatrix();
      node.translation_m = 5.0 * i * random.unit_vector();
      node.tree_node = static_cast<std::uint32_t>(i);
      description.nodes.push_back(node);
    }
    description.tree.resize(4);
    const auto scene = Scene::compile(std::move(description), {.scale = 0.25});
    ASSERT_TRUE(scene) << scene.error().to_string();
    expect_same_shape(*scene);
  }
}

nlohmann::json json_of(const std::string& glb) {
  std::uint32_t length;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  return nlohmann::json::parse(glb.substr(20, length));
}

// The page moves a body by replacing its node's matrix.
TEST(FeltGlb, NamesEachBodyAndItsPlace) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/gallery.glb");
  ASSERT_TRUE(scene);
  const auto felt = encode_felt_scene(*scene);
  ASSERT_TRUE(felt);
  const nlohmann::json json = json_of(felt->bytes);
  const ActuationModel motors = *ActuationModel::from_counts(3, 3);
  const auto loop = test::made(HapticLoop::create(scene->world(), motors, {}));
  ASSERT_EQ(json["nodes"].size(), scene->objects().size());
  for (std::size_t body = 0; body < scene->objects().size(); ++body) {
    const nlohmann::json& node = json["nodes"][body];
    EXPECT_EQ(node["extras"]["body"], body);
    EXPECT_EQ(node["name"], scene->objects()[body].name);
    const RigidTransform T = loop.T_scene_body(static_cast<std::uint32_t>(body));
    const Mat3 R = T.rotation.toRotationMatrix();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        EXPECT_EQ(node["matrix"][static_cast<std::size_t>(4 * column + row)], R(row, column));
      }
      // The loop's frame is shifted by the middle of the scene and back.
      EXPECT_NEAR(node["matrix"][static_cast<std::size_t>(12 + row)], T.translation_m[row],
                  0x1p-50);
    }
  }
}

TEST(FeltGlb, LargeSceneIsSimplifiedToAboutTheWantedNumber) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/sphere.glb");
  ASSERT_TRUE(scene);
  const auto whole = encode_felt_scene(*scene);
  ASSERT_TRUE(whole);
  ASSERT_GT(whole->triangles, 1000u);
  const std::size_t most = whole->triangles / 4;
  const auto felt = encode_felt_scene(*scene, most);
  ASSERT_TRUE(felt);
  EXPECT_EQ(felt->triangles, whole->triangles);
  EXPECT_LE(felt->shown_triangles, most);
  EXPECT_GE(felt->shown_triangles, most * 9 / 10);
  EXPECT_LT(felt->bytes.size(), whole->bytes.size() / 3);
  // meshoptimizer keeps corners, so every corner is one of the sphere's.
  const Scene back = read_back(*felt);
  const Vec3 middle =
      0.5 * (scene->statistics().bounds_scene.low + scene->statistics().bounds_scene.high);
  const double radius_m = 0.5 * scene->statistics().extent_m.maxCoeff();
  for (const Vec3& p : shape_of(back).corners_m) {
    EXPECT_NEAR((p - middle).norm(), radius_m, 4 * 0x1p-23 * radius_m);
  }
  EXPECT_EQ(encode_felt_scene(*scene, whole->triangles)->bytes, whole->bytes);
}

}  // namespace
}  // namespace palpate::test
