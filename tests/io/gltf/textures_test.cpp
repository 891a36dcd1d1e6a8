#include <array>
#include <cmath>
#include <cstdint>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <filesystem>
#include <limits>
#include <meshoptimizer.h>
#include <string>
#include <turbojpeg.h>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/png_writer.h"
#include "tests/io/gltf/extension_names.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::add_floats;
using test::add_numbers;
using test::expect_invalid;
using test::expect_refused;
using test::GltfBuilder;
using test::kHaptic;
using test::png_of;
using test::read_glb;
using test::TemporaryFolder;
using Samples = std::vector<std::uint16_t>;
using Coordinates = std::vector<std::array<double, 2>>;

std::string grey_pixel() {
  return png_of({1, 1, 8, 0}, {128});
}

// One triangle whose material requires its normal texture, texture 0 of image 0, with TEXCOORD_0:
// (0,0), (1,0), (0,1). The image has no data yet.
GltfBuilder asset_without_data() {
  GltfBuilder asset = GltfBuilder::one_triangle();
  Json& primitive = asset.json["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  primitive["attributes"]["TEXCOORD_0"] = add_floats(asset, {0, 0, 1, 0, 0, 1}, "VEC2");
  asset.json["materials"] = Json::array(
      {{{"normalTexture", {{"index", 0}}}, {"extras", {{"palpate", {{"textureHeight", 0.001}}}}}}});
  asset.json["textures"] = Json::array({{{"source", 0}}});
  asset.json["images"] = Json::array({Json::object()});
  return asset;
}

// The image is in a buffer view.
GltfBuilder asset_with(const std::string& image) {
  GltfBuilder asset = asset_without_data();
  asset.json["images"][0]["bufferView"] = asset.add_view(image);
  return asset;
}

Json& primitive_attributes_of(GltfBuilder& asset) {
  return asset.json["meshes"][0]["primitives"][0]["attributes"];
}

Json& normal_texture_of(GltfBuilder& asset) {
  return asset.json["materials"][0]["normalTexture"];
}

Json haptic_map(const Json& texture) {
  return {{"texture", texture}, {"type", "Other"}};
}

// Gives mesh 0 a haptic material with these maps.
void bind_haptic(GltfBuilder& asset, const Json& material) {
  asset.json["extensionsUsed"] = {kHaptic};
  asset.json["extensions"][kHaptic]["materials"] = Json::array({material});
  asset.json["meshes"][0]["extensions"][kHaptic]["hapticMaterialIndex"] = 0;
}

// --- Pixels --------------------------------------------------------------------------------------

ImageDescription decoded(const std::string& image) {
  const auto scene = read_glb(asset_with(image));
  EXPECT_EQ(scene.images.size(), 1u);
  return scene.images.empty() ? ImageDescription{} : scene.images[0];
}

TEST(GltfTextures, KeepAllDigitsOf16Bits) {
  const Samples samples = {0, 1, 2, 255, 256, 257, 32767, 32768, 40000, 65279, 65534, 65535};
  const ImageDescription image = decoded(png_of({2, 2, 16, 2}, samples));
  EXPECT_EQ(image.width, 2u);
  EXPECT_EQ(image.height, 2u);
  EXPECT_EQ(image.rgb, samples);
  EXPECT_EQ(decoded(png_of({2, 1, 16, 0}, {1, 65534})).rgb,
            (Samples{1, 1, 1, 65534, 65534, 65534}));
}

TEST(GltfTextures, AreScaledFrom8To16Bits) {
  EXPECT_EQ(decoded(png_of({1, 3, 8, 2}, {0, 1, 2, 3, 4, 5, 253, 254, 255})).rgb,
            (Samples{0, 257, 514, 771, 1028, 1285, 65021, 65278, 65535}));
  EXPECT_EQ(decoded(grey_pixel()).rgb, Samples(3, 128 * 257));
  EXPECT_EQ(decoded(png_of({2, 1, 8, 3}, {3, 1})).rgb,
            (Samples{0x4040, 0, 0, 0x2020, 0, 0}));  // of a palette
}

TEST(GltfTextures, AreNotAffectedByTransparency) {
  EXPECT_EQ(decoded(png_of({1, 1, 8, 6}, {10, 20, 30, 0})).rgb,
            (Samples{10 * 257, 20 * 257, 30 * 257}));
  EXPECT_EQ(decoded(png_of({1, 1, 16, 6}, {10, 20, 30, 7})).rgb, (Samples{10, 20, 30}));
  EXPECT_EQ(decoded(png_of({1, 1, 16, 4}, {300, 0})).rgb, (Samples{300, 300, 300}));
}

TEST(GltfTextures, AreCompleteIfWiderThanABlockOfData) {
  Samples samples;
  for (std::uint32_t i = 0; i < 300 * 200 * 3; ++i) {
    samples.push_back(static_cast<std::uint16_t>(i * 2654435761u >> 16));
  }
  EXPECT_EQ(decoded(png_of({300, 200, 16, 2}, samples)).rgb, samples);
}

// One grey: at quality 100 its only coefficient is quantised by 1, so nothing is lost.
std::string jpeg_of(int width, int height, std::uint8_t grey) {
  const tjhandle encoder = tjInitCompress();
  const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width * height), grey);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(encoder, pixels.data(), width, 0, height, TJPF_GRAY, &data, &size,
                        TJSAMP_GRAY, 100, 0),
            0);
  const std::string file(reinterpret_cast<const char*>(data), size);
  tjFree(data);
  tjDestroy(encoder);
  return file;
}

