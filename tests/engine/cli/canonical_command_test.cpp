// `palpate experiment` with a canonical plan, as a user or a script runs it. Pages take seconds, so
// only the tests that look at one have a Python.

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/run_program.h"
#include "tests/helpers/environment_variable.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::content_of;
using test::Outcome;
using test::StartedProgram;
using test::TemporaryFolder;

using Arguments = std::vector<std::string>;
using Contents = std::map<std::string, std::string>;  // of files, by their name

constexpr int kPersons = 7;

Json wall_plan() {
  return Json::parse(R"({"palpate_plan": 1, "name": "wall", "protocol": "canonical", "seed": 5,
      "participants": 7,
      "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                 "damping_Ns_per_m": 2},
      "display_Hz": 40, "angles_deg": [30, 75], "operator": "literature"})");
}

constexpr const char* kNoPython = "/nowhere/python3";

// Without the page.
Contents canonical_results(const std::string& folder) {
  Contents results;
  for (const char* const name : {"canonical.csv", "columns.csv", "run.json"}) {
    const std::string path = (fs::path(folder) / name).string();
    if (fs::exists(path)) results[name] = content_of(path);
  }
  return results;
}

class CanonicalCommandTest : public testing::Test {
 protected:
  CanonicalCommandTest() { folder.write("wall.json", wall_plan().dump()); }

