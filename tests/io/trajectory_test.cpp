#include "io/trajectory.h"

#include <array>
#include <bit>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class TrajectoryFile : public testing::Test {
 protected:
  TrajectoryFile()
      : path_(testing::TempDir() + "palpate_trajectory_" + std::to_string(::getpid()) + ".txt") {}
  ~TrajectoryFile() override { std::filesystem::remove(path_); }

  Result<Trajectory> read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_trajectory(path_);
  }

  // The trajectory; without positions, with a test failure, on an error.
  Trajectory trajectory(const std::string& text) {
    auto result = read(text);
    if (result) return *result;
    ADD_FAILURE() << text.substr(0, 80) << ": " << result.error().to_string();
    return {};
  }

  // The positions; empty, with a test failure, on an error.
  std::vector<Vec3> positions(const std::string& text) { return trajectory(text).positions_m; }
  std::vector<std::int64_t> times_ns(const std::string& text) { return trajectory(text).times_ns; }

  // The one-line message of the expected error.
  std::string message(const std::string& text) {
    const auto result = read(text);
    if (!result) return result.error().to_string();
    ADD_FAILURE() << "accepted: " << text;
    return "";
  }

  void expect_message(const std::string& text, const std::string& line,
                      const std::string& problem) {
    const std::string said = message(text);
    EXPECT_TRUE(said.starts_with(path_ + ": " + line)) << said;
    EXPECT_NE(said.find(problem), std::string::npos) << said;
    EXPECT_EQ(said.back(), ')') << "no hint: " << said;
  }

  std::string path_;
};

const std::vector<Vec3> kTwoPoints = {{1.0, -2.5, 3e-3}, {4.0, 0.0, -0.0625}};

TEST_F(TrajectoryFile, SeparatesColumnsByBlanksOrCommas) {
  for (const char* text : {
           "1 -2.5 3e-3\n4 0 -0.0625\n",
           "1,-2.5,3e-3\n4,0,-0.0625\n",
           "1, -2.5, 3e-3\n4 ,0 , -0.0625\n",
           "  1\t-2.5 \t 3e-3  \n\t4 0 -0.0625",
           "1 -2.5 3e-3\r\n4 0 -0.0625\r\n",
           "1, -2.5 3E-3\n+4 .0 -.0625\n",
           "1 -2.5 3e-3\r4 0 -0.0625\r",
           "1;-2.5;3e-3\n4; 0 ;-0.0625\n",
           "1,0;-2,5;3e-3\n4;0,0;-0,0625\n",
           "1,0\t-2,5\t3e-3\n4,0\t0,0\t-0,0625\n",
           "\"1,0\",\"-2,5\",\"3e-3\"\n\"4\",\"0\",\"-0,0625\"\n",
       }) {
    SCOPED_TRACE(text);
    EXPECT_EQ(positions(text), kTwoPoints);
  }
}

TEST_F(TrajectoryFile, SkipsCommentsAndEmptyLines) {
  EXPECT_EQ(positions("\xef\xbb\xbf# a pen\r\n\r\n1 -2.5 3e-3# 9 9 9\n   \n#5 5 5\n  # x\n"
                      "4 0 -0.0625 #\n\n"),
            kTwoPoints);
}

TEST_F(TrajectoryFile, SkipsAHeaderThatAgreesWithTheColumns) {
  for (const char* header : {
           "x y z",
           "X,Y,Z",
           "x_m y_m z_m",
           "x [m] y [m] z [m]",
           "PosX;PosY;PosZ",
           "\"x\",\"y\",\"z\"",
           "x (m), y (m), z (m)",
           "# comment\n\nx\ty\tz",
           "px, py, pz",
           "% x y z",
           "# the x y z of the tip",
       }) {
    SCOPED_TRACE(header);
    EXPECT_EQ(positions(std::string(header) + "\n1 -2.5 3e-3\n4 0 -0.0625\n"), kTwoPoints);
  }
}