TEST(GltfTextures, AreReadFromJpeg) {
  const ImageDescription image = decoded(jpeg_of(20, 10, 77));
  EXPECT_EQ(image.width, 20u);
  EXPECT_EQ(image.height, 10u);
  EXPECT_EQ(image.rgb, Samples(20 * 10 * 3, 77 * 257));
}

// --- Where images come from ----------------------------------------------------------------------

TEST(GltfTextures, ComeFromDataUrisAndFilesAsBuffersDo) {
  GltfBuilder asset = asset_without_data();
  asset.json["images"][0]["uri"] = "data:image/png;base64," + test::base64_encoded(grey_pixel());
  EXPECT_EQ(read_glb(asset).images.at(0).rgb, Samples(3, 128 * 257));

  const TemporaryFolder folder;
  folder.write("maps/a b.png", png_of({1, 1, 16, 0}, {1234}));
  asset.json["images"][0]["uri"] = "maps/a%20b.png";
  const auto scene = read_gltf(asset.write_gltf(folder));
  ASSERT_TRUE(scene.ok()) << scene.error().to_string();
  EXPECT_EQ(scene->images.at(0).rgb, Samples(3, 1234));
}

TEST(GltfTextures, AreNotReadFromOutsideTheFolder) {
  const TemporaryFolder folder;
  folder.write("secret.png", grey_pixel());
  folder.write("inside/ok.png", grey_pixel());
  std::filesystem::create_symlink(folder.path("secret.png"), folder.path("inside/link.png"));
  for (const std::string uri : {"../secret.png", "%2e%2e/secret.png", "link.png", "inside/../../x",
                                "/etc/hostname", "file:///etc/hostname", "http://a/b.png", ".", "",
                                "missing.png", "data:image/png,abc", "data:image/png;base64,***"}) {
    SCOPED_TRACE(uri);
    GltfBuilder asset = asset_without_data();
    asset.json["images"][0]["uri"] = uri;
    const auto scene = read_gltf(folder.write("inside/asset.glb", asset.glb_bytes()));
    ASSERT_FALSE(scene.ok());
    EXPECT_EQ(scene.error().element, "/images/0/uri");
    EXPECT_NE(scene.error().hint.find("textureHeight of /materials/0"), std::string::npos)
        << scene.error().to_string();
  }
}

TEST(GltfTextures, AreRefusedWithoutExactlyOneSource) {
  expect_invalid(asset_without_data(), "/images/0", "neither");
  GltfBuilder asset = asset_with(grey_pixel());
  asset.json["images"][0]["uri"] = "a.png";
  expect_invalid(asset, "/images/0", "both");
  asset.json["images"][0] = {{"bufferView", 99}};
  expect_invalid(asset, "/images/0/bufferView", "an index");
  asset.json["images"][0] = {{"uri", 7}};
  expect_invalid(asset, "/images/0/uri", "a string");
  asset.json["textures"][0] = {{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}};
  expect_refused(asset, ErrorCode::kUnsupported, "/textures/0/source", "PNG or JPEG");
}

