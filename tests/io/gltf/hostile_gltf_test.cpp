// Hostile files: each must be refused with the right error, or read without its harmful parts, with
// memory in proportion to its size. Files that are merely invalid are tested in gltf_test.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string>
#include <sys/stat.h>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/base64.h"
#include "io/gltf/byte_ranges.h"
#include "io/gltf/file.h"
#include "io/gltf/json_scan.h"
#include "io/gltf/limits.h"
#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/gltf_seeds.h"
#include "tests/helpers/peak_memory.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::GltfBuilder;
using test::TemporaryFolder;

// The memory that reading may use. The documented limit is 64 MiB for the whole process.
constexpr std::size_t kBaseBytes = std::size_t{32} << 20;
constexpr std::size_t kBytesPerByte = 40;
// An element, such as a node, may have a text of two bytes, so elements have a separate allowance.
constexpr std::size_t kBytesPerElement = 2048;

struct Outcome {
  Result<SceneDescription> scene;
  std::size_t peak_bytes = 0;
};

// Reads an asset in memory, whose external files lie in the folder.
Outcome read_measured(const std::string& file, const std::string& folder) {
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(file.data()),
                                            file.size());
  const test::PeakMemory memory;
  auto scene = read_gltf_bytes(bytes, folder, "hostile");
  return {std::move(scene), memory.bytes()};
}

void expect_modest(const Outcome& outcome, const std::string& file, std::size_t elements = 0) {
  EXPECT_LE(outcome.peak_bytes,
            kBaseBytes + kBytesPerByte * file.size() + kBytesPerElement * elements);
}

void expect_refused(const std::string& file, ErrorCode code, const std::string& element,
                    std::size_t elements = 0) {
  const Outcome outcome = read_measured(file, "/nowhere");
  expect_modest(outcome, file, elements);
  ASSERT_FALSE(outcome.scene.ok()) << "accepted; expected an error at " << element;
  const Error& error = outcome.scene.error();
  EXPECT_EQ(static_cast<int>(error.code), static_cast<int>(code)) << error.to_string();
  EXPECT_EQ(error.element, element) << error.to_string();
  EXPECT_EQ(error.path, "hostile");
  EXPECT_FALSE(error.problem.empty());
}

void expect_invalid(const std::string& file, const std::string& element, std::size_t elements = 0) {
  expect_refused(file, ErrorCode::kInvalidContent, element, elements);
}

SceneDescription read_or_fail(const std::string& file) {
  Outcome outcome = read_measured(file, "/nowhere");
  expect_modest(outcome, file);
  EXPECT_TRUE(outcome.scene.ok()) << (outcome.scene.ok() ? "" : outcome.scene.error().to_string());
  return outcome.scene.ok() ? std::move(*outcome.scene) : SceneDescription{};
}

// One triangle whose JSON has this text before its last brace.
std::string triangle_with(const std::string& json_text) {
  std::string text = GltfBuilder::one_triangle().data_uri_text();
  return text.replace(text.size() - 1, 1, "," + json_text + "}");
}

std::string repeated(const std::string& text, std::size_t times) {
  std::string result;
  result.reserve(text.size() * times);
  for (std::size_t i = 0; i < times; ++i) result += text;
  return result;
}

// A list of count elements.
std::string list_of(const std::string& element, std::size_t count) {
  return "[" + element + repeated("," + element, count - 1) + "]";
}

const std::string kAsset = R"("asset":{"version":"2.0"})";

// --- Files that are judged before they are read --------------------------------------------------

constexpr std::uintmax_t kLargeBytes = std::uintmax_t{900} << 20;

// Writes a file of kLargeBytes that begins and ends with the given bytes, and zeros between them.
std::string write_large(const TemporaryFolder& folder, const std::string& name,
                        const std::string& start, const std::string& end = {}) {
  const std::string path = folder.write(name, start);
  std::filesystem::resize_file(path, kLargeBytes - end.size());
  std::FILE* file = std::fopen(path.c_str(), "ab");
  std::fwrite(end.data(), 1, end.size(), file);
  std::fclose(file);
  return path;
}

// The beginning of a GLB of kLargeBytes with a JSON chunk.
std::string glb_start(std::uint32_t version, std::uint32_t length, std::uint32_t json_length,
                      const std::string& type) {
  return "glTF" + test::bytes_of(std::vector<std::uint32_t>{version, length, json_length}) + type;
}

// Reads a file, and expects an error with this text and almost no memory.
void expect_refused_unread(const std::string& path, const std::string& text) {
  SCOPED_TRACE(text);
  constexpr std::size_t kAlmostNone = std::size_t{1} << 20;
  const test::PeakMemory memory;
  const auto scene = read_gltf(path);
  EXPECT_LT(memory.bytes(), kAlmostNone);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().to_string().find(text), std::string::npos) << scene.error().to_string();
}

TEST(HostileGltf, LargeFilesThatAreNoGltfAreRefusedByTheirFirstBytes) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& start, const std::string& text) {
    expect_refused_unread(write_large(folder, "large", start), text);
  };
  constexpr auto kLength = static_cast<std::uint32_t>(kLargeBytes);
  refuse("PK\x03\x04", "ZIP archive");
  refuse("\x89PNG\r\n\x1a\n", "PNG image");
  refuse("# cube\nv 0 0 1\nvn 0 0 1\n", "OBJ file");
  refuse("solid a\nfacet normal 0 0 1\n", "STL file");
  refuse("  <!DOCTYPE HTML>\n<html>", "HTML page");
  refuse("version https://git-lfs.github.com/spec/v1\n", "Git LFS pointer");
  refuse("[{}]", "JSON array");
  refuse("unknown", "begins neither like");
  refuse(glb_start(1, kLength, 100, "JSON"), "version is 1");
  refuse(glb_start(2, kLength - 4, 100, "JSON"), "GLB header: its length");
  refuse(glb_start(2, kLength, kLength, "JSON"), "GLB chunk 0: its length");
  refuse(glb_start(2, kLength, kLength - 20, "JSON"), "JSON: has");
  refuse(glb_start(2, kLength, kLength - 20, "BIN "), "GLB chunk 0: is not of type JSON");
  refuse("{\"asset\":{}}  ", "JSON: has");
}

TEST(HostileGltf, LongTextsAreJudgedByTheirEnds) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& text, const std::string& expected) {
    expect_refused_unread(folder.write("a.gltf", text), expected);
  };
  const std::string spaces(std::size_t{64} << 20, ' ');
  refuse(spaces, "begins neither like");
  refuse(spaces + "x}", "is neither a space nor one of {");
  refuse("{" + spaces + "1}", "is neither a space nor one of \"}");
  refuse("{\"asset\": " + spaces + "\"2.0", "does not end with }");
}

TEST(HostileGltf, OnlyTheNeededPartsOfAFileAreRead) {
  const TemporaryFolder folder;
  std::string bytes = test::glb_of({{"JSON", R"({"asset":{"version":"1.0"}} )"}});
  const auto rest = static_cast<std::uint32_t>(kLargeBytes - bytes.size() - 8);
  bytes.replace(8, 4, test::bytes_of(std::vector<std::uint32_t>{std::uint32_t{kLargeBytes}}));
  bytes += test::bytes_of(std::vector<std::uint32_t>{rest}) + std::string("BIN\0", 4);
  expect_refused_unread(write_large(folder, "a.glb", bytes), "/asset/version");
}

TEST(HostileGltf, ABufferThatIsShorterThanItsByteLengthIsNotRead) {
  const TemporaryFolder folder;
  GltfBuilder asset = GltfBuilder::one_triangle();
  write_large(folder, "short.bin", asset.bin);
  Json root = asset.json;
  root["buffers"] = {{{"byteLength", kLargeBytes + 1}, {"uri", "short.bin"}}};
  expect_refused_unread(folder.write("a.gltf", root.dump()),
                        "but its data have " + std::to_string(kLargeBytes) + " bytes");
  root["buffers"] = {{{"byteLength", asset.bin.size()}, {"uri", "short.bin"}}};
  const test::PeakMemory memory;
  EXPECT_TRUE(read_gltf(folder.write("a.gltf", root.dump())).ok());
  EXPECT_LT(memory.bytes(), kBaseBytes);
}

