// `palpate experiment` as a user or a script runs it: plan, run and merge.

#include <algorithm>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <sys/file.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using test::content_of;
using test::FileSizeLimit;
using test::Outcome;
using test::StartedProgram;
using test::TemporaryFolder;

using Arguments = std::vector<std::string>;
using Contents = std::map<std::string, std::string>;  // of files, by their path

constexpr int kPersons = 3;
constexpr int kTrialsOfAPerson = 2 * 2;  // levels of haptic and rotation

// A plan for a small star, which a hand follows in some seconds.
Json star_plan() {
  Json plan = Json::parse(R"({"palpate_plan": 1, "name": "small star", "seed": 11,
      "participants": 3, "blocks": 1, "practice_blocks": 0,
      "device": {"sensors": 2, "actuators": 1, "rate_Hz": 1000, "stiffness_N_per_m": 1000,
                 "damping_Ns_per_m": 2},
      "display_Hz": 40, "sphere_radius_m": 0.006, "limit_s": 120,
      "haptic": ["NoH", "H"], "rotation": ["NoR", "R"], "objects": {},
      "operator": "literature", "followings": ["delayed"]})");
  plan["objects"]["O1"] = {{"file", PALPATE_MODELS_DIR "/star.glb"}, {"scale", 0.5}};
  return plan;
}

Contents contents_of(const std::string& folder) {
  Contents contents;
  if (!fs::exists(folder)) return contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    contents[name] = entry.is_regular_file() ? content_of(entry.path().string()) : "";
  }
  return contents;
}

// The results in a folder of an experiment, without the parts and the log.
Contents results_of(const std::string& folder) {
  Contents results;
  for (const char* const name : {"trials.csv", "columns.csv", "run.json"}) {
    const std::string path = (fs::path(folder) / name).string();
    if (fs::exists(path)) results[name] = content_of(path);
  }
  return results;
}

class ExperimentCommandTest : public testing::Test {
 protected:
  ExperimentCommandTest() { folder.write("plan.json", star_plan().dump()); }

