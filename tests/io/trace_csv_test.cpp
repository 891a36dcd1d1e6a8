#include "io/trace_csv.h"

#include <array>
#include <bit>
#include <charconv>
#include <clocale>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::Random;

// A folder of its own for each test, so that whatever a writer leaves behind is seen.
class TraceFile : public testing::Test {
 protected:
  TraceFile() : folder_(testing::TempDir() + "palpate_trace_" + std::to_string(::getpid())) {
    fs::remove_all(folder_);
    fs::create_directory(folder_);
    path_ = folder_ / "trace.csv";
  }
  ~TraceFile() override { fs::remove_all(folder_); }

  TraceWriter writer() {
    auto result = TraceWriter::create(path_);
    if (!result) ADD_FAILURE() << result.error().to_string();
    return std::move(*result);
  }

  std::string write(const std::vector<TraceRow>& rows) {
    TraceWriter trace = writer();
    for (const TraceRow& row : rows) trace.add(row);
    const auto count = trace.finish();
    if (!count) ADD_FAILURE() << count.error().to_string();
    return content();
  }

  std::string content() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  auto files() const { return std::distance(fs::directory_iterator(folder_), {}); }

  fs::path folder_;
  fs::path path_;
};

// The 26 numbers before friction, faults and step_ns, in the order of the columns; tick and contact
// as doubles.
std::array<double, 26> values_of(const TraceRow& row) {
  const Quat& q = row.T_device_scene.rotation;
  std::array<double, 26> values{static_cast<double>(row.tick), row.time_s};
  std::size_t i = 2;
  for (const Vec3& v :
       {row.device_m, row.goal_scene_m, row.proxy_scene_m, row.normal_scene, row.force_device_N}) {
    for (const double c : v) values[i++] = c;
  }
  values[i++] = row.contact ? 1.0 : 0.0;
  values[i++] = row.alpha_deg;
  for (const double c : {q.w(), q.x(), q.y(), q.z()}) values[i++] = c;
  for (const double c : row.T_device_scene.translation_m) values[i++] = c;
  return values;
}

// A row whose doubles have any bits: subnormal, huge, negative zero, infinite.
TraceRow random_row(Random& random, std::uint64_t tick) {
  const auto number = [&random] {
    const double value = std::bit_cast<double>(random.index(~std::uint64_t{0}));
    return std::isnan(value) ? -0.0 : value;
  };
  const auto vector = [&number] {
    const double x = number();
    const double y = number();
    return Vec3(x, y, number());
  };
  TraceRow row;
  row.tick = tick;
  row.time_s = number();
  for (Vec3* v : {&row.device_m, &row.goal_scene_m, &row.proxy_scene_m, &row.normal_scene,
                  &row.force_device_N, &row.T_device_scene.translation_m}) {
    *v = vector();
  }
  row.contact = random.index(2) == 1;
  row.alpha_deg = number();
  for (double& c : row.T_device_scene.rotation.coeffs()) c = number();
  row.step_ns = static_cast<std::int64_t>(random.index(1u << 30));
  return row;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

double number_of(const std::string& field) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), value);
  EXPECT_TRUE(code == std::errc() && end == field.data() + field.size()) << field;
  return value;
}

TEST_F(TraceFile, HasTheColumnsInTheirOrder) {
  TraceRow row;
  row.tick = 1;
  row.time_s = 2;
  row.device_m = {3, 4, 5};
  row.goal_scene_m = {6, 7, 8};
  row.proxy_scene_m = {9, 10, 11};
  row.normal_scene = {12, 13, 14};
  row.force_device_N = {15, 16, 17};
  row.contact = true;
  row.alpha_deg = 19;
  row.T_device_scene = {Quat(20, 21, 22, 23), {24, 25, 26}};
  row.friction = "slides";
  row.faults = "solver_capped+body_held";
  row.step_ns = 27;
  EXPECT_EQ(write({row}),
            "tick,t,device_x,device_y,device_z,goal_x,goal_y,goal_z,proxy_x,proxy_y,proxy_z,"
            "normal_x,normal_y,normal_z,force_x,force_y,force_z,contact,alpha_deg,"
            "q_w,q_x,q_y,q_z,o_x,o_y,o_z,friction,faults,step_ns\n"
            "1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,1,19,20,21,22,23,24,25,26,"
            "slides,solver_capped+body_held,27\n");
}