TEST(HostileGltf, AFileThatShrinksIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder.write("a.bin", std::string(1000, 'x'));
  const auto file = RegularFile::open(path);
  ASSERT_TRUE(file.ok());
  std::filesystem::resize_file(path, 400);
  const auto bytes = file->read(100, 900);
  ASSERT_FALSE(bytes.ok());
  EXPECT_EQ(bytes.error().code, ErrorCode::kFileUnreadable);
  EXPECT_EQ(file->read(100, 300)->size(), 300u);
}

TEST(HostileGltf, ChunksAreLimited) {
  std::vector<std::pair<std::string, std::string>> chunks = {
      {"JSON", R"({"asset":{"version":"2.0"}} )"}};
  chunks.resize(kMaxGltfChunks + 1, {"none", ""});
  expect_refused(test::glb_of(chunks), ErrorCode::kLimitExceeded, "GLB");
}

TEST(HostileGltf, SeedsOfTheFuzzTargetAreValid) {
  for (const test::GltfSeed& seed : test::gltf_seeds()) {
    SCOPED_TRACE(seed.name);
    EXPECT_FALSE(read_or_fail(seed.bytes).meshes.empty());
  }
}

// --- JSON ----------------------------------------------------------------------------------------

TEST(HostileGltf, ClosedNestingIsLimitedLikeOpenNesting) {
  for (const std::size_t depth : {std::size_t{14500}, std::size_t{1000000}}) {
    for (const auto& [open, close] :
         {std::pair<std::string, std::string>{"[", "]"}, {"{\"a\":", "}"}}) {
      for (const char* where : {"extras", "extensions"}) {
        const std::string nested = "\"" + std::string(where) +
                                   "\":{\"x\":" + repeated(open, depth) + "0" +
                                   repeated(close, depth) + "}";
        const std::string file = triangle_with(nested);
        const Outcome outcome = read_measured(file, "/nowhere");
        expect_modest(outcome, file);
        ASSERT_FALSE(outcome.scene.ok());
        EXPECT_EQ(outcome.scene.error().code, ErrorCode::kLimitExceeded);
        EXPECT_EQ(outcome.scene.error().element.rfind("JSON byte ", 0), 0u);
      }
    }
  }
}

TEST(HostileGltf, ErrorsShowNamesOfUpTo120Bytes) {
  const auto refused_at = [](std::size_t length, const std::string& shown) {
    const std::string name = "_" + std::string(length - 1, 'n');
    expect_invalid(
        "{" + kAsset + R"(,"meshes":[{"primitives":[{"attributes":{")" + name + R"(":"x"}}]}]})",
        "/meshes/0/primitives/0/attributes/" + shown);
  };
  refused_at(40, "_" + std::string(39, 'n'));
  refused_at(120, "_" + std::string(119, 'n'));
  refused_at(121, "_" + std::string(119, 'n') + "...");
}

TEST(HostileGltf, LongRunsOfSpacesAreLeftOutOnlyBetweenValues) {
  const std::string spaces = std::string(std::size_t{16} << 20, ' ') + "\r\n\t";
  const std::string text =
      triangle_with("\"extras\":[" + spaces + "1" + spaces + "," + spaces + "2]");
  const TemporaryFolder folder;
  const std::string path = folder.write("a.gltf", spaces + text + spaces);
  EXPECT_TRUE(read_gltf(path).ok());
  // Spaces still separate numbers, belong to strings, and the text is still checked behind them.
  expect_invalid(triangle_with("\"extras\":[1" + spaces + "2]"), "JSON");
  expect_invalid(triangle_with("\"extras\":[1," + spaces + "]"), "JSON");
  const SceneDescription scene = read_or_fail(
      triangle_with("\"nodes\":[{\"mesh\":0,\"name\":\"a" + std::string(1000, ' ') + "b\"}]"));
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].name, "a" + std::string(1000, ' ') + "b");
}

// Parts of a text that has been scanned.
std::string left_out_of(const std::string& text) {
  const auto scan = scan_json(text);
  if (!scan.ok()) return scan.error().to_string();
  std::string parts;
  for (const JsonTextPart& part : scan->long_spaces) {
    parts += std::to_string(part.begin) + "-" + std::to_string(part.end) + " ";
  }
  return parts;
}

TEST(HostileGltf, OnePassOverATextFindsLongSpacesAndCountsValues) {
  test::Random random(46);
  for (int draw = 0; draw < 200; ++draw) {
    // Spaces of every length around the blocks that are examined at once, between values and in
    // strings with and without escapes.
    std::string text = "[";
    std::string expected;
    std::uint64_t values = 0;
    const auto add_spaces = [&] {
      const std::size_t count = random.index(3) == 0 ? 200 + random.index(400) : random.index(100);
      if (count >= 256) {
        expected +=
            std::to_string(text.size()) + "-" + std::to_string(text.size() + count - 1) + " ";
      }
      for (std::size_t i = 0; i < count; ++i) text += " \t\r\n"[random.index(4)];
    };
    for (std::size_t left = 1 + random.index(8); left > 0; --left) {
      add_spaces();
      switch (random.index(4)) {
        case 0:
          text +=
              "\"" + std::string(random.index(400), ' ') + "\\\"" + std::string(300, ' ') + "\"";
          break;
        case 1:
          text += "{\"a,[{\\\\\":" + std::string(random.index(200), ' ') + "1}";
          ++values;
          break;
        case 2:
          text += "\"" + std::string(random.index(200), 'x') + "\"";
          break;
        default:
          text += "1.5";
      }
      ++values;
      add_spaces();
      text += left > 1 ? "," : "]";
    }
    SCOPED_TRACE("draw " + std::to_string(draw));
    ASSERT_EQ(left_out_of(text), expected);
    EXPECT_EQ(scan_json(text)->extent.values, values);
    EXPECT_TRUE(Json::accept(text));
  }
}

TEST(HostileGltf, ValuesOutsideTheElementsOfGltfMayNotFillTheMemory) {
  const auto flood = [](const std::string& value, std::size_t count, const std::string& end) {
    std::string text;
    text.reserve(value.size() * count + 1);
    for (std::size_t i = 0; i < count; ++i) text += value + ",";
    text += end;
    return text;
  };
  constexpr std::size_t kMany = 6'000'000;  // of any kind
  const std::string strings = flood("\"\"", kMany, "0");
  for (const std::string& extra :
       {"\"extras\":[" + flood("0", kMany, "0") + "]", "\"unknown\":[" + strings + "]",
        "\"extras\":[" + flood("[]", kMany / 2, "0") + "]",
        "\"extras\":[" + flood("{\"a\":{}}", kMany / 4, "0") + "]",
        "\"images\":[{\"extras\":[" + strings + "]}]"}) {
    SCOPED_TRACE(extra.substr(0, 40));
    const std::string text = triangle_with(extra);
    const Outcome outcome = read_measured(text, "/nowhere");
    ASSERT_FALSE(outcome.scene.ok());
    EXPECT_EQ(outcome.scene.error().code, ErrorCode::kLimitExceeded);
    EXPECT_EQ(outcome.scene.error().element, "JSON");
    EXPECT_LT(outcome.peak_bytes, kBaseBytes);
  }
  read_or_fail(triangle_with("\"extras\":[" + flood("[0.5,true]", 1'000'000, "0") + "]"));
  read_or_fail(triangle_with("\"images\":[" + flood("{\"uri\":\"a.png\"}", 1'000'000, "{}") + "]"));
}