TEST_F(TrajectoryFile, ReadsTimesToTheNanosecond) {
  const std::string rows = "-5 1 -2.5 3e-3\n-4.999 4 0 -0.0625\n";
  struct Header {
    const char* text;
    std::int64_t length_ns;
  };
  for (const Header& header :
       {Header{"", 1'000'000}, Header{"t x y z\n", 1'000'000}, Header{"Time, X, Y, Z\n", 1'000'000},
        Header{"time (s),x [m],y [m],z [m]\n", 1'000'000}, Header{"t_ms px py pz\n", 1000},
        Header{"Zeit [ms];x;y;z\n", 1000}, Header{"t (\u00b5s),x,y,z\n", 1},
        Header{"t [\u03bcs],x,y,z\n", 1}, Header{"t\uff3bms\uff3d,x,y,z\n", 1000},
        Header{"time_min,x,y,z\n", 60'000'000}, Header{"timestamp,x,y,z\nms,m,m,m\n", 1000},
        Header{"# t [ms] x [m] y [m] z [m]\n", 1000}, Header{"# units: ms\n", 1000},
        Header{"# units: m, ms\n", 1000}}) {
    SCOPED_TRACE(header.text);
    const Trajectory read = trajectory(header.text + rows);
    EXPECT_EQ(read.positions_m, kTwoPoints);
    EXPECT_EQ(read.times_ns, (std::vector<std::int64_t>{0, header.length_ns}));
  }
  EXPECT_EQ(positions("frame x y z\n" + rows), kTwoPoints);
  EXPECT_TRUE(times_ns("frame x y z\n" + rows).empty());
  // Ties go up.
  EXPECT_EQ(
      times_ns("0 0 0 0\n2.5e-9 0 0 0\n3.5e-9 0 0 0\n5.50000000000000000000000000000000001e-9 "
               "0 0 0\n"),
      (std::vector<std::int64_t>{0, 3, 4, 6}));
  EXPECT_EQ(times_ns("-1.5000000000000000001e-9 0 0 0\n0 0 0 0\n"),
            (std::vector<std::int64_t>{0, 2}));
  EXPECT_EQ(times_ns("1e-30 0 0 0\n1700000000.123456 0 0 0\n"),
            (std::vector<std::int64_t>{0, 1'700'000'000'123'456'000}));
}

// A sum of doubles drifts, and each of its steps is a millisecond nevertheless.
TEST_F(TrajectoryFile, ReadsSumsOfTimeSteps) {
  for (const double step_s : {0.001, 1.0 / 3000.0}) {
    std::string text;
    double time_s = 170.00000000048;  // the drift of the sum passes half a nanosecond
    constexpr int kRows = 20000;
    for (int n = 0; n < kRows; ++n, time_s += step_s) {
      std::array<char, 32> digits;
      text.append(digits.data(),
                  std::to_chars(digits.data(), digits.data() + digits.size(), time_s).ptr);
      text += " 0 0 0\n";
    }
    const std::vector<std::int64_t> read_ns = times_ns(text);
    ASSERT_EQ(read_ns.size(), kRows);
    // No drift: the last time is the number of steps times the step.
    EXPECT_NEAR(1e-9 * static_cast<double>(read_ns.back()), (kRows - 1) * step_s, 2e-9);
    for (std::size_t n = 1; n < kRows && step_s == 0.001; ++n) {
      ASSERT_EQ(read_ns[n] - read_ns[n - 1], 1'000'000) << n;
    }
  }
}

// The nanoseconds of a random decimal number are known before it is written.
TEST_F(TrajectoryFile, RestoresEveryNanosecond) {
  Random random(46101);
  std::string text;
  std::vector<std::int64_t> expected_ns;
  std::int64_t time_ns = -static_cast<std::int64_t>(random.index(4'000'000'000'000'000'000));
  const std::int64_t first_ns = time_ns;
  for (int n = 0; n < 5000; ++n) {
    expected_ns.push_back(time_ns - first_ns);
    const std::uint64_t size = static_cast<std::uint64_t>(std::abs(time_ns));
    std::string digits = std::to_string(size);
    digits.insert(0, std::max<std::size_t>(10, digits.size()) - digits.size(), '0');
    const std::string sign = time_ns < 0 ? "-" : n % 2 == 0 ? "+" : "";
    if (n % 3 == 0) {
      text += sign + digits + "e-9";
    } else {
      text += sign + digits.substr(0, digits.size() - 9) + "." + digits.substr(digits.size() - 9);
      text += n % 3 == 1 ? "" : "49999999999999999999999999999999999";
    }
    text += " 0 0 0\n";
    time_ns += 1 + static_cast<std::int64_t>(random.index(1'000'000'000'000));
  }
  // A negative number with more digits is nearer to the lower nanosecond or equal to it.
  EXPECT_EQ(times_ns(text), expected_ns);
}

