#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/gltf/limits.h"
#include "io/gltf/reader.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/io/gltf/extension_names.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::expect_invalid;
using test::expect_refused;
using test::GltfBuilder;
using test::kHaptic;
using test::read_glb;
using test::TemporaryFolder;

const Json kPath = {{"POSITION", 0}};
const char* const kPhysics = "KHR_physics_rigid_bodies";
const char* const kOldHaptic = "MPEG_material_haptic";

// One triangle that has material 0.
GltfBuilder asset_with_material(const Json& material) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["materials"] = Json::array({material});
  asset.json["meshes"][0]["primitives"][0]["material"] = 0;
  return asset;
}

GltfBuilder asset_declaring(const Json& palpate) {
  return asset_with_material({{"extras", {{"palpate", palpate}}}});
}

Json triangle_primitive() {
  return {{"attributes", kPath}, {"indices", 1}};
}

Json triangle_primitive(std::size_t material) {
  Json primitive = triangle_primitive();
  primitive["material"] = material;
  return primitive;
}

// The runs as "3: none" or "0: 2": the first triangle and its material.
std::vector<std::string> runs_of(const MeshDescription& mesh) {
  std::vector<std::string> runs;
  for (const MaterialRun& run : mesh.material_runs) {
    runs.push_back(std::to_string(run.first_triangle) + ": " +
                   (run.material ? std::to_string(*run.material) : "none"));
  }
  return runs;
}

using Runs = std::vector<std::string>;

// --- extras.palpate ------------------------------------------------------------------------------

TEST(GltfMaterials, KeepEveryKindOfParameterAsWritten) {
  GltfBuilder asset = asset_with_material(
      {{"name", "rubber"},
       {"extras",
        {{"note", "not ours"},
         {"palpate",
          {{"stiffness", 800.5},
           {"damping", -3},
           {"magnet", true},
           {"nonsense", "as it is"},
           {"gravity", {0, -9.81, 1e300}},
           {"empty", Json::array()},
           {"texture", {{"amplitude", 0.001}, {"kind", "grid"}, {"uv", {1, 2}}}}}}}}});
  const auto scene = read_glb(asset);
  ASSERT_EQ(scene.materials.size(), 1u);
  const MaterialDescription& material = scene.materials[0];
  EXPECT_EQ(material.name, "rubber");
  EXPECT_EQ(material.element, "/materials/0");
  EXPECT_FALSE(material.normal_texture);
  const std::vector<std::pair<std::string, MaterialValue>> expected = {
      {"damping", -3.0},
      {"empty", std::vector<double>{}},
      {"gravity", std::vector<double>{0.0, -9.81, 1e300}},
      {"magnet", true},
      {"nonsense", std::string("as it is")},
      {"stiffness", 800.5},
      {"texture.amplitude", 0.001},
      {"texture.kind", std::string("grid")},
      {"texture.uv", std::vector<double>{1.0, 2.0}}};
  ASSERT_EQ(material.parameters.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(material.parameters[i].key, expected[i].first);
    EXPECT_EQ(material.parameters[i].value, expected[i].second) << expected[i].first;
  }
  EXPECT_EQ(material.parameters[5].element, "/materials/0/extras/palpate/stiffness");
  EXPECT_EQ(material.parameters[6].element, "/materials/0/extras/palpate/texture/amplitude");
}

TEST(GltfMaterials, IgnoreOtherExtras) {
  for (const Json& extras : {Json("text"), Json(7), Json::array({1}), Json(nullptr),
                             Json({{"Palpate", 1}}), Json({{"palpate", Json::object()}})}) {
    const auto scene = read_glb(asset_with_material({{"extras", extras}}));
    ASSERT_EQ(scene.materials.size(), 1u);
    EXPECT_EQ(scene.materials[0].name, "material 0");
    EXPECT_TRUE(scene.materials[0].parameters.empty());
  }
}

TEST(GltfMaterials, AreRefusedByPathIfTheyCannotBeRepresented) {
  const std::string palpate = "/materials/0/extras/palpate";
  for (const Json& wrong : {Json(1), Json("soft"), Json::array(), Json(nullptr), Json(true)}) {
    expect_invalid(asset_declaring(wrong), palpate, "an object");
  }
  expect_invalid(asset_declaring({{"stiffness", nullptr}}), palpate + "/stiffness", "null");
  expect_invalid(asset_declaring({{"gravity", {1, "2", 3}}}), palpate + "/gravity/1", "a number");
  expect_invalid(asset_declaring({{"gravity", {1, {2}}}}), palpate + "/gravity/1", "an array");
  expect_invalid(asset_declaring({{"texture", {{"amplitude", nullptr}}}}),
                 palpate + "/texture/amplitude");
  expect_invalid(asset_declaring({{"texture", {{"wave", {{"length", 1}}}}}}),
                 palpate + "/texture/wave", "an object");
  expect_invalid(asset_declaring({{"texture.amplitude", 1}}), palpate, "without a dot");
  expect_invalid(asset_declaring({{"texture", {{"a.b", 1}}}}), palpate + "/texture", "a.b");
}

TEST(GltfMaterials, HaveBoundedKeysAndLists) {
  const std::string longest(32, 'k');
  const auto scene = read_glb(
      asset_declaring({{longest, std::vector<int>(16, 1)}, {"text", std::string(99, 'x')}}));
  EXPECT_EQ(scene.materials.at(0).parameters.at(0).key, longest);
  EXPECT_EQ(scene.materials.at(0).parameters.at(0).value,
            MaterialValue(std::vector<double>(16, 1.0)));
  expect_invalid(asset_declaring({{longest + "k", 1}}), "/materials/0/extras/palpate", "33 bytes");
  expect_invalid(asset_declaring({{"list", std::vector<int>(17, 1)}}),
                 "/materials/0/extras/palpate/list", "17 elements");
}