TEST(HostileGltf, EqualMeshesOfManyTrianglesAreReadOnce) {
  constexpr std::size_t kTriangles = kMaxGltfRepeatedTriangles / 2 - kGltfTrianglesPerMesh;
  GltfBuilder asset;
  const auto positions = asset.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  std::vector<std::uint32_t> corners;
  for (std::size_t i = 0; i < 3 * kTriangles; ++i) {
    corners.push_back(static_cast<std::uint32_t>(i % 3));
  }
  const Json primitive = {{"attributes", {{"POSITION", positions}}},
                          {"indices", asset.add_indices(corners)}};
  asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive}))}});
  Json& meshes = asset.json["meshes"];
  constexpr int kMeshes = 50;
  for (int i = 1; i < kMeshes; ++i) {
    meshes.push_back(Json(meshes[0]));
    asset.add_node({{"mesh", i}});
  }
  meshes[kMeshes - 1]["name"] = "another";
  const SceneDescription scene = read_or_fail(asset.glb_bytes());
  ASSERT_EQ(scene.nodes.size(), static_cast<std::size_t>(kMeshes));
  EXPECT_EQ(scene.meshes.size(), 4u) << "the first, two equal ones within the limit, another";
  for (int i = 0; i < kMeshes; ++i) {
    EXPECT_EQ(scene.nodes[i].mesh, i == kMeshes - 1 ? 3u
                                   : i < 3          ? static_cast<std::uint32_t>(i)
                                                    : 0u);
  }
}

TEST(HostileGltf, EqualMeshesOfFewTrianglesAreReadOnceToo) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  constexpr std::size_t kRead = kMaxGltfRepeatedTriangles / (1 + kGltfTrianglesPerMesh);
  Json& meshes = asset.json["meshes"];
  const Json mesh = meshes[0];
  for (std::size_t i = 1; i < kRead + 100; ++i) {
    meshes.push_back(mesh);
    asset.add_node({{"mesh", i}});
  }
  EXPECT_EQ(read_or_fail(asset.glb_bytes()).meshes.size(), 1 + kRead);
}

// --- Mesh data that are read again ---------------------------------------------------------------

// A mesh of many triangles with equal corners, which has a skin and a morph target.
struct RepeatedMesh {
  static constexpr std::size_t kTriangles = std::size_t{1} << 14;
  GltfBuilder asset;
  Json primitive;

  RepeatedMesh() {
    const auto positions = asset.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 0; i < 3 * kTriangles; ++i) {
      corners.push_back(static_cast<std::uint32_t>(i % 3));
    }
    primitive = {{"attributes", {{"POSITION", positions}}},
                 {"indices", asset.add_indices(corners)},
                 {"targets", Json::array({{{"POSITION", positions}}})}};
  }

  // Bytes of all views, which the mesh uses.
  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const Json& view : asset.json["bufferViews"]) {
      sum += view["byteLength"].get<std::uint64_t>();
    }
    return sum;
  }

  void add_skin_attributes() {
    const auto joints =
        asset.add_accessor(asset.add_view(test::bytes_of(std::vector<std::uint8_t>(12, 0))),
                           GltfBuilder::kUnsignedByte, 3, "VEC4");
    const auto weights = asset.add_accessor(
        asset.add_view(test::bytes_of(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})),
        GltfBuilder::kFloat, 3, "VEC4");
    primitive["attributes"]["JOINTS_0"] = joints;
    primitive["attributes"]["WEIGHTS_0"] = weights;
  }
};

// The most meshes or poses of RepeatedMesh that are read.
std::size_t most_of(std::size_t most_triangles) {
  return most_triangles / (RepeatedMesh::kTriangles + kGltfTrianglesPerMesh);
}

// The largest memory of so many meshes of RepeatedMesh in a description.
std::size_t bytes_of_meshes(std::size_t count) {
  return kBaseBytes + count * RepeatedMesh::kTriangles * sizeof(Triangle);
}

TEST(HostileGltf, ACrowdIsWithinTheLimitOfPoses) {
  constexpr std::size_t kTriangles = 50'000;
  constexpr std::size_t kVertices = kTriangles / 2;  // positions, four joints, four float weights
  constexpr std::uint64_t kBytes = kVertices * (12 + 4 + 16) + kTriangles * 3 * 4;
  EXPECT_GE(most_gltf_posed_triangles(kBytes), 100 * (kTriangles + kGltfTrianglesPerMesh));
}

TEST(HostileGltf, PosesOfOneMeshAreLimitedByItsData) {
  for (const bool has_skins : {false, true}) {
    SCOPED_TRACE(has_skins);
    RepeatedMesh repeated;
    GltfBuilder& asset = repeated.asset;
    if (has_skins) repeated.add_skin_attributes();
    asset.add_mesh(Json::array({repeated.primitive}));
    const std::size_t most = most_of(most_gltf_posed_triangles(repeated.bytes()));
    asset.json["nodes"] = Json::array();
    const auto add_pose = [&](std::size_t i) {
      if (has_skins) {
        asset.json["skins"].push_back({{"joints", {0}}});
        asset.add_node({{"mesh", 0}, {"skin", i}});
      } else {
        asset.add_node({{"mesh", 0}, {"weights", {static_cast<double>(1 + i)}}});
      }
    };
    for (std::size_t i = 0; i < most; ++i) add_pose(i);
    const Outcome read = read_measured(asset.glb_bytes(), "/nowhere");
    ASSERT_TRUE(read.scene.ok()) << read.scene.error().to_string();
    EXPECT_EQ(read.scene->meshes.size(), most);
    for (std::size_t i = most; i < 3 * most; ++i) add_pose(i);
    const Outcome refused = read_measured(asset.glb_bytes(), "/nowhere");
    ASSERT_FALSE(refused.scene.ok());
    EXPECT_EQ(refused.scene.error().code, ErrorCode::kLimitExceeded);
    EXPECT_EQ(refused.scene.error().element, "/nodes/" + std::to_string(most));
    EXPECT_LT(refused.peak_bytes, bytes_of_meshes(most + 1));
  }
}

TEST(HostileGltf, MeshesAndPrimitivesThatReadDataAgainAreLimited) {
  for (const bool one_mesh : {false, true}) {
    SCOPED_TRACE(one_mesh);
    RepeatedMesh repeated;
    GltfBuilder& asset = repeated.asset;
    repeated.primitive.erase("targets");
    const std::size_t limit = most_gltf_triangles(repeated.bytes());
    const std::size_t most =
        one_mesh ? (limit - kGltfTrianglesPerMesh) / RepeatedMesh::kTriangles : most_of(limit);
    Json primitives = Json::array();
    for (std::size_t i = 0; i < 3 * most; ++i) {
      repeated.primitive["material"] = i;
      asset.json["materials"].push_back(Json::object());
      primitives.push_back(repeated.primitive);
    }
    if (one_mesh) {
      asset.add_node({{"mesh", asset.add_mesh(primitives)}});
    } else {
      for (const Json& primitive : primitives) {
        asset.add_node({{"mesh", asset.add_mesh(Json::array({primitive}))}});
      }
    }
    const Outcome refused = read_measured(asset.glb_bytes(), "/nowhere");
    ASSERT_FALSE(refused.scene.ok());
    EXPECT_EQ(refused.scene.error().code, ErrorCode::kLimitExceeded);
    EXPECT_EQ(refused.scene.error().element,
              one_mesh ? "/meshes/0/primitives/" + std::to_string(most)
                       : "/meshes/" + std::to_string(most) + "/primitives/0");
    EXPECT_LT(refused.peak_bytes, bytes_of_meshes(2 * most));  // an array grows by doubling
  }
}

TEST(HostileGltf, BytesThatAreReadAgainCountOnce) {
  test::Random random(4610);
  for (int draw = 0; draw < 100; ++draw) {
    ByteRanges ranges;
    std::vector<bool> is_in(200, false);
    for (int i = 0; i < 30; ++i) {
      const std::size_t begin = random.index(200);
      const std::size_t end = begin + random.index(201 - begin);
      ranges.add(begin, end);
      std::fill(is_in.begin() + static_cast<std::ptrdiff_t>(begin),
                is_in.begin() + static_cast<std::ptrdiff_t>(end), true);
      ASSERT_EQ(ranges.total(),
                static_cast<std::uint64_t>(std::count(is_in.begin(), is_in.end(), true)));
    }
  }
}