  Outcome call(const Arguments& more) const {
    Arguments arguments{"experiment"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(folder, arguments);
  }
  Outcome expect_done(const Arguments& more) const {
    const Outcome o = call(more);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    const bool is_page_missing =
        o.err.starts_with("palpate: warning: the page is missing: /nowhere/python3 ") &&
        std::count(o.err.begin(), o.err.end(), '\n') == 1;
    EXPECT_TRUE(o.err.empty() || is_page_missing) << o.err;
    return o;
  }
  // Code 2, nothing on stdout, and one line on stderr with all of `parts`.
  void expect_refused(const Arguments& more, const std::vector<std::string>& parts) const {
    const Outcome o = call(more);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_TRUE(o.err.starts_with("palpate: ")) << o.err;
    for (const std::string& part : parts) EXPECT_NE(o.err.find(part), std::string::npos) << o.err;
  }
  std::string path(const std::string& name) const { return folder.path(name); }

  // The results of one undisturbed run of wall_plan().
  static const Contents& reference() {
    static const Contents results = [] {
      const TemporaryFolder own;
      own.write("wall.json", wall_plan().dump());
      const test::EnvironmentVariable python("PALPATE_PYTHON", kNoPython);
      const Outcome o = run_program(own, {"experiment", "run", "wall.json", "--jobs", "1"});
      EXPECT_EQ(o.exit_code, 0) << o.err;
      return canonical_results(own.path("experiment"));
    }();
    return results;
  }

  TemporaryFolder folder;
  test::EnvironmentVariable python{"PALPATE_PYTHON", kNoPython};
};

TEST_F(CanonicalCommandTest, RunWritesOneRowForEachPersonAngleMotionAndRotation) {
  const Outcome o = expect_done({"run", "wall.json", "--jobs", "2", "--out", "out"});
  EXPECT_EQ(o.out,
            "56 trials of 7 participants at the canonical wall\n"
            "canonical.csv, columns.csv and run.json are in out/\n");
  EXPECT_FALSE(fs::exists(path("out/canonical.html")));
  EXPECT_EQ(canonical_results(path("out")), reference());
  std::string expected = "participant,angle_deg,motion,rotation";
  for (int participant = 1; participant <= kPersons; ++participant) {
    for (const char* const angle : {"30", "75"}) {
      for (const char* const motion : {"pressed", "stroked"}) {
        for (const char* const rotation : {"NoR", "R"}) {
          expected +=
              "\n" + std::to_string(participant) + "," + angle + "," + motion + "," + rotation;
        }
      }
    }
  }
  const std::string& rows = reference().at("canonical.csv");
  EXPECT_EQ(std::regex_replace(rows, std::regex(",[^,\n]*,[^,\n]*\n"), "\n"), expected + "\n");
  const Json run = Json::parse(reference().at("run.json"));
  EXPECT_EQ(run["kind"], "canonical");
  EXPECT_EQ(run["trials"], 56);
  EXPECT_EQ(run["trials_without_result"], 0);
  // Python checks canonical.csv by its own copy of columns.csv.
  EXPECT_EQ(
      reference().at("columns.csv"),
      content_of(PALPATE_MODELS_DIR "/../engine/python/palpate/analysis/canonical/columns.csv"));
}

TEST_F(CanonicalCommandTest, ShardsInAnyOrderMergeToTheSameBytes) {
  for (int count = 1; count <= kPersons; ++count) {
    Arguments merge{"merge"};
    for (int i = 0; i < count; ++i) {
      // In the order 2, 4, 6, ..., 1, 3, 5, ... of each count.
      const int half = count / 2;
      const int number = i < half ? 2 * i + 2 : 2 * (i - half) + 1;
      const std::string shard = std::to_string(number) + "/" + std::to_string(count);
      const std::string out = std::to_string(count) + "/" + std::to_string(number);
      expect_done({"run", "wall.json", "--shard", shard, "--out", out});
      EXPECT_TRUE(canonical_results(path(out)).empty());
      merge.push_back(out);
    }
    const std::string all = std::to_string(count) + "/all";
    merge.insert(merge.end(), {"--out", all});
    EXPECT_TRUE(expect_done(merge).out.starts_with("56 trials of 7 participants at the canon"));
    EXPECT_EQ(canonical_results(path(all)), reference()) << count;
  }
}

TEST_F(CanonicalCommandTest, AKilledShardGoesOnToTheSameBytes) {
  for (int attempt = 1;; ++attempt) {
    fs::remove_all(path("killed"));
    const StartedProgram started = start_program(
        folder, {"experiment", "run", "wall.json", "--shard", "1/2", "--out", "killed"});
    siginfo_t ended{};
    while (!fs::exists(path("killed/parts/participant-1.csv")) && ended.si_pid == 0) {
      ::usleep(200);
      ::waitid(P_PID, static_cast<id_t>(started.process), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
    ::kill(started.process, SIGKILL);
    const Outcome killed = outcome_of(started);
    if (killed.exit_code == -1) break;
    ASSERT_LT(attempt, 20) << "the run ended before the signal came";
  }
  EXPECT_FALSE(fs::exists(path("killed/parts/participant-7.csv")));
  const Outcome o = expect_done({"run", "wall.json", "--shard", "1/2", "--out", "killed"});
  EXPECT_TRUE(o.out.starts_with("kept participant")) << o.out;
  expect_done({"run", "wall.json", "--shard", "2/2", "--out", "other"});
  expect_done({"merge", "other", "killed", "--out", "all"});
  EXPECT_EQ(canonical_results(path("all")), reference());
}

TEST_F(CanonicalCommandTest, PlanWritesAPlanThatRunAccepts) {
  const Outcome o = expect_done({"plan", "canonical"});
  EXPECT_TRUE(o.out.starts_with("canonical.json\nrun it: ")) << o.out;
  for (const char* const plan : {"canonical.json", "canonical"}) {
    EXPECT_EQ(expect_done({"run", plan, "--shard", "10000/10000", "--out", "none"}).out,
              "shard 10000/10000 has no participant\n");
  }
  expect_refused({"plan", "canonical"}, {"canonical.json: exists already"});
}

TEST_F(CanonicalCommandTest, AnalyseRefusesCanonicalRowsByName) {
  folder.write("rows.csv", reference().at("canonical.csv"));
  folder.write("saved.csv", "\xEF\xBB\xBF" + reference().at("canonical.csv"));
  for (const char* const name : {"rows.csv", "saved.csv"}) {
    expect_refused({"analyse", name},
                   {std::string(name) + ": line 1: has the columns of canonical.csv; expected",
                    "trials.csv", "canonical.html"});
  }
  expect_refused({"power", "--pilot", "rows.csv"},
                 {"rows.csv: line 1: has the columns of canonical.csv; expected"});
  EXPECT_FALSE(fs::exists(path("analysis")));
  EXPECT_FALSE(fs::exists(path("power")));
  // A folder has no trials either; the hint names what it has.
  fs::create_directory(path("wall"));
  folder.write("wall/canonical.csv", reference().at("canonical.csv"));
  expect_refused({"analyse", "wall"}, {"wall: ", "wall/canonical.html has the analysis"});
}

TEST_F(CanonicalCommandTest, BrokenPlansAreRefusedAndNothingIsWritten) {
  const std::vector<std::pair<Json, std::vector<std::string>>> changes = {
      {{{"protocol", "canonic"}}, {"/protocol: is \"canonic\"; expected canonical"}},
      {{{"protocol", 1}}, {"/protocol: is 1; expected canonical"}},
      {{{"objects", {{"O1", "star.glb"}}}}, {"/objects: is not a known key"}},
      {{{"haptic", {"UaH"}}}, {"/haptic: is not a known key"}},
      {{{"followings", {"delayed"}}}, {"/followings: is not a known key"}},
      {{{"participants", 0}}, {"/participants: is 0"}},
      {{{"angles_deg", {0, 91}}}, {"/angles_deg/1: is 91"}},
      {{{"angles_deg", {15, 0}}}, {"/angles_deg/1: is 0 after 15"}},
      {{{"angles_deg", Json::array()}}, {"/angles_deg: is a list of 0"}},
      {{{"display_Hz", 1001}}, {"/display_Hz: is 1001"}},
      {{{"display_Hz", 1e-310}}, {"/display_Hz: is 1e-310; expected at least 0.333"}},
      {{{"operator", "nobody"}}, {"/operator: is \"nobody\""}},
      {{{"seed", 0.5}}, {"/seed: is 0.5"}},
      {{{"device", nullptr}}, {"/device: is null"}},
      {{{"name", ""}}, {"/name: "}},
  };
  for (const auto& [change, parts] : changes) {
    SCOPED_TRACE(change.dump());
    Json plan = wall_plan();
    plan.update(change);
    folder.write("wall.json", plan.dump());
    std::vector<std::string> all = parts;
    all.emplace_back("wall.json: ");
    expect_refused({"run", "wall.json", "--out", "out"}, all);
    EXPECT_FALSE(fs::exists(path("out")));
  }
  // An error of the device that only the simulated hand shows.
  Json plan = wall_plan();
  plan["device"]["device_damping_Ns_per_m"] = 1e5;
  folder.write("wall.json", plan.dump());
  expect_refused({"run", "wall.json", "--out", "out"},
                 {"wall.json: /device/device_damping_Ns_per_m: "});
  folder.write("wall.json", "{\"protocol\": \"canonical\",");
  expect_refused({"run", "wall.json", "--out", "out"}, {"wall.json: "});
  folder.write("wall.json", wall_plan().dump());
  expect_refused({"run", "wall.json", "--traces", "--out", "out"}, {"--traces: "});
  EXPECT_FALSE(fs::exists(path("out")));
}

TEST_F(CanonicalCommandTest, ShardsOfAnotherPlanAreNotMerged) {
  expect_done({"run", "wall.json", "--shard", "1/2", "--out", "one"});
  Json other = wall_plan();
  other["seed"] = 6;
  folder.write("other.json", other.dump());
  expect_done({"run", "other.json", "--shard", "2/2", "--out", "two"});
  expect_refused({"merge", "one", "two", "--out", "all"},
                 {"two/parts/run.json: /plan/hash: is ", "as in one/parts/run.json"});
  EXPECT_FALSE(fs::exists(path("all")));
}

// A plan with one trial at the star.
Json star_plan() {
  Json star = Json::parse(R"({"palpate_plan": 1, "name": "short", "seed": 1, "participants": 1,
      "blocks": 1, "practice_blocks": 0, "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000,
      "stiffness_N_per_m": 1000, "damping_Ns_per_m": 2}, "display_Hz": 40, "sphere_radius_m": 0.006,
      "limit_s": 1, "haptic": ["H"], "rotation": ["R"], "objects": {}, "operator": "literature",
      "followings": ["delayed"]})");
  star["objects"]["O1"] = PALPATE_MODELS_DIR "/star.glb";
  return star;
}

TEST_F(CanonicalCommandTest, ResultsOfTheOtherProtocolInTheFolderAreReplaced) {
  folder.write("star.json", star_plan().dump());
  expect_done({"run", "star.json", "--out", "out", "--traces"});
  EXPECT_TRUE(fs::exists(path("out/trials.csv")));
  const std::string trace = path("out/traces/delayed/participant-1/block-1-trial-1-H-R-O1.csv");
  EXPECT_TRUE(fs::exists(trace));
  folder.write("out/traces/delayed/notes.txt", "mine");
  expect_done({"run", "wall.json", "--out", "out"});
  EXPECT_EQ(canonical_results(path("out")), reference());
  EXPECT_FALSE(fs::exists(path("out/trials.csv")));
  EXPECT_FALSE(fs::exists(trace));
  EXPECT_TRUE(fs::exists(path("out/traces/delayed/notes.txt")));
  // The report of an analysis in the folder of an experiment stays.
  folder.write("out/report.html", "analysis");
  folder.write("out/canonical.html", "page");
  expect_done({"run", "star.json", "--out", "out"});
  EXPECT_TRUE(fs::exists(path("out/trials.csv")));
  EXPECT_FALSE(fs::exists(path("out/canonical.csv")));
  EXPECT_FALSE(fs::exists(path("out/canonical.html")));
  EXPECT_EQ(content_of(path("out/report.html")), "analysis");
}

TEST_F(CanonicalCommandTest, WhatHasTheNameOfTheOtherProtocolsResultButIsNoneStays) {
  fs::create_directories(path("one/trials.csv"));
  expect_done({"run", "wall.json", "--out", "one"});
  EXPECT_EQ(canonical_results(path("one")), reference());
  EXPECT_TRUE(fs::is_directory(path("one/trials.csv")));
  fs::create_directories(path("two"));
  ASSERT_EQ(::mkfifo(path("two/trials.csv").c_str(), 0600), 0);
  expect_done({"run", "wall.json", "--out", "two"});
  EXPECT_TRUE(fs::is_fifo(path("two/trials.csv")));
  // The trials of people are no results of this program.
  fs::create_directories(path("three"));
  folder.write("three/trials.csv", "participant,total_time_s\n");
  expect_done({"run", "wall.json", "--out", "three"});
  EXPECT_EQ(content_of(path("three/trials.csv")), "participant,total_time_s\n");
}

TEST_F(CanonicalCommandTest, AShardLeavesTheResultsOfAnExperimentUntilTheMerge) {
  folder.write("star.json", star_plan().dump());
  expect_done({"run", "star.json", "--out", "out"});
  const std::string trials = content_of(path("out/trials.csv"));
  expect_done({"run", "wall.json", "--shard", "1/2", "--out", "out"});
  EXPECT_EQ(content_of(path("out/trials.csv")), trials);
  expect_done({"run", "wall.json", "--shard", "2/2", "--out", "out"});
  expect_done({"merge", "out", "--out", "out"});
  EXPECT_FALSE(fs::exists(path("out/trials.csv")));
  EXPECT_EQ(canonical_results(path("out")), reference());
}

TEST_F(CanonicalCommandTest, AWallAndAnExperimentAreNotMerged) {
  folder.write("star.json", star_plan().dump());
  expect_done({"run", "star.json", "--out", "star"});
  expect_done({"run", "wall.json", "--shard", "1/2", "--out", "one"});
  expect_refused({"merge", "one", "star", "--out", "all"},
                 {"star/parts/run.json: /kind: is of an experiment; expected a canonical wall, as "
                  "in one/parts/run.json"});
  expect_refused({"merge", "star", "one", "--out", "all"},
                 {"one/parts/run.json: /kind: is of a canonical wall; expected an experiment"});
  EXPECT_FALSE(fs::exists(path("all")));
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++count;
  return count;
}

TEST_F(CanonicalCommandTest, ThePageComesWithTheMeasuredFiles) {
  test::EnvironmentVariable any_python("PALPATE_PYTHON", "");
  const Outcome o = expect_done({"run", "wall.json", "--out", "out"});
  EXPECT_EQ(o.err, "");
  EXPECT_EQ(o.out,
            "56 trials of 7 participants at the canonical wall\n"
            "canonical.csv, columns.csv, canonical.html and run.json are in out/\n");
  EXPECT_EQ(canonical_results(path("out")), reference());
  // The figures are drawn, the ratio and the share for each motion.
  const std::string page = content_of(path("out/canonical.html"));
  EXPECT_EQ(count_of(page, "<svg "), 4u);
  // A merge of shards, in any order, gives the same page.
  expect_done({"run", "wall.json", "--shard", "2/2", "--out", "two"});
  expect_done({"run", "wall.json", "--shard", "1/2", "--out", "one"});
  EXPECT_EQ(expect_done({"merge", "one", "two", "--out", "all"}).err, "");
  EXPECT_EQ(content_of(path("all/canonical.html")), page);
}

TEST_F(CanonicalCommandTest, WarningsOfThePageArePrinted) {
  test::EnvironmentVariable any_python("PALPATE_PYTHON", "");
  Json plan = wall_plan();
  plan["participants"] = 2;
  plan["device"]["stiffness_N_per_m"] = 0;
  plan["device"]["damping_Ns_per_m"] = 0;
  folder.write("wall.json", plan.dump());
  const Outcome o = call({"run", "wall.json", "--out", "out"});
  EXPECT_EQ(o.exit_code, 0);
  EXPECT_EQ(o.err,
            "palpate: warning: no trial has a force into the hand, so that there is no ratio\n");
  EXPECT_EQ(count_of(content_of(path("out/canonical.html")), "<svg "), 2u);  // of the share
}

// A page that no Python could make is not taken for one of the new results.
TEST_F(CanonicalCommandTest, AFormerPageDoesNotStayBesideOtherResults) {
  fs::create_directory(path("out"));
  folder.write("out/canonical.html", "former");
  expect_done({"run", "wall.json", "--out", "out"});
  EXPECT_FALSE(fs::exists(path("out/canonical.html")));
}

}  // namespace
}  // namespace palpate
