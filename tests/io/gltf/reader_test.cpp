#include "io/gltf/reader.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <sys/stat.h>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "io/gltf/primitives.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::GltfBuilder;
using test::read_glb;
using test::TemporaryFolder;

SceneDescription read_or_fail(const std::string& path) {
  auto scene = read_gltf(path);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return scene.ok() ? std::move(*scene) : SceneDescription{};
}

// The file must be refused with this code and an error that names the element, the file and,
// somewhere, the text.
void expect_file_refused(const std::string& path, ErrorCode code, const std::string& element,
                         const std::string& text = {}) {
  const auto scene = read_gltf(path);
  ASSERT_FALSE(scene.ok()) << "accepted; expected an error at " << element;
  const Error& error = scene.error();
  EXPECT_EQ(static_cast<int>(error.code), static_cast<int>(code)) << error.to_string();
  EXPECT_EQ(error.element, element) << error.to_string();
  EXPECT_EQ(error.path, path);
  EXPECT_FALSE(error.problem.empty());
  EXPECT_NE(error.to_string().find(text), std::string::npos)
      << error.to_string() << "\nexpected: " << text;
}

void expect_file_refused(const GltfBuilder& asset, ErrorCode code, const std::string& element,
                         const std::string& text = {}) {
  const TemporaryFolder folder;
  expect_file_refused(asset.write_glb(folder), code, element, text);
}

void expect_file_invalid(const GltfBuilder& asset, const std::string& element,
                         const std::string& text = {}) {
  expect_file_refused(asset, ErrorCode::kInvalidContent, element, text);
}

std::vector<Eigen::Vector3f> random_points(test::Random& random, std::size_t count) {
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(random.in_box(10.0).cast<float>());
  return points;
}

Json primitive_of(std::size_t positions, std::size_t indices, int mode = 4) {
  return {{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", mode}};
}

// A scene of one node and one mesh of one primitive.
GltfBuilder asset_of(const std::vector<Eigen::Vector3f>& points,
                     const std::vector<std::uint32_t>& indices,
                     int component_type = GltfBuilder::kUnsignedShort, int mode = 4) {
  GltfBuilder asset;
  const auto positions = asset.add_positions(points);
  const auto index_accessor = asset.add_indices(indices, component_type);
  asset.add_node(
      {{"mesh", asset.add_mesh(Json::array({primitive_of(positions, index_accessor, mode)}))}});
  return asset;
}

void expect_same_geometry(const SceneDescription& a, const SceneDescription& b) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    EXPECT_EQ(a.meshes[i].name, b.meshes[i].name);
    EXPECT_EQ(a.meshes[i].positions, b.meshes[i].positions);
    EXPECT_EQ(a.meshes[i].triangles, b.meshes[i].triangles);
  }
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].name, b.nodes[i].name);
    EXPECT_EQ(a.nodes[i].mesh, b.nodes[i].mesh);
    EXPECT_EQ(a.nodes[i].linear_scene_mesh, b.nodes[i].linear_scene_mesh);
    EXPECT_EQ(a.nodes[i].translation_m, b.nodes[i].translation_m);
  }
}

// --- Content -------------------------------------------------------------------------------------

TEST(GltfReader, ReadsPositionsAndTrianglesBitForBit) {
  test::Random random(1);
  const auto points = random_points(random, 50);
  std::vector<std::uint32_t> indices;
  for (int i = 0; i < 90; ++i) {
    indices.push_back(static_cast<std::uint32_t>(random.index(points.size())));
  }
  for (const int type :
       {GltfBuilder::kUnsignedByte, GltfBuilder::kUnsignedShort, GltfBuilder::kUnsignedInt}) {
    const SceneDescription scene = read_glb(asset_of(points, indices, type));
    ASSERT_EQ(scene.meshes.size(), 1u);
    const MeshDescription& mesh = scene.meshes[0];
    ASSERT_EQ(mesh.positions.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(mesh.positions[i], points[i].cast<double>());
    }
    ASSERT_EQ(mesh.triangles.size(), 30u);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      EXPECT_EQ(mesh.triangles[i / 3][i % 3], indices[i]);
    }
    EXPECT_EQ(scene.tree.size(), 1u);
    EXPECT_EQ(scene.nodes[0].name, "node 0");
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_GT(scene.parse_ms, 0.0);
  }
}

