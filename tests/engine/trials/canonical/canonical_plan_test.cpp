// Plans with "protocol": "canonical", as they ship and broken in one place each; and canonical.csv.

#include "engine/trials/canonical/canonical_plan.h"

#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/trials/canonical/canonical_rows.h"
#include "engine/trials/shipped_files.h"
#include "tests/engine/trials/added_column.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

Json shipped() {
  return Json::parse(shipped_canonical());
}

Result<CanonicalPlan> parsed(const Json& json) {
  return parse_canonical_plan(json.dump(), "wall.json", "");
}

TEST(CanonicalPlan, ThatShipsIsRead) {
  const auto plan = load_canonical_plan("canonical");
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  ASSERT_TRUE(plan->has_value());
  EXPECT_EQ((*plan)->angles_deg, (std::vector<double>{0, 15, 30, 45, 60, 75, 90}));
  EXPECT_EQ((*plan)->participants, 10);
  EXPECT_EQ((*plan)->person.name, "people2005");
  const auto cells = (*plan)->cells();
  ASSERT_EQ(cells.size(), 28u);
  EXPECT_EQ(cells[0].rotates, false);
  EXPECT_EQ(cells[1].rotates, true);
  EXPECT_EQ(cells[1].motion, CanonicalMotion::kPressed);
  EXPECT_EQ(cells[2].motion, CanonicalMotion::kStroked);
  EXPECT_EQ(cells[4].angle_deg, 15.0);
}

TEST(CanonicalPlan, WithoutAnglesHasThoseFrom0To90InStepsOf15) {
  Json json = shipped();
  json.erase("angles_deg");
  const auto plan = parsed(json);
  ASSERT_TRUE(plan.ok()) << plan.error().to_string();
  EXPECT_EQ(plan->angles_deg, (std::vector<double>{0, 15, 30, 45, 60, 75, 90}));
}

TEST(CanonicalPlan, IsToldFromOtherPlansByTheKeyProtocol) {
  const test::TemporaryFolder folder;
  const auto paper = load_canonical_plan("paper");
  ASSERT_TRUE(paper.ok());
  EXPECT_FALSE(paper->has_value());
  const auto other = load_canonical_plan(folder.write("other.json", R"({"objects": {}})"));
  ASSERT_TRUE(other.ok());
  EXPECT_FALSE(other->has_value());
  const auto own = load_canonical_plan(folder.write("own.json", shipped().dump()));
  ASSERT_TRUE(own.ok()) << own.error().to_string();
  EXPECT_TRUE(own->has_value());
}

TEST(CanonicalPlan, HashesItsContentAndNotItsForm) {
  const auto hash_after = [](const std::function<void(Json&)>& change) {
    Json json = shipped();
    change(json);
    const auto plan = parse_canonical_plan(json.dump(4), "other name.json", "folder");
    EXPECT_TRUE(plan.ok()) << plan.error().to_string();
    return plan->hash;
  };
  const std::uint64_t hash = parsed(shipped())->hash;
  EXPECT_EQ(hash_after([](Json&) {}), hash);
  EXPECT_NE(hash_after([](Json& j) { j["seed"] = 1; }), hash);
  EXPECT_NE(hash_after([](Json& j) { j["angles_deg"] = {0, 15}; }), hash);
  EXPECT_NE(hash_after([](Json& j) { j["display_Hz"] = 60; }), hash);
  EXPECT_NE(hash_after([](Json& j) { j["device"]["stiffness_N_per_m"] = 900; }), hash);
  EXPECT_NE(hash_after([](Json& j) { j["operator"] = "literature"; }), hash);
}

// A change that breaks a plan, and the element and a part of the problem that the error must name.
struct Breakage {
  std::string name;
  std::function<void(Json&)> change;
  std::string element;
  std::string problem;
};

