// The files that commands read and write, and their standard output.

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

using test::CommandLine;
using test::content_of;
using test::FileSizeLimit;
using test::GltfBuilder;
using test::kStar;
using test::Outcome;
using test::sorted;

TEST_F(CommandLine, RefusesScenesItCannotRead) {
  write_path();
  GltfBuilder broken = GltfBuilder::one_triangle();
  broken.json["accessors"][0]["count"] = 1000;
  const std::string beyond = broken.write_glb(folder);
  const std::string text = folder.write("text.glb", "no scene");
  const std::string empty = folder.write("empty.glb", "");
  const std::string nothing = folder.write("nothing.gltf", R"({"asset":{"version":"2.0"}})");
  for (const std::string command : {"info", "run", "replay"}) {
    const auto expect = [&](const std::string& scene, const std::vector<std::string>& names) {
      std::vector<std::string> arguments{command, scene};
      if (command == "replay") {
        arguments.insert(arguments.end(), {"--trajectory", folder.path("path.txt")});
      }
      expect_refused(arguments, names);
    };
    expect(folder.path("missing.glb"), {"missing.glb"});
    expect(folder.path(), {folder.path()});
    expect(text, {"text.glb"});
    expect(empty, {"empty.glb"});
    expect(nothing, {"nothing.gltf"});
    expect(beyond, {beyond, "accessors"});
    expect("", {command});
  }
}

TEST_F(CommandLine, RefusesTrajectoriesItCannotRead) {
  const auto expect = [&](const std::string& file, const std::vector<std::string>& names) {
    expect_refused({"replay", kStar, "--trajectory", file}, names);
  };
  expect(folder.path("missing.txt"), {"missing.txt"});
  expect(folder.path(), {folder.path()});
  expect(folder.write("empty.txt", ""), {"empty.txt"});
  expect(folder.write("short.txt", "0 0 0\n0 0\n"), {"short.txt", "2"});
  expect(folder.write("word.txt", "0 0 0\n0 0 0\n0 there 0\n"), {"word.txt", "3"});
  expect(folder.write("back.txt", "0 0 0 0\n2 0 0 0\n1 0 0 0\n"), {"back.txt", "3"});
}

TEST_F(CommandLine, RefusesToWriteWhereItCannot) {
  PALPATE_NEEDS(test::lack_of_full_disk());
  write_path();
  const std::string file = folder.write("file", "");
  expect_refused(replay({"--out", folder.path("missing/trace.csv")}), {"missing/trace.csv"});
  expect_refused(replay({"--out", folder.path()}), {folder.path()});
  expect_refused(replay({"--out", file + "/trace.csv"}), {file});
  expect_refused(replay({"--out", "/dev/full"}), {"/dev/full"});
  expect_refused({"run", kStar, "--virtual", "--seconds", "2", "--out", file}, {file});
  expect_refused({"run", kStar, "--virtual", "--seconds", "2", "--out", file + "/out"}, {file});
  std::filesystem::create_directories(folder.path("taken/trace-off.csv"));
  expect_refused({"run", kStar, "--virtual", "--seconds", "2", "--out", folder.path("taken")},
                 {"trace-off.csv"});
}

TEST_F(CommandLine, RefusesToWriteWhereItMayNot) {
  write_path();
  // No user can create a file in /proc, not even root.
  expect_refused(replay({"--out", "/proc/trace.csv"}), {"/proc/trace.csv"});
  expect_refused({"run", kStar, "--virtual", "--out", "/proc/out"}, {"/proc/out"});
  expect_refused({"run", kStar, "--virtual", "--seconds", "2", "--out", "/proc"}, {"/proc"});
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    names.push_back(entry.path().lexically_relative(folder).string());
  }
  return sorted(names);
}

