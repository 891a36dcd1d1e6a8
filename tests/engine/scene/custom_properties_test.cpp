// Tests custom properties as authors write them in the panels of modelling programs: each is
// applied, or one line says where it belongs.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/scene/load_warnings.h"
#include "engine/scene/scene.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::TemporaryFolder;

// A closed body "body" (node 0, mesh 0) of the material "wood" (material 0) in a scene of its own;
// material 1 is unused; node 1 has a camera, and node 2 is in no scene.
GltfBuilder wooden_body() {
  GltfBuilder gltf;
  const auto positions = gltf.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const auto indices = gltf.add_indices({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  gltf.json["materials"] = {{{"name", "wood"}}, {{"name", "unused"}}};
  gltf.add_mesh(
      {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}}});
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
  gltf.add_node({{"mesh", 0}, {"name", "body"}});
  gltf.add_node({{"camera", 0}});
  gltf.add_child({{"name", "elsewhere"}});
  return gltf;
}

GltfBuilder with_extras(const std::string& pointer, const json& extras) {
  GltfBuilder gltf = wooden_body();
  gltf.json[json::json_pointer(pointer + "/extras")] = extras;
  return gltf;
}

Result<Scene> loaded(const GltfBuilder& gltf, const SceneSettings& settings = {}) {
  const TemporaryFolder folder;
  return Scene::load(gltf.write_glb(folder), settings);
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += "\n  " + line;
  return text;
}

// The keys that a material, the scene or a region applies.
std::vector<std::string> applied_keys(const Scene& scene) {
  std::vector<std::string> keys;
  const auto add = [&](const DeclarationReport& report) {
    for (const HonouredParameter& p : report.report.honoured) keys.push_back(p.key);
  };
  for (const DeclarationReport& material : scene.effects().materials) add(material);
  add(scene.effects().scene);
  for (const DeclarationReport& region : scene.effects().regions) add(region);
  return keys;
}

// Extras of an element, and what the one line about them contains. says.front() is its beginning.
struct Property {
  const char* element;
  json extras;
  std::vector<std::string> says;
};

const json kGroup = {{"stiffness", 400}, {"dynamicFriction", 0.3}};
constexpr const char* kWood = "/materials/0/extras/palpate (material \"wood\")";

