// EXT_mesh_gpu_instancing.

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::add_floats;
using test::add_numbers;
using test::expect_invalid;
using test::expect_refused;
using test::GltfBuilder;
using test::read_glb;

const std::string kAttributes = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";

Json& instance_attributes_of(GltfBuilder& asset) {
  return asset.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
}

// The triangle at (1, 0, 0), with instances at z = 0, 10, 20.
GltfBuilder three_instances() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  asset.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  asset.json["nodes"][0]["name"] = "grass";
  asset.json["nodes"][0]["translation"] = {1, 0, 0};
  instance_attributes_of(asset)["TRANSLATION"] =
      add_floats(asset, {0, 0, 0, 0, 0, 10, 0, 0, 20}, "VEC3");
  return asset;
}

TEST(GltfInstancing, MakesANodeOfEveryInstance) {
  GltfBuilder asset = three_instances();
  asset.add_node({{"mesh", 0}});
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.tree.size(), 2u);
  ASSERT_EQ(scene.nodes.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene.nodes[i].name, "grass #" + std::to_string(i));
    EXPECT_EQ(scene.nodes[i].mesh, 0u);
    EXPECT_EQ(scene.nodes[i].tree_node, 0u);
    EXPECT_EQ(scene.nodes[i].linear_scene_mesh, Mat3::Identity());
    EXPECT_EQ(scene.nodes[i].translation_m, Vec3(1, 0, 10.0 * static_cast<double>(i)));
  }
  EXPECT_EQ(scene.nodes[3].name, "node 1");
  EXPECT_EQ(scene.nodes[3].tree_node, 1u);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.notes, (std::vector<std::string>{"instances: 3 of meshes"}));
}

TEST(GltfInstancing, MultipliesTranslationRotationAndScale) {
  test::Random random(21);
  using Affine = Eigen::Transform<long double, 3, Eigen::Affine>;
  constexpr std::size_t kCount = 30;
  GltfBuilder asset = three_instances();
  asset.json["nodes"][0]["scale"] = {2, -3, 4};
  std::vector<float> translations;
  std::vector<float> rotations;
  std::vector<float> scales;
  std::vector<Affine> expected;
  const Affine T_scene_node = Eigen::Translation<long double, 3>(1, 0, 0) *
                              Eigen::Scaling(Eigen::Matrix<long double, 3, 1>(2, -3, 4));
  for (std::size_t i = 0; i < kCount; ++i) {
    const Eigen::Vector3f t = random.in_box(10.0).cast<float>();
    const Eigen::Quaternionf q = random.rotation().cast<float>();
    const Eigen::Vector3f s = (random.in_box(1.0) + Vec3(3, 3, 3)).cast<float>();
    translations.insert(translations.end(), t.data(), t.data() + 3);
    rotations.insert(rotations.end(), q.coeffs().data(), q.coeffs().data() + 4);
    scales.insert(scales.end(), s.data(), s.data() + 3);
    expected.push_back(T_scene_node * Eigen::Translation<long double, 3>(t.cast<long double>()) *
                       q.cast<long double>().normalized() *
                       Eigen::Scaling(s.cast<long double>().eval()));
  }
  instance_attributes_of(asset) = {{"TRANSLATION", add_floats(asset, translations, "VEC3")},
                                   {"ROTATION", add_floats(asset, rotations, "VEC4")},
                                   {"SCALE", add_floats(asset, scales, "VEC3")}};
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.nodes.size(), kCount);
  // A few roundings of numbers up to 4 * 10 + 1.
  constexpr double kNoise = 32.0 * 41.0 * std::numeric_limits<double>::epsilon();
  for (std::size_t i = 0; i < kCount; ++i) {
    const Mat3 linear = expected[i].linear().cast<double>();
    const Vec3 translation = expected[i].translation().cast<double>();
    EXPECT_LE((scene.nodes[i].linear_scene_mesh - linear).norm(), kNoise);
    EXPECT_LE((scene.nodes[i].translation_m - translation).norm(), kNoise);
  }
}

template <typename T>
void check_rotations(int component_type) {
  const T one = std::numeric_limits<T>::max();
  const T minus_one = std::numeric_limits<T>::min();  // also represents -1
  GltfBuilder asset = three_instances();
  const std::vector<T> quaternions = {one, 0, 0, 0, 0, minus_one, 0, 0, 0, 0, 0, one};
  instance_attributes_of(asset)["ROTATION"] =
      add_numbers(asset, quaternions, component_type, "VEC4", true);
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.nodes[0].linear_scene_mesh, Mat3(Vec3(1, -1, -1).asDiagonal()));
  EXPECT_EQ(scene.nodes[1].linear_scene_mesh, Mat3(Vec3(-1, 1, -1).asDiagonal()));
  EXPECT_EQ(scene.nodes[2].linear_scene_mesh, Mat3::Identity());
  EXPECT_EQ(scene.nodes[1].translation_m, Vec3(1, 0, 10));
}

TEST(GltfInstancing, ReadsNormalisedRotations) {
  check_rotations<std::int8_t>(GltfBuilder::kByte);
  check_rotations<std::int16_t>(GltfBuilder::kShort);
}