TEST(GltfMaterials, HaveABoundedNumberOfParameters) {
  Json palpate = {{"inner", Json::object()}};
  for (int i = 0; i < 128; ++i) {
    palpate["a" + std::to_string(i)] = i;
    palpate["inner"]["b" + std::to_string(i)] = i;
  }
  EXPECT_EQ(read_glb(asset_declaring(palpate)).materials.at(0).parameters.size(), 256u);
  palpate["inner"]["z"] = 1;
  expect_invalid(asset_declaring(palpate), "/materials/0/extras/palpate/inner/z", "at most 256");
}

TEST(GltfMaterials, ANumberThatOverflowsIsRefused) {
  GltfBuilder asset = asset_declaring({{"stiffness", 12345}});
  asset.json["buffers"] = {
      {{"byteLength", asset.bin.size()},
       {"uri", "data:application/octet-stream;base64," + test::base64_encoded(asset.bin)}}};
  std::string text = asset.json.dump();
  text.replace(text.find("12345"), 5, "1e999");
  const TemporaryFolder folder;
  EXPECT_FALSE(read_gltf(GltfBuilder::write_text(folder, text)).ok());
}

TEST(GltfMaterials, AreRefusedForAWrongTypeIfATriangleUsesThem) {
  expect_invalid(asset_with_material("steel"), "/materials/0", "an object");
  expect_invalid(asset_with_material({{"name", 3}}), "/materials/0/name", "a string");
  GltfBuilder unused = GltfBuilder::one_triangle();
  unused.json["materials"] = {"steel", {{"extras", {{"palpate", 7}}}}};
  EXPECT_TRUE(read_glb(unused).materials.empty());
}

TEST(GltfMaterials, HaveABoundedTotalNumberOfParameters) {
  Json palpate;
  for (int i = 0; i < 256; ++i) palpate["a" + std::to_string(i)] = i;
  GltfBuilder asset = GltfBuilder::one_triangle();
  Json primitives = Json::array();
  for (std::size_t i = 0; i < kMaxGltfParameters / 256; ++i) {
    asset.json["materials"].push_back({{"extras", {{"palpate", palpate}}}});
    primitives.push_back(triangle_primitive(i));
  }
  asset.json["meshes"][0]["primitives"] = primitives;
  EXPECT_EQ(read_glb(asset).materials.size(), 256u);
  asset.json["scenes"][0]["extras"]["palpate"]["gravity"] = {0, 0, -1};
  expect_refused(asset, ErrorCode::kLimitExceeded, "/materials/255/extras/palpate/a99", "65536");
}

// --- Overrides -----------------------------------------------------------------------------------

using Overrides = std::vector<MaterialOverride>;

Result<SceneDescription> read_with(const GltfBuilder& asset, const Overrides& overrides) {
  const TemporaryFolder folder;
  return read_gltf(asset.write_glb(folder), {overrides});
}

// Expects an invalid argument, which the error names.
void expect_wrong(const GltfBuilder& asset, const MaterialOverride& setting,
                  const std::string& element, const std::string& text) {
  const auto scene = read_with(asset, {setting});
  ASSERT_FALSE(scene.ok()) << "accepted; expected an error at " << element;
  EXPECT_EQ(scene.error().code, ErrorCode::kInvalidArgument) << scene.error().to_string();
  EXPECT_EQ(scene.error().element, element);
  EXPECT_NE(scene.error().to_string().find(text), std::string::npos) << scene.error().to_string();
}

TEST(GltfMaterials, ApplyOverrides) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["materials"] = {
      {{"name", "skin"}, {"extras", {{"palpate", {{"damping", 3}, {"stiffness", 100}}}}}},
      {{"name", "bone"}},
      {{"name", "skin"}},
      Json::object()};
  asset.json["meshes"][0]["primitives"] = {triangle_primitive(0), triangle_primitive(1),
                                           triangle_primitive(2), triangle_primitive(3)};
  const auto scene = read_with(asset, {{"skin", "stiffness", "250.5"},
                                       {"skin", "solid", "false"},
                                       {"material 3", "texture.amplitude", "1"},
                                       {"material 3", "texture.amplitude", "2"}});
  ASSERT_TRUE(scene.ok()) << scene.error().to_string();
  ASSERT_EQ(scene->materials.size(), 4u);
  const auto& changed = scene->materials[0].parameters;
  ASSERT_EQ(changed.size(), 3u);
  EXPECT_EQ(changed[0].key, "damping");
  EXPECT_EQ(changed[0].element, "/materials/0/extras/palpate/damping");
  EXPECT_EQ(changed[1].key, "solid");
  EXPECT_EQ(changed[1].value, MaterialValue(false));
  EXPECT_EQ(changed[2].key, "stiffness");
  EXPECT_EQ(changed[2].value, MaterialValue(250.5));
  EXPECT_EQ(changed[2].element, "`SceneSettings::overrides` skin.stiffness");
  EXPECT_TRUE(scene->materials[1].parameters.empty());
  EXPECT_EQ(scene->materials[2].parameters.size(), 2u);  // of the same name
  ASSERT_EQ(scene->materials[3].parameters.size(), 1u);
  EXPECT_EQ(scene->materials[3].parameters[0].key, "texture.amplitude");
  EXPECT_EQ(scene->materials[3].parameters[0].value, MaterialValue(2.0));
}

TEST(GltfMaterials, ReadOverridesAsJsonElseAsText) {
  const std::vector<std::pair<std::string, MaterialValue>> expected = {
      {"1e3", 1000.0},
      {" -0.5 ", -0.5},
      {"true", true},
      {"\"1\"", std::string("1")},
      {"[0, 1, 2.5]", std::vector<double>{0, 1, 2.5}},
      {"[]", std::vector<double>{}},
      {"sliding", std::string("sliding")},
      {"", std::string()},
      {"1 mm", std::string("1 mm")},
      {"1e999", std::string("1e999")},
      {"[1, 2", std::string("[1, 2")}};
  for (const auto& [text, value] : expected) {
    SCOPED_TRACE(text);
    const auto scene = read_with(asset_with_material({{"name", "a"}}), {{"a", "key", text}});
    ASSERT_TRUE(scene.ok()) << scene.error().to_string();
    EXPECT_EQ(scene->materials.at(0).parameters.at(0).value, value);
  }
}

