// The program as a user or a script runs it: exit codes, stdout, stderr and files.
// Needs PALPATE_PROGRAM, the program, and PALPATE_MODELS_DIR, the folder of the models.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/session/trace_csv.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/slit_tube.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::content_of;
using test::FileSizeLimit;
using test::GltfBuilder;
using test::Outcome;
using test::TemporaryFolder;

constexpr const char* kStar = PALPATE_MODELS_DIR "/star.glb";
constexpr const char* kCube = PALPATE_MODELS_DIR "/cube.glb";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class CommandLine : public testing::Test {
 protected:
  // stdout_path: redirects stdout.
  Outcome call(std::vector<std::string> arguments, const std::string& stdout_path = {}) const {
    return test::run_program(folder, std::move(arguments), stdout_path);
  }

  // Runs the program in a shell, as `palpate ... >&-`.
  Outcome call_with_output_closed(const std::vector<std::string>& arguments) const {
    const std::string err = folder.path("stderr");
    std::string line = "cd '" + folder.path() + "' && '" PALPATE_PROGRAM "'";
    for (const std::string& argument : arguments) line += " '" + argument + "'";
    const int status = std::system((line + " >&- 2>'" + err + "'").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, "", content_of(err)};
  }

  // Bad arguments or input: code 2, nothing on stdout, one line on stderr with all of `names`.
  void expect_refused(const std::vector<std::string>& arguments,
                      const std::vector<std::string>& names) const {
    std::string text;
    for (const std::string& a : arguments) text += a + " ";
    SCOPED_TRACE(text);
    const Outcome o = call(arguments);
    EXPECT_EQ(o.exit_code, 2);
    EXPECT_EQ(o.out, "");
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_TRUE(o.err.starts_with("palpate: ") && o.err.ends_with("\n")) << o.err;
    for (const std::string& name : names) {
      EXPECT_NE(o.err.find(name), std::string::npos) << "no \"" << name << "\" in: " << o.err;
    }
  }

  Outcome expect_done(const std::vector<std::string>& arguments, int exit_code = 0) const {
    std::string text;
    for (const std::string& a : arguments) text += a + " ";
    SCOPED_TRACE(text);
    const Outcome o = call(arguments);
    EXPECT_EQ(o.exit_code, exit_code) << o.err;
    return o;
  }
  // A run, comparable or not.
  Outcome expect_run(const std::vector<std::string>& arguments) const {
    const Outcome o = call(arguments);
    EXPECT_TRUE(o.exit_code == 0 || o.exit_code == 3) << o.err;
    return o;
  }
  // A run whose time is too short for the whole contour.
  Outcome expect_not_comparable(const std::vector<std::string>& arguments) const {
    return expect_done(arguments, 3);
  }

  // Into the star from the side, along it and out again.
  std::string write_path(const std::string& name = "path.txt") const {
    std::ostringstream text;
    for (int n = 0; n < 200; ++n) text << 0.12 - 0.0005 * n << " " << 0.0003 * n << " 0\n";
    for (int n = 0; n < 50; ++n) text << "0.02 " << 0.06 + 0.005 * n << " 0\n";
    return folder.write(name, text.str());
  }

  std::vector<std::string> replay(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"replay", kStar, "--trajectory", folder.path("path.txt")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  TemporaryFolder folder;
};

// The rows of a trace as texts, without the header.
std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  for (const std::string& line : lines_of(csv)) {
    std::vector<std::string> row;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) row.push_back(field);
    rows.push_back(row);
  }
  if (!rows.empty()) rows.erase(rows.begin());
  return rows;
}

// A trace without the columns of measured times.
std::string without_times(const std::string& csv) {
  std::string text;
  std::vector<bool> is_time;
  for (const std::string& line : lines_of(csv)) {
    std::istringstream fields(line);
    const bool is_header = is_time.empty();
    std::size_t column = 0;
    for (std::string field; std::getline(fields, field, ','); ++column) {
      if (is_header) is_time.push_back(field.ends_with("_ns"));
      if (!is_time.at(column)) text += field + ",";
    }
    text += "\n";
  }
  return text;
}