const std::vector<Breakage>& broken_canonical_plans() {
  static const std::vector<Breakage> all = {
      {"another protocol", [](Json& j) { j["protocol"] = "paper"; }, "/protocol",
       "is \"paper\"; expected canonical"},
      {"no protocol", [](Json& j) { j["protocol"] = nullptr; }, "/protocol", "is null"},
      {"a protocol of usual plans",
       [](Json& j) {
         j["protocol"] = "contour";
         j["blocks"] = 3;
       },
       "/protocol", "is \"contour\"; expected canonical"},
      {"objects",
       [](Json& j) {
         j["objects"] = {{"O1", "star.glb"}};
       },
       "/objects", "is not a known key"},
      {"haptic", [](Json& j) { j["haptic"] = {"UaH"}; }, "/haptic", "is not a known key"},
      {"rotation", [](Json& j) { j["rotation"] = {"R"}; }, "/rotation", "is not a known key"},
      {"followings", [](Json& j) { j["followings"] = {"delayed"}; }, "/followings",
       "is not a known key"},
      {"blocks", [](Json& j) { j["blocks"] = 1; }, "/blocks", "is not a known key"},
      {"strategies", [](Json& j) { j["strategies"] = {"a4"}; }, "/strategies",
       "is not a known key"},
      {"format", [](Json& j) { j["palpate_plan"] = 2; }, "/palpate_plan", "is 2; expected 1"},
      {"no name", [](Json& j) { j.erase("name"); }, "/name", "is missing"},
      {"seed", [](Json& j) { j["seed"] = -1; }, "/seed", "is -1"},
      {"no participants", [](Json& j) { j["participants"] = 0; }, "/participants", "is 0"},
      {"too many trials",
       [](Json& j) {
         j["participants"] = 10000;
         j["angles_deg"] = Json::array();
         for (int a = 0; a <= 90; ++a) j["angles_deg"].push_back(a);
       },
       "/participants", "3640000 trials; expected at most 262144"},
      {"no device", [](Json& j) { j.erase("device"); }, "/device", "is missing"},
      {"three sensors", [](Json& j) { j["device"]["sensors"] = 3; }, "/device/sensors",
       "is 3; expected 2"},
      {"no motor", [](Json& j) { j["device"]["actuators"] = 0; }, "/device/actuators",
       "gives 0 motors; expected one"},
      {"two motors", [](Json& j) { j["device"]["actuators"] = 2; }, "/device/actuators",
       "gives 2 motors; expected one"},
      {"two axes",
       [](Json& j) {
         j["device"].erase("actuators");
         j["device"]["actuated_axes"] = Json::parse("[[1,0,0],[0,1,0]]");
       },
       "/device/actuated_axes", "gives 2 motors; expected one"},
      {"a place", [](Json& j) { j["device"]["place"] = {0, 0, 0, 1, 0, 0, 0}; }, "/device/place",
       "is given; expected no such key"},
      {"a plane", [](Json& j) { j["device"]["plane_height_m"] = 0.0; }, "/device/plane_height_m",
       "is given; expected no such key"},
      {"an unknown key of the device", [](Json& j) { j["device"]["stifness"] = 1; },
       "/device/stifness", "is not a known key"},
      {"a small workspace", [](Json& j) { j["device"]["workspace_m"] = 0.2; },
       "/device/workspace_m", "is 0.2 m; expected at least 0.2524 m"},
      {"a workspace too small for the proxy", [](Json& j) { j["device"]["radius_m"] = 0.1; },
       "/device/workspace_m", "is 0.4 m; expected at least 0.4524 m"},
      {"no display", [](Json& j) { j["display_Hz"] = 0; }, "/display_Hz", "is 0"},
      {"a fast display", [](Json& j) { j["display_Hz"] = 2000; }, "/display_Hz",
       "expected at most the rate of the device, 1000 Hz"},
      {"a display that is barely too fast", [](Json& j) { j["display_Hz"] = 1000.0001; },
       "/display_Hz", "is 1000.0001; expected at most the rate of the device, 1000 Hz"},
      {"a display without a picture", [](Json& j) { j["display_Hz"] = 1e-310; }, "/display_Hz",
       "is 1e-310; expected at least 0.333333333333333 Hz, one picture within 3 s"},
      {"a display that is barely too slow", [](Json& j) { j["display_Hz"] = 0.333; }, "/display_Hz",
       "is 0.333; expected at least 0.333333333333333 Hz"},
      {"angles in no list", [](Json& j) { j["angles_deg"] = 45; }, "/angles_deg",
       "is 45; expected a list"},
      {"no angle", [](Json& j) { j["angles_deg"] = Json::array(); }, "/angles_deg",
       "is a list of 0"},
      {"too many angles", [](Json& j) { j["angles_deg"] = std::vector<double>(182, 1.0); },
       "/angles_deg", "is a list of 182"},
      {"a negative angle",
       [](Json& j) {
         j["angles_deg"] = {-15, 0};
       },
       "/angles_deg/0", "is -15"},
      {"an angle beyond 90",
       [](Json& j) {
         j["angles_deg"] = {0, 90.5};
       },
       "/angles_deg/1", "is 90.5"},
      {"an angle that is a text", [](Json& j) { j["angles_deg"] = Json::parse(R"([0, "15"])"); },
       "/angles_deg/1", "is \"15\""},
      {"angles that descend",
       [](Json& j) {
         j["angles_deg"] = {0, 30, 15};
       },
       "/angles_deg/2", "is 15 after 30; expected a larger angle"},
      {"a repeated angle",
       [](Json& j) {
         j["angles_deg"] = {0, 15, 15};
       },
       "/angles_deg/2", "is 15 after 15"},
      {"no operator", [](Json& j) { j.erase("operator"); }, "/operator", "is missing"},
      {"an unknown operator", [](Json& j) { j["operator"] = "nobody.json"; }, "/operator",
       "is \"nobody.json\"; expected literature, people2005 or the path of an operator file"},
  };
  return all;
}

