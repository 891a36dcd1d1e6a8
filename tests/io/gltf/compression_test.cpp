#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <limits>
#include <malloc.h>
#include <memory>
#include <meshoptimizer.h>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "geometry/base/memory_reserve.h"
#include "io/gltf/draco.h"
#include "io/gltf/limits.h"
#include "io/gltf/reader.h"
#include "io/gltf/tinygltf.h"
#include "tests/helpers/compressed_seeds.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"

namespace {

// The bytes in use and their maximum, over all allocations of the process, including those of the
// codecs.
std::atomic<std::size_t> live_bytes{0};
std::atomic<std::size_t> peak_bytes{0};

void* counted_new_or_null(std::size_t size) noexcept {
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) return nullptr;
  const std::size_t live = live_bytes += malloc_usable_size(memory);
  if (live > peak_bytes) peak_bytes = live;
  return memory;
}

void* counted_new(std::size_t size) {
  void* memory = counted_new_or_null(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void counted_delete(void* memory) noexcept {
  if (memory != nullptr) live_bytes -= malloc_usable_size(memory);
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) {
  return counted_new(size);
}
void* operator new[](std::size_t size) {
  return counted_new(size);
}
// The sanitizers replace these operators by their own, which would not be counted.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return counted_new_or_null(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return counted_new_or_null(size);
}
void operator delete(void* memory) noexcept {
  counted_delete(memory);
}
void operator delete[](void* memory) noexcept {
  counted_delete(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  counted_delete(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  counted_delete(memory);
}

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::GltfBuilder;
using Points = std::vector<Eigen::Vector3f>;
using Indices = std::vector<std::uint32_t>;

constexpr const char* kMeshopt = "EXT_meshopt_compression";

std::string glb_bytes(const GltfBuilder& asset) {
  Json root = asset.json;
  if (!root.contains("buffers")) root["buffers"] = {{{"byteLength", asset.bin.size()}}};
  const auto padded = [](std::string bytes, char padding) {
    bytes.resize((bytes.size() + 3) / 4 * 4, padding);
    return bytes;
  };
  return test::glb_of(
      {{"JSON", padded(root.dump(), ' ')}, {std::string("BIN\0", 4), padded(asset.bin, '\0')}});
}

Result<SceneDescription> read_bytes(const std::string& bytes) {
  return read_gltf_bytes({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, "",
                         "asset.glb");
}

Result<SceneDescription> read_result(const GltfBuilder& asset) {
  return read_bytes(glb_bytes(asset));
}

SceneDescription read(const GltfBuilder& asset) {
  auto scene = read_result(asset);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().to_string());
  return scene.ok() ? std::move(*scene) : SceneDescription{};
}

void expect_refused(const GltfBuilder& asset, ErrorCode code, const std::string& element,
                    const std::string& text = {}) {
  const auto scene = read_result(asset);
  ASSERT_FALSE(scene.ok()) << "accepted; expected an error at " << element;
  const Error& error = scene.error();
  EXPECT_EQ(static_cast<int>(error.code), static_cast<int>(code)) << error.to_string();
  EXPECT_EQ(error.element, element) << error.to_string();
  EXPECT_NE(error.to_string().find(text), std::string::npos) << error.to_string();
}

// The peak memory of reading the asset above the current use, without the reserve that every file
// needs.
std::size_t peak_while_refused(const GltfBuilder& asset) {
  const std::string bytes = glb_bytes(asset);
  const MemoryReserve set_aside;
  const std::size_t before = live_bytes;
  peak_bytes = before;
  EXPECT_FALSE(read_bytes(bytes).ok());
  return peak_bytes - before;
}

// A grid of n x n squares on a wavy surface, the usual input of encoders.
Points grid_points(std::size_t n) {
  Points points;
  for (std::size_t i = 0; i <= n; ++i) {
    for (std::size_t j = 0; j <= n; ++j) {
      const float x = static_cast<float>(i) / static_cast<float>(n);
      const float y = static_cast<float>(j) / static_cast<float>(n);
      points.emplace_back(x, y, 0.1f * std::sin(9.0f * x) * std::cos(7.0f * y));
    }
  }
  return points;
}

Indices grid_indices(std::size_t n) {
  Indices indices;
  const auto row = static_cast<std::uint32_t>(n + 1);
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * row + j;
      for (const std::uint32_t index : {a, a + row, a + 1, a + 1, a + row, a + row + 1}) {
        indices.push_back(index);
      }
    }
  }
  return indices;
}

std::string meshopt_vertices(const std::string& bytes, std::size_t stride) {
  const std::size_t count = bytes.size() / stride;
  std::string encoded(meshopt_encodeVertexBufferBound(count, stride), '\0');
  encoded.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(encoded.data()),
                                            encoded.size(), bytes.data(), count, stride));
  return encoded;
}

std::string meshopt_triangles(const Indices& indices) {
  std::string encoded(meshopt_encodeIndexBufferBound(indices.size(), 1u << 20), '\0');
  encoded.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(encoded.data()),
                                           encoded.size(), indices.data(), indices.size()));
  return encoded;
}

std::string meshopt_sequence(const Indices& indices) {
  std::string encoded(meshopt_encodeIndexSequenceBound(indices.size(), 1u << 20), '\0');
  encoded.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(encoded.data()),
                                             encoded.size(), indices.data(), indices.size()));
  return encoded;
}

// An asset whose views live in buffer 1, a fallback without data, compressed in buffer 0.
class MeshoptAsset : public GltfBuilder {
 public:
  explicit MeshoptAsset(const char* extension = kMeshopt) : extension_(extension) {
    json["extensionsUsed"] = {extension};
    json["extensionsRequired"] = {extension};
  }

  std::size_t add_compressed(const std::string& encoded, std::size_t count, std::size_t stride,
                             const std::string& mode, const std::string& filter = {}) {
    while (bin.size() % 4 != 0) bin += '\0';
    Json compressed = {{"buffer", 0},          {"byteOffset", bin.size()},
                       {"count", count},       {"byteLength", encoded.size()},
                       {"byteStride", stride}, {"mode", mode}};
    if (!filter.empty()) compressed["filter"] = filter;
    Json view = {{"buffer", 1}, {"byteOffset", fallback_}, {"byteLength", count * stride}};
    if (mode == "ATTRIBUTES") view["byteStride"] = stride;
    view["extensions"][extension_] = compressed;
    bin += encoded;
    fallback_ += count * stride;
    json["bufferViews"].push_back(view);
    json["buffers"] = {{{"byteLength", bin.size()}}, {{"byteLength", fallback_}}};
    json["buffers"][1]["extensions"][extension_]["fallback"] = true;
    return json["bufferViews"].size() - 1;
  }

  // One mesh of one primitive, in one node.
  void place(std::size_t positions, std::size_t indices, int mode = 4) {
    const Json primitive = {
        {"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", mode}};
    add_node({{"mesh", add_mesh(Json::array({primitive}))}});
  }

  Json& compressed(std::size_t view) { return json["bufferViews"][view]["extensions"][extension_]; }

 private:
  std::string extension_;
  std::size_t fallback_ = 0;
};

// Views and accessors 0 (positions) and 1 (indices of 16 bits).
MeshoptAsset meshopt_grid(std::size_t n, const char* extension = kMeshopt) {
  const Points points = grid_points(n);
  const Indices indices = grid_indices(n);
  MeshoptAsset asset(extension);
  const auto vertices = asset.add_compressed(meshopt_vertices(test::bytes_of(points), 12),
                                             points.size(), 12, "ATTRIBUTES", "NONE");
  const auto triangles =
      asset.add_compressed(meshopt_triangles(indices), indices.size(), 2, "TRIANGLES");
  asset.place(asset.add_accessor(vertices, GltfBuilder::kFloat, points.size(), "VEC3"),
              asset.add_accessor(triangles, GltfBuilder::kUnsignedShort, indices.size(), "SCALAR"));
  return asset;
}

// Compression may change the first corner of a triangle.
Triangle from_smallest(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

void expect_triangles(const std::vector<Triangle>& found, const Indices& expected) {
  ASSERT_EQ(3 * found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Triangle t = {expected[3 * i], expected[3 * i + 1], expected[3 * i + 2]};
    EXPECT_EQ(from_smallest(found[i]), from_smallest(t)) << "triangle " << i;
  }
}

void expect_positions(const std::vector<Vec3>& found, const Points& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i], expected[i].cast<double>());
}

