// `palpate run`: its runs, its results and what it proposes for runs that are not comparable.

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/session/trace_csv.h"
#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::CommandLine;
using test::content_of;
using test::kCube;
using test::keys_of;
using test::kStar;
using test::kSummaryKeys;
using test::lines_of;
using test::Outcome;
using test::rows_of;
using test::sorted;
using test::without_times;

TEST_F(CommandLine, ComparesARunWithoutAndWithA4) {
  const Outcome o = expect_done({"run", kStar, "--virtual", "--json"});
  const json result = json::parse(o.out);
  EXPECT_EQ(keys_of(result),
            sorted({"comparable", "interrupted", "plane_height_m", "reasons", "runs", "scale",
                    "starts_inside", "try", "work_budget", "workspace_m"}));
  EXPECT_TRUE(result["starts_inside"].is_null());
  EXPECT_EQ(result["work_budget"], (json{{"units", 20000}, {"unit_ns", nullptr}}));
  EXPECT_EQ(result["interrupted"], false);
  EXPECT_EQ(result["comparable"], true);
  EXPECT_TRUE(result["reasons"].empty());
  EXPECT_TRUE(result["try"].is_null());
  EXPECT_EQ(result["plane_height_m"], 0.0);
  ASSERT_EQ(result["runs"].size(), 2u);
  auto expected = kSummaryKeys;
  expected.insert(expected.end(), {"a4", "way_share", "contact_share", "comparable", "reasons",
                                   "missed_deadlines", "device_extent_m"});
  for (const json& run : result["runs"]) {
    for (const std::string& key : expected) EXPECT_TRUE(run.contains(key)) << key;
    EXPECT_EQ(keys_of(run["step_ns"]), sorted({"p50", "p99", "p999", "max"}));
    EXPECT_EQ(run["ticks"], 28000);
    EXPECT_EQ(run["triangles"], 36);
    EXPECT_GE(run["way_share"], 0.99);
    EXPECT_EQ(run["comparable"], true);
    EXPECT_EQ(run["interrupted"], false);
    EXPECT_TRUE(run["missed_deadlines"].is_null()) << "simulated time has no deadlines";
    EXPECT_EQ(run["device_extent_m"].size(), 3u);
  }
  EXPECT_EQ(result["runs"][0]["a4"], false);
  EXPECT_EQ(result["runs"][1]["a4"], true);
  EXPECT_LT(result["runs"][1]["mean_contact_angle_deg"], 35.0);
  EXPECT_GT(result["runs"][0]["mean_contact_angle_deg"], 40.0);
  // The default folder, in the folder it runs in.
  for (const char* name : {"out/trace-off.csv", "out/trace-on.csv"}) {
    const std::string csv = content_of(folder.path(name));
    EXPECT_EQ(lines_of(csv).at(0), trace_columns());
    EXPECT_EQ(rows_of(csv).size(), 28000u);
  }
  EXPECT_NE(content_of(folder.path("out/trace-off.csv")),
            content_of(folder.path("out/trace-on.csv")));
  const std::string picture = content_of(folder.path("out/paths.svg"));
  EXPECT_NE(picture.find("<svg"), std::string::npos);
  EXPECT_NE(picture.find("</svg>"), std::string::npos);
}

TEST_F(CommandLine, RunsWithOrWithoutA4Only) {
  for (const bool a4 : {false, true}) {
    const std::string out = folder.path(a4 ? "on/deep" : "off/deep");
    const json result =
        json::parse(expect_not_comparable({"run", kStar, "--virtual", "--seconds", "2", "--a4",
                                           a4 ? "on" : "off", "--json", "--out", out})
                        .out);
    ASSERT_EQ(result["runs"].size(), 1u);
    EXPECT_EQ(result["runs"][0]["a4"], a4);
    EXPECT_EQ(std::filesystem::exists(out + "/trace-on.csv"), a4);
    EXPECT_EQ(std::filesystem::exists(out + "/trace-off.csv"), !a4);
  }
}

