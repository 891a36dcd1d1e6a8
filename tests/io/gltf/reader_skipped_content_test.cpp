// Content that carries no triangles, and extensions that the reader does not know.

#include <cstddef>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/io/gltf/reader_checks.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::expect_file_invalid;
using test::expect_file_refused;
using test::GltfBuilder;
using test::primitive_of;
using test::read_glb;

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

}  // namespace
}  // namespace palpate