TEST(Meshopt, ReadsPositionsAndTrianglesBitForBit) {
  for (const char* extension : {kMeshopt, "KHR_meshopt_compression"}) {
    // From less than one group of 16 vertices to several blocks of 256.
    for (const std::size_t n : {1u, 3u, 4u, 15u, 40u}) {
      const auto scene = read(meshopt_grid(n, extension));
      ASSERT_EQ(scene.meshes.size(), 1u);
      expect_positions(scene.meshes[0].positions, grid_points(n));
      expect_triangles(scene.meshes[0].triangles, grid_indices(n));
      EXPECT_TRUE(scene.warnings.empty());
    }
  }
}

TEST(Meshopt, ReadsBothIndexModesInBothWidths) {
  const Points points = grid_points(20);
  const Indices indices = grid_indices(20);
  for (const bool sequence : {false, true}) {
    for (const std::size_t stride : {2u, 4u}) {
      MeshoptAsset asset;
      const auto view =
          asset.add_compressed(sequence ? meshopt_sequence(indices) : meshopt_triangles(indices),
                               indices.size(), stride, sequence ? "INDICES" : "TRIANGLES");
      const auto vertices = asset.add_compressed(meshopt_vertices(test::bytes_of(points), 12),
                                                 points.size(), 12, "ATTRIBUTES");
      const int type = stride == 2 ? GltfBuilder::kUnsignedShort : GltfBuilder::kUnsignedInt;
      asset.place(asset.add_accessor(vertices, GltfBuilder::kFloat, points.size(), "VEC3"),
                  asset.add_accessor(view, type, indices.size(), "SCALAR"));
      expect_triangles(read(asset).meshes.at(0).triangles, indices);
    }
  }
}

// Version 0.22 of meshoptimizer also has a mode parameter; this mode is that of older versions.
template <typename Points>
void encode_exponents(auto& filtered, const Points& points, int bits) {
  constexpr std::size_t kStride = sizeof(points[0]);
#if MESHOPTIMIZER_VERSION >= 220
  meshopt_encodeFilterExp(filtered.data(), points.size(), kStride, bits, points[0].data(),
                          meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(filtered.data(), points.size(), kStride, bits, points[0].data());
#endif
}

TEST(Meshopt, ReadsStrips) {
  const Points points = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}};
  MeshoptAsset asset;
  const auto strip = asset.add_compressed(meshopt_sequence({0, 1, 2, 3, 4}), 5, 2, "INDICES");
  const auto vertices =
      asset.add_compressed(meshopt_vertices(test::bytes_of(points), 12), 5, 12, "ATTRIBUTES");
  asset.place(asset.add_accessor(vertices, GltfBuilder::kFloat, 5, "VEC3"),
              asset.add_accessor(strip, GltfBuilder::kUnsignedShort, 5, "SCALAR"), 5);
  expect_triangles(read(asset).meshes.at(0).triangles, {0, 1, 2, 1, 3, 2, 2, 3, 4});
}

TEST(Meshopt, UndoesTheExponentialFilterBitForBit) {
  const Points points = grid_points(12);
  for (const int bits : {12, 16, 24}) {
    std::vector<std::int32_t> filtered(points.size() * 3);
    encode_exponents(filtered, points, bits);
    MeshoptAsset asset;
    const auto vertices = asset.add_compressed(meshopt_vertices(test::bytes_of(filtered), 12),
                                               points.size(), 12, "ATTRIBUTES", "EXPONENTIAL");
    const auto indices = grid_indices(12);
    const auto triangles =
        asset.add_compressed(meshopt_triangles(indices), indices.size(), 2, "TRIANGLES");
    asset.place(
        asset.add_accessor(vertices, GltfBuilder::kFloat, points.size(), "VEC3"),
        asset.add_accessor(triangles, GltfBuilder::kUnsignedShort, indices.size(), "SCALAR"));
    const auto scene = read(asset);
    for (std::size_t i = 0; i < filtered.size(); ++i) {
      // 8 bits of a signed exponent of two above 24 of a signed factor.
      const std::int32_t exponent = filtered[i] >> 24;
      const std::int32_t factor = filtered[i] - exponent * (1 << 24);
      const double expected = std::ldexp(factor >= 1 << 23 ? factor - (1 << 24) : factor, exponent);
      const auto k = static_cast<Eigen::Index>(i % 3);
      EXPECT_EQ(scene.meshes.at(0).positions[i / 3][k], expected);
      // One percent of the box: only a check for gross errors.
      EXPECT_NEAR(expected, points[i / 3][k], 0.01);
    }
  }
}

// Random unit vectors as quantised positions, for a filter with four floats per vector.
void expect_filtered(const std::string& filter, std::size_t stride, int component_type,
                     double bound) {
  test::Random random(7);
  std::vector<Eigen::Vector4f> units;
  for (int i = 0; i < 100; ++i) {
    Eigen::Vector4f unit(0, 0, 0, 0);
    for (int k = 0; k < 4; ++k) unit[k] = static_cast<float>(random.normal());
    if (filter == "OCTAHEDRAL") unit[3] = 0.0f;
    unit.normalize();
    // The largest component of a quaternion is stored as positive, which may negate the quaternion.
    int largest = 0;
    unit.cwiseAbs().maxCoeff(&largest);
    if (filter == "QUATERNION" && unit[largest] < 0.0f) unit = -unit;
    units.push_back(unit);
  }
  std::string filtered(units.size() * stride, '\0');
  const auto encode = filter == "OCTAHEDRAL" ? meshopt_encodeFilterOct : meshopt_encodeFilterQuat;
  encode(filtered.data(), units.size(), stride, stride == 4 ? 8 : 16, units[0].data());
  MeshoptAsset asset;
  asset.json["extensionsUsed"].push_back("KHR_mesh_quantization");
  const auto vertices = asset.add_compressed(meshopt_vertices(filtered, stride), units.size(),
                                             stride, "ATTRIBUTES", filter);
  const auto triangles = asset.add_compressed(meshopt_triangles({0, 1, 2}), 3, 2, "TRIANGLES");
  const auto positions = asset.add_accessor(vertices, component_type, units.size(), "VEC3");
  asset.json["accessors"][positions]["normalized"] = true;
  asset.place(positions, asset.add_accessor(triangles, GltfBuilder::kUnsignedShort, 3, "SCALAR"));
  const auto scene = read(asset);
  for (std::size_t i = 0; i < units.size(); ++i) {
    const Vec3 expected = units[i].head<3>().cast<double>();
    EXPECT_LE((scene.meshes.at(0).positions[i] - expected).lpNorm<Eigen::Infinity>(), bound);
  }
}

TEST(Meshopt, UndoesTheFiltersOfUnitVectorsAndQuaternions) {
  // A few units of the format: the octahedron is twice as steep as the sphere at its corners, and
  // one more rounding follows.
  expect_filtered("OCTAHEDRAL", 4, GltfBuilder::kByte, 3.0 / 127.0);
  expect_filtered("OCTAHEDRAL", 8, GltfBuilder::kShort, 3.0 / 32767.0);
  expect_filtered("QUATERNION", 8, GltfBuilder::kShort, 3.0 / 32767.0);
}

TEST(Meshopt, ReadsQuantisedPositionsAtTheirStride) {
  const std::vector<std::uint16_t> stored = {0, 0, 0, 7, 65535, 0, 0, 7, 0, 65535, 13107, 7};
  MeshoptAsset asset;
  asset.json["extensionsUsed"].push_back("KHR_mesh_quantization");
  const auto vertices =
      asset.add_compressed(meshopt_vertices(test::bytes_of(stored), 8), 3, 8, "ATTRIBUTES");
  const auto triangles = asset.add_compressed(meshopt_triangles({0, 1, 2}), 3, 2, "TRIANGLES");
  const auto positions = asset.add_accessor(vertices, GltfBuilder::kUnsignedShort, 3, "VEC3");
  asset.json["accessors"][positions]["normalized"] = true;
  asset.place(positions, asset.add_accessor(triangles, GltfBuilder::kUnsignedShort, 3, "SCALAR"));
  const auto scene = read(asset);
  ASSERT_EQ(scene.meshes.at(0).positions.size(), 3u);
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3(1, 0, 0));
  EXPECT_EQ(scene.meshes[0].positions[2], Vec3(0, 1, 13107.0 / 65535.0));

  // The same bytes read without the stride would give other positions.
  asset.json["bufferViews"][vertices].erase("byteStride");
  expect_refused(asset, ErrorCode::kInvalidContent, "/accessors/0", "of 8 bytes");
}