std::vector<std::string> keys_of(const json& object) {
  std::vector<std::string> keys;
  for (const auto& item : object.items()) keys.push_back(item.key());
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::vector<std::string> sorted(std::vector<std::string> texts) {
  std::sort(texts.begin(), texts.end());
  return texts;
}

const std::vector<std::string> kSummaryKeys{"ticks",
                                            "contact_ticks",
                                            "mean_penetration_m",
                                            "max_penetration_m",
                                            "mean_contact_angle_deg",
                                            "share_within_30deg",
                                            "losses_of_contact",
                                            "work_lost_J",
                                            "port_work_J",
                                            "faults",
                                            "governor",
                                            "effects",
                                            "not_understood",
                                            "step_ns",
                                            "step_ns_clock",
                                            "load_ms",
                                            "triangles"};

// ---- help and version --------------------------------------------------------------------------

TEST_F(CommandLine, PrintsItsVersion) {
  const Outcome o = expect_done({"--version"});
  EXPECT_TRUE(std::regex_match(o.out, std::regex("palpate [0-9]+\\.[0-9]+\\.[0-9]+\n"))) << o.out;
  EXPECT_EQ(o.err, "");
}

TEST_F(CommandLine, BeginsEveryHelpWithAnExample) {
  for (const std::vector<std::string>& command : {std::vector<std::string>{"--help"},
                                                  {"run", "--help"},
                                                  {"replay", "--help"},
                                                  {"accuracy", "--help"},
                                                  {"experiment", "--help"},
                                                  {"info", "--help"}}) {
    EXPECT_TRUE(expect_done(command).out.starts_with("Example:\n  ./run.sh ")) << command.front();
  }
}

TEST_F(CommandLine, NamesItsCommandsInTheHelp) {
  const Outcome o = expect_done({"--help"});
  for (const char* name : {"run", "replay", "info", "--version", "--help"}) {
    EXPECT_NE(o.out.find(name), std::string::npos) << name;
  }
}

// An option, and a part of its help: the unit, or the choices.
struct OptionHelp {
  const char* option;
  const char* says;
};

const std::vector<OptionHelp> kSharedOptions{{"--sensors", "2 or 3"},
                                             {"--actuators", "axes"},
                                             {"--actuated-axes", "0 0 1"},
                                             {"--force", "none,actuated,full"},
                                             {"--rate", "Hz"},
                                             {"--stiffness", "N/m"},
                                             {"--damping", "N s/m"},
                                             {"--velocity-estimator", "difference,line,adaptive"},
                                             {"--velocity-window", "ticks"},
                                             {"--encoder-quantum", " m"},
                                             {"--radius", " m"},
                                             {"--plane-height", " m"},
                                             {"--place", "x y z qw qx qy qz"},
                                             {"--table1", "corrected"},
                                             {"--a4-step", "exact"},
                                             {"--align", "nearest,forward"},
                                             {"--json", "JSON"},
                                             {"--a4", "on,off"},
                                             {"--strategy", "a4-anticipate"},
                                             {"--material", "NAME.key=value"},
                                             {"--pose", "NAME@SECONDS"},
                                             {"--close-gaps", "at most this far apart"},
                                             {"--effect-times", "share"}};

// The part of a help text about an option: its line and the continuation of it.
std::string help_of(const std::string& help, const std::string& option) {
  const std::regex start("\n  " + option + "[ \n]");
  std::smatch found;
  if (!std::regex_search(help, found, start)) return {};
  const std::string rest = found.str().substr(1) + found.suffix().str();
  std::smatch next;
  return std::regex_search(rest, next, std::regex("\n  -")) ? next.prefix().str() : rest;
}

void expect_help(const std::string& help, const std::vector<OptionHelp>& options) {
  for (const OptionHelp& expected : options) {
    const std::string text = help_of(help, expected.option);
    EXPECT_FALSE(text.empty()) << expected.option << " is not in the help";
    EXPECT_NE(text.find(expected.says), std::string::npos)
        << expected.says << " is not in: " << text;
  }
}

TEST_F(CommandLine, DescribesEveryOptionWithItsUnit) {
  const Outcome run = expect_done({"run", "--help"});
  expect_help(run.out, kSharedOptions);
  expect_help(run.out, {{"--seconds", " s"},
                        {"--seed", "seed"},
                        {"--virtual", "simulated time"},
                        {"--workspace", " m"},
                        {"--out", "folder"},
                        {"--a4", "compare"},
                        {"--record", "FILE"}});
  const Outcome replayed = expect_done({"replay", "--help"});
  expect_help(replayed.out, kSharedOptions);
  expect_help(replayed.out, {{"--trajectory", "metres"},
                             {"--out", "CSV"},
                             {"--repeat", "passes"},
                             {"--scene", "recording"}});
  const Outcome info = expect_done({"info", "--help"});
  expect_help(info.out, {{"--json", "JSON"}});
}

TEST_F(CommandLine, StatesTheDefaultsOfRunAndReplay) {
  const std::string run = expect_done({"run", "--help"}).out;
  const std::string replayed = expect_done({"replay", "--help"}).out;
  // CLI11 2.4 prints a default as "[2]", older versions as "=2".
  const auto expect_default = [](const std::string& help, const char* option,
                                 const std::string& value) {
    const std::string text = help_of(help, option);
    const bool is_stated = text.find(value) != std::string::npos ||
                           text.find("[" + value.substr(1) + "]") != std::string::npos;
    EXPECT_TRUE(is_stated) << text;
  };
  expect_default(run, "--sensors", "=2");
  expect_default(run, "--actuators", "[1");
  expect_default(run, "--stiffness", "=1000");
  expect_default(run, "--damping", "=0");
  expect_default(run, "--velocity-window", "=1");
  expect_default(run, "--velocity-estimator", "=difference");
  expect_default(run, "--a4", "=compare");
  expect_default(run, "--force", "=actuated");
  expect_default(run, "--out", "=out");
  expect_default(replayed, "--sensors", "=3");
  expect_default(replayed, "--actuators", "[3");
  expect_default(replayed, "--a4", "=off");
  expect_default(replayed, "--damping", "=0");
  expect_default(replayed, "--radius", "=0");
}

// ---- bad arguments -----------------------------------------------------------------------------

TEST_F(CommandLine, RefusesUnknownArguments) {
  write_path();
  expect_refused({}, {"subcommand is required; expected run, view, replay, recording, accuracy, "
                      "experiment, compare, soak, info or devices"});
  expect_refused({"feel"}, {"feel"});
  expect_refused({"--bogus"}, {"--bogus"});
  expect_refused({"info"}, {"SCENE"});
  expect_refused({"replay", kStar}, {"--trajectory"});
  expect_refused(replay({"--bogus"}), {"--bogus: is not an option of replay", "replay --help"});
  expect_refused(replay({"superfluous"}), {"superfluous: is an unexpected argument of replay"});
  expect_refused(replay({"--virtual"}), {"--virtual"});
  expect_refused(replay({"--force", "all"}), {"--force", "all"});
  expect_refused(replay({"--a4", "compare"}), {"--a4"});
  expect_refused(replay({"--strategy", "best"}), {"--strategy: is \"best\"; expected one of none"});
  expect_refused(replay({"--strategy", "anisotropic:0"}), {"--strategy", "from 0.0625 to 16"});
  for (const char* option : {"--a4", "--force"}) {
    const std::string value = std::string(option) == "--a4" ? "on" : "full";
    expect_refused(replay({"--strategy", "a4", option, value}),
                   {"--strategy: is given beside " + std::string(option)});
    expect_refused({"run", kStar, "--strategy", "a4", option, value},
                   {"--strategy: is given beside " + std::string(option)});
  }
  expect_refused(replay({"--strategy", "anisotropic:4", "--radius", "0.001"}),
                 {"--strategy: is anisotropic:4, which is for a point"});
  expect_refused(replay({"--table1", "x"}), {"--table1"});
  expect_refused({"run", kStar, "--a4", "perhaps"},
                 {"--a4: is \"perhaps\"; expected one of on,off,compare"});
  expect_refused({"run", kStar, "--seed", "1", "--seed", "2"},
                 {"--seed: is given more than once; expected once"});
  expect_refused({"feel\nme"}, {"feel me"});
  expect_refused(replay({"--out", ""}), {"--out"});
  expect_refused(replay({"--place", ""}), {"--place"});
}

TEST_F(CommandLine, RefusesImpossibleDevices) {
  write_path();
  expect_refused(replay({"--sensors", "1", "--actuators", "1"}), {"sensors", "1"});
  expect_refused(replay({"--sensors", "1", "--actuators", "0"}), {"sensors", "1"});
  expect_refused(replay({"--sensors", "4"}), {"sensors", "4"});
  expect_refused(replay({"--sensors", "0", "--actuators", "0"}), {"sensors", "0"});
  expect_refused(replay({"--sensors", "2", "--actuators", "3"}), {"actuators", "3"});
  expect_refused(replay({"--actuators", "4"}), {"actuators", "4"});
  expect_refused(replay({"--actuators", "-1"}), {"actuators", "-1"});
  expect_refused({"run", kStar, "--sensors", "1"}, {"sensors"});
  expect_refused({"run", kStar, "--actuators", "3"}, {"actuators"});
}

TEST_F(CommandLine, RefusesInvalidActuatedAxes) {
  write_path();
  const auto expect = [&](const char* axes, const std::vector<std::string>& more,
                          const std::vector<std::string>& names) {
    std::vector<std::string> arguments{"--actuated-axes", axes};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refused(replay(arguments), names);
  };
  expect("0 0 1", {"--sensors", "2"}, {"actuated", "0 0 1", "sens"});
  expect("1 0 0; 0 1 0.001", {"--sensors", "2"}, {"actuated", "2"});
  expect("1 0 0; 2 0 0", {}, {"actuated", "2 0 0", "depend"});
  expect("1 0 0; 0 1 0; 1 1 0", {}, {"actuated", "1 1 0"});
  expect("1 0 0; 0 1 0; 0 0 1; 1 1 1", {}, {"actua"});
  expect("0 0 0", {}, {"actuated", "0 0 0"});
  expect("1 0", {}, {"--actuated-axes", "1 0"});
  expect("1 0 0 0", {}, {"--actuated-axes"});
  expect("1 0 x", {}, {"--actuated-axes"});
  expect("nan 0 1", {}, {"--actuated-axes"});
  expect("0 1 0", {"--actuators", "2"}, {"--actuators", "2"});
}

TEST_F(CommandLine, RefusesNumbersOutOfRange) {
  write_path();
  for (const char* option : {"--rate", "--stiffness", "--damping", "--radius"}) {
    for (const char* value : {"nan", "inf", "-1", "1e999"}) {
      expect_refused(replay({option, value}), {option});
    }
    expect_refused(replay({option, "soft"}), {option});
    expect_refused(replay({option, ""}), {option});
  }
  expect_refused(replay({"--rate", "0"}), {"--rate"});
  for (const char* slow : {"1e-320", "0.001", "0.999"}) {
    expect_refused(replay({"--rate", slow}), {"--rate", "at least 1"});
  }
  expect_done(replay({"--rate", "1"}));
  // The force overflows a double, or the sphere exceeds the index.
  expect_refused(replay({"--stiffness", "1e300"}), {"--stiffness", "overflows"});
  expect_refused(replay({"--damping", "1e300"}), {"--damping", "overflows"});
  expect_refused({"run", kStar, "--virtual", "--seconds", "2", "--stiffness", "1e300"},
                 {"--stiffness", "overflows"});
  expect_refused(replay({"--radius", "1e300"}), {"--radius"});
  expect_refused(replay({"--plane-height", "nan"}), {"--plane-height"});
  expect_refused(replay({"--repeat", "0"}), {"--repeat"});
  expect_refused(replay({"--sensors", "2.5"}), {"--sensors"});
  expect_refused(replay({"--place", "0 0 0"}), {"--place"});
  expect_refused(replay({"--place", "0 0 0 0 0 0 0"}), {"--place"});
  expect_refused(replay({"--place", "0 0 0 1 1 0 0"}), {"--place"});
  expect_refused(replay({"--place", "nan 0 0 1 0 0 0"}), {"--place"});
  for (const char* far : {"1e12 0 0 1 0 0 0", "0 1e200 0 1 0 0 0"}) {
    expect_refused(replay({"--place", far}), {": --place: ", "half of their digits"});
    for (const char* fit : {"0.2", "auto"}) {
      expect_refused({"run", kStar, "--virtual", "--place", far, "--fit", fit},
                     {": --place: ", "half of their digits"});
    }
  }
}

// Only decimal digits: a text that another parser would read as a different number, or clamp, is an
// error that names the option and the range.
TEST_F(CommandLine, RefusesIntegersThatAreNotWrittenInDigits) {
  write_path();
  const std::vector<std::string> run{"run", kStar, "--virtual", "--seconds", "2"};
  const std::vector<std::string> bad{"-1",    "+1",
                                     "1.0",   "1e2",
                                     "0x10",  "0b1",
                                     "1'000", "1_0",
                                     "1,0",   "1 ",
                                     " 1",    "1s",
                                     "one",   "99999999999999999999",
                                     "-0",    "1;",
                                     "true",  "inf",
                                     "nan",   std::string(400, '9')};
  const auto expect = [&](std::vector<std::string> command, const char* option,
                          const std::string& range) {
    for (const std::string& value : bad) {
      std::vector<std::string> arguments = command;
      arguments.insert(arguments.end(), {option, value});
      expect_refused(arguments, {option, "expected a whole number", range, value.substr(0, 40)});
    }
  };
  expect(run, "--seed", "from 0 to 18446744073709551615");
  expect(run, "--sensors", "from 2 to 3");
  expect(run, "--actuators", "from 0 to 3");
  expect(run, "--work-budget", "from 1 to 1000000000000");
  expect(run, "--velocity-window", "from 1 to 63");
  expect(replay({}), "--repeat", "from 1 to 1000");
  expect({"accuracy", "--quick"}, "--seed", "from 0 to 18446744073709551615");
  expect_refused(replay({"--seed=-1"}), {"--seed"});
  expect_refused({"run", kStar, "--seed", "18446744073709551616"}, {"--seed"});
  std::vector<std::string> largest = run;
  largest.insert(largest.end(), {"--seed", "18446744073709551615"});
  expect_run(largest);
}

TEST_F(CommandLine, MeasuresAWorkBudgetForTheRate) {
  write_path();
  const auto budget_at = [&](const std::string& rate) {
    std::vector<std::string> arguments = replay({});
    arguments.insert(arguments.end(), {"--work-budget", "auto", "--rate", rate});
    const std::string text = expect_done(arguments).err;
    const std::string before = "work budget: ";
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << text;
    return at == std::string::npos ? 0LL : std::stoll(text.substr(at + before.size()));
  };
  EXPECT_GE(budget_at("1000"), 100);
  EXPECT_GE(budget_at("100"), budget_at("10000")) << "ten times the time, at the least";
  // `run` states it in its results too: the number, and the price from which it follows.
  const auto stated = [&](const std::string& budget) {
    return json::parse(expect_run({"run", kStar, "--virtual", "--seconds", "2", "--a4", "off",
                                   "--work-budget", budget, "--json"})
                           .out)["work_budget"];
  };
  const json measured = stated("auto");
  EXPECT_GE(measured["units"], 100);
  EXPECT_GT(measured["unit_ns"], 0.0);
  EXPECT_LE(measured["units"].get<double>() * measured["unit_ns"].get<double>(), 0.5e6);
  EXPECT_EQ(stated("12345"), (json{{"units", 12345}, {"unit_ns", nullptr}}));
  expect_refused({"compare", kStar, "--work-budget", "auto", "--plane-height", "0.01"},
                 {"--work-budget", "is auto", "expected a number"});
  expect_refused(replay({"--work-budget", "automatic"}), {"--work-budget", "whole number"});
}

TEST_F(CommandLine, ReadsLeadingZerosAsDecimal) {
  write_path();
  const auto trace = [&](const char* window) {
    expect_done(
        replay({"--damping", "5", "--velocity-window", window, "--out", folder.path("trace.csv")}));
    return without_times(content_of(folder.path("trace.csv")));
  };
  EXPECT_EQ(trace("010"), trace("10")) << "an octal number";
}

TEST_F(CommandLine, RefusesInvalidAndInfiniteRealNumbers) {
  write_path();
  const std::vector<std::string> run{"run", kStar, "--virtual"};
  const std::vector<std::string> accuracy{"accuracy", kStar, "--quick"};
  const auto expect = [&](const std::vector<std::string>& command, const char* option,
                          const std::string& range) {
    for (const char* value :
         {"nan", "-nan", "inf",   "-inf",   "infinity", "1e999", "-1e999", "1e-999",
          "1,5", "0x10", "0x1p3", "1.5abc", "1 5",      " 1",    "1 ",     "++1",
          "+-1", "--1",  ".",     "e5",     "1'000",    "one"}) {
      std::vector<std::string> arguments = command;
      arguments.push_back(std::string(option) + "=" + value);
      expect_refused(arguments, {option, "expected a finite number" + range, value});
    }
  };
  for (const char* option : {"--rate", "--stiffness", "--damping", "--radius", "--plane-height",
                             "--encoder-quantum", "--workspace", "--seconds", "--scale", "--fit"}) {
    expect(run, option, "");
  }
  for (const char* option :
       {"--rate", "--stiffness", "--damping", "--radius", "--scale", "--fit", "--device-mass",
        "--device-damping", "--device-friction", "--encoder-quantum"}) {
    expect(accuracy, option, "");
  }
  expect(run, "--seconds", " from 2 to 86400");
  expect(run, "--rate", " of at least 1");
  expect(run, "--fit", " above 0");
  expect(run, "--stiffness", " of at least 0");
  for (const char* value : {"+0.1", ".1", "1e-1", "0.1", "1E-1"}) {
    expect_done(replay({"--encoder-quantum", value}));
  }
}

TEST_F(CommandLine, RefusesEmptyValuesAfterTheEqualsSign) {
  expect_refused({"run", kStar, "--out=", "--virtual"}, {"--out", "empty value"});
  expect_refused({"run", kStar, "--seed=", "5"}, {"--seed", "empty value"});
  expect_refused({"run", kStar, "--seed=5", "--seed", "5"}, {"--seed"});
}

TEST_F(CommandLine, RefusesInvalidVelocityEstimators) {
  write_path();
  for (const char* window : {"0", "-1", "64", "2.5", "long", "99999999999"}) {
    expect_refused(replay({"--velocity-window", window}), {"--velocity-window"});
  }
  expect_refused(replay({"--velocity-estimator", "kalman"}), {"--velocity-estimator", "kalman"});
  expect_refused(replay({"--velocity-estimator", "adaptive"}), {"adaptive", "--encoder-quantum"});
  for (const char* quantum : {"0", "-1e-5", "nan", "inf"}) {
    expect_refused(replay({"--velocity-estimator", "adaptive", "--encoder-quantum", quantum}),
                   {"--encoder-quantum"});
  }
  expect_refused({"run", kStar, "--virtual", "--velocity-window", "64"}, {"--velocity-window"});
}

TEST_F(CommandLine, RefusesInvalidRunSettings) {
  const auto expect = [&](const std::vector<std::string>& more,
                          const std::vector<std::string>& names) {
    std::vector<std::string> arguments{"run", kStar, "--virtual"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refused(arguments, names);
  };
  for (const char* seconds : {"nan", "inf", "0", "-3", "1e300"}) {
    expect({"--seconds", seconds}, {"--seconds"});
  }
  expect({"--rate", "1e12"}, {"--rate"});
  expect({"--rate", "1e-12"}, {"--rate"});
  expect({"--workspace", "nan"}, {"--workspace"});
  expect({"--workspace", "-1"}, {"--workspace"});
  expect({"--seed", "-1"}, {"--seed"});
  expect({"--plane-height", "1"}, {"--plane-height", "-0.02", "0.02"});
  expect({"--plane-height", "nan"}, {"--plane-height"});
  expect({"--place", "0 0 1 1 0 0 0", "--plane-height", "0"}, {"--plane-height"});
}

// ---- bad input ---------------------------------------------------------------------------------

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
  const Outcome o = call({"info", kStar}, "/dev/full");
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}

// ---- part, size and motion of a scene ----------------------------------------------------------

TEST_F(CommandLine, ListsTheNodesOfAScene) {
  EXPECT_EQ(expect_done({"info", kStar, "--list"}).out,
            std::string(kStar) + "\n  star  #0  mesh\n");
  const json list = json::parse(expect_done({"info", kStar, "--list", "--json"}).out);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0]["name"], "star");
  EXPECT_EQ(list[0]["number"], 0);
  EXPECT_TRUE(list[0]["parent"].is_null());
}