// --- Hostile images ------------------------------------------------------------------------------

TEST(GltfTextures, AreRefusedInOtherFormats) {
  for (const std::string image :
       {"GIF89a\1\0\1\0", "RIFF\4\0\0\0WEBP", "not an image", "\x89PNG", "P6 1 1 255 abc", "BM"}) {
    expect_refused(asset_with(image), ErrorCode::kUnsupported, "/images/0", "PNG");
  }
}

TEST(GltfTextures, AreRefusedByTheirHeaderIfTooLarge) {
  for (const auto& [width, height] :
       {std::pair<std::uint32_t, std::uint32_t>{8193, 1}, {1, 8193}, {0x7fffffff, 0x7fffffff}}) {
    expect_refused(asset_with(png_of({width, height, 8, 0}, {1, 2})), ErrorCode::kLimitExceeded,
                   "/images/0", "8192 x 8192");
  }
  std::string jpeg = jpeg_of(16, 16, 5);
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  jpeg[frame + 5] = jpeg[frame + 7] = '\x7f';  // the high bytes of height and width
  expect_refused(asset_with(jpeg), ErrorCode::kLimitExceeded, "/images/0", "8192 x 8192");
  expect_invalid(asset_with(png_of({0, 1, 8, 0}, {})), "/images/0");
}

TEST(GltfTextures, AreRefusedIfTheirPixelsExceedTheTotal) {
  GltfBuilder asset = asset_with(grey_pixel());
  asset.json["textures"].push_back({{"source", 1}});
  asset.json["images"].push_back({{"bufferView", asset.add_view(png_of({8192, 8192, 8, 0}, {1}))}});
  bind_haptic(asset, {{"friction", {haptic_map({{"index", 1}})}}});
  expect_refused(asset, ErrorCode::kLimitExceeded, "/images/1",
                 std::to_string(kMaxGltfPixels - 1) + " of a scene");
}

TEST(GltfTextures, AreRefusedIfTruncated) {
  for (const std::string& image :
       {png_of({3, 2, 16, 2}, Samples(18, 500)), png_of({4, 4, 8, 6}, Samples(64, 9))}) {
    constexpr std::size_t kEndChunk = 12;  // nothing depends on it
    for (std::size_t size = 8; size < image.size() - kEndChunk - 4; ++size) {
      expect_invalid(asset_with(image.substr(0, size)), "/images/0");
    }
  }
  const std::string jpeg = jpeg_of(64, 64, 200);
  for (std::size_t size = 3; size < jpeg.size() - 2; ++size) {
    expect_invalid(asset_with(jpeg.substr(0, size)), "/images/0");
  }
  expect_invalid(asset_with(png_of({3, 2, 8, 0}, {1, 2, 3})), "/images/0");  // one row of two
}

// Data after the last pixel and its checksum are not read.
TEST(GltfTextures, AreRefusedWithADamagedPixel) {
  const std::string image = png_of({2, 2, 8, 0}, {1, 2, 3, 4});
  constexpr std::size_t kHeadOfStream =
      2 + 5;  // before the first row; each row begins with a filter
  const std::size_t first_row = image.find("IDAT") + 4 + kHeadOfStream;
  constexpr std::size_t kChecksum = 4;
  for (std::size_t i = first_row; i < first_row + 2 * 3 + kChecksum; ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = image;
      damaged[i] = static_cast<char>(damaged[i] ^ 1 << bit);
      expect_invalid(asset_with(damaged), "/images/0");
    }
  }
}

// --- Required images -----------------------------------------------------------------------------