TEST_F(TrajectoryFile, ConvertsUnitsOfLength) {
  struct Unit {
    const char* name;
    double metres;
  };
  Random random(46102);
  for (const Unit& unit : {Unit{"mm", 1e-3}, Unit{"cm", 1e-2}, Unit{"m", 1.0}, Unit{"in", 0.0254},
                           Unit{"inch", 0.0254}, Unit{"ft", 0.3048}, Unit{"\u00b5m", 1e-6},
                           Unit{"\u03bcm", 1e-6}, Unit{"MM", 1e-3}, Unit{"millimetres", 1e-3},
                           Unit{"Micrometer", 1e-6}, Unit{"nm", 1e-9}, Unit{"km", 1e3}}) {
    const double value = random.uniform(-20.0, 20.0);
    std::array<char, 32> digits;
    const std::string number(
        digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
    for (const char* form : {"X [@]", "x_@", "x(@)", "x (@)", "x @", "X/@", "x / @", "pos_x [@]",
                             "x\uff08@\uff09", "\"x [@]\"", "x in @", "Position X (@)"}) {
      std::string header;
      for (const char axis : {'z', 'x', 'y'}) {
        std::string name = form;
        name.replace(name.find('@'), 1, unit.name);
        const std::size_t place = name.find_first_of("xX");
        name[place] = static_cast<char>(name[place] + (axis - 'x'));
        header += (header.empty() ? "" : ",") + name;
      }
      SCOPED_TRACE(header);
      const Trajectory read = trajectory(header + "\n1," + number + ",3\n");
      ASSERT_EQ(read.positions_m.size(), 1u);
      // The expected values are rounded twice.
      const double rounding = 2 * std::numeric_limits<double>::epsilon() * unit.metres;
      EXPECT_NEAR(read.positions_m[0].x(), value * unit.metres, rounding * std::abs(value));
      EXPECT_NEAR(read.positions_m[0].z(), unit.metres, rounding);
      EXPECT_EQ(read.notes.size(), unit.metres == 1.0 ? 0u : 1u);
    }
  }
  const auto mixed = positions("z [m],y [cm],fx [N],x [mm]\n-0.0625,0,9,4000\n");
  EXPECT_EQ(mixed, std::vector<Vec3>{kTwoPoints[1]});
}

TEST_F(TrajectoryFile, ReadsUnitsBelowNamesAndAfterThem) {
  for (const char* text :
       {"x,y,z\nmm,mm,mm\n1000,-2500,3\n4000,0,-62.5\n",
        "# units: mm\nx,y,z\n1000,-2500,3\n4000,0,-62.5\n",
        "x y z # a pen\n# units: mm\n1000 -2500 3\n4000 0 -62.5\n",
        "# units: mm\n# unit = mm\n# x [mm] y [mm] z [mm]\n1000 -2500 3\n4000 0 -62.5\n",
        "# z_mm,x_mm,y_mm\n3,1000,-2500\n-62.5,4000,0\n"}) {
    SCOPED_TRACE(text);
    const Trajectory read = trajectory(text);
    EXPECT_EQ(read.positions_m, kTwoPoints);
    EXPECT_FALSE(read.notes.empty());
    EXPECT_TRUE(read.warnings.empty());
  }
}

// A comment is applied, or refused, or text; a unit in a text is named in a warning.
struct CommentCase {
  const char* comment;
  double metres;     // of a 1 in the file; 0: refused
  const char* said;  // in the warning or in the error; empty: nothing
  const char* rows = "1 1 1\n2 2 2\n";
};
const char* const kFour = "0 1 1 1\n0.5 2 2 2\n";
const char* const kForces = "1 1 1 9\n2 2 2 9\n";
const char* const kFive = "0 1 1 1 9\n0.5 2 2 2 9\n";
const CommentCase kComments[] = {
    // Texts.
    {"# positions are in metres", 1, ""},
    {"# values are in the device frame", 1, ""},
    {"# The data is in SI units", 1, ""},
    {"# data are in chronological order", 1, ""},
    {"# columns are in the order x y z", 1, ""},
    {"# position is in m", 1, ""},
    {"# x, y, z are in meters", 1, ""},
    {"# positions are given as in ISO 9283", 1, ""},
    {"# positions (in)", 1, ""},
    {"# data (m. smith, 2020)", 1, ""},
    {"# positions in a 3 m room", 1, ""},
    {"# data (f, 23 y), (m, 25 y)", 1, ""},
    {"# axes: x right, y up, z in", 1, ""},
    {"# x = left, y = up, z = in", 1, ""},
    {"# unit test data", 1, ""},
    {"# units", 1, ""},
    {"# measurement unit: IMU 3", 1, ""},
    {"# unit 5 m, run 3", 1, ""},
    {"# data [run 3]", 1, ""},
    {"# positions of the tip [see README]", 1, ""},
    {"# x range [0, 1]", 1, ""},
    {"# x y z (see README)", 1, ""},
    {"# recorded at 5 mm/s", 1, ""},
    {"# vx [[1e-3]]", 1, ""},
    {"# t is zero at the start", 1, "", kFour},
    // Texts with a unit.
    {"# positions are in mm", 1, "line 1, a comment, names mm"},
    {"# tip position, mm", 1, "names mm"},
    {"# measured in mm", 1, "names mm"},
    {"# all in mm", 1, "names mm"},
    {"# mm", 1, "names mm"},
    {"# a sphere of 50mm", 1, "names mm"},
    {"# x_mm", 1, "names mm"},
    {"# units-mm", 1, "names mm"},
    {"# {\"units\": \"mm\"}", 1, "names mm"},
    {"# positions in \u00b5m", 1, "names um"},
    {"# positions in inches", 1, "names inches"},
    {"# all in Millimetres.", 1, "names Millimetres"},
    {"# positions in furlongs", 1, "names furlongs"},
    {"# screen pixels", 1, "names pixels"},
    {"# 1 unit = 0.1 mm", 1, "names mm"},
    {"# positions in 1e-3 m", 1, "names 1e-3 m"},
    {"# positions in 1/1000 m", 1, "names 1/1000 m"},
    {"# x [mm]\n# y [cm]\n# z [mm]", 1, "line 1, a comment, names mm"},
    {"# time in ms", 1, "names ms; t is read as seconds", kFour},
    {"# x y z of the pen", 1, ""},
    {"# t x y z of the pen", 1, "", kFour},
    {"# x y z of the pen", 1, "names x, y and z among 6 columns", kFour},
    // Units.
    {"# units: mm", 1e-3, ""},
    {"# Unit = CM", 1e-2, ""},
    {"# units: \"mm\"", 1e-3, ""},
    {"# units: [mm]", 1e-3, ""},
    {"# length_unit: mm", 1e-3, ""},
    {"# position units are mm", 1e-3, ""},
    {"# units are in mm", 1e-3, ""},
    {"# unit: in", 0.0254, ""},
    {"# units: mm, mm, mm", 1e-3, ""},
    {"# units: mm and s", 1e-3, "", kFour},
    {"# units: SI", 1, ""},
    {"// units: mm", 1e-3, ""},
    {"# units: px", 0, "\"px\" is no known unit"},
    {"# units: 10 um", 0, "\"10\" is no known unit"},
    {"# units: 1e-3 m", 0, "\"1e-3\" is no known unit"},
    {"# units: 1/1000 m", 0, "\"1/1000\" is no known unit"},
    {"# units = hundredths of mm", 0, "\"hundredths\" is no known unit"},
    {"# units: mm/s", 0, "\"mm/s\" is no known unit"},
    {"# length unit: s", 0, "\"s\" is no known unit"},
    {"# units: mm, cm", 0, "expected one unit of length"},
    {"# units: mm\n# units: m", 0, "line 2: states other units of length than line 1"},
    {"# units: ms\n# units: s", 0, "line 2: states other units of time than line 1", kFour},
    {"# units: mm\n# x [cm] y [cm] z [cm]", 0, "states other units of length"},
    {"# units: mm\nx [cm] y [cm] z [cm]", 0, "line 2: states other units of length than line 1"},
    {"x [cm] y [cm] z [cm]\n# units: mm", 0, "line 2: states other units of length than line 1"},
    {"# all in mm\nx [cm] y [cm] z [cm]", 1e-2, ""},
    // Columns.
    {"# x [mm] y [mm] z [mm]", 1e-3, ""},
    {"# x [mm] | y [mm] | z [mm]", 1e-3, ""},
    {"# x, y, z, # units: mm", 1e-3, ""},
    {"# Columns: t [s], x [mm], y [mm], z [mm]", 1e-3, "", kFour},
    {"# data format = t x y z", 1, "", kFour},
    {"# (t, x, y, z)", 1, "", kFour},
    {"# t x y z force [N]", 1, "", kFive},
    {"# x,y,z,alpha [deg]", 1, "", kForces},
    {"# columns: x y z pressure", 1, "", kForces},
    {"# x y z force", 1, "", kForces},
    {"# columns: x y z pressure", 0, "names x, y and z among 4 columns"},
    {"# x y z", 0, "names x, y and z among 3 columns", kFour},
    {"# x, y, z, f", 0, "names x, y and z among 4 columns"},
    {"# t x y z\n# z y x t", 0, "line 2: states other columns than line 1", kFour},
    {"# x [px] y [px] z [px]", 0, "\"px\""},
    {"# x [mm], y [mm], z", 0, "units for 2 of the columns"},
    // Traces and names like those of a trace.
    {"# units: m\nt,device_x,device_y,device_z", 1, "", "0,1,1,1\n0.5,2,2,2\n"},
    {"# in mm\nt,device_x,device_y,device_z", 1, "", "0,1,1,1\n0.5,2,2,2\n"},
    {"# units: mm\nt,device_x,device_y,device_z", 0, "line 2: is the header of a trace",
     "0,1,1,1\n0.5,2,2,2\n"},
    {"# units: mm\ntime,device_x,device_y,device_z", 1e-3, "", "0,1,1,1\n0.5,2,2,2\n"},
};

TEST_F(TrajectoryFile, AppliesCommentsOfTwoForms) {
  for (const CommentCase& c : kComments) {
    SCOPED_TRACE(c.comment);
    const std::string text = std::string(c.comment) + "\n" + c.rows;
    if (c.metres == 0.0) {
      const std::string said = message(text);
      EXPECT_NE(said.find(c.said), std::string::npos) << said;
      continue;
    }
    const Trajectory read = trajectory(text);
    ASSERT_EQ(read.positions_m.size(), 2u);
    // Inches are rounded twice.
    const double rounding = std::numeric_limits<double>::epsilon() * c.metres;
    EXPECT_LE((read.positions_m[0].array() - c.metres).abs().maxCoeff(), rounding);
    EXPECT_EQ(read.notes.empty(), c.metres == 1.0 && c.rows != kForces && c.rows != kFive);
    const std::string said = read.warnings.empty() ? "" : read.warnings[0];
    EXPECT_EQ(said.empty(), std::string(c.said).empty()) << said;
    EXPECT_NE(said.find(c.said), std::string::npos) << said;
    EXPECT_LE(read.warnings.size(), 1u);
    const bool has_times = c.rows == kFour || c.rows == kFive || c.rows[1] == ',';
    EXPECT_EQ(read.times_ns.empty(), !has_times);
    if (has_times) {
      EXPECT_EQ(read.times_ns.back(), 500'000'000);
    }
  }
}

TEST_F(TrajectoryFile, ReadsTimesBesideTheNamesOfATrace) {
  for (const char* name : {"time_ms", "t [ms]", "t_ms", "timestamp [ms]", "T (ms)"}) {
    SCOPED_TRACE(name);
    const Trajectory read = trajectory(
        std::string(name) + ",device_x,device_y,device_z\n0,1,-2.5,3e-3\n2,4,0,-0.0625\n");
    EXPECT_EQ(read.positions_m, kTwoPoints);
    EXPECT_EQ(read.times_ns, (std::vector<std::int64_t>{0, 2'000'000}));
  }
}

TEST_F(TrajectoryFile, ReadsTheRateThatACommentStates) {
  for (const char* comment :
       {"# sampled at 500 Hz", "# rate: 0.5kHz", "# Sampling frequency (Hz): 500", "# fs = 500",
        "# dt = 0.002 s", "# dt=2ms", "# sample_period: 2 ms", "# sampling rate: 500",
        "# 500 Hz"}) {
    const Trajectory read = trajectory(std::string("\n") + comment + "\n1 2 3\n");
    EXPECT_EQ(read.stated_rate_Hz, 500.0) << comment;
    EXPECT_EQ(read.stated_rate_line, 2u);
  }
  for (const char* comment :
       {"# a filter of 50 Hz", "# rate of the pen", "# 500", "# rate: -5 Hz"}) {
    EXPECT_FALSE(trajectory(std::string(comment) + "\n1 2 3\n").stated_rate_Hz) << comment;
  }
}

TEST_F(TrajectoryFile, RefusesUnitsByName) {
  for (const char* unit : {"parsec", "px", "mm/s", "1e-3 m", "deg", "Mm", "m m", ""}) {
    const std::string u = unit;
    expect_message("x [" + u + "],y [" + u + "],z [" + u + "]\n1,2,3\n",
                   "line 1: ", "the unit \"" + u + "\" in column 1");
  }
  expect_message("x_px,y_px,z_px\n1,2,3\n", "line 1: ", "\"x_px\"");
  expect_message("x [mm],y,z\n1,2,3\n", "line 1: ", "units for 1 of the columns");
  expect_message("t [parsec],x,y,z\n1,2,3,4\n", "line 1: ", "no known unit of time");
  expect_message("t [m],x,y,z\n1,2,3,4\n", "line 1: ", "no known unit of time");
  expect_message("n_[samples],x,y,z\n1,2,3,4\n", "line 2: ", "counts samples");
  expect_message("secs,nsecs,x,y,z\n1,2,3,4,5\n", "line 1: ", "several times");
}

TEST_F(TrajectoryFile, UsesNoOtherColumn) {
  const Trajectory read = trajectory(
      "frame,fx,qw,z,pressure,x,note,y\n0,1,2,3e-3,4,1,of a pen,-2.5\n1,1,2,-0.0625,,4,,0\n");
  EXPECT_EQ(read.positions_m, kTwoPoints);
  ASSERT_EQ(read.notes.size(), 1u);
  EXPECT_NE(read.notes[0].find("\"frame\", \"fx\", \"qw\", \"pressure\", \"note\""),
            std::string::npos)
      << read.notes[0];
  for (const char* header : {"vx,vy,vz", "fx,fy,fz", "roll,pitch,yaw", "a,b,c", "null,null,null"}) {
    expect_message(std::string(header) + "\n1,2,3\n", "line 1: ", "names no column x, y, z");
  }
}

TEST_F(TrajectoryFile, DropsNoFirstRow) {
  EXPECT_EQ(positions("1 -2.5 3e-3\n4 0 -0.0625\n"), kTwoPoints);
  expect_message("0,0,x\n1,2,3\n", "line 1: ", "column 3 is \"x\"");
  expect_message("1e-3,,0\n1,2,3\n", "line 1: ", "column 2 is empty");
  expect_message("1mm 2mm 3mm\n1 2 3\n", "line 1: ", "column 1 is \"1mm\"");
  expect_message("--1 2 3\n1 2 3\n", "line 1: ", "column 1 is \"--1\"");
  expect_message("device positions\n1 2 3\n", "line 1: ", "names no column x, y, z");
}

TEST_F(TrajectoryFile, NamesDecimalCommas) {
  expect_message("0,06 0,1 0,2\n", "line 1: ", "a comma may separate columns or decimals");
  expect_message("0,1 5 5\n1,2 5 5\n", "line 1: ", "a comma may separate columns or decimals");
  expect_message("1.234,5;2;3\n", "line 1: ", "column 1 is \"1.234,5\"");
  expect_message("1.5;2;3\n1;2,5;3\n", "line 2: ", "line 1 has a decimal point");
  const std::string said = message("0,06,0,0,0,1\n");
  EXPECT_NE(said.find("decimal commas"), std::string::npos) << said;
}

TEST_F(TrajectoryFile, NamesOtherEncodings) {
  const std::string text = "1 2 3\n4 5 6\n";
  std::string little = "\xff\xfe";
  std::string big;
  for (const char c : text) {
    little += {c, '\0'};
    big += {'\0', c};
  }
  for (const std::string& bytes : {little, little.substr(2), big, "\xfe\xff" + big}) {
    const std::string said = message(bytes);
    EXPECT_NE(said.find("is text in UTF-16"), std::string::npos) << said;
  }
}

TEST_F(TrajectoryFile, AcceptsNanAndInfinityAsSamples) {
  const auto points = positions("nan NaN -nan\ninf -inf INF\n+inf infinity -Infinity\n");
  ASSERT_EQ(points.size(), 3u);
  EXPECT_TRUE(points[0].array().isNaN().all());
  EXPECT_EQ(points[1], Vec3(kInfinity, -kInfinity, kInfinity));
  EXPECT_EQ(points[2], Vec3(kInfinity, kInfinity, -kInfinity));
}

TEST_F(TrajectoryFile, RestoresEveryDoubleToTheBit) {
  Random random(7101);
  std::vector<Vec3> written;
  std::string text;
  while (written.size() < 20000) {
    Vec3 p;
    for (double& c : p) {
      c = std::bit_cast<double>(random.index(~std::uint64_t{0}));
      if (!std::isfinite(c)) c = std::numeric_limits<double>::denorm_min();
      std::array<char, 32> digits;
      text.append(digits.data(),
                  std::to_chars(digits.data(), digits.data() + digits.size(), c).ptr);
      text += ' ';
    }
    text += '\n';
    written.push_back(p);
  }
  EXPECT_TRUE(positions(text) == written);
}

TEST_F(TrajectoryFile, ReadsThePointAsDecimalInEveryLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "C.UTF-8"}) {
    if (std::setlocale(LC_ALL, name)) break;
  }
  EXPECT_EQ(positions("1 -2.5 3e-3\n4 0 -0.0625\n"), kTwoPoints);
  std::setlocale(LC_ALL, before.c_str());
}

