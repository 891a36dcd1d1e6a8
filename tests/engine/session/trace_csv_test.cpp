#include "engine/session/trace_csv.h"

#include <bit>
#include <charconv>
#include <clocale>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <span>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "haptics/effects/effect_program.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/needs.h"
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

  std::string write(const std::vector<TickRecord>& rows) {
    TraceWriter trace = writer();
    for (const TickRecord& row : rows) trace.add(row);
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
// as doubles, the angle as it is.
std::vector<double> values_of(const TickRecord& row) {
  std::vector<double> values{static_cast<double>(row.tick), row.time_s};
  const auto append = [&](std::span<const double> numbers) {
    values.insert(values.end(), numbers.begin(), numbers.end());
  };
  append(row.device_m);
  append(row.goal_scene_m);
  append(row.proxy_scene_m);
  append(row.normal_scene);
  append(row.force_device_N);
  values.push_back(row.contact);
  values.push_back(row.alpha_rad);
  append(row.q_before_wxyz);
  append(row.o_before_m);
  return values;
}
constexpr std::size_t kAngleColumn = 18;

// Those behind step_ns, likewise, but for effects.
std::vector<double> later_values_of(const TickRecord& row) {
  std::vector<double> values;
  const auto append = [&](std::span<const double> numbers) {
    values.insert(values.end(), numbers.begin(), numbers.end());
  };
  append(row.full_force_device_N);
  append(row.q_after_wxyz);
  append(row.o_after_m);
  return values;
}

// A row whose doubles have any bits: subnormal, huge, negative zero, infinite.
TickRecord random_row(Random& random, std::uint64_t tick) {
  const auto number = [&random] {
    const double value = std::bit_cast<double>(random.index(~std::uint64_t{0}));
    return std::isnan(value) ? -0.0 : value;
  };
  TickRecord row;
  for (const RecordField& field : kRecordFields) {
    if (field.type != FieldType::kDouble) continue;
    for (std::size_t k = 0; k < field.count; ++k) {
      const double value = number();
      std::memcpy(reinterpret_cast<char*>(&row) + field.offset + k * sizeof value, &value,
                  sizeof value);
    }
  }
  row.tick = tick;
  row.contact = random.index(2) == 1;
  row.alpha_rad = random.uniform(0.0, 1.5);  // in degrees in the table
  row.rotation_rad = random.uniform(0.0, 1.5);
  row.step_ns = static_cast<std::int64_t>(random.index(1u << 30));
  row.late_ns = static_cast<std::int64_t>(random.index(1u << 30));
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

std::uint64_t bits(double value) {
  return std::bit_cast<std::uint64_t>(value);
}

TEST_F(TraceFile, HasTheColumnsInTheirOrderAndNewOnesLast) {
  TickRecord row;
  row.tick = 1;
  row.time_s = 2;
  put(Vec3(3, 4, 5), row.device_m);
  put(Vec3(6, 7, 8), row.goal_scene_m);
  put(Vec3(9, 10, 11), row.proxy_scene_m);
  put(Vec3(12, 13, 14), row.normal_scene);
  put(Vec3(15, 16, 17), row.force_device_N);
  row.contact = 1;
  row.alpha_rad = std::numbers::pi / 2;
  put(ScenePose{Quat(20, 21, 22, 23), {24, 25, 26}}, row.q_before_wxyz, row.o_before_m);
  row.friction = FrictionState::kSlides;
  row.faults = kFaultSolverCapped | kFaultBodyHeld | 1u << 15;
  row.step_ns = 27;
  put(Vec3(28, 29, 30), row.full_force_device_N);
  put(ScenePose{Quat(31, 32, 33, 34), {35, 36, 37}}, row.q_after_wxyz, row.o_after_m);
  row.rotation_rad = std::numbers::pi;
  row.effects = 3;
  row.iterations = 39;
  row.late_ns = -40;
  row.rules = kRuleMotors | kRuleTripped | 1u << 31;
  row.body = 41;
  row.material = kNothingTouched;
  row.contacts = 2;
  row.touch = kTouchBegan;
  const std::string effects =
      std::string(compiled_effects()[0].name) + "+" + std::string(compiled_effects()[1].name);
  EXPECT_EQ(write({row}),
            "tick,t,device_x,device_y,device_z,goal_x,goal_y,goal_z,proxy_x,proxy_y,proxy_z,"
            "normal_x,normal_y,normal_z,force_x,force_y,force_z,contact,alpha_deg,"
            "q_w,q_x,q_y,q_z,o_x,o_y,o_z,friction,faults,step_ns,"
            "full_force_x,full_force_y,full_force_z,q_after_w,q_after_x,q_after_y,q_after_z,"
            "o_after_x,o_after_y,o_after_z,rotation_deg,effects,iterations,late_ns,"
            "rules,body,material,contacts,touch\n"
            "1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,1,90,20,21,22,23,24,25,26,"
            "slides,solver_capped+body_held+bit_15,27,"
            "28,29,30,31,32,33,34,35,36,37,180," +
                effects + ",39,-40,motors+tripped+bit_31,41,-1,2,began\n");
}

TEST_F(TraceFile, SaysWhenATouchEndsAndLeavesOutWhatIsUnknown) {
  TickRecord ended;
  ended.touch = kTouchEnded;
  TickRecord unknown;  // of a recording of version 1
  unknown.body = unknown.material = kTouchUnknown;
  std::istringstream lines(write({ended, unknown}));
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  EXPECT_TRUE(line.ends_with(",0,0,,-1,-1,0,ended")) << line;
  std::getline(lines, line);
  EXPECT_TRUE(line.ends_with(",0,0,,,,,")) << line;
}

TEST_F(TraceFile, GivesEveryDoubleBackToTheBit) {
  Random random(7201);
  std::vector<TickRecord> rows;
  for (std::uint64_t i = 0; i < 5000; ++i) rows.push_back(random_row(random, i));
  std::istringstream lines(write(rows));
  std::string line;
  std::getline(lines, line);
  for (const TickRecord& row : rows) {
    ASSERT_TRUE(std::getline(lines, line));
    const auto fields = split(line);
    auto expected = values_of(row);
    expected[kAngleColumn] = row.alpha_rad * 180.0 / std::numbers::pi;
    const auto later = later_values_of(row);
    ASSERT_EQ(fields.size(), expected.size() + 3 + later.size() + 8);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(bits(number_of(fields[i])), bits(expected[i])) << fields[i];
    }
    ASSERT_EQ(fields[28], std::to_string(row.step_ns));
    for (std::size_t i = 0; i < later.size(); ++i) {
      ASSERT_EQ(bits(number_of(fields[29 + i])), bits(later[i])) << fields[29 + i];
    }
    ASSERT_EQ(fields[42], std::to_string(row.late_ns));
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(TraceFile, WritesSeventeenDigitsAndTheExtremes) {
  TickRecord row;
  row.tick = std::numeric_limits<std::uint64_t>::max();
  row.time_s = 0.1;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  put(Vec3::Constant(-kInfinity), row.device_m);
  put(Vec3(kNan, -kNan, -0.0), row.goal_scene_m);
  put(Vec3::Constant(-std::numeric_limits<double>::min() / 3), row.proxy_scene_m);
  put(Vec3::Constant(-std::numeric_limits<double>::max()), row.normal_scene);
  put(Vec3::Constant(kInfinity), row.force_device_N);
  row.step_ns = std::numeric_limits<std::int64_t>::min();
  const auto fields = split(write({row}).substr(trace_columns().size() + 1));
  ASSERT_EQ(fields.size(), 48u) << "the last one is empty";
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
  EXPECT_EQ(fields[28], "-9223372036854775808");
}

TEST_F(TraceFile, WritesThePointAsDecimalInEveryLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "C.UTF-8"}) {
    if (std::setlocale(LC_ALL, name)) break;
  }
  TickRecord row;
  row.time_s = 0.5;
  EXPECT_TRUE(write({row}).substr(trace_columns().size() + 1).starts_with("0,0.5,0,"));
  std::setlocale(LC_ALL, before.c_str());
}

TEST_F(TraceFile, HoldsEveryRowOfATraceLargerThanTheBuffer) {
  constexpr std::uint64_t kRows = 20000;
  Random random(7202);
  std::vector<TickRecord> rows;
  for (std::uint64_t i = 0; i < kRows; ++i) rows.push_back(random_row(random, i));
  const std::string text = write(rows);
  ASSERT_GT(text.size(), 4u << 20);
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  for (std::uint64_t i = 0; i < kRows; ++i) {
    ASSERT_TRUE(std::getline(lines, line));
    ASSERT_TRUE(line.starts_with(std::to_string(i) + ",")) << line;
    ASSERT_TRUE(line.ends_with("," + std::to_string(rows[i].late_ns) + ",,-1,-1,0,")) << line;
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
  EXPECT_TRUE(content().starts_with(trace_columns()));
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
  EXPECT_TRUE(content().substr(trace_columns().size() + 1).starts_with("77,"));
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
  write({TickRecord{}});
  EXPECT_EQ(files(), 3) << "the trace, that of the living writer, and what is no writer's";
  alive.add({.tick = 5});
  ASSERT_TRUE(alive.finish());
  EXPECT_TRUE(content().substr(trace_columns().size() + 1).starts_with("5,"));
  EXPECT_EQ(files(), 2);
  EXPECT_TRUE(fs::exists(not_of_a_writer));
}

TEST_F(TraceFile, KeepsALinkALink) {
  const fs::path target = folder_ / "elsewhere.csv";
  std::ofstream(target) << "before";
  fs::create_symlink(target, path_);
  write({TickRecord{}});
  EXPECT_TRUE(fs::is_symlink(path_));
  EXPECT_TRUE(content().starts_with(trace_columns()));
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
  PALPATE_NEEDS(test::lack_of_full_disk());
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
