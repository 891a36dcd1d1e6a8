// Meshes: their primitives, views and accessors, read and refused.

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
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
using test::asset_of;
using test::expect_file_invalid;
using test::expect_file_refused;
using test::expect_same_geometry;
using test::GltfBuilder;
using test::primitive_of;
using test::random_points;
using test::read_glb;

// ---- what is read ------------------------------------------------------------------------------

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

// ---- what is refused ---------------------------------------------------------------------------

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

}  // namespace
}  // namespace palpate
