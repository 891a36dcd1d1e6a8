// Trajectories with times and units, as a user replays them: the forces are those of closed forms,
// which know only the definitions of the damper, the viscosity and the vibration.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/command_line_fixture.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using nlohmann::json;
using test::content_of;
using test::GltfBuilder;
using test::Outcome;
using test::Random;
using test::TemporaryFolder;
using test::without_times;

constexpr float kHalf_m = 0.0625f;  // exact in binary: the top of the cube is where the file says

// A cube whose material has these properties. "thin" has no stiffness of its own.
GltfBuilder cube_of(const json& material) {
  GltfBuilder builder;
  std::vector<Eigen::Vector3f> corners;
  for (const float x : {-kHalf_m, kHalf_m}) {
    for (const float y : {-kHalf_m, kHalf_m}) {
      for (const float z : {-kHalf_m, kHalf_m}) corners.emplace_back(x, y, z);
    }
  }
  const std::array<std::array<std::uint32_t, 4>, 6> sides{
      {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
  std::vector<std::uint32_t> indices;
  for (const auto& [a, b, c, d] : sides) indices.insert(indices.end(), {a, b, c, a, c, d});
  builder.json["materials"] = {{{"name", "wall"}, {"extras", {{"palpate", material}}}}};
  const std::size_t mesh =
      builder.add_mesh({{{"attributes", {{"POSITION", builder.add_positions(corners)}}},
                         {"indices", builder.add_indices(indices)},
                         {"material", 0}}});
  builder.add_node({{"mesh", mesh}, {"name", "cube"}});
  return builder;
}

struct Row {
  double t_s = 0.0;
  Eigen::Vector3d device_m;
  Eigen::Vector3d force_N;
};

std::vector<Row> rows_of_trace(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  std::vector<std::string> names;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) names.push_back(name);
  std::vector<Row> rows;
  while (std::getline(lines, line)) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    const auto number = [&](const std::string& name) {
      const auto found = std::find(names.begin(), names.end(), name);
      return std::stod(fields.at(static_cast<std::size_t>(found - names.begin())));
    };
    const auto vector = [&](const std::string& name) {
      return Eigen::Vector3d(number(name + "_x"), number(name + "_y"), number(name + "_z"));
    };
    rows.push_back({number("t"), vector("device"), vector("force")});
  }
  return rows;
}