TEST(Meshopt, DecodesAViewOnceForAllItsAccessors) {
  // Two interleaved accessors of 100 meshes in one view: if it were decoded or counted for each
  // mesh, it would exceed the limits.
  constexpr std::size_t kCount = 1u << 20;
  static_assert(100 * kCount * 24 > kMaxGltfBufferBytes);
  std::vector<float> interleaved(kCount * 6);
  for (std::size_t i = 0; i < interleaved.size(); ++i) interleaved[i] = static_cast<float>(i % 97);
  MeshoptAsset asset;
  const auto vertices = asset.add_compressed(meshopt_vertices(test::bytes_of(interleaved), 24),
                                             kCount, 24, "ATTRIBUTES");
  const auto triangles = asset.add_compressed(meshopt_triangles({0, 1, 2}), 3, 2, "TRIANGLES");
  const auto indices = asset.add_accessor(triangles, GltfBuilder::kUnsignedShort, 3, "SCALAR");
  for (int i = 0; i < 100; ++i) {
    const auto positions = asset.add_accessor(vertices, GltfBuilder::kFloat, 3, "VEC3");
    asset.json["accessors"][positions]["byteOffset"] = i % 2 == 0 ? 0 : 12;
    asset.place(positions, indices);
  }
  const auto scene = read(asset);
  ASSERT_EQ(scene.meshes.size(), 100u);
  EXPECT_EQ(scene.meshes[0].positions[1], Vec3(6, 7, 8));
  EXPECT_EQ(scene.meshes[1].positions[1], Vec3(9, 10, 11));
}

TEST(Meshopt, DecodesEvenIfAFallbackIsPresent) {
  MeshoptAsset asset = meshopt_grid(4);
  asset.json.erase("extensionsRequired");
  const std::size_t bytes = asset.json["buffers"][1]["byteLength"].get<std::size_t>();
  asset.json["buffers"][1] = {{"byteLength", bytes},
                              {"uri", "data:application/octet-stream;base64," +
                                          test::base64_encoded(std::string(bytes, '\x01'))}};
  expect_positions(read(asset).meshes.at(0).positions, grid_points(4));
}

TEST(Meshopt, RejectsAFallbackUsedAsData) {
  MeshoptAsset asset = meshopt_grid(4);
  asset.json["bufferViews"][0].erase("extensions");
  expect_refused(asset, ErrorCode::kInvalidContent, "/buffers/1", "no data");
}

TEST(Meshopt, RejectsViolationsOfTheExtension) {
  const std::string element = "/bufferViews/0/extensions/EXT_meshopt_compression";
  const auto refuse = [&](const char* property, const Json& value,
                          ErrorCode code = ErrorCode::kInvalidContent) {
    MeshoptAsset asset = meshopt_grid(4);
    asset.compressed(0)[property] = value;
    expect_refused(asset, code, element + "/" + property);
  };
  for (const char* property : {"buffer", "byteLength", "byteStride", "count", "mode"}) {
    MeshoptAsset asset = meshopt_grid(4);
    asset.compressed(0).erase(property);
    expect_refused(asset, ErrorCode::kInvalidContent, element + "/" + property, "missing");
  }
  for (const Json& wrong : {Json(2), Json(-1), Json("0"), Json(1e30)}) refuse("buffer", wrong);
  for (const Json& wrong : {Json(-4), Json("0"), Json(0.5), Json(1e30)}) {
    refuse("byteOffset", wrong);
    refuse("byteLength", wrong);
  }
  for (const Json& wrong : {Json(0), Json(2), Json(10), Json(260), Json(nullptr)}) {
    refuse("byteStride", wrong);
  }
  for (const Json& wrong : {Json(0), Json(-1), Json(1.5), Json(kMaxGltfBufferBytes)}) {
    refuse("count", wrong);
  }
  for (const Json& wrong : {Json("VERTICES"), Json(0)}) refuse("mode", wrong);
  for (const Json& wrong : {Json("ROT13"), Json(0)}) refuse("filter", wrong);
  refuse("filter", "COLOR", ErrorCode::kUnsupported);

  MeshoptAsset asset = meshopt_grid(4);
  asset.json["bufferViews"][0]["extensions"][kMeshopt] = 7;
  expect_refused(asset, ErrorCode::kInvalidContent, element);
}

TEST(Meshopt, RejectsStridesThatTheModeOrTheFilterDoesNotAllow) {
  const std::string stride = "/bufferViews/0/extensions/EXT_meshopt_compression/byteStride";
  for (const char* filter : {"OCTAHEDRAL", "QUATERNION"}) {
    MeshoptAsset asset = meshopt_grid(4);
    asset.compressed(0)["filter"] = filter;
    expect_refused(asset, ErrorCode::kInvalidContent, stride, filter);
  }
  const std::string indices = "/bufferViews/1/extensions/EXT_meshopt_compression";
  for (const std::size_t wrong : {1u, 3u, 8u}) {
    MeshoptAsset asset = meshopt_grid(4);
    asset.compressed(1)["byteStride"] = wrong;
    expect_refused(asset, ErrorCode::kInvalidContent, indices + "/byteStride");
  }
  MeshoptAsset asset = meshopt_grid(4);
  asset.compressed(1)["filter"] = "EXPONENTIAL";
  expect_refused(asset, ErrorCode::kInvalidContent, indices + "/filter");
  asset = meshopt_grid(4);
  asset.compressed(1)["count"] = 95;
  expect_refused(asset, ErrorCode::kInvalidContent, indices + "/count", "multiple of 3");
}

TEST(Meshopt, RefusesViewsOfAnotherSizeThanTheirData) {
  MeshoptAsset asset = meshopt_grid(4);
  asset.json["bufferViews"][0]["byteLength"] = 25 * 12 + 4;
  expect_refused(asset, ErrorCode::kInvalidContent, "/bufferViews/0/byteLength", "300");
  asset = meshopt_grid(4);
  asset.json["bufferViews"][0]["byteStride"] = 16;
  expect_refused(asset, ErrorCode::kInvalidContent, "/bufferViews/0/byteStride", "12");
}

TEST(Meshopt, RefusesDataBeyondTheBuffer) {
  const std::string element = "/bufferViews/0/extensions/EXT_meshopt_compression";
  MeshoptAsset asset = meshopt_grid(4);
  asset.compressed(0)["byteLength"] = asset.bin.size() + 1;
  expect_refused(asset, ErrorCode::kInvalidContent, element, "beyond buffer 0");
  asset = meshopt_grid(4);
  asset.compressed(0)["byteOffset"] = kMaxGltfBufferBytes;
  expect_refused(asset, ErrorCode::kInvalidContent, element, "beyond buffer 0");
}

TEST(Meshopt, RefusesOtherCodecsByName) {
  const std::string element = "/bufferViews/0/extensions/EXT_meshopt_compression";
  MeshoptAsset asset = meshopt_grid(4);
  asset.bin[0] = '\xa1';
  expect_refused(asset, ErrorCode::kUnsupported, element, "version 1");
  asset.bin[0] = '\xe0';
  expect_refused(asset, ErrorCode::kInvalidContent, element, "mode");
}

TEST(Meshopt, RefusesDamagedData) {
  MeshoptAsset asset = meshopt_grid(15);
  // One byte too long.
  asset.compressed(0)["byteLength"] = asset.compressed(0)["byteLength"].get<std::size_t>() + 1;
  expect_refused(asset, ErrorCode::kInvalidContent,
                 "/bufferViews/0/extensions/EXT_meshopt_compression", "decoded");
}