TEST(GltfReader, ReadsUnindexedTriangles) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["meshes"][0]["primitives"][0].erase("indices");
  const SceneDescription scene = read_glb(asset);
  EXPECT_EQ(scene.meshes[0].triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(GltfReader, ReadsTheSameFromGlbFileAndDataUri) {
  test::Random random(2);
  const GltfBuilder asset = asset_of(random_points(random, 7), {0, 1, 2, 3, 4, 5, 6, 0, 3});
  const TemporaryFolder folder;
  const SceneDescription glb = read_or_fail(asset.write_glb(folder));
  expect_same_geometry(glb, read_or_fail(asset.write_gltf(folder)));
  expect_same_geometry(glb, read_or_fail(asset.write_data_uri(folder)));
  expect_same_geometry(glb, read_or_fail(asset.write_data_uri(folder, "text/x-anything")));
  expect_same_geometry(glb, read_or_fail(asset.write_data_uri(folder, "")));
}

TEST(GltfReader, RecognisesTheContainerByContentNotByName) {
  const TemporaryFolder folder;
  const std::string glb = GltfBuilder::one_triangle().write_glb(folder);
  std::filesystem::rename(glb, folder.path("wrong.gltf"));
  EXPECT_EQ(read_or_fail(folder.path("wrong.gltf")).meshes.size(), 1u);
}

TEST(GltfReader, ReadsStripsAndFansAsTheEquivalentList) {
  test::Random random(3);
  const auto points = random_points(random, 9);
  const std::vector<std::uint32_t> order = {4, 0, 7, 1, 8, 2};
  // The specification lists these: every second triangle of a strip is reversed.
  const std::vector<std::uint32_t> strip = {4, 0, 7, 0, 1, 7, 7, 1, 8, 1, 2, 8};
  const std::vector<std::uint32_t> fan = {0, 7, 4, 7, 1, 4, 1, 8, 4, 8, 2, 4};
  constexpr int kType = GltfBuilder::kUnsignedByte;
  expect_same_geometry(read_glb(asset_of(points, order, kType, 5)),
                       read_glb(asset_of(points, strip, kType, 4)));
  expect_same_geometry(read_glb(asset_of(points, order, kType, 6)),
                       read_glb(asset_of(points, fan, kType, 4)));
}

TEST(GltfReader, KeepsTheOrientationAlongAStrip) {
  // A flat zigzag: every triangle must face +z like the first.
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < 20; ++i) {
    points.emplace_back(static_cast<float>(i), static_cast<float>(i % 2), 0.0f);
    indices.push_back(i);
  }
  const auto scene = read_glb(asset_of(points, indices, GltfBuilder::kUnsignedShort, 5));
  const MeshDescription& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.triangles.size(), 18u);
  for (const Triangle& t : mesh.triangles) {
    const Vec3 normal = (mesh.positions[t[1]] - mesh.positions[t[0]])
                            .cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
    EXPECT_LT(normal.z(), 0.0);
  }
}

TEST(GltfReader, ReadsInterleavedPositionsByStride) {
  GltfBuilder asset;
  std::vector<float> interleaved;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 5; ++k) interleaved.push_back(static_cast<float>(10 * i + k));
  }
  const auto view = asset.add_view(test::bytes_of(interleaved), 20);
  const auto positions = asset.add_accessor(view, GltfBuilder::kFloat, 3, "VEC3");
  asset.json["accessors"][positions]["byteOffset"] = 8;  // the last element ends with the view
  const auto indices = asset.add_indices({0, 1, 2});
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive_of(positions, indices)}))}});
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.meshes[0].positions, (std::vector<Vec3>{{2, 3, 4}, {12, 13, 14}, {22, 23, 24}}));
}

TEST(GltfReader, AppliesSparsePositionsWithAndWithoutBaseView) {
  for (const bool with_base : {true, false}) {
    GltfBuilder asset = asset_of({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {1, 1, 1}}, {0, 1, 2, 0, 1, 3});
    const auto indices = asset.add_view(test::bytes_of(std::vector<std::uint16_t>{1, 3}));
    const auto values = asset.add_view(test::bytes_of(std::vector<float>{10, 20, 30, 40, 50, 60}));
    Json& accessor = asset.json["accessors"][0];
    accessor["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", indices}, {"componentType", GltfBuilder::kUnsignedShort}}},
        {"values", {{"bufferView", values}}}};
    if (!with_base) accessor.erase("bufferView");
    const Vec3 first = with_base ? Vec3(1, 2, 3) : Vec3(0, 0, 0);
    const Vec3 third = with_base ? Vec3(7, 8, 9) : Vec3(0, 0, 0);
    EXPECT_EQ(read_glb(asset).meshes[0].positions,
              (std::vector<Vec3>{first, {10, 20, 30}, third, {40, 50, 60}}));
  }
}

TEST(GltfReader, AppliesSparseIndicesWithoutBaseView) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto where = asset.add_view(test::bytes_of(std::vector<std::uint8_t>{1, 2}));
  const auto values = asset.add_view(test::bytes_of(std::vector<std::uint16_t>{2, 1}));
  Json& accessor = asset.json["accessors"][1];
  accessor.erase("bufferView");
  accessor["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedByte}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_EQ(read_glb(asset).meshes[0].triangles, (std::vector<Triangle>{{0, 2, 1}}));
}

template <typename T>
void check_quantized(int component_type, bool normalized, double largest) {
  constexpr T kMin = std::numeric_limits<T>::min();
  constexpr T kMax = std::numeric_limits<T>::max();
  const std::vector<T> stored = {kMin, kMax, 0, 1, 7, kMax, 3, kMin, 9};
  GltfBuilder asset;
  std::string bytes;
  for (std::size_t i = 0; i < 3; ++i) {  // elements of 3 components, padded to 4 bytes
    std::string element =
        test::bytes_of(std::vector<T>(stored.begin() + 3 * static_cast<std::ptrdiff_t>(i),
                                      stored.begin() + 3 * static_cast<std::ptrdiff_t>(i) + 3));
    element.resize(sizeof(T) == 1 ? 4 : 8);
    bytes += element;
  }
  const auto view = asset.add_view(bytes, sizeof(T) == 1 ? 4 : 8);
  const auto positions = asset.add_accessor(view, component_type, 3, "VEC3");
  asset.json["accessors"][positions]["normalized"] = normalized;
  const auto indices = asset.add_indices({0, 1, 2});
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive_of(positions, indices)}))}});
  expect_file_invalid(asset, "/accessors/0/componentType", "KHR_mesh_quantization");
  asset.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  asset.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const auto scene = read_glb(asset);
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const double value = normalized ? std::max(stored[i] / largest, -1.0) : stored[i];
    EXPECT_EQ(scene.meshes[0].positions[i / 3][static_cast<int>(i % 3)], value);
  }
}

