// The scene of a command: its part, size, pose, motion and gaps, and what `info` says about it.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/slit_tube.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::CommandLine;
using test::content_of;
using test::GltfBuilder;
using test::kCube;
using test::keys_of;
using test::kStar;
using test::Outcome;
using test::sorted;
using test::without_times;

// ---- part, size and motion ---------------------------------------------------------------------

TEST_F(CommandLine, ListsTheNodesOfAScene) {
  EXPECT_EQ(expect_done({"info", kStar, "--list"}).out,
            std::string(kStar) + "\n  star  #0  mesh\n");
  const json list = json::parse(expect_done({"info", kStar, "--list", "--json"}).out);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0]["name"], "star");
  EXPECT_EQ(list[0]["number"], 0);
  EXPECT_TRUE(list[0]["parent"].is_null());
}

TEST_F(CommandLine, LoadsAPartInAnySize) {
  const auto extent = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", kCube, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(expect_done(arguments).out)["extent_m"][0].get<double>();
  };
  const double as_it_is = extent({});
  EXPECT_EQ(extent({"--scale", "0.25"}), 0.25 * as_it_is);
  EXPECT_NEAR(extent({"--fit", "0.3"}), 0.3, 1e-15);
  EXPECT_EQ(extent({"--node", "cube"}), as_it_is);
  EXPECT_EQ(extent({"--node", "#0"}), as_it_is);
}

TEST_F(CommandLine, RefusesUnknownNodesAndInvalidSizes) {
  expect_refused({"info", kCube, "--node", "sphere"}, {kCube, "sphere", "--list"});
  for (const char* size : {"0", "-1", "nan", "inf", "1e-400"}) {
    expect_refused({"info", kCube, "--scale", size}, {"--scale"});
    expect_refused({"info", kCube, "--fit", size}, {"--fit"});
  }
  expect_refused({"info", kCube, "--fit", "1", "--scale", "1"}, {"--fit", "--scale"});
}

// The hint appears if `run` refuses the size.
TEST_F(CommandLine, HintsAtFitForScenesThatDoNotFitTheWorkspace) {
  const std::string hint = "run it with --fit auto";
  EXPECT_EQ(expect_done({"info", kStar}).out.find(hint), std::string::npos);
  for (const std::string size : {"4", "0.003"}) {
    const std::string text = expect_done({"info", kCube, "--fit", size}).out;
    EXPECT_NE(text.find("\n  size: " + size + " x " + size + " x " + size +
                        " m; a device's workspace is 0.4 m: " + hint + "\n"),
              std::string::npos)
        << text;
    expect_refused({"run", kCube, "--virtual", "--fit", size}, {"--fit auto"});
  }
}

TEST_F(CommandLine, FitsASceneToTheWorkspace) {
  for (const char* scale : {"20", "0.01"}) {
    expect_refused({"run", kStar, "--virtual", "--scale", scale}, {"scene", "--fit 0.2"});
  }
  const json as_it_is =
      json::parse(expect_done({"run", kStar, "--virtual", "--fit", "auto", "--json"}).out);
  EXPECT_EQ(as_it_is["scale"], 1.0) << "it fits";
  const json fitted = json::parse(
      expect_done({"run", kStar, "--virtual", "--fit", "auto", "--json", "--workspace", "0.2"})
          .out);
  EXPECT_LT(fitted["scale"], 1.0);
  EXPECT_EQ(fitted["workspace_m"], 0.2);
  expect_refused({"run", kStar, "--virtual", "--fit", "auto", "--scale", "2"}, {"--fit"});
  expect_refused({"info", kStar, "--fit", "auto"}, {"--fit", "auto", "workspace"});
  expect_refused({"run", kStar, "--virtual", "--fit", "large"}, {"--fit", "auto"});
}

