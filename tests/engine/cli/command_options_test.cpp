// The options of commands: their help and the values that they refuse.

#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::CommandLine;
using test::content_of;
using test::kStar;
using test::Outcome;
using test::without_times;

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

// ---- values ------------------------------------------------------------------------------------

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
  expect_refused(replay({"--place", "0 0 0,, 1 0 0 0"}), {"--place"});
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

}  // namespace
}  // namespace palpate