TEST(GltfTextures, AreNotOpenedUnlessRequired) {
  GltfBuilder asset = asset_with("no image");
  asset.json["materials"][0].erase("extras");
  asset.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  bind_haptic(asset, {{"stiffness", {haptic_map({{"index", 0}})}}});
  const auto scene = read_glb(asset);
  EXPECT_TRUE(scene.images.empty());
  EXPECT_TRUE(scene.meshes.at(0).texture_uv.empty());
  EXPECT_TRUE(scene.meshes.at(0).friction_uv.empty());
  EXPECT_FALSE(scene.materials.at(0).normal_texture->pixels);
  EXPECT_EQ(texture_map(scene.materials[0], &scene.haptic_materials.at(0)), nullptr);
  EXPECT_EQ(friction_map(&scene.haptic_materials[0]), nullptr);
  EXPECT_EQ(friction_map(nullptr), nullptr);

  // A height set by an override requires the image.
  const TemporaryFolder folder;
  const auto called =
      read_gltf(asset.write_glb(folder), {{{"material 0", "textureHeight", "0.1"}}});
  ASSERT_FALSE(called.ok());
  EXPECT_EQ(called.error().element, "/meshes/0/primitives/0/attributes/TEXCOORD_0");
}

TEST(GltfTextures, OfTheHapticMaterialTakePrecedence) {
  GltfBuilder asset = asset_with("no image");  // of the normal texture
  asset.json["textures"] = {{{"source", 0}}, {{"source", 1}}, {{"source", 2}}};
  asset.json["images"].push_back({{"bufferView", asset.add_view(png_of({1, 1, 8, 0}, {1}))}});
  asset.json["images"].push_back({{"bufferView", asset.add_view(png_of({1, 1, 8, 0}, {2}))}});
  bind_haptic(asset,
              {{"vibrotactileTexture", {haptic_map({{"index", 2}}), haptic_map({{"index", 0}})}},
               {"friction", {haptic_map({{"index", 1}}), haptic_map({{"index", 0}})}},
               {"temperature", {haptic_map({{"index", 0}})}}});
  for (const bool with_height : {true, false}) {
    if (!with_height) asset.json["materials"][0].erase("extras");
    const auto scene = read_glb(asset);
    ASSERT_EQ(scene.images.size(), 2u);
    const auto* haptic = &scene.haptic_materials.at(0);
    const TextureReference* texture = texture_map(scene.materials.at(0), haptic);
    const TextureReference* friction = friction_map(haptic);
    ASSERT_TRUE(texture && friction && texture->pixels && friction->pixels);
    EXPECT_EQ(texture->texture, 2u);
    EXPECT_EQ(friction->texture, 1u);
    EXPECT_EQ(scene.images.at(*texture->pixels).rgb, Samples(3, 2 * 257));
    EXPECT_EQ(scene.images.at(*friction->pixels).rgb, Samples(3, 257));
    EXPECT_FALSE(scene.materials[0].normal_texture->pixels);
    EXPECT_EQ(scene.meshes.at(0).texture_uv.size(), 3u);
    EXPECT_EQ(scene.meshes.at(0).friction_uv.size(), 3u);
  }
}

TEST(GltfTextures, OfAHapticMaterialNeedNoGltfMaterial) {
  GltfBuilder asset = asset_with(grey_pixel());
  asset.json["meshes"][0]["primitives"][0].erase("material");
  bind_haptic(asset, {{"vibrotactileTexture", {haptic_map({{"index", 0}})}}});
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.meshes.at(0).texture_uv.size(), 3u);
  EXPECT_TRUE(scene.meshes.at(0).friction_uv.empty());
}

TEST(GltfTextures, ShareOneImage) {
  GltfBuilder asset = asset_with(grey_pixel());
  asset.json["textures"].push_back({{"source", 0}});
  Json other = asset.json["materials"][0];
  other["normalTexture"]["index"] = 1;
  asset.json["materials"].push_back(other);
  Json primitive = asset.json["meshes"][0]["primitives"][0];
  primitive["material"] = 1;
  asset.json["meshes"][0]["primitives"].push_back(primitive);
  bind_haptic(asset, {{"friction", {haptic_map({{"index", 0}})}}});
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.images.size(), 1u);
  for (const MaterialDescription& material : scene.materials) {
    EXPECT_EQ(material.normal_texture->pixels, 0u);
  }
  EXPECT_EQ(friction_map(&scene.haptic_materials.at(0))->pixels, 0u);
}