TEST_F(CommandLine, ChoosesThePlaneHeightAfterPlacingTheScene) {
  const json result = json::parse(
      expect_done({"run", kStar, "--virtual", "--place", "0 0 1 1 0 0 0", "--json"}).out);
  EXPECT_EQ(result["plane_height_m"], 1.0);
}

// A triangle whose node moves from x = 0 to 4 within two seconds, and another clip.
GltfBuilder moving_triangle() {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  const auto clip = [&](const char* name, float x) {
    const auto times = gltf.add_view(test::bytes_of(std::vector<float>{0, 2}));
    const auto values = gltf.add_view(test::bytes_of(std::vector<float>{0, 0, 0, x, 0, 0}));
    const auto input = gltf.add_accessor(times, GltfBuilder::kFloat, 2, "SCALAR");
    const auto output = gltf.add_accessor(values, GltfBuilder::kFloat, 2, "VEC3");
    gltf.json["animations"].push_back(
        {{"name", name},
         {"samplers", {{{"input", input}, {"output", output}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
  };
  clip("Go", 4);
  clip("Jump", 40);
  return gltf;
}

TEST_F(CommandLine, PosesASceneByOneAnimationAtOneTime) {
  const std::string path = moving_triangle().write_glb(folder);
  const auto info = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", path, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(expect_done(arguments).out);
  };
  const json at_rest = info({});
  EXPECT_TRUE(at_rest["pose"].is_null());
  EXPECT_EQ(at_rest["animations"], json({{{"number", 0}, {"name", "Go"}, {"length_s", 2.0}},
                                         {{"number", 1}, {"name", "Jump"}, {"length_s", 2.0}}}));
  EXPECT_EQ(at_rest["bounding_box"]["min_m"], json({0.0, 0.0, 0.0}));
  const json posed = info({"--pose", "Go@0.5", "--scale", "2"});
  EXPECT_EQ(posed["pose"], json({{"number", 0}, {"name", "Go"}, {"time_s", 0.5}}));
  EXPECT_EQ(posed["bounding_box"]["min_m"], json({2.0, 0.0, 0.0}));
  EXPECT_EQ(posed["bounding_box"]["max_m"], json({4.0, 2.0, 0.0}));
  EXPECT_EQ(posed["bounding_box"]["centre_m"], json({3.0, 1.0, 0.0}));
  const std::string text = expect_done({"info", path, "--pose", "#1@1"}).out;
  for (const char* line : {"\n  animation #0 \"Go\", 2 s\n", "\n  animation #1 \"Jump\", 2 s\n",
                           "\n  pose: animation #1 \"Jump\" at 1 s\n",
                           "\n  bounding box (20, 0, 0) to (21, 1, 0) m, centre (20.5, 0.5, 0) m\n",
                           "\n  contour across A1 through the centre: 0.5 m, open\n",
                           "\n  contour across A3 through the centre: none\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << " is not in " << text;
  }
  const std::string way = folder.write("way.txt", "2.2 0.2 0.1\n2.2 0.2 -0.01\n");
  const auto replayed = [&](const char* pose) {
    return json::parse(
        expect_done({"replay", path, "--trajectory", way, "--json", "--pose", pose}).out);
  };
  EXPECT_EQ(replayed("Go@1")["contact_ticks"], 1);
  EXPECT_EQ(replayed("Go@0")["contact_ticks"], 0);
  EXPECT_NE(expect_done({"replay", path, "--trajectory", way, "--pose", "Go@1"})
                .out.find("pose: animation #0 \"Go\" at 1 s"),
            std::string::npos);
}

TEST_F(CommandLine, RefusesInvalidPoses) {
  const std::string path = moving_triangle().write_glb(folder);
  for (const char* pose : {"Go", "Go@", "Go@x", "Go@-1", "Go@nan", "@1", "Went@0", "#2@0"}) {
    expect_refused({"info", path, "--pose", pose}, {pose, "#0 \"Go\" of 2 s, #1 \"Jump\" of 2 s"});
  }
  expect_refused({"info", path, "--pose", ""}, {"--pose"});
  expect_refused({"run", path, "--virtual", "--pose", "Went@0"}, {"Went"});
  const std::string way = folder.write("way.txt", "0 0 1\n");
  expect_refused({"replay", path, "--trajectory", way, "--pose", "Went@0"}, {"Went"});
  expect_refused({"accuracy", path, "--quick", "--pose", "Went@0"}, {"Went"});
  expect_refused({"info", kStar, "--pose", "Go@0"}, {"Go@0", "no animation"});
}

TEST_F(CommandLine, MovesNodesTheSameWayEveryTime) {
  write_path();
  const auto trace = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = replay({"--out", folder.path("trace.csv")});
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_done(arguments);
    return without_times(content_of(folder.path("trace.csv")));
  };
  const std::string resting = trace({});
  const std::string moving = trace({"--move", "star=0.2 0 0 0 0 3"});
  EXPECT_NE(moving, resting);
  EXPECT_EQ(trace({"--move", "star=0.2 0 0 0 0 3"}), moving);
  EXPECT_EQ(trace({"--move", "star=0 0 0 0 0 0"}), resting);
}

TEST_F(CommandLine, RefusesInvalidMotions) {
  write_path();
  for (const char* move : {"star", "star=", "star=1 2 3", "=0 0 0 0 0 0", "star=0 0 0 0 0 x",
                           "star=0 0 0 0 0 0 0", "star=0 0 0 0 0 inf"}) {
    expect_refused(replay({"--move", move}), {"--move"});
  }
  expect_refused(replay({"--move", "moon=0 0 0 0 0 0"}), {"moon", "--list"});
}

// ---- gaps --------------------------------------------------------------------------------------

// `info` says how far apart open edges are and what closes them; nothing is closed without demand,
// nor beyond the demanded width.
TEST_F(CommandLine, ClosesGapsOnDemandAndSaysSo) {
  const std::string tube = test::slit_tube().write_glb(folder);
  const auto info = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", tube, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = expect_done(arguments);
    return std::pair(json::parse(o.out), o.err);
  };
  const auto [open, silence] = info({});
  EXPECT_EQ(silence, "");
  EXPECT_EQ(open["boundary_edges"], 12);
  EXPECT_EQ(open["joined"]["edges"], 0);
  EXPECT_EQ(open["gaps_joined"]["edges"], 0);
  EXPECT_FALSE(open["contours"][2]["closed"].get<bool>());
  const double gap_m = open["nearest_gap_m"];
  EXPECT_NEAR(gap_m, test::kSlit_m, 1e-9);
  // The text states the width that closes the gap, and that width does.
  const std::string text = expect_done({"info", tube}).out;
  const std::string before = " m apart; --close-gaps ";
  const std::size_t at = text.find(before);
  ASSERT_NE(at, std::string::npos) << text;
  const std::size_t begin = at + before.size();
  const std::string width = text.substr(begin, text.find(' ', begin) - begin);
  EXPECT_EQ(std::stod(width), gap_m);
  for (const std::string& wide : {width, std::string("0.007")}) {
    const auto [closed, said] = info({"--close-gaps", wide});
    EXPECT_EQ(closed["boundary_edges"], 10);
    EXPECT_EQ(closed["gaps_joined"]["edges"], 1);
    EXPECT_EQ(closed["gaps_joined"]["vertices"], 2);
    EXPECT_TRUE(closed["contours"][2]["closed"].get<bool>());
    EXPECT_NE(said.find("--close-gaps joined 1 pairs of edges and 2 vertices"), std::string::npos)
        << said;
  }
  const auto [narrow, said] = info({"--close-gaps", "0.0019"});
  EXPECT_EQ(narrow["boundary_edges"], 12);
  EXPECT_EQ(narrow["gaps_joined"]["edges"], 0);
  EXPECT_NE(said.find("--close-gaps joined 0 pairs of edges"), std::string::npos) << said;
  // In another size, the width is one of the scene as it is loaded.
  const auto [small, of_small] = info({"--scale", "0.1", "--close-gaps", "0.00021"});
  EXPECT_EQ(small["gaps_joined"]["edges"], 1) << of_small;
}

TEST_F(CommandLine, RefusesWidthsThatAreNoGaps) {
  const std::string tube = test::slit_tube().write_glb(folder);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"info", tube}, {"run", tube, "--virtual", "--seconds", "2"}}) {
    for (const char* width :
         {"-0.001", "0", "-0", "nan", "inf", "-inf", "1e-400", "2mm", "", " "}) {
      std::vector<std::string> arguments = command;
      arguments.insert(arguments.end(), {"--close-gaps", width});
      expect_refused(arguments, {"--close-gaps"});
    }
    for (const char* width : {"0.008001", "0.08", "1e300"}) {
      std::vector<std::string> arguments = command;
      arguments.insert(arguments.end(), {"--close-gaps", width});
      expect_refused(arguments, {tube, "--close-gaps", "tenth of the extent", "0.08"});
    }
    std::vector<std::string> arguments = command;
    arguments.push_back("--close-gaps");
    expect_refused(arguments, {"--close-gaps"});
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("out")));
}

