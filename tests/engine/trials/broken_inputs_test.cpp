// Plans, operator files and tables of trials that are broken in one place each: the error names
// this place.

#include <array>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/operator_file.h"
#include "engine/trials/paper_plan.h"
#include "engine/trials/plan.h"
#include "engine/trials/trials_file.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// A change that breaks a file, and the element and a part of the problem that the error must name.
struct Breakage {
  std::string name;
  std::function<void(Json&)> change;
  std::string element;
  std::string problem;
};

std::string to_text(const Json& json) {
  return json.dump(2);
}

void expect_error(const Error& error, const std::string& element, const std::string& problem,
                  const std::string& path) {
  const std::string line = error.to_string();
  EXPECT_EQ(error.path, path) << line;
  EXPECT_EQ(error.element, element) << line;
  EXPECT_NE(error.problem.find(problem), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos);
}

Json paper() {
  return Json::parse(shipped_plan_text(kPaperPlan, ""));
}

// Puts strategies in place of haptic and rotation.
void set_strategies(Json& plan, const Json& strategies) {
  plan.erase("haptic");
  plan.erase("rotation");
  plan["strategies"] = strategies;
}

const std::vector<Breakage>& broken_plans() {
  static const std::vector<Breakage> all = {
      {"no object", [](Json& j) { j = Json::array(); }, "JSON", "expected an object"},
      {"unknown key", [](Json& j) { j["partcipants"] = 3; }, "/partcipants", "not a known key"},
      {"misspelt key",
       [](Json& j) {
         j.erase("participants");
         j["Participants"] = 10;
       },
       "/Participants", "expected palpate_plan, name, seed"},
      {"missing key", [](Json& j) { j.erase("limit_s"); }, "/limit_s", "is missing"},
      {"format", [](Json& j) { j["palpate_plan"] = 2; }, "/palpate_plan", "is 2; expected 1"},
      {"no format", [](Json& j) { j.erase("palpate_plan"); }, "/palpate_plan", "is missing"},
      {"strategies beside haptic", [](Json& j) { j["strategies"] = {"mask"}; }, "/strategies",
       "is used together with haptic; expected strategies, or haptic and rotation"},
      {"strategies beside rotation",
       [](Json& j) {
         j.erase("haptic");
         j["strategies"] = {"mask"};
       },
       "/strategies", "is used together with rotation"},
      {"strategies in no list", [](Json& j) { set_strategies(j, "mask"); }, "/strategies",
       "is \"mask\"; expected a list of 1 to 100 strategies"},
      {"no strategy", [](Json& j) { set_strategies(j, Json::array()); }, "/strategies",
       "is a list of 0"},
      {"too many strategies",
       [](Json& j) { set_strategies(j, std::vector<std::string>(101, "mask")); }, "/strategies",
       "is a list of 101"},
      {"a number among the strategies",
       [](Json& j) {
         set_strategies(j, {"mask", 4});
       },
       "/strategies/1", "is 4"},
      {"unknown strategy",
       [](Json& j) {
         set_strategies(j, {"mask", "a5"});
       },
       "/strategies/1", "is \"a5\"; expected one of none, mask, full, a4"},
      {"a strategy without its number", [](Json& j) { set_strategies(j, {"anisotropic"}); },
       "/strategies/0", "is \"anisotropic\""},
      {"repeated strategy",
       [](Json& j) {
         set_strategies(j, {"a4", "mask", "a4"});
       },
       "/strategies/2", "is a4 again"},
      {"align is no word", [](Json& j) { j["align"] = "backward"; }, "/align",
       "is \"backward\"; expected nearest or forward"},
      {"align is a list", [](Json& j) { j["align"] = {"forward"}; }, "/align", "expected"},
      {"forward with two motors",
       [](Json& j) {
         j["align"] = "forward";
         j["device"]["actuators"] = 2;
       },
       "/align", "is forward, which is for one motor, but the device has 2"},
      {"forward without a motor",
       [](Json& j) {
         j["align"] = "forward";
         j["device"]["actuators"] = 0;
       },
       "/align", "is for one motor, but the device has 0"},
      {"forward with the printed table",
       [](Json& j) {
         j["align"] = "forward";
         j["device"]["table1"] = "printed";
       },
       "/align", "is forward together with table1 printed"},
      {"align in the device", [](Json& j) { j["device"]["align"] = "forward"; }, "/device/align",
       "not a known key"},
      {"view is a word", [](Json& j) { j["view"] = "still"; }, "/view", "expected a list"},
      {"no view", [](Json& j) { j["view"] = Json::array(); }, "/view", ""},
      {"unknown view",
       [](Json& j) {
         j["view"] = {"turning", "frozen"};
       },
       "/view/1", "turning or still"},
      {"repeated view",
       [](Json& j) {
         j["view"] = {"still", "still"};
       },
       "/view/1", ""},
      {"an adaptation as a following", [](Json& j) { j["followings"] = {"adapts-1"}; },
       "/followings/0", "delayed, predict, replan or frozen"},
      {"start orientation is a number", [](Json& j) { j["start_orientation_deg"] = 45; },
       "/start_orientation_deg", "is 45; expected a list"},
      {"no start orientation", [](Json& j) { j["start_orientation_deg"] = Json::array(); },
       "/start_orientation_deg", "is a list of 0"},
      {"start orientation beyond a turn",
       [](Json& j) {
         j["start_orientation_deg"] = {0, 361};
       },
       "/start_orientation_deg/1", "is 361; expected a number from -360 to 360"},
      {"start orientation is a text", [](Json& j) { j["start_orientation_deg"] = {"45"}; },
       "/start_orientation_deg/0", "is \"45\""},
      {"repeated start orientation",
       [](Json& j) {
         j["start_orientation_deg"] = {45, 0, 45.0};
       },
       "/start_orientation_deg/2", "again"},
      {"scale 0", [](Json& j) { j["scale"] = {0}; }, "/scale/0", "above 0"},
      {"negative scale",
       [](Json& j) {
         j["scale"] = {1, -1};
       },
       "/scale/1", "above 0"},
      {"repeated scale",
       [](Json& j) {
         j["scale"] = {1, 1.0};
       },
       "/scale/1", "again"},
      {"too many scales", [](Json& j) { j["scale"] = std::vector<double>(101, 1.0); }, "/scale",
       "is a list of 101; expected a list of 1 to 100 numbers"},
      {"unknown order", [](Json& j) { j["order"] = "latin"; }, "/order", "random or williams"},
      {"williams with three conditions",
       [](Json& j) {
         j["order"] = "williams";
         j["rotation"] = {"R"};
       },
       "/order", "has 3 conditions without their objects; expected an even number"},
      {"negative learning", [](Json& j) { j["learning_exponent"] = -0.1; }, "/learning_exponent",
       "from 0 to 1"},
      {"learning is a list", [](Json& j) { j["learning_exponent"] = {0.3}; }, "/learning_exponent",
       "expected a number"},
      {"variants make too many trials",
       [](Json& j) {
         std::vector<int> starts(100);
         std::iota(starts.begin(), starts.end(), 0);
         j["start_orientation_deg"] = starts;
       },
       "/participants", "gives a plan of 384000 trials"},
      {"name is a number", [](Json& j) { j["name"] = 1; }, "/name", "expected a text"},
      {"name is empty", [](Json& j) { j["name"] = ""; }, "/name", "expected a text"},
      {"name has a control character", [](Json& j) { j["name"] = "a\x1b[2J"; }, "/name",
       "without control characters"},
      {"name is long", [](Json& j) { j["name"] = std::string(101, 'x'); }, "/name", "1 to 100"},
      {"seed is negative", [](Json& j) { j["seed"] = -1; }, "/seed", "is -1"},
      {"seed is a fraction", [](Json& j) { j["seed"] = 0.5; }, "/seed", "a whole number"},
      {"seed is too large", [](Json& j) { j["seed"] = 9007199254740992u; }, "/seed",
       "a whole number"},
      {"no participants", [](Json& j) { j["participants"] = 0; }, "/participants", "is 0"},
      {"participants is a text", [](Json& j) { j["participants"] = "10"; }, "/participants",
       "is \"10\""},
      {"too many participants", [](Json& j) { j["participants"] = 10001; }, "/participants",
       "10000"},
      {"too many trials", [](Json& j) { j["participants"] = 10000; }, "/participants", "trials"},
      {"no blocks", [](Json& j) { j["blocks"] = 0; }, "/blocks", "from 1"},
      {"two practice blocks", [](Json& j) { j["practice_blocks"] = 2; }, "/practice_blocks",
       "from 0 to 1"},
      {"device is a list", [](Json& j) { j["device"] = Json::array(); }, "/device",
       "expected an object"},
      {"three sensors", [](Json& j) { j["device"]["sensors"] = 3; }, "/device/sensors",
       "is 3; expected 2"},
      {"one sensor", [](Json& j) { j["device"]["sensors"] = 1; }, "/device/sensors", "expected 2"},
      {"three actuators", [](Json& j) { j["device"]["actuators"] = 3; }, "/device/actuators",
       "is 3"},
      {"no actuators", [](Json& j) { j["device"].erase("actuators"); }, "/device/actuators",
       "is missing"},
      {"axes that contradict",
       [](Json& j) { j["device"]["actuated_axes"] = Json::parse("[[1,0,0],[0,1,0]]"); },
       "/device/actuators", "the number of actuated_axes is 2"},
      {"an axis of length 0",
       [](Json& j) {
         j["device"].erase("actuators");
         j["device"]["actuated_axes"] = Json::parse("[[0,0,0]]");
       },
       "/device/actuated_axes", ""},
      {"an axis with two numbers",
       [](Json& j) { j["device"]["actuated_axes"] = Json::parse("[[1,0,0],[1,0]]"); },
       "/device/actuated_axes/1", "three numbers"},
      {"an axis of texts",
       [](Json& j) { j["device"]["actuated_axes"] = Json::parse(R"([["1",0,0]])"); },
       "/device/actuated_axes/0", "three numbers"},
      {"three axes",
       [](Json& j) { j["device"]["actuated_axes"] = Json::parse("[[1,0,0],[0,1,0],[0,0,1]]"); },
       "/device/actuated_axes", "is a list of 3; expected a list of one or two"},
      {"axes in no list", [](Json& j) { j["device"]["actuated_axes"] = nullptr; },
       "/device/actuated_axes", "is null; expected a list"},
      {"no rate", [](Json& j) { j["device"].erase("rate_Hz"); }, "/device/rate_Hz", "is missing"},
      {"rate 0", [](Json& j) { j["device"]["rate_Hz"] = 0; }, "/device/rate_Hz", "above 0"},
      {"rate too low", [](Json& j) { j["device"]["rate_Hz"] = 0.5; }, "/device/rate_Hz",
       "expected at least"},
      {"negative stiffness", [](Json& j) { j["device"]["stiffness_N_per_m"] = -1; },
       "/device/stiffness_N_per_m", "is -1"},
      {"no damping", [](Json& j) { j["device"].erase("damping_Ns_per_m"); },
       "/device/damping_Ns_per_m", "is missing"},
      {"force in the device", [](Json& j) { j["device"]["force"] = "full"; }, "/device/force",
       "not a known key"},
      {"option in place of the key", [](Json& j) { j["device"]["rate"] = 1000; }, "/device/rate",
       "rate_Hz"},
      {"accuracy", [](Json& j) { j["device"]["accuracy"] = "best"; }, "/device/accuracy",
       "fast, balanced or exact"},
      {"work budget", [](Json& j) { j["device"]["work_budget"] = 0; }, "/device/work_budget",
       "from 1"},
      {"table", [](Json& j) { j["device"]["table1"] = 1; }, "/device/table1",
       "corrected or printed"},
      {"step", [](Json& j) { j["device"]["a4_step"] = "Euler"; }, "/device/a4_step",
       "exact or paper"},
      {"estimator", [](Json& j) { j["device"]["velocity_estimator"] = "kalman"; },
       "/device/velocity_estimator", "difference, line or adaptive"},
      {"adaptive without quantum", [](Json& j) { j["device"]["velocity_estimator"] = "adaptive"; },
       "/device/velocity_estimator", "requires encoder_quantum_m"},
      {"window", [](Json& j) { j["device"]["velocity_window_ticks"] = 64; },
       "/device/velocity_window_ticks", "from 1 to 63"},
      {"quantum", [](Json& j) { j["device"]["encoder_quantum_m"] = 0; },
       "/device/encoder_quantum_m", "above 0"},
      {"radius", [](Json& j) { j["device"]["radius_m"] = -0.001; }, "/device/radius_m",
       "at least 0"},
      {"place of six numbers", [](Json& j) { j["device"]["place"] = Json::parse("[0,0,0,1,0,0]"); },
       "/device/place", "a list of 6; expected a list of 7"},
      {"place with a text",
       [](Json& j) { j["device"]["place"] = Json::parse(R"([0,0,0,1,0,0,"0"])"); },
       "/device/place/6", "is \"0\"; expected a number"},
      {"place is a text", [](Json& j) { j["device"]["place"] = "0 0 0 1 0 0 0"; }, "/device/place",
       "expected a list of 7 numbers"},
      {"place without rotation",
       [](Json& j) { j["device"]["place"] = Json::parse("[0,0,0,0,0,0,0]"); }, "/device/place",
       "length"},
      {"mass", [](Json& j) { j["device"]["device_mass_kg"] = 0; }, "/device/device_mass_kg",
       "above 0"},
      {"display", [](Json& j) { j["display_Hz"] = 0; }, "/display_Hz", "above 0"},
      {"display faster than the device", [](Json& j) { j["display_Hz"] = 2000; }, "/display_Hz",
       "the rate of the device"},
      {"display faster than any",
       [](Json& j) {
         j["device"]["rate_Hz"] = 3e4;
         j["display_Hz"] = 1.1e4;
       },
       "/display_Hz", "at most 10000"},
      {"display slower than a trial", [](Json& j) { j["display_Hz"] = 0.008; }, "/display_Hz",
       "is 0.008; expected at least 0.00833333 Hz"},
      {"spheres", [](Json& j) { j["sphere_radius_m"] = 2; }, "/sphere_radius_m", "at most 1"},
      {"limit", [](Json& j) { j["limit_s"] = 1e9; }, "/limit_s", "at most 3600"},
      {"limit below a tick", [](Json& j) { j["limit_s"] = 9e-4; }, "/limit_s",
       "0.9 ticks at the rate of the device, 1000 Hz; expected 1 to 4e+06"},
      {"too many ticks", [](Json& j) { j["device"]["rate_Hz"] = 1e9; }, "/limit_s",
       "or 1.2e+11 ticks"},
      {"more ticks than a whole number", [](Json& j) { j["device"]["rate_Hz"] = 1e300; },
       "/limit_s", "or 1.2e+302 ticks"},
      {"limit is null", [](Json& j) { j["limit_s"] = nullptr; }, "/limit_s", "is null"},
      {"no haptic level", [](Json& j) { j["haptic"] = Json::array(); }, "/haptic", "is empty"},
      {"unknown haptic level", [](Json& j) { j["haptic"][1] = "UAH"; }, "/haptic/1",
       "NoH, UaH, H, seen-UaH or seen-H"},
      {"haptic level twice", [](Json& j) { j["haptic"][2] = "NoH"; }, "/haptic/2", "repeats"},
      {"haptic is a text", [](Json& j) { j["haptic"] = "H"; }, "/haptic", "a list"},
      {"unknown rotation", [](Json& j) { j["rotation"] = Json::parse("[true]"); }, "/rotation/0",
       "NoR or R"},
      {"no followings", [](Json& j) { j["followings"] = Json::array(); }, "/followings",
       "is empty"},
      {"unknown following", [](Json& j) { j["followings"][0] = "lazy"; }, "/followings/0",
       "delayed, predict, replan or frozen"},
      {"no objects", [](Json& j) { j["objects"] = Json::object(); }, "/objects", "0 entries"},
      {"objects are a list", [](Json& j) { j["objects"] = Json::parse("[\"star.glb\"]"); },
       "/objects", ""},
      {"object is a number", [](Json& j) { j["objects"]["O2"] = 2; }, "/objects/O2",
       "expected an object"},
      {"object without file",
       [](Json& j) {
         j["objects"]["O2"] = {{"scale", 1}};
       },
       "/objects/O2/file", "is missing"},
      {"object with an unknown key",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"size", 1}};
       },
       "/objects/O2/size", "not a known key"},
      {"object with two sizes",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"scale", 1}, {"fit_size_m", 0.1}};
       },
       "/objects/O2", "both"},
      {"object of size 0",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"scale", 0}};
       },
       "/objects/O2/scale", "above 0"},
      {"object whose gaps have no width",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"close_gaps_m", 0}};
       },
       "/objects/O2/close_gaps_m", "above 0"},
      {"object with the scene -1",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"scene", -1}};
       },
       "/objects/O2/scene", "whole number"},
      {"object whose scene is a list",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"scene", {1}}};
       },
       "/objects/O2/scene", "text"},
      {"object whose scene is true",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"scene", true}};
       },
       "/objects/O2/scene", "the number of a scene of the file, or its name as a text"},
      {"object with a misspelt key beside its scene",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"scene", 1}, {"nodes", "b"}};
       },
       "/objects/O2/nodes", "expected file, node, scene, feel_hidden"},
      {"object that feels hidden nodes by number",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"feel_hidden", 2}};
       },
       "/objects/O2/feel_hidden", "true or false"},
      {"object whose gaps are a text",
       [](Json& j) {
         j["objects"]["O2"] = {{"file", "a.glb"}, {"close_gaps_m", "auto"}};
       },
       "/objects/O2/close_gaps_m", "number"},
      {"name of an object that is a path", [](Json& j) { j["objects"]["../O"] = "star.glb"; },
       "/objects", "letters, digits"},
      {"unknown operator", [](Json& j) { j["operator"] = "people2006"; }, "/operator",
       "literature, people2005 or the path"},
      {"operator is a number", [](Json& j) { j["operator"] = 1; }, "/operator", "expected a text"},
  };
  return all;
}