std::vector<Property> told_properties() {
  const char* const material = "/materials/0";
  const char* const node = "/nodes/0";
  const char* const mesh = "/meshes/0";
  const char* const scene = "/scenes/0";
  return {
      // Keys beside the group.
      {material, {{"stiffness", 400}}, {"/materials/0/extras/stiffness: ", "belongs in", kWood}},
      {node, {{"stiffness", 400}}, {"/nodes/0/extras/stiffness: ", kWood}},
      {mesh, {{"dynamicFriction", 0.3}}, {"/meshes/0/extras/dynamicFriction: ", kWood}},
      {"/meshes/0/primitives/0", {{"stiffness", 4}}, {"/meshes/0/primitives/0/extras/", kWood}},
      {scene, {{"stiffness", 400}}, {"/scenes/0/extras/stiffness: ", "of a material"}},
      {scene,
       {{"gravity", {0, 0, -9.81}}},
       {"/scenes/0/extras/gravity: ", "/scenes/0/extras/palpate"}},
      {node,
       {{"gravity", {0, 0, -9.81}}},
       {"/nodes/0/extras/gravity: ", "/scenes/0/extras/palpate"}},
      {"", {{"stiffness", 400}}, {"/extras/stiffness: ", "of a material"}},
      {"/asset", {{"stiffness", 400}}, {"/asset/extras/stiffness: ", "of a material"}},
      {"/cameras/0", {{"viscosity", 4}}, {"/cameras/0/extras/viscosity: ", "of a material"}},
      {"/materials/1", {{"stiffness", 400}}, {"/materials/1/extras/stiffness: ", "unused"}},
      {"/nodes/2", {{"medium", "box"}}, {"/nodes/2/extras/medium: ", "/nodes/2/extras/palpate"}},
      {material, {{"solid", 0}}, {"/materials/0/extras/solid: ", kWood}},
      // Other spellings of keys.
      {material, {{"Stiffness", 400}}, {"/materials/0/extras/Stiffness: ", "stiffness", kWood}},
      {material, {{"dynamic_friction", 1}}, {"/materials/0/extras/", "dynamicFriction", kWood}},
      {material, {{"Dynamic Friction", 1}}, {"/materials/0/extras/", "dynamicFriction", kWood}},
      {material, {{"stifness", 400}}, {"/materials/0/extras/stifness: ", "nearest key, stiffness"}},
      // Keys joined with the group's name.
      {material, {{"palpate.stiffness", 400}}, {"/materials/0/extras/palpate.stiffness: ", kWood}},
      {material,
       {{"palpate_stiffness", 400}},
       {"/materials/0/extras/", "stiffness belongs", kWood}},
      {material,
       {{"palpate:stiffness", 400}},
       {"/materials/0/extras/", "stiffness belongs", kWood}},
      {material, {{"palpateStifness", 400}}, {"/materials/0/extras/", "nearest key, stiffness"}},
      {material, {{"palpate colour", 1}}, {"/materials/0/extras/", "no key is named \"colour\""}},
      // Other spellings of the group.
      {material, {{"Palpate", kGroup}}, {"/materials/0/extras/Palpate: ", "group is palpate"}},
      {material, {{"PALPATE", kGroup}}, {"/materials/0/extras/PALPATE: ", "palpate, not"}},
      {material, {{"palpte", kGroup}}, {"/materials/0/extras/palpte: ", "palpate, not", kWood}},
      {mesh, {{"Palpate", kGroup}}, {"/meshes/0/extras/Palpate: ", "palpate, not", kWood}},
      // The group on another element.
      {mesh,
       {{"palpate", kGroup}},
       {"/meshes/0/extras/palpate: ", "dynamicFriction, stiffness", kWood}},
      {node,
       {{"palpate", kGroup}},
       {"/nodes/0/extras/palpate: ", "dynamicFriction, stiffness", kWood}},
      {node, {{"palpate", {{"size", {1, 1, 1}}}}}, {"/nodes/0/extras/palpate: ", "key medium"}},
      {"",
       {{"palpate", {{"gravity", {0, 0, -9}}}}},
       {"/extras/palpate: ", "/scenes/0/extras/palpate"}},
      {"/cameras/0", {{"palpate", kGroup}}, {"/cameras/0/extras/palpate: ", "of a material"}},
      {"/materials/1", {{"palpate", kGroup}}, {"/materials/1/extras/palpate: ", "no triangle"}},
      {"/nodes/2",
       {{"palpate", {{"medium", "box"}}}},
       {"/nodes/2/extras/palpate: ", "not part of the loaded scene"}},
      {mesh,
       {{"palpate", "{\"stiffness\": 400}"}},
       {"/meshes/0/extras/palpate: ", "a text", kWood}},
      {mesh, {{"palpate", 1.0}}, {"/meshes/0/extras/palpate: ", "a number", kWood}},
      {mesh, {{"palpate", nullptr}}, {"/meshes/0/extras/palpate: ", "null", kWood}},
      {material,
       {{"haptics", {{"palpate", kGroup}}}},
       {"/materials/0/extras/haptics/palpate: ", kWood}},
      {material, json::array({{{"palpate", kGroup}}}), {"/materials/0/extras/0/palpate: ", kWood}},
      {material, "{\"palpate\": {}}", {"/materials/0/extras: ", "a text", "an object"}},
      {mesh, {{"palpate_contour", json::object()}}, {"/meshes/0/extras/palpate_contour: ", "node"}},
      {node, {{"palpateContour", json::object()}}, {"/nodes/0/extras/", "palpate_contour"}},
      {node, {{"palpate_contours", json::object()}}, {"/nodes/0/extras/", "palpate_contour,"}},
      {node, {{"palpate_cntuor", json::object()}}, {"/nodes/0/extras/", "palpate_contour,"}},
      // Groups of other names with nothing but keys of Palpate.
      {material, {{"haptics", kGroup}}, {"/materials/0/extras/haptics: ", "palpate, not", kWood}},
      {mesh, {{"feeling", kGroup}}, {"/meshes/0/extras/feeling: ", "palpate, not", kWood}},
      {material,
       {{"custom", {{"stiffness", 4}}}},
       {"/materials/0/extras/custom: ", "stiffness belongs"}},
      {material,
       {{"haptic", {{"stiffness", 4}, {"colour", 1}}}},
       {"/materials/0/extras/haptic: ", "stiffness belongs", kWood}},
      {material,
       {{"palpate_haptics", {{"stiffness", 4}}}},
       {"/materials/0/extras/palpate_haptics: ", "palpate, not", "stiffness belongs", kWood}},
      // Extras that are a text.
      {material, "{\"stiffness\": 400}", {"/materials/0/extras: ", "a text", "an object"}},
      {material, " {'dynamic_friction': 1}", {"/materials/0/extras: ", "a text", "an object"}},
      // Names that begin with another word, and other words.
      {material, {{"haptic_stiffness", 4}}, {"/materials/0/extras/haptic_", "stiffness", kWood}},
      {material, {{"hapticsStiffness", 4}}, {"/materials/0/extras/haptics", "stiffness", kWood}},
      {material,
       {{"kineticFriction", 1}},
       {"/materials/0/extras/", "nearest key, dynamicFriction"}},
      {material, {{"dampening", 1}}, {"/materials/0/extras/", "nearest key, damping"}},
      {material, {{"vibrationFreq", 9}}, {"/materials/0/extras/", "key, vibrationFrequency"}},
      // Keys inside a group that is applied.
      {material,
       {{"palpate", {{"stifness", 400}}}},
       {"/materials/0/extras/palpate/stifness", "nearest key is stiffness"}},
      {material,
       {{"palpate", {{"Stiffness", 4}}}},
       {"/materials/0/extras/palpate/Stiffness", "nearest key is stiffness"}},
      {material,
       {{"palpate", {{"friction", 1}}}},
       {"/materials/0/extras/palpate/friction", "staticFriction or dynamicFriction"}},
      {material,
       {{"palpate", {{"gravity", 1}}}},
       {"/materials/0/extras/palpate/gravity", "of the scene"}},
      {scene,
       {{"palpate", {{"stiffness", 400}}}},
       {"/scenes/0/extras/palpate/stiffness", "of a material"}},
  };
}