TEST_F(TraceFile, GivesEveryDoubleBackToTheBit) {
  Random random(7201);
  std::vector<TraceRow> rows;
  for (std::uint64_t i = 0; i < 5000; ++i) rows.push_back(random_row(random, i));
  std::istringstream lines(write(rows));
  std::string line;
  std::getline(lines, line);
  for (const TraceRow& row : rows) {
    ASSERT_TRUE(std::getline(lines, line));
    const auto fields = split(line);
    const auto expected = values_of(row);
    ASSERT_EQ(fields.size(), expected.size() + 3);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(number_of(fields[i])),
                std::bit_cast<std::uint64_t>(expected[i]))
          << fields[i];
    }
    ASSERT_EQ(fields.back(), std::to_string(row.step_ns));
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(TraceFile, WritesSeventeenDigitsAndTheExtremes) {
  TraceRow row;
  row.tick = std::numeric_limits<std::uint64_t>::max();
  row.time_s = 0.1;
  row.device_m = Vec3::Constant(-std::numeric_limits<double>::infinity());
  row.goal_scene_m = {std::numeric_limits<double>::quiet_NaN(),
                      -std::numeric_limits<double>::quiet_NaN(), -0.0};
  row.proxy_scene_m = Vec3::Constant(-std::numeric_limits<double>::min() / 3);
  row.normal_scene = Vec3::Constant(-std::numeric_limits<double>::max());
  row.force_device_N = Vec3::Constant(std::numeric_limits<double>::infinity());
  row.step_ns = std::numeric_limits<std::int64_t>::min();
  const auto fields = split(write({row}).substr(kTraceColumns.size() + 1));
  ASSERT_EQ(fields.size(), 29u);
  EXPECT_EQ(fields[0], "18446744073709551615");
  EXPECT_EQ(fields[1], "0.10000000000000001");
  EXPECT_EQ(fields[2], "-inf");
  EXPECT_EQ(fields[5], "nan");
  EXPECT_EQ(fields[6], "nan");
  EXPECT_EQ(fields[7], "-0");
  EXPECT_EQ(fields[8], "-7.4169128616906696e-309");
  EXPECT_EQ(fields[11], "-1.7976931348623157e+308");
  EXPECT_EQ(fields[14], "inf");
  EXPECT_EQ(fields[26], "none");
  EXPECT_EQ(fields[27], "");
  EXPECT_EQ(fields[28], "-9223372036854775808\n");
}

// Whatever a caller puts there, a row stays in the room that is kept for it.
TEST_F(TraceFile, CutsOffWhatCannotBeNames) {
  std::vector<TraceRow> rows(3000);
  const std::string is_long(1000, 'x');
  for (TraceRow& row : rows) {
    row.friction = is_long;
    row.faults = is_long;
  }
  std::istringstream lines(write(rows));
  std::string line;
  std::getline(lines, line);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_TRUE(std::getline(lines, line));
    ASSERT_EQ(split(line)[26], std::string(kMaxFrictionBytes, 'x'));
    ASSERT_EQ(split(line)[27], std::string(kMaxFaultBytes, 'x'));
  }
}

TEST_F(TraceFile, WritesThePointAsDecimalInEveryLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "C.UTF-8"}) {
    if (std::setlocale(LC_ALL, name)) break;
  }
  TraceRow row;
  row.time_s = 0.5;
  EXPECT_TRUE(write({row}).substr(kTraceColumns.size() + 1).starts_with("0,0.5,0,"));
  std::setlocale(LC_ALL, before.c_str());
}

