// Tests which nodes of a file are read: those of the chosen scene, without hidden ones.

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/helpers/gltf_builder.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::expect_refused;
using test::GltfBuilder;
using test::read_glb;

constexpr const char* kVisibility = "KHR_node_visibility";

Json visible(const Json& value) {
  return {{"extensions", {{kVisibility, {{"visible", value}}}}}};
}

std::vector<std::string> names_of(const SceneDescription& scene) {
  std::vector<std::string> names;
  for (const NodeDescription& node : scene.nodes) names.push_back(node.name);
  return names;
}

using Names = std::vector<std::string>;

// Node "a" in scene 0, "b" in scene 1 and "c" in scene 2, which is the default.
GltfBuilder three_scenes(const std::vector<Json>& scene_names) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json["nodes"] = Json::array();
  gltf.json["scenes"] = Json::array();
  gltf.json["scene"] = 2;
  for (std::size_t i = 0; i < 3; ++i) {
    gltf.json["nodes"].push_back({{"mesh", 0}, {"name", std::string(1, "abc"[i])}});
    Json scene = {{"nodes", {i}}};
    if (!scene_names[i].is_null()) scene["name"] = scene_names[i];
    gltf.json["scenes"].push_back(scene);
  }
  return gltf;
}

ReadOptions scene_option(const std::string& choice) {
  ReadOptions options;
  options.scene = choice;
  return options;
}

TEST(SceneChoice, IsTheDefaultOneOrANumberOrAName) {
  const GltfBuilder gltf = three_scenes({"hall", "room", nullptr});
  EXPECT_EQ(names_of(read_glb(gltf)), Names{"c"});
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("0"))), Names{"a"});
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("#1"))), Names{"b"});
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("002"))), Names{"c"});
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("hall"))), Names{"a"});
  const SceneDescription scene = read_glb(gltf, scene_option("room"));
  EXPECT_EQ(names_of(scene), Names{"b"});
  EXPECT_EQ(scene.scenes.count, 3u);
  EXPECT_EQ(scene.scenes.names, (Names{"hall", "room", ""}));
  EXPECT_EQ(scene.scenes.loaded, 1u);
}

TEST(SceneChoice, DigitsAreANumberEvenIfASceneHasThemAsItsName) {
  const GltfBuilder gltf = three_scenes({"2", "#0", "1"});
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("1"))), Names{"b"});
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("2"))), Names{"c"});
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("#0"))), Names{"b"});  // a name comes first
  EXPECT_EQ(names_of(read_glb(gltf, scene_option("#2"))), Names{"c"});
}

TEST(SceneChoice, RefusesANameOfNoSceneOrOfSeveralWithTheListOfScenes) {
  const GltfBuilder gltf = three_scenes({"room", "room", nullptr});
  const std::string list = "the scenes are 0 \"room\", 1 \"room\", 2 without a name";
  const auto refuse = [&](const std::string& choice, const std::string& text) {
    expect_refused(gltf, ErrorCode::kInvalidArgument, "`SceneSettings::listed_scene`", text,
                   scene_option(choice));
  };
  refuse("room", "is \"room\", the name of 2 scenes of the file; " + list);
  refuse("Room", list);
  refuse("3", "but the file has 3 scenes; " + list);
  refuse("#3", list);
  refuse("-1", list);
  refuse("1.0", list);
  refuse(" 1", list);
  refuse("99999999999999999999999", list);
  refuse("node 0", list);
}

TEST(SceneChoice, OfAFileWithoutScenesIsRefused) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json.erase("scenes");
  gltf.json.erase("scene");
  EXPECT_EQ(read_glb(gltf).scenes.count, 0u);
  EXPECT_FALSE(read_glb(gltf).scenes.loaded);
  expect_refused(gltf, ErrorCode::kInvalidArgument, "`SceneSettings::listed_scene`",
                 "the file lists no scene", scene_option("0"));
}

// "whole" > "part" > "screw", beside "ball"; every node has the mesh.
GltfBuilder assembly() {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json["nodes"] = {{{"mesh", 0}, {"name", "whole"}, {"children", {1}}},
                        {{"mesh", 0}, {"name", "part"}, {"children", {2}}},
                        {{"mesh", 0}, {"name", "screw"}},
                        {{"mesh", 0}, {"name", "ball"}}};
  gltf.json["scenes"] = {{{"nodes", {0, 3}}}};
  return gltf;
}

void hide(GltfBuilder& gltf, std::size_t node, const Json& value = false) {
  gltf.json["nodes"][node].update(visible(value));
}