TEST_F(TrajectoryFile, NamesTheLineOfAFieldThatIsNotANumber) {
  expect_message("1 2 3\n# c\n1 2 3mm\n", "line 3: ", "column 3 is \"3mm\"; expected a number");
  expect_message("1 2 o\n", "line 1: ", "column 3 is \"o\"");
  expect_message("x y z\nx y z\n", "line 2: ", "column 1 is \"x\"");
  expect_message("0x10 1 1\n", "line 1: ", "\"0x10\"");
  expect_message("1 2 --3\n", "line 1: ", "\"--3\"");
  expect_message("1 2 +-3\n", "line 1: ", "\"+-3\"");
  expect_message("1 2 3\n1 2 1e400\n", "line 2: ", "range of a double");
  expect_message("1e400 2 3\n", "line 1: ", "range of a double");
  expect_message("1:2:3\n1:2:3\n", "line 1: ", "has 1 column; expected 3 or 4");
  expect_message("1,,3\n", "line 1: ", "column 2 is empty");
  expect_message("1,2,3,\n", "line 1: ", "column 4 is empty");
  expect_message(",1,2\n", "line 1: ", "column 1 is empty");
  expect_message(std::string("1 2 3\n1 2 \x01\0\x7f\n", 13),
                 "line 2: ", "column 3 is \"" + std::string("\x01\0\x7f", 3) + "\"");
}