TEST(GltfMaterials, RejectOverridesThatNoMaterialCanHave) {
  const GltfBuilder asset = asset_with_material({{"name", "a"}});
  expect_wrong(asset, {"a", "key", "null"}, "`SceneSettings::overrides` a.key", "null");
  expect_wrong(asset, {"a", "key", "{\"b\": 1}"}, "`SceneSettings::overrides` a.key", "an object");
  expect_wrong(asset, {"a", "key", "[1, \"2\"]"}, "`SceneSettings::overrides` a.key/1", "a number");
  expect_wrong(asset, {"a", "key", "[1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1]"},
               "`SceneSettings::overrides` a.key", "17 elements");
  expect_wrong(asset, {"a", "", "1"}, "`SceneSettings::overrides` a.", "NAME.key");
  expect_wrong(asset, {"a", std::string(33, 'k'), "1"},
               "`SceneSettings::overrides` a." + std::string(33, 'k'), "33 bytes");
}

TEST(GltfMaterials, AreListedIfAnOverrideNamesAnUnknownOne) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  Json primitives = Json::array();
  for (std::size_t i = 0; i < 11; ++i) {
    asset.json["materials"].push_back({{"name", std::string(1, static_cast<char>('k' - i))}});
    if (i < 10) primitives.push_back(triangle_primitive(i));
  }
  asset.json["meshes"][0]["primitives"] = primitives;
  const std::string listed = R"("b", "c", "d", "e", "f", "g", "h", "i" and 2 more)";
  expect_wrong(asset, {"x", "key", "1"}, "`SceneSettings::overrides` x.key", listed);
  expect_wrong(asset, {"a", "key", "1"}, "`SceneSettings::overrides` a.key",
               listed);  // not used by a triangle
  expect_wrong(asset, {"default", "key", "1"}, "`SceneSettings::overrides` default.key", listed);
  expect_wrong(GltfBuilder::one_triangle(), {"x", "key", "1"}, "`SceneSettings::overrides` x.key",
               "there are \"default\"");
}

TEST(GltfMaterials, AreNamedDefaultForTrianglesWithoutAMaterial) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["materials"] = Json::array({{{"name", "steel"}}});
  asset.json["meshes"][0]["primitives"] = {triangle_primitive(), triangle_primitive(0),
                                           triangle_primitive()};
  asset.add_node({{"mesh", asset.add_mesh(Json::array({triangle_primitive()}))}});
  const auto scene = read_with(asset, {{"default", "stiffness", "5"}, {"default", "damping", "1"}});
  ASSERT_TRUE(scene.ok()) << scene.error().to_string();
  ASSERT_EQ(scene->materials.size(), 2u);
  EXPECT_EQ(scene->materials[1].name, "default");
  EXPECT_EQ(scene->materials[1].element, "default material");
  ASSERT_EQ(scene->materials[1].parameters.size(), 2u);
  EXPECT_EQ(scene->materials[1].parameters[1].element,
            "`SceneSettings::overrides` default.stiffness");
  EXPECT_EQ(runs_of(scene->meshes[0]), (Runs{"0: 1", "1: 0", "2: 1"}));
  EXPECT_EQ(runs_of(scene->meshes[1]), (Runs{"0: 1"}));

  const auto other = read_with(asset, {{"steel", "stiffness", "5"}});
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(runs_of(other->meshes[0]), (Runs{"0: none", "1: 0", "2: none"}));

  asset.json["materials"][0]["name"] = "default";  // so the name refers to this material
  const auto named = read_with(asset, {{"default", "stiffness", "5"}});
  ASSERT_TRUE(named.ok());
  EXPECT_EQ(runs_of(named->meshes[0]), (Runs{"0: none", "1: 0", "2: none"}));
  EXPECT_EQ(named->materials.at(0).parameters.size(), 1u);
}

// --- Scenes and nodes ----------------------------------------------------------------------------

TEST(GltfMaterials, SceneParametersAreThoseOfTheSceneRead) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  EXPECT_TRUE(read_glb(asset).scene_parameters.parameters.empty());
  asset.json["scenes"].push_back(asset.json["scenes"][0]);
  asset.json["scenes"][0]["extras"]["palpate"] = {{"toolMass", 7}};
  asset.json["scenes"][1]["extras"]["palpate"] = {{"gravity", {0, 0, -9.81}}, {"toolMass", 0.5}};
  EXPECT_EQ(read_glb(asset).scene_parameters.parameters.size(), 1u);
  asset.json["scene"] = 1;
  const MaterialDescription parameters = read_glb(asset).scene_parameters;
  EXPECT_EQ(parameters.name, "scene");
  EXPECT_EQ(parameters.element, "/scenes/1/extras/palpate");
  ASSERT_EQ(parameters.parameters.size(), 2u);
  EXPECT_EQ(parameters.parameters[0].value, MaterialValue(std::vector<double>{0, 0, -9.81}));
  EXPECT_EQ(parameters.parameters[1].element, "/scenes/1/extras/palpate/toolMass");
  asset.json["scenes"][1]["extras"]["palpate"] = 3;
  expect_invalid(asset, "/scenes/1/extras/palpate", "an object");
  asset.json["scenes"][1]["extras"]["palpate"] = {{"gravity", nullptr}};
  expect_invalid(asset, "/scenes/1/extras/palpate/gravity", "null");
  asset.json.erase("scene");
  asset.json.erase("scenes");
  EXPECT_TRUE(read_glb(asset).scene_parameters.parameters.empty());
}