TEST(HostileGltf, NodesOfASmallFileAreCountedBeforeTheyAreParsed) {
  const auto nodes = [](std::size_t count) {
    return "{" + kAsset + R"(,"nodes":)" + list_of(R"({"name":"a"})", count) + "}";
  };
  const std::string few = nodes(most_gltf_nodes(0));
  EXPECT_EQ(read_measured(few, "/nowhere").scene.error().code, ErrorCode::kEmptyScene);
  const std::string many = nodes(most_gltf_nodes(few.size()) + 1000);
  const Outcome refused = read_measured(many, "/nowhere");
  ASSERT_FALSE(refused.scene.ok());
  EXPECT_EQ(refused.scene.error().code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(refused.scene.error().element, "/nodes");
  EXPECT_LT(refused.peak_bytes, std::size_t{1} << 20);
}

TEST(HostileGltf, ScenesAndAnimationsAreCountedBeforeTheyAreParsed) {
  for (const std::string list : {"scenes", "animations"}) {
    const std::string text =
        "{" + kAsset + ",\"" + list + "\":" + list_of("{}", kMaxGltfScenes + 1) + "}";
    const Outcome refused = read_measured(text, "/nowhere");
    ASSERT_FALSE(refused.scene.ok());
    EXPECT_EQ(refused.scene.error().code, ErrorCode::kLimitExceeded);
    EXPECT_EQ(refused.scene.error().element, "/" + list);
    EXPECT_LT(refused.peak_bytes, std::size_t{1} << 20);
  }
}

// --- Long texts that are not parsed --------------------------------------------------------------

// The memory beside the file that reading it takes.
std::size_t bytes_beside_file(const std::string& path, Result<SceneDescription>& scene) {
  const test::PeakMemory memory;
  scene = read_gltf(path);
  const std::size_t peak = memory.bytes();
  return peak - std::min<std::size_t>(peak, std::filesystem::file_size(path));
}

TEST(HostileGltf, LongRunsOfSpacesTakeNoMemoryBesideTheFile) {
  const std::string spaces(std::size_t{8} << 20, ' ');
  const TemporaryFolder folder;
  const std::string path =
      folder.write("a.gltf", triangle_with("\"extras\":[" + spaces + "1," + spaces + "2]"));
  Result<SceneDescription> scene = SceneDescription{};
  EXPECT_LT(bytes_beside_file(path, scene), std::size_t{1} << 20);
  EXPECT_TRUE(scene.ok());
}

TEST(HostileGltf, LongDataOfDataUrisTakeNoMemoryBesideTheFile) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const SceneDescription expected = read_or_fail(asset.data_uri_text());
  asset.add_view(std::string(std::size_t{6} << 20, '\x5a'));  // the buffer becomes long
  std::string text = asset.data_uri_text();
  const std::string image = std::string(std::size_t{8} << 20, 'A') + "-";
  text.replace(text.size() - 1, 1,
               ",\"images\":[{\"uri\":\"data:image/png;base64," + image + "\"}]}");
  const TemporaryFolder folder;
  const std::string path = folder.write("a.gltf", text);
  Result<SceneDescription> scene = SceneDescription{};
  EXPECT_LT(bytes_beside_file(path, scene), std::size_t{1} << 20);
  ASSERT_TRUE(scene.ok()) << scene.error().to_string();
  EXPECT_EQ(scene->meshes.at(0).positions, expected.meshes.at(0).positions);
  EXPECT_EQ(scene->meshes.at(0).triangles, expected.meshes.at(0).triangles);
  EXPECT_EQ(read_or_fail(text).meshes.at(0).positions, expected.meshes.at(0).positions)
      << "from memory that must not be changed";
}

TEST(HostileGltf, DataOfDataUrisStayWhatTheyAre) {
  const TemporaryFolder folder;
  const std::string long_image = "\"images\":[{\"uri\":\"data:image/png;base64," +
                                 std::string(std::size_t{2} << 20, 'A') + "\"}]}";
  const auto error_of = [&](const std::string& data) {
    const std::string text = "{" + kAsset +
                             R"(,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[)"
                             R"({"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[)"
                             R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                             R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[)"
                             R"({"byteLength":36,"uri":"data:;base64,)" +
                             data + "\"}]," + long_image;
    const auto scene = read_gltf(folder.write("a.gltf", text));
    return scene.ok() ? "read" : scene.error().to_string();
  };
  const std::string zeros(48, 'A');
  EXPECT_EQ(error_of(zeros), "read");
  // What the parser gets in the place of long data is not base64 if a file states it.
  for (const std::string& data :
       {std::string("*0"), std::string("*1"), zeros + "*", std::string(3 << 20, 'A') + "-"}) {
    EXPECT_NE(error_of(data).find("/buffers/0/uri: the data URI is not valid base64"),
              std::string::npos)
        << error_of(data).substr(0, 300);
  }
}

TEST(HostileGltf, Base64IsDecodedInItsPlace) {
  test::Random random(4611);
  for (std::size_t size = 1; size < 200; ++size) {
    std::string bytes(size, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random.index(256));
    std::string text = test::base64_encoded(bytes);
    if (random.index(2) == 0) text.erase(text.find_last_not_of('=') + 1);
    std::string in_place = text;
    auto* begin = reinterpret_cast<std::uint8_t*>(in_place.data());
    ASSERT_EQ(base64_size(text), size);
    ASSERT_TRUE(decode_base64(in_place, begin));
    EXPECT_EQ(in_place.substr(0, size), bytes);
    const std::size_t digits = text.find_last_not_of('=') + 1;
    text[random.index(digits)] = "-_ =*\x80"[random.index(6)];
    std::vector<std::uint8_t> decoded(size + 3);
    EXPECT_FALSE(base64_size(text) == size && decode_base64(text, decoded.data())) << text;
  }
  EXPECT_EQ(base64_size("AAAAA"), std::nullopt);
}

TEST(HostileGltf, StringsAreLimitedTogether) {
  const std::string name(kMaxGltfStringBytes / 2, 'n');
  const std::size_t most = kMaxGltfStringBytesInAll / name.size();
  const Outcome outcome =
      read_measured(triangle_with("\"extras\":" + list_of("\"" + name + "\"", most)), "/nowhere");
  ASSERT_FALSE(outcome.scene.ok());
  EXPECT_EQ(outcome.scene.error().code, ErrorCode::kLimitExceeded);
  EXPECT_LT(outcome.peak_bytes, std::size_t{1} << 20);
}

TEST(HostileGltf, OnlyDataUrisMayBeVeryLongStrings) {
  const std::string body(kMaxGltfStringBytes, 'A');
  const Outcome outcome = read_measured(triangle_with("\"extras\":\"" + body + "\""), "/nowhere");
  ASSERT_FALSE(outcome.scene.ok());
  EXPECT_EQ(outcome.scene.error().code, ErrorCode::kLimitExceeded);
  read_or_fail(triangle_with("\"images\":[{\"uri\":\"data:image/png;base64," + body + "\"}]"));
}

TEST(HostileGltf, NestingUpToTheLimitIsRead) {
  const std::size_t depth = kMaxGltfJsonDepth - 1;  // within the root
  const std::string nested = "\"extras\":" + repeated("[", depth) + repeated("]", depth);
  EXPECT_EQ(read_or_fail(triangle_with(nested)).meshes.size(), 1u);
}

TEST(HostileGltf, TextThatIsNotUtf8IsRefused) {
  for (const char* name : {"\"\xff\"", "\"\xc0\xaf\"", "\"\xed\xa0\x80\"", "\"\xe2\x82\"",
                           "\"\\ud800\"", "\"\\u12\"", "\"\x01\""}) {
    expect_invalid("{" + kAsset + ",\"nodes\":[{\"name\":" + name + "}]}", "JSON");
  }
}

bool has_warning(const SceneDescription& scene, const std::string& text) {
  return std::any_of(scene.warnings.begin(), scene.warnings.end(), [&](const std::string& warning) {
    return warning.find(text) != std::string::npos;
  });
}

TEST(HostileGltf, AByteOrderMarkIsIgnoredWithAWarning) {
  const std::string mark = "\xEF\xBB\xBF";
  const std::string text = GltfBuilder::one_triangle().data_uri_text();
  for (const std::string& file : {mark + text, test::glb_of({{"JSON", mark + text}})}) {
    const SceneDescription scene = read_or_fail(file);
    EXPECT_EQ(scene.meshes.size(), 1u);
    EXPECT_TRUE(has_warning(scene, "byte order mark"));
  }
  EXPECT_TRUE(read_or_fail(text).warnings.empty());
  // Only one mark is ignored.
  expect_refused(mark + mark + text, ErrorCode::kNotGltf, "");
  expect_invalid(test::glb_of({{"JSON", mark + mark + text}}), "JSON");
  expect_refused(mark, ErrorCode::kNotGltf, "");
}