// The plan is refused once each of them has changed it.
void expect_refused(const Json& plan, const std::vector<Breakage>& breakages) {
  for (const Breakage& breakage : breakages) {
    SCOPED_TRACE(breakage.name);
    Json json = plan;
    breakage.change(json);
    const auto broken = parse_plan(to_text(json), "plan.json", "");
    ASSERT_FALSE(broken.ok());
    expect_error(broken.error(), breakage.element, breakage.problem, "plan.json");
  }
}

TEST(BrokenInputs, APlanIsRefusedByTheNameOfItsElement) {
  expect_refused(paper(), broken_plans());
  EXPECT_GE(broken_plans().size(), 60u);
}

// A plan with a mouse and a force that is seen.
Json seen() {
  Json json = Json::parse(shipped_plan_text("paper-live-mouse", ""));
  json["haptic"] = {"NoH", "seen-UaH", "seen-H"};
  json["live"]["force"] = "seen";
  json["live"]["grip"] = {
      {"stiffness_N_per_m", 135}, {"damping_Ns_per_m", 6.45}, {"mass_kg", 0.55}};
  return json;
}

TEST(BrokenInputs, ASeenForceIsRefusedByTheNameOfItsElement) {
  const auto plan = parse_plan(to_text(seen()), "plan.json", "");
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  ASSERT_TRUE(plan->live->grip);
  EXPECT_EQ(plan->live->grip->stiffness_N_per_m, 135.0);
  EXPECT_EQ(plan->live->grip->damping_Ns_per_m, 6.45);
  EXPECT_EQ(plan->live->grip->mass_kg, 0.55);
  const std::vector<Breakage> breakages = {
      {"H with a mouse",
       [](Json& j) {
         j["haptic"] = {"NoH", "seen-H", "H"};
       },
       "/haptic/2",
       "is H, which a mouse, pen or finger cannot render; expected NoH, seen-UaH or seen-H"},
      {"UaH with a mouse",
       [](Json& j) {
         j["haptic"] = {"UaH", "seen-UaH"};
       },
       "/haptic/0", "is UaH, which a mouse"},
      {"nothing that is seen", [](Json& j) { j["haptic"] = {"NoH"}; }, "/haptic",
       "has no seen level; expected seen-UaH or seen-H"},
      {"no force",
       [](Json& j) {
         j["live"].erase("force");
         j["live"].erase("grip");
       },
       "/haptic/1", "is seen-UaH, which needs \"force\": \"seen\" in /live; expected NoH"},
      {"no live", [](Json& j) { j.erase("live"); }, "/haptic/1",
       "is seen-UaH, which needs \"force\": \"seen\" in /live; expected NoH, UaH or H"},
      {"a board", [](Json& j) { j["live"]["input"] = "board"; }, "/live/force",
       "is seen, but the input is board"},
      {"a seen level with a board",
       [](Json& j) {
         j["live"].erase("force");
         j["live"].erase("grip");
         j["live"].erase("clutch");  // of a pointer
         j["live"]["input"] = "board";
       },
       "/haptic/1", "is seen-UaH, which needs \"force\": \"seen\" in /live"},
      {"another force", [](Json& j) { j["live"]["force"] = "felt"; }, "/live/force",
       "is \"felt\"; expected seen"},
      {"no grip", [](Json& j) { j["live"].erase("grip"); }, "/live/grip", "is missing"},
      {"a grip without force", [](Json& j) { j["live"].erase("force"); }, "/live/grip",
       "is of a plan with \"force\": \"seen\""},
      {"no mass", [](Json& j) { j["live"]["grip"].erase("mass_kg"); }, "/live/grip/mass_kg",
       "is missing"},
      {"no stiffness", [](Json& j) { j["live"]["grip"]["stiffness_N_per_m"] = 0; },
       "/live/grip/stiffness_N_per_m", "above 0"},
      {"unknown key", [](Json& j) { j["live"]["grip"]["friction"] = 1; }, "/live/grip/friction",
       "not a known key"},
  };
  expect_refused(seen(), breakages);
}