TEST(Meshopt, RejectsCountsTooLargeForTheBytesBeforeAllocating) {
  for (const std::size_t view : {0u, 1u}) {
    for (const std::uint64_t count : {std::uint64_t{30000}, std::uint64_t{3} << 20,
                                      std::uint64_t{3} << 28, std::uint64_t{3} << 46}) {
      MeshoptAsset asset = meshopt_grid(4);
      asset.compressed(view)["count"] = count;
      asset.json["bufferViews"][view]["byteLength"] = count * (view == 0 ? 12 : 2);
      asset.json["accessors"][view]["count"] = std::min<std::uint64_t>(count, 3u << 20);
      EXPECT_LT(peak_while_refused(asset), 100000u);
      asset.json["accessors"][view]["count"] = 3;
      expect_refused(
          asset, ErrorCode::kInvalidContent,
          "/bufferViews/" + std::to_string(view) + "/extensions/EXT_meshopt_compression/count",
          "compressed bytes");
    }
  }
}

TEST(Meshopt, ReadsTheHighestCompressionOfTheCodecs) {
  // All elements equal: every group of 16 is a code of two bits, every triangle one byte.
  constexpr std::size_t kCount = 256 * 40;
  MeshoptAsset asset;
  const auto vertices = asset.add_compressed(meshopt_vertices(std::string(kCount * 12, '\0'), 12),
                                             kCount, 12, "ATTRIBUTES");
  EXPECT_LT(asset.compressed(vertices)["byteLength"].get<std::size_t>(), kCount * 12 / 64 + 40);
  const auto triangles = asset.add_compressed(meshopt_sequence(Indices(999, 0)), 999, 2, "INDICES");
  asset.place(asset.add_accessor(vertices, GltfBuilder::kFloat, kCount, "VEC3"),
              asset.add_accessor(triangles, GltfBuilder::kUnsignedShort, 999, "SCALAR"));
  EXPECT_EQ(read(asset).meshes.at(0).positions.size(), kCount);
}

// Every byte of the buffer is changed. The reader must always return soon, with any result;
// sanitizers check its accesses.
void expect_corners_in_range(const SceneDescription& scene) {
  for (const MeshDescription& mesh : scene.meshes) {
    for (const Triangle& t : mesh.triangles) {
      for (const std::uint32_t vertex : t) ASSERT_LT(vertex, mesh.positions.size());
    }
  }
}

void expect_survival(const GltfBuilder& asset, std::uint64_t seed) {
  GltfBuilder changed = asset;
  test::Random random(seed);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < asset.bin.size(); ++i) {
    for (const int value : {0, 255, static_cast<int>(random.index(256))}) {
      changed.bin[i] = static_cast<char>(value);
      const auto scene = read_result(changed);
      refused += scene.ok() ? 0 : 1;
      if (scene.ok()) expect_corners_in_range(*scene);
    }
    changed.bin[i] = asset.bin[i];
  }
  EXPECT_GT(refused, 0u);
}

TEST(Meshopt, SurvivesEveryCutAndEveryChangedByte) {
  const MeshoptAsset good = meshopt_grid(5);
  expect_survival(good, 11);
  for (const std::size_t view : {0u, 1u}) {
    const auto length =
        good.json["bufferViews"][view]["extensions"][kMeshopt]["byteLength"].get<std::size_t>();
    for (std::size_t cut = 0; cut < length; ++cut) {
      MeshoptAsset asset = good;
      asset.compressed(view)["byteLength"] = cut;
      EXPECT_FALSE(read_result(asset).ok()) << "view " << view << " cut to " << cut;
    }
  }
}

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kDracoElement =
    "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";

struct DracoOptions {
  int method = draco::MESH_EDGEBREAKER_ENCODING;
  int speed = 5;  // below 5: symbols by valence
  int bits = 0;   // of positions; 0: floats as they are
  bool metadata = false;
};

template <typename T>
void add_draco_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type,
                         draco::DataType data_type, int components, bool normalized,
                         const std::vector<T>& values) {
  const auto count =
      static_cast<std::uint32_t>(values.size() / static_cast<std::size_t>(components));
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, static_cast<std::int8_t>(components), data_type, normalized,
                 components * static_cast<std::int64_t>(sizeof(T)), 0);
  const int id = mesh.AddAttribute(attribute, true, count);
  for (std::uint32_t i = 0; i < count; ++i) {
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                          &values[i * static_cast<std::size_t>(components)]);
  }
}

void add_metadata(draco::Mesh& mesh) {
  auto metadata = std::make_unique<draco::GeometryMetadata>();
  metadata->AddEntryString("name", "grid");
  auto outer = std::make_unique<draco::Metadata>();
  outer->AddSubMetadata("inner", std::make_unique<draco::Metadata>());
  outer->AddEntryInt("answer", 42);
  metadata->AddSubMetadata("outer", std::move(outer));
  metadata->AddSubMetadata("empty", std::make_unique<draco::Metadata>());
  mesh.AddMetadata(std::move(metadata));
  auto of_attribute = std::make_unique<draco::AttributeMetadata>();
  of_attribute->AddEntryInt("unit", 1);
  mesh.AddAttributeMetadata(0, std::move(of_attribute));
}

void add_faces(draco::Mesh& mesh, const Indices& indices) {
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(indices[i]), draco::PointIndex(indices[i + 1]),
                  draco::PointIndex(indices[i + 2])});
  }
}

std::string draco_bytes(draco::Mesh& mesh, const DracoOptions& options) {
  if (options.metadata) add_metadata(mesh);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(options.method);
  encoder.SetSpeedOptions(options.speed, options.speed);
  if (options.bits > 0) {
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, options.bits);
  }
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  return {buffer.data(), buffer.size()};
}

// Attribute 0: positions. Attribute 1: the numbers of the vertices before the encoder moved them.
std::string draco_stream(const Points& points, const Indices& indices,
                         const DracoOptions& options = {}) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(points.size()));
  std::vector<float> coordinates;
  std::vector<std::uint16_t> numbers;
  for (const Eigen::Vector3f& point : points) {
    coordinates.insert(coordinates.end(), point.begin(), point.end());
    numbers.push_back(static_cast<std::uint16_t>(numbers.size()));
  }
  add_draco_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, false,
                      coordinates);
  add_draco_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT16, 1, false, numbers);
  add_faces(mesh, indices);
  return draco_bytes(mesh, options);
}

// One mesh of one primitive: view 0 is the stream, accessors 0 (positions), 1 (numbers) and 2
// (indices) describe what it holds.
GltfBuilder draco_asset(const std::string& stream, std::size_t vertices, std::size_t indices,
                        int mode = 4) {
  GltfBuilder asset;
  asset.json["extensionsUsed"] = {kDraco};
  asset.json["extensionsRequired"] = {kDraco};
  asset.json["accessors"] = {
      {{"componentType", GltfBuilder::kFloat}, {"count", vertices}, {"type", "VEC3"}},
      {{"componentType", GltfBuilder::kUnsignedShort}, {"count", vertices}, {"type", "SCALAR"}},
      {{"componentType", GltfBuilder::kUnsignedInt}, {"count", indices}, {"type", "SCALAR"}}};
  Json primitive = {
      {"attributes", {{"POSITION", 0}, {"_NUMBER", 1}}}, {"indices", 2}, {"mode", mode}};
  primitive["extensions"][kDraco] = {{"bufferView", asset.add_view(stream)},
                                     {"attributes", {{"POSITION", 0}, {"_NUMBER", 1}}}};
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive}))}});
  return asset;
}

GltfBuilder draco_grid(std::size_t n, const DracoOptions& options = {}) {
  const Points points = grid_points(n);
  const Indices indices = grid_indices(n);
  return draco_asset(draco_stream(points, indices, options), points.size(), indices.size());
}

Json& draco_extension(GltfBuilder& asset) {
  return asset.json["meshes"][0]["primitives"][0]["extensions"][kDraco];
}

// The parts of read_gltf()'s state that reading primitives needs.
class OpenAsset {
 public:
  explicit OpenAsset(const GltfBuilder& builder)
      : json_(Json::parse(builder.json.dump())),
        bin_(builder.bin),
        source_(std::span(reinterpret_cast<const std::uint8_t*>(bin_.data()), bin_.size())),
        buffers_({{std::nullopt, bin_.size()}}, source_, GltfRange{0, bin_.size()}, ""),
        views_(json_, buffers_) {
    for (const Json& view : json_["bufferViews"]) {
      tinygltf::BufferView& copy = model_.bufferViews.emplace_back();
      copy.buffer = 0;
      copy.byteOffset = view["byteOffset"];
      copy.byteLength = view["byteLength"];
    }
    for (const Json& accessor : json_["accessors"]) {
      tinygltf::Accessor& copy = model_.accessors.emplace_back();
      copy.componentType = accessor["componentType"];
      copy.count = accessor["count"];
      copy.type = accessor["type"] == "SCALAR" ? TINYGLTF_TYPE_SCALAR : TINYGLTF_TYPE_VEC3;
    }
    const Json& primitive = json_["meshes"][0]["primitives"][0];
    tinygltf::Primitive& copy = model_.meshes.emplace_back().primitives.emplace_back();
    for (const auto& [name, id] : primitive["attributes"].items()) copy.attributes[name] = id;
    copy.indices = primitive["indices"];
    copy.mode = primitive["mode"];
  }