TEST(CustomProperties, EachThatIsNotAppliedGetsOneLineWithItsPlace) {
  for (const Property& property : told_properties()) {
    SCOPED_TRACE(std::string(property.element) + " " + property.extras.dump());
    const auto scene = loaded(with_extras(property.element, property.extras));
    ASSERT_TRUE(scene) << scene.error().to_string();
    const std::vector<std::string> lines = load_warnings(*scene);
    ASSERT_EQ(lines.size(), 1u) << joined(lines);
    EXPECT_TRUE(lines.front().starts_with(property.says.front())) << lines.front();
    for (const std::string& part : property.says) {
      EXPECT_NE(lines.front().find(part), std::string::npos)
          << part << " is not in " << lines.front();
    }
    EXPECT_TRUE(applied_keys(*scene).empty());
  }
}

TEST(CustomProperties, AreAppliedWhereTheyBelong) {
  const Property applied[] = {
      {"/materials/0", {{"palpate", kGroup}}, {"stiffness", "dynamicFriction"}},
      {"/materials/0", {{"palpate", {{"solid", true}}}}, {"solid"}},
      {"/materials/0", {{"palpate", {{"solid", 1}}}}, {"solid"}},
      {"/materials/0", {{"palpate", {{"solid", 0}, {"viscosity", 2}}}}, {"solid", "viscosity"}},
      {"/materials/0", {{"palpate", {{"solid", 0.0}, {"viscosity", 2}}}}, {"solid", "viscosity"}},
      {"/scenes/0", {{"palpate", {{"constantForce", {0, 0, 1}}}}}, {"constantForce"}},
      {"/nodes/1",
       {{"palpate", {{"medium", "sphere"}, {"radius", 1}, {"viscosity", 2}}}},
       {"medium", "radius", "viscosity"}},
  };
  for (const Property& property : applied) {
    SCOPED_TRACE(std::string(property.element) + " " + property.extras.dump());
    const auto scene = loaded(with_extras(property.element, property.extras));
    ASSERT_TRUE(scene) << scene.error().to_string();
    EXPECT_TRUE(load_warnings(*scene).empty()) << joined(load_warnings(*scene));
    std::vector<std::string> keys = applied_keys(*scene);
    std::vector<std::string> expected = property.says;
    std::sort(keys.begin(), keys.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(keys, expected);
  }
}

// 0 and 1 do what false and true do: a medium cannot be touched.
TEST(CustomProperties, NumbersStandForFalseAndTrue) {
  for (const auto& [value, objects] :
       {std::pair<json, std::size_t>{false, 0}, {0, 0}, {0.0, 0}, {true, 1}, {1, 1}, {1.0, 1}}) {
    const auto scene =
        loaded(with_extras("/materials/0", {{"palpate", {{"solid", value}, {"viscosity", 2}}}}));
    ASSERT_TRUE(scene) << scene.error().to_string();
    EXPECT_EQ(scene->objects().size(), objects) << value;
  }
}

TEST(CustomProperties, WrongValuesOfAppliedKeysAreRefusedWithTheirPlace) {
  const Property refused[] = {
      {"solid", 2, {"expected true or false, or 1 or 0"}},
      {"solid", 0.5, {"expected true or false, or 1 or 0"}},
      {"solid", -1, {"expected true or false, or 1 or 0"}},
      {"solid", "true", {"write true without quotation marks"}},
      {"solid", {1}, {"write 1 without brackets"}},
      {"stiffness", "400", {"is \"400\"; expected a number", "write 400 without quotation marks"}},
      {"stiffness", {400}, {"is [400]; expected a number", "write 400 without brackets"}},
      {"stiffness", nullptr, {"is null; expected a number"}},
      {"stiffness", true, {"is true; expected a number"}},
      {"stiffness", {{"value", 400}}, {}},  // told: an unknown key "stiffness.value"
  };
  for (const Property& property : refused) {
    SCOPED_TRACE(std::string(property.element) + " " + property.extras.dump());
    const auto scene =
        loaded(with_extras("/materials/0", {{"palpate", {{property.element, property.extras}}}}));
    const std::string place = std::string("/materials/0/extras/palpate/") + property.element;
    if (property.says.empty()) {
      ASSERT_TRUE(scene) << scene.error().to_string();
      ASSERT_EQ(load_warnings(*scene).size(), 1u);
      EXPECT_TRUE(load_warnings(*scene).front().starts_with(place));
      continue;
    }
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().element, place);
    for (const std::string& part : property.says) {
      EXPECT_NE(scene.error().to_string().find(part), std::string::npos)
          << part << " is not in " << scene.error().to_string();
    }
  }
  const auto text = loaded(with_extras("/materials/0", {{"palpate", "{\"stiffness\": 400}"}}));
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().element, "/materials/0/extras/palpate");
  EXPECT_NE(text.error().hint.find("type Python"), std::string::npos);
}