// Each character with this many zero bytes before and after it.
std::string widened(const std::string& text, std::size_t before, std::size_t behind) {
  std::string wide;
  for (const char c : text) {
    wide += std::string(before, '\0');
    wide += c;
    wide += std::string(behind, '\0');
  }
  return wide;
}

TEST(HostileGltf, TextInAnotherEncodingIsRefusedByItsName) {
  const std::string text = GltfBuilder::one_triangle().data_uri_text();
  const auto refuse = [](const std::string& bytes, const std::string& name) {
    for (const auto& [file, element] :
         {std::pair(bytes, std::string()),
          std::pair(test::glb_of({{"JSON", bytes}}), std::string("JSON"))}) {
      expect_refused(file, ErrorCode::kNotGltf, element);
      const auto problem = read_measured(file, "/nowhere").scene.error().problem;
      EXPECT_NE(problem.find(name), std::string::npos) << problem;
    }
  };
  for (const char* mark : {"\xFF\xFE", ""}) refuse(mark + widened(text, 0, 1), "UTF-16");
  for (const char* mark : {"\xFE\xFF", ""}) refuse(mark + widened(text, 1, 0), "UTF-16");
  for (const auto& mark : {std::string("\xFF\xFE\0\0", 4), std::string()}) {
    refuse(mark + widened(text, 0, 3), "UTF-32");
  }
  for (const auto& mark : {std::string("\0\0\xFE\xFF", 4), std::string()}) {
    refuse(mark + widened(text, 3, 0), "UTF-32");
  }
}

TEST(HostileGltf, TheLastValueOfARepeatedKeyIsUsedWithAWarning) {
  const SceneDescription scene =
      read_or_fail(triangle_with(R"("nodes":[{},{"mesh":0}],"scenes":[{"nodes":[1]}])"));
  EXPECT_EQ(scene.nodes.at(0).name, "node 1");
  EXPECT_TRUE(has_warning(scene, "/nodes: is present more than once"));
  EXPECT_TRUE(has_warning(scene, "/scenes: is present more than once"));
  expect_invalid(triangle_with(R"("nodes":7)"), "/nodes");
  expect_invalid(triangle_with(R"("accessors":[])"), "/meshes/0/primitives/0/indices");

  const std::string nested = R"("nodes":[{},{"extras":[0,{"a":{"b":1,"b":2}}],)"
                             R"("translation":[9,9,9],"mesh":0,"translation":[1,2,3]}],)"
                             R"("scenes":[{"nodes":[1]}])";
  const SceneDescription deep = read_or_fail(triangle_with(nested));
  EXPECT_EQ(deep.nodes.at(0).translation_m, Vec3(1, 2, 3));
  EXPECT_TRUE(has_warning(deep, "/nodes/1/translation: is present more than once"));
  EXPECT_TRUE(has_warning(deep, "/nodes/1/extras/1/a/b: is present more than once"));
}

TEST(HostileGltf, ManyRepeatedKeysAreCounted) {
  constexpr std::size_t kMany = 100000;
  const SceneDescription scene =
      read_or_fail(triangle_with("\"extras\":{\"k\":0" + repeated(",\"k\":[1]", kMany) + "}"));
  EXPECT_TRUE(has_warning(scene, "/extras/k: is present more than once"));
  ASSERT_FALSE(scene.warnings.empty());
  EXPECT_LT(scene.warnings.size(), kMaxGltfWarnings);
  const std::size_t listed = scene.warnings.size() - 1;
  EXPECT_EQ(scene.warnings.back(), "JSON: " + std::to_string(kMany - listed) +
                                       " further keys are present more than once; the last "
                                       "value of each is used");
}

TEST(HostileGltf, ContradictoryMinAndMaxAreNamedAndIgnored) {
  const auto warnings_of = [](const Json& low, const Json& high) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["accessors"][0]["min"] = low;
    asset.json["accessors"][0]["max"] = high;
    const SceneDescription scene = read_or_fail(asset.glb_bytes());
    EXPECT_EQ(scene.meshes.at(0).positions.at(1), Vec3(1, 0, 0));
    return scene.warnings;
  };
  EXPECT_TRUE(warnings_of({0, 0, 0}, {1, 1, 0}).empty());
  EXPECT_TRUE(warnings_of({0, 0, 0}, {0, 0, 0}).empty());
  const auto above = warnings_of({0, 0.5, 0}, {1, -0.5, 0});
  ASSERT_EQ(above.size(), 1u);
  EXPECT_NE(above[0].find("/accessors/0: its min 0.5 is above its max -0.5 in component 1"),
            std::string::npos)
      << above[0];
  // Exporters write null for numbers that are not finite.
  const auto null = warnings_of({0, 0, 0}, {nullptr, nullptr, nullptr});
  ASSERT_EQ(null.size(), 1u);
  EXPECT_NE(null[0].find("/accessors/0/max: is not a list of 3 numbers"), std::string::npos);
  EXPECT_EQ(warnings_of({0, 0}, "x").size(), 2u);
}

// --- Scales --------------------------------------------------------------------------------------

Json scaled_by(double scale) {
  return {{"scale", {scale, scale, scale}}};
}

// The node "small" has the mesh; all these scales apply to it, outermost first.
GltfBuilder scaled_triangle(const std::vector<double>& scales) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"] = Json::array();
  for (std::size_t i = 0; i < scales.size(); ++i) {
    Json node = scaled_by(scales[i]);
    node["name"] = "level" + std::to_string(i);
    node["children"] = {i + 1};
    asset.add_child(node);
  }
  asset.add_child({{"mesh", 0}, {"name", "small"}});
  return asset;
}

void expect_problem(const std::string& file, ErrorCode code, const std::string& element,
                    const std::vector<std::string>& texts) {
  expect_refused(file, code, element);
  const std::string message = read_measured(file, "/nowhere").scene.error().to_string();
  for (const std::string& text : texts) {
    EXPECT_NE(message.find(text), std::string::npos) << message;
  }
}

TEST(HostileGltf, AScaleBeyondTheLimitIsRefusedByTheNameOfTheNodeAndTheScale) {
  for (const double scale : {1.1e100, 1e155, 1e300, 1e308, -1e155}) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", std::abs(scale));
    expect_problem(scaled_triangle({scale}).glb_bytes(), ErrorCode::kLimitExceeded, "/nodes/1",
                   {"\"small\"", std::string("scaled by ") + text});
    expect_problem(
        scaled_triangle({1.0, std::sqrt(std::abs(scale)), std::sqrt(std::abs(scale))}).glb_bytes(),
        ErrorCode::kLimitExceeded, "/nodes/3", {"\"small\"", "scaled by"});
    GltfBuilder matrix = scaled_triangle({1.0});
    matrix.json["nodes"][1]["matrix"] = {scale, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    expect_problem(matrix.glb_bytes(), ErrorCode::kLimitExceeded, "/nodes/1", {"\"small\"", text});
  }
  expect_problem(scaled_triangle({1e200, 1e200}).glb_bytes(), ErrorCode::kInvalidContent,
                 "/nodes/1",
                 {"\"level1\"", "its scale of 1e+200, times that of its ancestors, 1e+200"});
  GltfBuilder moved = scaled_triangle({1e99});
  moved.json["nodes"][1]["translation"] = {1e300, 0, 0};
  expect_problem(moved.glb_bytes(), ErrorCode::kInvalidContent, "/nodes/1",
                 {"\"small\"", "translation of 1e+300"});
}

TEST(HostileGltf, ScalesThatCancelDoNotAffectTheMesh) {
  for (const double scale : {1e30, 1e60, 1e155, 1e200, 1e300}) {
    for (const double first : {scale, 1.0 / scale}) {
      const SceneDescription scene =
          read_or_fail(scaled_triangle({first, 1.0 / first}).glb_bytes());
      ASSERT_EQ(scene.nodes.size(), 1u);
      const NodeDescription& node = scene.nodes[0];
      EXPECT_LE((node.linear_scene_mesh - Mat3::Identity()).norm(), 1e-15);
      // The bound for seams has neither overflowed nor underflowed.
      EXPECT_LE((node.product.columns - Vec3::Ones()).norm(), 1e-12);
      EXPECT_NEAR(node.product.linear, 1.0, 1e-12);
    }
  }
}

