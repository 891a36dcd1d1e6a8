// Sweeps that are broken in one place each: the error names this place, and nothing is written.

#include <algorithm>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/paper_plan.h"
#include "engine/trials/sweep/sweep_points.h"
#include "engine/trials/sweep/sweep_run.h"
#include "tests/engine/cli/run_program.h"
#include "tests/engine/trials/sweep/small_sweep.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::small_sweep_json;
using test::TemporaryFolder;

// A change that breaks a sweep, and the element and a part of the problem that the error must name.
struct BrokenSweep {
  std::string name;
  std::function<void(Json&)> change;
  std::string element;
  std::string problem;
};

const std::vector<BrokenSweep>& broken_sweeps() {
  static const std::vector<BrokenSweep> all = {
      {"no object", [](Json& j) { j = Json::array(); }, "JSON", "expected an object"},
      {"format", [](Json& j) { j["palpate_sweep"] = 2; }, "/palpate_sweep", "is 2; expected 1"},
      {"a plan in place of a sweep", [](Json& j) { j = j["plan"]; }, "/palpate_plan",
       "is the key of a plan; expected palpate_sweep"},
      {"unknown key", [](Json& j) { j["hyper"] = 1; }, "/hyper",
       "expected palpate_sweep, name, plan, parameters or hypercube"},
      {"no name", [](Json& j) { j.erase("name"); }, "/name", "is missing"},
      {"no plan", [](Json& j) { j.erase("plan"); }, "/plan", "is missing"},
      {"a path as plan", [](Json& j) { j["plan"] = "plan.json"; }, "/plan",
       "is \"plan.json\"; expected an object"},
      {"broken plan", [](Json& j) { j["plan"]["participants"] = 0; }, "/plan/participants", "is 0"},
      {"unknown key of the plan", [](Json& j) { j["plan"]["sweep"] = 1; }, "/plan/sweep",
       "not a known key"},
      {"broken device", [](Json& j) { j["plan"]["device"]["sensors"] = 3; }, "/plan/device/sensors",
       "is 3; expected 2"},
      {"a level of haptic is missing",
       [](Json& j) {
         j["plan"]["haptic"] = {"NoH", "H"};
       },
       "/plan/haptic", "lacks a level; expected NoH, UaH and H"},
      {"a level of rotation is missing", [](Json& j) { j["plan"]["rotation"] = {"R"}; },
       "/plan/rotation", "lacks a level"},
      {"strategies",
       [](Json& j) {
         j["plan"].erase("haptic");
         j["plan"].erase("rotation");
         j["plan"]["strategies"] = {"a4"};
       },
       "/plan/strategies", "is present; expected haptic and rotation"},
      {"practice", [](Json& j) { j["plan"]["practice_blocks"] = 1; }, "/plan/practice_blocks",
       "is 1; expected 0"},
      {"two followings",
       [](Json& j) {
         j["plan"]["followings"] = {"delayed", "replan"};
       },
       "/plan/followings", "is a list of 2; expected one level"},
      {"two starts",
       [](Json& j) {
         j["plan"]["start_orientation_deg"] = {0, 45};
       },
       "/plan/start_orientation_deg", "is a list of 2"},
      {"two scales",
       [](Json& j) {
         j["plan"]["scale"] = {1, 2};
       },
       "/plan/scale", "is a list of 2"},
      {"the view still", [](Json& j) { j["plan"]["view"] = {"still"}; }, "/plan/view",
       "expected it alone"},
      {"the view still, which has no followings",
       [](Json& j) {
         j["plan"]["view"] = {"still"};
         j["plan"].erase("followings");
       },
       "/plan/view", "expected it alone"},
      {"parameters in a list", [](Json& j) { j["parameters"] = Json::array(); }, "/parameters",
       "expected an object"},
      {"no parameter", [](Json& j) { j["parameters"] = Json::object(); }, "/parameters",
       "has no parameter"},
      {"unknown parameter",
       [](Json& j) {
         j["parameters"]["tau"] = {0.1, 0.2};
       },
       "/parameters/tau", "is not a known key; expected sight_delay_s"},
      {"a parameter of the hand that no sweep varies",
       [](Json& j) {
         j["parameters"]["gain_per_s"] = {1, 2};
       },
       "/parameters/gain_per_s", "not a known key"},
      {"a number as levels", [](Json& j) { j["parameters"]["scale"] = 1; }, "/parameters/scale",
       "is 1; expected a list of 2 to 100 levels"},
      {"one level", [](Json& j) { j["parameters"]["scale"] = {1}; }, "/parameters/scale",
       "is a list of 1; expected a list of 2 to 100 levels"},
      {"too many levels", [](Json& j) { j["parameters"]["scale"] = std::vector<double>(101, 1.0); },
       "/parameters/scale", "is a list of 101"},
      {"a level twice",
       [](Json& j) {
         j["parameters"]["scale"] = {1, 0.5, 1.0};
       },
       "/parameters/scale/2", "is 1 again"},
      {"a word twice",
       [](Json& j) {
         j["parameters"]["following"] = {"delayed", "delayed"};
       },
       "/parameters/following/1", "is delayed again"},
      {"a word as number",
       [](Json& j) {
         j["parameters"]["scale"] = {1, "big"};
       },
       "/parameters/scale/1", "is \"big\"; expected a number above 0"},
      {"a number as word",
       [](Json& j) {
         j["parameters"]["align"] = {"nearest", 1};
       },
       "/parameters/align/1", "is 1; expected nearest or forward"},
      {"unknown word",
       [](Json& j) {
         j["parameters"]["following"] = {"delayed", "adapts-1"};
       },
       "/parameters/following/1", "expected delayed, predict, replan or frozen"},
      {"a level of 0",
       [](Json& j) {
         j["parameters"]["sight_delay_s"] = {0, 0.1};
       },
       "/parameters/sight_delay_s/0", "is 0; expected a number above 0"},
      {"a negative level",
       [](Json& j) {
         j["parameters"]["force_noise"] = {-0.1, 0.1};
       },
       "/parameters/force_noise/0", "is -0.1"},
      {"a level beyond any hand",
       [](Json& j) {
         j["parameters"]["press_depth_m"] = {0.01, 8};
       },
       "/parameters/press_depth_m/1", "at most 1"},
      {"a turn beyond a circle",
       [](Json& j) {
         j["parameters"]["start_orientation_deg"] = {0, 361};
       },
       "/parameters/start_orientation_deg/1", "is 361"},
      {"an unstable hand",
       [](Json& j) {
         j["parameters"]["sight_delay_s"] = {0.1, 5};
       },
       "/parameters/sight_delay_s", "expected less than pi/2"},
      {"no hypercube", [](Json& j) { j.erase("hypercube"); }, "/hypercube", "is missing"},
      {"one point", [](Json& j) { j["hypercube"]["points"] = 1; }, "/hypercube/points",
       "is 1; expected a whole number from 2"},
      {"a negative seed", [](Json& j) { j["hypercube"]["seed"] = -1; }, "/hypercube/seed", "is -1"},
      {"no participants", [](Json& j) { j["hypercube"].erase("participants"); },
       "/hypercube/participants", "is missing"},
      {"ranges of the hypercube", [](Json& j) { j["hypercube"]["ranges"] = Json::object(); },
       "/hypercube/ranges", "not a known key"},
      {"too many points", [](Json& j) { j["hypercube"]["points"] = 9990; }, "/hypercube/points",
       "gives a sweep of 10009 points with those of /parameters; expected at most 10000"},
      {"too many trials", [](Json& j) { j["hypercube"]["participants"] = 10000; }, "/hypercube",
       "trials with those of /parameters; expected at most 262144"},
  };
  return all;
}