TEST_F(CommandLine, KeepsOlderFilesWhenADiskIsFull) {
  write_path();
  const std::vector<std::string> names{"a4_step.svg", "raw.csv", "trace-off.csv", "trace-on.csv"};
  for (const std::string& name : names) folder.write("out/" + name, "old");
  const FileSizeLimit limit(2000);
  for (const char* out : {"out", "new/er"}) {
    expect_refused({"run", kStar, "--virtual", "--seconds", "2", "--out", out},
                   {std::string(out) + "/trace-off.csv: cannot be written"});
    expect_refused({"accuracy", "--quick", "--knob", "a4_step", "--out", out},
                   {std::string(out) + "/raw.csv: cannot be written"});
  }
  expect_refused(replay({"--out", folder.path("out/trace-on.csv")}),
                 {"out/trace-on.csv: cannot be written"});
  EXPECT_EQ(files_in(folder.path("out")), names);
  for (const std::string& name : names) EXPECT_EQ(content_of(folder.path("out/" + name)), "old");
  EXPECT_FALSE(std::filesystem::exists(folder.path("new")));
}

TEST_F(CommandLine, RemovesItsOlderResultsAndNoOtherFile) {
  const std::vector<std::string> others{"notes.txt", "raw.csv", "trace-on.csv.bak"};
  for (const std::string& name : others) folder.write("out/" + name, "mine");
  const std::vector<std::string> run{"run", kStar, "--virtual", "--seconds", "2", "--out", "out"};
  const auto results = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = run;
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_run(arguments);
    std::vector<std::string> names = files_in(folder.path("out"));
    for (const std::string& other : others) {
      EXPECT_EQ(std::erase(names, other), 1u) << other;
      EXPECT_EQ(content_of(folder.path("out/" + other)), "mine");
    }
    return names;
  };
  EXPECT_EQ(results({}), sorted({"contour-off.csv", "contour-on.csv", "paths.svg", "trace-off.csv",
                                 "trace-on.csv"}));
  EXPECT_EQ(results({"--a4", "on"}), sorted({"contour-on.csv", "paths.svg", "trace-on.csv"}));
  EXPECT_EQ(results({"--sensors", "3", "--a4", "off"}),
            sorted({"paths.svg", "places-off.csv", "trace-off.csv"}));
  const std::vector<std::string> before = files_in(folder.path("out"));
  expect_refused({"run", kStar, "--virtual", "--seconds", "2", "--plane-height", "1"},
                 {"--plane-height"});
  EXPECT_EQ(files_in(folder.path("out")), before) << "of a run that failed";
}

TEST_F(CommandLine, LeavesNoFolderOfACommandThatFailed) {
  expect_refused({"run", kStar, "--virtual", "--plane-height", "1", "--out", "a/b/c"},
                 {"--plane-height"});
  expect_refused({"run", "missing.glb", "--virtual", "--out", "a/b/c"}, {"missing.glb"});
  expect_refused({"accuracy", "missing.glb", "--out", "a/b/c"}, {"missing.glb"});
  EXPECT_FALSE(std::filesystem::exists(folder.path("a")));
}

TEST_F(CommandLine, KeepsOlderFilesWhenItsOutputCannotBeWritten) {
  PALPATE_NEEDS(test::lack_of_full_disk());
  write_path();
  folder.write("out/trace-off.csv", "old");
  for (const char* output : {"/dev/full", ""}) {
    SCOPED_TRACE(output);
    for (const auto& arguments :
         {std::vector<std::string>{"run", kStar, "--virtual", "--seconds", "2"},
          replay({"--out", "out/trace-off.csv"})}) {
      const Outcome o = *output ? call(arguments, output) : call_with_output_closed(arguments);
      EXPECT_EQ(o.exit_code, 2);
      EXPECT_EQ(
          o.err,
          "palpate: standard output: cannot be written (check its target and the free space)\n");
      EXPECT_EQ(files_in(folder.path("out")), std::vector<std::string>{"trace-off.csv"});
      EXPECT_EQ(content_of(folder.path("out/trace-off.csv")), "old");
    }
  }
}

TEST_F(CommandLine, ReportsLostOutput) {
  PALPATE_NEEDS(test::lack_of_full_disk());
  const Outcome o = call({"info", kStar}, "/dev/full");
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}

}  // namespace
}  // namespace palpate