TEST(GltfReader, ReadsQuantizedPositionsWhenTheExtensionIsListed) {
  for (const bool normalized : {false, true}) {
    check_quantized<std::int8_t>(GltfBuilder::kByte, normalized, 127.0);
    check_quantized<std::uint8_t>(GltfBuilder::kUnsignedByte, normalized, 255.0);
    check_quantized<std::int16_t>(GltfBuilder::kShort, normalized, 32767.0);
    check_quantized<std::uint16_t>(GltfBuilder::kUnsignedShort, normalized, 65535.0);
  }
}

TEST(GltfReader, AppendsPrimitivesAndSharesTheirPositions) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto other = asset.add_positions({{5, 5, 5}, {6, 5, 5}, {5, 6, 5}});
  const auto turned = asset.add_indices({2, 1, 0});
  Json& primitives = asset.json["meshes"][0]["primitives"];
  primitives.push_back(primitive_of(other, turned));
  primitives.push_back(primitive_of(0, turned));  // the accessor of the first one
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.meshes[0].positions.size(), 6u);
  EXPECT_EQ(scene.meshes[0].triangles, (std::vector<Triangle>{{0, 1, 2}, {5, 4, 3}, {2, 1, 0}}));
}

TEST(GltfReader, ListsASharedMeshOnce) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.add_node({{"mesh", 0}, {"name", "copy"}, {"translation", {1, 2, 3}}});
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.nodes.size(), 2u);
  EXPECT_EQ(scene.nodes[1].mesh, scene.nodes[0].mesh);
  EXPECT_EQ(scene.nodes[1].name, "copy");
  EXPECT_EQ(scene.nodes[1].translation_m, Vec3(1, 2, 3));
}

// --- Scenes and nodes ----------------------------------------------------------------------------

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

// --- What is skipped -----------------------------------------------------------------------------

TEST(GltfReader, WarnsAboutPointsAndLines) {
  for (int mode = 0; mode < 4; ++mode) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["meshes"][0]["primitives"].push_back(primitive_of(0, 1, mode));
    const auto scene = read_glb(asset);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("/meshes/0/primitives/1"), std::string::npos);
  }
}

TEST(GltfReader, LeavesOutNodesWhoseMeshHasNoTriangle) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto points = asset.add_mesh(Json::array({primitive_of(0, 1, 0)}));
  asset.json["nodes"][0]["mesh"] = points;
  asset.add_node({{"mesh", 0}});
  asset.add_node({{"mesh", points}});
  const auto scene = read_glb(asset);
  ASSERT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].name, "node 1");
  EXPECT_EQ(scene.nodes[0].mesh, 0u);
  EXPECT_EQ(scene.tree.size(), 3u);
  EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(GltfReader, WarnsAboutUnknownExtensionsOnly) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["extensionsUsed"] = {"KHR_materials_unlit", "VENDOR_secret",
                                  "KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing"};
  asset.json["extensionsRequired"] = {"KHR_materials_unlit",   "KHR_lights_punctual",
                                      "KHR_texture_transform", "KHR_texture_basisu",
                                      "EXT_texture_webp",      "KHR_materials_volume"};
  const auto scene = read_glb(asset);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("VENDOR_secret"), std::string::npos);
}

TEST(GltfReader, AcceptsRequiredExtensionsThatDoNotAffectTriangles) {
  for (const char* name : {"KHR_materials_variants",
                           "KHR_materials_pbrSpecularGlossiness",
                           "KHR_texture_basisu",
                           "EXT_texture_webp",
                           "EXT_texture_avif",
                           "MSFT_texture_dds",
                           "MSFT_lod",
                           "MSFT_packing_occlusionRoughnessMetallic",
                           "KHR_lights_punctual",
                           "KHR_implicit_shapes",
                           "KHR_physics_rigid_bodies",
                           "KHR_collision_shapes",
                           "OMI_physics_body",
                           "AGI_articulations",
                           "CESIUM_primitive_outline",
                           "MPEG_haptic_material",
                           "MPEG_material_haptic",
                           "EXT_mesh_primitive_restart",
                           "KHR_techniques_webgl",
                           "VRM"}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["extensionsUsed"] = {name};
    asset.json["extensionsRequired"] = {name};
    EXPECT_TRUE(read_glb(asset).warnings.empty()) << name;
  }
}

TEST(GltfReader, WarnsOfExtensionsThatAffectTrianglesAndRefusesRequiredOnes) {
  for (const char* name : {"KHR_gaussian_splatting", "KHR_displacement_mapping_shared",
                           "MAXAR_mesh_variants", "CESIUM_RTC", "EXT_primitive_voxels",
                           "MPEG_accessor_timed", "KHR_materials_of_tomorrow", "KHR_materials_"}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["extensionsUsed"] = {name};
    const auto scene = read_glb(asset);
    ASSERT_EQ(scene.warnings.size(), 1u) << name;
    EXPECT_NE(scene.warnings[0].find(name), std::string::npos) << scene.warnings[0];
    asset.json["extensionsRequired"] = {name};
    expect_file_refused(asset, ErrorCode::kUnsupported, "/extensionsRequired/0", name);
  }
}

TEST(GltfReader, IgnoresBrokenCamerasLightsAnimationsImagesAndMaterials) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["cameras"] = {{{"type", "telescope"}}, 7};
  asset.json["animations"] = {{{"channels", "none"}}};
  asset.json["images"] = {{{"bufferView", 4000}}, {{"uri", "/dev/zero"}}, {{"uri", "../../x"}}};
  asset.json["textures"] = {{{"source", -3}}};
  asset.json["materials"] = "steel";
  asset.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", 5}}};
  asset.json["nodes"][0]["camera"] = 99;
  EXPECT_EQ(read_glb(asset).meshes.size(), 1u);
}