  static Arguments experiment(const Arguments& more) {
    Arguments arguments{"experiment"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  Outcome call(const Arguments& more) const { return run_program(folder, experiment(more)); }

  Outcome expect_done(const Arguments& more) const {
    const Outcome o = call(more);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    EXPECT_EQ(o.err, "");
    return o;
  }

  // Code 2, nothing on stdout, and one line on stderr with all of `parts`.
  void expect_refused(const Arguments& more, const std::vector<std::string>& parts) const {
    std::string line;
    for (const std::string& argument : more) line += argument + " ";
    SCOPED_TRACE(line);
    const Outcome o = call(more);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_TRUE(o.err.starts_with("palpate: ") && o.err.ends_with("\n")) << o.err;
    for (const std::string& part : parts) EXPECT_NE(o.err.find(part), std::string::npos) << o.err;
  }

  std::string path(const std::string& name) const { return folder.path(name); }
  Contents results(const std::string& name) const { return results_of(folder.path(name)); }

  // Runs the plan with one job, and sends a signal as soon as the first person is complete. out: a
  // new folder. A run that had ended before the signal came is repeated in another folder.
  Outcome interrupted(std::string& out, int signal) const {
    for (int attempt = 1;; ++attempt) {
      out = "interrupted-" + std::to_string(attempt);
      const fs::path first = fs::path(folder.path(out)) / "parts" / "participant-1.csv";
      const StartedProgram started =
          start_program(folder, experiment({"run", "plan.json", "--jobs", "1", "--out", out}));
      siginfo_t ended{};
      while (!fs::exists(first) && ended.si_pid == 0) {
        ::usleep(200);
        ::waitid(P_PID, static_cast<id_t>(started.process), &ended, WEXITED | WNOHANG | WNOWAIT);
      }
      ::kill(started.process, signal);
      const Outcome outcome = outcome_of(started);
      if (!fs::exists(path(out + "/trials.csv")) || attempt == 20) return outcome;
    }
  }

  // The results of one undisturbed run of star_plan().
  static const Contents& reference() {
    static const Contents results = [] {
      const TemporaryFolder own;
      own.write("plan.json", star_plan().dump());
      const Outcome o = run_program(own, {"experiment", "run", "plan.json", "--jobs", "1"});
      EXPECT_EQ(o.exit_code, 0) << o.err;
      return results_of(own.path("experiment"));
    }();
    return results;
  }

  TemporaryFolder folder;
};

TEST_F(ExperimentCommandTest, BeginsTheHelpOfEverySubcommandWithExamples) {
  for (const char* const name : {"plan", "run", "merge", "analyse", "power"}) {
    const Outcome o = expect_done({name, "--help"});
    EXPECT_TRUE(o.out.starts_with("Example:\n  ./run.sh experiment ")) << o.out;
    const std::string own = std::string("  ./run.sh experiment ") + name + " ";
    EXPECT_LT(o.out.find(own), o.out.find("\n\n")) << o.out;
    EXPECT_NE(o.out.find("Exit codes: 0; "), std::string::npos) << o.out;
  }
}

TEST_F(ExperimentCommandTest, RefusesUnknownSubcommandsAndBadArguments) {
  const Contents before = contents_of(path(""));
  expect_refused({}, {"subcommand is required; expected plan, run, sweep, merge, analyse, power, "
                      "export, live or forget",
                      "experiment --help"});
  expect_refused({"walk"}, {"walk: is not a subcommand of experiment; expected plan, run, sweep, "
                            "merge, analyse, power, export, live or forget"});
  expect_refused({"--out", "x"}, {"--out: is not an option of experiment; expected plan, run, "
                                  "sweep, merge, analyse, power, export, live or forget"});
  expect_refused({"run"}, {"PLAN", "experiment run --help"});
  expect_refused({"run", "plan.json", "other.json"},
                 {"other.json: is an unexpected argument of run"});
  expect_refused({"plan"}, {"NAME"});
  expect_refused({"plan", "people"}, {"NAME", "is \"people\"; expected paper"});
  expect_refused({"merge"}, {"DIR"});
  for (const char* const shard : {"0/2", "3/2", "1", "1/0", "/", "1/", "/2", "-1/2", "1/2/3", "a/b",
                                  "1.0/2", "1/10001", "1 /2", "99999999999999999999/1"}) {
    expect_refused({"run", "plan.json", "--shard", shard},
                   {std::string("--shard: is \"") + shard + "\"; expected i/n with 1 <= i <= n <= ",
                    "--shard 1/4"});
  }
  for (const char* const jobs : {"0", "-1", "1025", "two", "1.5", "1e3", "99999999999999999999"}) {
    expect_refused({"run", "plan.json", "--jobs", jobs},
                   {"--jobs", "expected a whole number from 1 to 1024"});
  }
  expect_refused({"run", "missing.json"}, {"missing.json: ", "cannot be opened"});
  Contents after = contents_of(path(""));
  after.erase("stdout");
  after.erase("stderr");
  EXPECT_EQ(after, before);
}

TEST_F(ExperimentCommandTest, PlanWritesAPlanThatRunAcceptsFromAnyFolder) {
  fs::create_directories(path("deep/er"));
  fs::create_directory_symlink(path("deep/er"), path("link"));
  for (const char* const name : {"paper.json", "deep/er/my plan.json", "link/other.json"}) {
    SCOPED_TRACE(name);
    const Outcome o = expect_done({"plan", "paper", "--out", name});
    EXPECT_TRUE(o.out.starts_with(std::string(name) + "\nrun it: ")) << o.out;
    // A shard without participants reads the plan and all its scenes, but runs no trial.
    const Outcome run = expect_done({"run", name, "--shard", "10000/10000", "--out", "out"});
    EXPECT_EQ(run.out, "shard 10000/10000 has no participant\n");
  }
  EXPECT_EQ(content_of(path("link/other.json")), content_of(path("deep/er/other.json")));
  EXPECT_EQ(Json::parse(content_of(path("paper.json")))["seed"], 2005);
  EXPECT_FALSE(fs::exists(path("out/trials.csv")));
}

TEST_F(ExperimentCommandTest, PlanWritesNothingOverAnExistingFile) {
  folder.write("mine.json", "mine");
  fs::create_symlink("nowhere", path("dangling.json"));
  fs::create_directory(path("taken.json"));
  for (const char* const name : {"mine.json", "dangling.json", "taken.json"}) {
    expect_refused({"plan", "paper", "--out", name},
                   {std::string(name) + ": ", "exists already", "--out"});
  }
  EXPECT_EQ(content_of(path("mine.json")), "mine");
  EXPECT_FALSE(fs::exists(path("nowhere")));
  expect_refused({"plan", "paper", "--out", "no/such/plan.json"},
                 {"no/such/plan.json: cannot be written"});
  EXPECT_FALSE(fs::exists(path("no")));
}

TEST_F(ExperimentCommandTest, RunWritesRealTrialsIntoItsFolderOnly) {
  const Contents before = contents_of(path(""));
  const Outcome o = expect_done({"run", "plan.json", "--jobs", "2", "--out", "new/er"});
  std::smatch counts;
  ASSERT_TRUE(std::regex_match(
      o.out, counts,
      std::regex("12 trials of 3 participants: (\\d+) done, (\\d+) timeout, (\\d+) fault\n"
                 "trials.csv, columns.csv and run.json are in new/er/\n")))
      << o.out;
  EXPECT_EQ(results("new/er"), reference());
  const std::string trials = content_of(path("new/er/trials.csv"));
  EXPECT_EQ(std::count(trials.begin(), trials.end(), '\n'), 1 + kPersons * kTrialsOfAPerson);
  for (const char* const status : {"done", "timeout", "fault"}) {
    const auto place = static_cast<std::size_t>(status[0] == 'd' ? 1 : status[0] == 't' ? 2 : 3);
    std::size_t rows = 0;
    for (std::size_t at = 0;
         (at = trials.find(std::string(",") + status + ",", at)) != std::string::npos; ++at) {
      ++rows;
    }
    EXPECT_EQ(std::to_string(rows), counts.str(place)) << status;
  }
  EXPECT_GE(std::stoi(counts.str(1)), kPersons * kTrialsOfAPerson / 2) << "few trials end";
  Contents after = contents_of(path(""));
  for (const char* const name :
       {"stdout", "stderr", "new", "new/er", "new/er/trials.csv", "new/er/columns.csv",
        "new/er/run.json", "new/er/run.log", "new/er/parts", "new/er/parts/run.json",
        "new/er/parts/participant-1.csv", "new/er/parts/participant-2.csv",
        "new/er/parts/participant-3.csv"}) {
    EXPECT_EQ(after.erase(name), 1u) << name;
  }
  EXPECT_EQ(after, before);
}

TEST_F(ExperimentCommandTest, ShardsInAnyOrderMergeToTheSameBytes) {
  for (const std::vector<int>& order :
       {std::vector<int>{1}, {2, 1}, {1, 2}, {3, 1, 2}, {2, 3, 1}}) {
    const std::string count = std::to_string(order.size());
    const std::string base = "shards-" + count + "-" + std::to_string(order.front());
    Arguments merge{"merge"};
    for (const int number : order) {
      const std::string shard = std::to_string(number) + "/" + count;
      const std::string out = base + "/" + std::to_string(number);
      const Outcome o = expect_done({"run", "plan.json", "--shard", shard, "--out", out});
      EXPECT_TRUE(o.out.starts_with("shard " + shard + " is complete in " + out + "/parts\n"))
          << o.out;
      EXPECT_TRUE(results(out).empty());
      merge.push_back(out);
    }
    merge.insert(merge.end(), {"--out", base + "/all"});
    EXPECT_TRUE(expect_done(merge).out.starts_with("12 trials of 3 participants: "));
    EXPECT_EQ(results(base + "/all"), reference()) << base;
  }
}

TEST_F(ExperimentCommandTest, MergeNamesWhatIsMissing) {
  expect_done({"run", "plan.json", "--shard", "1/3", "--out", "one"});
  const Contents before = contents_of(path("one"));
  expect_refused({"merge", "one", "nowhere", "--out", "all"},
                 {"nowhere: has no parts/run.json; expected the folder of `experiment run --out`"});
  expect_refused({"merge", "one", "--out", "all"},
                 {"one: lacks participants 2 and 3 of 3", "run their shards"});
  expect_refused({"merge", "one"}, {"one: lacks participants 2 and 3 of 3"});
  EXPECT_FALSE(fs::exists(path("all")));
  EXPECT_FALSE(fs::exists(path("experiment")));
  EXPECT_EQ(contents_of(path("one")), before);
}

TEST_F(ExperimentCommandTest, AKilledRunGoesOnToTheSameBytes) {
  std::string out;
  const Outcome killed = interrupted(out, SIGKILL);
  EXPECT_EQ(killed.exit_code, -1);
  EXPECT_EQ(killed.out, "");
  EXPECT_TRUE(results(out).empty());
  const Outcome o = expect_done({"run", "plan.json", "--jobs", "2", "--out", out});
  EXPECT_TRUE(
      std::regex_search(o.out, std::regex("^kept participants? 1( and 2|, 2 and 3)?, complete in " +
                                          out + "/parts from an earlier run of this plan\n")))
      << o.out;
  EXPECT_EQ(results(out), reference());
}

TEST_F(ExperimentCommandTest, AnInterruptedRunTellsHowToGoOn) {
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
    SCOPED_TRACE(signal);
    std::string out;
    const Outcome o = interrupted(out, signal);
    EXPECT_EQ(o.exit_code, code);
    EXPECT_EQ(o.out, "");
    EXPECT_TRUE(std::regex_match(
        o.err, std::regex("palpate: interrupted; [12] of 3 participants are complete in " + out +
                          "/parts(, 1 trial of an incomplete participant is kept there|, [2-3] "
                          "trials of incomplete participants are kept there)?, and the same "
                          "command goes on from there\n")))
        << o.err;
    EXPECT_TRUE(results(out).empty());
    expect_done({"run", "plan.json", "--jobs", "1", "--out", out});
    EXPECT_EQ(results(out), reference());
    fs::remove_all(path(out));
  }
}

TEST_F(ExperimentCommandTest, AFullDiskIsRefusedAndTheSameCommandGoesOn) {
  expect_done({"run", "plan.json", "--out", "measured"});
  const auto size = [&](const std::string& name) {
    return fs::file_size(path("measured/" + name));
  };
  const auto part = size("parts/participant-1.csv");
  ASSERT_LT(size("parts/run.json"), part / 2);
  ASSERT_LT(3 * part / 2, size("trials.csv"));
  // No part is written; or all parts, but not the results.
  for (const auto& [bytes, name, kept] : {std::tuple(part / 2, "/parts/participant-", 0),
                                          std::tuple(3 * part / 2, "/trials.csv", 3)}) {
    SCOPED_TRACE(bytes);
    const std::string out = "full-" + std::to_string(bytes);
    const Arguments run{"run", "plan.json", "--jobs", "2", "--out", out};
    {
      const FileSizeLimit limit(bytes);
      expect_refused(run, {out + name, "cannot be written: File too large", "free disk space"});
    }
    EXPECT_TRUE(results(out).empty());
    for (const auto& [file, text] : contents_of(path(out))) {
      EXPECT_FALSE(file.ends_with(".part") || file.starts_with(".")) << file;
    }
    const Outcome o = expect_done(run);
    EXPECT_EQ(o.out.starts_with("kept participants 1, 2 and 3, complete in "), kept == 3) << o.out;
    EXPECT_EQ(results(out), reference());
  }
}

void expect_one_error(const Outcome& o, const std::string& part) {
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  EXPECT_NE(o.err.find(part), std::string::npos) << o.err;
}

TEST_F(ExperimentCommandTest, EveryCommandIsRefusedInAFolderThatAnotherOneHas) {
  folder.write("way.txt", "0 0 0.1\n0 0 0.099\n");
  expect_done({"run", "plan.json", "--out", "before"});
  fs::create_directory(path("out"));
  const int held = ::open(path("out").c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(::flock(held, LOCK_EX | LOCK_NB), 0);
  for (const Arguments& arguments :
       {Arguments{"run", "plan.json"}, Arguments{"run", "plan.json", "--shard", "1/2"},
        Arguments{"run", "canonical"}, Arguments{"sweep", "sweep"}, Arguments{"merge", "before"},
        Arguments{"analyse", "before/trials.csv"}, Arguments{"power"}}) {
    Arguments more = arguments;
    more.insert(more.end(), {"--out", "out"});
    expect_refused(more, {"out: ", "--out", "is in use", "choose another folder"});
  }
  const std::string star = PALPATE_MODELS_DIR "/star.glb";
  for (const Arguments& arguments :
       {Arguments{"run", star, "--virtual"}, Arguments{"soak", star}, Arguments{"compare", star},
        Arguments{"accuracy", "--quick", "--knob", "a4_step"}}) {
    Arguments more = arguments;
    more.insert(more.end(), {"--out", "out"});
    const Outcome o = run_program(folder, more);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_NE(o.err.find("is in use"), std::string::npos) << o.err;
  }
  EXPECT_TRUE(contents_of(path("out")).empty());
  fs::create_directories(path("compared/trials"));
  const int trials = ::open(path("compared/trials").c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(::flock(trials, LOCK_EX | LOCK_NB), 0);
  const Outcome o = run_program(folder, {"compare", star, "--out", "compared"});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_NE(o.err.find("is in use"), std::string::npos) << o.err;
  // One file in such a folder, and a folder inside the folder of a run.
  expect_one_error(
      run_program(folder, {"replay", star, "--trajectory", "way.txt", "--out", "out/trace.csv"}),
      "out: is in use");
  fs::create_directories(path("run/parts"));
  const int parts = ::open(path("run/parts").c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(::flock(parts, LOCK_EX | LOCK_NB), 0);
  expect_one_error(run_program(folder, {"experiment", "run", "plan.json", "--out", "run"}),
                   "run/parts: --out: is in use");
  ::close(held);
  ::close(trials);
  ::close(parts);
  expect_done({"run", "plan.json", "--out", "out"});
  EXPECT_EQ(results("out"), reference());
}

TEST_F(ExperimentCommandTest, AnotherPlanInTheFolderReplacesTheResults) {
  Json other = star_plan();
  other["participants"] = kPersons + 2;
  other["haptic"] = {"H"};
  other["limit_s"] = 1;
  folder.write("other.json", other.dump());
  expect_done({"run", "other.json", "--out", "out"});
  EXPECT_NE(results("out"), reference());
  expect_done({"run", "plan.json", "--out", "out"});
  EXPECT_EQ(results("out"), reference());
  EXPECT_FALSE(fs::exists(path("out/parts/participant-5.csv")));
}

}  // namespace
}  // namespace palpate