// The hand follows an open contour to its end and back; the run says so, and closes no gap itself.
TEST_F(CommandLine, ARunSaysThatItsContourIsOpen) {
  const std::string tube = test::slit_tube().write_glb(folder);
  const std::vector<std::string> run{"run", tube, "--virtual", "--seconds", "2", "--a4", "on"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = run;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return expect_run(arguments);
  };
  const std::string line = "! the contour is open";
  EXPECT_NE(with({}).out.find(line), std::string::npos);
  EXPECT_EQ(json::parse(with({"--json"}).out)["runs"][0]["contour_closed"], false);
  const Outcome closed = with({"--close-gaps", "0.0021"});
  EXPECT_EQ(closed.out.find(line), std::string::npos) << closed.out;
  EXPECT_EQ(
      json::parse(with({"--close-gaps", "0.0021", "--json"}).out)["runs"][0]["contour_closed"],
      true);
  // Once, although the scene may be loaded again for other trials.
  const std::string said = "--close-gaps joined 1 pairs of edges and 2 vertices";
  const std::size_t at = closed.err.find(said);
  ASSERT_NE(at, std::string::npos) << closed.err;
  EXPECT_EQ(closed.err.find(said, at + 1), std::string::npos) << closed.err;
  // The line is about the boundary of a surface, not about the sample that ends a closed contour.
  EXPECT_EQ(expect_run({"run", kStar, "--virtual", "--seconds", "2"}).out.find(line),
            std::string::npos);
}

