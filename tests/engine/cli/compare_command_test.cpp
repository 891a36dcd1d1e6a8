// `palpate compare` as a user or a script runs it.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
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
using test::kStar;
using test::TemporaryFolder;

using Arguments = std::vector<std::string>;

class CompareCommandTest : public testing::Test {
 protected:
  // A small star, which a hand follows in some seconds.
  test::Outcome call(const Arguments& more) const {
    Arguments arguments{"compare", kStar, "--scale", "0.5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(folder, arguments);
  }
  // Code 2, nothing on stdout, one line on stderr with all of `parts`, and no new file.
  void expect_refused(const Arguments& arguments, const std::vector<std::string>& parts) const {
    std::string line;
    for (const std::string& argument : arguments) line += argument + " ";
    SCOPED_TRACE(line);
    const test::Outcome o = run_program(folder, arguments);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_TRUE(o.err.starts_with("palpate: ") && o.err.ends_with("\n")) << o.err;
    for (const std::string& part : parts) EXPECT_NE(o.err.find(part), std::string::npos) << o.err;
    EXPECT_FALSE(fs::exists(folder.path("compare")));
  }

  // The means of a document, by measure and strategy. One without a value is NaN.
  static std::map<std::string, double> means_in(const std::string& json) {
    std::map<std::string, double> means;
    const Json parsed = Json::parse(json);
    for (const Json& row : parsed["means"]) {
      std::string key;
      for (const char* const name :
           {"following", "scene", "measure", "column", "unit", "better", "strategy", "role"}) {
        key += row[name].get<std::string>() + ",";
      }
      means[key + row["hands"].dump()] =
          row["mean"].is_null() ? std::nan("") : row["mean"].get<double>();
    }
    return means;
  }
  // Expects the same in means.csv, to the ten digits of a document.
  void expect_measured(const std::map<std::string, double>& means) const {
    std::istringstream lines(content_of(folder.path("compare/means.csv")));
    std::string line;
    std::getline(lines, line);
    std::size_t count = 0;
    for (; std::getline(lines, line); ++count) {
      const std::size_t last = line.rfind(',');
      const auto found = means.find(line.substr(0, last));
      ASSERT_NE(found, means.end()) << line;
      const std::string mean = line.substr(last + 1);
      EXPECT_EQ(mean.empty(), std::isnan(found->second)) << line;
      if (mean.empty()) continue;
      EXPECT_NEAR(std::stod(mean), found->second, 1e-9 * std::abs(found->second)) << line;
    }
    EXPECT_EQ(count, means.size());
  }

  TemporaryFolder folder;
};

TEST_F(CompareCommandTest, BeginsItsHelpWithAnExample) {
  const test::Outcome o = run_program(folder, {"compare", "--help"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_TRUE(o.out.starts_with("Example:\n  ./run.sh compare models/star.glb ")) << o.out;
  for (const char* const own : {"--force", "--a4 ", "--material", "--move"}) {
    EXPECT_EQ(o.out.find(own), std::string::npos) << own;
  }
}

TEST_F(CompareCommandTest, RefusesBadListsAndValuesInOneLine) {
  const auto with = [](const Arguments& more) {
    Arguments arguments{"compare", kStar};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  expect_refused({"compare"}, {"SCENE"});
  expect_refused({"compare", "missing.glb"}, {"missing.glb: ", "cannot be opened"});
  expect_refused(with({"--strategies", ""}), {"--strategies: has an empty value"});
  expect_refused(with({"--strategies", "mask,a5"}),
                 {"--strategies: has a name that is \"a5\"; expected one of none, mask"});
  expect_refused(with({"--strategies", "mask,mask"}), {"--strategies: has mask twice"});
  expect_refused(with({"--strategies", "anisotropic:0.01"}), {"--strategies", "0.0625 to 16"});
  expect_refused(with({"--strategies", "anisotropic:2,anisotropic"}),
                 {"--strategies: has anisotropic:2 twice", "six E"});
  expect_refused(with({"--strategies", "anisotropic:2", "--radius", "0.002"}),
                 {"--strategies: anisotropic:2 is refused for object star"});
  for (const char* const hands : {"1", "0", "-2", "10001", "2.5", "ten"}) {
    expect_refused(with({"--hands", hands}), {"--hands", "from 2 to 10000"});
  }
  expect_refused(with({"--operator", "nobody"}), {"--operator: is \"nobody\""});
  expect_refused(with({"--sensors", "3"}), {"--sensors: is 3; expected 2"});
  expect_refused(with({"--actuators", "3"}), {"actuators"});
  expect_refused(with({"--seed", "9007199254740992"}), {"--seed"});
  expect_refused(with({"--shard", "3/2"}), {"--shard: is \"3/2\""});
  expect_refused(with({"--jobs", "0"}), {"--jobs"});
  expect_refused(with({"--force", "full"}), {"--force"});
  expect_refused(with({"--scale", "1", "--fit", "0.1"}), {"--fit"});
  expect_refused(with({"--close-gaps", "1"}), {"--close-gaps: is 1 m", "tenth of the extent"});
  expect_refused(with({"--plane-height", "5"}), {"--plane-height: is 5 m"});
  expect_refused(with({"--max-force", "30"}), {"--max-force: is 30 N; expected at most 20 N"});
}

TEST_F(CompareCommandTest, WritesAReportOfTheTrials) {
  const test::Outcome o = call({"--hands", "2", "--strategies", "mask,a4", "--jobs", "2"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(o.err, "");
  EXPECT_NE(o.out.find(": 4 trials of 2 hands of people2005, seed 2005\n"), std::string::npos)
      << o.out;
  EXPECT_NE(o.out.find("contact angle, deg"), std::string::npos) << o.out;
  for (const char* const name :
       {"plan.json", "report.html", "comparison.json", "means.csv", "strategies.csv",
        "comparison.csv", "a4_losses.csv", "trials/trials.csv", "trials/run.json"}) {
    EXPECT_TRUE(fs::exists(folder.path(std::string("compare/") + name))) << name;
  }
  // The plan that was written gives the same trials.
  const test::Outcome run =
      run_program(folder, {"experiment", "run", "compare/plan.json", "--out", "again"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(content_of(folder.path("again/trials.csv")),
            content_of(folder.path("compare/trials/trials.csv")));
  const test::Outcome analyse = run_program(folder, {"experiment", "analyse", "again/trials.csv"});
  EXPECT_EQ(analyse.exit_code, 2);
  EXPECT_NE(analyse.err.find("again/trials.csv: column strategy: is "), std::string::npos)
      << analyse.err;
  EXPECT_NE(analyse.err.find("palpate compare"), std::string::npos) << analyse.err;
  EXPECT_FALSE(fs::exists(folder.path("analysis")));
  // A second call computes nothing, and prints the same as JSON.
  const std::string json = content_of(folder.path("compare/comparison.json"));
  const test::Outcome printed =
      call({"--hands", "2", "--strategies", "mask,a4", "--jobs", "1", "--json"});
  EXPECT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_EQ(printed.out, json);
  EXPECT_EQ(Json::parse(printed.out)["comparable"]["delayed"], true);
  expect_measured(means_in(json));
}

// A person who hardly moves does not arrive within the limit.
TEST_F(CompareCommandTest, EndsWithThreeAndWritesAllTheSameIfTrialsAreNotCompleted) {
  Json person = Json::parse(content_of(PALPATE_TRIALS_DIR "/people2005.json"));
  person["parameters"]["speed_m_per_s"]["low"] = 1e-4;
  person["parameters"]["speed_m_per_s"]["high"] = 2e-4;
  folder.write("slow.json", person.dump());
  const test::Outcome o = call({"--hands", "2", "--strategies", "mask", "--operator", "slow.json"});
  EXPECT_EQ(o.exit_code, 3) << o.err;
  EXPECT_NE(o.out.find("not comparable: 0 of 2 trials of mask ended at the red sphere"),
            std::string::npos)
      << o.out;
  EXPECT_TRUE(fs::exists(folder.path("compare/report.html")));
}

// With and without Python: the same line, and a mark in the table.
TEST_F(CompareCommandTest, FlagsATravelBeyondTheWorkspace) {
  const Arguments small = {"--hands", "2", "--strategies", "mask,a4", "--workspace", "0.12"};
  const test::Outcome page = call(small);
  EXPECT_EQ(page.exit_code, 0) << page.err;
  const std::size_t start = page.out.find("! beyond the workspace of 120 mm: ");
  ASSERT_NE(start, std::string::npos) << page.out;
  const std::string line = page.out.substr(start, page.out.find('\n', start) + 1 - start);
  EXPECT_NE(content_of(folder.path("compare/report.html")).find("eyond the workspace of 120 mm"),
            std::string::npos);
  const test::EnvironmentVariable python("PALPATE_PYTHON", "/nowhere/python3");
  const test::Outcome means = call(small);
  EXPECT_NE(means.out.find(line), std::string::npos) << line << means.out;
  Arguments large = small;
  large.back() = "2";
  EXPECT_EQ(call(large).out.find("! beyond"), std::string::npos);
}

TEST_F(CompareCommandTest, PrintsTheMeansAsJsonWithoutPython) {
  const test::EnvironmentVariable python("PALPATE_PYTHON", "/nowhere/python3");
  const test::Outcome o = call({"--hands", "2", "--strategies", "mask", "--json"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_TRUE(o.err.starts_with("palpate: warning: the page is missing: /nowhere/python3"))
      << o.err;
  const Json json = Json::parse(o.out);
  EXPECT_EQ(json["strategies"][0]["trials"], 2);
  expect_measured(means_in(o.out));
  EXPECT_FALSE(fs::exists(folder.path("compare/report.html")));
}

TEST_F(CompareCommandTest, ShardsInOneFolderAreOneComparison) {
  const Arguments settings = {"--hands", "3", "--strategies", "mask,a4"};
  const auto with = [&](const Arguments& more) {
    Arguments arguments = settings;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  EXPECT_EQ(call(with({"--out", "whole"})).exit_code, 0);
  for (const char* const shard : {"2/2", "1/2"}) {
    const test::Outcome o = call(with({"--out", "shards", "--shard", shard}));
    EXPECT_EQ(o.exit_code, 0) << o.err;
    EXPECT_TRUE(o.out.starts_with(std::string("shard ") + shard + " is complete in shards/"));
  }
  EXPECT_FALSE(fs::exists(folder.path("shards/report.html")));
  EXPECT_EQ(call(with({"--out", "shards"})).exit_code, 0);
  for (const char* const name : {"report.html", "comparison.json", "means.csv"}) {
    EXPECT_EQ(content_of(folder.path(std::string("shards/") + name)),
              content_of(folder.path(std::string("whole/") + name)))
        << name;
  }
}

}  // namespace
}  // namespace palpate