TEST(CustomProperties, OfOtherProgramsGiveNoLine) {
  GltfBuilder gltf = wooden_body();
  const json others = {
      {"gltf_yup", 1},
      {"cycles", {{"stiffness", 4}, {"dynamicFriction", 1}, {"texture", "x"}}},
      {"rigidBody", {{"mass", 1}, {"restitution", 0.5}, {"material", {{"stiffness", 2}}}}},
      {"targetNames", {"stiffness", "palpate"}},
      {"texture", "wood.png"},
      {"name", "palpate"},
      {"density", 700},
      {"friction", 0.5},
      {"size", {1, 2, 3}},
      {"radius", 3},
      {"medium", "water"},
      {"solid", "oak"},
      {"palette", {{"red", 1}}},
      {"sold", true},
      {"damp", 1},
      {"_RNA_UI", {{"stiffness", {{"min", 0.0}}}, {"dynamicFriction", {{"min", 0.0}}}}},
      {"physicsMaterial", {{"staticFriction", 1}, {"dynamicFriction", 1}, {"restitution", 0}}},
      {"spring", {{"stiffness", 1}, {"damping", 1}}},
      {"shape", {{"size", {1, 1, 1}}, {"radius", 1}}},
      {"world", {{"gravity", {0, 0, -9.81}}, {"damping", 0.1}}},
      {"option", {{"stiffness", 1}}},
      {"note", "{\"stiffness\": 400}"},
      {"haptic", {{"device", "none"}}},
      {"haptic_note", "none"},
      {"prop", 1.0}};
  for (const char* element : {"/materials/0", "/nodes/0", "/meshes/0", "/scenes/0", "/asset", ""}) {
    gltf.json[json::json_pointer(std::string(element) + "/extras")] = others;
  }
  const auto scene = loaded(gltf);
  ASSERT_TRUE(scene) << scene.error().to_string();
  EXPECT_TRUE(load_warnings(*scene).empty()) << joined(load_warnings(*scene));
}

TEST(CustomProperties, AreToldInABoundedNumberOfLinesWhateverTheFile) {
  GltfBuilder gltf = wooden_body();
  json& many = gltf.json["materials"][0]["extras"];
  for (unsigned n = 0; n < (1u << 16); ++n) {
    constexpr const char* kSigns[] = {"", "_", "-", " "};
    std::string key = "s";
    for (unsigned i = 0; i < 8; ++i)
      key += kSigns[(n >> (2 * i)) % 4] + std::string(1, "tiffness"[i]);
    many[key] = n;
  }
  for (int n = 0; n < 1000; ++n) many["palpate\n\x1b[2J" + std::to_string(n)] = n;
  json* deep = &gltf.json["meshes"][0]["extras"];
  for (int n = 0; n < 200; ++n) deep = &(*deep)["a"];
  (*deep)["palpate"] = 1;
  const auto scene = loaded(gltf);
  ASSERT_TRUE(scene) << scene.error().to_string();
  const auto lines = load_warnings(*scene);
  ASSERT_EQ(lines.size(), 33u) << joined(lines);
  EXPECT_TRUE(lines.back().starts_with("and ")) << lines.back();
  for (const std::string& line : lines) EXPECT_LT(line.size(), 2000u);
}