TEST_F(TrajectoryFile, RefusesLinesOfAnotherLength) {
  expect_message("1 2\n", "line 1: ", "has 2 columns; expected 3 or 4");
  expect_message(std::string("1 2 3\n\0\0\0\n", 10), "line 2: ", "bytes of value 0");
  expect_message("1 2 3 4 5\n", "line 1: ", "has 5 columns");
  expect_message("\n1 2 3\n1 2 3\n1 2 3 4\n",
                 "line 4: ", "has 4 columns; expected 3 columns as in line 2");
  expect_message("t x y z\n1 2 3\n", "line 2: ", "has 3 columns; expected 4 columns as in line 1");
  expect_message("x y z\n0 1 2 3\n", "line 2: ", "has 4 columns; expected 3 columns as in line 1");
}

TEST_F(TrajectoryFile, RefusesAHeaderWithoutThreeAxes) {
  for (const char* header : {"x y", "t x y", "x", "x y x", "x,y,z,x", "x [mm],y [mm]"}) {
    expect_message(std::string(header) + "\n1 2 3\n", "line 1: ", "is the header");
  }
}

TEST_F(TrajectoryFile, RefusesATimeThatDoesNotIncrease) {
  expect_message("0 1 2 3\n1 1 2 3\n1 1 2 3\n",
                 "line 3: ", "time \"1\" does not increase by a nanosecond");
  expect_message("0 1 2 3\n1e-10 1 2 3\n", "line 2: ", "does not increase by a nanosecond");
  expect_message("0 1 2 3\n1e10 1 2 3\n", "line 2: ", "more than 292 years");
  expect_message("0 1 2 3\n1e28 1 2 3\n", "line 2: ", "expected less than 1e12 s");
  expect_message("0 1 2 3\n-0.5 1 2 3\n", "line 2: ", "does not increase");
  expect_message("0 1 2 3\nnan 1 2 3\n", "line 2: ", "time is \"nan\"; expected a finite number");
  expect_message("-inf 1 2 3\n", "line 1: ", "finite");
}