// Two boxes, 1 mm apart.
TEST_F(CommandLine, ClosesGapsBetweenNodesOnDemand) {
  GltfBuilder gltf = test::slit_tube();
  const auto mesh = json::parse(R"({"mesh": 0, "name": "right", "translation": [0.081, 0, 0]})");
  gltf.add_node(mesh);
  const std::string boxes = gltf.write_glb(folder);
  const auto seams = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", boxes, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = expect_done(arguments);
    return std::pair(json::parse(o.out)["node_seams"], o.err);
  };
  // Texts of the library name the option.
  const std::string text = expect_done({"info", boxes, "--close-gaps", "0.0015"}).out;
  EXPECT_NE(text.find("seams: "), std::string::npos) << text;
  EXPECT_EQ(text.find("SceneSettings"), std::string::npos) << text;
  const json open = seams({}).first;
  EXPECT_EQ(open["places"], 0);
  EXPECT_EQ(open["changed_nodes"], 0);
  const auto [closed, said] = seams({"--close-gaps", "0.0015"});
  EXPECT_GT(closed["places"], 3);
  EXPECT_EQ(closed["changed_nodes"], 1);
  EXPECT_NE(said.find("moved 1 nodes"), std::string::npos) << said;
}

// ---- info --------------------------------------------------------------------------------------