TEST(GltfTextures, HaveABoundedNumberOfMaps) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["textures"] = Json::array({Json::object()});
  const std::vector<Json> maps(128, haptic_map({{"index", 0}}));
  Json material = {{"custom", maps}, {"stiffness", maps}};
  bind_haptic(asset, material);
  EXPECT_EQ(read_glb(asset).haptic_materials.at(0).maps.size(), kMaxGltfHapticMaps);
  material["vibration"] = Json::array({haptic_map({{"index", 0}})});
  bind_haptic(asset, material);
  expect_refused(asset, ErrorCode::kLimitExceeded,
                 "/extensions/MPEG_haptic_material/materials/0/custom");
}

// --- Samplers ------------------------------------------------------------------------------------

TEST(GltfTextures, WrapAsTheirSamplerStates) {
  GltfBuilder asset = asset_with(grey_pixel());
  const auto wraps = [&] {
    const auto texture = read_glb(asset).materials.at(0).normal_texture;
    return std::pair(texture->wrap_u, texture->wrap_v);
  };
  EXPECT_EQ(wraps(), std::pair(TextureWrap::kRepeat, TextureWrap::kRepeat));
  asset.json["textures"][0]["sampler"] = 1;
  asset.json["samplers"] = {{{"wrapS", 33071}}, Json::object()};
  EXPECT_EQ(wraps(), std::pair(TextureWrap::kRepeat, TextureWrap::kRepeat));
  asset.json["samplers"][1] = {{"wrapS", 33071}, {"wrapT", 33648}};
  EXPECT_EQ(wraps(), std::pair(TextureWrap::kClamp, TextureWrap::kMirror));
  asset.json["samplers"][1] = {{"wrapS", 33648}, {"wrapT", 10497}};
  EXPECT_EQ(wraps(), std::pair(TextureWrap::kMirror, TextureWrap::kRepeat));
  asset.json["samplers"][1] = {{"wrapT", 1}};
  expect_invalid(asset, "/samplers/1/wrapT", "33071");
  asset.json["samplers"][1] = 3;
  expect_invalid(asset, "/samplers/1", "an object");
  asset.json["textures"][0]["sampler"] = 2;
  expect_invalid(asset, "/textures/0/sampler", "has 2 elements");
}

// --- Texture coordinates -------------------------------------------------------------------------

void expect_near(const Coordinates& found, const Coordinates& expected, double tolerance = 0.0) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i][0], expected[i][0], tolerance) << "u of " << i;
    EXPECT_NEAR(found[i][1], expected[i][1], tolerance) << "v of " << i;
  }
}

TEST(GltfTextureCoordinates, AreThoseOfTheChosenSet) {
  GltfBuilder asset = asset_with(grey_pixel());
  primitive_attributes_of(asset)["TEXCOORD_2"] =
      add_floats(asset, {5, 6, -7, 8.5f, 0.25f, 1e30f}, "VEC2");
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv, (Coordinates{{0, 0}, {1, 0}, {0, 1}}));
  const Coordinates second = {{5, 6}, {-7, 8.5}, {0.25, double{1e30f}}};
  normal_texture_of(asset)["texCoord"] = 2;
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv, second);
  normal_texture_of(asset)["texCoord"] = 0;
  normal_texture_of(asset)["extensions"]["KHR_texture_transform"] = {{"texCoord", 2}};
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv, second);
}

TEST(GltfTextureCoordinates, AreScaledThenRotatedThenTranslated) {
  GltfBuilder asset = asset_with(grey_pixel());
  Json& transform = normal_texture_of(asset)["extensions"]["KHR_texture_transform"];
  const auto transformed = [&] { return read_glb(asset).meshes.at(0).texture_uv; };
  transform = {{"offset", {0, 1}},
               {"scale", {1, -1}}};  // the extension's example of a lower left origin
  EXPECT_EQ(transformed(), (Coordinates{{0, 1}, {1, 1}, {0, 0}}));
  transform = {{"offset", {0.5, -2}}, {"scale", {3, 4}}};
  EXPECT_EQ(transformed(), (Coordinates{{0.5, -2}, {3.5, -2}, {0.5, 2}}));
  // From the extension: "only the lower left quadrant of the source image, rotated clockwise 90
  // degrees". The cosine of the angle nearest to a quarter turn is not zero.
  transform = {{"offset", {0, 1}}, {"rotation", std::acos(0.0)}, {"scale", {0.5, 0.5}}};
  expect_near(transformed(), {{0, 1}, {0, 0.5}, {0.5, 1}}, std::numeric_limits<double>::epsilon());
  // Rotates by atan(3/4), from larger u towards smaller v.
  transform = {{"rotation", std::atan2(3.0, 4.0)}, {"scale", {5, 10}}};
  expect_near(transformed(), {{0, 0}, {4, -3}, {6, 8}},
              16 * std::numeric_limits<double>::epsilon());
}