TEST_F(TrajectoryFile, ReadsTheDeviceOfATrace) {
  for (const char* text : {
           "tick,t,device_x,device_y,device_z,goal_x,friction,faults,step_ns\n"
           "0,0,1,-2.5,3e-3,9,none,,90\n1,0.001,4,0,-0.0625,nan,sticks,jump,91\n",
           "device_z,x,faults,device_x,t,device_y\r\n"
           "3e-3,7,,1,-5,-2.5\r\n-0.0625,seven,a+b,4,-4,0\r\n",
           "# of a run\n\ndevice_x, device_y, device_z\n1, -2.5, 3e-3\n4,0,-0.0625\n",
           "device_x device_y device_z speed\n1 -2.5 3e-3 a\n4 0 -0.0625 b\n",
       }) {
    SCOPED_TRACE(text);
    EXPECT_EQ(positions(text), kTwoPoints);
  }
  const auto faults = positions(
      "device_x,device_y,device_z,faults\nnan,0,1,non_finite_sample\n"
      "0,-inf,1,non_finite_sample\n");
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_TRUE(std::isnan(faults[0].x()));
  EXPECT_EQ(faults[1], Vec3(0.0, -kInfinity, 1.0));
}

TEST_F(TrajectoryFile, RejectsAnIncompleteTrace) {
  const std::string start = "t,device_x,device_y,device_z,faults\n0,1,2,3,\n";
  expect_message(start + "1,1,2,3", "line 3: ", "is cut off; expected 5 columns as in line 1");
  expect_message(start + "1,1,2,3,jum", "line 3: ", "is cut off");
  expect_message(start + "1,1,2,3\n", "line 3: ", "has 4 columns; expected 5 columns as in line 1");
  expect_message(start + "1,1,2,3,,\n2,1,2,3,\n", "line 3: ", "has 6 columns");
  expect_message(start + "1,1,,3,\n", "line 3: ", "column 3 is empty");
  expect_message(start + "1,1,two,3,\n", "line 3: ", "column 3 is \"two\"");
  expect_message(start + "0,1,2,3,\n", "line 3: ", "time \"0\" does not increase");
  expect_message(start + ",1,2,3,\n", "line 3: ", "column 1 is empty");
  for (const char* header :
       {"t,device_x,device_y,goal_z", "t,device_x,device_y,device_z,device_x", "device_y,x,t,z"}) {
    expect_message(std::string(header) + "\n1,2,3,4\n", "line 1: ", "device_x, device_y and");
  }
  const std::string said = message("device_x,device_y,device_z\n");
  EXPECT_TRUE(said.starts_with(path_ + ": contains no sample")) << said;
}

TEST_F(TrajectoryFile, RefusesAFileWithoutSamples) {
  for (const char* text : {"", "\n\n", "# nothing\n", "x y z\n", "\xef\xbb\xbf"}) {
    const std::string said = message(text);
    EXPECT_TRUE(said.starts_with(path_ + ": contains no sample")) << said;
  }
}

TEST_F(TrajectoryFile, RefusesEndlessLinesWithoutReadingThem) {
  expect_message("1 2 3\n" + std::string(100000, '1') + "\n", "line 2: ", "longer than");
  const auto result = read_trajectory("/dev/zero");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().element, "line 1");
}

TEST_F(TrajectoryFile, StatesWhyAFileCannotBeOpened) {
  const auto missing = read_trajectory("no/such/file.txt");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kFileNotFound);
  EXPECT_EQ(missing.error().path, "no/such/file.txt");
  const auto folder = read_trajectory(testing::TempDir());
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().code, ErrorCode::kFileUnreadable);
}

}  // namespace
}  // namespace palpate