// A strategy makes one run: in simulated time, the trace is that of the options it stands for.
TEST_F(CommandLine, MakesOneRunOfAStrategy) {
  const auto trace = [&](const std::vector<std::string>& options, const char* file) {
    std::vector<std::string> run{"run", kStar, "--virtual", "--seconds", "2", "--out", "runs"};
    run.insert(run.end(), options.begin(), options.end());
    expect_run(run);
    return without_times(content_of(folder.path(std::string("runs/") + file)));
  };
  EXPECT_EQ(trace({"--strategy", "full"}, "trace-off.csv"),
            trace({"--force", "full", "--a4", "off"}, "trace-off.csv"));
  EXPECT_EQ(trace({"--strategy", "a4"}, "trace-on.csv"), trace({"--a4", "on"}, "trace-on.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("runs/trace-off.csv")));
  EXPECT_NE(trace({"--strategy", "cd"}, "trace-off.csv"), "");
}

TEST_F(CommandLine, PrintsBothRunsSideBySide) {
  const std::string out =
      expect_done({"run", kStar, "--virtual", "--seconds", "26", "--out", folder.path("o")}).out;
  for (const char* what : {"without A4", "with A4", "contact angle", "within 30 deg", "penetration",
                           "losses", "work", "travel", "missed deadlines", "p50 / p99 / max"}) {
    EXPECT_NE(out.find(what), std::string::npos) << what << " is not in " << out;
  }
  EXPECT_TRUE(std::regex_search(out, std::regex("\nmissed deadlines +- +-\n")))
      << "not measured in simulated time: " << out;
}

TEST_F(CommandLine, CountsMissedDeadlinesInRealTime) {
  const json result = json::parse(
      expect_not_comparable({"run", kStar, "--seconds", "2", "--a4", "on", "--json"}).out);
  const json& missed = result["runs"].at(0)["missed_deadlines"];
  ASSERT_TRUE(missed.is_number_unsigned()) << missed;
  EXPECT_LE(missed, result["runs"].at(0)["ticks"]);
}

TEST_F(CommandLine, GivesOneTraceForOneSeed) {
  const auto trace = [&](const char* seed, bool virtual_time) {
    std::vector<std::string> arguments{"run", kStar,    "--seconds", "2",     "--a4",
                                       "on",  "--seed", seed,        "--out", folder.path("o")};
    if (virtual_time) arguments.emplace_back("--virtual");
    expect_not_comparable(arguments);
    return without_times(content_of(folder.path("o/trace-on.csv")));
  };
  const std::string first = trace("5", true);
  EXPECT_EQ(trace("5", true), first);
  EXPECT_EQ(trace("5", false), first) << "in real time, too";
  EXPECT_NE(trace("6", true), first);
}

TEST_F(CommandLine, WalksWithThreeSensorsAndRunsWithoutActuators) {
  const std::vector<std::vector<std::string>> devices{
      {"--sensors", "3"},
      {"--sensors", "3", "--actuators", "2"},
      {"--sensors", "3", "--actuators", "3"},
      {"--sensors", "3", "--actuated-axes", "0 0 1"},
      {"--sensors", "2", "--actuators", "0"},
      {"--sensors", "2", "--actuators", "2"}};
  for (const auto& device : devices) {
    std::vector<std::string> arguments{"run",       kCube,       "--fit", "auto",
                                       "--virtual", "--seconds", "5",     "--json"};
    arguments.insert(arguments.end(), device.begin(), device.end());
    const Outcome o = call(arguments);
    const json result = json::parse(o.out);
    EXPECT_EQ(o.exit_code, result["comparable"] == true ? 0 : 3) << o.err;
    for (const json& run : result["runs"]) EXPECT_GT(run["contact_ticks"], 1000);
  }
}

// A script can run the proposed command line.
TEST_F(CommandLine, ProposesACommandLineForARunThatIsNotComparable) {
  const std::string text =
      expect_not_comparable({"run", kStar, "--virtual", "--seconds", "5", "--a4", "on"}).out;
  EXPECT_TRUE(text.starts_with("not comparable\n")) << text;
  const json result = json::parse(
      expect_not_comparable({"run", kStar, "--virtual", "--seconds", "5", "--a4", "on", "--json"})
          .out);
  EXPECT_EQ(result["comparable"], false);
  ASSERT_EQ(result["reasons"].size(), 1u);
  EXPECT_NE(result["reasons"][0].get<std::string>().find("% of the contour"), std::string::npos);
  EXPECT_EQ(result["runs"][0]["comparable"], false);
  const std::string proposed = result["try"];
  EXPECT_NE(text.find("  try: "), std::string::npos);
  std::vector<std::string> words;
  std::istringstream stream(proposed);
  for (std::string word; stream >> word;) words.push_back(word);
  ASSERT_EQ(words.front(), "palpate");
  words.erase(words.begin());
  EXPECT_EQ(json::parse(expect_done(words).out)["comparable"], true) << proposed;
  EXPECT_TRUE(std::filesystem::exists(folder.path("out/trace-on.csv")));
}

// The words of the command line that the program proposes for a run that is not comparable.
std::vector<std::string> proposed_words(const json& result) {
  EXPECT_TRUE(result["try"].is_string());
  std::istringstream line(result.value("try", std::string()));
  std::vector<std::string> words;
  bool is_quoted = false;
  std::string word;
  for (char c = '\0'; line.get(c);) {
    if (c == '\'') is_quoted = !is_quoted;
    if (c == ' ' && !is_quoted) words.push_back(std::exchange(word, {}));
    if (c != '\'' && (c != ' ' || is_quoted)) word += c;
  }
  words.push_back(word);
  words.erase(words.begin());  // palpate
  return words;
}

bool has_word(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

TEST_F(CommandLine, ProposesASmallerSphereForASphereThatIsTooLarge) {
  const json result = json::parse(expect_not_comparable({"run", kStar, "--virtual", "--a4", "off",
                                                         "--radius", "0.02", "--json"})
                                      .out);
  EXPECT_NE(result["reasons"][0].get<std::string>().find("the sphere of --radius 0.02 m"),
            std::string::npos)
      << result["reasons"];
  const std::vector<std::string> words = proposed_words(result);
  EXPECT_TRUE(has_word(words, "--radius")) << result["try"];
  EXPECT_FALSE(has_word(words, "0.02")) << result["try"];
  expect_done(words);
}

// Near its top a ball of 380 mm has a contour of a millimetre.
TEST_F(CommandLine, ProposesAnotherPlaneForAContourThatIsTooShort) {
  const std::string sphere = std::string(PALPATE_MODELS_DIR) + "/sphere.glb";
  const json result =
      json::parse(expect_not_comparable({"run", sphere, "--virtual", "--a4", "off", "--fit", "0.38",
                                         "--plane-height", "0.18999", "--place=0 0 0 1 0 0 0",
                                         "--actuated-axes", "1 0 0", "--json"})
                      .out);
  const std::vector<std::string> words = proposed_words(result);
  EXPECT_FALSE(has_word(words, "0.18999")) << result["try"];
  expect_done(words);
}

TEST_F(CommandLine, PrintsNoMeansForARunWithoutContact) {
  const Outcome o = expect_not_comparable(
      {"run", kStar, "--virtual", "--seconds", "2", "--a4", "off", "--move", "#0=0 0 50 0 0 0"});
  EXPECT_NE(o.out.find("touched no surface"), std::string::npos) << o.out;
  const json result =
      json::parse(expect_not_comparable({"run", kStar, "--virtual", "--seconds", "2", "--a4", "off",
                                         "--move", "#0=0 0 50 0 0 0", "--json"})
                      .out);
  EXPECT_TRUE(result["runs"][0]["mean_contact_angle_deg"].is_null());
  EXPECT_TRUE(result["runs"][0]["share_within_30deg"].is_null());
  EXPECT_EQ(result["runs"][0]["contact_share"], 0.0);
}

TEST_F(CommandLine, MarksTheTimesOfASimulatedRunAsTimesOfTheMachine) {
  const Outcome run = expect_not_comparable(
      {"run", kStar, "--virtual", "--seconds", "2", "--a4", "off", "--move", "#0=0 0 50 0 0 0"});
  EXPECT_NE(run.out.find("us (3)"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("(3) computing times of this machine"), std::string::npos) << run.out;
}

}  // namespace
}  // namespace palpate