TEST(GltfTextureCoordinates, AreFractionsForNormalisedIntegers) {
  GltfBuilder asset = asset_with(grey_pixel());
  primitive_attributes_of(asset)["TEXCOORD_0"] = add_numbers<std::uint8_t>(
      asset, {0, 255, 51, 102, 1, 254}, GltfBuilder::kUnsignedByte, "VEC2", true);
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv,
            (Coordinates{{0, 1}, {51 / 255.0, 102 / 255.0}, {1 / 255.0, 254 / 255.0}}));
  primitive_attributes_of(asset)["TEXCOORD_0"] = add_numbers<std::uint16_t>(
      asset, {0, 65535, 13107, 1, 2, 3}, GltfBuilder::kUnsignedShort, "VEC2", true);
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv,
            (Coordinates{{0, 1}, {13107 / 65535.0, 1 / 65535.0}, {2 / 65535.0, 3 / 65535.0}}));
}

TEST(GltfTextureCoordinates, NeedQuantizationForOtherIntegers) {
  GltfBuilder asset = asset_with(grey_pixel());
  const auto shorts =
      add_numbers<std::int16_t>(asset, {-3, 7, 300, -32768, 0, 1}, GltfBuilder::kShort, "VEC2");
  const auto bytes =
      add_numbers<std::int8_t>(asset, {-127, 127, -128, 0, 1, 2}, GltfBuilder::kByte, "VEC2", true);
  const auto words = add_numbers<std::uint16_t>(asset, {1, 2, 3, 4, 5, 60000},
                                                GltfBuilder::kUnsignedShort, "VEC2");
  for (const auto accessor : {shorts, bytes, words}) {
    primitive_attributes_of(asset)["TEXCOORD_0"] = accessor;
    expect_invalid(asset, "/accessors/" + std::to_string(accessor) + "/componentType",
                   "texture coordinates");
  }
  asset.json["extensionsUsed"] = {"KHR_mesh_quantization"};
  normal_texture_of(asset)["extensions"]["KHR_texture_transform"] = {{"scale", {0.5, 0.25}}};
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv,
            (Coordinates{{0.5, 0.5}, {1.5, 1}, {2.5, 15000}}));
  primitive_attributes_of(asset)["TEXCOORD_0"] = shorts;
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv,
            (Coordinates{{-1.5, 1.75}, {150, -8192}, {0, 0.25}}));
  primitive_attributes_of(asset)["TEXCOORD_0"] = bytes;
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv,
            (Coordinates{{-0.5, 0.25}, {-0.5, 0}, {0.5 / 127, 0.25 * (2 / 127.0)}}));
}

TEST(GltfTextureCoordinates, AreRefusedIfMissingOrInvalid) {
  const std::string element = "/meshes/0/primitives/0/attributes/TEXCOORD_";
  GltfBuilder asset = asset_with(grey_pixel());
  normal_texture_of(asset)["texCoord"] = 1;
  expect_invalid(asset, element + "1", "missing");
  primitive_attributes_of(asset)["TEXCOORD_1"] = add_floats(asset, {0, 0, 1, 1}, "VEC2");
  expect_invalid(asset, element + "1", "2 elements");
  const auto of_scalars = add_numbers<float>(asset, {0, 0, 1}, GltfBuilder::kFloat, "SCALAR");
  primitive_attributes_of(asset)["TEXCOORD_1"] = of_scalars;
  expect_invalid(asset, "/accessors/" + std::to_string(of_scalars) + "/type", "VEC2");
  const float infinity = std::numeric_limits<float>::infinity();
  const auto infinite = add_floats(asset, {0, 0, 1, 1, 0, infinity}, "VEC2");
  primitive_attributes_of(asset)["TEXCOORD_1"] = infinite;
  expect_invalid(asset, "/accessors/" + std::to_string(infinite), "element 2 is not finite");
  primitive_attributes_of(asset)["TEXCOORD_1"] = add_floats(asset, {0, 0, 1, 1, 3, 4}, "VEC2");
  normal_texture_of(asset)["extensions"]["KHR_texture_transform"] = {{"scale", {1e308, 1}}};
  expect_invalid(asset, element + "1", "element 2");
}

