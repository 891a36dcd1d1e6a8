// Materials, their values and their effects, as `info` and `replay` report them.

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::CommandLine;
using test::content_of;
using test::GltfBuilder;
using test::keys_of;
using test::rows_of;
using test::sorted;

TEST_F(CommandLine, PrintsTheParametersOfMaterials) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json["materials"] = {
      {{"name", "a \"b\"\n"},
       {"extras",
        {{"palpate", {{"stiffness", 800}, {"texture", {{"amplitude", 0.5}}}, {"on", true}}}}}},
      {{"name", "paint"}}};
  json& primitives = gltf.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  for (std::size_t i = 0; i < 2; ++i) primitives[i]["material"] = i;
  const std::string path = gltf.write_glb(folder);
  const json info = json::parse(expect_done({"info", path, "--json"}).out);
  const json declared = {{"stiffness", 800}, {"texture.amplitude", 0.5}, {"on", true}};
  ASSERT_EQ(info["materials"].size(), 2u);
  EXPECT_EQ(info["materials"][0]["name"], "a \"b\"\n");
  EXPECT_EQ(info["materials"][0]["parameters"], declared);
  EXPECT_EQ(info["materials"][1]["name"], "paint");
  EXPECT_EQ(info["materials"][1]["parameters"], json::object());
  const std::string text = expect_done({"info", path}).out;
  EXPECT_NE(text.find("\n  material \"a \\\"b\\\"\\n\": on true, stiffness 800.0, "
                      "texture.amplitude 0.5\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("paint"), std::string::npos) << text;
}

// A triangle in the plane z = 0 whose material has these extras.
GltfBuilder triangle_of(const json& palpate) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json["materials"] = {{{"name", "wood.1"}, {"extras", {{"palpate", palpate}}}}};
  gltf.json["meshes"][0]["primitives"][0]["material"] = 0;
  return gltf;
}

TEST_F(CommandLine, ReportsAppliedAndIgnoredValues) {
  GltfBuilder gltf = triangle_of({{"staticFriction", 0.5}, {"restitution", 0.0}, {"hue", 3}});
  gltf.json["extensionsUsed"] = {"KHR_physics_rigid_bodies"};
  gltf.json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"] = {
      {{"staticFriction", 0.7}, {"dynamicFriction", 0.4}, {"restitution", 0.0}}};
  gltf.json["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"]["collider"] = {
      {"physicsMaterial", 0}};
  const std::string path = gltf.write_glb(folder);
  const json info =
      json::parse(expect_done({"info", path, "--json", "--material", "wood.1.stiffness=800"}).out);
  EXPECT_EQ(info["effects"], json({"friction", "stiffness"}));
  const json& wood = info["materials"][0];
  EXPECT_EQ(wood["effects"], json({"friction", "stiffness"}));
  EXPECT_EQ(wood["parameters"]["stiffness"], 800);
  std::vector<std::string> values;
  for (const json& h : wood["honoured"]) {
    values.push_back(h["key"].get<std::string>() + " " + h["value"].dump() + " " +
                     h["unit"].get<std::string>() + " " + h["source"].get<std::string>() +
                     (h["off"] ? " off" : ""));
  }
  std::sort(values.begin(), values.end());
  EXPECT_EQ(values, (std::vector<std::string>{"dynamicFriction 0.4  KHR_physics_rigid_bodies",
                                              "restitution 0.0  extras.palpate off",
                                              "staticFriction 0.5  extras.palpate",
                                              "stiffness 800.0 N/m --material"}));
  ASSERT_EQ(wood["not_understood"].size(), 1u);
  EXPECT_EQ(wood["not_understood"][0]["element"], "/materials/0/extras/palpate/hue");
  const std::string text = expect_done({"info", path}).out;
  for (const char* line :
       {"    applied: ", "staticFriction 0.5 (extras.palpate)",
        "restitution 0.0 (extras.palpate, off)", "dynamicFriction 0.4 (KHR_physics_rigid_bodies)",
        "    ignored: hue 3.0", "  effects: friction\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << " is not in " << text;
  }
  EXPECT_GT(info["memory"]["effects"], 0);
}