  GltfAsset asset() { return {model_, json_, buffers_, views_}; }

 private:
  Json json_;
  std::string bin_;
  tinygltf::Model model_;
  GltfSource source_;
  GltfBuffers buffers_;
  GltfMeshoptViews views_;
};

// The decoded grid, in its order before encoding.
void expect_draco_grid(const GltfBuilder& builder, std::size_t n, double bound) {
  const Points points = grid_points(n);
  OpenAsset open(builder);
  const GltfAsset asset = open.asset();
  const auto primitive = read_draco_primitive(asset, 0, 0, 1u << 20, 1u << 20);
  ASSERT_TRUE(primitive.ok()) << primitive.error().to_string();
  ASSERT_TRUE(primitive->has_value());
  ASSERT_EQ((*primitive)->vertex_count(), points.size());
  const auto numbers = (*primitive)->attribute("_NUMBER");
  const auto positions = (*primitive)->positions();
  ASSERT_TRUE(numbers.ok() && positions.ok());
  EXPECT_EQ(numbers->components, 1u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 expected = points[static_cast<std::size_t>(numbers->values[i])].cast<double>();
    EXPECT_LE(((*positions)[i] - expected).lpNorm<Eigen::Infinity>(), bound);
  }
  std::vector<Triangle> found;
  const Indices indices = (*primitive)->indices();
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const auto number = [&](std::size_t k) {
      return static_cast<std::uint32_t>(numbers->values[indices[i + k]]);
    };
    found.push_back(from_smallest({number(0), number(1), number(2)}));
  }
  std::vector<Triangle> expected;
  const Indices source = grid_indices(n);
  for (std::size_t i = 0; i < source.size(); i += 3) {
    expected.push_back(from_smallest({source[i], source[i + 1], source[i + 2]}));
  }
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);

  const auto scene = read(builder);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].positions, *positions);
  expect_triangles(scene.meshes[0].triangles, indices);
  EXPECT_TRUE(scene.warnings.empty());
}

// A number in the stream's variable-length encoding: seven bits a byte, lowest first; the top bit
// of all bytes except the last is set.
std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value > 0x7f; value >>= 7) bytes += static_cast<char>((value & 0x7f) | 0x80);
  return bytes + static_cast<char>(value);
}

constexpr DracoOptions kMethods[] = {{draco::MESH_SEQUENTIAL_ENCODING, 5},
                                     {draco::MESH_SEQUENTIAL_ENCODING, 10},
                                     {draco::MESH_EDGEBREAKER_ENCODING, 5},
                                     {draco::MESH_EDGEBREAKER_ENCODING, 0}};

TEST(Draco, ReadsEveryMethodToTheBitsItKeeps) {
  for (DracoOptions options : kMethods) {
    for (const int bits : {0, 8, 11, 16}) {
      options.bits = bits;
      // The longest edge of the box is 1. Half a step, and the rounding of floats below 1.
      const double bound =
          bits == 0 ? 0.0 : 0.5 / static_cast<double>((1 << bits) - 1) + 2.0 * 0x1p-23;
      for (const std::size_t n : {1u, 5u, 30u}) expect_draco_grid(draco_grid(n, options), n, bound);
    }
  }
}

TEST(Draco, SkipsMetadata) {
  for (DracoOptions options : kMethods) {
    options.metadata = true;
    const GltfBuilder asset = draco_grid(5, options);
    ASSERT_NE(asset.bin.find("inner"), std::string::npos);
    expect_draco_grid(asset, 5, 0.0);
  }
}

TEST(Draco, KeepsNothingOfTheMetadata) {
  // 20,000 attributes with an id each, without entries and nested blocks, before a valid stream.
  GltfBuilder asset = draco_grid(5);
  std::string metadata = varint(20000) + std::string(3 * 20000, '\0') + varint(0) + varint(0);
  asset.bin[10] = '\x80';
  asset.bin.insert(11, metadata);
  asset.json["bufferViews"][0]["byteLength"] = asset.bin.size();
  const std::string bytes = glb_bytes(asset);
  const std::size_t before = live_bytes;
  peak_bytes = before;
  EXPECT_TRUE(read_bytes(bytes).ok());
  EXPECT_LT(peak_bytes - before, 200000u);
}

TEST(Draco, ReadsAStripAsTheDecodedList) {
  const Points points = grid_points(5);
  const Indices indices = grid_indices(5);
  const std::string stream = draco_stream(points, indices);
  const auto list = read(draco_asset(stream, points.size(), indices.size()));
  for (const std::size_t count : {indices.size(), indices.size() / 3 + 2}) {
    const auto strip = read(draco_asset(stream, points.size(), count, 5));
    EXPECT_EQ(strip.meshes.at(0).triangles, list.meshes.at(0).triangles);
    EXPECT_EQ(strip.meshes.at(0).positions, list.meshes.at(0).positions);
  }
  const auto odd = read(draco_asset(stream, points.size(), indices.size() / 3 + 1, 5));
  EXPECT_EQ(odd.meshes.at(0).triangles, list.meshes.at(0).triangles);
  ASSERT_EQ(odd.warnings.size(), 1u);
  EXPECT_NE(odd.warnings[0].find("50 triangles"), std::string::npos) << odd.warnings[0];
}

TEST(Draco, DecodesEvenIfAFallbackIsPresent) {
  GltfBuilder asset = draco_grid(4);
  asset.json.erase("extensionsRequired");
  const std::size_t zeros = asset.add_view(std::string(25 * 12, '\0'));
  const std::size_t noise = asset.add_view(std::string(96 * 4, '\x7f'));
  asset.json["accessors"][0]["bufferView"] = zeros;
  asset.json["accessors"][2]["bufferView"] = noise;
  expect_draco_grid(asset, 4, 0.0);
}

TEST(Draco, ReadsQuantisedPositions) {
  const std::vector<std::uint16_t> stored = {0, 0, 0, 65535, 0, 0, 0, 65535, 13107};
  draco::Mesh mesh;
  mesh.set_num_points(3);
  add_draco_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_UINT16, 3, true, stored);
  add_faces(mesh, {0, 1, 2});
  GltfBuilder asset = draco_asset(draco_bytes(mesh, {draco::MESH_SEQUENTIAL_ENCODING, 5}), 3, 3);
  draco_extension(asset)["attributes"].erase("_NUMBER");
  asset.json["accessors"][0]["componentType"] = GltfBuilder::kUnsignedShort;
  asset.json["accessors"][0]["normalized"] = true;
  expect_refused(asset, ErrorCode::kInvalidContent, "/accessors/0/componentType");
  asset.json["extensionsUsed"].push_back("KHR_mesh_quantization");
  GltfBuilder signed_asset = asset;
  signed_asset.json["accessors"][0]["componentType"] = GltfBuilder::kShort;
  expect_refused(signed_asset, ErrorCode::kInvalidContent,
                 std::string(kDracoElement) + "/attributes/POSITION", "another type");
  const auto scene = read(asset);
  ASSERT_EQ(scene.meshes.at(0).positions.size(), 3u);
  const std::vector<Vec3> expected = {{0, 0, 0}, {1, 0, 0}, {0, 1, 13107.0 / 65535.0}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Triangle& t = scene.meshes[0].triangles.at(0);
    EXPECT_EQ(scene.meshes[0].positions[t[i]], expected[i]);
  }
}