TEST_F(CommandLine, LoadsAPartInAnySize) {
  const auto extent = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", kCube, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(expect_done(arguments).out)["extent_m"][0].get<double>();
  };
  const double as_it_is = extent({});
  EXPECT_EQ(extent({"--scale", "0.25"}), 0.25 * as_it_is);
  EXPECT_NEAR(extent({"--fit", "0.3"}), 0.3, 1e-15);
  EXPECT_EQ(extent({"--node", "cube"}), as_it_is);
  EXPECT_EQ(extent({"--node", "#0"}), as_it_is);
}

TEST_F(CommandLine, RefusesUnknownNodesAndInvalidSizes) {
  expect_refused({"info", kCube, "--node", "sphere"}, {kCube, "sphere", "--list"});
  for (const char* size : {"0", "-1", "nan", "inf", "1e-400"}) {
    expect_refused({"info", kCube, "--scale", size}, {"--scale"});
    expect_refused({"info", kCube, "--fit", size}, {"--fit"});
  }
  expect_refused({"info", kCube, "--fit", "1", "--scale", "1"}, {"--fit", "--scale"});
}

// A triangle whose node moves from x = 0 to 4 within two seconds, and another clip.
GltfBuilder moving_triangle() {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  const auto clip = [&](const char* name, float x) {
    const auto times = gltf.add_view(test::bytes_of(std::vector<float>{0, 2}));
    const auto values = gltf.add_view(test::bytes_of(std::vector<float>{0, 0, 0, x, 0, 0}));
    const auto input = gltf.add_accessor(times, GltfBuilder::kFloat, 2, "SCALAR");
    const auto output = gltf.add_accessor(values, GltfBuilder::kFloat, 2, "VEC3");
    gltf.json["animations"].push_back(
        {{"name", name},
         {"samplers", {{{"input", input}, {"output", output}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
  };
  clip("Go", 4);
  clip("Jump", 40);
  return gltf;
}

TEST_F(CommandLine, PosesASceneByOneAnimationAtOneTime) {
  const std::string path = moving_triangle().write_glb(folder);
  const auto info = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", path, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json::parse(expect_done(arguments).out);
  };
  const json at_rest = info({});
  EXPECT_TRUE(at_rest["pose"].is_null());
  EXPECT_EQ(at_rest["animations"], json({{{"number", 0}, {"name", "Go"}, {"length_s", 2.0}},
                                         {{"number", 1}, {"name", "Jump"}, {"length_s", 2.0}}}));
  EXPECT_EQ(at_rest["bounding_box"]["min_m"], json({0.0, 0.0, 0.0}));
  const json posed = info({"--pose", "Go@0.5", "--scale", "2"});
  EXPECT_EQ(posed["pose"], json({{"number", 0}, {"name", "Go"}, {"time_s", 0.5}}));
  EXPECT_EQ(posed["bounding_box"]["min_m"], json({2.0, 0.0, 0.0}));
  EXPECT_EQ(posed["bounding_box"]["max_m"], json({4.0, 2.0, 0.0}));
  EXPECT_EQ(posed["bounding_box"]["centre_m"], json({3.0, 1.0, 0.0}));
  const std::string text = expect_done({"info", path, "--pose", "#1@1"}).out;
  for (const char* line : {"\n  animation #0 \"Go\", 2 s\n", "\n  animation #1 \"Jump\", 2 s\n",
                           "\n  pose: animation #1 \"Jump\" at 1 s\n",
                           "\n  bounding box (20, 0, 0) to (21, 1, 0) m, centre (20.5, 0.5, 0) m\n",
                           "\n  contour across A1 through the centre: 0.5 m, open\n",
                           "\n  contour across A3 through the centre: none\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << " is not in " << text;
  }
  const std::string way = folder.write("way.txt", "2.2 0.2 0.1\n2.2 0.2 -0.01\n");
  const auto replayed = [&](const char* pose) {
    return json::parse(
        expect_done({"replay", path, "--trajectory", way, "--json", "--pose", pose}).out);
  };
  EXPECT_EQ(replayed("Go@1")["contact_ticks"], 1);
  EXPECT_EQ(replayed("Go@0")["contact_ticks"], 0);
  EXPECT_NE(expect_done({"replay", path, "--trajectory", way, "--pose", "Go@1"})
                .out.find("pose: animation #0 \"Go\" at 1 s"),
            std::string::npos);
}

TEST_F(CommandLine, RefusesInvalidPoses) {
  const std::string path = moving_triangle().write_glb(folder);
  for (const char* pose : {"Go", "Go@", "Go@x", "Go@-1", "Go@nan", "@1", "Went@0", "#2@0"}) {
    expect_refused({"info", path, "--pose", pose}, {pose, "#0 \"Go\" of 2 s, #1 \"Jump\" of 2 s"});
  }
  expect_refused({"info", path, "--pose", ""}, {"--pose"});
  expect_refused({"run", path, "--virtual", "--pose", "Went@0"}, {"Went"});
  const std::string way = folder.write("way.txt", "0 0 1\n");
  expect_refused({"replay", path, "--trajectory", way, "--pose", "Went@0"}, {"Went"});
  expect_refused({"accuracy", path, "--quick", "--pose", "Went@0"}, {"Went"});
  expect_refused({"info", kStar, "--pose", "Go@0"}, {"Go@0", "no animation"});
}

TEST_F(CommandLine, MovesNodesTheSameWayEveryTime) {
  write_path();
  const auto trace = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = replay({"--out", folder.path("trace.csv")});
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_done(arguments);
    return without_times(content_of(folder.path("trace.csv")));
  };
  const std::string resting = trace({});
  const std::string moving = trace({"--move", "star=0.2 0 0 0 0 3"});
  EXPECT_NE(moving, resting);
  EXPECT_EQ(trace({"--move", "star=0.2 0 0 0 0 3"}), moving);
  EXPECT_EQ(trace({"--move", "star=0 0 0 0 0 0"}), resting);
}

TEST_F(CommandLine, DampsByTheChosenVelocityEstimator) {
  write_path();
  const auto trace = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments =
        replay({"--damping", "5", "--out", folder.path("trace.csv")});
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_done(arguments);
    return without_times(content_of(folder.path("trace.csv")));
  };
  const std::string one_tick = trace({});
  const std::string longer = trace({"--velocity-window", "8"});
  const std::string fitted = trace({"--velocity-window", "8", "--velocity-estimator", "line"});
  const std::string adaptive = trace(
      {"--velocity-window", "8", "--velocity-estimator", "adaptive", "--encoder-quantum", "1e-6"});
  EXPECT_NE(longer, one_tick);
  EXPECT_NE(fitted, longer);
  EXPECT_NE(adaptive, longer);
  EXPECT_NE(adaptive, fitted);
  EXPECT_EQ(trace({"--velocity-window", "1", "--velocity-estimator", "line"}), one_tick);
}

TEST_F(CommandLine, RefusesInvalidMotions) {
  write_path();
  for (const char* move : {"star", "star=", "star=1 2 3", "=0 0 0 0 0 0", "star=0 0 0 0 0 x",
                           "star=0 0 0 0 0 0 0", "star=0 0 0 0 0 inf"}) {
    expect_refused(replay({"--move", move}), {"--move"});
  }
  expect_refused(replay({"--move", "moon=0 0 0 0 0 0"}), {"moon", "--list"});
}

// ---- info --------------------------------------------------------------------------------------

TEST_F(CommandLine, DescribesASceneInJson) {
  const Outcome o = expect_done({"info", kCube, "--json"});
  EXPECT_EQ(o.err, "");
  const json info = json::parse(o.out);
  EXPECT_EQ(keys_of(info), sorted({"hidden_nodes",
                                   "scenes",
                                   "nodes",
                                   "meshes",
                                   "instances",
                                   "triangles_in",
                                   "triangles",
                                   "instanced_triangles",
                                   "vertices",
                                   "dropped",
                                   "split_vertices",
                                   "boundary_edges",
                                   "non_manifold_edges",
                                   "joined",
                                   "gaps_joined",
                                   "nearest_gap_m",
                                   "node_seams",
                                   "extent_m",
                                   "bounding_box",
                                   "contours",
                                   "animations",
                                   "pose",
                                   "effects",
                                   "load_ms",
                                   "memory_bytes",
                                   "memory",
                                   "indices",
                                   "scale",
                                   "notes",
                                   "materials",
                                   "scene_parameters",
                                   "regions",
                                   "warnings"}));
  EXPECT_EQ(keys_of(info["dropped"]), sorted({"degenerate", "duplicate"}));
  EXPECT_EQ(keys_of(info["load_ms"]), sorted({"parse", "mesh", "index"}));
  EXPECT_EQ(info["triangles_in"], 12);
  EXPECT_EQ(info["triangles"], 12);
  EXPECT_EQ(info["vertices"], 8);
  EXPECT_EQ(info["boundary_edges"], 0);
  ASSERT_EQ(info["materials"].size(), 1u);
  EXPECT_EQ(info["materials"][0]["name"], "solid");
  EXPECT_EQ(info["materials"][0]["parameters"], json::object());
  EXPECT_EQ(info["materials"][0]["effects"], json::array());
  EXPECT_EQ(info["regions"], json::array());
  EXPECT_EQ(info["effects"], json::array());
  EXPECT_EQ(info["warnings"], json::array());
  EXPECT_EQ(info["extent_m"].size(), 3u);
  for (const json& extent : info["extent_m"]) EXPECT_EQ(extent, info["extent_m"][0]);
  EXPECT_GT(info["memory_bytes"], 1000);
  EXPECT_EQ(keys_of(info["memory"]), sorted({"adjacency", "positions", "maps", "index_triangles",
                                             "index_packs", "index_boxes", "places", "effects"}));
  std::size_t sum = 0;
  for (const json& part : info["memory"]) sum += part.get<std::size_t>();
  EXPECT_EQ(info["memory_bytes"], sum);
}

// ---- gaps --------------------------------------------------------------------------------------

// `info` says how far apart open edges are and what closes them; nothing is closed without demand,
// nor beyond the demanded width.
TEST_F(CommandLine, ClosesGapsOnDemandAndSaysSo) {
  const std::string tube = test::slit_tube().write_glb(folder);
  const auto info = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", tube, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = expect_done(arguments);
    return std::pair(json::parse(o.out), o.err);
  };
  const auto [open, silence] = info({});
  EXPECT_EQ(silence, "");
  EXPECT_EQ(open["boundary_edges"], 12);
  EXPECT_EQ(open["joined"]["edges"], 0);
  EXPECT_EQ(open["gaps_joined"]["edges"], 0);
  EXPECT_FALSE(open["contours"][2]["closed"].get<bool>());
  const double gap_m = open["nearest_gap_m"];
  EXPECT_NEAR(gap_m, test::kSlit_m, 1e-9);
  // The text states the width that closes the gap, and that width does.
  const std::string text = expect_done({"info", tube}).out;
  const std::string before = " m apart; --close-gaps ";
  const std::size_t at = text.find(before);
  ASSERT_NE(at, std::string::npos) << text;
  const std::size_t begin = at + before.size();
  const std::string width = text.substr(begin, text.find(' ', begin) - begin);
  EXPECT_EQ(std::stod(width), gap_m);
  for (const std::string& wide : {width, std::string("0.007")}) {
    const auto [closed, said] = info({"--close-gaps", wide});
    EXPECT_EQ(closed["boundary_edges"], 10);
    EXPECT_EQ(closed["gaps_joined"]["edges"], 1);
    EXPECT_EQ(closed["gaps_joined"]["vertices"], 2);
    EXPECT_TRUE(closed["contours"][2]["closed"].get<bool>());
    EXPECT_NE(said.find("--close-gaps joined 1 pairs of edges and 2 vertices"), std::string::npos)
        << said;
  }
  const auto [narrow, said] = info({"--close-gaps", "0.0019"});
  EXPECT_EQ(narrow["boundary_edges"], 12);
  EXPECT_EQ(narrow["gaps_joined"]["edges"], 0);
  EXPECT_NE(said.find("--close-gaps joined 0 pairs of edges"), std::string::npos) << said;
  // In another size, the width is one of the scene as it is loaded.
  const auto [small, of_small] = info({"--scale", "0.1", "--close-gaps", "0.00021"});
  EXPECT_EQ(small["gaps_joined"]["edges"], 1) << of_small;
}

TEST_F(CommandLine, RefusesWidthsThatAreNoGaps) {
  const std::string tube = test::slit_tube().write_glb(folder);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"info", tube}, {"run", tube, "--virtual", "--seconds", "2"}}) {
    for (const char* width :
         {"-0.001", "0", "-0", "nan", "inf", "-inf", "1e-400", "2mm", "", " "}) {
      std::vector<std::string> arguments = command;
      arguments.insert(arguments.end(), {"--close-gaps", width});
      expect_refused(arguments, {"--close-gaps"});
    }
    for (const char* width : {"0.008001", "0.08", "1e300"}) {
      std::vector<std::string> arguments = command;
      arguments.insert(arguments.end(), {"--close-gaps", width});
      expect_refused(arguments, {tube, "--close-gaps", "tenth of the extent", "0.08"});
    }
    std::vector<std::string> arguments = command;
    arguments.push_back("--close-gaps");
    expect_refused(arguments, {"--close-gaps"});
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("out")));
}