TEST_F(TraceFile, HoldsEveryRowOfATraceLargerThanTheBuffer) {
  constexpr std::uint64_t kRows = 20000;
  Random random(7202);
  std::vector<TraceRow> rows;
  for (std::uint64_t i = 0; i < kRows; ++i) rows.push_back(random_row(random, i));
  const std::string text = write(rows);
  ASSERT_GT(text.size(), 4u << 20);
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  for (std::uint64_t i = 0; i < kRows; ++i) {
    ASSERT_TRUE(std::getline(lines, line));
    ASSERT_TRUE(line.starts_with(std::to_string(i) + ",")) << line;
    ASSERT_TRUE(line.ends_with("," + std::to_string(rows[i].step_ns))) << line;
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(TraceFile, AppearsOnlyWhenFinished) {
  std::ofstream(path_) << "before";
  {
    TraceWriter trace = writer();
    for (std::uint64_t i = 0; i < 20000; ++i) trace.add({.tick = i});
    EXPECT_EQ(content(), "before");
  }
  EXPECT_EQ(content(), "before");
  EXPECT_EQ(files(), 1) << "an abandoned trace leaves a file behind";
  TraceWriter trace = writer();
  trace.add({});
  TraceWriter moved = std::move(trace);
  moved.add({.tick = 1});
  const auto count = moved.finish();
  ASSERT_TRUE(count);
  EXPECT_EQ(*count, 2u);
  EXPECT_TRUE(content().starts_with(kTraceColumns));
  EXPECT_EQ(files(), 1);
  moved.add({});
  EXPECT_FALSE(moved.finish());
}

TEST_F(TraceFile, TwoWritersOfOneNameDoNotMix) {
  TraceWriter first = writer();
  TraceWriter second = writer();
  for (std::uint64_t i = 0; i < 10; ++i) first.add({.tick = i});
  second.add({.tick = 77});
  ASSERT_TRUE(first.finish());
  ASSERT_TRUE(second.finish());
  EXPECT_TRUE(content().substr(kTraceColumns.size() + 1).starts_with("77,"));
  EXPECT_EQ(files(), 1);
}

TEST_F(TraceFile, RemovesWhatAKilledWriterHasLeft) {
  const std::string not_of_a_writer = path_.string() + ".1-x.part";
  std::ofstream(not_of_a_writer) << "mine";
  TraceWriter alive = writer();
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    TraceWriter trace = writer();
    for (std::uint64_t i = 0; i < 20000; ++i) trace.add({.tick = i});
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(files(), 3) << "two unfinished ones, and one that is no writer's";
  write({TraceRow{}});
  EXPECT_EQ(files(), 3) << "the trace, that of the living writer, and what is no writer's";
  alive.add({.tick = 5});
  ASSERT_TRUE(alive.finish());
  EXPECT_TRUE(content().substr(kTraceColumns.size() + 1).starts_with("5,"));
  EXPECT_EQ(files(), 2);
  EXPECT_TRUE(fs::exists(not_of_a_writer));
}

TEST_F(TraceFile, KeepsALinkALink) {
  const fs::path target = folder_ / "elsewhere.csv";
  std::ofstream(target) << "before";
  fs::create_symlink(target, path_);
  write({TraceRow{}});
  EXPECT_TRUE(fs::is_symlink(path_));
  EXPECT_TRUE(content().starts_with(kTraceColumns));
  EXPECT_EQ(files(), 2);
}

TEST_F(TraceFile, SaysWhatCannotBeWritten) {
  for (const std::string& path :
       {(folder_ / "missing" / "trace.csv").string(), folder_.string(), std::string()}) {
    const auto result = TraceWriter::create(path);
    ASSERT_FALSE(result) << path;
    EXPECT_EQ(result.error().code, ErrorCode::kFileUnwritable);
    EXPECT_EQ(result.error().path, path);
    EXPECT_FALSE(result.error().hint.empty());
  }
}

TEST_F(TraceFile, WritesToADeviceInPlaceAndReportsThatItIsFull) {
  auto trace = TraceWriter::create("/dev/full");
  ASSERT_TRUE(trace) << trace.error().to_string();
  trace->add({});
  const auto count = trace->finish();
  ASSERT_FALSE(count);
  EXPECT_NE(count.error().problem.find("No space left"), std::string::npos)
      << count.error().problem;
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

}  // namespace
}  // namespace palpate