TEST(BrokenInputs, SimulatedPersonsSeeNoForce) {
  const auto plan = parse_plan(to_text(seen()), "plan.json", "");
  ASSERT_TRUE(plan.ok());
  const auto refused = check_simulable(*plan);
  ASSERT_TRUE(refused);
  expect_error(*refused, "/live/force", "is seen, which only people see", "plan.json");
  EXPECT_FALSE(check_simulable(*parse_plan(to_text(paper()), "plan.json", "")));
}

TEST(BrokenInputs, TheTextOfAPlanIsRefusedByItsPlace) {
  const std::string good = shipped_plan_text(kPaperPlan, "");
  ASSERT_TRUE(parse_plan(good, "plan.json", "").ok());
  EXPECT_TRUE(parse_plan("\xEF\xBB\xBF" + good, "plan.json", "").ok());
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::vector<std::tuple<std::string, std::string, std::string>> texts = {
      {"", "JSON", "unexpected end"},
      {"{", "JSON", "unexpected end"},
      {with("\"seed\": 2005", "\"seed\": NaN"), "JSON", "line 1"},
      {with("\"limit_s\": 120", "\"limit_s\": 1e999"), "JSON", "1e999"},
      {with("\"seed\": 2005", "\"seed\": 1, \"seed\": 2"), "/seed", "more than once"},
      {with("\"rate_Hz\": 1000", "\"rate_Hz\": 1, \"rate_Hz\": 2"), "/device/rate_Hz",
       "more than once"},
      {with("\"O2\"", "\"O1\""), "/objects/O1", "more than once"},
      {good + "x", "JSON", "x"},
      {good + std::string(3, '\0'), "JSON", "is zero"},
      {std::string(300, '[') + std::string(300, ']'), "JSON byte 256", "deep"},
  };
  for (const auto& [text, element, problem] : texts) {
    SCOPED_TRACE(text.substr(0, 60));
    const auto plan = parse_plan(text, "plan.json", "");
    ASSERT_FALSE(plan.ok());
    expect_error(plan.error(), element, problem, "plan.json");
  }
}