// The hand follows an open contour to its end and back; the run says so, and closes no gap itself.
TEST_F(CommandLine, ARunSaysThatItsContourIsOpen) {
  const std::string tube = test::slit_tube().write_glb(folder);
  const std::vector<std::string> run{"run", tube, "--virtual", "--seconds", "2", "--a4", "on"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = run;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return expect_run(arguments);
  };
  const std::string line = "! the contour is open";
  EXPECT_NE(with({}).out.find(line), std::string::npos);
  EXPECT_EQ(json::parse(with({"--json"}).out)["runs"][0]["contour_closed"], false);
  const Outcome closed = with({"--close-gaps", "0.0021"});
  EXPECT_EQ(closed.out.find(line), std::string::npos) << closed.out;
  EXPECT_EQ(
      json::parse(with({"--close-gaps", "0.0021", "--json"}).out)["runs"][0]["contour_closed"],
      true);
  // Once, although the scene may be loaded again for other trials.
  const std::string said = "--close-gaps joined 1 pairs of edges and 2 vertices";
  const std::size_t at = closed.err.find(said);
  ASSERT_NE(at, std::string::npos) << closed.err;
  EXPECT_EQ(closed.err.find(said, at + 1), std::string::npos) << closed.err;
  // The line is about the boundary of a surface, not about the sample that ends a closed contour.
  EXPECT_EQ(expect_run({"run", kStar, "--virtual", "--seconds", "2"}).out.find(line),
            std::string::npos);
}

