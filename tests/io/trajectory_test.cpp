#include "io/trajectory.h"

#include <array>
#include <bit>
#include <charconv>
#include <clocale>
#include <cmath>
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

class Trajectory : public testing::Test {
 protected:
  Trajectory()
      : path_(testing::TempDir() + "palpate_trajectory_" + std::to_string(::getpid()) + ".txt") {}
  ~Trajectory() override { std::filesystem::remove(path_); }

  Result<std::vector<Vec3>> read(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return read_trajectory(path_);
  }

  // The positions; empty, with a test failure, on an error.
  std::vector<Vec3> positions(const std::string& text) {
    auto result = read(text);
    if (result) return *result;
    ADD_FAILURE() << result.error().to_string();
    return {};
  }

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

TEST_F(Trajectory, SeparatesColumnsByBlanksOrCommas) {
  for (const char* text : {
           "1 -2.5 3e-3\n4 0 -0.0625\n",
           "1,-2.5,3e-3\n4,0,-0.0625\n",
           "1, -2.5, 3e-3\n4 ,0 , -0.0625\n",
           "  1\t-2.5 \t 3e-3  \n\t4 0 -0.0625",
           "1 -2.5 3e-3\r\n4 0 -0.0625\r\n",
           "1, -2.5 3E-3\n+4 .0 -.0625\n",
       }) {
    SCOPED_TRACE(text);
    EXPECT_EQ(positions(text), kTwoPoints);
  }
}

TEST_F(Trajectory, SkipsCommentsAndEmptyLines) {
  EXPECT_EQ(positions("\xef\xbb\xbf# a pen\r\n\r\n1 -2.5 3e-3# 9 9 9\n   \n#5 5 5\n  # x\n"
                      "4 0 -0.0625 #\n\n"),
            kTwoPoints);
}

TEST_F(Trajectory, SkipsAHeaderThatAgreesWithTheColumns) {
  for (const char* header : {
           "x y z",
           "X,Y,Z",
           "x_m y_m z_m",
           "x (m), y (m), z (m)",
           "# comment\n\nx\ty\tz",
           "device positions",
           "px, py, pz",
           "a header of more words than columns",
       }) {
    SCOPED_TRACE(header);
    EXPECT_EQ(positions(std::string(header) + "\n1 -2.5 3e-3\n4 0 -0.0625\n"), kTwoPoints);
  }
}

TEST_F(Trajectory, IgnoresALeadingTimeThatIncreases) {
  for (const char* header : {"", "t x y z\n", "Time, X, Y, Z\n", "time (s),x [m],y [m],z [m]\n",
                             "frame x y z\n", "t_ms px py pz\n", "four columns each line\n"}) {
    SCOPED_TRACE(header);
    EXPECT_EQ(positions(std::string(header) + "-5 1 -2.5 3e-3\n-4.999 4 0 -0.0625\n"), kTwoPoints);
  }
}

TEST_F(Trajectory, AcceptsNanAndInfinityAsSamples) {
  const auto points = positions("nan NaN -nan\ninf -inf INF\n+inf infinity -Infinity\n");
  ASSERT_EQ(points.size(), 3u);
  EXPECT_TRUE(points[0].array().isNaN().all());
  EXPECT_EQ(points[1], Vec3(kInfinity, -kInfinity, kInfinity));
  EXPECT_EQ(points[2], Vec3(kInfinity, kInfinity, -kInfinity));
}

TEST_F(Trajectory, RestoresEveryDoubleToTheBit) {
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

TEST_F(Trajectory, ReadsThePointAsDecimalInEveryLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "C.UTF-8"}) {
    if (std::setlocale(LC_ALL, name)) break;
  }
  EXPECT_EQ(positions("1 -2.5 3e-3\n4 0 -0.0625\n"), kTwoPoints);
  std::setlocale(LC_ALL, before.c_str());
}