// An error is one line: warnings are printed only if no error occurs.
TEST_F(CommandLine, WarnsOfIgnoredKeysUnlessAnErrorOccurs) {
  GltfBuilder gltf = triangle_of({{"hue", 3}});
  const std::string path = gltf.write_glb(folder);
  const std::string trajectory = folder.write("path.txt", "0.2 0.2 0.1\n0.2 0.2 -0.1\n");
  const std::vector<std::string> replayed{"replay", path, "--trajectory", trajectory};
  const std::vector<std::string> run{"run", path, "--virtual", "--seconds", "2", "--sensors", "3"};
  const std::string warning =
      "palpate: warning: /materials/0/extras/palpate/hue: hue of \"wood.1\"";
  EXPECT_TRUE(expect_done(replayed).err.starts_with(warning));
  std::vector<std::string> fitted = run;
  fitted.insert(fitted.end(), {"--fit", "0.2"});
  EXPECT_TRUE(expect_run(fitted).err.starts_with(warning));
  for (std::vector<std::string> refused : {replayed, fitted}) {
    refused.insert(refused.end(), {"--move", "moon=0 0 0 0 0 0"});
    expect_refused(refused, {"moon"});
  }
  expect_refused({"run", path, "--virtual", "--fit", "0.2", "--plane-height", "9"},
                 {"--plane-height"});
}

TEST_F(CommandLine, CompletesPhysicsMaterialsThatStateOneCoefficient) {
  GltfBuilder gltf = triangle_of(json::object());
  gltf.json["extensionsUsed"] = {"KHR_physics_rigid_bodies"};
  gltf.json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"] = {
      {{"staticFriction", 0.3}}};
  gltf.json["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"]["collider"] = {
      {"physicsMaterial", 0}};
  const std::string path = gltf.write_glb(folder);
  const json wood = json::parse(expect_done({"info", path, "--json"}).out)["materials"][0];
  ASSERT_EQ(wood["honoured"].size(), 1u);
  EXPECT_EQ(wood["honoured"][0]["element"],
            "/extensions/KHR_physics_rigid_bodies/physicsMaterials/0/staticFriction");
  EXPECT_EQ(wood["defaulted"], json({{{"key", "dynamicFriction"}, {"value", 0.3}, {"unit", ""}}}));
  const json off = json::parse(
      expect_done({"info", path, "--json", "--material", "wood.1.staticFriction=0"}).out);
  EXPECT_EQ(off["effects"], json::array());
}

TEST_F(CommandLine, ReportsTheDefaultsInUse) {
  const std::string path = triangle_of({{"restitution", 0.5}}).write_glb(folder);
  const json info = json::parse(expect_done({"info", path, "--json"}).out);
  EXPECT_EQ(info["materials"][0]["defaulted"],
            json({{{"key", "impactMass"}, {"value", 0.05}, {"unit", "kg"}},
                  {{"key", "impactDuration"}, {"value", 0.005}, {"unit", "s"}}}));
}

TEST_F(CommandLine, RefusesInvalidMaterialValues) {
  const std::string good = triangle_of({{"stiffness", 500}}).write_glb(folder);
  expect_refused({"info", good, "--material", "wood.1.stiffness=-1"},
                 {"--material wood.1.stiffness", "wood.1", "stiffness is -1", "1e+06 N/m"});
  expect_refused({"info", good, "--material", "wood.1.stiffness=hard"},
                 {"wood.1", "stiffness is \"hard\"", "N/m"});
  expect_refused({"info", good, "--material", "glass.stiffness=1"}, {"--material", "glass"});
  expect_refused(
      {"info", good, "--material", "wood.1.stiffnes=1"},
      {"--material wood.1.stiffnes", "wood.1", "use one of the keys solid, stiffness, "});
  for (const char* none : {"stiffness=1", "wood.1.stiffness", "=1", ".stiffness=1", "wood.1.=1",
                           "wood.1.stiffness="}) {
    expect_refused({"info", good, "--material", none}, {"--material", none});
  }
  write_path();
  const std::vector<std::string> play = {"--trajectory", folder.path("path.txt")};
  std::vector<std::string> hum = {"replay",     good,
                                  "--material", "wood.1.vibrationAmplitude=1",
                                  "--material", "wood.1.vibrationFrequency=600"};
  hum.insert(hum.end(), play.begin(), play.end());
  expect_refused(hum, {"wood.1", "vibrationFrequency is 600", "--rate", "500 Hz"});
  hum.insert(hum.end(), {"--rate", "2000"});
  expect_done(hum);

  const std::string bad = triangle_of({{"magnetForce", 1}}).write_glb(folder);
  expect_refused({"info", bad},
                 {bad, "/materials/0/extras/palpate/magnetForce", "wood.1", "magnetRange"});
}