TEST(Draco, ReadsPositionsThatAreNotCompressedThemselves) {
  const Points points = grid_points(3);
  const Indices indices = grid_indices(3);
  // This method keeps the order of the vertices.
  GltfBuilder asset =
      draco_asset(draco_stream(points, indices, {draco::MESH_SEQUENTIAL_ENCODING, 10}),
                  points.size(), indices.size());
  draco_extension(asset)["attributes"].erase("POSITION");
  asset.json["accessors"][0]["bufferView"] = asset.add_view(test::bytes_of(points));
  const auto scene = read(asset);
  expect_positions(scene.meshes.at(0).positions, points);
  expect_triangles(scene.meshes.at(0).triangles, indices);
  asset.json["accessors"][0]["count"] = points.size() - 1;
  expect_refused(asset, ErrorCode::kInvalidContent, "/meshes/0/primitives/0/attributes/POSITION");
}

TEST(CompressedSeeds, OfTheFuzzTargetAreValid) {
  for (const auto& [name, bytes] : test::compressed_gltf_seeds()) {
    SCOPED_TRACE(name);
    const auto scene = read_bytes(bytes);
    ASSERT_TRUE(scene.ok()) << scene.error().to_string();
    EXPECT_EQ(scene->meshes.at(0).triangles.size(), 4u);
    EXPECT_EQ(scene->meshes.at(0).positions.size(), 4u);
  }
}

// A grid of which every second vertex moves up with its joint, the others down.
struct SkinnedGrid {
  Points points = grid_points(4);
  Indices indices = grid_indices(4);

  // Joints of the stream, of any integer type. first_joint: the number of the upper joint.
  template <typename Joint>
  std::string stream(int method, draco::DataType joint_type, Joint first_joint = 0) const {
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<std::uint32_t>(points.size()));
    std::vector<float> coordinates;
    std::vector<Joint> joints;
    std::vector<float> weights;
    for (std::size_t v = 0; v < points.size(); ++v) {
      coordinates.insert(coordinates.end(), points[v].begin(), points[v].end());
      joints.insert(joints.end(), {static_cast<Joint>(first_joint + static_cast<Joint>(v % 2)),
                                   Joint{0}, Joint{0}, Joint{0}});
      weights.insert(weights.end(), {1.0f, 0.0f, 0.0f, 0.0f});
    }
    add_draco_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, false,
                        coordinates);
    add_draco_attribute(mesh, draco::GeometryAttribute::GENERIC, joint_type, 4, false, joints);
    add_draco_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_FLOAT32, 4, false,
                        weights);
    add_faces(mesh, indices);
    return draco_bytes(mesh, {.method = method});
  }

  // joint_type: of the accessor. declared: the number of vertices according to the accessors.
  GltfBuilder asset(const std::string& stream, int joint_type, std::size_t declared,
                    std::size_t declared_indices) const {
    GltfBuilder asset = draco_asset(stream, declared, declared_indices);
    asset.json["accessors"][1] = {
        {"componentType", joint_type}, {"count", declared}, {"type", "VEC4"}};
    asset.json["accessors"].push_back(
        {{"componentType", GltfBuilder::kFloat}, {"count", declared}, {"type", "VEC4"}});
    const Json attributes = {{"POSITION", 0}, {"JOINTS_0", 1}, {"WEIGHTS_0", 3}};
    asset.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    draco_extension(asset)["attributes"] = {{"POSITION", 0}, {"JOINTS_0", 1}, {"WEIGHTS_0", 2}};
    asset.add_node({{"translation", {0, 0, 8}}});
    asset.add_node({{"translation", {0, 0, -8}}});
    asset.json["skins"] = {{{"joints", {1, 2}}}};
    asset.json["nodes"][0]["skin"] = 0;
    return asset;
  }

  void expect_posed(const SceneDescription& scene) const {
    ASSERT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.meshes[0].positions.size(), points.size());
    EXPECT_EQ(3 * scene.meshes[0].triangles.size(), indices.size());
    for (const Vec3& posed : scene.meshes[0].positions) {
      const auto original =
          std::find_if(points.begin(), points.end(), [&](const Eigen::Vector3f& p) {
            return double{p.x()} == posed.x() && double{p.y()} == posed.y();
          });
      ASSERT_NE(original, points.end());
      const double shift = (original - points.begin()) % 2 == 0 ? 8.0 : -8.0;
      EXPECT_EQ(posed.z(), double{original->z()} + shift);
    }
  }
};

constexpr int kBothMethods[] = {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING};

TEST(Draco, PosesCompressedSkins) {
  const SkinnedGrid grid;
  for (const int method : kBothMethods) {
    const std::string stream = grid.stream<std::uint16_t>(method, draco::DT_UINT16);
    const auto scene = read(
        grid.asset(stream, GltfBuilder::kUnsignedShort, grid.points.size(), grid.indices.size()));
    grid.expect_posed(scene);
    EXPECT_TRUE(scene.warnings.empty());
  }
}

TEST(Draco, ConvertsIntegersToTheTypeOfTheAccessor) {
  const SkinnedGrid grid;
  for (const int method : kBothMethods) {
    for (const std::string& stream : {grid.stream<std::uint8_t>(method, draco::DT_UINT8),
                                      grid.stream<std::int8_t>(method, draco::DT_INT8),
                                      grid.stream<std::uint16_t>(method, draco::DT_UINT16),
                                      grid.stream<std::int16_t>(method, draco::DT_INT16),
                                      grid.stream<std::uint32_t>(method, draco::DT_UINT32),
                                      grid.stream<std::int32_t>(method, draco::DT_INT32)}) {
      for (const int type : {GltfBuilder::kUnsignedByte, GltfBuilder::kUnsignedShort}) {
        const auto scene = read(grid.asset(stream, type, grid.points.size(), grid.indices.size()));
        grid.expect_posed(scene);
        EXPECT_TRUE(scene.warnings.empty());
      }
    }
  }
}

// For example, out-of-range joints would be read with wrapped values.
TEST(Draco, RejectsIntegersOutOfRangeOfTheAccessorsType) {
  const SkinnedGrid grid;
  for (const int method : kBothMethods) {
    for (const std::string& stream : {grid.stream<std::uint16_t>(method, draco::DT_UINT16, 255),
                                      grid.stream<std::uint32_t>(method, draco::DT_UINT32, 255),
                                      grid.stream<std::int8_t>(method, draco::DT_INT8, -1),
                                      grid.stream<std::int32_t>(method, draco::DT_INT32, -256)}) {
      expect_refused(
          grid.asset(stream, GltfBuilder::kUnsignedByte, grid.points.size(), grid.indices.size()),
          ErrorCode::kInvalidContent, std::string(kDracoElement) + "/attributes/JOINTS_0",
          "do not fit");
    }
  }
}

TEST(Draco, DividesNormalisedIntegersByTheLargestOfTheAccessorsTypeWithAWarning) {
  const std::vector<std::uint8_t> stored = {0, 0, 0, 255, 0, 0, 0, 255, 51};
  draco::Mesh mesh;
  mesh.set_num_points(3);
  add_draco_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_UINT8, 3, true, stored);
  add_faces(mesh, {0, 1, 2});
  GltfBuilder asset = draco_asset(draco_bytes(mesh, {}), 3, 3);
  draco_extension(asset)["attributes"].erase("_NUMBER");
  asset.json["extensionsUsed"].push_back("KHR_mesh_quantization");
  asset.json["accessors"][0]["componentType"] = GltfBuilder::kUnsignedShort;
  asset.json["accessors"][0]["normalized"] = true;
  const auto scene = read(asset);
  ASSERT_EQ(scene.meshes.at(0).positions.size(), 3u);
  const Triangle& t = scene.meshes[0].triangles.at(0);
  EXPECT_EQ(scene.meshes[0].positions[t[1]], Vec3(255.0 / 65535.0, 0, 0));
  EXPECT_EQ(scene.meshes[0].positions[t[2]], Vec3(0, 255.0 / 65535.0, 51.0 / 65535.0));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("attributes/POSITION"), std::string::npos) << scene.warnings[0];
}

TEST(Draco, KeepsTheMaterialOfEachPrimitive) {
  GltfBuilder asset = draco_grid(3);
  asset.json["materials"] = {Json::object(), Json::object()};
  Json& primitives = asset.json["meshes"][0]["primitives"];
  primitives[0]["material"] = 1;
  primitives.push_back(primitives[0]);
  primitives[1]["material"] = 0;
  const auto scene = read(asset);
  const auto& runs = scene.meshes.at(0).material_runs;
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].first_triangle, 0u);
  EXPECT_EQ(runs[1].first_triangle, 18u);
  EXPECT_NE(runs[0].material, runs[1].material);
}

