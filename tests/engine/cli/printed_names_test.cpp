// Names in files that contain terminal commands, line breaks or markup do not reach the output of
// the program as such. Needs PALPATE_PROGRAM, the program.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "geometry/base/printable.h"
#include "models/primitives.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::add_floats;
using test::content_of;
using test::GltfBuilder;
using test::Outcome;
using test::TemporaryFolder;

// Only a line break in a name can put this text at the beginning of a printed line.
constexpr const char* kForged = "FORGED";

// Escape sequences, C0 and C1 controls, line ends, changes of writing direction, markup, a name of
// multi-byte characters that is longer than a message shows, and a mixture.
const std::array<std::string, 7> kNames = {
    "\x1b[31mred\x1b[0m\x1b]0;title\x07\r\b\x7f",
    "two\nFORGED: line\r\nFORGED",
    "\u0085FORGED\u009b31m\u2028FORGED\u2029",
    "\u202egnp.\u2066exe\u2069\u200f",
    "</title><script>alert(1)</script>&\"'<img src=x onerror=alert(1)>`@{}",
    "\u00e4\u6f22\U0001f600 " + std::string("\x1b[2J") +
        []() {
          std::string text;
          for (int i = 0; i < 50; ++i) text += "\u6f22";
          return text;
        }(),
    "\x1b[31m\u009b<script>\u202e&\"'\n<img \x7f"};

class PrintedNames : public testing::TestWithParam<std::size_t> {
 protected:
  PrintedNames() : name(kNames[GetParam()]) {
    // A key may not contain a dot, and must be short.
    for (const char c : name.substr(0, 30)) key += c == '.' ? '_' : c;
    key = as_utf8(key);
  }

  // Removes a truncated character at the end, which JSON does not allow.
  static std::string as_utf8(std::string text) {
    while (json(text).dump(-1, ' ', false, json::error_handler_t::replace).find("\ufffd") !=
           std::string::npos) {
      text.pop_back();
    }
    return text;
  }

  Outcome call(const std::vector<std::string>& arguments) const {
    return test::run_program(folder, arguments);
  }