TEST(GltfReader, DoesNotOpenBuffersThatNoTriangleNeeds) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["buffers"] = {{{"byteLength", asset.bin.size()}},
                           {{"byteLength", 8}, {"uri", "not_there.bin"}},
                           {{"byteLength", 8}, {"uri", "../../etc/passwd"}}};
  EXPECT_EQ(read_glb(asset).meshes.size(), 1u);
}

TEST(GltfReader, CountsTheWarningsItDoesNotList) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  for (std::size_t i = 0; i < kMaxGltfWarnings + 20; ++i) {
    asset.json["meshes"][0]["primitives"].push_back(primitive_of(0, 1, 0));
  }
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.warnings.size(), kMaxGltfWarnings + 1);
  EXPECT_NE(scene.warnings.back().find("20 further"), std::string::npos);
}

TEST(GltfReader, RefusesASceneWithoutTriangles) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["meshes"][0]["primitives"][0]["mode"] = 1;
  expect_file_refused(asset, ErrorCode::kEmptyScene, "", "lines");
  expect_file_refused(GltfBuilder(), ErrorCode::kEmptyScene, "");
}

// --- Files and containers ------------------------------------------------------------------------

TEST(GltfReader, RefusesPathsThatAreNotRegularFiles) {
  const TemporaryFolder folder;
  expect_file_refused(folder.path("missing.glb"), ErrorCode::kFileNotFound, "");
  expect_file_refused(folder.path(), ErrorCode::kFileUnreadable, "", "folder");
  const std::string pipe = folder.path("pipe.gltf");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_file_refused(pipe, ErrorCode::kFileUnreadable, "");
  expect_file_refused("/dev/zero", ErrorCode::kFileUnreadable, "");
}

TEST(GltfReader, RefusesFilesBeyondTheSizeLimit) {
  const TemporaryFolder folder;
  const std::string path = folder.write("large.glb", "glTF");
  std::filesystem::resize_file(path, kMaxGltfFileBytes + 1);  // a sparse file
  expect_file_refused(path, ErrorCode::kLimitExceeded, "", std::to_string(kMaxGltfFileBytes));
}

TEST(GltfReader, RefusesFilesThatAreNotGltf) {
  const TemporaryFolder folder;
  for (const char* text : {"", "   ", "solid cube", "[1, 2]", "\xEF\xBB\xBF{}", "{}",
                           R"({"asset": 5})", R"({"asset": {}})"}) {
    const auto scene = read_gltf(GltfBuilder::write_text(folder, text));
    ASSERT_FALSE(scene.ok()) << text;
    EXPECT_EQ(scene.error().code, ErrorCode::kNotGltf) << text;
  }
  expect_file_refused(GltfBuilder::write_text(folder, R"({"asset": )"), ErrorCode::kInvalidContent,
                      "JSON");
}

TEST(GltfReader, RefusesOtherVersions) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["asset"]["version"] = "2.1";
  EXPECT_EQ(read_glb(asset).meshes.size(), 1u);
  asset.json["asset"]["minVersion"] = "2.1";
  expect_file_refused(asset, ErrorCode::kUnsupported, "/asset/minVersion");
  asset.json["asset"] = {{"version", "1.0"}};
  expect_file_refused(asset, ErrorCode::kUnsupported, "/asset/version", "1.0");
  asset.json["asset"] = {{"version", "3.0"}};
  expect_file_refused(asset, ErrorCode::kUnsupported, "/asset/version", "3.0");
  for (const Json& wrong : {Json("two"), Json("2"), Json("2."), Json(".0"), Json("2.0.0"),
                            Json(2.0), Json("99999999999.0"), Json("")}) {
    asset.json["asset"] = {{"version", wrong}};
    expect_file_invalid(asset, "/asset/version");
  }
}

TEST(GltfReader, RefusesRequiredExtensionsItLacksByName) {
  for (const char* name : {"CESIUM_RTC", "EXT_primitive_voxels", "VENDOR_secret"}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["extensionsRequired"] = {"KHR_materials_unlit", name};
    expect_file_refused(asset, ErrorCode::kUnsupported, "/extensionsRequired/1", name);
  }
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["extensionsRequired"] = "KHR_materials_unlit";
  expect_file_invalid(asset, "/extensionsRequired");
}

const std::string kBin("BIN\0", 4);

TEST(GltfReader, RefusesBrokenGlbContainers) {
  const TemporaryFolder folder;
  const std::string good = test::glb_of({{"JSON", R"({"asset":{"version":"2.0"}} )"}});
  const auto refuse = [&](const std::string& bytes, const std::string& element) {
    expect_file_refused(folder.write("a.glb", bytes), ErrorCode::kInvalidContent, element);
  };
  const auto patched = [&](std::size_t offset, std::uint32_t value) {
    std::string bytes = good;
    bytes.replace(offset, 4, test::bytes_of(std::vector<std::uint32_t>{value}));
    return bytes;
  };
  refuse("glTF", "GLB header");
  refuse(good.substr(0, 12), "GLB header");
  refuse(patched(8, 0xffffffffu), "GLB header");
  refuse(patched(8, 0), "GLB header");
  refuse(good + "tail", "GLB header");
  refuse(patched(12, 0xffffffffu), "GLB chunk 0");
  refuse(patched(12, 0xfffffff0u), "GLB chunk 0");
  refuse(patched(16, 0x12345678u), "GLB chunk 0");
  refuse(test::glb_of({{kBin, "1234"}}), "GLB chunk 0");
  refuse(test::glb_of({{"JSON", "{}  "}, {"JSON", "{}  "}}), "GLB chunk 1");
  refuse(test::glb_of({{"JSON", "{}  "}, {kBin, "1234"}, {kBin, "1234"}}), "GLB chunk 2");
  expect_file_refused(folder.write("a.glb", patched(4, 1)), ErrorCode::kUnsupported, "GLB header");
}