TEST(GltfMaterials, NodeWithAMediumMakesARegion) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const Json sphere = {{"medium", "sphere"}, {"radius", 0.5}, {"viscosity", 4}};
  const auto child = asset.add_child(
      {{"name", "honey"}, {"translation", {1, 2, 3}}, {"extras", {{"palpate", sphere}}}});
  asset.add_node({{"children", {child}}, {"scale", {2, 2, 0}}, {"translation", {10, 0, 0}}});
  asset.add_child({{"extras", {{"palpate", sphere}}}});  // outside the scene
  asset.add_node({{"extras", {{"palpate", {{"medium", 5}}}, {"palpate_contour", 3}}}});
  asset.add_node({{"extras", {{"palpate_contour", {{"medium", "box"}}}}}});
  const auto scene = read_glb(asset);
  // The malformed contours are warnings, and neither belongs to a region.
  ASSERT_EQ(scene.warnings.size(), 2u);
  EXPECT_EQ(scene.warnings[0].rfind("/nodes/4/extras/palpate_contour: ", 0), 0u);
  EXPECT_EQ(scene.warnings[1].rfind("/nodes/5/extras/palpate_contour: ", 0), 0u);
  ASSERT_EQ(scene.regions.size(), 2u);
  const RegionDescription& region = scene.regions[0];
  EXPECT_EQ(region.name, "honey");
  EXPECT_EQ(region.element, "/nodes/1/extras/palpate");
  EXPECT_EQ(scene.tree.at(region.tree_node).file_index, 1u);
  EXPECT_EQ(region.translation_m, Vec3(12, 4, 0));
  EXPECT_EQ(region.linear_scene_node, Mat3(Vec3(2, 2, 0).asDiagonal()));
  ASSERT_EQ(region.parameters.size(), 3u);
  EXPECT_EQ(region.parameters[0].value, MaterialValue(std::string("sphere")));
  EXPECT_EQ(region.parameters[1].element, "/nodes/1/extras/palpate/radius");
  EXPECT_EQ(scene.regions[1].name, "node 4");
}

TEST(GltfMaterials, NodeWithoutAMediumIsNotApplied) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0]["name"] = "tip";
  asset.json["nodes"][0]["extras"]["palpate"] = {{"stiffness", 100}};
  const KeyNames names({{"stiffness", kOfMaterial}, {"medium", kOfNode}});
  ReadOptions options;
  options.key_names = &names;
  const auto scene = read_glb(asset, options);
  EXPECT_TRUE(scene.regions.empty());
  ASSERT_EQ(scene.unapplied_extras.size(), 1u);
  EXPECT_EQ(scene.unapplied_extras[0],
            "/nodes/0/extras/palpate: is not applied; stiffness belongs in extras.palpate of a "
            "material");
  asset.json["nodes"][0]["extras"]["palpate"] = "soft";
  expect_invalid(asset, "/nodes/0/extras/palpate", "an object");
  asset.json["nodes"][0]["extras"]["palpate"] = {{"medium", "box"}, {"a.b", 1}};
  expect_invalid(asset, "/nodes/0/extras/palpate", "without a dot");
}

// --- Runs ----------------------------------------------------------------------------------------

TEST(GltfMaterials, RunsFollowThePrimitives) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  for (int i = 0; i < 6; ++i)
    asset.json["materials"].push_back({{"name", std::string(1, "abcdef"[i])}});
  Json points = triangle_primitive(2);
  points["mode"] = 0;
  Json nowhere = triangle_primitive(1);
  nowhere["attributes"] = Json::object();
  asset.json["meshes"][0]["primitives"] = {
      triangle_primitive(),  triangle_primitive(4), points, triangle_primitive(4), nowhere,
      triangle_primitive(0), triangle_primitive()};
  const auto other =
      asset.add_mesh({points, triangle_primitive(5), triangle_primitive(0), triangle_primitive(5)});
  asset.add_node({{"mesh", other}});
  const auto scene = read_glb(asset);
  ASSERT_EQ(scene.meshes.size(), 2u);
  // In the order of first use: e is 0, a is 1, f is 2; materials of points are not used.
  EXPECT_EQ(runs_of(scene.meshes[0]), (Runs{"0: none", "1: 0", "3: 1", "4: none"}));
  EXPECT_EQ(runs_of(scene.meshes[1]), (Runs{"0: 2", "1: 1", "2: 2"}));
  ASSERT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(scene.materials[0].name, "e");
  EXPECT_EQ(scene.materials[1].name, "a");
  EXPECT_EQ(scene.materials[2].name, "f");
  EXPECT_EQ(scene.materials[2].element, "/materials/5");
}

TEST(GltfMaterials, RunsCountTheTrianglesOfEveryMode) {
  GltfBuilder asset;
  const auto positions =
      asset.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}, {1, 2, 1}});
  const auto primitive = [&](int mode, std::size_t material) {
    return Json{{"attributes", {{"POSITION", positions}}}, {"mode", mode}, {"material", material}};
  };
  asset.json["materials"] = {Json::object(), Json::object(), Json::object()};
  asset.add_node({{"mesh", asset.add_mesh({primitive(5, 0), primitive(4, 1), primitive(6, 2)})}});
  const auto scene = read_glb(asset);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.meshes[0].triangles.size(), 10u);
  EXPECT_EQ(runs_of(scene.meshes[0]), (Runs{"0: 0", "4: 1", "6: 2"}));
}

TEST(GltfMaterials, IdsOfPrimitivesAreChecked) {
  const std::string element = "/meshes/0/primitives/0/material";
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["materials"] = {Json::object(), Json::object()};
  for (const Json& wrong : {Json(2), Json(-1), Json(0.5), Json("0"), Json(nullptr)}) {
    asset.json["meshes"][0]["primitives"][0]["material"] = wrong;
    expect_invalid(asset, element, "has 2 elements");
  }
  asset.json["meshes"][0]["primitives"][0]["material"] = 0;
  asset.json["materials"] = "steel";
  expect_invalid(asset, element, "has 0 elements");
  asset.json.erase("materials");
  expect_invalid(asset, element);
}