TEST(BrokenInputs, AnOperatorFileIsRefusedByTheNameOfItsElement) {
  const Json good = Json::parse(shipped_operator_text("people2005"));
  const std::vector<Breakage> breakages = {
      {"format", [](Json& j) { j["palpate_operator"] = 2; }, "/palpate_operator", "is 2"},
      {"version", [](Json& j) { j["version"] = 0; }, "/version", "from 1"},
      {"unknown key", [](Json& j) { j["author"] = "x"; }, "/author", "not a known key"},
      {"no name", [](Json& j) { j.erase("name"); }, "/name", "is missing"},
      {"no parameters", [](Json& j) { j.erase("parameters"); }, "/parameters", "is missing"},
      {"missing parameter", [](Json& j) { j["parameters"].erase("replan_s"); },
       "/parameters/replan_s", "is missing"},
      {"unknown parameter", [](Json& j) { j["parameters"]["patience_s"] = 1; },
       "/parameters/patience_s", "not a known key"},
      {"parameter is a number", [](Json& j) { j["parameters"]["replan_s"] = 1; },
       "/parameters/replan_s", "an object"},
      {"missing low", [](Json& j) { j["parameters"]["replan_s"].erase("low"); },
       "/parameters/replan_s/low", "is missing"},
      {"low above high", [](Json& j) { j["parameters"]["replan_s"]["low"] = 0.6; },
       "/parameters/replan_s/high", "expected at least low"},
      {"delay 0", [](Json& j) { j["parameters"]["sight_delay_s"]["low"] = 0; },
       "/parameters/sight_delay_s/low", "above 0"},
      {"negative noise", [](Json& j) { j["parameters"]["force_noise"]["low"] = -0.1; },
       "/parameters/force_noise/low", "is -0.1"},
      {"stiffness too large",
       [](Json& j) { j["parameters"]["hand_stiffness_N_per_m"]["high"] = 1e300; },
       "/parameters/hand_stiffness_N_per_m/high", "at most"},
      {"unit", [](Json& j) { j["parameters"]["press_depth_m"]["unit"] = "mm"; },
       "/parameters/press_depth_m/unit", "expected \"m\""},
      {"no source", [](Json& j) { j["parameters"]["press_depth_m"].erase("source"); },
       "/parameters/press_depth_m/source", "is missing"},
      {"falls is a number", [](Json& j) { j["parameters"]["press_depth_m"]["falls"] = 1; },
       "/parameters/press_depth_m/falls", "true or false"},
      {"draw is a number", [](Json& j) { j["parameters"]["press_depth_m"]["draw"] = 1; },
       "/parameters/press_depth_m/draw", "a text"},
      {"unstable correction", [](Json& j) { j["parameters"]["gain_per_s"]["high"] = 7.9; },
       "/parameters/gain_per_s/high", "expected less than pi/2"},
  };
  for (const Breakage& breakage : breakages) {
    SCOPED_TRACE(breakage.name);
    Json json = good;
    breakage.change(json);
    const auto file = parse_operator(to_text(json), "operator.json");
    ASSERT_FALSE(file.ok());
    expect_error(file.error(), breakage.element, breakage.problem, "operator.json");
  }
  Json at_limit = good;  // 7.8 x 0.2 < pi/2 < 7.9 x 0.2
  at_limit["parameters"]["gain_per_s"]["high"] = 7.8;
  EXPECT_TRUE(parse_operator(to_text(at_limit), "operator.json").ok());
}