TEST(GltfReader, RefusesABinChunkLongerThanTheFile) {
  const TemporaryFolder folder;
  std::string bytes =
      test::glb_of({{"JSON", R"({"asset":{"version":"2.0"}} )"}, {kBin, "12345678"}});
  const std::size_t length_at = bytes.size() - 16;
  bytes.replace(length_at, 4, test::bytes_of(std::vector<std::uint32_t>{0x7ffffffcu}));
  expect_file_refused(folder.write("a.glb", bytes), ErrorCode::kInvalidContent, "GLB chunk 1");
}

TEST(GltfReader, IgnoresUnknownChunksAndReadsUnalignedOnes) {
  const GltfBuilder asset = GltfBuilder::one_triangle();
  Json root = asset.json;
  root["buffers"] = {{{"byteLength", asset.bin.size()}}};
  std::string text = root.dump();
  while (text.size() % 4 != 1) text += ' ';
  const TemporaryFolder folder;
  const auto scene = read_or_fail(
      folder.write("a.glb", test::glb_of({{"JSON", text}, {kBin, asset.bin}, {"XTRA", "1234"}})));
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("multiple of 4"), std::string::npos);
}

TEST(GltfReader, RefusesDeepJsonWithoutOverflowingTheStack) {
  const TemporaryFolder folder;
  for (const std::size_t depth : {kMaxGltfJsonDepth + 1, std::size_t{5000000}}) {
    for (const auto& [open, close] : {std::pair("[", ']'), std::pair("{\"a\":", '}')}) {
      std::string text = R"({"asset":{"version":"2.0"},"extras":)";
      for (std::size_t i = 0; i < depth; ++i) text += open;
      text += "0" + std::string(depth, close) + "}";
      const auto scene = read_gltf(GltfBuilder::write_text(folder, text));
      ASSERT_FALSE(scene.ok());
      EXPECT_EQ(scene.error().code, ErrorCode::kLimitExceeded);
      EXPECT_NE(scene.error().problem.find("deeper"), std::string::npos);
    }
  }
}

TEST(GltfReader, CountsNoBracketsInsideStrings) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["name"] = std::string(5000, '[') + "\"\\" + std::string(5000, '{');
  EXPECT_EQ(read_glb(asset).nodes[0].name.size(), 10002u);
}

TEST(GltfReader, RefusesTooManyJsonValues) {
  const TemporaryFolder folder;
  std::string text = R"({"asset":{"version":"2.0"},"extras":[0)";
  for (std::size_t i = 0; i <= kMaxGltfJsonValues; ++i) text += ",0";
  const auto scene = read_gltf(GltfBuilder::write_text(folder, text + "]}"));
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, ErrorCode::kLimitExceeded);
}

// --- Buffers -------------------------------------------------------------------------------------

TEST(GltfReader, KeepsExternalBuffersInsideTheFolder) {
  const TemporaryFolder folder;
  const GltfBuilder asset = GltfBuilder::one_triangle();
  folder.write("secret.bin", asset.bin);
  folder.write("asset/inside.bin", asset.bin);
  folder.write("asset_two/near.bin", asset.bin);
  std::filesystem::create_symlink(folder.path("secret.bin"), folder.path("asset/link.bin"));
  std::filesystem::create_symlink(folder.path(), folder.path("asset/up"));
  std::filesystem::create_symlink("inside.bin", folder.path("asset/good_link.bin"));
  const auto with_uri = [&](const std::string& uri) {
    Json root = asset.json;
    root["buffers"] = {{{"byteLength", asset.bin.size()}, {"uri", uri}}};
    return folder.write("asset/scene.gltf", root.dump());
  };
  for (const char* uri :
       {"inside.bin", "./inside.bin", "in%73ide.bin", "good_link.bin", "../asset/inside.bin"}) {
    EXPECT_EQ(read_or_fail(with_uri(uri)).meshes.size(), 1u) << uri;
  }
  for (const std::string& uri :
       {std::string("../secret.bin"), std::string("..%2Fsecret.bin"),
        std::string("%2e%2e/secret.bin"), std::string("link.bin"), std::string("up/secret.bin"),
        std::string("../asset_two/near.bin"), std::string("x/../../secret.bin"), std::string("."),
        std::string(""), std::string("/etc/passwd"), folder.path("secret.bin"),
        std::string("inside.bin%00"), std::string("inside%zz"), std::string("inside%2")}) {
    expect_file_refused(with_uri(uri), ErrorCode::kInvalidContent, "/buffers/0/uri");
  }
  expect_file_refused(with_uri("https://example.com/a.bin"), ErrorCode::kUnsupported,
                      "/buffers/0/uri");
  expect_file_refused(with_uri("file:inside.bin"), ErrorCode::kUnsupported, "/buffers/0/uri");
}

TEST(GltfReader, LooksForBuffersBesideTheAssetOnly) {
  const TemporaryFolder folder;
  const TemporaryFolder elsewhere;
  const GltfBuilder asset = GltfBuilder::one_triangle();
  const std::string path = asset.write_gltf(folder);
  std::filesystem::rename(folder.path("asset.bin"), elsewhere.path("asset.bin"));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(elsewhere.path());
  expect_file_refused(path, ErrorCode::kFileNotFound, "/buffers/0/uri", "asset.bin");
  std::filesystem::current_path(before);
}

