// Tests the options that choose what of a file is felt, and what the commands say about the rest.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

// A prism of 0.1 m, in scene 0 "near" alone and in scene 1 "far" with a hidden copy beside it. The
// material has a key beside the group, and the mesh has a group.
void write_scenes(const TemporaryFolder& folder) {
  GltfBuilder gltf;
  std::vector<Eigen::Vector3f> p;
  for (const float z : {-0.05f, 0.05f}) {
    for (const auto& [x, y] : {std::pair{-0.05f, -0.05f}, {0.05f, -0.05f}, {0.f, 0.05f}}) {
      p.push_back({x, y, z});
    }
  }
  const auto positions = gltf.add_positions(p);
  const auto indices =
      gltf.add_indices({0, 2, 1, 3, 4, 5, 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5});
  gltf.json["materials"] = {{{"name", "wood"}, {"extras", {{"stiffness", 400}}}}};
  gltf.add_mesh(
      {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}}});
  gltf.json["meshes"][0]["extras"] = {{"palpate", {{"dynamicFriction", 0.3}}}};
  gltf.add_node({{"mesh", 0}, {"name", "prism"}});
  gltf.json["nodes"].push_back({{"mesh", 0},
                                {"name", "ghost"},
                                {"translation", {0.2, 0, 0}},
                                {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  gltf.json["scenes"][0]["name"] = "near";
  gltf.json["scenes"].push_back({{"nodes", {0, 1}}, {"name", "far"}});
  const std::string file = gltf.write_glb(folder);
  std::rename(file.c_str(), folder.path("scenes.glb").c_str());
  folder.write("path.txt", "0 0 0.06\n0 0 0.049\n0 0 0.049\n0 0 0.06\n");
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
  return count;
}

constexpr const char* kFlat =
    "/materials/0/extras/stiffness: is not applied; stiffness belongs in "
    "/materials/0/extras/palpate (material \"wood\")";
constexpr const char* kOnMesh =
    "/meshes/0/extras/palpate: is not applied; dynamicFriction belongs "
    "in /materials/0/extras/palpate (material \"wood\")";
constexpr const char* kHidden =
    "1 node with a mesh is hidden in the file (KHR_node_visibility) and "
    "cannot be felt: \"ghost\"; --feel-hidden loads hidden nodes, too";

TEST(SceneContent, EveryCommandSaysWhatOfTheFileIsNotFelt) {
  const TemporaryFolder folder;
  write_scenes(folder);
  const std::vector<std::vector<std::string>> commands = {
      {"run", "scenes.glb", "--scene", "1", "--virtual", "--seconds", "2", "--a4", "off"},
      {"replay", "scenes.glb", "--scene", "far", "--trajectory", "path.txt"},
      {"soak", "scenes.glb", "--scene", "1", "--minutes", "0.04"},
  };
  for (const auto& command : commands) {
    const Outcome outcome = run_program(folder, command);
    for (const char* line : {kFlat, kOnMesh, kHidden}) {
      EXPECT_EQ(count_of(outcome.err, std::string("palpate: warning: ") + line), 1u)
          << command.front() << ": " << line << "\n"
          << outcome.err;
    }
  }
}

TEST(SceneContent, InfoListsScenesAndHiddenNodes) {
  const TemporaryFolder folder;
  write_scenes(folder);
  const Outcome text = run_program(folder, {"info", "scenes.glb", "--scene", "far"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const std::string& line :
       {std::string("  scene #0 \"near\"\n  scene #1 \"far\", loaded\n"),
        std::string("  warning: ") + kFlat + "\n", std::string("  warning: ") + kOnMesh + "\n",
        std::string("  warning: ") + kHidden + "\n"}) {
    EXPECT_TRUE(contains(text.out, line)) << line << text.out;
  }
  const json answer =
      json::parse(run_program(folder, {"info", "scenes.glb", "--scene", "1", "--json"}).out);
  EXPECT_EQ(answer["scenes"], json({{"count", 2}, {"names", {"near", "far"}}, {"loaded", 1}}));
  EXPECT_EQ(answer["hidden_nodes"], json({{"count", 1}, {"first_names", {"ghost"}}}));
  EXPECT_EQ(answer["instances"], 1);
  for (const char* line : {kFlat, kOnMesh, kHidden}) {
    EXPECT_EQ(std::count(answer["warnings"].begin(), answer["warnings"].end(), line), 1) << line;
  }
  const Outcome tree = run_program(folder, {"info", "scenes.glb", "--scene", "1", "--list"});
  EXPECT_TRUE(contains(tree.out, "ghost  #1  mesh  hidden\n")) << tree.out;
}

TEST(SceneContent, HiddenNodesAreFeltOnRequest) {
  const TemporaryFolder folder;
  write_scenes(folder);
  const Outcome outcome =
      run_program(folder, {"info", "scenes.glb", "--scene", "1", "--feel-hidden", "--json"});
  const json answer = json::parse(outcome.out);
  EXPECT_EQ(answer["instances"], 2);
  EXPECT_EQ(answer["hidden_nodes"]["count"], 0);
  EXPECT_FALSE(contains(outcome.out, "hidden in the file"));
}

TEST(SceneContent, AnUnknownSceneIsRefusedWithTheList) {
  const TemporaryFolder folder;
  write_scenes(folder);
  for (const char* command : {"info", "run", "view", "soak"}) {
    const Outcome outcome = run_program(folder, {command, "scenes.glb", "--scene", "middle"});
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_TRUE(contains(outcome.err, "scenes.glb: --scene: is \"middle\"")) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "the scenes are 0 \"near\", 1 \"far\"")) << outcome.err;
    EXPECT_EQ(count_of(outcome.err, "\n"), 1u) << outcome.err;
  }
}

TEST(SceneContent, ARecordingOfAChosenSceneReplaysToTheBit) {
  const TemporaryFolder folder;
  write_scenes(folder);
  const Outcome run =
      run_program(folder, {"run", "scenes.glb", "--scene", "far", "--virtual", "--seconds", "2",
                           "--a4", "off", "--record", "a.palpate"});
  ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 3) << run.err;
  EXPECT_EQ(run_program(folder, {"replay", "a.palpate"}).exit_code, 0);
  std::rename(folder.path("scenes.glb").c_str(), folder.path("moved.glb").c_str());
  EXPECT_EQ(run_program(folder, {"replay", "a.palpate"}).exit_code, 2);
  EXPECT_EQ(run_program(folder, {"replay", "a.palpate", "--scene", "moved.glb"}).exit_code, 0);
}