TEST(BrokenInputs, AnErrorInAnOperatorFileOfAPlanNamesThatFile) {
  const test::TemporaryFolder folder;
  Json broken = Json::parse(shipped_operator_text("literature"));
  broken["version"] = "1";
  folder.write("own.json", to_text(broken));
  Json json = paper();
  json["operator"] = "own.json";
  const auto plan = parse_plan(to_text(json), "plan.json", folder.path());
  ASSERT_FALSE(plan.ok());
  expect_error(plan.error(), "/version", "is \"1\"", folder.path("own.json"));
}

// A table of two trials of people, with some measures.
constexpr const char* kHeader =
    "participant,block,trial,haptic,rotation,object,attempt,status,total_time_s,"
    "losses_of_contact,mean_penetration_dm\n";
constexpr const char* kFirst = "Ann,1,1,NoH,R,O1,1,done,25.5,21,0.031\n";
constexpr const char* kSecond = "Ann,1,2,H,R,O1,1,timeout,,,\n";

std::string table() {
  return std::string(kHeader) + kFirst + kSecond;
}

TEST(TrialsFile, ReadsRowsOfPeople) {
  for (const bool crlf : {false, true}) {
    std::string text;
    for (const char c : table())
      text += c == '\n' && crlf ? std::string("\r\n") : std::string(1, c);
    for (const std::string& variant :
         {text, "\xEF\xBB\xBF" + text, text.substr(0, text.find_last_not_of("\r\n") + 1)}) {
      const auto rows = parse_trials(variant, "t.csv");
      ASSERT_TRUE(rows.ok()) << rows.error().to_string();
      ASSERT_EQ(rows->size(), 2u);
      const TrialRow& first = rows->front();
      EXPECT_EQ(first.participant, "Ann");
      EXPECT_EQ(first.following, "");
      EXPECT_EQ(first.block, 1);
      EXPECT_EQ(first.haptic, "NoH");
      EXPECT_EQ(first.status, TrialStatus::kDone);
      EXPECT_EQ(first.measures[kTotalTime], 25.5);
      EXPECT_EQ(first.measures[kPenetrationDm], 0.031);
      EXPECT_FALSE(first.measures[kPenetration].has_value());
      EXPECT_EQ(rows->back().status, TrialStatus::kTimeout);
      EXPECT_FALSE(rows->back().measures[kTotalTime].has_value());
    }
  }
}

TEST(TrialsFile, ReadsQuotedFieldsOtherColumnsAndMissingValues) {
  const auto rows = parse_trials(
      "\"participant\",block,haptic,rotation,object,status,note,total_time_s\n"
      "\"Ann, \"\"A\"\"\",1,H,R,O1,done,\"two\nlines, one field\",NA\n"
      "Bob,1,H,R,O1,fault,,nan\n\n",
      "t.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ(rows->front().participant, "Ann, \"A\"");
  EXPECT_FALSE(rows->front().measures[kTotalTime].has_value());
  EXPECT_FALSE(rows->back().measures[kTotalTime].has_value());
}