// Real exporters count before or after the codec has split vertices or dropped triangles.
TEST(Draco, UsesTheNumbersOfTheStreamWithAWarningIfTheAccessorsDiffer) {
  for (const DracoOptions& options : kMethods) {
    const auto plain = read(draco_grid(5, options));
    for (const int vertices : {1, 35, 36, 37, 3600}) {
      for (const int indices : {3, 147, 149, 150, 153, 15000}) {
        GltfBuilder asset = draco_grid(5, options);
        asset.json["accessors"][0]["count"] = vertices;
        asset.json["accessors"][1]["count"] = vertices;
        asset.json["accessors"][2]["count"] = indices;
        const auto scene = read(asset);
        EXPECT_EQ(scene.meshes.at(0).positions, plain.meshes.at(0).positions);
        EXPECT_EQ(scene.meshes.at(0).triangles, plain.meshes.at(0).triangles);
        if (vertices == 36 && indices == 150) {
          EXPECT_TRUE(scene.warnings.empty());
          continue;
        }
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_NE(scene.warnings[0].find("36 vertices and 50 triangles"), std::string::npos)
            << scene.warnings[0];
      }
    }
  }
}

// The accessor's type cannot represent the larger indices; the indices of the stream are used.
TEST(Draco, UsesTheIndicesOfTheStreamForAnyTypeOfTheirAccessor) {
  for (const DracoOptions& options : kMethods) {
    GltfBuilder asset = draco_grid(20, options);
    for (const int type : {GltfBuilder::kUnsignedByte, GltfBuilder::kUnsignedShort}) {
      asset.json["accessors"][2]["componentType"] = type;
      expect_draco_grid(asset, 20, 0.0);
      EXPECT_EQ(read(asset).meshes.at(0).triangles.size(), 800u);
    }
  }
}

TEST(Draco, RefusesAccessorsThatDisagreeWithEachOther) {
  for (const DracoOptions& options : kMethods) {
    for (const int change : {-1, 1}) {
      GltfBuilder asset = draco_grid(5, options);
      asset.json["accessors"][1]["count"] = 36 + change;
      expect_refused(asset, ErrorCode::kInvalidContent, "/accessors/1/count");
    }
  }
}

TEST(Draco, PosesAsManyVerticesAsTheStreamHas) {
  const SkinnedGrid grid;
  for (const int method : kBothMethods) {
    const std::string stream = grid.stream<std::uint8_t>(method, draco::DT_UINT8);
    for (const std::size_t declared : {std::size_t{3}, std::size_t{400}}) {
      GltfBuilder asset = grid.asset(stream, GltfBuilder::kUnsignedShort, declared, 3 * declared);
      const auto scene = read(asset);
      grid.expect_posed(scene);
      EXPECT_EQ(scene.warnings.size(), 1u);

      // Uncompressed attributes must match the stream, not the accessors that it overrides.
      const std::size_t count = grid.points.size();
      const std::vector<float> up(3 * count, 1.0f);
      const std::size_t target = asset.add_accessor(asset.add_view(test::bytes_of(up)),
                                                    GltfBuilder::kFloat, count, "VEC3");
      asset.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
      asset.json["meshes"][0]["weights"] = {1.0};
      EXPECT_EQ(read(asset).meshes.at(0).positions.size(), count);
      asset.json["accessors"][target]["count"] = count - 1;
      expect_refused(asset, ErrorCode::kInvalidContent, "/meshes/0/primitives/0/targets/0/POSITION",
                     "25 vertices");
    }
  }
}

TEST(Draco, AppliesLimitsToTheNumbersOfTheStream) {
  for (const DracoOptions& options : kMethods) {
    GltfBuilder builder = draco_grid(5, options);
    for (const std::size_t accessor : {0u, 1u, 2u})
      builder.json["accessors"][accessor]["count"] = 3;
    OpenAsset open(builder);
    const auto expect_limit = [&](std::size_t vertices, std::size_t triangles, const char* text) {
      const auto primitive = read_draco_primitive(open.asset(), 0, 0, vertices, triangles);
      ASSERT_FALSE(primitive.ok());
      EXPECT_EQ(primitive.error().code, ErrorCode::kLimitExceeded);
      EXPECT_NE(primitive.error().problem.find(text), std::string::npos)
          << primitive.error().to_string();
    };
    expect_limit(36, 49, "50 triangles");
    expect_limit(35, 50, "36 vertices");
    EXPECT_TRUE(read_draco_primitive(open.asset(), 0, 0, 36, 50).ok());
  }
}

// Repeated values take almost no space in a stream. Accessors may declare a large size; beyond it,
// the decoded size is limited by the length of the stream.
TEST(Draco, BoundsTheDecodedSizeBeyondTheAccessors) {
  constexpr std::size_t kSide = 300;
  const Indices indices = grid_indices(kSide);
  const std::size_t vertices = (kSide + 1) * (kSide + 1);
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(vertices));
  add_draco_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, false,
                      std::vector<float>(3 * vertices, 0.0f));
  add_faces(mesh, indices);
  const std::string stream = draco_bytes(mesh, {.bits = 8});
  const auto asset_of = [&](std::size_t declared, std::size_t declared_indices) {
    GltfBuilder asset = draco_asset(stream, declared, declared_indices);
    draco_extension(asset)["attributes"].erase("_NUMBER");
    return asset;
  };
  const std::size_t decoded = 12 * vertices + 4 * indices.size();
  ASSERT_GT(decoded, kDracoUndeclaredBytes + kDracoUndeclaredFactor * stream.size());
  ASSERT_LE(decoded, kMaxDracoExpansion * stream.size());
  EXPECT_EQ(read(asset_of(vertices, indices.size())).meshes.at(0).positions.size(), vertices);
  const GltfBuilder lying = asset_of(3, 3);
  EXPECT_LT(peak_while_refused(lying), kDracoWorkingBytes + (std::size_t{8} << 20));
  expect_refused(lying, ErrorCode::kLimitExceeded, kDracoElement, "far more than the");
}

TEST(Draco, RefusesTypesThatDifferFromTheStream) {
  const auto refuse = [](std::size_t accessor, const char* property, const Json& value,
                         const std::string& element) {
    GltfBuilder asset = draco_grid(3);
    asset.json["accessors"][accessor][property] = value;
    expect_refused(asset, ErrorCode::kInvalidContent, element);
  };
  refuse(0, "type", "VEC2", "/accessors/0/type");
  refuse(0, "componentType", GltfBuilder::kShort, "/accessors/0/componentType");
  refuse(2, "type", "VEC2", "/accessors/2/type");
  refuse(2, "componentType", GltfBuilder::kFloat, "/accessors/2/componentType");
  // An attribute with the id of another one.
  GltfBuilder asset = draco_grid(3);
  draco_extension(asset)["attributes"]["POSITION"] = 1;
  expect_refused(asset, ErrorCode::kInvalidContent,
                 std::string(kDracoElement) + "/attributes/POSITION", "another type");
}

TEST(Draco, RejectsViolationsOfTheExtension) {
  const std::string element = kDracoElement;
  const auto refuse = [&](const Json::json_pointer& pointer, const Json& value,
                          const std::string& where) {
    GltfBuilder asset = draco_grid(3);
    draco_extension(asset)[pointer] = value;
    expect_refused(asset, ErrorCode::kInvalidContent, where);
  };
  for (const Json& wrong : {Json(1), Json(-1), Json("0"), Json(0.5)}) {
    refuse(Json::json_pointer("/bufferView"), wrong, element + "/bufferView");
  }
  for (const Json& wrong : {Json(-1), Json("0"), Json(0.5), Json(std::uint64_t{1} << 32)}) {
    refuse(Json::json_pointer("/attributes/POSITION"), wrong, element + "/attributes/POSITION");
  }
  for (const Json& wrong : {Json(0), Json::array(), Json::object()}) {
    refuse(Json::json_pointer("/attributes"), wrong, element + "/attributes");
  }
  refuse(Json::json_pointer("/attributes/POSITION"), 2, element + "/attributes/POSITION");
  refuse(Json::json_pointer("/attributes/NORMAL"), 1, element + "/attributes/NORMAL");
  for (const char* property : {"bufferView", "attributes"}) {
    GltfBuilder asset = draco_grid(3);
    draco_extension(asset).erase(property);
    expect_refused(asset, ErrorCode::kInvalidContent, element + "/" + property, "missing");
  }
  GltfBuilder asset = draco_grid(3);
  asset.json["meshes"][0]["primitives"][0].erase("indices");
  expect_refused(asset, ErrorCode::kInvalidContent, "/meshes/0/primitives/0/indices");
  asset = draco_grid(3);
  asset.json["meshes"][0]["primitives"][0]["mode"] = 6;
  expect_refused(asset, ErrorCode::kInvalidContent, "/meshes/0/primitives/0/mode");
  asset = draco_grid(3);
  draco_extension(asset) = 7;
  expect_refused(asset, ErrorCode::kInvalidContent, element);
  asset = draco_grid(3);
  const Json part = {{"bufferView", 0}, {"componentType", GltfBuilder::kUnsignedShort}};
  asset.json["accessors"][0]["sparse"] = {{"count", 1}, {"indices", part}, {"values", part}};
  expect_refused(asset, ErrorCode::kUnsupported, "/accessors/0/sparse");
}