// --- Textures ------------------------------------------------------------------------------------

GltfBuilder asset_with_normal_texture(const Json& normal_texture) {
  GltfBuilder asset = asset_with_material({{"normalTexture", normal_texture}});
  asset.json["images"] = {{{"uri", "nowhere.png"}}, {{"bufferView", 4000}}, 5};
  asset.json["textures"] = {{{"source", 1}},  Json::object(), {{"source", 3}}, {{"source", 2}}, "t",
                            {{"source", "0"}}};
  return asset;
}

TEST(GltfMaterials, KeepTheirNormalTextureWithoutOpeningItsImage) {
  const auto scene = read_glb(asset_with_normal_texture({{"index", 0}}));
  ASSERT_TRUE(scene.materials.at(0).normal_texture);
  const TextureReference plain = *scene.materials[0].normal_texture;
  EXPECT_EQ(plain.texture, 0u);
  EXPECT_EQ(plain.image, 1u);
  EXPECT_EQ(plain.tex_coord, 0u);
  EXPECT_EQ(plain.scale, 1.0);
  EXPECT_EQ(plain.uv_offset, (std::array<double, 2>{0, 0}));
  EXPECT_EQ(plain.uv_rotation_rad, 0.0);
  EXPECT_EQ(plain.uv_scale, (std::array<double, 2>{1, 1}));

  Json info = {{"index", 1}, {"texCoord", 2}, {"scale", -0.5}};
  EXPECT_EQ(read_glb(asset_with_normal_texture(info)).materials.at(0).normal_texture->tex_coord,
            2u);
  info["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.25, -1}}, {"rotation", 1.5}, {"scale", {2, 3}}, {"texCoord", 1}};
  const auto turned = read_glb(asset_with_normal_texture(info)).materials.at(0).normal_texture;
  ASSERT_TRUE(turned);
  EXPECT_EQ(turned->texture, 1u);
  EXPECT_FALSE(turned->image);  // an extension may name the image
  EXPECT_EQ(turned->tex_coord, 1u);
  EXPECT_EQ(turned->scale, -0.5);
  EXPECT_EQ(turned->uv_offset, (std::array<double, 2>{0.25, -1}));
  EXPECT_EQ(turned->uv_rotation_rad, 1.5);
  EXPECT_EQ(turned->uv_scale, (std::array<double, 2>{2, 3}));
}

TEST(GltfMaterials, TexturesMustReferToAnImage) {
  const std::string element = "/materials/0/normalTexture";
  const auto refuse = [](const Json& info, const std::string& where) {
    expect_invalid(asset_with_normal_texture(info), where);
  };
  refuse("bumpy", element);
  refuse(Json::object(), element + "/index");
  refuse({{"index", 6}}, element + "/index");
  refuse({{"index", 2}}, "/textures/2/source");
  refuse({{"index", 3}}, "/images/2");
  refuse({{"index", 4}}, "/textures/4");
  refuse({{"index", 5}}, "/textures/5/source");
  refuse({{"index", 0}, {"texCoord", -1}}, element + "/texCoord");
  refuse({{"index", 0}, {"texCoord", 4294967296.0}}, element + "/texCoord");
  refuse({{"index", 0}, {"scale", "1"}}, element + "/scale");
  const auto transform = [](const Json& t) {
    return Json{{"index", 0}, {"extensions", {{"KHR_texture_transform", t}}}};
  };
  const std::string extension = element + "/extensions/KHR_texture_transform";
  refuse(transform(1), extension);
  refuse(transform({{"offset", {1, 2, 3}}}), extension + "/offset");
  refuse(transform({{"scale", {1, "2"}}}), extension + "/scale");
  refuse(transform({{"rotation", {1}}}), extension + "/rotation");
  refuse(transform({{"texCoord", 0.5}}), extension + "/texCoord");
}

// --- Physics materials ---------------------------------------------------------------------------

GltfBuilder asset_with_physics(const Json& materials) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["extensionsUsed"] = {kPhysics, "KHR_implicit_shapes"};
  asset.json["extensionsRequired"] = {kPhysics, "KHR_implicit_shapes"};
  asset.json["extensions"][kPhysics]["physicsMaterials"] = materials;
  return asset;
}

// Four of them.
GltfBuilder asset_with_physics() {
  return asset_with_physics({Json::object(), Json::object(), Json::object(), Json::object()});
}

Json with_collider(Json node, const Json& collider) {
  node["extensions"][kPhysics]["collider"] = collider;
  return node;
}

using Ids = std::vector<std::optional<std::uint32_t>>;

Ids physics_materials_of(const SceneDescription& scene) {
  Ids ids;
  for (const NodeDescription& node : scene.nodes) ids.push_back(node.physics_material);
  return ids;
}