TEST(HiddenNodes, AreLeftOutWithTheirDescendants) {
  GltfBuilder gltf = assembly();
  hide(gltf, 1);
  hide(gltf, 2, true);  // visible itself, below a hidden node
  const SceneDescription scene = read_glb(gltf);
  EXPECT_EQ(names_of(scene), (Names{"whole", "ball"}));
  EXPECT_EQ(scene.hidden_nodes.count, 2u);
  EXPECT_EQ(scene.hidden_nodes.first_names, (Names{"part", "screw"}));
  ASSERT_EQ(scene.tree.size(), 4u);
  EXPECT_FALSE(scene.tree[0].is_hidden);
  EXPECT_TRUE(scene.tree[1].is_hidden);
  EXPECT_TRUE(scene.tree[2].is_hidden);
  EXPECT_FALSE(scene.tree[3].is_hidden);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(HiddenNodes, AreReadIfTheyAreAskedFor) {
  GltfBuilder gltf = assembly();
  hide(gltf, 0);
  ReadOptions options;
  options.feels_hidden = true;
  const SceneDescription scene = read_glb(gltf, options);
  EXPECT_EQ(names_of(scene), (Names{"whole", "part", "screw", "ball"}));
  EXPECT_EQ(scene.hidden_nodes.count, 0u);
}

TEST(HiddenNodes, DoNotIncludeVisibleOnes) {
  GltfBuilder gltf = assembly();
  hide(gltf, 0, true);
  gltf.json["nodes"][1]["extensions"][kVisibility] = Json::object();  // the default is true
  EXPECT_EQ(names_of(read_glb(gltf)).size(), 4u);
  gltf.json["extensionsUsed"] = {kVisibility};
  gltf.json["extensionsRequired"] = {kVisibility};
  EXPECT_EQ(names_of(read_glb(gltf)).size(), 4u);
}

TEST(HiddenNodes, WithAWrongVisibilityAreRefused) {
  for (const Json& wrong : {Json("false"), Json(2), Json(0.5), Json(-1), Json(nullptr),
                            Json::array({false}), Json(Json::object())}) {
    GltfBuilder gltf = assembly();
    hide(gltf, 1, wrong);
    expect_refused(gltf, ErrorCode::kInvalidContent,
                   "/nodes/1/extensions/KHR_node_visibility/visible", "true or false, or 1 or 0");
  }
  for (const Json& wrong : {Json(false), Json(nullptr), Json(0), Json::array()}) {
    GltfBuilder gltf = assembly();
    gltf.json["nodes"][1]["extensions"][kVisibility] = wrong;
    expect_refused(gltf, ErrorCode::kInvalidContent, "/nodes/1/extensions/KHR_node_visibility",
                   "write {\"visible\": false} to hide the node");
  }
}

TEST(HiddenNodes, NumbersStandForFalseAndTrue) {
  for (const Json& no : {Json(0), Json(0.0), Json(-0.0)}) {
    GltfBuilder gltf = assembly();
    hide(gltf, 1, no);
    EXPECT_EQ(names_of(read_glb(gltf)), (Names{"whole", "ball"})) << no;
  }
  for (const Json& yes : {Json(1), Json(1.0)}) {
    GltfBuilder gltf = assembly();
    hide(gltf, 1, yes);
    EXPECT_EQ(names_of(read_glb(gltf)).size(), 4u) << yes;
  }
}

TEST(HiddenNodes, AreListedWithoutAnyThatIsVisible) {
  GltfBuilder gltf = assembly();
  hide(gltf, 0);
  hide(gltf, 3);
  ReadOptions options;
  options.reads_only_tree = true;
  const SceneDescription scene = read_glb(gltf, options);
  ASSERT_EQ(scene.tree.size(), 4u);
  for (const TreeNode& node : scene.tree) EXPECT_TRUE(node.is_hidden) << node.name;
  EXPECT_EQ(scene.hidden_nodes.count, 4u);
}

TEST(HiddenNodes, ThatAreAllSayHowToReadThem) {
  GltfBuilder gltf = assembly();
  hide(gltf, 0);
  hide(gltf, 3);
  const test::TemporaryFolder folder;
  const auto scene = read_gltf(gltf.write_glb(folder));
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, ErrorCode::kEmptyScene);
  EXPECT_TRUE(scene.error().hint.starts_with("4 nodes with a mesh are hidden"))
      << scene.error().hint;
  EXPECT_NE(scene.error().hint.find("\"whole\", \"part\", \"screw\", \"ball\";"), std::string::npos)
      << scene.error().hint;
  EXPECT_NE(scene.error().hint.find("`SceneSettings::feels_hidden`"), std::string::npos);
}

// Regions and contours of hidden nodes are left out, too.
TEST(HiddenNodes, DeclareNothing) {
  GltfBuilder gltf = assembly();
  gltf.json["nodes"][2]["extras"] = {
      {"palpate", {{"medium", "sphere"}, {"radius", 1}, {"viscosity", 1}}},
      {"palpate_contour", {{"start_m", {0, 0, 0}}, {"end_m", {1, 0, 0}}}}};
  EXPECT_EQ(read_glb(gltf).regions.size(), 1u);
  EXPECT_EQ(read_glb(gltf).contours.size(), 1u);
  hide(gltf, 1);
  EXPECT_TRUE(read_glb(gltf).regions.empty());
  EXPECT_TRUE(read_glb(gltf).contours.empty());
}

TEST(HiddenNodes, WhoseVisibilityIsAnimatedGiveANote) {
  GltfBuilder gltf = assembly();
  const auto with_pointer = [](const Json& pointer) {
    return Json{{"sampler", 0},
                {"target",
                 {{"path", "pointer"},
                  {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}};
  };
  const auto notes_with = [&](const Json& channel) {
    gltf.json["animations"] = {{{"channels", {channel}}, {"samplers", Json::array()}}};
    std::size_t count = 0;
    for (const std::string& note : read_glb(gltf).notes) {
      count += note.find("the visibility of nodes is animated") != std::string::npos;
    }
    return count;
  };
  EXPECT_EQ(notes_with(with_pointer("/nodes/1/extensions/KHR_node_visibility/visible")), 1u);
  EXPECT_EQ(notes_with(with_pointer("/nodes/1/translation")), 0u);
  EXPECT_EQ(notes_with(with_pointer(7)), 0u);
  EXPECT_EQ(notes_with(with_pointer(nullptr)), 0u);
}

}  // namespace
}  // namespace palpate