TEST_F(CommandLine, CountsTheTicksInWhichAnEffectIsActive) {
  const std::string scene =
      triangle_of({{"stiffness", 500}, {"dynamicFriction", 0.2}, {"staticFriction", 0.3}})
          .write_glb(folder);
  std::ostringstream path;
  for (int n = 0; n < 100; ++n) path << "0.3 0.3 " << 0.05 - 0.001 * n << "\n";
  for (int n = 0; n < 50; ++n) path << 0.3 + 0.004 * n << " 0.3 -0.049\n";
  const std::string file = folder.write("press.txt", path.str());
  const json plain =
      json::parse(expect_done({"replay", scene, "--trajectory", file, "--json"}).out);
  EXPECT_EQ(keys_of(plain["effects"]), sorted({"friction", "stiffness", "a4"}));
  EXPECT_EQ(plain["effects"]["stiffness"], json({{"ticks", plain["contact_ticks"]}}));
  EXPECT_EQ(plain["effects"]["friction"]["ticks"], plain["contact_ticks"]);
  EXPECT_EQ(plain["effects"]["a4"]["ticks"], 0);
  EXPECT_GT(plain["contact_ticks"], 90);
  const json timed = json::parse(
      expect_done({"replay", scene, "--trajectory", file, "--json", "--effect-times", "--repeat",
                   "3", "--sensors", "3", "--actuated-axes", "1 0 0", "--a4", "on"})
          .out);
  EXPECT_EQ(timed["effects"]["stiffness"]["ticks"], timed["contact_ticks"]);
  EXPECT_GT(timed["effects"]["stiffness"]["time_share"], 0.0);
  EXPECT_LT(timed["effects"]["stiffness"]["time_share"], 1.0);
  EXPECT_GT(timed["effects"]["a4"]["ticks"], 0);
  EXPECT_LE(timed["effects"]["a4"]["ticks"], timed["contact_ticks"]);
  const std::string text = expect_done({"replay", scene, "--trajectory", file}).out;
  EXPECT_NE(text.find("friction active in " + plain["contact_ticks"].dump() + " ticks\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("A4 turned the scene in 0 ticks"), std::string::npos) << text;
}

// Pressed to 49 mm, the hand moves sideways in steps of 4 mm: it sticks to 14.7 mm and slides on
// from there, at 0.2 of the normal force.
TEST_F(CommandLine, WritesToTheTraceWhetherAContactSticksOrSlides) {
  const std::string scene =
      triangle_of({{"dynamicFriction", 0.2}, {"staticFriction", 0.3}}).write_glb(folder);
  std::ostringstream path;
  path << "0.3 0.3 0.01\n0.3 0.3 -0.049\n";
  for (int n = 1; n <= 20; ++n) path << 0.3 + 0.004 * n << " 0.3 -0.049\n";
  const std::string file = folder.write("press.txt", path.str());
  const std::string out = folder.path("trace.csv");
  expect_done({"replay", scene, "--trajectory", file, "--out", out});
  const auto rows = rows_of(content_of(out));
  ASSERT_EQ(rows.size(), 22u);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const char* expected = n == 0 ? "none" : n <= 4 ? "sticks" : "slides";
    EXPECT_EQ(rows[n][26], expected) << n;
    if (n <= 4) continue;
    EXPECT_NEAR(std::stod(rows[n][14]), -0.2 * std::stod(rows[n][16]), 1e-9) << n;
  }
}

}  // namespace
}  // namespace palpate
