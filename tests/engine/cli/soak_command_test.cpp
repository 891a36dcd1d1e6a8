// The command `soak`, started as a script starts it.

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/run_program.h"

namespace palpate {
namespace {

using test::content_of;
using test::kStar;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

TEST(SoakCommand, ReportsEveryTickWithItsTimes) {
  const TemporaryFolder folder;
  const Outcome done = run_program(folder, {"soak", kStar, "--minutes", "0.05", "--rate", "500",
                                            "--out", "report", "--cpu-times"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const std::string text = content_of(folder.path("report/soak.txt"));
  EXPECT_EQ(done.out, text + "report in report/\n");
  const auto report = nlohmann::json::parse(content_of(folder.path("report/soak.json")));
  EXPECT_EQ(report["ticks"], 1500);
  EXPECT_EQ(report["rate_Hz"], 500.0);
  EXPECT_EQ(report["work_budget"]["units"], 20000);
  EXPECT_EQ(report["ticks_not_finite"], 0);
  std::uint64_t counted = 0;
  for (const auto& bucket : report["tick_times"]["cpu_ns"]["buckets"]) {
    counted += bucket[1].get<std::uint64_t>();
  }
  EXPECT_EQ(counted, 1500u);
  EXPECT_EQ(content_of(folder.path("report/cpu_ns.u32")).size(), 4u * 1500u);
  std::uint64_t late = 0;
  for (const auto& ticks : report["tick_times"]["late_ticks"]) late += ticks.get<std::uint64_t>();
  EXPECT_NE(text.find("late ticks: " + std::to_string(late) + " of 1500"), std::string::npos);
  EXPECT_GE(report["reached_timing"]["period_ns"], 1'990'000);
  EXPECT_GT(report["reached_timing"]["stable_N_per_m"], 0.0);
}

TEST(SoakCommand, CountsAndTimesTheEffects) {
  const TemporaryFolder folder;
  const Outcome done =
      run_program(folder, {"soak", PALPATE_MODELS_DIR "/effect_gravity.glb", "--minutes", "0.04",
                           "--rate", "500", "--effect-times", "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const auto report = nlohmann::json::parse(done.out);
  const auto gravity = report["effects"]["gravity"];
  EXPECT_GT(gravity["ticks"], 0);
  EXPECT_GT(gravity["time_share"], 0.0);
  EXPECT_LT(gravity["time_share"], 1.0);
  EXPECT_NE(content_of(folder.path("out/soak.txt")).find("gravity active in"), std::string::npos);
}

// The rows of a table without its columns.
std::ptrdiff_t row_count(const std::string& csv) {
  return std::count(csv.begin(), csv.end(), '\n') - 1;
}

TEST(SoakCommand, RunsTheChartOfDevicesTheSameWayAgain) {
  const TemporaryFolder folder;
  std::string first;
  for (const char* out : {"one", "two"}) {
    const Outcome done = run_program(
        folder, {"soak", "--device", "--cases", "30", "--seed", "7", "--json", "--out", out});
    const auto report = nlohmann::json::parse(done.out);
    EXPECT_EQ(done.exit_code, report["broken_cases"].empty() ? 0 : 1) << done.err;
    EXPECT_EQ(report["cases"], 30);
    std::uint64_t cases = 0;
    std::uint64_t broken = 0;
    for (const auto& zone : report["zones"]) {
      cases += zone["cases"].get<std::uint64_t>();
      broken += zone["outcomes"]["swings"].get<std::uint64_t>() +
                zone["outcomes"]["returns energy"].get<std::uint64_t>();
    }
    EXPECT_EQ(cases, 30u);
    EXPECT_EQ(broken, report["broken_cases"].size());
    const std::string csv = content_of(folder.path(std::string(out) + "/calm_chart.csv"));
    EXPECT_EQ(row_count(csv), 30);
    EXPECT_EQ(row_count(content_of(folder.path(std::string(out) + "/stiffness_zones.csv"))), 4 * 51);
    if (first.empty()) first = csv;
    EXPECT_EQ(csv, first);
  }
  const Outcome other =
      run_program(folder, {"soak", "--device", "--cases", "30", "--seed", "8", "--rate", "1000"});
  const std::string csv = content_of(folder.path("out/calm_chart.csv"));
  EXPECT_EQ(row_count(csv), 30);
  EXPECT_NE(csv, first);
  EXPECT_NE(other.out.find("zone of the stiffness"), std::string::npos);
}

TEST(SoakCommand, RefusesBadArgumentsAndLeavesNothing) {
  const TemporaryFolder folder;
  for (const auto& arguments : {std::vector<std::string>{"soak"},
                                {"soak", kStar, "--minutes", "0"},
                                {"soak", kStar, "--minutes", "0.03"},
                                {"soak", kStar, "--minutes", "nan"},
                                {"soak", kStar, "--minutes", "2000"},
                                {"soak", kStar, "--rate", "0"},
                                {"soak", kStar, "--cpu", "-1"},
                                {"soak", kStar, "--virtual"},
                                {"soak", "missing.glb"},
                                {"soak", kStar, "--cases", "3"},
                                {"soak", kStar, "--device"},
                                {"soak", "--device", "--minutes", "1"},
                                {"soak", "--device", "--stiffness", "300"},
                                {"soak", "--device", "--cases", "0"},
                                {"soak", "--device", "--rate", "249"},
                                {"soak", "--device", "--rate", "10001"}}) {
    const Outcome refused = run_program(folder, arguments);
    EXPECT_EQ(refused.exit_code, 2) << refused.err;
    EXPECT_EQ(refused.out, "");
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("out")));
}

}  // namespace
}  // namespace palpate