TEST(GltfReader, RefusesBuffersThatAreNotRegularFiles) {
  const TemporaryFolder folder;
  GltfBuilder asset = GltfBuilder::one_triangle();
  ASSERT_EQ(::mkfifo(folder.path("pipe").c_str(), 0600), 0);
  std::filesystem::create_directory(folder.path("folder"));
  for (const char* uri : {"pipe", "folder"}) {
    asset.json["buffers"] = {{{"byteLength", asset.bin.size()}, {"uri", uri}}};
    expect_file_refused(asset.write_gltf(folder), ErrorCode::kFileUnreadable, "/buffers/0/uri",
                        uri);
  }
  asset.json["buffers"][0]["uri"] = "pointer.bin";
  folder.write("pointer.bin",
               "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 44\n");
  expect_file_refused(asset.write_gltf(folder), ErrorCode::kFileUnreadable, "/buffers/0/uri",
                      "lfs");
}

TEST(GltfReader, AcceptsLongerButNotShorterBuffers) {
  const TemporaryFolder folder;
  const GltfBuilder asset = GltfBuilder::one_triangle();
  const std::string path = asset.write_gltf(folder);
  folder.write("asset.bin", asset.bin + "more");
  EXPECT_EQ(read_or_fail(path).meshes.size(), 1u);
  folder.write("asset.bin", asset.bin.substr(1));
  expect_file_refused(path, ErrorCode::kInvalidContent, "/buffers/0/byteLength", "truncated");
  folder.write("asset.bin", "");
  expect_file_refused(path, ErrorCode::kInvalidContent, "/buffers/0/byteLength");
}

TEST(GltfReader, RefusesBuffersWithoutData) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["buffers"] = {{{"byteLength", 0}}};
  expect_file_invalid(asset, "/buffers/0/byteLength");
  asset.json["buffers"] = {{{"byteLength", asset.bin.size() + 100}}};
  expect_file_invalid(asset, "/buffers/0/byteLength");
  asset.json["buffers"] = Json::array({Json::object()});
  expect_file_invalid(asset, "/buffers/0/byteLength", "missing");
  // Twenty thousand buffers, each of which would be a copy of the BIN chunk.
  asset.json["buffers"] = Json::array();
  for (int i = 0; i < 20000; ++i) asset.json["buffers"].push_back({{"byteLength", 1}});
  asset.json["bufferViews"][0]["buffer"] = 1;
  expect_file_invalid(asset, "/buffers/1", "BIN chunk");
  asset.json["buffers"] = {{{"byteLength", asset.bin.size()}}};
  asset.json["bufferViews"][0]["buffer"] = 0;
  const TemporaryFolder folder;
  expect_file_refused(asset.write_gltf(folder), ErrorCode::kInvalidContent, "/buffers/0");
}

TEST(GltfReader, RefusesBrokenDataUris) {
  const TemporaryFolder folder;
  GltfBuilder asset = GltfBuilder::one_triangle();
  const std::string data = test::base64_encoded(asset.bin);
  for (const std::string& uri :
       {"data:;base64" + data, "data:," + data, "data:application/octet-stream," + data,
        "data:;base64," + data.substr(0, 9) + "*" + data.substr(10), "data:;base64," + data + "A",
        std::string("data:;base64,=")}) {
    asset.json["buffers"] = {{{"byteLength", asset.bin.size()}, {"uri", uri}}};
    expect_file_refused(asset.write_gltf(folder), ErrorCode::kInvalidContent, "/buffers/0/uri");
  }
}

// --- Views and accessors -------------------------------------------------------------------------

TEST(GltfReader, RefusesViewsBeyondTheirBuffer) {
  const std::size_t bin_size = GltfBuilder::one_triangle().bin.size();
  for (const auto& [offset, length] :
       std::vector<std::pair<Json, Json>>{{0, bin_size + 1},
                                          {bin_size, 36},
                                          {bin_size + 1, 1},
                                          {9007199254740992, 36},
                                          {36, 9007199254740992},
                                          {9007199254740992, 9007199254740992}}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["bufferViews"][0]["byteOffset"] = offset;
    asset.json["bufferViews"][0]["byteLength"] = length;
    expect_file_invalid(asset, "/bufferViews/0", "beyond buffer 0");
  }
}

TEST(GltfReader, RefusesAccessorsBeyondTheirView) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto refuse_with = [&](const char* property, const Json& value) {
    GltfBuilder broken = asset;
    broken.json["accessors"][0][property] = value;
    expect_file_invalid(broken, "/accessors/0", "beyond bufferView 0");
  };
  refuse_with("count", 4);
  refuse_with("byteOffset", 1);
  refuse_with("byteOffset", 37);
  refuse_with("byteOffset", std::uint64_t{1} << 53);
  asset.json["bufferViews"][0]["byteStride"] = 16;
  expect_file_invalid(asset, "/accessors/0", "stride 16");
  asset.json["bufferViews"][0]["byteStride"] = 8;
  expect_file_invalid(asset, "/bufferViews/0/byteStride", "12 bytes");
  for (const Json& stride : {Json(0), Json(6), Json(256), Json(-4)}) {
    asset.json["bufferViews"][0]["byteStride"] = stride;
    expect_file_invalid(asset, "/bufferViews/0/byteStride");
  }
}

TEST(GltfReader, RefusesHugeCountsBeforeAllocating) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  for (const std::uint64_t count :
       {std::uint64_t{kMaxGltfVertices} + 1, std::uint64_t{1} << 40, std::uint64_t{1} << 53}) {
    asset.json["accessors"][0]["count"] = count;
    expect_file_refused(asset, ErrorCode::kLimitExceeded, "/accessors/0/count");
  }
  asset.json["accessors"][0]["count"] = 3;
  asset.json["accessors"][1]["count"] = std::uint64_t{1} << 40;
  expect_file_refused(asset, ErrorCode::kLimitExceeded, "/accessors/1/count");
  asset.json["accessors"][1]["count"] = 1e300;
  expect_file_invalid(asset, "/accessors/1/count");
  asset.json["accessors"][1]["count"] = -3;
  expect_file_invalid(asset, "/accessors/1/count");
  asset.json["accessors"][1]["count"] = 0;
  expect_file_invalid(asset, "/accessors/1/count");
}