TEST(CanonicalPlan, NamesWhatIsBroken) {
  for (const Breakage& broken : broken_canonical_plans()) {
    SCOPED_TRACE(broken.name);
    Json json = shipped();
    broken.change(json);
    const auto plan = parsed(json);
    ASSERT_FALSE(plan.ok());
    const std::string line = plan.error().to_string();
    EXPECT_EQ(plan.error().path, "wall.json") << line;
    EXPECT_EQ(plan.error().element, broken.element) << line;
    EXPECT_NE(plan.error().problem.find(broken.problem), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos);
  }
}

// The number after "expected at least" of an error.
double advised(const Error& error) {
  const std::string before = "expected at least ";
  return std::stod(error.problem.substr(error.problem.find(before) + before.size()));
}

TEST(CanonicalPlan, AcceptsTheLeastNumberThatItsErrorsName) {
  for (const auto& [name, operator_name] :
       {std::pair("people2005", "people2005"), std::pair("literature", "literature")}) {
    for (const double radius_m : {0.0, 0.001, 0.003, 0.01, 0.033}) {
      SCOPED_TRACE(name + std::string(", radius ") + std::to_string(radius_m));
      Json json = shipped();
      json["operator"] = operator_name;
      json["device"]["radius_m"] = radius_m;
      json["device"]["workspace_m"] = 0.1;
      const auto small = parsed(json);
      ASSERT_FALSE(small.ok());
      json["device"]["workspace_m"] = advised(small.error());
      EXPECT_TRUE(parsed(json).ok()) << parsed(json).error().to_string();
    }
  }
  // Two strokes of 0.1 m and twice two depths of 0.01 m are 0.24 m, which no double is.
  Json json = shipped();
  json["operator"] = "literature";
  json["device"]["workspace_m"] = 0.24;
  EXPECT_TRUE(parsed(json).ok()) << parsed(json).error().to_string();
  json["device"]["workspace_m"] = 0.2399999;
  EXPECT_FALSE(parsed(json).ok());
  json = shipped();
  json["display_Hz"] = 0.1;
  json["display_Hz"] = advised(parsed(json).error());
  EXPECT_TRUE(parsed(json).ok()) << parsed(json).error().to_string();
}