TEST(TrialsFile, RestoresEveryRowToTheBit) {
  TrialRow row{.following = "adapts-0.5",
               .participant = "7",
               .block = 0,
               .trial = 24,
               .haptic = "UaH",
               .rotation = "NoR",
               .object = "O4",
               .attempt = 2,
               .status = TrialStatus::kFault,
               .measures = {},
               .view = "still",
               .align = "forward",
               .start_orientation_deg = -0.1,
               .scale = 1.0 / 3.0};
  for (std::size_t i = 0; i < kPlainMeasureCount; ++i) {
    if (i % 5 != 4) row.measures[i] = std::ldexp(1.0 / 3.0 + static_cast<double>(i), -60);
  }
  CsvLines lines(trials_columns());
  add_row(lines, row);
  const auto rows = parse_trials(lines.text(), "t.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  const TrialRow& read = rows->front();
  EXPECT_EQ(read.following, row.following);
  EXPECT_EQ(read.participant, row.participant);
  EXPECT_EQ(read.block, row.block);
  EXPECT_EQ(read.trial, row.trial);
  EXPECT_EQ(read.haptic, row.haptic);
  EXPECT_EQ(read.rotation, row.rotation);
  EXPECT_EQ(read.object, row.object);
  EXPECT_EQ(read.attempt, row.attempt);
  EXPECT_EQ(read.status, row.status);
  EXPECT_EQ(read.measures, row.measures);
  EXPECT_EQ(read.view, row.view);
  EXPECT_EQ(read.align, row.align);
  EXPECT_EQ(read.start_orientation_deg, row.start_orientation_deg);
  EXPECT_EQ(read.scale, row.scale);
  CsvLines again(trials_columns());
  add_row(again, read);
  EXPECT_EQ(again.text(), lines.text());
}

TEST(TrialsFile, ColumnsDescribeEveryColumn) {
  const std::string text = columns_csv();
  const auto lines = std::count(text.begin(), text.end(), '\n');
  const auto commas = std::count(trials_columns().begin(), trials_columns().end(), ',');
  EXPECT_EQ(lines, 1 + commas + 1);
  EXPECT_TRUE(text.starts_with("name,unit,meaning,paper,presence,values\nfollowing,"));
  EXPECT_TRUE(trials_columns().starts_with(
      "following,participant,block,trial,haptic,rotation,object,attempt,status,total_time_s,"));
  EXPECT_TRUE(
      trials_columns().ends_with(",missed_deadlines,view,align,start_orientation_deg,scale"));
  // With strategies, the last columns are the same.
  EXPECT_TRUE(trials_columns(TrialColumns::kStrategies)
                  .ends_with(",strategy,view,align,start_orientation_deg,scale"));
}

TEST(BrokenInputs, ATableOfTrialsIsRefusedByLineAndColumn) {
  const std::string good = table();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  std::string semicolons = good;
  std::replace(semicolons.begin(), semicolons.end(), ',', ';');
  const std::vector<std::tuple<std::string, std::string, std::string>> texts = {
      {"", "", "is empty"},
      {kHeader, "", "has no trial"},
      {"\xEF\xBB\xBF", "", "is empty"},
      {good.substr(0, 100) + std::string(1, '\0') + good.substr(100), "byte 100", "is zero"},
      {semicolons, "line 1, column participant", "is missing"},
      {with("participant", "person"), "line 1, column participant", "is missing"},
      {with("block", "Block"), "line 1, column block", "is missing"},
      {with("haptic", "force"), "line 1, column haptic", "is missing"},
      {with("rotation", "a4"), "line 1, column rotation", "is missing"},
      {with("object", "model"), "line 1, column object", "is missing"},
      {with("status", "state"), "line 1, column status", "is missing"},
      {with("attempt", "participant"), "line 1, column participant", "more than once"},
      {with("losses_of_contact", "total_time_s"), "line 1, column total_time_s", "more than once"},
      {with("Ann,1,1,NoH", ",1,1,NoH"), "line 2, column participant", "a name"},
      {with("Ann,1,2,H", "Ann ,1,2,H"), "line 3, column participant", "without blanks around it"},
      {with("Ann,1,1", " Ann,1,1"), "line 2, column participant", "without blanks around it"},
      {with("Ann,1,1", "Ren\xE9,1,1"), "line 2, column participant", "in UTF-8"},
      {with("Ann,1,1", "A\x1b[2J,1,1"), "line 2, column participant", "control characters"},
      {with("Ann,1,1", "\"A\nnn\",1,1"), "line 2, column participant", "control characters"},
      {with("R,O1", "R,O1 "), "line 2, column object", "is \"O1 \""},
      {with("Ann,1,1,NoH", "Ann,one,1,NoH"), "line 2, column block", "is \"one\""},
      {with("Ann,1,1,NoH", "Ann,-1,1,NoH"), "line 2, column block", "is \"-1\""},
      {with("Ann,1,1,NoH", "Ann,1.5,1,NoH"), "line 2, column block", "a whole number"},
      {with("Ann,1,1,NoH", "Ann,,1,NoH"), "line 2, column block", "is \"\""},
      {with("Ann,1,1,NoH", "Ann,1,0,NoH"), "line 2, column trial", "from 1"},
      {with("NoH", "noh"), "line 2, column haptic", "NoH, UaH, H, seen-UaH or seen-H"},
      {with("NoH,R,", "NoH,A4,"), "line 2, column rotation", "NoR or R"},
      {with("NoH,R,O1", "NoH,R,"), "line 2, column object", "a name"},
      {with("1,done", "0,done"), "line 2, column attempt", "from 1"},
      {with("done", "ok"), "line 2, column status", "done, timeout, fault, aborted or skipped"},
      {with("timeout", ""), "line 3, column status", "is \"\""},
      {with("25.5", "\"25,5\""), "line 2, column total_time_s", "is \"25,5\"; expected a number"},
      {with("25.5", "25.5 s"), "line 2, column total_time_s", "a number"},
      {with("25.5", "+25.5"), "line 2, column total_time_s", "a number"},
      {with("25.5", "-25.5"), "line 2, column total_time_s",
       "is \"-25.5\"; expected a number of at"},
      {with("25.5", "-1e-300"), "line 2, column total_time_s", "at least 0"},
      {with("25.5", "-inf"), "line 2, column total_time_s", "at least 0"},
      {with("21", "-1"), "line 2, column losses_of_contact", "at least 0"},
      {with("0.031", "-0.031"), "line 2, column mean_penetration_dm", "at least 0"},
      {with("timeout,,,", "timeout,,,-1"), "line 3, column mean_penetration_dm", "at least 0"},
      {with("25.5", "nan"), "line 2, column total_time_s", "the status is done"},
      {with("25.5", "inf"), "line 2, column total_time_s", "the status is done"},
      {with("25.5", "1e999"), "line 2, column total_time_s", "a number"},
      {with("0.031", "NaN"), "line 2, column mean_penetration_dm", "the status is done"},
      {with("0.031", "0.031,1"), "line 2", "has 12 fields; expected 11"},
      {with("done,25.5,21,0.031", "done,25.5,21"), "line 2", "has 10 fields"},
      {with("timeout,,,", "timeout,,"), "line 3", "has 10 fields"},
      {good + kFirst, "line 4", "has the trial of line 2 again"},
      {with("Ann,1,2,H", "Ann,1,2,NoH"), "line 3", "has the trial of line 2 again"},
      {with("Ann,1,1", "\"Ann,1,1"), "line 2", "without its partner"},
      {with("Ann,1,1", "\"Ann\" A,1,1"), "line 2", "behind a closing quotation mark"},
      {with("Ann,1,1", "A\"nn,1,1"), "line 2", "within a field"},
      {with("Ann,1,1", "A\rnn,1,1"), "line 2", "carriage return"},
  };
  for (const auto& [text, element, problem] : texts) {
    SCOPED_TRACE(element + ": " + problem);
    const auto rows = parse_trials(text, "t.csv");
    ASSERT_FALSE(rows.ok());
    expect_error(rows.error(), element, problem, "t.csv");
  }
  EXPECT_GE(texts.size(), 40u);
}

TEST(BrokenInputs, ATableWithAnUnknownFollowingIsRefused) {
  const auto rows = parse_trials(
      "following,participant,block,haptic,rotation,object,status\nlazy,1,1,H,R,O1,done\n", "t.csv");
  ASSERT_FALSE(rows.ok());
  expect_error(rows.error(), "line 2, column following",
               "delayed, predict, replan, frozen, adapts-0, adapts-0.5 or adapts-1", "t.csv");
}

TrialRow live_row() {
  TrialRow row;
  row.participant = "7";
  row.block = 2;
  row.trial = 5;
  row.haptic = "UaH";
  row.rotation = "R";
  row.object = "O4";
  row.attempt = 2;
  row.status = TrialStatus::kAborted;
  row.live = LiveColumns{.pilot = 1,
                         .input = LiveInput::kPen,
                         .motion = PointerMotion::kUnknown,
                         .reason = CutReason::kLateFrames,
                         .returns_shown = 3,
                         .clutches = 0,
                         .pictures = 812,
                         .longest_picture_s = 1.0 / 30.0,
                         .css_px_per_mm = 1e-3 / 7.0};
  return row;
}

std::string live_text(const TrialRow& row) {
  CsvLines lines(trials_columns(TrialColumns::kLive));
  add_row(lines, row);
  return lines.text();
}

TEST(LiveTrialsFile, HasTheLiveColumnsBehindThePlainOnes) {
  const std::string& live = trials_columns(TrialColumns::kLive);
  EXPECT_EQ(live, trials_columns() +
                      ",pilot,input,motion,reason,returns_shown,clutches,pictures,"
                      "longest_picture_s,css_px_per_mm");
  const std::string text = columns_csv(TrialColumns::kLive);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'),
            2 + std::count(live.begin(), live.end(), ','));
  EXPECT_NE(text.find(",required,done|timeout|fault|aborted|skipped\n"), std::string::npos);
  EXPECT_NE(text.find(",required,NoH|UaH|H|seen-UaH|seen-H\n"), std::string::npos);
  // Simulated trials are neither aborted nor skipped.
  for (const TrialColumns kind : {TrialColumns::kFactors, TrialColumns::kStrategies}) {
    EXPECT_NE(columns_csv(kind).find(",required,done|timeout|fault\n"), std::string::npos);
    EXPECT_EQ(columns_csv(kind).find("pilot"), std::string::npos);
    EXPECT_NE(columns_csv(kind).find(",required,NoH|UaH|H\n"), std::string::npos);
  }
}