TEST(GltfInstancing, LeavesOutFlatInstancesWithOneWarning) {
  GltfBuilder asset = three_instances();
  instance_attributes_of(asset)["SCALE"] = add_floats(asset, {1, 0, 1, 2, 2, 2, 0, 0, 0}, "VEC3");
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].name, "grass #1");
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("2 of its 3 instances"), std::string::npos);
}

TEST(GltfInstancing, ReadsNoMeshForNodesWithoutAnInstance) {
  GltfBuilder asset = three_instances();
  asset.json["nodes"][0]["scale"] = {1, 0, 1};
  const auto other = asset.add_positions({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}});
  asset.add_node({{"mesh", asset.add_mesh({{{"attributes", {{"POSITION", other}}}}})}});
  const SceneDescription scene = read_glb(asset);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3(2, 0, 0));
  EXPECT_EQ(scene.nodes.size(), 1u);
}

TEST(GltfInstancing, CutsLongNames) {
  GltfBuilder asset = three_instances();
  std::string name(31, 'x');
  name += "\xc3\xa4";  // two bytes; the second would be the 33rd
  asset.json["nodes"][0]["name"] = name;
  EXPECT_EQ(read_glb(asset).nodes.at(2).name, std::string(31, 'x') + "... #2");
}

TEST(GltfInstancing, RefusesBrokenInstances) {
  const auto expect_broken = [](const std::string& element, const auto& change) {
    GltfBuilder asset = three_instances();
    change(asset, instance_attributes_of(asset));
    expect_invalid(asset, element);
  };
  expect_broken(kAttributes, [](GltfBuilder&, Json& a) { a = "many"; });
  expect_broken(kAttributes, [](GltfBuilder&, Json& a) { a = Json::object(); });
  expect_broken("/nodes/0/extensions/EXT_mesh_gpu_instancing", [](GltfBuilder& asset, Json&) {
    asset.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = 3;
  });
  expect_broken(kAttributes + "/SCALE", [](GltfBuilder&, Json& a) { a["SCALE"] = 99; });
  expect_broken(kAttributes + "/SCALE", [](GltfBuilder& asset, Json& a) {
    a["SCALE"] = add_floats(asset, {1, 1, 1, 1, 1, 1}, "VEC3");
  });
  expect_broken("/accessors/2/type",
                [](GltfBuilder& asset, Json&) { asset.json["accessors"][2]["type"] = "VEC4"; });
  expect_broken("/accessors/3/componentType", [](GltfBuilder& asset, Json& a) {
    a["ROTATION"] = add_numbers(asset, std::vector<std::uint8_t>(12, 1), GltfBuilder::kUnsignedByte,
                                "VEC4", true);
  });
  expect_broken("/accessors/3/componentType", [](GltfBuilder& asset, Json& a) {
    a["SCALE"] =
        add_numbers(asset, std::vector<std::int16_t>(9, 1), GltfBuilder::kShort, "VEC3", true);
  });
  expect_broken(kAttributes + "/ROTATION", [](GltfBuilder& asset, Json& a) {
    a["ROTATION"] = add_floats(asset, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 2}, "VEC4");
  });
  expect_broken("/nodes/0", [](GltfBuilder& asset, Json& a) {
    asset.json["nodes"][0]["scale"] = {1e300, 1e300, 1e300};
    a["SCALE"] = add_floats(asset, std::vector<float>(9, 1e30f), "VEC3");
  });
}

TEST(GltfInstancing, RefusesInstancesOfASkinnedMesh) {
  GltfBuilder asset = three_instances();
  asset.json["nodes"][0]["skin"] = 0;
  asset.json["skins"] = {{{"joints", {0}}}};
  expect_refused(asset, ErrorCode::kUnsupported, "/nodes/0");
}

TEST(GltfInstancing, RejectsInstancesWithoutAMesh) {
  GltfBuilder asset = three_instances();
  const auto where = asset.add_view(test::bytes_of(std::vector<std::uint8_t>{2}));
  Json& accessor = asset.json["accessors"][2];
  accessor["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedByte}}},
      {"values", {{"bufferView", accessor["bufferView"]}}}};
  EXPECT_EQ(read_glb(asset).nodes.at(2).translation_m, Vec3(1, 0, 0));
  accessor.erase("bufferView");
  expect_refused(asset, ErrorCode::kUnsupported, kAttributes + "/TRANSLATION");
}

TEST(GltfInstancing, BoundsTheInstancesOfAllNodesBeforeAllocating) {
  GltfBuilder asset = three_instances();
  asset.json["accessors"][2]["count"] = kMaxGltfInstances + 1;
  expect_refused(asset, ErrorCode::kLimitExceeded, kAttributes + "/TRANSLATION");
  asset.json["accessors"][2]["count"] = kMaxGltfInstances;
  expect_invalid(asset, "/accessors/2");  // within the limit, but more than the data
  asset = three_instances();
  Json second = asset.json["nodes"][0];
  second["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 3;
  asset.json["accessors"].push_back(asset.json["accessors"][2]);
  asset.json["accessors"][3]["count"] = kMaxGltfInstances - 2;
  asset.add_node(second);
  expect_refused(asset, ErrorCode::kLimitExceeded,
                 "/nodes/1/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION");
}

}  // namespace
}  // namespace palpate