TEST(CanonicalPlan, RefusesOperatorsWhoseStrokeDoesNotEnd) {
  const test::TemporaryFolder folder;
  Json person = Json::parse(shipped_literature());
  for (const double speed_m_per_s : {0.0, 1e-310, 1e-6}) {
    person["parameters"]["speed_m_per_s"]["low"] = speed_m_per_s;
    folder.write("slow.json", person.dump());
    Json json = shipped();
    json["operator"] = "slow.json";
    const auto plan = parse_canonical_plan(json.dump(), "wall.json", folder.path());
    ASSERT_FALSE(plan.ok());
    EXPECT_EQ(plan.error().element, "/operator");
    EXPECT_NE(plan.error().problem.find("expected at most 4e+06 ticks"), std::string::npos)
        << plan.error().to_string();
    // A stroke that never ends does not end at another rate either.
    const bool ends = speed_m_per_s == 1e-6;
    EXPECT_EQ(plan.error().problem.find("which never ends; ") == std::string::npos, ends);
    EXPECT_EQ(plan.error().hint.find("rate_Hz") != std::string::npos, ends);
  }
}

CanonicalRow row_of(int participant, double angle_deg, std::optional<double> ratio) {
  return {participant, {angle_deg, CanonicalMotion::kStroked, true}, ratio, 0.25};
}

TEST(CanonicalRows, AreReadAsTheyWereWritten) {
  const std::vector<CanonicalRow> rows = {row_of(1, 15.0, 0.1 + 0.2),
                                          row_of(2, 22.5, {}),
                                          {3, {90.0, CanonicalMotion::kPressed, false}, {}, {}}};
  CsvLines lines(canonical_columns());
  for (const CanonicalRow& row : rows) add_canonical_row(lines, row);
  EXPECT_EQ(lines.text(),
            "participant,angle_deg,motion,rotation,along_over_into,share_within_30deg\n"
            "1,15,stroked,R,0.30000000000000004,0.25\n"
            "2,22.5,stroked,R,,0.25\n"
            "3,90,pressed,NoR,,\n");
  const auto read = parse_canonical_rows(lines.text(), "canonical.csv");
  ASSERT_TRUE(read.ok()) << read.error().to_string();
  ASSERT_EQ(read->size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ((*read)[i].participant, rows[i].participant);
    EXPECT_EQ((*read)[i].cell.angle_deg, rows[i].cell.angle_deg);
    EXPECT_EQ((*read)[i].cell.motion, rows[i].cell.motion);
    EXPECT_EQ((*read)[i].cell.rotates, rows[i].cell.rotates);
    EXPECT_EQ((*read)[i].along_over_into, rows[i].along_over_into);
    EXPECT_EQ((*read)[i].share_within_30deg, rows[i].share_within_30deg);
  }
}

TEST(AddedColumn, IsEverywhereInCanonicalTrials) {
  test::expect_added_column_everywhere(canonical_table(), row_of(1, 15.0, {}));
}

TEST(CanonicalRows, NameTheLineAndTheColumnThatIsWrong) {
  const std::string head = canonical_columns() + "\n1,0,pressed,R,0,1\n";
  for (const auto& [text, element] :
       {std::pair<std::string, std::string>{"participant\n", "line 1"},
        {head + "1,0,pressed,R,0\n", "line 3"},
        {head + "x,0,pressed,R,0,1\n", "line 3, column participant"},
        {head + "1,zero,pressed,R,0,1\n", "line 3, column angle_deg"},
        {head + "1,0,pushed,R,0,1\n", "line 3, column motion"},
        {head + "1,0,pressed,r,0,1\n", "line 3, column rotation"},
        {head + "1,0,pressed,R,nan,1\n", "line 3, column along_over_into"},
        {head + "1,0,pressed,R,0,-1\n", "line 3, column share_within_30deg"},
        {head + "1,0,pressed,R,0,\"1\n", "line 3"},
        {head + "1,0,pressed,R,0,1\r1\n", "line 3"}}) {
    const auto rows = parse_canonical_rows(text, "canonical.csv");
    ASSERT_FALSE(rows.ok()) << text;
    EXPECT_EQ(rows.error().element, element) << rows.error().to_string();
    EXPECT_EQ(rows.error().path, "canonical.csv");
  }
}

}  // namespace
}  // namespace palpate
