// Scenes and their nodes: the hierarchy and its transforms.

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/io/gltf/reader_checks.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::expect_file_invalid;
using test::expect_file_refused;
using test::GltfBuilder;
using test::read_glb;
using test::TemporaryFolder;

// ---- what is read ------------------------------------------------------------------------------

// Three roots 0, 1, 2; scenes {1} and {2}.
GltfBuilder three_roots() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.add_child({{"mesh", 0}});
  asset.add_child({{"mesh", 0}});
  asset.json["scenes"] = {{{"nodes", {1}}}, {{"nodes", {2}}}};
  return asset;
}

TEST(GltfReader, ReadsTheDefaultSceneElseTheFirstElseAllRoots) {
  GltfBuilder asset = three_roots();
  EXPECT_EQ(read_glb(asset).nodes.at(0).name, "node 1");
  asset.json["scene"] = 1;
  EXPECT_EQ(read_glb(asset).nodes.at(0).name, "node 2");
  asset.json.erase("scene");
  asset.json.erase("scenes");
  EXPECT_EQ(read_glb(asset).nodes.size(), 3u);
}

TEST(GltfReader, WalksDepthFirstInFileOrder) {
  GltfBuilder asset = GltfBuilder::one_triangle();  // node 0
  for (int i = 1; i < 6; ++i) asset.add_child({{"mesh", 0}});
  asset.json["scenes"][0]["nodes"] = {5, 0};
  asset.json["nodes"][5]["children"] = {3, 1};
  asset.json["nodes"][3]["children"] = {4};
  asset.json["nodes"][0]["children"] = {2};
  std::string order;
  const auto scene = read_glb(asset);
  for (const NodeDescription& node : scene.nodes) order += node.name.back();
  EXPECT_EQ(order, "534102");
  EXPECT_EQ(scene.tree.size(), 6u);
}

TEST(GltfReader, MultipliesTheTransformsOfTheAncestors) {
  test::Random random(4);
  for (int round = 0; round < 50; ++round) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["nodes"] = Json::array();
    Eigen::Affine3d expected = Eigen::Affine3d::Identity();
    const std::size_t length = 1 + random.index(6);
    for (std::size_t i = 0; i < length; ++i) {
      const Quat q = random.rotation();
      const Vec3 t = random.in_box(5.0);
      const Vec3 s(random.uniform(0.5, 2.0), -random.uniform(0.5, 2.0), random.uniform(0.5, 2.0));
      const Eigen::Affine3d local =
          Eigen::Translation3d(t) * Eigen::Quaterniond(q.coeffs()) * Eigen::Scaling(s);
      Json node;
      if (random.index(2) == 0) {
        const Eigen::Matrix4d m = local.matrix();
        node["matrix"] = std::vector<double>(m.data(), m.data() + 16);
      } else {
        node = {{"translation", {t.x(), t.y(), t.z()}},
                {"rotation", {q.x(), q.y(), q.z(), q.w()}},
                {"scale", {s.x(), s.y(), s.z()}}};
      }
      if (i + 1 < length) node["children"] = {i + 1};
      if (i + 1 == length) node["mesh"] = 0;
      asset.add_child(node);
      expected = expected * local;
    }
    const auto scene = read_glb(asset);
    ASSERT_EQ(scene.nodes.size(), 1u);
    EXPECT_EQ(scene.tree.size(), length);
    // Each factor is rounded a few times, by half an ulp of the running magnitude.
    const double noise =
        64.0 * static_cast<double>(length) * std::numeric_limits<double>::epsilon();
    EXPECT_LE((scene.nodes[0].linear_scene_mesh - expected.linear()).norm(),
              noise * std::pow(2.0, static_cast<double>(length)));
    EXPECT_LE((scene.nodes[0].translation_m - expected.translation()).norm(),
              noise * 10.0 * std::pow(2.0, static_cast<double>(length)));
  }
}

TEST(GltfReader, KeepsIdentityScaleAndQuarterTurnsExact) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto linear_with = [&](const Json& node) {
    asset.json["nodes"][0] = node;
    asset.json["nodes"][0]["mesh"] = 0;
    return read_glb(asset).nodes.at(0).linear_scene_mesh;
  };
  EXPECT_EQ(linear_with(Json::object()), Mat3::Identity());
  EXPECT_EQ(linear_with({{"rotation", {0, 0, 0, 1}}}), Mat3::Identity());
  const Mat3 scale = Vec3(0.1, -3.7, 1e-7).asDiagonal();
  EXPECT_EQ(linear_with({{"scale", {0.1, -3.7, 1e-7}}}), scale);
  EXPECT_EQ(linear_with({{"scale", {0.1, -3.7, 1e-7}}, {"rotation", {0, 0, 0, -1}}}), scale);
  EXPECT_EQ(linear_with({{"matrix", {0.1, 0, 0, 0, 0, -3.7, 0, 0, 0, 0, 1e-7, 0, 5, 6, 7, 1}}}),
            scale);
  Mat3 turn;
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_EQ(linear_with({{"rotation", {0, 0, 0.7071068f, 0.7071068f}}}), turn);
}

TEST(GltfReader, KeepsExactScaleBelowAnIdentityParent) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0] = {{"children", {1}}, {"translation", {0.1, 0.2, 0.3}}};
  asset.add_child({{"mesh", 0}, {"scale", {0.1, 0.7, 1.3}}});
  const auto node = read_glb(asset).nodes.at(0);
  EXPECT_EQ(node.linear_scene_mesh, Mat3(Vec3(0.1, 0.7, 1.3).asDiagonal()));
  EXPECT_EQ(node.translation_m, Vec3(0.1, 0.2, 0.3));
}