// The positions of all corners of triangles, and their coordinates.
TEST(GltfTextureCoordinates, AllowSharedVerticesOnlyIfEqual) {
  GltfBuilder asset = asset_with(grey_pixel());
  Json& primitives = asset.json["meshes"][0]["primitives"];
  const Json first = primitives[0];
  Json elsewhere = first;
  elsewhere["attributes"]["TEXCOORD_0"] = add_floats(asset, {9, 9, 8, 8, 7, 7}, "VEC2");
  Json without = first;
  without.erase("material");
  Json same_map = first;
  same_map["material"] = 1;
  Json turned = first;
  turned["material"] = 2;
  const Json material = asset.json["materials"][0];
  asset.json["materials"].push_back(material);
  asset.json["materials"].push_back(material);
  asset.json["materials"][2]["normalTexture"]["extensions"]["KHR_texture_transform"]["offset"] = {
      10, 20};
  primitives = {without, first, elsewhere, same_map, turned, first, without};
  const auto scene = read_glb(asset);
  const MeshDescription& mesh = scene.meshes.at(0);
  ASSERT_EQ(mesh.positions.size(), 12u);
  EXPECT_EQ(mesh.texture_uv, (Coordinates{{0, 0},
                                          {0, 0},
                                          {0, 0},  // without
                                          {0, 0},
                                          {1, 0},
                                          {0, 1},  // first
                                          {9, 9},
                                          {8, 8},
                                          {7, 7},  // elsewhere
                                          {10, 20},
                                          {11, 20},
                                          {10, 21}}));  // turned
  ASSERT_EQ(mesh.triangles.size(), 7u);
  const std::vector<std::uint32_t> first_vertices = {0, 3, 6, 3, 9, 3, 0};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(mesh.triangles[i][0], first_vertices[i]) << i;
  EXPECT_TRUE(mesh.friction_uv.empty());
}

TEST(GltfTextureCoordinates, AreZeroAfterTheLastMap) {
  GltfBuilder asset = asset_with(grey_pixel());
  Json without = asset.json["meshes"][0]["primitives"][0];
  without.erase("material");
  without["attributes"]["POSITION"] = asset.add_positions({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
  asset.json["meshes"][0]["primitives"].push_back(without);
  EXPECT_EQ(read_glb(asset).meshes.at(0).texture_uv,
            (Coordinates{{0, 0}, {1, 0}, {0, 1}, {0, 0}, {0, 0}, {0, 0}}));
}

TEST(GltfTextureCoordinates, OfTextureAndFrictionAreSeparate) {
  GltfBuilder asset = asset_with(grey_pixel());
  primitive_attributes_of(asset)["TEXCOORD_1"] = add_floats(asset, {3, 3, 4, 4, 5, 5}, "VEC2");
  bind_haptic(asset, {{"friction", {haptic_map({{"index", 0}, {"texCoord", 1}})}}});
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.meshes.at(0).texture_uv, (Coordinates{{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_EQ(scene.meshes.at(0).friction_uv, (Coordinates{{3, 3}, {4, 4}, {5, 5}}));
}

// --- Compressed coordinates ----------------------------------------------------------------------

const std::vector<std::array<float, 3>> kPoints = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<std::array<float, 2>> kUv = {{0, 0}, {1, 0}, {0, 1}, {0.5f, 0.25f}};
const std::vector<std::uint32_t> kFaces = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

template <std::size_t N>
void add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type,
                   const std::vector<std::array<float, N>>& values) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, N, draco::DT_FLOAT32, false, N * sizeof(float), 0);
  const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(values.size()));
  for (std::uint32_t v = 0; v < values.size(); ++v) {
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), values[v].data());
  }
}