TEST(GltfReader, BoundsTheVerticesOfAllMeshesTogether) {
  // Sparse without base view: vertices that take no bytes in the file.
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto where = asset.add_view(test::bytes_of(std::vector<std::uint8_t>{1}));
  const auto values = asset.add_view(test::bytes_of(std::vector<float>{1, 1, 1}));
  Json& accessor = asset.json["accessors"][0];
  accessor.erase("bufferView");
  accessor["count"] = kMaxGltfVertices / 4;
  accessor["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedByte}}},
      {"values", {{"bufferView", values}}}};
  for (int i = 0; i < 10; ++i)
    asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive_of(0, 1)}))}});
  expect_file_refused(asset, ErrorCode::kLimitExceeded, "/accessors/0/count");
}

TEST(GltfReader, RefusesWrongAccessorTypes) {
  const auto refuse = [](std::size_t accessor, const char* property, const Json& value) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["accessors"][accessor][property] = value;
    expect_file_invalid(asset, "/accessors/" + std::to_string(accessor) + "/" + property);
  };
  for (const char* type : {"SCALAR", "VEC2", "VEC4", "MAT3", "VEC5"}) refuse(0, "type", type);
  for (const char* type : {"VEC3", "vec3"}) refuse(1, "type", type);
  for (const int type : {5120, 5122, 5126, 5124, 5130, 0, -1}) refuse(1, "componentType", type);
  for (const int type : {5121, 5123, 5125, 5127}) refuse(0, "componentType", type);
  refuse(0, "normalized", true);
  refuse(1, "normalized", true);
  refuse(1, "normalized", 1);
}

TEST(GltfReader, RefusesAccessorsWithoutData) {
  for (const std::size_t accessor : {0u, 1u}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["accessors"][accessor].erase("bufferView");
    expect_file_refused(asset, ErrorCode::kUnsupported, "/accessors/" + std::to_string(accessor));
  }
}

TEST(GltfReader, RefusesIndicesBeyondTheVertices) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const int type :
       {GltfBuilder::kUnsignedByte, GltfBuilder::kUnsignedShort, GltfBuilder::kUnsignedInt}) {
    expect_file_invalid(asset_of(points, {0, 1, 3}, type), "/meshes/0/primitives/0/indices",
                        "index 2 is 3");
    expect_file_invalid(asset_of(points, {0, 254, 1}, type), "/meshes/0/primitives/0/indices",
                        "index 1 is 254");
  }
}

TEST(GltfReader, ReadsTheRestartIndexAsAVertexInListsOnly) {
  const std::vector<Eigen::Vector3f> points = [] {
    std::vector<Eigen::Vector3f> line;
    for (int i = 0; i < 65536; ++i)
      line.emplace_back(static_cast<float>(i), i % 2 ? 1.0f : 0.0f, 0.0f);
    return line;
  }();
  for (const auto& [index, type] : {std::pair(255u, GltfBuilder::kUnsignedByte),
                                    std::pair(65535u, GltfBuilder::kUnsignedShort)}) {
    GltfBuilder asset = asset_of(points, {0, 1, index}, type);
    const SceneDescription scene = read_glb(asset);
    EXPECT_EQ(scene.meshes.at(0).triangles.at(0)[2], index);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find(std::to_string(index)), std::string::npos);
    for (const int strip_or_fan : {5, 6}) {
      asset.json["meshes"][0]["primitives"][0]["mode"] = strip_or_fan;
      expect_file_invalid(asset, "/meshes/0/primitives/0/indices", std::to_string(index));
    }
  }
}

TEST(GltfReader, RefusesIncompleteTriangles) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  constexpr int kType = GltfBuilder::kUnsignedShort;
  expect_file_invalid(asset_of(points, {0, 1, 2, 3}), "/meshes/0/primitives/0", "multiple of 3");
  expect_file_invalid(asset_of(points, {0, 1}, kType, 5), "/meshes/0/primitives/0", "3 or more");
  expect_file_invalid(asset_of(points, {0}, kType, 6), "/meshes/0/primitives/0", "3 or more");
  GltfBuilder unindexed = asset_of(points, {0, 1, 2});
  unindexed.json["meshes"][0]["primitives"][0].erase("indices");
  expect_file_invalid(unindexed, "/meshes/0/primitives/0", "multiple of 3");
}

TEST(GltfReader, RefusesPositionsThatAreNotFinite) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    expect_file_invalid(asset_of({{0, 0, 0}, {1, 0, bad}, {0, 1, 0}}, {0, 1, 2}), "/accessors/0",
                        "position 1");
  }
}