TEST(HostileGltf, AScaleBelowTheLimitLeavesTheNodeOutByName) {
  for (const double scale : {1e-101, 1e-155, 1e-300, 1e-308, 5e-324, -5e-324}) {
    GltfBuilder asset = scaled_triangle({scale});
    asset.add_node({{"mesh", 0}, {"name", "other"}});
    const SceneDescription scene = read_or_fail(asset.glb_bytes());
    ASSERT_EQ(scene.nodes.size(), 1u);
    EXPECT_EQ(scene.nodes[0].name, "other");
    EXPECT_TRUE(has_warning(scene, "/nodes/1: \"small\" is scaled by "));
  }
  EXPECT_EQ(read_or_fail(scaled_triangle({1e-99}).glb_bytes()).nodes.size(), 1u);
}

// One triangle, instanced at two places.
TEST(HostileGltf, AScaleOfInstancesIsRefusedByTheNameOfTheNodeAndTheInstance) {
  GltfBuilder asset = scaled_triangle({1e80});
  const std::size_t scales = asset.add_accessor(
      asset.add_view(test::bytes_of(std::vector<float>{1, 1, 1, 1e30f, 1e30f, 1e30f})),
      GltfBuilder::kFloat, 2, "VEC3");
  asset.json["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"] = {
      {"attributes", {{"SCALE", scales}}}};
  expect_problem(asset.glb_bytes(), ErrorCode::kLimitExceeded, "/nodes/1",
                 {"instance 1 of \"small\"", "scaled by 1e+110"});
  asset.json["nodes"][0] = scaled_by(1e290);
  asset.json["nodes"][0]["children"] = {1};
  asset.json["nodes"][1]["name"] = "";
  expect_problem(asset.glb_bytes(), ErrorCode::kLimitExceeded, "/nodes/1",
                 {"instance 0 of \"node 1\"", "scaled by 1e+290"});
}

GltfBuilder skinned_triangle() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto joints =
      asset.add_accessor(asset.add_view(test::bytes_of(std::vector<std::uint8_t>(12, 0))),
                         GltfBuilder::kUnsignedByte, 3, "VEC4");
  const auto weights = asset.add_accessor(
      asset.add_view(test::bytes_of(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0})),
      GltfBuilder::kFloat, 3, "VEC4");
  Json& attributes = asset.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = joints;
  attributes["WEIGHTS_0"] = weights;
  asset.json["nodes"][0]["skin"] = 0;
  asset.add_node({{"name", "arm"}, {"scale", {2, 2, 2}}});
  asset.json["skins"] = {{{"joints", {1}}}};
  return asset;
}

TEST(HostileGltf, AScaleOfAJointIsRefusedByTheNameOfTheNode) {
  GltfBuilder asset = skinned_triangle();
  EXPECT_EQ(read_or_fail(asset.glb_bytes()).meshes.at(0).positions.at(1), Vec3(2, 0, 0));
  asset.json["nodes"][1]["scale"] = {1e155, 1e155, 1e155};
  expect_problem(asset.glb_bytes(), ErrorCode::kLimitExceeded, "/skins/0/joints/0",
                 {"node 1 (\"arm\")", "scaled by 1e+155"});
}

TEST(HostileGltf, ANodeThatIsSeveralJointsIsNamed) {
  GltfBuilder asset = skinned_triangle();
  EXPECT_TRUE(read_or_fail(asset.glb_bytes()).warnings.empty());
  asset.json["skins"][0]["joints"] = {1, 0, 1, 1};
  const SceneDescription scene = read_or_fail(asset.glb_bytes());
  EXPECT_EQ(scene.meshes.at(0).positions.at(1), Vec3(2, 0, 0));
  EXPECT_TRUE(has_warning(
      scene, "/skins/0/joints: node 1 (\"arm\") is joint 0 and joint 2; expected each node once"));
  EXPECT_TRUE(has_warning(scene, "further repeated joints: 1"));
}

TEST(HostileGltf, TextAfterTheJsonIsRefused) {
  const std::string text = GltfBuilder::one_triangle().data_uri_text();
  for (const std::string& tail : {std::string("x"), std::string("{}"), std::string("]"),
                                  std::string("\0{}", 3), std::string("\0\0 ", 3)}) {
    expect_invalid(text + tail, "JSON");
  }
  // Some exporters pad their GLB with zero bytes.
  EXPECT_EQ(read_or_fail(text + std::string(3, '\0')).meshes.size(), 1u);
}

TEST(HostileGltf, EmptyFilesAndListsAreRefused) {
  expect_refused("", ErrorCode::kNotGltf, "");
  expect_refused("{}", ErrorCode::kNotGltf, "/asset/version");
  expect_invalid(test::glb_of({{"JSON", ""}}), "JSON");
  for (const char* section : {"scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers"}) {
    expect_refused("{" + kAsset + ",\"" + section + "\":[]}", ErrorCode::kEmptyScene, "");
  }
}

TEST(HostileGltf, LongArraysTakeMemoryLikeTheirText) {
  constexpr std::size_t kMany = 200000;
  EXPECT_EQ(read_or_fail(triangle_with("\"extras\":" + list_of("0", kMany))).meshes.size(), 1u);
  EXPECT_EQ(read_or_fail(triangle_with("\"materials\":" + list_of("{}", kMany))).meshes.size(), 1u);
  EXPECT_EQ(read_or_fail(triangle_with("\"extras\":" + list_of("{\"a\":{}}", kMany))).nodes.size(),
            1u);
  expect_invalid(triangle_with("\"scenes\":[{\"nodes\":" + list_of("0", kMany) + "}]"),
                 "/scenes/0/nodes");
  expect_invalid(triangle_with("\"nodes\":[{\"children\":" + list_of("0", kMany) + "}]"),
                 "/nodes/0/children");
  expect_refused(triangle_with("\"accessors\":" + list_of("{}", kMany)), ErrorCode::kLimitExceeded,
                 "/accessors");
  expect_invalid(triangle_with("\"nodes\":[{\"matrix\":" + list_of("1", kMany) + "}]"),
                 "/nodes/0/matrix");
}

// --- The hierarchy -------------------------------------------------------------------------------

TEST(HostileGltf, AGraphOfSixtyLevelsIsRefused) {
  // Two nodes on each level, each a parent of both nodes of the next level: 2^60 paths down.
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"] = Json::array();
  for (std::size_t level = 0; level < 60; ++level) {
    const Json next = {2 * level + 2, 2 * level + 3};
    asset.add_child({{"children", next}});
    asset.add_child({{"children", next}});
  }
  asset.add_child({{"mesh", 0}});
  asset.add_child({{"mesh", 0}});
  expect_invalid(asset.glb_bytes(), "/nodes/1/children/0");
}

TEST(HostileGltf, ALongCycleIsFound) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  constexpr std::size_t kLength = 10000;
  asset.json["nodes"] = Json::array();
  for (std::size_t i = 0; i < kLength; ++i) asset.add_child({{"children", {(i + 1) % kLength}}});
  expect_invalid(asset.glb_bytes(), "/nodes/0", kLength);
}

TEST(HostileGltf, AChainOfNodesDeeperThanTheStackIsRefused) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"] = Json::array();
  constexpr std::size_t kDepth = 100000;
  for (std::size_t i = 0; i + 1 < kDepth; ++i) asset.add_child({{"children", {i + 1}}});
  asset.add_child({{"mesh", 0}});
  expect_refused(asset.glb_bytes(), ErrorCode::kLimitExceeded,
                 "/nodes/" + std::to_string(kMaxGltfNodeDepth), kDepth);
}