// Two boxes, 1 mm apart.
TEST_F(CommandLine, ClosesGapsBetweenNodesOnDemand) {
  GltfBuilder gltf = test::slit_tube();
  const auto mesh = json::parse(R"({"mesh": 0, "name": "right", "translation": [0.081, 0, 0]})");
  gltf.add_node(mesh);
  const std::string boxes = gltf.write_glb(folder);
  const auto seams = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"info", boxes, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = expect_done(arguments);
    return std::pair(json::parse(o.out)["node_seams"], o.err);
  };
  // Texts of the library name the option.
  const std::string text = expect_done({"info", boxes, "--close-gaps", "0.0015"}).out;
  EXPECT_NE(text.find("seams: "), std::string::npos) << text;
  EXPECT_EQ(text.find("SceneSettings"), std::string::npos) << text;
  const json open = seams({}).first;
  EXPECT_EQ(open["places"], 0);
  EXPECT_EQ(open["changed_nodes"], 0);
  const auto [closed, said] = seams({"--close-gaps", "0.0015"});
  EXPECT_GT(closed["places"], 3);
  EXPECT_EQ(closed["changed_nodes"], 1);
  EXPECT_NE(said.find("moved 1 nodes"), std::string::npos) << said;
}

// The hint appears if `run` refuses the size.
TEST_F(CommandLine, HintsAtFitForScenesThatDoNotFitTheWorkspace) {
  const std::string hint = "run it with --fit auto";
  EXPECT_EQ(expect_done({"info", kStar}).out.find(hint), std::string::npos);
  for (const std::string size : {"4", "0.003"}) {
    const std::string text = expect_done({"info", kCube, "--fit", size}).out;
    EXPECT_NE(text.find("\n  size: " + size + " x " + size + " x " + size +
                        " m; a device's workspace is 0.4 m: " + hint + "\n"),
              std::string::npos)
        << text;
    expect_refused({"run", kCube, "--virtual", "--fit", size}, {"--fit auto"});
  }
}

TEST_F(CommandLine, PrintsTheParametersOfMaterials) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json["materials"] = {
      {{"name", "a \"b\"\n"},
       {"extras",
        {{"palpate", {{"stiffness", 800}, {"texture", {{"amplitude", 0.5}}}, {"on", true}}}}}},
      {{"name", "paint"}}};
  json& primitives = gltf.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  for (std::size_t i = 0; i < 2; ++i) primitives[i]["material"] = i;
  const std::string path = gltf.write_glb(folder);
  const json info = json::parse(expect_done({"info", path, "--json"}).out);
  const json declared = {{"stiffness", 800}, {"texture.amplitude", 0.5}, {"on", true}};
  ASSERT_EQ(info["materials"].size(), 2u);
  EXPECT_EQ(info["materials"][0]["name"], "a \"b\"\n");
  EXPECT_EQ(info["materials"][0]["parameters"], declared);
  EXPECT_EQ(info["materials"][1]["name"], "paint");
  EXPECT_EQ(info["materials"][1]["parameters"], json::object());
  const std::string text = expect_done({"info", path}).out;
  EXPECT_NE(text.find("\n  material \"a \\\"b\\\"\\n\": on true, stiffness 800.0, "
                      "texture.amplitude 0.5\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("paint"), std::string::npos) << text;
}

// A triangle in the plane z = 0 whose material has these extras.
GltfBuilder triangle_of(const json& palpate) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.json["materials"] = {{{"name", "wood.1"}, {"extras", {{"palpate", palpate}}}}};
  gltf.json["meshes"][0]["primitives"][0]["material"] = 0;
  return gltf;
}

TEST_F(CommandLine, ReportsAppliedAndIgnoredValues) {
  GltfBuilder gltf = triangle_of({{"staticFriction", 0.5}, {"restitution", 0.0}, {"hue", 3}});
  gltf.json["extensionsUsed"] = {"KHR_physics_rigid_bodies"};
  gltf.json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"] = {
      {{"staticFriction", 0.7}, {"dynamicFriction", 0.4}, {"restitution", 0.0}}};
  gltf.json["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"]["collider"] = {
      {"physicsMaterial", 0}};
  const std::string path = gltf.write_glb(folder);
  const json info =
      json::parse(expect_done({"info", path, "--json", "--material", "wood.1.stiffness=800"}).out);
  EXPECT_EQ(info["effects"], json({"friction", "stiffness"}));
  const json& wood = info["materials"][0];
  EXPECT_EQ(wood["effects"], json({"friction", "stiffness"}));
  EXPECT_EQ(wood["parameters"]["stiffness"], 800);
  std::vector<std::string> values;
  for (const json& h : wood["honoured"]) {
    values.push_back(h["key"].get<std::string>() + " " + h["value"].dump() + " " +
                     h["unit"].get<std::string>() + " " + h["source"].get<std::string>() +
                     (h["off"] ? " off" : ""));
  }
  std::sort(values.begin(), values.end());
  EXPECT_EQ(values, (std::vector<std::string>{"dynamicFriction 0.4  KHR_physics_rigid_bodies",
                                              "restitution 0.0  extras.palpate off",
                                              "staticFriction 0.5  extras.palpate",
                                              "stiffness 800.0 N/m --material"}));
  ASSERT_EQ(wood["not_understood"].size(), 1u);
  EXPECT_EQ(wood["not_understood"][0]["element"], "/materials/0/extras/palpate/hue");
  const std::string text = expect_done({"info", path}).out;
  for (const char* line :
       {"    applied: ", "staticFriction 0.5 (extras.palpate)",
        "restitution 0.0 (extras.palpate, off)", "dynamicFriction 0.4 (KHR_physics_rigid_bodies)",
        "    ignored: hue 3.0", "  effects: friction\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << " is not in " << text;
  }
  EXPECT_GT(info["memory"]["effects"], 0);
}

// An error is one line: warnings are printed only if no error occurs.
TEST_F(CommandLine, WarnsOfIgnoredKeysUnlessAnErrorOccurs) {
  GltfBuilder gltf = triangle_of({{"hue", 3}});
  const std::string path = gltf.write_glb(folder);
  const std::string trajectory = folder.write("path.txt", "0.2 0.2 0.1\n0.2 0.2 -0.1\n");
  const std::vector<std::string> replayed{"replay", path, "--trajectory", trajectory};
  const std::vector<std::string> run{"run", path, "--virtual", "--seconds", "2", "--sensors", "3"};
  const std::string warning =
      "palpate: warning: /materials/0/extras/palpate/hue: hue of \"wood.1\"";
  EXPECT_TRUE(expect_done(replayed).err.starts_with(warning));
  std::vector<std::string> fitted = run;
  fitted.insert(fitted.end(), {"--fit", "0.2"});
  EXPECT_TRUE(expect_run(fitted).err.starts_with(warning));
  for (std::vector<std::string> refused : {replayed, fitted}) {
    refused.insert(refused.end(), {"--move", "moon=0 0 0 0 0 0"});
    expect_refused(refused, {"moon"});
  }
  expect_refused({"run", path, "--virtual", "--fit", "0.2", "--plane-height", "9"},
                 {"--plane-height"});
}