TEST(Draco, RefusesPositionsThatAreNotFinite) {
  Points points = grid_points(3);
  points[5].y() = std::numeric_limits<float>::infinity();
  const Indices indices = grid_indices(3);
  expect_refused(draco_asset(draco_stream(points, indices), points.size(), indices.size()),
                 ErrorCode::kInvalidContent, kDracoElement, "not finite");
}

TEST(Draco, RefusesOtherStreamsByName) {
  const auto refuse = [](std::size_t byte, int value, ErrorCode code, const std::string& text) {
    GltfBuilder asset = draco_grid(3);
    asset.bin[byte] = static_cast<char>(value);
    expect_refused(asset, code, kDracoElement, text);
  };
  refuse(0, 'd', ErrorCode::kInvalidContent, "begin");
  refuse(5, 0, ErrorCode::kUnsupported, "version 0.2");
  refuse(5, 3, ErrorCode::kUnsupported, "version 3.2");
  refuse(6, 3, ErrorCode::kUnsupported, "version 2.3");
  refuse(7, 0, ErrorCode::kInvalidContent, "cloud");
  refuse(8, 2, ErrorCode::kUnsupported, "method 2");
}

std::string draco_header(int method) {
  return std::string("DRACO") + '\x02' + '\x02' + '\x01' + static_cast<char>(method) +
         std::string(2, '\0');
}

std::string edgebreaker_stream(std::uint64_t vertices, std::uint64_t faces, int tables,
                               std::uint64_t splits, std::size_t padding) {
  return draco_header(1) + '\0' + varint(vertices) + varint(faces) + static_cast<char>(tables) +
         varint(faces) + varint(splits) + std::string(padding, '\0');
}

TEST(Draco, RejectsCountsTooLargeForTheBytesBeforeAllocating) {
  for (const std::uint64_t faces : {std::uint64_t{100000}, std::uint64_t{10000000}}) {
    for (const std::string& stream :
         {edgebreaker_stream(faces / 2, faces, 0, 0, 100),
          draco_header(0) + varint(faces) + varint(faces / 2) + std::string(100, '\0')}) {
      const GltfBuilder asset = draco_asset(stream, faces / 2, 3 * faces);
      EXPECT_LT(peak_while_refused(asset), 100000u);
      expect_refused(asset, ErrorCode::kLimitExceeded, kDracoElement, "times as many");
    }
  }
}

TEST(Draco, RejectsCountsThatDifferFromTheAccessorsBeforeAllocating) {
  constexpr std::uint64_t kMany = 50000000;
  for (const std::string& stream :
       {edgebreaker_stream(kMany, 50, 0, 50, 1000), edgebreaker_stream(kMany, kMany, 0, 0, 1000),
        edgebreaker_stream(36, 50, 0, kMany, 1000),
        edgebreaker_stream(0xffffffffu, 50, 0, 50, 1000),
        draco_header(0) + varint(kMany) + varint(36) + std::string(1000, '\0'),
        draco_header(0) + varint(50) + varint(kMany) + std::string(1000, '\0')}) {
    EXPECT_LT(peak_while_refused(draco_asset(stream, 36, 150)), 100000u);
  }
}

TEST(Draco, BoundsTheMemoryOfConnectivitiesAndAttributes) {
  // As many connectivities as the format can count, with too many triangles for that number.
  constexpr std::uint64_t kFaces = 20000;
  const std::string tables = edgebreaker_stream(kFaces / 2, kFaces, 255, 0, 20000);
  const GltfBuilder asset = draco_asset(tables, kFaces / 2, 3 * kFaces);
  EXPECT_LT(peak_while_refused(asset), 1000000u);
  expect_refused(asset, ErrorCode::kInvalidContent, kDracoElement, "bytes of memory");

  // Valid triangles, and attributes of 127 doubles each that no accessor describes.
  constexpr std::uint64_t kVertices = 3000;
  std::string stream = draco_header(0) + varint(kVertices) + varint(kVertices) + '\x01' +
                       std::string(3 * kVertices * sizeof(std::uint16_t), '\0');
  stream += '\x01' + varint(20);
  for (char id = 0; id < 20; ++id) {
    stream += std::string("\x04\x0a\x7f\0", 4) + id;
  }
  stream += std::string(20, '\0') + std::string(20000, '\0');
  const GltfBuilder wide = draco_asset(stream, kVertices, 3 * kVertices);
  EXPECT_LT(peak_while_refused(wide), 1000000u);
  expect_refused(wide, ErrorCode::kInvalidContent, kDracoElement, "bytes of memory");
}

TEST(Draco, KeepsHostileStreamsBelowTheDocumentedMemory) {
  // As much as the accessors may describe for the stream's length; no data follow the counts.
  constexpr std::uint64_t kFaces = 2000000;
  constexpr std::uint64_t kDescribed = 12 * kFaces + (12 + 2) * kFaces / 2;
  const std::string stream =
      edgebreaker_stream(kFaces / 2, kFaces, 0, kFaces, kDescribed / kMaxDracoExpansion);
  EXPECT_LT(peak_while_refused(draco_asset(stream, kFaces / 2, 3 * kFaces)),
            (64u << 20) + 40 * kDescribed);
}

TEST(Draco, RejectsEndlessMetadata) {
  std::string header = draco_header(1);
  header[10] = '\x80';
  for (const std::string& metadata : {varint(0xffffffffu), varint(0) + varint(0xffffffffu),
                                      varint(0) + varint(0) + varint(0xffffffffu),
                                      varint(0) + varint(1) + "\x01x" + varint(0xffffffffu),
                                      varint(0) + varint(0) + varint(1) + "\xff" + "x"}) {
    const GltfBuilder asset = draco_asset(header + metadata + std::string(100, '\0'), 36, 150);
    EXPECT_LT(peak_while_refused(asset), 100000u);
  }
}

TEST(Draco, BoundsTheVerticesAndTrianglesOfTheScene) {
  GltfBuilder asset = draco_grid(3);
  for (const std::size_t accessor : {0u, 1u}) {
    asset.json["accessors"][accessor]["count"] = kMaxGltfVertices + 1;
  }
  expect_refused(asset, ErrorCode::kLimitExceeded, "/meshes/0/primitives/0");
  asset = draco_grid(3);
  asset.json["accessors"][2]["count"] = 3 * (kMaxGltfTriangles + 1);
  expect_refused(asset, ErrorCode::kLimitExceeded, "/meshes/0/primitives/0");
  asset.json["accessors"][2]["count"] = std::uint64_t{1} << 53;
  expect_refused(asset, ErrorCode::kLimitExceeded, "/accessors/2/count");
}

TEST(Draco, SurvivesEveryCutAndEveryChangedByte) {
  for (DracoOptions options : kMethods) {
    options.bits = 8;
    options.metadata = true;
    const GltfBuilder good = draco_grid(3, options);
    expect_survival(good, 13);
    for (std::size_t cut = 0; cut < good.bin.size(); ++cut) {
      GltfBuilder asset = good;
      asset.json["bufferViews"][0]["byteLength"] = cut;
      // The decoder does not need the last bytes of every stream.
      if (cut + 8 < good.bin.size()) {
        EXPECT_FALSE(read_result(asset).ok()) << "cut to " << cut;
      } else {
        (void)read_result(asset);
      }
    }
  }
}

}  // namespace
}  // namespace palpate