std::string shown(const char* format, double value) {
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

class TimedTrajectory : public testing::Test {
 protected:
  Outcome replay(const std::string& scene, const std::string& path,
                 const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"replay", scene,   "--trajectory",
                                       path,     "--out", folder.path("trace.csv")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::run_program(folder, arguments);
  }
  std::string trace() const { return content_of(folder.path("trace.csv")); }
  // The trace of a path, of which the text is given.
  std::string trace_of(const std::string& scene, const std::string& text,
                       const std::vector<std::string>& more = {}) const {
    const Outcome o = replay(scene, folder.write("path.txt", text), more);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return without_times(trace());
  }

  std::string cube(const json& material = json::object()) const {
    return cube_of(material).write_glb(folder);
  }

  TemporaryFolder folder;
};

// A path with times in whole nanoseconds: at a random rate, with jitter and gaps.
struct TimedPath {
  std::vector<std::int64_t> times_ns;
  std::vector<Eigen::Vector3d> positions_m;

  double since_last_s(std::size_t n) const {
    return 1e-9 * static_cast<double>(times_ns[n] - times_ns[n - 1]);
  }
  std::string text() const {
    std::string text;
    for (std::size_t n = 0; n < times_ns.size(); ++n) {
      const long long t = times_ns[n];
      std::array<char, 40> time;
      std::snprintf(time.data(), time.size(), "%lld.%09lld", t / 1'000'000'000, t % 1'000'000'000);
      text += time.data();
      for (const double c : positions_m[n]) text += shown(" %.17g", c);
      text += "\n";
    }
    return text;
  }
};

TimedPath random_times(Random& random, std::size_t rows, double largest_gap_s) {
  TimedPath path;
  // 100 Hz to 10 kHz, from any second on.
  const double period_ns = 1e9 / std::pow(10.0, random.uniform(2.0, 4.0));
  auto time_ns = static_cast<std::int64_t>(random.uniform(0.0, 2e18));
  for (std::size_t n = 0; n < rows; ++n) {
    path.times_ns.push_back(time_ns);
    const bool is_gap = random.index(10) == 0;
    const double longest_ns = std::max(2 * period_ns, 1e9 * largest_gap_s);
    time_ns +=
        std::max<std::int64_t>(1, std::llround(is_gap ? random.uniform(period_ns, longest_ns)
                                                      : period_ns * random.uniform(0.7, 1.3)));
  }
  return path;
}

double largest_N(const std::vector<Eigen::Vector3d>& forces_N) {
  double largest = 0.0;
  for (const auto& force_N : forces_N) largest = std::max(largest, force_N.norm());
  return largest;
}

constexpr double kSameForce = 1e-9;  // of the largest force

void expect_forces(const std::vector<Row>& rows, const TimedPath& path,
                   const std::vector<Eigen::Vector3d>& forces_N) {
  ASSERT_EQ(rows.size(), path.times_ns.size());
  const double largest = largest_N(forces_N);
  ASSERT_GT(largest, 0.0);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const double t_s = 1e-9 * static_cast<double>(path.times_ns[n] - path.times_ns[0]);
    ASSERT_NEAR(rows[n].t_s, t_s, 1e-12 * t_s) << n;
    ASSERT_LE((rows[n].force_N - forces_N[n]).norm(), kSameForce * largest)
        << "position " << n << ", " << rows[n].force_N.transpose() << ", expected "
        << forces_N[n].transpose();
  }
}

constexpr int kPaths = 6;
constexpr std::size_t kRows = 400;

TEST_F(TimedTrajectory, DampsWithTheTimeOfEachPosition) {
  Random random(46001);
  const std::string scene = cube();
  for (int pass = 0; pass < kPaths; ++pass) {
    TimedPath path = random_times(random, kRows, pass % 2 == 0 ? 0.05 : 5.0);
    std::vector<Eigen::Vector3d> forces_N;
    constexpr double kDamping_Ns_per_m = 5.0;
    for (std::size_t n = 0; n < kRows; ++n) {
      // Above the wall, then in it.
      const double depth_m = n < 3 ? -0.001 : random.uniform(0.001, 0.004);
      path.positions_m.emplace_back(0.01, -0.007, kHalf_m - depth_m);
      Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
      if (n > 3) {
        const double rate = path.positions_m[n - 1].z() - path.positions_m[n].z();
        force_N.z() = std::max(0.0, kDamping_Ns_per_m * rate / path.since_last_s(n));
      }
      forces_N.push_back(force_N);
    }
    const Outcome o = replay(scene, folder.write("path.txt", path.text()),
                             {"--stiffness", "0", "--damping", "5"});
    ASSERT_EQ(o.exit_code, 0) << o.err;
    expect_forces(rows_of_trace(trace()), path, forces_N);
  }
}

TEST_F(TimedTrajectory, DragsInAMediumWithTheTimeOfEachPosition) {
  Random random(46002);
  const std::string scene = cube({{"viscosity", 3.0}});
  for (int pass = 0; pass < kPaths; ++pass) {
    TimedPath path = random_times(random, kRows, pass % 2 == 0 ? 0.05 : 5.0);
    std::vector<Eigen::Vector3d> forces_N;
    for (std::size_t n = 0; n < kRows; ++n) {
      path.positions_m.emplace_back(random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03),
                                    random.uniform(-0.03, 0.03));
      forces_N.emplace_back(Eigen::Vector3d::Zero());
      if (n == 0) continue;
      forces_N[n] = -3.0 * (path.positions_m[n] - path.positions_m[n - 1]) / path.since_last_s(n);
    }
    const Outcome o = replay(scene, folder.write("path.txt", path.text()));
    ASSERT_EQ(o.exit_code, 0) << o.err;
    expect_forces(rows_of_trace(trace()), path, forces_N);
  }
}