TEST(HostileGltf, ListsOfNodesAreNoLongerThanTheNodes) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["scenes"][0]["nodes"] = {0, 0};
  expect_invalid(asset.glb_bytes(), "/scenes/0/nodes");
  asset.add_child(Json::object());
  expect_invalid(asset.glb_bytes(), "/nodes/0");
  asset.json["scenes"][0]["nodes"] = {0};
  asset.json["nodes"][0]["children"] = {1, 1};
  expect_invalid(asset.glb_bytes(), "/nodes/0/children/1");
  asset.json["nodes"][0]["children"] = {1, 1, 1};
  expect_invalid(asset.glb_bytes(), "/nodes/0/children");
}

// The number of elements is bounded over all kinds: scenes and morph targets take only three bytes
// each in a file.
TEST(HostileGltf, ElementsOfEveryKindAreBounded) {
  const std::string most = list_of("{}", kMaxGltfElements + 1);
  expect_refused("{" + kAsset + ",\"scenes\":" + most + "}", ErrorCode::kLimitExceeded, "/scenes");
  const std::string primitive = R"({"primitives":[{"attributes":{},"targets":)";
  expect_refused("{" + kAsset + ",\"meshes\":[" + primitive + most + "}]}]}",
                 ErrorCode::kLimitExceeded, "JSON");  // refused before it is parsed
  expect_refused("{" + kAsset + ",\"meshes\":[{\"primitives\":" + most + "}]}",
                 ErrorCode::kLimitExceeded, "JSON");
  expect_refused("{" + kAsset + ",\"nodes\":" + most + "}", ErrorCode::kLimitExceeded, "/nodes");
  constexpr std::size_t kMany = 20000;
  expect_refused("{" + kAsset + ",\"scenes\":" + list_of("{}", kMany) + "}", ErrorCode::kEmptyScene,
                 "", kMany);
}

TEST(HostileGltf, MalformedContoursAreBoundedAndCounted) {
  const std::string contour = R"({"extras":{"palpate_contour":0}})";
  const auto file_with = [&](std::size_t count) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    std::vector<std::size_t> roots(count + 1);
    for (std::size_t i = 0; i <= count; ++i) roots[i] = i;
    asset.json["scenes"][0]["nodes"] = roots;
    std::string text = asset.data_uri_text();
    const std::string node = R"("nodes":[)";
    return text.replace(text.find(R"("nodes":[{)"), node.size(),
                        node + repeated(contour + ",", count));
  };
  const std::string most = file_with(kMaxGltfContours);
  const Outcome outcome = read_measured(most, "/nowhere");
  expect_modest(outcome, most, kMaxGltfContours);
  ASSERT_TRUE(outcome.scene.ok()) << outcome.scene.error().to_string();
  EXPECT_EQ(outcome.scene->contours.size(), kMaxGltfContours);
  EXPECT_EQ(outcome.scene->warnings.size(), kMaxGltfWarnings + 1);
  expect_refused(file_with(kMaxGltfContours + 1), ErrorCode::kLimitExceeded,
                 "/nodes/" + std::to_string(kMaxGltfContours) + "/extras/palpate_contour",
                 kMaxGltfContours);
}

// --- Sizes that overflow or underflow ------------------------------------------------------------

TEST(HostileGltf, HugeNumbersAreRefusedEverywhere) {
  const std::uint64_t huge = std::uint64_t{1} << 53;
  const std::uint64_t wraps = std::numeric_limits<std::uint64_t>::max() - 11;  // + 12 is 0
  for (const char* pointer :
       {"/accessors/0/count", "/accessors/1/count", "/accessors/0/byteOffset",
        "/accessors/1/byteOffset", "/bufferViews/0/byteOffset", "/bufferViews/0/byteLength",
        "/bufferViews/0/byteStride", "/buffers/0/byteLength"}) {
    for (const std::uint64_t value : {std::uint64_t{1} << 31, std::uint64_t{1} << 32,
                                      std::uint64_t{1} << 40, huge, huge + 1, wraps}) {
      GltfBuilder asset = GltfBuilder::one_triangle();
      asset.json["buffers"] = {{{"byteLength", asset.bin.size()}}};
      asset.json[Json::json_pointer(pointer)] = value;
      const std::string file = asset.glb_bytes();
      const Outcome outcome = read_measured(file, "/nowhere");
      expect_modest(outcome, file);
      ASSERT_FALSE(outcome.scene.ok()) << pointer << " " << value;
      // The element itself, or the element that it exceeds.
      const std::string element = outcome.scene.error().element;
      EXPECT_TRUE(element == pointer || std::string(pointer).rfind(element + "/", 0) == 0)
          << pointer << " " << value << ": " << outcome.scene.error().to_string();
    }
  }
}

TEST(HostileGltf, SparseCountsBelowZeroAreRefused) {
  for (const Json& count : {Json(-1), Json(-2147483648LL), Json(-9223372036854775807LL)}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["accessors"][0]["sparse"] = {
        {"count", count},
        {"indices", {{"bufferView", 1}, {"componentType", GltfBuilder::kUnsignedShort}}},
        {"values", {{"bufferView", 0}}}};
    expect_invalid(asset.glb_bytes(), "/accessors/0/sparse/count");
  }
}

// A triangle whose accessor has count elements; all except one are zeros that are not stored.
GltfBuilder triangle_of_zeros(std::size_t accessor, std::size_t count) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["accessors"][accessor].erase("bufferView");
  asset.json["accessors"][accessor]["count"] = count;
  asset.json["accessors"][accessor]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", 1}, {"componentType", GltfBuilder::kUnsignedShort}}},
      {"values", {{"bufferView", accessor}}}};
  return asset;
}

TEST(HostileGltf, ZerosThatAreNotStoredAreBounded) {
  constexpr std::size_t kMost = kMaxGltfUnstored / 3 * 3;
  for (const std::size_t accessor : {0u, 1u}) {
    expect_refused(triangle_of_zeros(accessor, kMaxGltfUnstored + 1).glb_bytes(),
                   ErrorCode::kLimitExceeded, "/accessors/" + std::to_string(accessor) + "/count");
    const Outcome outcome = read_measured(triangle_of_zeros(accessor, kMost).glb_bytes(), "");
    EXPECT_TRUE(outcome.scene.ok());
    EXPECT_LE(outcome.peak_bytes, std::size_t{64} << 20);
  }
  GltfBuilder two = triangle_of_zeros(0, kMaxGltfUnstored / 2 + 1);
  two.add_node({{"mesh", two.add_mesh(two.json["meshes"][0]["primitives"])}});
  expect_refused(two.glb_bytes(), ErrorCode::kLimitExceeded, "/accessors/0/count");
}

TEST(HostileGltf, StridesOfIndicesAreRefused) {
  for (const char* where : {"/bufferViews/1", "/bufferViews/2"}) {
    GltfBuilder asset = triangle_of_zeros(0, 3);
    asset.json["bufferViews"].push_back(asset.json["bufferViews"][1]);
    asset.json["accessors"][0]["sparse"]["indices"]["bufferView"] = 2;
    EXPECT_EQ(read_or_fail(asset.glb_bytes()).meshes.size(), 1u);
    asset.json[Json::json_pointer(where)]["byteStride"] = 4;
    expect_invalid(asset.glb_bytes(), std::string(where) + "/byteStride");
  }
}

TEST(HostileGltf, PositionsThatAreNotFiniteAreNamed) {
  for (const std::uint32_t bits : {0x7f800000u, 0xff800000u, 0x7fc00000u, 0x7f800001u}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.bin.replace(12 * 2 + 8, 4, test::bytes_of(std::vector<std::uint32_t>{bits}));
    const Outcome outcome = read_measured(asset.glb_bytes(), "/nowhere");
    ASSERT_FALSE(outcome.scene.ok());
    EXPECT_EQ(outcome.scene.error().element, "/accessors/0");
    EXPECT_NE(outcome.scene.error().problem.find("position 2 is not finite"), std::string::npos);
  }
}

// --- Containers and buffers ----------------------------------------------------------------------

