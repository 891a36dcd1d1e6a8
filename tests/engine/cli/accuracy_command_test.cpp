// `palpate accuracy`: its files, and the command line that it offers.

#include <filesystem>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/environment_variable.h"

namespace palpate {
namespace {

using test::CommandLine;
using test::content_of;
using test::kStar;
using test::lines_of;
using test::Outcome;

TEST_F(CommandLine, AccuracyWritesAPageATableAndADiagramPerKnob) {
  const Outcome done =
      call({"accuracy", "--quick", "--knob", "a4_step", "--knob", "mesh_depth", "--out", "it's"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("mesh_depth"), std::string::npos);
  EXPECT_EQ(done.out.find("servo_rate"), std::string::npos) << "only the requested knobs";
  const std::string page = content_of(folder.path("it's/report.html"));
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_EQ(page.find("Your scene"), std::string::npos);
  for (const char* knob : {"a4_step", "mesh_depth"}) {
    const std::string svg = content_of(folder.path(std::string("it's/") + knob + ".svg"));
    EXPECT_NE(svg.find("<svg"), std::string::npos) << knob;
  }
  const std::vector<std::string> rows = lines_of(content_of(folder.path("it's/raw.csv")));
  ASSERT_GT(rows.size(), 20u);
  EXPECT_EQ(rows.front().rfind("knob,method,level,", 0), 0u);
  EXPECT_EQ(
      content_of(folder.path("it's/accuracy.json")).find("{\n \"format\": \"palpate-accuracy-1\""),
      0u);
  EXPECT_EQ(done.err, "") << "no progress bar where there is no terminal";
}

TEST_F(CommandLine, AccuracyMeasuresWithoutPython) {
  const std::vector<std::string> command{"accuracy", "--quick", "--knob",
                                         "a4_step",  "--out",   "new"};
  std::filesystem::create_directory(folder.path("new"));
  for (const char* name : {"new/report.html", "new/a4_step.svg", "new/mine.txt"}) {
    folder.write(name, "older");
  }
  const test::EnvironmentVariable none("PALPATE_PYTHON", "/nowhere/python3");
  const Outcome done = call(command);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("Velocity window"), std::string::npos) << "the answer";
  EXPECT_NE(done.out.find("accuracy.json are in new/"), std::string::npos) << done.out;
  EXPECT_EQ(done.out.find("report.html"), std::string::npos) << done.out;
  const std::vector<std::string> lines = lines_of(done.err);
  ASSERT_EQ(lines.size(), 1u) << done.err;
  EXPECT_NE(lines[0].find("the page is missing: /nowhere/python3"), std::string::npos) << done.err;
  for (const char* name : {"accuracy.json", "raw.csv", "stiffness_zones.csv", "stiffness.svg"}) {
    EXPECT_NE(content_of(folder.path(std::string("new/") + name)), "") << name;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("new/report.html"))) << "of an older run";
  EXPECT_FALSE(std::filesystem::exists(folder.path("new/a4_step.svg"))) << "of an older run";
  EXPECT_EQ(content_of(folder.path("new/mine.txt")), "older");
}

TEST_F(CommandLine, AccuracyReportsOnAScene) {
  const Outcome done = call({"accuracy", kStar, "--quick", "--knob", "a4_step", "--stiffness",
                             "900", "--device-damping", "0.4", "--encoder-quantum", "0"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("highest servo rate kept"), std::string::npos);
  EXPECT_NE(done.out.find("K 900 N/m, not passive (passive up to 800 N/m)"), std::string::npos)
      << done.out;
  const std::string page = content_of(folder.path("accuracy/report.html"));
  EXPECT_NE(page.find("Your scene"), std::string::npos);
  // 0.4 / (0.5 ms + 3.1 ms), the longest delay of a bare tip.
  EXPECT_NE(done.out.find("stable below 111 N/m, calm by the controller up to "), std::string::npos)
      << done.out;
  EXPECT_NE(page.find("the setting, 900 N/m at a delay of 3.1 ms: calm only by the controller"),
            std::string::npos);
  EXPECT_EQ(content_of(folder.path("accuracy/stiffness_zones.csv")).find("rate_Hz,delay_s,"), 0u);
  const std::string csv = content_of(folder.path("accuracy/scene.csv"));
  for (const char* quantity : {"preset,fast,p50", "preset,exact,worst", "preset,balanced,error_rms",
                               "rate,safe,rate", "passive_up_to,800,N/m", "is_stable"}) {
    EXPECT_NE(csv.find(quantity), std::string::npos) << quantity;
  }
}

// The arguments of the line that the output offers to copy. Words without spaces alone.
std::vector<std::string> offered_command(const std::string& output) {
  const std::size_t begin = output.find("palpate run ");
  EXPECT_NE(begin, std::string::npos) << output;
  std::istringstream line(output.substr(begin, output.find('\n', begin) - begin));
  std::vector<std::string> words{std::istream_iterator<std::string>(line), {}};
  if (!words.empty()) words.erase(words.begin());  // "palpate"
  return words;
}

TEST_F(CommandLine, AccuracyOffersACommandThatRuns) {
  const Outcome done =
      call({"accuracy", kStar, "--quick", "--knob", "velocity_total", "--device-mass", "0.2"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("For this device and this scene (mass 0.2 kg"), std::string::npos);
  std::vector<std::string> command = offered_command(done.out);
  ASSERT_GT(command.size(), 10u);
  EXPECT_EQ(command[1], kStar);
  const Outcome run = call(command);
  EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 3) << run.exit_code << "\n" << run.err;
  // Without a scene the command names a model of the repository.
  const Outcome alone = call({"accuracy", "--quick", "--knob", "a4_step", "--device-mass", "0.2"});
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  command = offered_command(alone.out);
  ASSERT_EQ(command[1], "models/sphere.glb");
  command[1] = std::filesystem::path(kStar).replace_filename("sphere.glb");
  const Outcome on_sphere = call(command);
  EXPECT_TRUE(on_sphere.exit_code == 0 || on_sphere.exit_code == 3) << on_sphere.err;
}

TEST_F(CommandLine, AccuracyRefusesInvalidRequests) {
  expect_refused({"accuracy", "--knob", "speed"}, {"--knob", "speed", "mesh_depth", "a4_step"});
  expect_refused({"accuracy", "none.glb"}, {"none.glb"});
  expect_refused({"accuracy", kStar, "--quick", "--device-mass", "0"}, {"--device-mass"});
  expect_refused({"accuracy", kStar, "--quick", "--device-damping", "-1"}, {"--device-damping"});
  expect_refused({"accuracy", "--quick", "--out", "/dev/null/x"}, {"--out"});
  expect_refused({"accuracy", kStar, "--rate", "0"}, {"--rate"});
  expect_refused({"accuracy", "--device-mass", "0"}, {"--device-mass"});
  expect_refused({"accuracy", "--fit", "0.2"}, {"--fit", "SCENE"});
  expect_refused({"accuracy", "--knob", "scene_resolution"}, {"--knob", "with a SCENE"});
}

}  // namespace
}  // namespace palpate