TEST_F(TimedTrajectory, VibratesInTheTimeOfThePath) {
  Random random(46003);
  for (int pass = 0; pass < kPaths; ++pass) {
    TimedPath path = random_times(random, kRows, pass % 2 == 0 ? 0.05 : 5.0);
    std::vector<std::int64_t> lengths_ns;
    for (std::size_t n = 1; n < kRows; ++n) {
      lengths_ns.push_back(path.times_ns[n] - path.times_ns[n - 1]);
    }
    std::nth_element(lengths_ns.begin(), lengths_ns.begin() + kRows / 2, lengths_ns.end());
    // A fifth of the sample rate; gaps are longer than half a period.
    const double frequency_Hz =
        std::round(std::min(5000.0, 0.2e9 / static_cast<double>(lengths_ns[kRows / 2])));
    const std::string scene =
        cube({{"vibrationFrequency", frequency_Hz}, {"vibrationAmplitude", 0.7}, {"stiffness", 0}});
    constexpr std::size_t kTouch = 5;  // the first position in contact
    std::vector<Eigen::Vector3d> forces_N;
    for (std::size_t n = 0; n < kRows; ++n) {
      path.positions_m.emplace_back(0.0, 0.002, kHalf_m + (n < kTouch ? 0.001 : -0.002));
      forces_N.emplace_back(Eigen::Vector3d::Zero());
      if (n < kTouch || frequency_Hz * path.since_last_s(n) >= 0.5) continue;
      // The contact began after the position before the touch.
      const double periods =
          frequency_Hz * 1e-9 * static_cast<double>(path.times_ns[n] - path.times_ns[kTouch - 1]);
      forces_N[n].z() = 0.7 * std::min(1.0, periods) * std::sin(2 * std::numbers::pi * periods);
    }
    const Outcome o = replay(scene, folder.write("path.txt", path.text()));
    ASSERT_EQ(o.exit_code, 0) << o.err;
    expect_forces(rows_of_trace(trace()), path, forces_N);
  }
}

// A tap after a flight that is longer than a pulse, in ticks of other lengths than the tap's.
TEST_F(TimedTrajectory, KnowsAnImpactByTheTimeOfTheFlight) {
  Random random(46007);
  constexpr double kPulse_s = 0.005;
  const std::string scene = cube(
      {{"restitution", 0.8}, {"impactMass", 0.05}, {"impactDuration", kPulse_s}, {"stiffness", 0}});
  for (int pass = 0; pass < kPaths; ++pass) {
    TimedPath path;
    std::int64_t time_ns = 0;
    const auto add = [&](std::int64_t length_ns, double height_m) {
      time_ns += length_ns;
      path.times_ns.push_back(time_ns);
      path.positions_m.emplace_back(0.0, 0.0, kHalf_m + height_m);
    };
    add(0, 0.001);
    add(1'000'000, -0.001);  // the first contact
    for (int n = 0; n < 3; ++n) add(2'000'000 + static_cast<int>(random.index(1000)), 0.001);
    const std::int64_t tap_ns = 100'000 + static_cast<int>(random.index(100'000));
    const double depth_m = random.uniform(1e-5, 1e-4);
    add(tap_ns, -depth_m);
    const Outcome o = replay(scene, folder.write("path.txt", path.text()));
    ASSERT_EQ(o.exit_code, 0) << o.err;
    const double length_s = 1e-9 * static_cast<double>(tap_ns);
    const double impulse_Ns = 0.8 * 0.05 * (0.001 + depth_m) / length_s;
    const double part = 0.5 * (1.0 - std::cos(std::numbers::pi * length_s / kPulse_s));
    const double expected_N = impulse_Ns * part / length_s;
    EXPECT_NEAR(rows_of_trace(trace()).back().force_N.z(), expected_N, kSameForce * expected_N);
  }
}

