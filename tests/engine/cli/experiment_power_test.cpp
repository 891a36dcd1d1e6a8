// `palpate experiment power` as a user or a script runs it.

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>
#include <set>
#include <string>
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
using test::TemporaryFolder;

using Arguments = std::vector<std::string>;

constexpr const char* kHead =
    "following,participant,block,haptic,rotation,object,status,total_time_s\n";
const char* const kNames[] = {"report.html", "power.json", "needed_people.csv", "power.csv"};

// A line of a file of trials.
struct PilotLine {
  std::string following;
  int person, block;
  std::string haptic, rotation, object, status;
  double time_s;
};

// Three persons, two objects, two blocks, and practice. The times are numbers of a formula without
// any pattern that a model could explain.
std::vector<PilotLine> pilot_lines(const std::string& following = "") {
  std::vector<PilotLine> lines;
  unsigned state = 1;
  for (int person = 1; person <= 3; ++person) {
    for (int block = 0; block <= 2; ++block) {
      for (const char* const haptic : {"NoH", "UaH", "H"}) {
        for (const char* const rotation : {"NoR", "R"}) {
          for (const char* const object : {"O1", "O2"}) {
            state = state * 1664525u + 1013904223u;
            lines.push_back({following, person, block, haptic, rotation, object, "done",
                             20.0 + 4.0 * person + (state >> 24) / 32.0});
          }
        }
      }
    }
  }
  return lines;
}

std::string pilot_csv(const std::vector<PilotLine>& lines) {
  std::string text = kHead;
  for (const PilotLine& line : lines) {
    text += line.following + ",P" + std::to_string(line.person) + "," + std::to_string(line.block) +
            "," + line.haptic + "," + line.rotation + "," + line.object + "," + line.status + "," +
            (line.status == "done" ? std::to_string(line.time_s) : "") + "\n";
  }
  return text;
}

class ExperimentPowerTest : public testing::Test {
 protected:
  ExperimentPowerTest() { folder.write("pilot.csv", pilot_csv(pilot_lines())); }

  test::Outcome call(const Arguments& more) const {
    Arguments arguments{"experiment", "power"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(folder, arguments);
  }
  // Few data sets.
  test::Outcome quick(const Arguments& more) const {
    Arguments arguments{"--sets", "200", "--participants", "12"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  }

  std::set<std::string> names_in_folder() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path(""))) {
      names.insert(entry.path().string());
    }
    return names;
  }

  // Code 2, nothing on stdout, one line on stderr with all of `parts`, and no new file.
  void expect_refused(const Arguments& arguments, const std::vector<std::string>& parts) const {
    std::string line;
    for (const std::string& argument : arguments) line += argument + " ";
    SCOPED_TRACE(line);
    call({"--help"});  // so that stdout and stderr are there before
    const auto before = names_in_folder();
    const test::Outcome o = call(arguments);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_TRUE(o.err.starts_with("palpate: ") && o.err.ends_with("\n")) << o.err;
    for (const std::string& part : parts) EXPECT_NE(o.err.find(part), std::string::npos) << o.err;
    EXPECT_EQ(names_in_folder(), before);
  }
  std::map<std::string, std::string> results(const std::string& out) const {
    std::map<std::string, std::string> contents;
    for (const char* const name : kNames)
      contents[name] = content_of(folder.path(out + "/" + name));
    return contents;
  }

  TemporaryFolder folder;
};