TEST_F(CommandLine, CompletesPhysicsMaterialsThatStateOneCoefficient) {
  GltfBuilder gltf = triangle_of(json::object());
  gltf.json["extensionsUsed"] = {"KHR_physics_rigid_bodies"};
  gltf.json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"] = {
      {{"staticFriction", 0.3}}};
  gltf.json["nodes"][0]["extensions"]["KHR_physics_rigid_bodies"]["collider"] = {
      {"physicsMaterial", 0}};
  const std::string path = gltf.write_glb(folder);
  const json wood = json::parse(expect_done({"info", path, "--json"}).out)["materials"][0];
  ASSERT_EQ(wood["honoured"].size(), 1u);
  EXPECT_EQ(wood["honoured"][0]["element"],
            "/extensions/KHR_physics_rigid_bodies/physicsMaterials/0/staticFriction");
  EXPECT_EQ(wood["defaulted"], json({{{"key", "dynamicFriction"}, {"value", 0.3}, {"unit", ""}}}));
  const json off = json::parse(
      expect_done({"info", path, "--json", "--material", "wood.1.staticFriction=0"}).out);
  EXPECT_EQ(off["effects"], json::array());
}

TEST_F(CommandLine, ReportsTheDefaultsInUse) {
  const std::string path = triangle_of({{"restitution", 0.5}}).write_glb(folder);
  const json info = json::parse(expect_done({"info", path, "--json"}).out);
  EXPECT_EQ(info["materials"][0]["defaulted"],
            json({{{"key", "impactMass"}, {"value", 0.05}, {"unit", "kg"}},
                  {{"key", "impactDuration"}, {"value", 0.005}, {"unit", "s"}}}));
}

TEST_F(CommandLine, RefusesInvalidMaterialValues) {
  const std::string good = triangle_of({{"stiffness", 500}}).write_glb(folder);
  expect_refused({"info", good, "--material", "wood.1.stiffness=-1"},
                 {"--material wood.1.stiffness", "wood.1", "stiffness is -1", "1e+06 N/m"});
  expect_refused({"info", good, "--material", "wood.1.stiffness=hard"},
                 {"wood.1", "stiffness is \"hard\"", "N/m"});
  expect_refused({"info", good, "--material", "glass.stiffness=1"}, {"--material", "glass"});
  expect_refused(
      {"info", good, "--material", "wood.1.stiffnes=1"},
      {"--material wood.1.stiffnes", "wood.1", "use one of the keys solid, stiffness, "});
  for (const char* none : {"stiffness=1", "wood.1.stiffness", "=1", ".stiffness=1", "wood.1.=1",
                           "wood.1.stiffness="}) {
    expect_refused({"info", good, "--material", none}, {"--material", none});
  }
  write_path();
  const std::vector<std::string> play = {"--trajectory", folder.path("path.txt")};
  std::vector<std::string> hum = {"replay",     good,
                                  "--material", "wood.1.vibrationAmplitude=1",
                                  "--material", "wood.1.vibrationFrequency=600"};
  hum.insert(hum.end(), play.begin(), play.end());
  expect_refused(hum, {"wood.1", "vibrationFrequency is 600", "--rate", "500 Hz"});
  hum.insert(hum.end(), {"--rate", "2000"});
  expect_done(hum);

  const std::string bad = triangle_of({{"magnetForce", 1}}).write_glb(folder);
  expect_refused({"info", bad},
                 {bad, "/materials/0/extras/palpate/magnetForce", "wood.1", "magnetRange"});
}