TEST(GltfReader, RefusesBrokenSparseAccessors) {
  GltfBuilder good = GltfBuilder::one_triangle();
  const auto where = good.add_view(test::bytes_of(std::vector<std::uint16_t>{0, 2}));
  const auto values = good.add_view(test::bytes_of(std::vector<float>{1, 1, 1, 2, 2, 2}));
  good.json["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", where}, {"componentType", GltfBuilder::kUnsignedShort}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_EQ(read_glb(good).meshes.size(), 1u);
  const auto refuse = [&](const char* pointer, const Json& value, const std::string& element) {
    GltfBuilder asset = good;
    asset.json["accessors"][0]["sparse"][Json::json_pointer(pointer)] = value;
    expect_file_invalid(asset, "/accessors/0/sparse" + element);
  };
  for (const Json& count : {Json(0), Json(4), Json(2147483647), Json(2147483648u), Json(-1)}) {
    refuse("/count", count, "/count");
  }
  refuse("/count", 3, "/indices");
  refuse("/indices/byteOffset", 1, "/indices");
  refuse("/indices/byteOffset", 2147483647, "/indices");
  refuse("/indices/byteOffset", -1, "/indices/byteOffset");
  refuse("/indices/bufferView", 9, "/indices/bufferView");
  refuse("/indices/componentType", GltfBuilder::kFloat, "/indices/componentType");
  refuse("/values/byteOffset", 1, "/values");
  refuse("/values/bufferView", -1, "/values/bufferView");
  refuse("/values", Json::array(), "/values");
  for (const std::vector<std::uint16_t>& targets :
       {std::vector<std::uint16_t>{2, 0}, {1, 1}, {0, 3}, {0, 65535}}) {
    GltfBuilder asset = good;
    const std::size_t offset = asset.json["bufferViews"][where]["byteOffset"];
    asset.bin.replace(offset, 4, test::bytes_of(targets));
    expect_file_invalid(asset, "/accessors/0/sparse/indices", "element 1");
  }
}

// --- Ids, types and the node hierarchy -----------------------------------------------------------

TEST(GltfReader, RefusesIdsOutOfRangeEverywhere) {
  for (const char* pointer :
       {"/scene", "/scenes/0/nodes/0", "/nodes/0/mesh", "/nodes/0/skin", "/nodes/0/children/0",
        "/meshes/0/primitives/0/indices", "/meshes/0/primitives/0/attributes/POSITION",
        "/meshes/0/primitives/0/attributes/NORMAL", "/meshes/0/primitives/0/targets/0/POSITION",
        "/accessors/0/bufferView", "/bufferViews/0/buffer"}) {
    for (const Json& id : {Json(2), Json(-1), Json(4294967296), Json(-9223372036854775807),
                           Json(18446744073709551615u), Json(0.5), Json("0"), Json(), Json(true),
                           Json::array({0})}) {
      GltfBuilder asset = GltfBuilder::one_triangle();
      asset.json["scene"] = 0;
      asset.json["nodes"][0]["children"] = Json::array();
      asset.json["meshes"][0]["primitives"][0]["targets"] = Json::array({Json::object()});
      asset.json[Json::json_pointer(pointer)] = id;
      expect_file_invalid(asset, pointer);
    }
  }
}

TEST(GltfReader, AcceptsWholeNumbersWrittenWithAFraction) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["accessors"][0]["count"] = 3.0;
  asset.json["nodes"][0]["mesh"] = 0.0;
  EXPECT_EQ(read_glb(asset).meshes.at(0).positions.size(), 3u);
}

TEST(GltfReader, RefusesWrongJsonTypes) {
  for (const char* pointer : {"/scenes",
                              "/scenes/0",
                              "/scenes/0/nodes",
                              "/nodes",
                              "/nodes/0",
                              "/nodes/0/children",
                              "/nodes/0/name",
                              "/meshes",
                              "/meshes/0",
                              "/meshes/0/primitives",
                              "/meshes/0/primitives/0",
                              "/meshes/0/primitives/0/attributes",
                              "/meshes/0/primitives/0/targets",
                              "/meshes/0/primitives/0/mode",
                              "/accessors",
                              "/accessors/0",
                              "/accessors/0/byteOffset",
                              "/accessors/0/sparse",
                              "/bufferViews",
                              "/bufferViews/0",
                              "/bufferViews/0/byteLength",
                              "/buffers",
                              "/buffers/0",
                              "/buffers/0/byteLength",
                              "/buffers/0/uri",
                              "/nodes/0/matrix",
                              "/nodes/0/scale"}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["buffers"] = {{{"byteLength", asset.bin.size()}}};
    asset.json[Json::json_pointer(pointer)] = 1.5;
    expect_file_invalid(asset, pointer);
  }
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["meshes"][0].erase("primitives");
  expect_file_invalid(asset, "/meshes/0/primitives", "missing");
}

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

TEST(GltfReader, RefusesNumbersBeyondDouble) {
  const TemporaryFolder folder;
  for (const char* number : {"1e999", "-1e999", "NaN", "Infinity"}) {
    const std::string text =
        std::string(R"({"asset":{"version":"2.0"},"nodes":[{"scale":[1,)") + number + ",1]}]}";
    expect_file_refused(GltfBuilder::write_text(folder, text), ErrorCode::kInvalidContent, "JSON");
  }
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

TEST(GltfReader, SurvivesEveryCutAndEveryChangedByte) {
  // The reader must return, with any result; sanitizers check its accesses.
  const TemporaryFolder folder;
  const std::string path = GltfBuilder::one_triangle().write_glb(folder);
  std::string good(std::filesystem::file_size(path), '\0');
  {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    ASSERT_NE(file, nullptr);
    ASSERT_EQ(std::fread(good.data(), 1, good.size(), file), good.size());
    std::fclose(file);
  }
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_FALSE(read_gltf(folder.write("cut.glb", good.substr(0, length))).ok());
  }
  test::Random random(5);
  std::size_t refused = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string changed = good;
    for (std::size_t k = 0; k <= random.index(3); ++k) {
      changed[random.index(changed.size())] = static_cast<char>(random.index(256));
    }
    refused += read_gltf(folder.write("changed.glb", changed)).ok() ? 0 : 1;
  }
  EXPECT_GT(refused, 0u);
}

}  // namespace
}  // namespace palpate