// A file of which every node is hidden: "a", and "b" below it.
void write_hidden(const TemporaryFolder& folder) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json["nodes"] = {{{"name", "a"},
                         {"mesh", 0},
                         {"children", {1}},
                         {"extensions", {{"KHR_node_visibility", {{"visible", 0}}}}}},
                        {{"name", "b"}, {"mesh", 0}}};
  gltf.json["scenes"] = {{{"nodes", {0}}}};
  std::rename(gltf.write_glb(folder).c_str(), folder.path("hidden.glb").c_str());
}

TEST(SceneContent, InfoListsNodesThatAreAllHidden) {
  const TemporaryFolder folder;
  write_hidden(folder);
  const Outcome list = run_program(folder, {"info", "hidden.glb", "--list"});
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_EQ(list.out, "hidden.glb\n  a  #0  mesh  hidden\n    b  #1  mesh  hidden\n");
  const Outcome part = run_program(folder, {"info", "hidden.glb", "--list", "--node", "b"});
  EXPECT_EQ(part.out, "hidden.glb\n  b  #1  mesh  hidden\n") << part.err;
  const Outcome as_json = run_program(folder, {"info", "hidden.glb", "--list", "--json"});
  EXPECT_EQ(json::parse(as_json.out).size(), 2u) << as_json.err;
  const Outcome info = run_program(folder, {"info", "hidden.glb"});
  EXPECT_EQ(info.exit_code, 2);
  EXPECT_TRUE(contains(info.err,
                       "2 nodes with a mesh are hidden in the file "
                       "(KHR_node_visibility) and cannot be felt: \"a\", \"b\"; "
                       "--feel-hidden loads hidden nodes, too"))
      << info.err;
  const Outcome none = run_program(folder, {"info", "hidden.glb", "--list", "--node", "c"});
  EXPECT_EQ(none.exit_code, 2);
}

TEST(SceneContent, HiddenNodesOutsideTheLoadedNodeAreNotTold) {
  const TemporaryFolder folder;
  write_scenes(folder);
  const json answer = json::parse(
      run_program(folder, {"info", "scenes.glb", "--scene", "1", "--node", "prism", "--json"}).out);
  EXPECT_EQ(answer["hidden_nodes"]["count"], 0);
  for (const json& line : answer["warnings"]) {
    EXPECT_FALSE(contains(line.get<std::string>(), "hidden")) << line;
  }
}

TEST(SceneContent, ARecordingSaysWhatOfTheFileWasLoaded) {
  const TemporaryFolder folder;
  write_scenes(folder);
  const auto summary = [&](std::vector<std::string> options) {
    std::vector<std::string> command = {"run",  "scenes.glb", "--virtual", "--seconds", "2",
                                        "--a4", "off",        "--record",  "r.palpate"};
    command.insert(command.end(), options.begin(), options.end());
    const Outcome run = run_program(folder, command);
    EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 3) << run.err;
    const std::string text = run_program(folder, {"recording", "info", "r.palpate"}).out;
    std::remove(folder.path("r.palpate").c_str());
    return text;
  };
  const std::string plain = summary({});
  for (const char* name : {"listed scene", "node", "hidden nodes"}) {
    EXPECT_FALSE(contains(plain, "\n  " + std::string(name) + " ")) << plain;
  }
  const std::string chosen = summary({"--scene", "far", "--node", "prism", "--feel-hidden"});
  EXPECT_TRUE(contains(chosen, "\n  listed scene  far\n")) << chosen;
  EXPECT_TRUE(contains(chosen, "\n  node          prism\n")) << chosen;
  EXPECT_TRUE(contains(chosen, "\n  hidden nodes  felt\n")) << chosen;
}

}  // namespace
}  // namespace palpate