  static void expect_printable(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_EQ(line, printable(line));
      EXPECT_FALSE(line.starts_with(kForged)) << line;
    }
  }

  static void expect_no_markup(const std::string& text) {
    for (const char* tag : {"<script", "<img", "</title><"}) {
      EXPECT_EQ(text.find(tag), std::string::npos) << tag;
    }
  }

  Outcome expect_done(const std::vector<std::string>& arguments) const {
    const Outcome o = call(arguments);
    SCOPED_TRACE(arguments.front() + " " + arguments.back());
    const bool may_be_not_comparable = arguments.front() == "run";
    EXPECT_TRUE(o.exit_code == 0 || (may_be_not_comparable && o.exit_code == 3)) << o.err;
    expect_printable(o.out);
    expect_printable(o.err);
    return o;
  }

  void expect_refused(const std::vector<std::string>& arguments) const {
    const Outcome o = call(arguments);
    SCOPED_TRACE(arguments.front() + " " + arguments.back() + ": " + o.err);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    expect_printable(o.err);
    // Warnings about ignored keys may precede the error.
    const auto lines = arguments.front() == "run" ? 4 : 1;
    EXPECT_LE(std::count(o.err.begin(), o.err.end(), '\n'), lines);
  }

  // A box of 0.1 m in which whatever may have a name has this one, and keys that nobody knows.
  GltfBuilder named_box() const {
    const TriangleMesh mesh = box(Vec3(0.1, 0.1, 0.1));
    std::vector<Eigen::Vector3f> positions;
    for (const Vec3& p : mesh.positions_m) positions.push_back(p.cast<float>());
    std::vector<std::uint32_t> indices;
    for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
    GltfBuilder asset;
    const json primitive = {{"attributes", {{"POSITION", asset.add_positions(positions)}}},
                            {"indices", asset.add_indices(indices)},
                            {"material", 0}};
    asset.add_mesh({primitive});
    asset.json["meshes"][0]["name"] = name;
    const json declared = {{key, name}, {"stiffness", 500}};
    asset.json["materials"] = {{{"name", name}, {"extras", {{"palpate", declared}}}}};
    asset.add_node({{"mesh", 0}, {"name", name}, {"extras", {{"palpate", {{key, 1}}}}}});
    asset.add_node(
        {{"name", name},
         {"extras",
          {{"palpate", {{"medium", "box"}, {"size", {1, 1, 1}}, {"viscosity", 1}, {key, 2}}}}}});
    asset.add_node({{"mesh", 0}, {"name", name}, {"scale", {0, 0, 0}}});
    asset.json["scenes"][0]["name"] = name;
    asset.json["scenes"][0]["extras"] = {{"palpate", {{key, 3}}}};
    asset.json["extensionsUsed"] = {name};
    const auto times = add_floats(asset, {0, 1, 1}, "SCALAR");
    const auto values = add_floats(asset, {0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3");
    asset.json["animations"] = {
        {{"name", name},
         {"samplers", {{{"input", times}, {"output", values}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    return asset;
  }

  // Uses the name as a file name, without the characters that a file name cannot have.
  std::string write(const GltfBuilder& asset) const {
    std::string file = name.substr(0, 120);
    for (char& c : file) c = c == '/' || c == '\n' ? '_' : c;
    return folder.write(file + ".glb", asset.glb_bytes());
  }

  std::string name;
  std::string key;
  TemporaryFolder folder;
};

INSTANTIATE_TEST_SUITE_P(All, PrintedNames, testing::Range(std::size_t{0}, kNames.size()));

TEST_P(PrintedNames, DoNotControlTheTerminalInADescriptionOfAScene) {
  const std::string path = write(named_box());
  const json info = json::parse(expect_done({"info", path, "--json"}).out);
  EXPECT_EQ(info["materials"][0]["name"], name);
  EXPECT_EQ(info["animations"][0]["name"], name);
  EXPECT_EQ(info["regions"][0]["name"], name);
  const json tree = json::parse(expect_done({"info", path, "--json", "--list"}).out);
  EXPECT_EQ(tree[0]["name"], name);
  EXPECT_EQ(json::parse(expect_done({"info", path, "--json", "--pose", name + "@1"}).out)["pose"],
            json({{"number", 0}, {"name", name}, {"time_s", 1.0}}));
  const std::string text = expect_done({"info", path, "--pose", "#0@0.5"}).out;
  for (const char* part :
       {"animation #0", "pose: animation", "material", "region", "warning: ", "ignored: "}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in " << text;
  }
  expect_done({"info", path, "--list"});
}

TEST_P(PrintedNames, DoNotControlTheTerminalInErrors) {
  const std::string path = write(named_box());
  expect_refused({"info", path, "--node", name});
  expect_refused({"info", path, "--node", name + name});
  expect_refused({"info", path, "--pose", name});
  expect_refused({"info", path, "--pose", name + "x@0"});
  expect_refused({"info", path, "--pose", name + "@" + name});
  expect_refused({"info", path, "--material", name + ".stiffness=-1"});
  expect_refused({"info", path, "--material", name + ".x=1"});
  expect_refused({"info", path, "--scale", name});
  expect_refused({"info", path, "--" + name});
  expect_refused({name});
  expect_refused({"info", name});
  expect_refused({"run", path, "--virtual", "--move", name + "=1 0 0 0 0 0"});
  expect_refused({"run", path, "--virtual", "--place", name});
  expect_refused({"replay", path, "--trajectory", name});
  expect_refused({"accuracy", "--knob", name});
  const auto expect_broken = [&](const auto& change) {
    GltfBuilder asset = named_box();
    change(asset.json);
    expect_refused({"info", write(asset)});
  };
  expect_broken([&](json& j) { j["extensionsRequired"] = {name}; });
  expect_broken([&](json& j) { j["nodes"][0]["mesh"] = name; });
  expect_broken([&](json& j) { j["asset"]["version"] = name; });
  expect_broken([&](json& j) { j["accessors"][0]["type"] = name; });
  expect_broken([&](json& j) { j["materials"][0]["extras"]["palpate"]["stiffness"] = name; });
  expect_broken([&](json& j) { j["materials"][0]["extras"]["palpate"]["stiffness"] = -1; });
  expect_broken([&](json& j) { j["nodes"][1]["extras"]["palpate"]["medium"] = name; });
  const auto file = named_box().data_uri_text();
  const std::string uri = "data:" + name;
  json root = json::parse(file);
  root["buffers"][0]["uri"] = uri;
  expect_refused({"info", folder.write("uri.gltf", root.dump())});
  root["buffers"][0]["uri"] = name + ".bin";
  expect_refused({"info", folder.write("uri.gltf", root.dump())});
  expect_refused({"info", folder.write("text.gltf", "{\"asset\": " + name)});
  expect_refused({"info", folder.write("bytes.gltf", "\xff\x1b[31m" + name)});
}

TEST_P(PrintedNames, DoNotControlTheTerminalAndAreNotMarkupInRuns) {
  const std::string path = write(named_box());
  expect_done({"run", path, "--virtual", "--seconds", "3", "--out", "out"});
  for (const char* arguments : {"--json", "--effect-times"}) {
    const Outcome o = expect_done({"run", path, "--virtual", "--seconds", "3", arguments});
    if (o.out.starts_with("{")) {
      EXPECT_FALSE(json::parse(o.out).empty());
    }
    EXPECT_NE(o.err.find("is ignored"), std::string::npos) << o.err;
  }
  const std::string picture = content_of(folder.path("out/paths.svg"));
  EXPECT_NE(picture.find("<svg"), std::string::npos);
  expect_printable(picture);
  expect_no_markup(picture);
  const std::string way = folder.write("way.txt", "0 0 0.2\n0 0 0.1\n0 0 0.04\n");
  expect_done({"replay", path, "--trajectory", way, "--pose", "#0@1"});
  const Outcome replayed = expect_done({"replay", path, "--trajectory", way, "--json"});
  EXPECT_EQ(json::parse(replayed.out)["not_understood"].size(), 4u);
}

// Slow, so only for the last name.
class PrintedNamesInAReport : public PrintedNames {};
INSTANTIATE_TEST_SUITE_P(Last, PrintedNamesInAReport, testing::Values(kNames.size() - 1));

TEST_P(PrintedNamesInAReport, DoNotControlTheTerminalAndAreNotMarkup) {
  const std::string path = write(named_box());
  expect_done({"accuracy", path, "--quick", "--knob", "a4_step", "--out", "report"});
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("report"))) {
    SCOPED_TRACE(entry.path().filename().string());
    const std::string content = content_of(entry.path().string());
    expect_printable(content);
    const auto kind = entry.path().extension();
    if (kind == ".html" || kind == ".svg") expect_no_markup(content);
    ++files;
  }
  EXPECT_GE(files, 4u);
}

}  // namespace
}  // namespace palpate