TEST(GltfReader, DividesOutTheLengthOfARoundedQuaternion) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["rotation"] = {0.183, 0.365, 0.548, 0.730};  // length 0.99996
  const Mat3 linear = read_glb(asset).nodes.at(0).linear_scene_mesh;
  EXPECT_LE((linear * linear.transpose() - Mat3::Identity()).norm(),
            16.0 * std::numeric_limits<double>::epsilon());
}

TEST(GltfReader, LeavesOutNodesWithScaleZero) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.add_node({{"mesh", 0}, {"scale", {0, 0, 0}}});
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.nodes.size(), 1u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("/nodes/1"), std::string::npos);
}

TEST(GltfReader, ReadsASceneThatStartsAtAChildWithAWarning) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.add_child({{"children", {0}}, {"translation", {9, 9, 9}}});
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.nodes.at(0).translation_m, Vec3::Zero());
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("/scenes/0/nodes/0"), std::string::npos);
}

// ---- what is refused ---------------------------------------------------------------------------

TEST(GltfReader, RefusesBrokenTransforms) {
  const auto refuse = [](const Json& node, const std::string& element) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["nodes"][0].update(node);
    expect_file_invalid(asset, element);
  };
  refuse({{"matrix", {1, 0, 0, 0}}}, "/nodes/0/matrix");
  refuse({{"matrix", Json::array()}}, "/nodes/0/matrix");
  refuse({{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2}}}, "/nodes/0/matrix");
  refuse({{"matrix", {1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}, "/nodes/0/matrix");
  refuse({{"translation", {1, 2}}}, "/nodes/0/translation");
  refuse({{"translation", {1, "2", 3}}}, "/nodes/0/translation/1");
  refuse({{"translation", {1, nullptr, 3}}}, "/nodes/0/translation/1");
  refuse({{"scale", {1, 2, 3, 4}}}, "/nodes/0/scale");
  refuse({{"rotation", {0, 0, 0}}}, "/nodes/0/rotation");
  refuse({{"rotation", {0, 0, 0, 0}}}, "/nodes/0/rotation");
  refuse({{"rotation", {0, 0, 0, 1.01}}}, "/nodes/0/rotation");
  refuse({{"rotation", {1e200, 0, 0, 0}}}, "/nodes/0/rotation");
  refuse({{"scale", {1, 1, 1}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}},
         "/nodes/0");
}

TEST(GltfReader, RefusesOverflowingTransformsAndLeavesOutFlatteningOnes) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0] = {{"children", {1}}, {"scale", {1e200, 1, 1}}};
  asset.add_child({{"mesh", 0}, {"scale", {1e200, 1, 1}}});
  expect_file_invalid(asset, "/nodes/1", "overflows");
  asset.json["nodes"][0]["scale"] = {1, 0, 1};
  asset.json["nodes"][1] = {{"mesh", 0}, {"rotation", {0.36, 0.48, 0.64, 0.48}}};
  expect_file_refused(asset, ErrorCode::kEmptyScene, "", "flattens");
  asset.json["nodes"][0]["scale"] = {1e-12, 1e12, 1};  // extreme, but not flat
  EXPECT_EQ(read_glb(asset).nodes.size(), 1u);
}

TEST(GltfReader, RefusesCyclesAndSecondParents) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["children"] = {0};
  expect_file_invalid(asset, "/nodes/0");
  asset.json["nodes"][0]["children"] = {1};
  asset.add_child({{"children", {0}}});
  expect_file_invalid(asset, "/nodes/0");
  asset.json["nodes"][1]["children"] = {2};
  asset.add_child({{"children", {1}}});
  expect_file_invalid(asset, "/nodes/2/children/0", "one parent");
  asset.json["nodes"][2] = Json::object();
  EXPECT_EQ(read_glb(asset).tree.size(), 3u);
  asset.json["nodes"][0]["children"] = {1, 1};
  expect_file_invalid(asset, "/nodes/0/children/1", "one parent");
  asset.json["nodes"][0]["children"] = {1};
  asset.json["scenes"][0]["nodes"] = {0, 0};
  expect_file_invalid(asset, "/nodes/0", "twice");
  asset.json["scenes"][0]["nodes"] = {0, 1};
  expect_file_invalid(asset, "/nodes/1", "twice");
}

TEST(GltfReader, RefusesAGraphWithExponentiallyManyPaths) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  for (std::size_t i = 1; i <= 60; ++i) {
    asset.json["nodes"][i - 1]["children"] = {i, i};
    asset.add_child(Json::object());
  }
  expect_file_invalid(asset, "/nodes/0/children/1", "one parent");
}

TEST(GltfReader, BoundsTheDepthOfTheHierarchy) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"] = Json::array();
  for (std::size_t i = 0; i < kMaxGltfNodeDepth; ++i) {
    asset.json["nodes"].push_back(i + 1 < kMaxGltfNodeDepth ? Json{{"children", {i + 1}}}
                                                            : Json{{"mesh", 0}});
  }
  EXPECT_EQ(read_glb(asset).tree.size(), kMaxGltfNodeDepth);
  asset.json["nodes"].back() = {{"children", {kMaxGltfNodeDepth}}};
  asset.add_child({{"mesh", 0}});
  expect_file_refused(asset, ErrorCode::kLimitExceeded,
                      "/nodes/" + std::to_string(kMaxGltfNodeDepth), "deeper");
}

TEST(GltfReader, BoundsTheNumberOfNodes) {
  const TemporaryFolder folder;
  std::string text = R"({"asset":{"version":"2.0"},"nodes":[{})";
  for (std::size_t i = 0; i < kMaxGltfNodes; ++i) text += ",{}";
  expect_file_refused(GltfBuilder::write_text(folder, text + "]}"), ErrorCode::kLimitExceeded,
                      "/nodes");
}

}  // namespace
}  // namespace palpate