// A key directly in an element, where extras.palpate is missing around it.
TEST(CustomProperties, OutsideExtrasSayWhereTheyBelong) {
  const std::pair<const char*, json> placed[] = {
      {"/materials/0", {{"stiffness", 400}}}, {"/materials/0", {{"dynamic_friction", 1}}},
      {"/materials/0", {{"solid", true}}},    {"/nodes/0", {{"stiffness", 400}}},
      {"/meshes/0", {{"stiffness", 400}}},    {"", {{"stiffness", 400}}}};
  for (const auto& [element, members] : placed) {
    GltfBuilder gltf = wooden_body();
    gltf.json[json::json_pointer(element)].update(members);
    gltf.json["materials"][0]["extras"] = {{"note", 1}};
    const auto scene = loaded(gltf);
    ASSERT_TRUE(scene) << scene.error().to_string();
    const auto lines = load_warnings(*scene);
    ASSERT_EQ(lines.size(), 1u) << element << members << joined(lines);
    const std::string begin = std::string(element) + "/" + members.begin().key() +
                              ": is not applied; it lies outside extras; ";
    EXPECT_TRUE(lines.front().starts_with(begin)) << lines.front();
  }
}

TEST(CustomProperties, OfHiddenNodesSayHowToLoadThem) {
  for (const char* key : {"palpate", "palpate_contour"}) {
    GltfBuilder gltf = wooden_body();
    gltf.json["nodes"][1]["extras"] = {{key, {{"medium", "box"}}}};
    gltf.json["nodes"][1]["extensions"] = {{"KHR_node_visibility", {{"visible", false}}}};
    const auto scene = loaded(gltf);
    ASSERT_TRUE(scene) << scene.error().to_string();
    ASSERT_EQ(load_warnings(*scene).size(), 1u) << joined(load_warnings(*scene));
    EXPECT_EQ(load_warnings(*scene).front(),
              std::string("/nodes/1/extras/") + key +
                  ": is not applied; the node, or an ancestor, is hidden (KHR_node_visibility); "
                  "`SceneSettings::feels_hidden` loads hidden nodes, too");
  }
}

TEST(CustomProperties, AreSaidToBeAtLeastSoManyWhereTheSearchEnds) {
  for (const auto& [count, begin] :
       {std::pair<int, const char*>{100, "and 68 more"}, {70'000, "and at least "}}) {
    GltfBuilder gltf = wooden_body();
    for (int n = 0; n < count; ++n) {
      gltf.json["nodes"].push_back({{"extras", {{"stifness", n}}}});
    }
    const auto scene = loaded(gltf);
    ASSERT_TRUE(scene) << scene.error().to_string();
    ASSERT_EQ(load_warnings(*scene).size(), 33u);
    EXPECT_TRUE(load_warnings(*scene).back().starts_with(begin)) << load_warnings(*scene).back();
  }
}

TEST(CustomProperties, OfAnotherSceneSayHowToLoadIt) {
  GltfBuilder gltf = wooden_body();
  gltf.json["scenes"].push_back(
      {{"nodes", {0}}, {"extras", {{"palpate", {{"constantForce", {0, 0, 1}}}}}}});
  const auto first = loaded(gltf);
  ASSERT_TRUE(first) << first.error().to_string();
  ASSERT_EQ(load_warnings(*first).size(), 1u);
  EXPECT_EQ(load_warnings(*first).front(),
            "/scenes/1/extras/palpate: is not applied; another scene of the file is loaded; load "
            "this one with `SceneSettings::listed_scene` 1");
  SceneSettings settings;
  settings.listed_scene = "1";
  const auto second = loaded(gltf, settings);
  ASSERT_TRUE(second) << second.error().to_string();
  EXPECT_TRUE(load_warnings(*second).empty()) << joined(load_warnings(*second));
  EXPECT_EQ(applied_keys(*second), std::vector<std::string>{"constantForce"});
}

}  // namespace
}  // namespace palpate