TEST(BrokenSweep, IsRefusedByItsElement) {
  std::set<std::string> names;
  for (const BrokenSweep& broken : broken_sweeps()) {
    SCOPED_TRACE(broken.name);
    EXPECT_TRUE(names.insert(broken.name).second);
    Json json = small_sweep_json();
    broken.change(json);
    const auto sweep = parse_sweep(json.dump(), "sweep.json", PALPATE_MODELS_DIR);
    ASSERT_FALSE(sweep.ok());
    const std::string line = sweep.error().to_string();
    EXPECT_EQ(sweep.error().path, "sweep.json") << line;
    EXPECT_EQ(sweep.error().element, broken.element) << line;
    EXPECT_NE(sweep.error().problem.find(broken.problem), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
  EXPECT_GE(names.size(), 20u);
}

// Found when the scenes are loaded, before the first trial.
TEST(BrokenSweep, IsRefusedBeforeTheFirstTrialIfAPointCannotRun) {
  const std::vector<BrokenSweep> all = {
      {"too large",
       [](Json& j) {
         j["parameters"]["scale"] = {1, 3};
       },
       "/parameters/scale", "(with scale 3)"},
      {"unstable device", [](Json& j) { j["plan"]["device"]["device_damping_Ns_per_m"] = 1e6; },
       "/plan/device/device_damping_Ns_per_m", "unstable"},
      {"too stiff",
       [](Json& j) {
         j["parameters"] = {{"stiffness_N_per_m", {1000, 1e300}}};
       },
       "/parameters/stiffness_N_per_m/1", "is 1e+300"},
      {"two motors", [](Json& j) { j["plan"]["device"]["actuators"] = 2; }, "/parameters/align",
       "(with align forward)"},
  };
  for (const BrokenSweep& broken : all) {
    SCOPED_TRACE(broken.name);
    Json json = small_sweep_json();
    broken.change(json);
    const TemporaryFolder folder;
    TrialFunctions never = test::sweep_stand_in();
    never.run = [](auto&&...) -> Result<TrialOutcome> {
      return invalid_argument("trial", "a trial ran");
    };
    const auto sweep = parse_sweep(json.dump(), "sweep.json", PALPATE_MODELS_DIR);
    const auto outcome = sweep ? run_sweep(*sweep, {folder.path("out"), {}, 1}, never)
                               : Result<SweepOutcome>(sweep.error());
    ASSERT_FALSE(outcome.ok());
    const std::string line = outcome.error().to_string();
    EXPECT_EQ(outcome.error().path, "sweep.json") << line;
    EXPECT_EQ(outcome.error().element, broken.element) << line;
    EXPECT_NE(line.find(broken.problem), std::string::npos) << line;
    EXPECT_EQ(line.find("Settings::"), std::string::npos) << line;
    EXPECT_FALSE(fs::exists(folder.path("out")));
  }
}

class SweepCommandTest : public testing::Test {
 protected:
  // Code 2, nothing on stdout, one line on stderr with all of `parts`, and no result.
  void expect_refused(const std::vector<std::string>& more,
                      const std::vector<std::string>& parts) const {
    std::vector<std::string> arguments{"experiment", "sweep"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const test::Outcome o = run_program(folder, arguments);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_TRUE(o.err.starts_with("palpate: ")) << o.err;
    for (const std::string& part : parts) EXPECT_NE(o.err.find(part), std::string::npos) << o.err;
    EXPECT_FALSE(fs::exists(folder.path("sweep")));
  }

  TemporaryFolder folder;
};

TEST_F(SweepCommandTest, RefusesBrokenSweepsInOneLine) {
  for (const BrokenSweep& broken : broken_sweeps()) {
    SCOPED_TRACE(broken.name);
    Json json = small_sweep_json();
    json["plan"]["objects"]["O1"] = PALPATE_MODELS_DIR "/star.glb";
    broken.change(json);
    folder.write("sweep.json", json.dump());
    expect_refused({"sweep.json"}, {"sweep.json: " + broken.element + ": "});
  }
}

TEST_F(SweepCommandTest, RefusesFilesAndOptions) {
  expect_refused({"missing.json"}, {"missing.json", "cannot be opened"});
  folder.write("sweep.json", "{\"palpate_sweep\": 1,");
  expect_refused({"sweep.json"}, {"sweep.json"});
  Json json = small_sweep_json();
  json["plan"]["objects"]["O1"] = "missing.glb";
  folder.write("sweep.json", json.dump());
  expect_refused({"sweep.json"}, {"missing.glb", "cannot be opened"});
  expect_refused({"sweep.json", "--shard", "0/2"}, {"--shard"});
  expect_refused({"sweep.json", "--jobs", "0"}, {"--jobs"});
  expect_refused({"sweep.json", "--traces"}, {"--traces"});
}

// Each command names the other one.
TEST_F(SweepCommandTest, APlanAndASweepNameTheCommandThatRunsThem) {
  Json json = small_sweep_json();
  json["plan"]["objects"]["O1"] = PALPATE_MODELS_DIR "/star.glb";
  folder.write("plan.json", json["plan"].dump());
  folder.write("sweep.json", json.dump());
  expect_refused({"plan.json"}, {"`palpate experiment run` runs a plan"});
  const test::Outcome o = run_program(folder, {"experiment", "run", "sweep.json"});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_NE(o.err.find("`palpate experiment sweep` runs a sweep"), std::string::npos) << o.err;
  fs::create_directory(folder.path("empty"));
  const test::Outcome merge = run_program(folder, {"experiment", "merge", "empty"});
  EXPECT_EQ(merge.exit_code, 2);
  EXPECT_NE(merge.err.find("`experiment sweep --out`"), std::string::npos) << merge.err;
}

TEST_F(SweepCommandTest, BeginsItsHelpWithAnExample) {
  const test::Outcome o = run_program(folder, {"experiment", "sweep", "--help"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_TRUE(o.out.starts_with("Example:\n  ./run.sh experiment plan sweep --out sweep.json"))
      << o.out;
}

TEST_F(SweepCommandTest, WritesTheSweepThatShips) {
  const test::Outcome o = run_program(folder, {"experiment", "plan", "sweep"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(o.out, "sweep.json\nrun it: palpate experiment sweep sweep.json\n");
  const auto sweep = load_sweep(folder.path("sweep.json"));
  ASSERT_TRUE(sweep.ok()) << sweep.error().to_string();
  const auto shipped = parse_sweep(shipped_sweep_text(""), "sweep", PALPATE_MODELS_DIR);
  ASSERT_TRUE(shipped.ok()) << shipped.error().to_string();
  EXPECT_EQ(sweep->hash, shipped->hash);
  EXPECT_EQ(sweep->parameters.size(), kSweepParameterCount);
}

}  // namespace
}  // namespace palpate
