// `palpate replay`: its trace and its summary.

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "geometry/base/types.h"
#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::CommandLine;
using test::content_of;
using test::keys_of;
using test::kStar;
using test::kSummaryKeys;
using test::lines_of;
using test::Outcome;
using test::rows_of;
using test::sorted;
using test::without_times;

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
    ASSERT_EQ(rows[n].size(), rows[n].back() == "began" || rows[n].back() == "ended" ? 48u : 47u)
        << "no field for an empty last one";
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

// The path begins in the middle of the star, and the force is that of before.
TEST_F(CommandLine, NamesTheNodeInsideWhichAPathBegins) {
  folder.write("inside.txt", "0 0 0\n0 0 0.001\n");
  const Outcome o =
      expect_done({"replay", kStar, "--trajectory", folder.path("inside.txt"), "--json"});
  EXPECT_NE(o.err.find("begins inside the closed surface of node \"star\""), std::string::npos)
      << o.err;
  EXPECT_EQ(json::parse(o.out)["starts_inside"], "star");
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
  for (const char* name : {"a4-anticipate", "a4-passive:10", "anisotropic:4", "cd"}) {
    traces.insert(without_times(trace({"--strategy", name})));
  }
  EXPECT_EQ(traces.size(), 8u);
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

}  // namespace
}  // namespace palpate
