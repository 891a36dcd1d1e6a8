// `palpate experiment power` as a user or a script runs it.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <sstream>
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

// The lines for which `keeps` is true.
std::string pilot_csv_with(const std::function<bool(const PilotLine&)>& keeps) {
  std::vector<PilotLine> lines = pilot_lines();
  std::erase_if(lines, [&](const PilotLine& line) { return !keeps(line); });
  return pilot_csv(lines);
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
  // Of a pilot with this text.
  void expect_pilot_refused(const std::string& text, std::vector<std::string> parts,
                            const Arguments& more = {}) const {
    folder.write("bad.csv", text);
    Arguments arguments{"--pilot", "bad.csv"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    parts.insert(parts.begin(), "bad.csv: ");
    expect_refused(arguments, parts);
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
        "is an assumption", "report.html, power.json and 2 tables are in power/\n"}) {
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

TEST_F(ExperimentPowerTest, PilotGivesTheVariancesAndSaysWhatItDid) {
  const test::Outcome o = quick({"--pilot", "pilot.csv", "--out", "out"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_NE(o.out.find("pilot: pilot.csv: 3 people, 72 trials, m = 4; sd of u "), std::string::npos)
      << o.out;
  const Json pilot = Json::parse(content_of(folder.path("out/power.json")))["pilot"];
  EXPECT_EQ(pilot["trials_of_condition"], 4.0);
  EXPECT_EQ(pilot["degrees_of_freedom"]["pc"], 10);
  EXPECT_EQ(pilot["degrees_of_freedom"]["e"], 36);  // 6 conditions, 3 - 1 people, 4 - 1 trials
  const double ms_pc = pilot["mean_squares"]["pc"], ms_e = pilot["mean_squares"]["e"];
  EXPECT_NEAR(pilot["estimates"]["w"].get<double>(), (ms_pc - ms_e) / 4.0, 1e-9 * ms_e);
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

TEST_F(ExperimentPowerTest, TrialsAreThoseOfThePilotUnlessGiven) {
  for (const auto& [trials, is_given] : {std::pair(4, false), std::pair(12, true)}) {
    Arguments arguments{"--pilot", "pilot.csv", "--out", "out"};
    if (is_given) arguments.insert(arguments.end(), {"--trials", "12"});
    const test::Outcome o = quick(arguments);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    EXPECT_NE(o.out.find("trials of a person in a condition: " + std::to_string(trials) + "\n"),
              std::string::npos)
        << o.out;
    EXPECT_EQ(o.out.find("and --trials is 12") != std::string::npos, is_given) << o.out;
    EXPECT_NE(o.out.find("model with m = 4\n  UaH - NoH"), std::string::npos) << o.out;
  }
}

TEST_F(ExperimentPowerTest, NamesThePapersErrorThatRoundingExcludes) {
  const test::Outcome o = quick({"--measure", "losses"});
  for (const char* const part :
       {"2.84 (paper, F of Rotation; 0 to 5.67 by", "5.41 (paper, F of Haptic; 3.54 to 7.37 by",
        "note: The error 2.84 from the F of Rotation is incompatible with the F of Haptic"}) {
    EXPECT_NE(o.out.find(part), std::string::npos) << part << "\n" << o.out;
  }
}

// A number and its bounds, from the counts in power.json: the interval of a share contains 0.8 just
// where (count / sets - 0.8)^2 <= z^2 0.8 0.2 / sets.
TEST_F(ExperimentPowerTest, SmallestNumberHasTheBoundsOfItsInterval) {
  const test::Outcome o = quick({"--measure", "angle", "--effect", "UaH-NoR=37, UaH-R=32"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_NE(o.out.find("36 combinations with the error, all with the same noise"),
            std::string::npos);
  const Json json = Json::parse(content_of(folder.path("power/power.json")));
  const Json& test = json["assumptions"][7]["tests"][0];
  EXPECT_EQ(test, json["assumptions"][30]["tests"][0]);
  const double bound = 1.959963984540054 * std::sqrt(0.8 * 0.2 / 200.0);
  int low = 0, high = 0, number = 0;
  for (int n = 12; n >= 2; --n) {
    const double above = test["significant"][n - 2].get<int>() / 200.0 - 0.8;
    if (above >= -bound && low == (n == 12 ? 0 : n + 1)) low = n;
    if (above >= 0.0 && number == (n == 12 ? 0 : n + 1)) number = n;
    if (above >= bound && high == (n == 12 ? 0 : n + 1)) high = n;
  }
  ASSERT_GT(low, 2);
  EXPECT_LT(low, number);
  EXPECT_EQ(test["people"]["0.8"], number);
  EXPECT_EQ(test["people_bounds"]["0.8"][0], low);
  EXPECT_EQ(test["people_bounds"]["0.8"][1], high == 0 ? Json(nullptr) : Json(high));
  const std::string range = std::to_string(number) + " (" + std::to_string(low) + " to " +
                            (high == 0 ? ">12" : std::to_string(high)) + ")";
  EXPECT_NE(o.out.find(range), std::string::npos) << range << "\n" << o.out;
}

// A set is a count, so that a power of 200 sets has three decimals.
TEST_F(ExperimentPowerTest, CurvesHaveExactPowersAndFewDigits) {
  EXPECT_EQ(quick({"--measure", "angle"}).exit_code, 0);
  std::istringstream lines(content_of(folder.path("power/power.csv")));
  std::string line;
  std::getline(lines, line);
  int count = 0;
  for (; std::getline(lines, line); ++count) {
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
    ASSERT_EQ(cells.size(), 12u) << line;
    EXPECT_EQ(std::stod(cells[9]), std::stoi(cells[8]) / 200.0) << line;
    EXPECT_LE(cells[9].size(), 5u) << line;
    for (const int c : {1, 2, 3, 10, 11}) {
      const std::string cell = cells[static_cast<std::size_t>(c)].substr(
          0, cells[static_cast<std::size_t>(c)].find('e'));
      const auto digits = std::count_if(cell.begin(), cell.end(),
                                        [](char letter) { return letter >= '1' && letter <= '9'; });
      EXPECT_LE(digits, 6) << line;
    }
  }
  EXPECT_EQ(count, 36 * 2 * 11);
}

// The angle is of UaH alone; practice may have other settings.
TEST_F(ExperimentPowerTest, PilotOfTheAngleNeedsUaHOnlyAndPracticeMayDiffer) {
  std::string text =
      "following,participant,block,haptic,rotation,object,status,mean_contact_angle_deg,view\n";
  for (const PilotLine& line : pilot_lines()) {
    if (line.haptic != "UaH") continue;
    text += ",P" + std::to_string(line.person) + "," + std::to_string(line.block) + ",UaH," +
            line.rotation + "," + line.object + ",done," + std::to_string(line.time_s) +
            (line.block == 0 ? ",still\n" : ",turning\n");
  }
  folder.write("angle.csv", text);
  const test::Outcome o = quick({"--measure", "angle", "--pilot", "angle.csv"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_NE(o.out.find("3 people, 24 trials, m = 4;"), std::string::npos) << o.out;
}

TEST_F(ExperimentPowerTest, PilotMayHaveMissingTrialsAndSeveralFollowings) {
  auto lines = pilot_lines("delayed");
  lines[30].status = "timeout";
  std::erase_if(lines, [](const PilotLine& line) { return line.person == 2 && line.block == 2; });
  folder.write("both.csv",
               pilot_csv(lines) + pilot_csv(pilot_lines()).substr(std::string(kHead).size()));
  for (const auto& [name, trials] : {std::pair("delayed", 59), std::pair("people", 72)}) {
    const test::Outcome o =
        quick({"--pilot", "both.csv", "--following", name, "--out", std::string("out-") + name});
    EXPECT_EQ(o.exit_code, 0) << o.err;
    EXPECT_NE(o.out.find("3 people, " + std::to_string(trials) + " trials, m = "),
              std::string::npos)
        << o.out;
    EXPECT_EQ(o.out.find("13 of 72 trials of the pilot are missing") != std::string::npos,
              trials == 59)
        << o.out;
  }
}

TEST_F(ExperimentPowerTest, AngleHasTheTwoConditionsOfUaH) {
  const test::Outcome o = quick({"--measure", "angle", "--effect", "UaH-R=32,UaH-NoR=49"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_NE(o.out.find("UaH-NoR 49, UaH-R 32 deg\n"), std::string::npos) << o.out;
  EXPECT_EQ(o.out.find("Haptic, "), std::string::npos) << o.out;
}

TEST_F(ExperimentPowerTest, RefusesBadOptionsInOneLine) {
  const std::string five = "NoH-NoR=29,NoH-R=31,UaH-NoR=27,UaH-R=29,H-NoR=25";
  const auto effect = [&](const std::string& text, const std::vector<std::string>& parts) {
    expect_refused({"--effect", text}, parts);
  };
  expect_refused({"--measure", "speed"},
                 {"--measure: is \"speed\"; expected time, losses, penetration or angle"});
  effect(five, {"--effect: lacks H-R; expected each condition"});
  effect(five + ",H-R", {"--effect: has the part \"H-R\"; expected CONDITION=MEAN"});
  effect(five + ",", {"--effect: has the part \"\""});
  effect(five + ",H-R=", {"--effect: has \"\" for H-R; expected a number"});
  effect(five + ",H-R=x", {"--effect: has \"x\" for H-R"});
  effect(five + ",H-R=nan", {"--effect: has \"nan\" for H-R"});
  effect(five + ",H-R=inf", {"--effect: has \"inf\" for H-R"});
  effect(five + ",H-R=1e10", {"--effect: has \"1e10\" for H-R", "-1e9 to 1e9"});
  effect(five + ",H-R=28 s", {"--effect: has \"28 s\" for H-R"});
  effect(five + ",H-R=28,H-NoR=4", {"--effect: has H-NoR twice"});
  effect(five + ",R-H=28", {"--effect: has the part \"R-H=28\""});
  effect("NoH=1", {"--effect: has the part \"NoH=1\"", "NoH-NoR=29.5"});
  expect_refused({"--measure", "angle", "--effect", five + ",H-R=28"},
                 {"--effect: has the part \"NoH-NoR=29\"", "each of UaH-NoR, UaH-R"});
  for (const char* const sd : {"0", "-1", "nan", "ten", "1e10"}) {
    expect_refused({"--error", sd},
                   {"--error", "expected a finite number above 0 and at most 1e+09"});
  }
  for (const char* const share : {"-0.1", "1.1", "30%", "nan"}) {
    expect_refused({"--share-u", share}, {"--share-u", "expected a finite number from 0 to 1"});
    expect_refused({"--share-w", share}, {"--share-w", "expected a finite number from 0 to 1"});
  }
  expect_refused({"--share-u", "0.7", "--share-w", "0.4"}, {"--share-u: and --share-w", "above 1"});
  expect_refused({"--share-u", "1", "--share-w", "0"}, {"--share-u: is 1; expected less"});
  expect_refused({"--share-u", "0.85"}, {"--share-u: leaves no room", "give both"});
  expect_refused({"--share-w", "0.9"}, {"--share-w: leaves no room", "give both"});
  expect_refused({"--trials", "0"}, {"--trials", "from 1 to 1000"});
  expect_refused({"--participants", "1"}, {"--participants", "from 2 to 200"});
  expect_refused({"--participants", "2-60"}, {"--participants", "from 2 to 200"});
  expect_refused({"--sets", "99"}, {"--sets", "from 100 to 1000000"});
  expect_refused({"--seed", "9007199254740992"}, {"--seed"});
  expect_refused({"--jobs", "0"}, {"--jobs", "from 1 to 1024"});
  expect_refused({"--following", "delayed"}, {"--following: is given without --pilot"});
  expect_refused({"--share-u", "0.9999999999999999", "--share-w", "0"},
                 {"--share-u: leaves w and e a standard deviation of "});
  expect_refused({"--effect", five + ",H-R=1e9"}, {"--effect: gives a standard deviation of "});
  EXPECT_EQ(quick({"--error", "1e9", "--out", "large"}).exit_code, 0);
  expect_refused({"--error", "1e-8", "--effect", five + ",H-R=28"},
                 {"--error: gives a standard deviation of ", "one scale"});
  expect_refused({"--error", "9", "--error", "8"}, {"--error: is given more than once"});
  expect_refused({"trials.csv"}, {"trials.csv: is an unexpected argument of power"});
}

TEST_F(ExperimentPowerTest, RefusesBadPilotsInOneLine) {
  expect_refused({"--pilot", "missing.csv"}, {"missing.csv: ", "cannot be opened"});
  for (const char* const option : {"--error", "--share-u", "--share-w"}) {
    expect_refused({"--pilot", "pilot.csv", option, "0.5"},
                   {std::string(option) + ": excludes --pilot"});
  }
  expect_refused({"--pilot", "pilot.csv", "--following", "delayed"},
                 {"--following: is \"delayed\"; expected people"});
  expect_refused({"--pilot", "pilot.csv", "--measure", "losses"},
                 {"pilot.csv: column losses_of_contact: has no value"});
  expect_pilot_refused("", {"is empty"});
  expect_pilot_refused(kHead, {"has no trial"});
  expect_pilot_refused("participant;block\n", {"column participant: is missing", "semicolons"});
  expect_pilot_refused(pilot_csv(pilot_lines()) + ",P1,1,NoH,NoR,O1,done,nan\n", {"line ", "nan"});
  expect_pilot_refused(pilot_csv(pilot_lines()) + ",P1,1,NoH,NoR,O1,done,7\n", {"line ", "again"});
  expect_pilot_refused(
      pilot_csv(pilot_lines("delayed")) + ",P1,1,NoH,NoR,O1,done,7\n",
      {"column following: has trials of 2 kinds", "--following: delayed or people"});
  expect_pilot_refused(pilot_csv_with([](const PilotLine& line) { return line.block == 0; }),
                       {"participant: has 0 levels beside practice"});
  expect_pilot_refused(pilot_csv_with([](const PilotLine& line) { return line.person == 1; }),
                       {"participant: has 1 level"});
  expect_pilot_refused(pilot_csv_with([](const PilotLine& line) { return line.haptic != "UaH"; }),
                       {"column haptic: has no trial of UaH", "--share-u"});
  expect_pilot_refused(pilot_csv_with([](const PilotLine& line) { return line.rotation == "NoR"; }),
                       {"column rotation: has no trial of R"});
  expect_pilot_refused(pilot_csv_with([](const PilotLine& line) {
                         return line.person == 1 || line.haptic != "H" || line.rotation != "R";
                       }),
                       {"column participant: has 1 participant with a completed trial in each of 6",
                        "P2 lacks H-R"});
  expect_pilot_refused(
      pilot_csv_with([](const PilotLine& line) { return line.block == 1 && line.object == "O1"; }),
      {"columns object and block: have one trial"});
  // P1 did one object in a condition, the others the other one.
  expect_pilot_refused(pilot_csv_with([](const PilotLine& line) {
                         return line.haptic != "NoH" || (line.person == 1) == (line.object == "O1");
                       }),
                       {"condition NoH-NoR: has participants whose objects and blocks no other"});
  // Each person has an object of his own, and O1 once.
  expect_pilot_refused(pilot_csv_with([](const PilotLine& line) {
                         return line.person <= 2 && line.block == 1 &&
                                (line.person == 1 || line.object == "O1");
                       }),
                       {"columns object and block: have so few trials in common"});
  for (const char* const value : {"1e300", "1e155", "2e9"}) {
    expect_pilot_refused(pilot_csv(pilot_lines()) + ",P1,3,NoH,NoR,O1,done," + value + "\n",
                         {"column total_time_s: is ", "participant P1, which is too large"});
  }
  auto lines = pilot_lines();
  for (PilotLine& line : lines) line.time_s = 20.0 + 3.0 * line.person;
  expect_pilot_refused(pilot_csv(lines), {"column total_time_s: does not vary"});
  for (PilotLine& line : lines) line.status = "timeout";
  expect_pilot_refused(pilot_csv(lines), {"column total_time_s: has no value"});
  const std::string with_strategy =
      "participant,block,haptic,rotation,object,status,strategy\n"
      "1,1,,,O1,done,a4\n2,1,,,O1,done,a4\n";
  expect_pilot_refused(with_strategy, {"column strategy: is a4 in a trial of participant 1"});
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