TEST_F(CommandLine, DescribesASceneInJson) {
  const Outcome o = expect_done({"info", kCube, "--json"});
  EXPECT_EQ(o.err, "");
  const json info = json::parse(o.out);
  EXPECT_EQ(keys_of(info), sorted({"hidden_nodes",
                                   "scenes",
                                   "nodes",
                                   "meshes",
                                   "instances",
                                   "triangles_in",
                                   "triangles",
                                   "instanced_triangles",
                                   "vertices",
                                   "dropped",
                                   "split_vertices",
                                   "boundary_edges",
                                   "non_manifold_edges",
                                   "joined",
                                   "gaps_joined",
                                   "nearest_gap_m",
                                   "node_seams",
                                   "extent_m",
                                   "bounding_box",
                                   "contours",
                                   "animations",
                                   "pose",
                                   "effects",
                                   "load_ms",
                                   "memory_bytes",
                                   "memory",
                                   "indices",
                                   "scale",
                                   "notes",
                                   "materials",
                                   "scene_parameters",
                                   "regions",
                                   "warnings"}));
  EXPECT_EQ(keys_of(info["dropped"]), sorted({"degenerate", "duplicate"}));
  EXPECT_EQ(keys_of(info["load_ms"]), sorted({"parse", "mesh", "index"}));
  EXPECT_EQ(info["triangles_in"], 12);
  EXPECT_EQ(info["triangles"], 12);
  EXPECT_EQ(info["vertices"], 8);
  EXPECT_EQ(info["boundary_edges"], 0);
  ASSERT_EQ(info["materials"].size(), 1u);
  EXPECT_EQ(info["materials"][0]["name"], "solid");
  EXPECT_EQ(info["materials"][0]["parameters"], json::object());
  EXPECT_EQ(info["materials"][0]["effects"], json::array());
  EXPECT_EQ(info["regions"], json::array());
  EXPECT_EQ(info["effects"], json::array());
  EXPECT_EQ(info["warnings"], json::array());
  EXPECT_EQ(info["extent_m"].size(), 3u);
  for (const json& extent : info["extent_m"]) EXPECT_EQ(extent, info["extent_m"][0]);
  EXPECT_GT(info["memory_bytes"], 1000);
  EXPECT_EQ(keys_of(info["memory"]), sorted({"adjacency", "positions", "maps", "index_triangles",
                                             "index_packs", "index_boxes", "places", "effects"}));
  std::size_t sum = 0;
  for (const json& part : info["memory"]) sum += part.get<std::size_t>();
  EXPECT_EQ(info["memory_bytes"], sum);
}

TEST_F(CommandLine, CountsTheTrianglesOfEveryNode) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.add_node({{"mesh", 0}, {"translation", {5, 0, 0}}});
  gltf.add_node({{"mesh", 0}, {"scale", {0, 0, 0}}, {"name", "vanished"}});
  const json info = json::parse(expect_done({"info", gltf.write_glb(folder), "--json"}).out);
  EXPECT_EQ(info["nodes"], 3);
  EXPECT_EQ(info["meshes"], 1);
  EXPECT_EQ(info["instances"], 2);
  EXPECT_EQ(info["triangles"], 1);
  EXPECT_EQ(info["instanced_triangles"], 2);
  ASSERT_EQ(info["warnings"].size(), 1u);
  EXPECT_NE(info["warnings"][0].get<std::string>().find("vanished"), std::string::npos);
}

TEST_F(CommandLine, DescribesASceneAsText) {
  const Outcome o = expect_done({"info", kStar});
  EXPECT_NE(o.out.find("36 of 36"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("extent"), std::string::npos);
}

}  // namespace
}  // namespace palpate