TEST(LiveTrialsFile, RestoresEveryRowToTheBit) {
  TrialRow without_values = live_row();
  without_values.status = TrialStatus::kDone;
  without_values.live = LiveColumns{};
  for (const TrialRow& row : {live_row(), without_values}) {
    const std::string text = live_text(row);
    const auto rows = parse_trials(text, "t.csv");
    ASSERT_TRUE(rows.ok()) << rows.error().to_string();
    ASSERT_TRUE(rows->front().live.has_value());
    const LiveColumns& read = *rows->front().live;
    EXPECT_EQ(read.pilot, row.live->pilot);
    EXPECT_EQ(read.input, row.live->input);
    EXPECT_EQ(read.motion, row.live->motion);
    EXPECT_EQ(read.reason, row.live->reason);
    EXPECT_EQ(read.returns_shown, row.live->returns_shown);
    EXPECT_EQ(read.clutches, row.live->clutches);
    EXPECT_EQ(read.pictures, row.live->pictures);
    EXPECT_EQ(read.longest_picture_s, row.live->longest_picture_s);
    EXPECT_EQ(read.css_px_per_mm, row.live->css_px_per_mm);
    EXPECT_EQ(live_text(rows->front()), text);
  }
}

// A trial of a pilot run is another trial.
TEST(LiveTrialsFile, KeepsPilotRowsApartAndReadsRowsWithoutLiveColumns) {
  const std::string head = "participant,block,haptic,rotation,object,status,pilot,reason\n";
  const auto rows =
      parse_trials(head +
                       "1,1,H,R,O1,done,1,\n1,1,H,R,O1,done,0,\n2,1,H,R,O1,skipped,,participant\n"
                       "3,1,H,R,O1,fault,,\n",
                   "t.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_EQ(rows->at(0).live->pilot, 1);
  EXPECT_EQ(rows->at(2).live->reason, CutReason::kParticipant);
  EXPECT_EQ(rows->at(2).status, TrialStatus::kSkipped);
  EXPECT_FALSE(rows->at(3).live.has_value());
  const auto without_reasons =
      parse_trials("participant,block,haptic,rotation,object,status\n1,1,H,R,O1,aborted\n", "");
  EXPECT_TRUE(without_reasons.ok());
}

// The lines of tests/engine/python/trials_test.py are the same.
TEST(BrokenInputs, ATableOfLiveTrialsIsRefusedByLineAndColumn) {
  const std::string head =
      "participant,block,haptic,rotation,object,status,pilot,input,motion,reason,returns_shown,"
      "clutches,pictures,longest_picture_s,css_px_per_mm\n";
  const std::string hint = " (rename the column if it has another meaning)";
  const std::string reasons =
      "focus, full_screen, pointer_lock, hidden, late_ticks, late_frames, trip, fault, server, "
      "experimenter, participant or lift";
  const std::vector<std::array<std::string, 2>> broken = {
      {"done,2,mouse,unknown,,0,0,9,0.1,4",
       "column pilot: is \"2\"; expected a whole number from 0 to 1" + hint},
      {"done,0,Mouse,unknown,,0,0,9,0.1,4",
       "column input: is \"Mouse\"; expected mouse, pen, touch, board or script" + hint},
      {"done,0,mouse,fast,,0,0,9,0.1,4",
       "column motion: is \"fast\"; expected unaccelerated, accelerated or unknown" + hint},
      {"aborted,0,mouse,unknown,bored,0,0,9,0.1,4",
       "column reason: is \"bored\"; expected " + reasons + hint},
      {"skipped,0,mouse,unknown,,0,0,9,0.1,4",
       "column reason: is \"\"; expected " + reasons + ", because the status is skipped"},
      {"done,0,mouse,unknown,focus,0,0,9,0.1,4",
       "column reason: is \"focus\"; expected an empty field, because the status is done"},
      {"done,0,mouse,unknown,,-1,0,9,0.1,4",
       "column returns_shown: is \"-1\"; expected a whole number from 0 to 1000000" + hint},
      {"done,0,mouse,unknown,,0,0.5,9,0.1,4",
       "column clutches: is \"0.5\"; expected a whole number from 0 to 1000000" + hint},
      {"done,0,mouse,unknown,,0,0,NA,0.1,4",
       "column pictures: is \"NA\"; expected a whole number from 0 to 1000000" + hint},
      {"done,0,mouse,unknown,,0,0,9,inf,4",
       "column longest_picture_s: is \"inf\"; expected a number from 0 to 1e+06" + hint},
      {"done,0,mouse,unknown,,0,0,9,0.1,0",
       "column css_px_per_mm: is \"0\"; expected a number above 0 and at most 1e+06" + hint}};
  for (const auto& [fields, problem] : broken) {
    const auto rows = parse_trials(head + "1,1,H,R,O1," + fields + "\n", "t.csv");
    ASSERT_FALSE(rows.ok()) << fields;
    EXPECT_EQ(rows.error().to_string(), "t.csv: line 2, " + problem);
  }
}

// An empty field of the last columns stands for what the paper did.
TEST(TrialsFile, ReadsTheLevelsOfAPlan) {
  const std::string names =
      "participant,block,haptic,rotation,object,status,view,align,start_orientation_deg,scale\n";
  const auto rows = parse_trials(
      names + "1,1,H,R,O1,done,,NA,,\n1,1,H,R,O1,done,still,forward,-144,0.5\n", "t.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_EQ(rows->front().view, "turning");
  EXPECT_EQ(rows->front().align, "nearest");
  EXPECT_EQ(rows->front().start_orientation_deg, 0.0);
  EXPECT_EQ(rows->front().scale, 1.0);
  EXPECT_EQ(rows->back().start_orientation_deg, -144.0);
  const std::vector<std::array<std::string, 3>> broken = {
      {"wide,,,", "view", "turning or still"},
      {",backward,,", "align", "nearest or forward"},
      {",,north,", "start_orientation_deg", "a number from -360 to 360"},
      {",,nan,", "start_orientation_deg", "a number from -360 to 360"},
      {",,,0", "scale", "above 0"},
      {",,,large", "scale", "above 0"}};
  for (const auto& [levels, column, expected] : broken) {
    const auto refused = parse_trials(names + "1,1,H,R,O1,done," + levels + "\n", "t.csv");
    ASSERT_FALSE(refused.ok()) << levels;
    expect_error(refused.error(), "line 2, column " + column, expected, "t.csv");
    EXPECT_NE(refused.error().hint.find("another meaning"), std::string::npos);
  }
  for (const auto& [following, view, expected] :
       {std::array{"delayed", "still", "turning"}, std::array{"adapts-1", "turning", "still"}}) {
    const auto refused = parse_trials(
        "following," + names + following + ",1,1,H,R,O1,done," + view + ",,,\n", "t.csv");
    ASSERT_FALSE(refused.ok());
    expect_error(refused.error(), "line 2, column view",
                 std::string("expected ") + expected + ", because the following is", "t.csv");
  }
}

TEST(BrokenInputs, AFileThatCannotBeReadIsRefusedByName) {
  const test::TemporaryFolder folder;
  for (const std::string& path : {folder.path("missing.json"), folder.path()}) {
    EXPECT_EQ(load_plan(path).error().path, path);
    EXPECT_EQ(load_operator(path).error().path, path);
    EXPECT_EQ(read_trials(path).error().path, path);
  }
  const std::string large = folder.write("large.json", std::string((1 << 20) + 1, ' '));
  EXPECT_EQ(load_plan(large).error().code, ErrorCode::kLimitExceeded);
}

TEST(Plan, ReadsWhatThePaperPlanStates) {
  const auto plan = parse_plan(shipped_plan_text(kPaperPlan, ""), "paper", "somewhere");
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  EXPECT_EQ(plan->seed, 2005u);
  EXPECT_EQ(plan->participants, 10);
  EXPECT_EQ(plan->conditions().size(), 24u);
  EXPECT_EQ(plan->block_numbers(), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(plan->trials_per_participant(), 384u);
  EXPECT_EQ(plan->device.sensors, 2);
  EXPECT_EQ(plan->device.actuators, 1);
  EXPECT_EQ(plan->device.haptics.coupling.stiffness_N_per_m, 1000.0);
  EXPECT_EQ(plan->device.haptics.coupling.damping_Ns_per_m, 2.0);
  EXPECT_EQ(plan->objects[1].name, "O2");
  EXPECT_EQ(plan->objects[1].path, "somewhere/labyrinth.glb");
  EXPECT_EQ(plan->person.name, "people2005");
  EXPECT_EQ(plan->followings.size(), 4u);
}

TEST(Plan, TakesEverySettingOfRun) {
  Json json = paper();
  json["device"] = Json::parse(R"({"sensors": 2, "actuated_axes": [[0, 1, 0]], "rate_Hz": 2000,
      "stiffness_N_per_m": 500, "damping_Ns_per_m": 1, "velocity_estimator": "adaptive",
      "velocity_window_ticks": 8, "encoder_quantum_m": 1e-5, "accuracy": "exact",
      "work_budget": 1000, "radius_m": 0.001, "plane_height_m": 0.002, "workspace_m": 0.5,
      "place": [0.01, 0, 0, 0, 0, 0, 1], "table1": "printed", "a4_step": "paper",
      "device_mass_kg": 0.2, "device_damping_Ns_per_m": 0.7, "device_friction_N": 0.03})");
  json["objects"]["O1"] = {{"file", "a.glb"},      {"node", "Star"}, {"fit_size_m", 0.1},
                           {"pose", "Walk@1.5"},   {"scene", 1},     {"feel_hidden", true},
                           {"close_gaps_m", 0.001}};
  json["objects"]["O2"] = {{"file", "a.glb"}, {"scene", "second"}};
  const auto plan = parse_plan(to_text(json), "plan.json", "");
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  const RunSettings& device = plan->device;
  EXPECT_EQ(device.actuated_axes.front(), Vec3(0, 1, 0));
  EXPECT_EQ(device.rate_Hz, 2000.0);
  EXPECT_EQ(device.haptics.coupling.stiffness_N_per_m, 500.0);
  EXPECT_EQ(device.haptics.coupling.damping_Ns_per_m, 1.0);
  EXPECT_EQ(device.haptics.coupling.velocity.method, VelocityMethod::kAdaptive);
  EXPECT_EQ(device.haptics.coupling.velocity.window_ticks, 8);
  EXPECT_EQ(device.encoder_quantum_m, 1e-5);
  EXPECT_EQ(device.haptics.god_object.accuracy.iterations, Accuracy::exact().iterations);
  EXPECT_EQ(device.work_budget, 1000);
  EXPECT_EQ(device.haptics.god_object.radius_m, 0.001);
  EXPECT_EQ(device.plane_height_m, 0.002);
  EXPECT_EQ(workspace_extent_m(device.device), 0.5);
  EXPECT_EQ(device.haptics.initial_pose.translation_m, Vec3(0.01, 0, 0));
  EXPECT_EQ(device.haptics.initial_pose.rotation.z(), 1.0);
  EXPECT_EQ(device.haptics.a4.table1, Table1Form::kAsPrinted);
  EXPECT_EQ(device.haptics.a4.step, StepRule::kSpeedByDt);
  EXPECT_EQ(device.device.mass_kg, 0.2);
  EXPECT_EQ(device.device.damping_Ns_per_m, 0.7);
  EXPECT_EQ(device.device.coulomb_friction_N, 0.03);
  EXPECT_EQ(plan->objects[0].scene.node, "Star");
  EXPECT_EQ(plan->objects[0].scene.fit_size_m, 0.1);
  EXPECT_EQ(plan->objects[0].scene.pose, "Walk@1.5");
  EXPECT_EQ(plan->objects[0].scene.listed_scene, "1");
  EXPECT_TRUE(plan->objects[0].scene.feels_hidden);
  EXPECT_EQ(plan->objects[0].scene.close_gaps_m, 0.001);
  EXPECT_EQ(plan->objects[1].scene.listed_scene, "second");
  EXPECT_FALSE(plan->objects[1].scene.feels_hidden);
}

TEST(Plan, HashIgnoresLayoutAndPlacesOfFilesOnly) {
  const std::uint64_t hash = parse_plan(shipped_plan_text(kPaperPlan, ""), "a", "")->hash;
  EXPECT_EQ(parse_plan(to_text(paper()), "b", "x")->hash, hash);
  EXPECT_EQ(parse_plan(shipped_plan_text(kPaperPlan, "elsewhere"), "c", "")->hash, hash);
  Json with_objects = paper();
  with_objects["objects"]["O1"] = {{"file", "elsewhere/star.glb"}};
  EXPECT_EQ(parse_plan(to_text(with_objects), "c", "")->hash, hash);
  for (const Breakage& change :
       std::vector<Breakage>{{"seed", [](Json& j) { j["seed"] = 2006; }, "", ""},
                             {"participants", [](Json& j) { j["participants"] = 11; }, "", ""},
                             {"rate", [](Json& j) { j["device"]["rate_Hz"] = 999; }, "", ""},
                             {"object", [](Json& j) { j["objects"]["O5"] = "star.glb"; }, "", ""},
                             {"scale",
                              [](Json& j) {
                                j["objects"]["O1"] = {{"file", "star.glb"}, {"scale", 2}};
                              },
                              "", ""},
                             {"operator", [](Json& j) { j["operator"] = "literature"; }, "", ""}}) {
    Json json = paper();
    change.change(json);
    EXPECT_NE(parse_plan(to_text(json), "d", "")->hash, hash) << change.name;
  }
}

}  // namespace
}  // namespace palpate