TEST(GltfMaterials, PhysicsMaterialsAreReadAsWritten) {
  const auto scene = read_glb(
      asset_with_physics({Json::object(),
                          {{"staticFriction", 0.8},
                           {"dynamicFriction", 0},
                           {"restitution", 0.1},
                           {"frictionCombine", "minimum"},
                           {"restitutionCombine", "multiply"}},
                          {{"frictionCombine", "maximum"}, {"restitutionCombine", "average"}}}));
  ASSERT_EQ(scene.physics_materials.size(), 3u);
  const auto& materials = scene.physics_materials;
  EXPECT_FALSE(materials[0].static_friction);
  EXPECT_FALSE(materials[0].dynamic_friction);
  EXPECT_FALSE(materials[0].restitution);
  EXPECT_TRUE(materials[0].friction_combine == CombineMode::kAverage);
  EXPECT_TRUE(materials[0].restitution_combine == CombineMode::kAverage);
  EXPECT_EQ(materials[1].static_friction, 0.8);
  EXPECT_EQ(materials[1].dynamic_friction, 0.0);
  EXPECT_EQ(materials[1].restitution, 0.1);
  EXPECT_TRUE(materials[1].friction_combine == CombineMode::kMinimum);
  EXPECT_TRUE(materials[1].restitution_combine == CombineMode::kMultiply);
  EXPECT_TRUE(materials[2].friction_combine == CombineMode::kMaximum);
  EXPECT_EQ(physics_materials_of(scene), (Ids{std::nullopt}));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfMaterials, InvalidPhysicsMaterialsAreRefusedByPath) {
  const std::string list = "/extensions/KHR_physics_rigid_bodies/physicsMaterials";
  expect_invalid(asset_with_physics(3), list, "an array");
  expect_invalid(asset_with_physics({Json::object(), 4}), list + "/1", "an object");
  for (const char* name : {"staticFriction", "dynamicFriction", "restitution"}) {
    for (const Json& wrong : {Json(-0.1), Json("0.5"), Json(nullptr), Json::array({1})}) {
      expect_invalid(asset_with_physics({{{name, wrong}}}), list + "/0/" + name, "number");
    }
  }
  for (const char* name : {"frictionCombine", "restitutionCombine"}) {
    for (const Json& wrong : {Json("mean"), Json(0), Json("")}) {
      expect_invalid(asset_with_physics({{{name, wrong}}}), list + "/0/" + name, "multiply");
    }
  }
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["extensions"][kPhysics] = 1;
  expect_invalid(asset, "/extensions/KHR_physics_rigid_bodies");
  asset = asset_with_physics(std::vector<Json>(kMaxGltfHapticMaterials, Json::object()));
  EXPECT_EQ(read_glb(asset).physics_materials.size(), kMaxGltfHapticMaterials);
  asset.json["extensions"][kPhysics]["physicsMaterials"].push_back(Json::object());
  expect_refused(asset, ErrorCode::kLimitExceeded, list);
}

TEST(GltfMaterials, ColliderMaterialsApplyToTheColliderNode) {
  GltfBuilder asset = asset_with_physics();
  asset.json["nodes"][0] =
      with_collider({{"mesh", 0}}, {{"geometry", {{"shape", 7}}}, {"physicsMaterial", 2}});
  asset.add_node(with_collider({{"mesh", 0}}, {{"geometry", {{"node", 1}}}}));
  asset.add_node(with_collider({{"name", "no mesh"}}, {{"physicsMaterial", 1}}));
  asset.add_node({{"mesh", 0}, {"extensions", {{kPhysics, {{"trigger", 5}, {"motion", 6}}}}}});
  EXPECT_EQ(physics_materials_of(read_glb(asset)), (Ids{2, std::nullopt, std::nullopt}));
}

TEST(GltfMaterials, ColliderMaterialsApplyToTheMeshesOfTheirGeometry) {
  GltfBuilder asset = asset_with_physics();
  // 0 is the geometry of 4, and so are its child 1 and grandchild 3; 2, a child of 1, has its own.
  asset.json["nodes"][0]["children"] = {1};
  asset.add_child({{"mesh", 0}, {"children", {2, 3}}});
  asset.add_child(with_collider({{"mesh", 0}}, {{"physicsMaterial", 1}}));
  asset.add_child({{"mesh", 0}});
  asset.add_node(with_collider({}, {{"geometry", {{"node", 0}}}, {"physicsMaterial", 3}}));
  asset.add_node({{"mesh", 0}});
  EXPECT_EQ(physics_materials_of(read_glb(asset)), (Ids{3, 3, 1, 3, std::nullopt}));
}

TEST(GltfMaterials, DisagreeingCollidersAreResolvedByNearestThenFirst) {
  GltfBuilder asset = asset_with_physics();
  asset.json["nodes"][0]["children"] = {1};
  asset.add_child({{"mesh", 0}});
  const auto naming = [](std::size_t node, int material) {
    return with_collider({}, {{"geometry", {{"node", node}}}, {"physicsMaterial", material}});
  };
  asset.add_node(naming(0, 3));
  asset.add_node(naming(1, 2));
  asset.add_node(naming(1, 2));
  const auto agreed = read_glb(asset);
  EXPECT_EQ(physics_materials_of(agreed), (Ids{3, 2}));
  EXPECT_TRUE(agreed.notes.empty());
  asset.add_node(naming(1, 0));
  asset.add_child(naming(0, 1));  // not in the scene
  const auto scene = read_glb(asset);
  EXPECT_EQ(physics_materials_of(scene), (Ids{3, 2}));
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_NE(scene.notes[0].find("/nodes/5: "), std::string::npos) << scene.notes[0];
  EXPECT_NE(scene.notes[0].find("/nodes/1 "), std::string::npos) << scene.notes[0];
  for (int i = 0; i < 3; ++i) asset.add_node(naming(0, 0));
  const auto notes = read_glb(asset).notes;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("3 further"), std::string::npos) << notes[0];
}

TEST(GltfMaterials, InvalidCollidersAreRefusedByPath) {
  const std::string element = "/nodes/0/extensions/KHR_physics_rigid_bodies";
  const auto refuse = [](const Json& collider, const std::string& where) {
    GltfBuilder asset = asset_with_physics();
    asset.json["nodes"][0] = with_collider({{"mesh", 0}}, collider);
    expect_invalid(asset, where);
  };
  refuse(1, element + "/collider");
  for (const Json& wrong : {Json(4), Json(-1), Json("0"), Json(nullptr)}) {
    refuse({{"physicsMaterial", wrong}}, element + "/collider/physicsMaterial");
  }
  refuse({{"geometry", "box"}}, element + "/collider/geometry");
  refuse({{"geometry", {{"node", 1}}}}, element + "/collider/geometry/node");
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["nodes"][0] = with_collider({{"mesh", 0}}, {{"physicsMaterial", 0}});
  expect_invalid(asset, element + "/collider/physicsMaterial", "has 0 elements");
  asset.json["nodes"][0]["extensions"][kPhysics] = "solid";
  expect_invalid(asset, element);
}

// --- Haptic materials ----------------------------------------------------------------------------