TEST(HostileGltf, NoLengthInAGlbLeadsToReadingBeyondIt) {
  const std::string good = GltfBuilder::one_triangle().glb_bytes();
  const std::size_t json_size = good.size() - 28 - 44;  // two headers and a BIN chunk of 44 bytes
  for (const std::size_t at : {std::size_t{8}, std::size_t{12}, 20 + json_size}) {
    for (const std::uint32_t value : {0u, 1u, 0x7fffffffu, 0x80000000u, 0xfffffff0u, 0xffffffffu}) {
      std::string file = good;
      file.replace(at, 4, test::bytes_of(std::vector<std::uint32_t>{value}));
      const Outcome outcome = read_measured(file, "/nowhere");
      expect_modest(outcome, file);
      EXPECT_FALSE(outcome.scene.ok()) << at << " " << value;
    }
  }
}

TEST(HostileGltf, TwentyThousandBuffersAreNotTwentyThousandCopies) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.bin.resize(std::size_t{1} << 20);
  asset.json["buffers"] = Json::array();
  for (std::size_t i = 0; i < 20000; ++i) {
    asset.json["buffers"].push_back({{"byteLength", asset.bin.size()}});
  }
  EXPECT_EQ(read_or_fail(asset.glb_bytes()).meshes.size(), 1u);
  for (Json& view : asset.json["bufferViews"]) view["buffer"] = 19999;
  expect_invalid(asset.glb_bytes(), "/buffers/19999");
}

TEST(HostileGltf, NoMoreOfABufferIsReadThanItDeclares) {
  // Many buffers of few bytes each, all in one large file.
  const TemporaryFolder folder;
  GltfBuilder asset = GltfBuilder::one_triangle();
  constexpr std::size_t kBuffers = 64;
  folder.write("large.bin", asset.bin);
  std::filesystem::resize_file(folder.path("large.bin"), std::size_t{1} << 28);
  asset.json["buffers"] = Json::array();
  Json primitives = Json::array();
  for (std::size_t i = 0; i < kBuffers; ++i) {
    asset.json["buffers"].push_back({{"byteLength", asset.bin.size()}, {"uri", "large.bin"}});
    asset.json["bufferViews"][2 * i] = {{"buffer", i}, {"byteLength", 36}};
    asset.json["bufferViews"][2 * i + 1] = {{"buffer", i}, {"byteOffset", 36}, {"byteLength", 6}};
    const auto positions = asset.add_accessor(2 * i, GltfBuilder::kFloat, 3, "VEC3");
    const auto indices = asset.add_accessor(2 * i + 1, GltfBuilder::kUnsignedShort, 3, "SCALAR");
    primitives.push_back({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  }
  asset.json["meshes"][0]["primitives"] = primitives;
  const std::string file = asset.json.dump();
  const Outcome outcome = read_measured(file, folder.path());
  expect_modest(outcome, file);
  ASSERT_TRUE(outcome.scene.ok()) << outcome.scene.error().to_string();
  EXPECT_EQ(outcome.scene->meshes.at(0).triangles.size(), kBuffers);
}

TEST(HostileGltf, BuffersAreBoundedTogether) {
  const TemporaryFolder folder;
  GltfBuilder asset = GltfBuilder::one_triangle();
  folder.write("asset.bin", asset.bin);
  const auto with_lengths = [&](std::uint64_t first, std::uint64_t second) {
    asset.json["buffers"] = {{{"byteLength", first}, {"uri", "asset.bin"}},
                             {{"byteLength", second}, {"uri", "asset.bin"}}};
    asset.json["bufferViews"][1]["buffer"] = 1;
    return read_measured(asset.json.dump(), folder.path());
  };
  const std::size_t size = asset.bin.size();
  EXPECT_TRUE(with_lengths(size, size).scene.ok());
  const Outcome outcome = with_lengths(size, kMaxGltfBufferBytes - size + 1);
  ASSERT_FALSE(outcome.scene.ok());
  EXPECT_EQ(outcome.scene.error().code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(outcome.scene.error().element, "/buffers/1");
}

TEST(HostileGltf, NoUriLeadsOutOfTheFolder) {
  const TemporaryFolder folder;
  folder.write("asset/x.txt", "");
  std::filesystem::create_symlink("loop_b", folder.path("asset/loop_a"));
  std::filesystem::create_symlink("loop_a", folder.path("asset/loop_b"));
  std::filesystem::create_symlink("/dev/zero", folder.path("asset/zeros"));
  std::filesystem::create_symlink("/etc", folder.path("asset/etc"));
  ASSERT_EQ(::mkfifo(folder.path("asset/pipe").c_str(), 0600), 0);
  for (const std::string& uri : {std::string("../../etc/passwd"),
                                 std::string("../../../../../../etc/passwd"),
                                 std::string("..%2f..%2f..%2f..%2f..%2fetc%2fpasswd"),
                                 std::string("%2e%2e/%2E%2E/%2e%2e/%2e%2e/etc/passwd"),
                                 std::string("%252e%252e/etc/passwd"),
                                 std::string("x.txt/../../../../etc/passwd"),
                                 std::string("/etc/passwd"),
                                 std::string("%2fetc%2fpasswd"),
                                 std::string("//etc/passwd"),
                                 std::string("etc/passwd"),
                                 std::string("zeros"),
                                 std::string("loop_a"),
                                 std::string("pipe"),
                                 std::string("."),
                                 std::string(".."),
                                 std::string("./"),
                                 std::string("x.txt/"),
                                 std::string("x.txt%00.bin"),
                                 std::string("file:///etc/passwd"),
                                 std::string("http://localhost/a.bin"),
                                 std::string("~/x"),
                                 std::string("C:\\x"),
                                 repeated("../", 5000) + "etc/passwd",
                                 repeated("a/", 5000),
                                 repeated("a", 5000)}) {
    GltfBuilder asset = GltfBuilder::one_triangle();
    asset.json["buffers"] = {{{"byteLength", asset.bin.size()}, {"uri", uri}}};
    const std::string file = asset.json.dump();
    const Outcome outcome = read_measured(file, folder.path("asset"));
    expect_modest(outcome, file);
    ASSERT_FALSE(outcome.scene.ok()) << uri;
    EXPECT_EQ(outcome.scene.error().element, "/buffers/0/uri") << uri;
    EXPECT_EQ(outcome.scene.error().problem.find("root:"), std::string::npos);
  }
}

// --- Content that must not make a file invalid ---------------------------------------------------

TEST(HostileGltf, UnusedContentMayBeInvalid) {
  for (const char* text :
       {R"("images":[{"bufferView":4000000000},{"uri":"pipe"},{"uri":"data:image/png;base64,!"}])",
        R"("cameras":[{"type":"telescope"},7,{}])", R"("textures":[{"source":-3}])",
        R"("samplers":{"a":[1e308]})", R"("extras":[null,[[]],{"":""}])",
        R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":5},[]]}})"}) {
    EXPECT_EQ(read_or_fail(triangle_with(text)).meshes.size(), 1u) << text;
  }
}

TEST(HostileGltf, TenThousandWarningsAreCountedNotListed) {
  const std::string file = triangle_with("\"extensionsUsed\":" + list_of("\"VENDOR_x\"", 10000));
  const SceneDescription scene = read_or_fail(file);
  EXPECT_EQ(scene.warnings.size(), kMaxGltfWarnings + 1);
  expect_refused(triangle_with("\"extensionsRequired\":" + list_of("\"VENDOR_x\"", 10000)),
                 ErrorCode::kUnsupported, "/extensionsRequired/0");
}

TEST(HostileGltf, MessagesAreShortForAnyQuotedText) {
  const std::string lengthy = repeated("n", 1000000);
  for (const std::string& file :
       {triangle_with("\"extensionsRequired\":[\"" + lengthy + "\"]"),
        triangle_with("\"scene\":\"" + lengthy + "\""),
        triangle_with("\"asset\":{\"version\":\"" + lengthy + "\"}"),
        triangle_with("\"buffers\":[{\"byteLength\":42,\"uri\":\"" + lengthy + "\"}]"),
        triangle_with("\"meshes\":[{\"primitives\":[{\"attributes\":{\"" + lengthy + "\":9}}]}]"),
        "{" + kAsset + ",\"" + lengthy + "\":tru}"}) {
    const Outcome outcome = read_measured(file, "/nowhere");
    expect_modest(outcome, file);
    ASSERT_FALSE(outcome.scene.ok());
    EXPECT_LT(outcome.scene.error().to_string().size(), 1000u);
  }
}

}  // namespace
}  // namespace palpate