TEST_F(Trajectory, NamesTheLineOfAFieldThatIsNotANumber) {
  expect_message("1 2 3\n# c\n1 2 3mm\n", "line 3: ", "column 3 is \"3mm\"; expected a number");
  expect_message("1 2 o\n", "line 1: ", "column 3 is \"o\"");
  expect_message("x y z\nx y z\n", "line 2: ", "column 1 is \"x\"");
  expect_message("0x10 1 1\n", "line 1: ", "\"0x10\"");
  expect_message("1 2 --3\n", "line 1: ", "\"--3\"");
  expect_message("1 2 +-3\n", "line 1: ", "\"+-3\"");
  expect_message("1 2 3\n1 2 1e400\n", "line 2: ", "range of a double");
  expect_message("1e400 2 3\n", "line 1: ", "range of a double");
  expect_message("1;2;3\n1;2;3\n", "line 2: ", "has 1 column; expected 3 or 4");
  expect_message("1,,3\n", "line 1: ", "column 2 is empty");
  expect_message("1,2,3,\n", "line 1: ", "column 4 is empty");
  expect_message(",1,2\n", "line 1: ", "column 1 is empty");
  expect_message(std::string("1 2 3\n1 2 \x01\0\x7f\n", 13), "line 2: ", "column 3 is \"???\"");
}

TEST_F(Trajectory, RefusesLinesOfAnotherLength) {
  expect_message("1 2\n", "line 1: ", "has 2 columns; expected 3 or 4");
  expect_message("1 2 3 4 5\n", "line 1: ", "has 5 columns");
  expect_message("\n1 2 3\n1 2 3\n1 2 3 4\n",
                 "line 4: ", "has 4 columns; expected 3 columns as in line 2");
  expect_message("t x y z\n1 2 3\n", "line 2: ", "has 3 columns; expected 4 columns as in line 1");
  expect_message("x y z\n0 1 2 3\n", "line 2: ", "has 4 columns; expected 3 columns as in line 1");
}

TEST_F(Trajectory, RefusesAHeaderOfAnotherOrder) {
  for (const char* header : {"x z y", "x y z t", "x y", "t x y", "y,x,z", "t x y z vx", "x"}) {
    expect_message(std::string(header) + "\n1 2 3\n",
                   "line 1: ", "expected the columns x y z or t");
  }
}

TEST_F(Trajectory, RefusesATimeThatDoesNotIncrease) {
  expect_message("0 1 2 3\n1 1 2 3\n1 1 2 3\n", "line 3: ", "time \"1\" does not increase");
  expect_message("0 1 2 3\n-0.5 1 2 3\n", "line 2: ", "does not increase");
  expect_message("0 1 2 3\nnan 1 2 3\n", "line 2: ", "time is \"nan\"; expected a finite number");
  expect_message("-inf 1 2 3\n", "line 1: ", "finite");
}

TEST_F(Trajectory, ReadsTheDeviceOfATrace) {
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

TEST_F(Trajectory, RejectsAnIncompleteTrace) {
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
       {"t,device_x,device_y,goal_z", "device_x,device_y,device_z,device_x", "device_y,x,y,z"}) {
    expect_message(std::string(header) + "\n1,2,3,4\n", "line 1: ", "device_x, device_y and");
  }
  const std::string said = message("device_x,device_y,device_z\n");
  EXPECT_TRUE(said.starts_with(path_ + ": contains no sample")) << said;
}

TEST_F(Trajectory, RefusesAFileWithoutSamples) {
  for (const char* text : {"", "\n\n", "# nothing\n", "x y z\n", "\xef\xbb\xbf"}) {
    const std::string said = message(text);
    EXPECT_TRUE(said.starts_with(path_ + ": contains no sample")) << said;
  }
}

TEST_F(Trajectory, RefusesEndlessLinesWithoutReadingThem) {
  expect_message("1 2 3\n" + std::string(100000, '1') + "\n", "line 2: ", "longer than");
  const auto result = read_trajectory("/dev/zero");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().element, "line 1");
}

TEST_F(Trajectory, StatesWhyAFileCannotBeOpened) {
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