TEST_F(CommandLine, CountsTheTicksInWhichAnEffectIsActive) {
  const std::string scene =
      triangle_of({{"stiffness", 500}, {"dynamicFriction", 0.2}, {"staticFriction", 0.3}})
          .write_glb(folder);
  std::ostringstream path;
  for (int n = 0; n < 100; ++n) path << "0.3 0.3 " << 0.05 - 0.001 * n << "\n";
  for (int n = 0; n < 50; ++n) path << 0.3 + 0.004 * n << " 0.3 -0.049\n";
  const std::string file = folder.write("press.txt", path.str());
  const json plain =
      json::parse(expect_done({"replay", scene, "--trajectory", file, "--json"}).out);
  EXPECT_EQ(keys_of(plain["effects"]), sorted({"friction", "stiffness", "a4"}));
  EXPECT_EQ(plain["effects"]["stiffness"], json({{"ticks", plain["contact_ticks"]}}));
  EXPECT_EQ(plain["effects"]["friction"]["ticks"], plain["contact_ticks"]);
  EXPECT_EQ(plain["effects"]["a4"]["ticks"], 0);
  EXPECT_GT(plain["contact_ticks"], 90);
  const json timed = json::parse(
      expect_done({"replay", scene, "--trajectory", file, "--json", "--effect-times", "--repeat",
                   "3", "--sensors", "3", "--actuated-axes", "1 0 0", "--a4", "on"})
          .out);
  EXPECT_EQ(timed["effects"]["stiffness"]["ticks"], timed["contact_ticks"]);
  EXPECT_GT(timed["effects"]["stiffness"]["time_share"], 0.0);
  EXPECT_LT(timed["effects"]["stiffness"]["time_share"], 1.0);
  EXPECT_GT(timed["effects"]["a4"]["ticks"], 0);
  EXPECT_LE(timed["effects"]["a4"]["ticks"], timed["contact_ticks"]);
  const std::string text = expect_done({"replay", scene, "--trajectory", file}).out;
  EXPECT_NE(text.find("friction active in " + plain["contact_ticks"].dump() + " ticks\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("A4 turned the scene in 0 ticks"), std::string::npos) << text;
}

// Pressed to 49 mm, the hand moves sideways in steps of 4 mm: it sticks to 14.7 mm and slides on
// from there, at 0.2 of the normal force.
TEST_F(CommandLine, WritesToTheTraceWhetherAContactSticksOrSlides) {
  const std::string scene =
      triangle_of({{"dynamicFriction", 0.2}, {"staticFriction", 0.3}}).write_glb(folder);
  std::ostringstream path;
  path << "0.3 0.3 0.01\n0.3 0.3 -0.049\n";
  for (int n = 1; n <= 20; ++n) path << 0.3 + 0.004 * n << " 0.3 -0.049\n";
  const std::string file = folder.write("press.txt", path.str());
  const std::string out = folder.path("trace.csv");
  expect_done({"replay", scene, "--trajectory", file, "--out", out});
  const auto rows = rows_of(content_of(out));
  ASSERT_EQ(rows.size(), 22u);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const char* expected = n == 0 ? "none" : n <= 4 ? "sticks" : "slides";
    EXPECT_EQ(rows[n][26], expected) << n;
    if (n <= 4) continue;
    EXPECT_NEAR(std::stod(rows[n][14]), -0.2 * std::stod(rows[n][16]), 1e-9) << n;
  }
}

TEST_F(CommandLine, CountsTheTrianglesOfEveryNode) {
  GltfBuilder gltf = GltfBuilder::one_triangle();
  gltf.add_node({{"mesh", 0}, {"translation", {5, 0, 0}}});
  gltf.add_node({{"mesh", 0}, {"scale", {0, 0, 0}}, {"name", "vanished"}});
  const json info = json::parse(expect_done({"info", gltf.write_glb(folder), "--json"}).out);
  EXPECT_EQ(info["nodes"], 3);
  EXPECT_EQ(info["meshes"], 1);
  EXPECT_EQ(info["instances"], 2);
  EXPECT_EQ(info["triangles"], 1);
  EXPECT_EQ(info["instanced_triangles"], 2);
  ASSERT_EQ(info["warnings"].size(), 1u);
  EXPECT_NE(info["warnings"][0].get<std::string>().find("vanished"), std::string::npos);
}

TEST_F(CommandLine, DescribesASceneAsText) {
  const Outcome o = expect_done({"info", kStar});
  EXPECT_NE(o.out.find("36 of 36"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("extent"), std::string::npos);
}

// ---- replay ------------------------------------------------------------------------------------

TEST_F(CommandLine, ReplaysATrajectoryIntoATraceOfTheAgreedColumns) {
  write_path();
  expect_done(replay({"--out", folder.path("trace.csv")}));
  const std::string csv = content_of(folder.path("trace.csv"));
  EXPECT_TRUE(lines_of(csv).at(0).starts_with(
      "tick,t,device_x,device_y,device_z,goal_x,goal_y,goal_z,proxy_x,proxy_y,proxy_z,"
      "normal_x,normal_y,normal_z,force_x,force_y,force_z,contact,alpha_deg,"
      "q_w,q_x,q_y,q_z,o_x,o_y,o_z,friction,faults,step_ns,"))
      << "new columns come last";
  const auto rows = rows_of(csv);
  ASSERT_EQ(rows.size(), 250u);
  int contact_ticks = 0;
  for (std::size_t n = 0; n < rows.size(); ++n) {
    ASSERT_EQ(rows[n].size(), 43u);
    EXPECT_EQ(rows[n][0], std::to_string(n));
    EXPECT_NEAR(std::stod(rows[n][1]), 1e-3 * static_cast<double>(n), 1e-12);
    ASSERT_TRUE(rows[n][17] == "0" || rows[n][17] == "1");
    contact_ticks += rows[n][17] == "1";
    EXPECT_EQ(rows[n][26], "none") << "of friction";
    EXPECT_EQ(rows[n][27], "") << "no fault";
    EXPECT_GE(std::stoll(rows[n][28]), 0);
    if (rows[n][17] == "1") continue;
    for (std::size_t column : {11, 12, 13, 14, 15, 16, 18}) EXPECT_EQ(rows[n][column], "0");
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(rows[n][5 + axis], rows[n][8 + axis]);
  }
  EXPECT_GT(contact_ticks, 20);
  EXPECT_LT(contact_ticks, 250);
  EXPECT_EQ(rows[1][2], "0.1195") << "17 significant digits are those the number needs";
}

// The columns agree with each other in their frames and units.
TEST_F(CommandLine, WritesTracesThatAddUp) {
  write_path();
  const double turn = std::sqrt(0.5);  // the scene lies turned by 90 deg: x_device = -y_scene
  std::ostringstream turned;
  for (const std::string& line : lines_of(content_of(folder.path("path.txt")))) {
    std::istringstream numbers(line);
    double x = 0.0;
    double y = 0.0;
    numbers >> x >> y;
    turned << -y << " " << x << " 0.5\n";
  }
  const std::string path = folder.write("turned.txt", turned.str());
  const std::string out = folder.path("trace.csv");
  expect_done({"replay", kStar, "--trajectory", path, "--place",
               "0 0 0.5 0.70710678118654757 0 0 0.70710678118654757", "--sensors", "2",
               "--actuators", "1", "--force", "full", "--stiffness", "500", "--plane-height", "0.5",
               "--out", out});
  int contact_ticks = 0;
  for (const auto& row : rows_of(content_of(out))) {
    const auto vector = [&](std::size_t i) {
      return Vec3(std::stod(row[i]), std::stod(row[i + 1]), std::stod(row[i + 2]));
    };
    const Vec3 device = vector(2), goal = vector(5), proxy = vector(8), normal = vector(11);
    const auto to_device = [](const Vec3& v) { return Vec3(-v.y(), v.x(), v.z()); };
    EXPECT_NEAR(std::stod(row[19]), turn, 1e-15);
    EXPECT_EQ(vector(23), Vec3(0, 0, 0.5));
    EXPECT_LE((to_device(goal) + Vec3(0, 0, 0.5) - device).norm(), 1e-15);
    if (row[17] == "0") continue;
    ++contact_ticks;
    EXPECT_NEAR(normal.norm(), 1.0, 1e-14);
    EXPECT_GT(normal.dot(proxy - goal), 0.0) << "from the surface to the proxy's side";
    EXPECT_LE((500.0 * to_device(proxy - goal) - vector(14)).norm(), 1e-10);
    const double alpha_deg = std::acos(std::min(1.0, std::abs(to_device(normal).x()))) * 180 / M_PI;
    EXPECT_NEAR(std::stod(row[18]), alpha_deg, 1e-6);
  }
  EXPECT_GT(contact_ticks, 50);
}

TEST_F(CommandLine, WritesTheSameTraceEveryTimeExceptMeasuredTimes) {
  write_path();
  const std::vector<std::vector<std::string>> ways{
      {}, {"--sensors", "2", "--actuators", "1", "--a4", "on", "--damping", "2"}};
  for (const auto& way : ways) {
    for (const char* name : {"a.csv", "b.csv"}) {
      auto arguments = replay(way);
      arguments.insert(arguments.end(), {"--out", folder.path(name)});
      if (name[0] == 'b') arguments.insert(arguments.end(), {"--repeat", "3"});
      expect_done(arguments);
    }
    const std::string a = content_of(folder.path("a.csv"));
    EXPECT_EQ(without_times(a), without_times(content_of(folder.path("b.csv"))));
    EXPECT_GT(a.size(), 10000u);
  }
}

TEST_F(CommandLine, SummarisesAReplayInJson) {
  write_path();
  const Outcome o = expect_done(replay({"--json", "--out", folder.path("trace.csv")}));
  EXPECT_EQ(o.err, "");
  const json summary = json::parse(o.out);
  auto expected = kSummaryKeys;
  expected.emplace_back("starts_inside");
  EXPECT_EQ(keys_of(summary), sorted(expected));
  EXPECT_NE(summary["step_ns_clock"].get<std::string>().find("this machine"), std::string::npos);
  EXPECT_EQ(keys_of(summary["step_ns"]), sorted({"p50", "p99", "p999", "max"}));
  EXPECT_EQ(keys_of(summary["faults"]),
            sorted({"non_finite_sample", "bad_time_step", "solver_capped", "jump", "body_held",
                    "bad_body_pose", "non_finite_force", "far_sample", "bad_settings",
                    "invalid_sample", "bad_actuation", "effects_capped"}));
  // The figures are those of the trace.
  int contact_ticks = 0;
  int losses = 0;
  double penetration_sum_m = 0.0;
  std::string before = "0";
  for (const auto& row : rows_of(content_of(folder.path("trace.csv")))) {
    const auto number = [&](std::size_t i) { return std::stod(row[i]); };
    losses += before == "1" && row[17] == "0";
    before = row[17];
    if (row[17] != "1") continue;
    ++contact_ticks;
    penetration_sum_m +=
        std::hypot(number(8) - number(5), number(9) - number(6), number(10) - number(7));
  }
  EXPECT_EQ(summary["ticks"], 250);
  EXPECT_EQ(summary["contact_ticks"], contact_ticks);
  EXPECT_EQ(summary["losses_of_contact"], losses);
  EXPECT_NEAR(summary["mean_penetration_m"], penetration_sum_m / contact_ticks, 1e-15);
  EXPECT_EQ(summary["work_lost_J"], 0.0) << "every axis pushes";
  EXPECT_EQ(summary["triangles"], 36);
  EXPECT_EQ(summary["effects"], json({{"a4", {{"ticks", 0}}}}));
}

TEST_F(CommandLine, SummarisesAReplayAsText) {
  write_path();
  const std::string out = expect_done(replay({})).out;
  for (const char* what : {"ticks 250", "penetration", "contact angle", "work", "faults: none"}) {
    EXPECT_NE(out.find(what), std::string::npos) << what << " is not in " << out;
  }
}

TEST_F(CommandLine, RecordsNanAndInfSamplesAsFaults) {
  folder.write("path.txt", "0.12 0 0\n0.05 0 0\nnan 0 0\n0.05 0 0\n0 inf 0\n0.04 0 0\n");
  const auto arguments = replay({"--json", "--out", folder.path("trace.csv")});
  const json summary = json::parse(expect_done(arguments).out);
  EXPECT_EQ(summary["ticks"], 6);
  EXPECT_EQ(summary["faults"]["non_finite_sample"], 2);
  const auto rows = rows_of(content_of(folder.path("trace.csv")));
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[2][2], "nan");
  EXPECT_EQ(rows[4][3], "inf");
  for (const std::size_t bad : {2u, 4u}) {
    for (std::size_t force = 14; force < 17; ++force) EXPECT_EQ(rows[bad][force], "0");
  }
  for (const std::size_t good : {1u, 3u, 5u}) {
    EXPECT_EQ(rows[good][17], "1");
    EXPECT_NE(rows[good][14], "0");
  }
}

// The summary counts faults by name; the trace names the faults of each tick.
TEST_F(CommandLine, NamesTheFaultsOfEachTick) {
  folder.write("path.txt", "0.12 0 0\n0.05 0 0\n1e30 0 0\nnan 0 0\n-3 0 0\n0.05 0 0\n");
  const auto arguments = replay({"--json", "--out", folder.path("trace.csv")});
  const json summary = json::parse(expect_done(arguments).out);
  EXPECT_EQ(summary["faults"]["far_sample"], 1);
  EXPECT_EQ(summary["faults"]["non_finite_sample"], 1);
  EXPECT_EQ(summary["faults"]["jump"], 1);
  EXPECT_EQ(summary["faults"]["bad_settings"], 0);
  const auto rows = rows_of(content_of(folder.path("trace.csv")));
  ASSERT_EQ(rows.size(), 6u);
  const char* expected[] = {"", "", "far_sample", "non_finite_sample", "jump", ""};
  for (std::size_t n = 0; n < rows.size(); ++n) EXPECT_EQ(rows[n][27], expected[n]) << n;
  EXPECT_EQ(rows[2][17], "1");
  EXPECT_EQ(rows[2][14], "0");
  const std::string text = expect_done(replay({})).out;
  EXPECT_NE(text.find("1 far_sample"), std::string::npos) << text;
}

TEST_F(CommandLine, ReadsTrajectoriesWithHeaderTimesAndComments) {
  folder.write("path.txt",
               "t,x,y,z\n# a comment\n0,0.12,0,0\n0.5,0.11,0,0 # another\n\n9,0.1,0,0\n");
  const json summary = json::parse(expect_done(replay({"--json"})).out);
  EXPECT_EQ(summary["ticks"], 3);
}

// Compares all columns except measured times: device, goal, proxy, normal, force, pose, friction,
// faults.
TEST_F(CommandLine, ReplaysTheTraceOfARunToTheSameTrace) {
  const std::vector<std::vector<std::string>> devices{
      {"--sensors", "2", "--actuators", "1", "--damping", "2"},
      {"--sensors", "2", "--actuated-axes", "0.6 0.8 0", "--damping", "0.5", "--radius", "0.001"},
      {"--sensors", "3", "--actuators", "2", "--damping", "2", "--rate", "2000"},
      {"--sensors", "2", "--actuators", "1", "--damping", "2", "--move", "star=0.002 0 0 0 0 0.1"}};
  for (const auto& device : devices) {
    for (const char* a4 : {"on", "off"}) {
      const std::string trace = std::string("out/trace-") + a4 + ".csv";
      std::vector<std::string> run{"run", kStar, "--virtual", "--seconds", "4", "--a4", a4};
      run.insert(run.end(), device.begin(), device.end());
      expect_run(run);
      std::vector<std::string> again{"replay", kStar, "--trajectory", trace,
                                     "--a4",   a4,    "--out",        "again.csv"};
      again.insert(again.end(), device.begin(), device.end());
      expect_done(again);
      const std::string csv = content_of(folder.path(trace));
      EXPECT_GE(lines_of(csv).size(), 4001u);
      EXPECT_TRUE(without_times(csv) == without_times(content_of(folder.path("again.csv"))))
          << a4 << " " << device[1];
    }
  }
}

TEST_F(CommandLine, ReplaysTheFaultsOfATrace) {
  folder.write("path.txt", "0.12 0 0\n0.05 0 0\nnan 0 0\n0.05 0 0\n0 inf 0\n0.04 0 0\n");
  expect_done(replay({"--out", folder.path("first.csv")}));
  expect_done({"replay", kStar, "--trajectory", "first.csv", "--out", "again.csv"});
  EXPECT_EQ(without_times(content_of(folder.path("again.csv"))),
            without_times(content_of(folder.path("first.csv"))));
}

TEST_F(CommandLine, UsesTheTimeStepOfTheRateForAFileWithoutTimes) {
  folder.write("path.txt", "0.12 0 0\n0.11 0 0\n0.1 0 0\n");
  expect_done(replay({"--rate", "4000", "--out", folder.path("trace.csv")}));
  const auto rows = rows_of(content_of(folder.path("trace.csv")));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1][1], "0.00025000000000000001");
  EXPECT_EQ(rows[2][1], "0.00050000000000000001");
}