// Not quantised. Attributes 0 and 1: positions and coordinates.
std::string draco_stream() {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(kPoints.size()));
  add_attribute(mesh, draco::GeometryAttribute::POSITION, kPoints);
  add_attribute(mesh, draco::GeometryAttribute::TEX_COORD, kUv);
  for (std::size_t i = 0; i < kFaces.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(kFaces[i]), draco::PointIndex(kFaces[i + 1]),
                  draco::PointIndex(kFaces[i + 2])});
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  return {buffer.data(), buffer.size()};
}

// Each position has its own coordinates, whatever the order.
void expect_matched(const MeshDescription& mesh) {
  ASSERT_EQ(mesh.texture_uv.size(), mesh.positions.size());
  ASSERT_EQ(mesh.triangles.size(), 4u);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    bool found = false;
    for (std::size_t k = 0; k < kPoints.size(); ++k) {
      const Vec3 point(kPoints[k][0], kPoints[k][1], kPoints[k][2]);
      if (mesh.positions[i] != point) continue;
      found = true;
      EXPECT_EQ(mesh.texture_uv[i], (std::array<double, 2>{kUv[k][0], kUv[k][1]}));
    }
    EXPECT_TRUE(found) << "position " << i;
  }
}

TEST(GltfTextureCoordinates, OfDracoMatchTheirPositions) {
  constexpr const char* kDraco = "KHR_draco_mesh_compression";
  GltfBuilder asset = asset_with(grey_pixel());
  Json& primitive = asset.json["meshes"][0]["primitives"][0];
  const std::size_t count = kPoints.size();
  asset.json["accessors"] = {
      {{"componentType", 5126}, {"count", count}, {"type", "VEC3"}},
      {{"componentType", 5123}, {"count", kFaces.size()}, {"type", "SCALAR"}},
      {{"componentType", 5126}, {"count", count}, {"type", "VEC2"}}};
  asset.json["extensionsUsed"] = {kDraco};
  primitive["attributes"]["TEXCOORD_0"] = 2;
  primitive["extensions"][kDraco] = {{"bufferView", asset.add_view(draco_stream())},
                                     {"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}};
  expect_matched(read_glb(asset).meshes.at(0));

  asset.json["accessors"][2]["type"] = "VEC3";
  expect_invalid(asset, "/accessors/2/type", "VEC2");
  primitive["attributes"].erase("TEXCOORD_0");
  primitive["extensions"][kDraco]["attributes"].erase("TEXCOORD_0");
  expect_invalid(asset, "/meshes/0/primitives/0/attributes/TEXCOORD_0", "missing");
}

TEST(GltfTextureCoordinates, OfMeshoptViewsAreRead) {
  constexpr const char* kMeshopt = "EXT_meshopt_compression";
  GltfBuilder asset = asset_with(grey_pixel());
  const std::size_t stride = sizeof kUv[0];
  std::string encoded(meshopt_encodeVertexBufferBound(kUv.size(), stride), '\0');
  encoded.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(encoded.data()),
                                            encoded.size(), kUv.data(), kUv.size(), stride));
  const std::size_t view = asset.add_view(encoded);
  Json& object = asset.json["bufferViews"][view];
  object["extensions"][kMeshopt] = {{"buffer", 0},
                                    {"byteOffset", object["byteOffset"]},
                                    {"byteLength", encoded.size()},
                                    {"byteStride", stride},
                                    {"count", kUv.size()},
                                    {"mode", "ATTRIBUTES"}};
  object["byteLength"] = kUv.size() * stride;
  object["byteStride"] = stride;
  asset.json["extensionsUsed"] = {kMeshopt};
  std::vector<Eigen::Vector3f> points;
  for (const auto& p : kPoints) points.emplace_back(p[0], p[1], p[2]);
  Json& primitive = asset.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["POSITION"] = asset.add_positions(points);
  primitive["attributes"]["TEXCOORD_0"] =
      asset.add_accessor(view, GltfBuilder::kFloat, kUv.size(), "VEC2");
  primitive["indices"] = asset.add_indices(kFaces);
  expect_matched(read_glb(asset).meshes.at(0));
}

}  // namespace
}  // namespace palpate