TEST_F(TimedTrajectory, MovesNodesInTheTimeOfThePath) {
  Random random(46008);
  const std::string scene = cube();
  for (int pass = 0; pass < kPaths; ++pass) {
    TimedPath path = random_times(random, 200, 0.5);
    const double duration_s =
        1e-9 * static_cast<double>(path.times_ns.back() - path.times_ns.front());
    // At the end, the cube has risen 6 mm into a hand that rests 2 mm above it.
    const double speed_m_per_s = 0.008 / duration_s;
    std::vector<Eigen::Vector3d> forces_N;
    for (std::size_t n = 0; n < 200; ++n) {
      path.positions_m.emplace_back(0.003, 0.001, kHalf_m + 0.002);
      const double t_s = 1e-9 * static_cast<double>(path.times_ns[n] - path.times_ns[0]);
      forces_N.emplace_back(0.0, 0.0, 1000.0 * std::max(0.0, speed_m_per_s * t_s - 0.002));
    }
    const Outcome o = replay(scene, folder.write("path.txt", path.text()),
                             {"--move", "cube=0 0 " + shown("%.17g", speed_m_per_s) + " 0 0 0"});
    ASSERT_EQ(o.exit_code, 0) << o.err;
    expect_forces(rows_of_trace(trace()), path, forces_N);
  }
}

// A press and a slide at 1 kHz.
std::vector<std::string> thousand_hertz_positions(Random& random) {
  std::vector<std::string> positions;
  for (int n = 0; n < 300; ++n) {
    positions.push_back(shown("%.6f", 0.0001 * n) + " " + shown("%.6f", random.uniform(0, 1e-4)) +
                        " " + shown("%.6f", 0.065 - 0.00003 * n + random.uniform(0, 1e-5)));
  }
  return positions;
}

TEST_F(TimedTrajectory, KeepsEveryBitAtOneKilohertz) {
  Random random(46004);
  const std::vector<std::string> positions = thousand_hertz_positions(random);
  const std::string scene = cube({{"vibrationFrequency", 80},
                                  {"vibrationAmplitude", 0.3},
                                  {"viscosity", 0.5},
                                  {"restitution", 0.5}});
  const std::vector<std::string> more{"--damping", "2", "--a4", "on", "--actuators", "1"};
  std::string plain;
  for (const std::string& p : positions) plain += p + "\n";
  const std::string expected = trace_of(scene, plain, more);
  double summed_s = 0.0;
  std::vector<double> sums_s;
  for (std::size_t n = 0; n < positions.size(); ++n, summed_s += 0.001) sums_s.push_back(summed_s);
  const std::vector<std::pair<std::string, std::function<std::string(std::size_t)>>> columns{
      {"", [](std::size_t n) { return shown("%.3f", 0.001 * static_cast<double>(n)); }},
      {"", [](std::size_t n) { return shown("%.6f", 5.0 + 0.001 * static_cast<double>(n)); }},
      {"", [](std::size_t n) { return shown("%.17g", 0.001 * static_cast<double>(n)); }},
      {"", [&](std::size_t n) { return shown("%.17g", sums_s[n]); }},
      {"", [](std::size_t n) { return shown("%.9e", -3.0 + 0.001 * static_cast<double>(n)); }},
      {"", [](std::size_t n) { return std::to_string(1'700'000'000'000 + n).insert(10, "."); }},
      {"t_ms x y z\n", [](std::size_t n) { return std::to_string(n); }},
      {"t_us x y z\n", [](std::size_t n) { return std::to_string(17 + 1000 * n); }}};
  for (const auto& [header, time] : columns) {
    std::string text = header;
    for (std::size_t n = 0; n < positions.size(); ++n) text += time(n) + " " + positions[n] + "\n";
    SCOPED_TRACE(text.substr(0, 60));
    EXPECT_TRUE(trace_of(scene, text, more) == expected);
    std::vector<std::string> at_rate = more;
    at_rate.insert(at_rate.end(), {"--rate", "1000"});
    EXPECT_TRUE(trace_of(scene, text, at_rate) == expected);
  }
}