GltfBuilder asset_with_haptics(const Json& materials, const char* name = kHaptic) {
  GltfBuilder asset = GltfBuilder::one_triangle();
  asset.json["extensionsUsed"] = {name};
  asset.json["extensionsRequired"] = {name};
  asset.json["images"] = {{{"uri", "nowhere.png"}}};
  asset.json["textures"] = {{{"source", 0}}, Json::object()};
  asset.json["extensions"][name]["materials"] = materials;
  return asset;
}

Json map_of(std::size_t texture, const std::string& type) {
  return {{"texture", {{"index", texture}}}, {"type", type}};
}

TEST(GltfMaterials, HapticTexturesAreReadUnderBothNames) {
  for (const char* name : {kHaptic, kOldHaptic}) {
    Json low = map_of(1, "Low_Resolution");
    low["texture"]["texCoord"] = 3;
    GltfBuilder asset = asset_with_haptics({{{"name", "wood"},
                                             {"vibrotactileTexture", {map_of(0, "Reference")}},
                                             {"friction", Json::array()},
                                             {"stiffness", {map_of(0, "High_Resolution"), low}},
                                             {"extras", 1}},
                                            {{"name", "bare"}},
                                            {{"temperature", {map_of(1, "Other")}},
                                             {"vibration", {map_of(1, "Other")}},
                                             {"custom", {map_of(1, "Other")}}}},
                                           name);
    asset.json["meshes"][0]["extensions"][name]["hapticMaterialIndex"] = 2;
    asset.add_node({{"mesh", asset.add_mesh(Json::array({triangle_primitive()}))}});
    const auto scene = read_glb(asset);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.meshes[0].haptic_material, 2u);
    EXPECT_FALSE(scene.meshes[1].haptic_material);
    ASSERT_EQ(scene.haptic_materials.size(), 3u);
    const HapticMaterialDescription& wood = scene.haptic_materials[0];
    const std::string element = std::string("/extensions/") + name + "/materials/0";
    EXPECT_EQ(wood.name, "wood");
    ASSERT_EQ(wood.maps.size(), 3u);
    EXPECT_EQ(wood.maps[0].property, "stiffness");
    EXPECT_EQ(wood.maps[0].type, "High_Resolution");
    EXPECT_EQ(wood.maps[0].texture.texture, 0u);
    EXPECT_EQ(wood.maps[0].texture.image, 0u);
    EXPECT_EQ(wood.maps[0].element, element + "/stiffness/0");
    EXPECT_EQ(wood.maps[1].type, "Low_Resolution");
    EXPECT_EQ(wood.maps[1].texture.texture, 1u);
    EXPECT_FALSE(wood.maps[1].texture.image);
    EXPECT_EQ(wood.maps[1].texture.tex_coord, 3u);
    EXPECT_EQ(wood.maps[1].element, element + "/stiffness/1");
    EXPECT_EQ(wood.maps[2].property, "vibrotactileTexture");
    EXPECT_EQ(wood.maps[2].type, "Reference");
    EXPECT_EQ(scene.haptic_materials[1].name, "bare");
    EXPECT_TRUE(scene.haptic_materials[1].maps.empty());
    EXPECT_EQ(scene.haptic_materials[2].name, "haptic material 2");
    ASSERT_EQ(scene.haptic_materials[2].maps.size(), 3u);
    EXPECT_EQ(scene.haptic_materials[2].maps[0].property, "temperature");
    EXPECT_EQ(scene.haptic_materials[2].maps[1].property, "vibration");
    EXPECT_EQ(scene.haptic_materials[2].maps[2].property, "custom");
  }
}

TEST(GltfMaterials, HapticTexturesAreReadFromTheCurrentNameIfBothArePresent) {
  GltfBuilder asset = asset_with_haptics({{{"name", "old"}}, {{"name", "older"}}}, kOldHaptic);
  asset.json["extensions"][kHaptic]["materials"] = {{{"name", "new"}}};
  asset.json["meshes"][0]["extensions"][kOldHaptic]["hapticMaterialIndex"] = 0;
  const auto scene = read_glb(asset);
  ASSERT_EQ(scene.haptic_materials.size(), 1u);
  EXPECT_EQ(scene.haptic_materials[0].name, "new");
  EXPECT_EQ(scene.meshes.at(0).haptic_material, 0u);
  asset.json["meshes"][0]["extensions"][kOldHaptic]["hapticMaterialIndex"] = 1;
  expect_invalid(asset, "/meshes/0/extensions/MPEG_material_haptic/hapticMaterialIndex");
}

TEST(GltfMaterials, InvalidHapticTexturesAreRefusedByPath) {
  for (const char* name : {kHaptic, kOldHaptic}) {
    const std::string list = std::string("/extensions/") + name + "/materials";
    const auto refuse = [&](const Json& materials, const std::string& where) {
      expect_invalid(asset_with_haptics(materials, name), where);
    };
    refuse(1, list);
    refuse(Json::array({2}), list + "/0");
    refuse({{{"name", 2}}}, list + "/0/name");
    refuse({Json::object(), {{"stiffness", 2}}}, list + "/1/stiffness");
    refuse({{{"custom", {3}}}}, list + "/0/custom/0");
    const auto friction = [&](const Json& map, const std::string& where) {
      refuse({{{"friction", {map_of(0, "Other"), map}}}}, list + "/0/friction/1" + where);
    };
    friction({{"texture", {{"index", 0}}}}, "/type");
    friction({{"texture", {{"index", 0}}}, {"type", 1}}, "/type");
    friction({{"type", "Other"}}, "/texture");
    friction({{"texture", 0}, {"type", "Other"}}, "/texture");
    friction(map_of(2, "Other"), "/texture/index");

    const std::string mesh = std::string("/meshes/0/extensions/") + name;
    GltfBuilder asset = asset_with_haptics(Json::array({Json::object()}), name);
    asset.json["meshes"][0]["extensions"][name] = Json::object();
    expect_invalid(asset, mesh + "/hapticMaterialIndex", "missing");
    asset.json["meshes"][0]["extensions"][name]["hapticMaterialIndex"] = 1;
    expect_invalid(asset, mesh + "/hapticMaterialIndex", list);
    asset.json["meshes"][0]["extensions"][name]["hapticMaterialIndex"] = 0;
    EXPECT_EQ(read_glb(asset).meshes.at(0).haptic_material, 0u);
    asset.json.erase("extensions");
    expect_invalid(asset, mesh + "/hapticMaterialIndex", "has 0 elements");
    asset.json["meshes"][0]["extensions"][name] = 3;
    expect_invalid(asset, mesh);
  }
}