TEST_F(ExperimentPowerTest, AnswersWithoutOptionsAndNamesAssumptions) {
  const test::Outcome o = quick({});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(o.err, "");
  for (const char* const part :
       {"8.98 s (paper, F of Haptic; ", ", 9.88 s (paper, F of Rotation; ",
        "u 0.1 to 0.8, w 0.1 to 0.8", "Haptic, Greenhouse-Geisser", "no effect", "H - UaH, Holm",
        "data sets: 200, seed 2005", "note: The model is normal, and the measure is a time",
        "is an assumption",
        " people for total time: each effect of the assumed means (Haptic by "
        "Greenhouse-Geisser, Rotation) then has a power of at least 0.8, if one trial has an error "
        "of "
        "9.88 s with the shares u 0.3 and w 0.1, which are a choice, and a person does 12 trials "
        "in a "
        "condition. Over all 72 assumptions: ",
        "report.html, power.json and 2 tables are in power/\n"}) {
    EXPECT_NE(o.out.find(part), std::string::npos) << part << "\n" << o.out;
  }
  for (const auto& [name, text] : results("power")) EXPECT_FALSE(text.empty()) << name;
  const Json json = Json::parse(content_of(folder.path("power/power.json")));
  EXPECT_EQ(json["assumptions"].size(), 72u);
  EXPECT_EQ(json["assumptions"][0]["tests"][0]["significant"].size(), 11u);  // 2 to 12 people
  EXPECT_EQ(json["settings"]["data_sets"], 200);
}