TEST_F(TimedTrajectory, ReplaysATraceWithItsTimes) {
  Random random(46005);
  const std::string scene = cube();
  TimedPath path = random_times(random, 200, 2.0);
  for (std::size_t n = 0; n < 200; ++n) {
    path.positions_m.emplace_back(0.0, 0.0, kHalf_m - 0.00002 * static_cast<double>(n));
  }
  const std::string first = trace_of(scene, path.text(), {"--damping", "3"});
  const double duration_s = 1e-9 * static_cast<double>(path.times_ns.back() - path.times_ns[0]);
  EXPECT_NEAR(rows_of_trace(trace()).back().t_s, duration_s, 1e-12 * duration_s);
  const std::string file = folder.write("first.csv", trace());
  ASSERT_EQ(replay(scene, file, {"--damping", "3"}).exit_code, 0);
  EXPECT_TRUE(without_times(trace()) == first);
}

TEST_F(TimedTrajectory, InterpolatesInTimeAtAGivenRate) {
  const std::string scene = cube();
  const std::string file =
      folder.write("path.txt", "10 0 0 0.07\n10.002 0.004 0 0.07\n10.005 0.004 0.003 0.073\n");
  const Outcome o = replay(scene, file, {"--rate", "1000"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const std::string first_line = o.out.substr(0, o.out.find('\n'));
  EXPECT_NE(first_line.find("3 of 6 positions are interpolated in time"), std::string::npos)
      << first_line;
  EXPECT_NE(first_line.find("1000 Hz (--rate)"), std::string::npos) << first_line;
  const auto rows = rows_of_trace(trace());
  const std::vector<Eigen::Vector3d> expected{{0, 0, 0.07},          {0.002, 0, 0.07},
                                              {0.004, 0, 0.07},      {0.004, 0.001, 0.071},
                                              {0.004, 0.002, 0.072}, {0.004, 0.003, 0.073}};
  ASSERT_EQ(rows.size(), expected.size());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    EXPECT_NEAR(rows[n].t_s, 0.001 * static_cast<double>(n), 1e-15);
    EXPECT_LE((rows[n].device_m - expected[n]).norm(), 1e-16) << n;
  }
  const Outcome own = replay(scene, file);
  EXPECT_NE(own.out.find("path.txt: 3 positions in 0.005 s"), std::string::npos) << own.out;
  // The last position is reached only at a time of the rate.
  ASSERT_EQ(replay(scene, file, {"--rate", "300"}).exit_code, 0);
  EXPECT_EQ(rows_of_trace(trace()).size(), 2u);
  const json said = json::parse(replay(scene, file, {"--rate", "1000", "--json"}).out);
  EXPECT_EQ(said["trajectory"]["interpolated"], 3);
  EXPECT_EQ(said["trajectory"]["at_rate_Hz"], 1000.0);
}

TEST_F(TimedTrajectory, TellsGapsAndRatesThatDevicesDoNotHave) {
  const std::string scene = cube();
  const auto said = [&](const std::string& text) {
    const Outcome o = replay(scene, folder.write("path.txt", text));
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return o.err;
  };
  EXPECT_EQ(said("0 0 0 1\n0.001 0 0 1\n0.002 0 0 1\n0.0034 0 0 1\n"), "");
  const std::string gaps = said(
      "# a path\n0 0 0 1\n0.002 0 0 1\n0.006 0 0 1\n0.008 0 0 1\n\n0.51 0 0 1\n0.512 0 0 1\n"
      "0.514 0 0 1\n");
  EXPECT_NE(gaps.find("line 7: t is 0.502 s after the position before it, 251 times the median"),
            std::string::npos)
      << gaps;
  EXPECT_NE(gaps.find("2 intervals"), std::string::npos) << gaps;
  EXPECT_NE(gaps.find("the first before line 4"), std::string::npos) << gaps;
  EXPECT_NE(said("0 0 0 1\n1 0 0 1\n2 0 0 1\n").find("if t is in ms, name its column t_ms"),
            std::string::npos);
  EXPECT_NE(said("0 0 0 1\n0.033 0 0 1\n0.067 0 0 1\n").find("the median rate is 30.303 Hz"),
            std::string::npos);
  const std::string stated = said("# sampled at 500 Hz\n0 0 1\n0 0 1\n");
  EXPECT_NE(stated.find("line 1, a comment, states 500 Hz"), std::string::npos) << stated;
  EXPECT_EQ(said("# sampled at 1 kHz\n0 0 1\n0 0 1\n"), "");
  EXPECT_NE(said("0 0 0 1\n2e-5 0 0 1\n4e-5 0 0 1\n").find("50000 Hz"), std::string::npos);
}

TEST_F(TimedTrajectory, ConvertsUnitsToTheBitsOfMetres) {
  Random random(46006);
  const std::string scene = cube();
  std::string metres;
  std::string millimetres = "time [ms];z [mm];x [mm];note;y [mm]\n";
  for (int n = 0; n < 100; ++n) {
    std::array<std::string, 3> m;
    std::array<std::string, 3> mm;
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = k == 2 ? random.uniform(58.0, 66.0) : random.uniform(-9.0, 9.0);
      mm[k] = shown("%.4f", value);
      m[k] = mm[k] + "e-3";
    }
    metres += shown("%.4f", 0.0005 * n) + " " + m[0] + " " + m[1] + " " + m[2] + "\n";
    for (std::string& text : mm) std::replace(text.begin(), text.end(), '.', ',');
    millimetres += std::to_string(n / 2) + (n % 2 == 0 ? "" : ",5") + ";" + mm[2] + ";" + mm[0] +
                   ";a, b;" + mm[1] + "\n";
  }
  const std::string expected = trace_of(scene, metres, {"--damping", "1"});
  EXPECT_TRUE(trace_of(scene, millimetres, {"--damping", "1"}) == expected);
  const Outcome o = replay(scene, folder.path("path.txt"));
  EXPECT_NE(o.out.find("x, y and z are in mm (1 mm = 0.001 m); t is in ms (1 ms = 0.001 s)"),
            std::string::npos)
      << o.out;
  EXPECT_NE(o.out.find("not used: \"note\""), std::string::npos) << o.out;
}

TEST_F(TimedTrajectory, CountsSamplesAtAGivenRateOnly) {
  const std::string scene = cube();
  const std::string text = "n [samples],x,y,z\n100,0,0,0.07\n101,0,0,0.071\n104,0,0,0.074\n";
  const Outcome refused = replay(scene, folder.write("path.txt", text));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("counts samples, which is no time"), std::string::npos) << refused.err;
  const Outcome o = replay(scene, folder.path("path.txt"), {"--rate", "3000"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  const auto rows = rows_of_trace(trace());
  ASSERT_EQ(rows.size(), 5u);
  // The times of two positions are rounded by half a nanosecond, at 3 m/s.
  EXPECT_NEAR(rows[3].device_m.z(), 0.073, 3e-9);
  EXPECT_EQ(rows[4].device_m.z(), 0.074);
}

TEST_F(TimedTrajectory, RefusesMoreTicksThanMemoryHolds) {
  const std::string scene = cube();
  const Outcome o =
      replay(scene, folder.write("path.txt", "0 0 0 1\n9e9 0 0 1\n"), {"--rate", "10000"});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_NE(o.err.find("lower --rate"), std::string::npos) << o.err;
}

}  // namespace
}  // namespace palpate
