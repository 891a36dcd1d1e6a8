// Files: containers, their JSON and their buffers, read and refused.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <sys/stat.h>
#include <utility>
#include <vector>

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
using test::random_points;
using test::read_glb;
using test::read_or_fail;
using test::TemporaryFolder;

// ---- containers --------------------------------------------------------------------------------

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

// ---- JSON --------------------------------------------------------------------------------------

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

TEST(GltfReader, RefusesNumbersBeyondDouble) {
  const TemporaryFolder folder;
  for (const char* number : {"1e999", "-1e999", "NaN", "Infinity"}) {
    const std::string text =
        std::string(R"({"asset":{"version":"2.0"},"nodes":[{"scale":[1,)") + number + ",1]}]}";
    expect_file_refused(GltfBuilder::write_text(folder, text), ErrorCode::kInvalidContent, "JSON");
  }
}

// ---- buffers -----------------------------------------------------------------------------------

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

}  // namespace
}  // namespace palpate