// The image is absent, and nothing here requires it.
TEST(GltfMaterials, NeedNoImageIfTheTextureHeightIsZero) {
  const std::vector<Json> maps = {map_of(0, "Other")};
  GltfBuilder felt = asset_with_haptics({{{"vibrotactileTexture", maps}}});
  felt.json["materials"] = {{{"name", "felt"}}, {{"name", "lead"}}};
  felt.json["meshes"][0]["primitives"][0]["material"] = 0;
  felt.json["meshes"][0]["extensions"][kHaptic]["hapticMaterialIndex"] = 0;
  GltfBuilder normal = asset_with_haptics(Json::array());
  normal.json["materials"] = {{{"name", "felt"},
                               {"normalTexture", {{"index", 0}}},
                               {"extras", {{"palpate", {{"textureHeight", 0.001}}}}}}};
  normal.json["meshes"][0]["primitives"][0]["material"] = 0;
  GltfBuilder bare = felt;
  bare.json["meshes"][0]["primitives"][0].erase("material");
  const auto expect_flat = [](const GltfBuilder& asset, const std::string& name) {
    EXPECT_FALSE(read_with(asset, {}).ok());
    const auto scene = read_with(asset, {{name, "textureHeight", "0"}});
    ASSERT_TRUE(scene.ok()) << scene.error().to_string();
    EXPECT_TRUE(scene->images.empty());
    EXPECT_TRUE(scene->meshes.at(0).texture_uv.empty());
    const auto* haptic =
        scene->haptic_materials.empty() ? nullptr : &scene->haptic_materials.front();
    EXPECT_EQ(texture_map(scene->materials.at(0), haptic), nullptr);
    // The engine reports a value that is not a number, so its map must be present.
    for (const char* called : {"0.01", "flat", "false"}) {
      EXPECT_FALSE(read_with(asset, {{name, "textureHeight", called}}).ok()) << called;
    }
  };
  expect_flat(felt, "felt");
  expect_flat(normal, "felt");
  expect_flat(bare, "default");
  // Here the name belongs to another material.
  bare.json["materials"][1]["name"] = "default";
  EXPECT_FALSE(read_with(bare, {{"default", "textureHeight", "0"}}).ok());
  // One flat material: the other material still uses the map.
  felt.json["meshes"][0]["primitives"] = {triangle_primitive(0), triangle_primitive(1)};
  EXPECT_FALSE(read_with(felt, {{"felt", "textureHeight", "0"}}).ok());
  EXPECT_TRUE(
      read_with(felt, {{"felt", "textureHeight", "0"}, {"lead", "textureHeight", "0"}}).ok());
}

// --- Unknown properties --------------------------------------------------------------------------

TEST(GltfMaterials, WarnAboutUnusedPropertiesOfExtensions) {
  const auto warnings_of = [](GltfBuilder asset, const char* extension, const char* list,
                              const Json& entry) {
    asset.json["extensions"][extension][list] = {Json::object(), entry};
    return read_glb(asset).warnings;
  };
  const Json every = {{"name", "a"}, {"extras", 1}, {"extensions", Json::object()}};
  Json physics = every;
  physics.update({{"staticFriction", 1}, {"frictionCombine", "average"}});
  Json haptic = every;
  haptic.update({{"friction", Json::array()}, {"custom", Json::array()}});
  EXPECT_TRUE(warnings_of(asset_with_physics(), kPhysics, "physicsMaterials", physics).empty());
  EXPECT_TRUE(warnings_of(asset_with_haptics(Json::array()), kHaptic, "materials", haptic).empty());
  physics["friction"] = 0.3;
  haptic["roughness"] = 1;
  haptic["smell"] = 2;
  using Warnings = std::vector<std::string>;
  EXPECT_EQ(warnings_of(asset_with_physics(), kPhysics, "physicsMaterials", physics),
            Warnings{"/extensions/KHR_physics_rigid_bodies/physicsMaterials/1: has \"friction\", "
                     "which is not used"});
  EXPECT_EQ(warnings_of(asset_with_haptics(Json::array()), kHaptic, "materials", haptic),
            Warnings{"/extensions/MPEG_haptic_material/materials/1: has \"roughness\" and 1 more, "
                     "which is not used"});
}

// --- Variants ------------------------------------------------------------------------------------

TEST(GltfMaterials, VariantsAreNotedAndTheDefaultIsUsed) {
  GltfBuilder asset = asset_with_material({{"name", "beech"}});
  asset.json["extensionsRequired"] = {"KHR_materials_variants"};
  asset.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "oak"}}, 5};
  asset.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = 7;
  const auto scene = read_glb(asset);
  EXPECT_EQ(scene.materials.at(0).name, "beech");
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_NE(scene.notes[0].find("\"oak\", variant 1"), std::string::npos) << scene.notes[0];
  asset.json["extensions"]["KHR_materials_variants"]["variants"] =
      std::vector<Json>(10, {{"name", "oak"}});
  EXPECT_NE(read_glb(asset).notes.at(0).find("\"oak\" and 2 more"), std::string::npos);
  asset.json["extensions"]["KHR_materials_variants"] = "broken";
  EXPECT_TRUE(read_glb(asset).notes.empty());
}

}  // namespace
}  // namespace palpate