TEST_F(CommandLine, AcceptsActuatedAxesInPlaceOfTheirNumber) {
  write_path();
  const auto trace = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--out", folder.path("trace.csv"), "--a4", "on"});
    expect_done(replay(more));
    return without_times(content_of(folder.path("trace.csv")));
  };
  const std::string counted = trace({"--sensors", "2", "--actuators", "1"});
  EXPECT_EQ(trace({"--sensors", "2", "--actuated-axes", "1 0 0"}), counted);
  EXPECT_EQ(trace({"--sensors", "2", "--actuated-axes", "3 0 0", "--actuators", "1"}), counted);
  EXPECT_NE(trace({"--sensors", "2", "--actuated-axes", "0 1 0"}), counted);
}

// --force none, actuated and full command no force, its actuated part, and all of it.
TEST_F(CommandLine, CommandsTheChosenForce) {
  write_path();
  const auto forces = [&](const char* force) {
    expect_done(replay({"--sensors", "2", "--actuators", "1", "--force", force, "--out",
                        folder.path("trace.csv")}));
    return rows_of(content_of(folder.path("trace.csv")));
  };
  const auto none = forces("none");
  const auto actuated = forces("actuated");
  const auto full = forces("full");
  int with_sideways_force = 0;
  for (std::size_t n = 0; n < full.size(); ++n) {
    EXPECT_EQ(none[n][14], "0");
    EXPECT_EQ(none[n][15], "0");
    EXPECT_EQ(actuated[n][14], full[n][14]);
    EXPECT_EQ(actuated[n][15], "0");
    with_sideways_force += full[n][15] != "0";
    EXPECT_EQ(none[n][18], full[n][18]) << "alpha, whatever the force";
  }
  EXPECT_GT(with_sideways_force, 20);
}

// The strategies that force and A4 describe give the traces of these options to the byte.
TEST_F(CommandLine, GivesTheSameTraceByTheNameOfAStrategy) {
  write_path();
  const auto trace = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"--sensors", "2", "--actuators", "1"});
    options.insert(options.end(), {"--out", folder.path("trace.csv")});
    expect_done(replay(options));
    return content_of(folder.path("trace.csv"));
  };
  const std::vector<std::vector<std::string>> options = {{"none", "--force", "none"},
                                                         {"mask", "--force", "actuated"},
                                                         {"full", "--force", "full"},
                                                         {"a4", "--a4", "on"}};
  std::set<std::string> traces;
  for (const auto& o : options) {
    const std::string named = trace({"--strategy", o[0]});
    EXPECT_EQ(without_times(named), without_times(trace({o[1], o[2]}))) << o[0];
    traces.insert(without_times(named));
  }
  for (const char* name : {"a4-anticipate", "anisotropic:4", "cd"}) {
    traces.insert(without_times(trace({"--strategy", name})));
  }
  EXPECT_EQ(traces.size(), 7u);
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

TEST_F(CommandLine, PlacesTheSceneInTheDeviceFrame) {
  write_path();
  std::ostringstream moved;  // the same path, turned by 90 deg about z and moved
  for (const std::string& line : lines_of(content_of(folder.path("path.txt")))) {
    std::istringstream numbers(line);
    double x = 0.0;
    double y = 0.0;
    numbers >> x >> y;
    moved << 0.25 - y << " " << -0.5 + x << " 1\n";
  }
  const json there = json::parse(expect_done(replay({"--json"})).out);
  const std::string path = folder.write("moved.txt", moved.str());
  const std::string place = "0.25 -0.5 1 0.70710678118654757 0 0 0.70710678118654757";
  const json here = json::parse(
      expect_done({"replay", kStar, "--trajectory", path, "--place", place, "--json"}).out);
  EXPECT_EQ(here["contact_ticks"], there["contact_ticks"]);
  EXPECT_NEAR(here["mean_penetration_m"], there["mean_penetration_m"], 1e-12);
}

// ---- run ---------------------------------------------------------------------------------------

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

// Means of nothing are neither 0 nor nan, in JSON and in text.
TEST_F(CommandLine, SummarisesAReplayThatTouchesNothingWithoutNumbersThatDoNotExist) {
  folder.write("far.txt", "0 0 60\n0 0 48\n");
  const std::vector<std::string> far{"replay", kStar, "--trajectory", folder.path("far.txt")};
  auto with_json = far;
  with_json.emplace_back("--json");
  const json summary = json::parse(expect_done(with_json).out);
  for (const char* key : {"mean_penetration_m", "max_penetration_m", "mean_contact_angle_deg",
                          "share_within_30deg"}) {
    EXPECT_TRUE(summary[key].is_null()) << key;
  }
  EXPECT_EQ(summary["losses_of_contact"], 0);
  EXPECT_EQ(summary["port_work_J"], 0.0);
  const std::string text = expect_done(far).out;
  EXPECT_NE(text.find("penetration mean -, max -"), std::string::npos) << text;
  EXPECT_NE(text.find("contact angle mean -, within 30 deg -"), std::string::npos) << text;
}

TEST_F(CommandLine, MarksTheTimesOfASimulatedRunAsTimesOfTheMachine) {
  const Outcome run = expect_not_comparable(
      {"run", kStar, "--virtual", "--seconds", "2", "--a4", "off", "--move", "#0=0 0 50 0 0 0"});
  EXPECT_NE(run.out.find("us (3)"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("(3) computing times of this machine"), std::string::npos) << run.out;
}

// The path begins in the middle of the star, and the force is that of before.
TEST_F(CommandLine, NamesTheNodeInsideWhichAPathBegins) {
  folder.write("inside.txt", "0 0 0\n0 0 0.001\n");
  const Outcome o =
      expect_done({"replay", kStar, "--trajectory", folder.path("inside.txt"), "--json"});
  EXPECT_NE(o.err.find("begins inside the closed surface of node \"star\""), std::string::npos)
      << o.err;
  EXPECT_EQ(json::parse(o.out)["starts_inside"], "star");
}

TEST_F(CommandLine, FitsASceneToTheWorkspace) {
  for (const char* scale : {"20", "0.01"}) {
    expect_refused({"run", kStar, "--virtual", "--scale", scale}, {"scene", "--fit 0.2"});
  }
  const json as_it_is =
      json::parse(expect_done({"run", kStar, "--virtual", "--fit", "auto", "--json"}).out);
  EXPECT_EQ(as_it_is["scale"], 1.0) << "it fits";
  const json fitted = json::parse(
      expect_done({"run", kStar, "--virtual", "--fit", "auto", "--json", "--workspace", "0.2"})
          .out);
  EXPECT_LT(fitted["scale"], 1.0);
  EXPECT_EQ(fitted["workspace_m"], 0.2);
  expect_refused({"run", kStar, "--virtual", "--fit", "auto", "--scale", "2"}, {"--fit"});
  expect_refused({"info", kStar, "--fit", "auto"}, {"--fit", "auto", "workspace"});
  expect_refused({"run", kStar, "--virtual", "--fit", "large"}, {"--fit", "auto"});
}

TEST_F(CommandLine, ChoosesThePlaneHeightAfterPlacingTheScene) {
  const json result = json::parse(
      expect_done({"run", kStar, "--virtual", "--place", "0 0 1 1 0 0 0", "--json"}).out);
  EXPECT_EQ(result["plane_height_m"], 1.0);
}

// ---- accuracy ----------------------------------------------------------------------------------

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
  EXPECT_EQ(done.err, "") << "no progress bar where there is no terminal";
}

TEST_F(CommandLine, AccuracyReportsOnAScene) {
  const Outcome done = call({"accuracy", kStar, "--quick", "--knob", "a4_step", "--stiffness",
                             "900", "--device-damping", "0.4", "--encoder-quantum", "0"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("highest servo rate kept"), std::string::npos);
  EXPECT_NE(done.out.find("K 900 N/m, not passive (passive up to 800 N/m)"), std::string::npos)
      << done.out;
  EXPECT_NE(content_of(folder.path("accuracy/report.html")).find("Your scene"), std::string::npos);
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