TEST_F(ExperimentPowerTest, WritesTheSameBytesForAnyJobsAndOthersForAnotherSeed) {
  const auto run = [&](const std::string& out, const Arguments& more) {
    Arguments arguments{"--pilot", "pilot.csv", "--out", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const test::Outcome o = quick(arguments);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return results(out);
  };
  const auto one = run("one", {"--jobs", "1"});
  EXPECT_EQ(run("two", {"--jobs", "2"}), one);
  EXPECT_EQ(run("one", {"--jobs", "7"}), one);
  const auto other = run("other", {"--jobs", "2", "--seed", "1"});
  for (const char* const name : {"power.json", "power.csv", "report.html"}) {
    EXPECT_NE(other.at(name), one.at(name)) << name;
  }
}

TEST_F(ExperimentPowerTest, NeverReplacesThePilot) {
  fs::create_directory(folder.path("out"));
  const std::string text = pilot_csv(pilot_lines());
  for (const char* const name : {"needed_people.csv", "power.csv"}) {
    const std::string path = std::string("out/") + name;
    folder.write(path, text);
    fs::create_symlink(folder.path(path), folder.path("link.csv"));
    for (const std::string& pilot : {path, std::string("link.csv"), "out/../" + path}) {
      expect_refused({"--pilot", pilot, "--out", "out"},
                     {path + ": is the same file as the input " + pilot, "choose another"});
    }
    fs::remove(folder.path("link.csv"));
    fs::remove(folder.path(path));
  }
  // People's trials under the name that the table had before.
  folder.write("out/people.csv", text);
  const test::Outcome o = quick({"--pilot", "out/people.csv", "--out", "out"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(content_of(folder.path("out/people.csv")), text);
}

// A million data sets would take minutes.
TEST_F(ExperimentPowerTest, RefusesAFolderThatCannotBeWrittenBeforeItSimulates) {
  folder.write("file", "");
  expect_refused({"--sets", "1000000", "--participants", "200", "--out", "file/out"}, {"file"});
}

// What one option tells is checked here; the rest by palpate.analysis.power, whose lines are those
// of tests/engine/python/power_report_test.py.
TEST_F(ExperimentPowerTest, RefusesBadOptionsInOneLine) {
  for (const char* const sd : {"0", "-1", "nan", "ten", "1e10"}) {
    expect_refused({"--error", sd},
                   {"--error", "expected a finite number above 0 and at most 1e+09"});
  }
  for (const char* const share : {"-0.1", "1.1", "30%", "nan"}) {
    expect_refused({"--share-u", share}, {"--share-u", "expected a finite number from 0 to 1"});
    expect_refused({"--share-w", share}, {"--share-w", "expected a finite number from 0 to 1"});
  }
  expect_refused({"--trials", "0"}, {"--trials", "from 1 to 1000"});
  expect_refused({"--participants", "1"}, {"--participants", "from 2 to 200"});
  expect_refused({"--participants", "2-60"}, {"--participants", "from 2 to 200"});
  expect_refused({"--sets", "99"}, {"--sets", "from 100 to 1000000"});
  expect_refused({"--seed", "9007199254740992"}, {"--seed"});
  expect_refused({"--jobs", "0"}, {"--jobs", "from 1 to 1024"});
  expect_refused({"--error", "9", "--error", "8"}, {"--error: is given more than once"});
  expect_refused({"trials.csv"}, {"trials.csv: is an unexpected argument of power"});
  // By Python.
  expect_refused({"--measure", "speed"},
                 {"--measure: is \"speed\"; expected time, losses, penetration or angle"});
  expect_refused({"--effect", "--help=1"}, {"--effect: has the part \"--help=1\""});
  expect_refused({"--following", "delayed"}, {"--following: is given without --pilot"});
  expect_refused({"--share-u", "0.9999999999999999", "--share-w", "0"},
                 {"--share-u: leaves w and e a standard deviation of "});
}

TEST_F(ExperimentPowerTest, RefusesBadPilotsInOneLine) {
  expect_refused({"--pilot", "missing.csv"}, {"missing.csv: ", "cannot be opened"});
  expect_refused({"--pilot", "pilot.csv", "--error", "0.5"}, {"--error: excludes --pilot"});
  folder.write("bad.csv", pilot_csv(pilot_lines()) + ",P1,1,NoH,NoR,O1,done,7\n");
  expect_refused({"--pilot", "bad.csv"}, {"bad.csv: line ", "again"});
}

// What the program passes on.
TEST_F(ExperimentPowerTest, OptionsReachTheSimulation) {
  const test::Outcome o =
      quick({"--measure", "angle", "--effect", "UaH-NoR=49.4,UaH-R=-32.1", "--error", "12.5",
             "--share-u", "0.3", "--share-w", "0.1", "--trials", "4", "--seed", "9007199254740991",
             "--jobs", "1", "--out", "all"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  const Json settings = Json::parse(content_of(folder.path("all/power.json")))["settings"];
  EXPECT_EQ(settings["measure"], "angle");
  EXPECT_EQ(settings["effects"]["UaH-NoR"], 49.4);
  EXPECT_EQ(settings["effects"]["UaH-R"], -32.1);
  EXPECT_EQ(settings["error_sd"], 12.5);
  EXPECT_EQ(settings["share_u"], 0.3);
  EXPECT_EQ(settings["share_w"], 0.1);
  EXPECT_EQ(settings["trials_of_condition"], 4);
  EXPECT_EQ(settings["participants"], 12);
  EXPECT_EQ(settings["data_sets"], 200);
  EXPECT_EQ(settings["seed"], 9007199254740991);
  EXPECT_EQ(quick({"--pilot", "pilot.csv", "--following", "people", "--out", "all"}).exit_code, 0);
  const Json pilot = Json::parse(content_of(folder.path("all/power.json")))["pilot"];
  EXPECT_EQ(pilot["file"], "pilot.csv");
  EXPECT_EQ(pilot["following"], "people");
  EXPECT_EQ(pilot["participants"], 3);
  EXPECT_EQ(pilot["trials_of_condition"], 4.0);
}

TEST_F(ExperimentPowerTest, WritesNothingOnAFullDiskOrAfterASignal) {
  {
    const FileSizeLimit limit(2000);
    const test::Outcome o = quick({"--out", "full"});
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_NE(o.err.find("cannot be written: File too large"), std::string::npos) << o.err;
  }
  EXPECT_FALSE(fs::exists(folder.path("full")));
  // A million data sets take minutes.
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
    const test::StartedProgram started = start_program(
        folder, {"experiment", "power", "--sets", "1000000", "--jobs", "2", "--out", "stopped"});
    ::usleep(300'000);
    ::kill(started.process, signal);
    const test::Outcome o = outcome_of(started);
    EXPECT_EQ(o.exit_code, code);
    EXPECT_EQ(o.out, "");
    EXPECT_FALSE(fs::exists(folder.path("stopped")));
  }
}

}  // namespace
}  // namespace palpate
