// What `accuracy` writes for other programs, for made-up knobs: the table and accuracy.json.

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/accuracy/accuracy_csv.h"
#include "engine/accuracy/accuracy_json.h"
#include "engine/devices/light_device.h"
#include "engine/report/text_file.h"
#include "geometry/base/printable.h"
#include "tests/engine/accuracy/sample_knobs.h"
#include "tests/helpers/made.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder()
      : path_(testing::TempDir() + "palpate report's \"folder\" " + std::to_string(::getpid())) {
    fs::remove_all(path_);
    fs::create_directory(path_);
  }
  ~Folder() { fs::remove_all(path_); }

  std::string file(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A reader of RFC 4180, independent of the writer.
std::vector<std::vector<std::string>> parsed_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row;
  std::string field;
  bool in_quotes = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_quotes) {
      if (c != '"') {
        field += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        field += text[++i];
      } else {
        in_quotes = false;
      }
    } else if (c == '"') {
      in_quotes = true;
    } else if (c == ',' || c == '\n') {
      row.push_back(std::exchange(field, {}));
      if (c == '\n') rows.push_back(std::exchange(row, {}));
    } else {
      field += c;
    }
  }
  EXPECT_FALSE(in_quotes);
  EXPECT_TRUE(row.empty() && field.empty()) << "no line break at the end";
  return rows;
}

// Rows by the names of their columns.
std::vector<std::map<std::string, std::string>> table_of(const std::vector<KnobResult>& results) {
  const auto rows = parsed_csv(accuracy_csv(results));
  std::vector<std::map<std::string, std::string>> table;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].size(), rows[0].size()) << "row " << i;
    if (rows[i].size() != rows[0].size()) return table;
    auto& entry = table.emplace_back();
    for (std::size_t c = 0; c < rows[0].size(); ++c) entry[rows[0][c]] = rows[i][c];
  }
  return table;
}

double number(const std::string& text) {
  double value = 0.0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  EXPECT_EQ(end.ptr, text.data() + text.size()) << text;
  EXPECT_FALSE(text.empty());
  return value;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class AllSamples : public testing::Test {
 protected:
  static void SetUpTestSuite() { results_ = new std::vector<KnobResult>(test::all_samples()); }
  static void TearDownTestSuite() { delete results_; }
  static const std::vector<KnobResult>& results() { return *results_; }

 private:
  static inline std::vector<KnobResult>* results_ = nullptr;
};

// Table

TEST_F(AllSamples, ATableHasARowForEachLevelAndPreset) {
  std::size_t expected = 0;
  for (const KnobResult& result : results()) {
    for (const MethodResult& method : result.methods) expected += method.levels.size();
    expected += kPresetNames.size();
  }
  EXPECT_EQ(table_of(results()).size(), expected);
}

TEST_F(AllSamples, ATableGivesBackEveryNumberToTheBit) {
  const auto table = table_of(results());
  std::size_t row = 0;
  for (const KnobResult& result : results()) {
    for (std::size_t m = 0; m < result.methods.size(); ++m) {
      for (std::size_t l = 0; l < result.methods[m].levels.size(); ++l) {
        const LevelResult& level = result.methods[m].levels[l];
        auto entry = table.at(row++);
        EXPECT_EQ(number(entry["value"]), level.value);
        EXPECT_EQ(entry["on_front"], level.on_front ? "1" : "0");
        EXPECT_EQ(entry["at_floor"] == "1", level.at_floor);
        EXPECT_EQ(entry["failures"], std::to_string(level.failures));
        EXPECT_EQ(entry["repeats"], "21");
        EXPECT_EQ(entry["is_default"] == "1",
                  m == result.knob.default_method && l == result.knob.default_level);
        EXPECT_EQ(entry["recommended"] == "1", result.recommended &&
                                                   m == result.recommended->method &&
                                                   l == result.recommended->level);
        if (level.failures == level.repeats) {
          EXPECT_EQ(entry["error_median"] + entry["time_high"] + entry["iterations"], "");
          continue;
        }
        EXPECT_EQ(number(entry["error_median"]), level.error.median);
        EXPECT_EQ(number(entry["error_low"]), level.error.low);
        EXPECT_EQ(number(entry["error_high"]), level.error.high);
        EXPECT_EQ(number(entry["raw_error"]), level.raw_error);
        EXPECT_EQ(number(entry["time_median"]), level.time.median);
        EXPECT_EQ(number(entry["time_low"]), level.time.low);
        EXPECT_EQ(number(entry["time_high"]), level.time.high);
        EXPECT_EQ(number(entry["iterations"]), level.iterations);
        EXPECT_EQ(entry["time_unit"], result.knob.time.unit);
      }
    }
    for (const char* preset : kPresetNames) {
      auto entry = table.at(row++);
      EXPECT_EQ(entry["preset"], preset);
      EXPECT_EQ(entry["method"] + entry["level"] + entry["value"], "");
      EXPECT_EQ(entry["error_unit"], result.knob.error.unit);
    }
  }
}

TEST(AccuracyCsv, GivesBackNamesWithQuotesCommasAndLineBreaks) {
  const KnobResult hostile = test::sample_hostile("true");
  auto first = table_of({hostile}).at(0);
  EXPECT_EQ(first["knob"], hostile.knob.name);
  EXPECT_EQ(first["method"], hostile.methods[0].name);
  EXPECT_EQ(first["level"], hostile.methods[0].levels[0].label);
  EXPECT_EQ(first["failure"], hostile.methods[0].levels[0].failure);
  EXPECT_TRUE(contains(first["knob"], "\n") && contains(first["knob"], "\"") &&
              contains(first["knob"], ","));
}

TEST(AccuracyCsv, IsWrittenToAFileOrAnErrorNamesIt) {
  const Folder folder;
  const std::vector<KnobResult> results = {test::sample_mesh()};
  const std::string path = folder.file("report.csv");
  ASSERT_TRUE(write_text_file(path, accuracy_csv(results)).ok());
  EXPECT_EQ(content_of(path), accuracy_csv(results));

  const auto nowhere = write_text_file(folder.file("no/such/report.csv"), accuracy_csv(results));
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().code, ErrorCode::kFileUnwritable);
  EXPECT_EQ(nowhere.error().path, folder.file("no/such/report.csv"));
}

TEST(TextFile, AFullDiskIsNoticed) {
  PALPATE_NEEDS(test::lack_of_full_disk());
  for (const std::size_t bytes : {1u, 1u << 20}) {  // within one buffer, and beyond
    const auto written = write_text_file("/dev/full", std::string(bytes, 'x'));
    ASSERT_FALSE(written.ok()) << bytes;
    EXPECT_EQ(written.error().path, "/dev/full");
  }
  EXPECT_TRUE(fs::exists("/dev/full"));
}

// JSON

using Json = nlohmann::json;

// The chart takes a second.
const StiffnessChart& chart_with(DelayInterval delay) {
  static std::map<double, StiffnessChart> charts;
  const auto found = charts.find(delay.most_s);
  if (found != charts.end()) return found->second;
  DeviceDescription device = light_device();
  device.delay = delay;
  return charts[delay.most_s] = test::made(stiffness_chart(device, {}, 1000.0));
}

// The file of these knobs, and of a scene if there is one.
std::string json_text(const std::vector<KnobResult>& results, const SceneFindings* scene = nullptr,
                      DelayInterval delay = {}) {
  AdviceInput input;
  input.results = results;
  input.scene = scene;
  input.device = light_device();
  input.scene_options = {"a <b>.glb"};
  const Advice advice = test::made(advise(input));
  return accuracy_json({advice, {}, results, scene, chart_with(delay)});
}

void expect_spread(const Json& json, const Spread& spread) {
  EXPECT_EQ(json["low"].get<double>(), spread.low);
  EXPECT_EQ(json["median"].get<double>(), spread.median);
  EXPECT_EQ(json["high"].get<double>(), spread.high);
}

void expect_level(const Json& json, const LevelResult& level) {
  EXPECT_EQ(json["label"], printable(level.label));
  EXPECT_EQ(json["value"].get<double>(), level.value);
  EXPECT_EQ(json["failures"], level.failures);
  EXPECT_EQ(json["repeats"], level.repeats);
  EXPECT_EQ(json["failure"], printable(level.failure));
  EXPECT_EQ(json["at_floor"], level.at_floor);
  EXPECT_EQ(json["on_front"], level.on_front);
  if (!level.was_measured()) {
    EXPECT_TRUE(json["error"].is_null() && json["time"].is_null() && json["iterations"].is_null());
    return;
  }
  expect_spread(json["error"], level.error);
  expect_spread(json["time"], level.time);
  EXPECT_EQ(json["iterations"].get<double>(), level.iterations);
}

TEST_F(AllSamples, JsonGivesBackEveryNumberToTheBit) {
  const Json json = Json::parse(json_text(results()));
  EXPECT_EQ(json["format"], kAccuracyJsonFormat);
  EXPECT_TRUE(json["scene"].is_null());
  ASSERT_EQ(json["knobs"].size(), results().size());
  for (std::size_t k = 0; k < results().size(); ++k) {
    const KnobResult& result = results()[k];
    const Json& knob = json["knobs"][k];
    EXPECT_EQ(knob["enough"].get<double>(), result.knob.enough);
    EXPECT_EQ(knob["default"]["level"], result.knob.default_level);
    EXPECT_EQ(knob["recommended"].is_null(), !result.recommended.has_value());
    ASSERT_EQ(knob["methods"].size(), result.methods.size());
    for (std::size_t m = 0; m < result.methods.size(); ++m) {
      const MethodResult& method = result.methods[m];
      const Json& shown = knob["methods"][m];
      EXPECT_EQ(shown["floor"].get<double>(), method.floor);
      EXPECT_EQ(shown.value("order", Json(nullptr)),
                method.order ? Json(*method.order) : Json(nullptr));
      ASSERT_EQ(shown["levels"].size(), method.levels.size());
      for (std::size_t l = 0; l < method.levels.size(); ++l) {
        expect_level(shown["levels"][l], method.levels[l]);
      }
    }
    ASSERT_EQ(knob["presets"].size(), result.presets.size());
    for (std::size_t p = 0; p < result.presets.size(); ++p) {
      expect_level(knob["presets"][p], result.presets[p]);
    }
  }
}

TEST(AccuracyJson, HasTheAdviceAndTheWordsOfItsCommand) {
  const Json advice = Json::parse(json_text({test::sample_mesh()}))["advice"];
  EXPECT_EQ(advice["subject"], "For this device");
  ASSERT_EQ(advice["answers"].size(), 6u);
  EXPECT_EQ(advice["answers"][0]["setting"], "Rate");
  EXPECT_EQ(advice["answers"][0]["value"], "1 kHz");
  EXPECT_TRUE(contains(advice["answers"][0]["reason"], "were not measured"));
  EXPECT_EQ(advice["command"][2], "'a <b>.glb'") << "a word of a shell";
}

TEST(AccuracyJson, ANumberWithoutBoundIsNull) {
  KnobResult result = test::sample_mesh();
  result.knob.enough = result.default_behind = std::numeric_limits<double>::infinity();
  const Json knob = Json::parse(json_text({result}))["knobs"][0];
  EXPECT_TRUE(knob["enough"].is_null());
  EXPECT_TRUE(knob["default_behind"].is_null());
  EXPECT_EQ(knob["default_on_front"], false);
}

TEST(AccuracyJson, HasTheFindingsOnAScene) {
  SceneFindings findings;
  findings.path = "of/a<b>\n.glb";
  findings.device = light_device();
  findings.measured.presets[0].name = "fast";
  findings.measured.presets[0].p50_ns = {1.0, 2.0, 3.0};
  findings.measured.kept_rate.trials = {{1000.0, 2, 2, 2000, 1, 12'700},
                                        {2000.0, 3, 1, 4000, 9, 1}};
  findings.measured.kept_rate.realtime_note = "<i>";
  const SurfaceCoupling hard{"<script>\"x\"", {1001.0, 0.0}};
  findings.verdicts = test::made(judge_couplings({hard}, light_device(), {1e-3, 0.0}, 0.0));
  findings.by_rate = {{1000.0, findings.verdicts[0].limits}};
  const Json scene = Json::parse(json_text({}, &findings))["scene"];
  EXPECT_EQ(scene["name"], "a<b> .glb");
  expect_spread(scene["presets"][0]["p50_ns"], {1.0, 2.0, 3.0});
  EXPECT_EQ(scene["kept_rate"]["trials"][0]["passed"], true);
  EXPECT_EQ(scene["kept_rate"]["trials"][1]["passed"], false);
  EXPECT_EQ(scene["kept_rate"]["realtime_note"], "<i>");
  const Json& surface = scene["surfaces"][0];
  EXPECT_EQ(surface["name"], "<script>\"x\"");
  EXPECT_EQ(surface["is_passive"], false);
  EXPECT_EQ(surface["effective"], "1001 N/m") << "as many digits as tell it from its limit";
  EXPECT_EQ(surface["passive_up_to"], "1000 N/m");
  EXPECT_EQ(surface["is_refused"], false);
  EXPECT_EQ(scene["limits"][0]["passive_N_per_m"].get<double>(), 1000.0);
}

TEST(AccuracyJson, SaysWhetherTheDelayIsStated) {
  const auto stiffness = [](DelayInterval delay) {
    return Json::parse(json_text({}, nullptr, delay))["stiffness"];
  };
  EXPECT_EQ(stiffness({})["assumes_delay"], true);
  EXPECT_EQ(stiffness({0.0, 1e-3})["assumes_delay"], false);
  EXPECT_TRUE(contains(stiffness({})["verdict"], "K 1 kN/m is calm only by the controller"));
}

TEST(AccuracyJson, HasNoControlCharacterAndNoBrokenCharacter) {
  const std::string text = json_text({test::sample_hostile("true")});
  EXPECT_FALSE(contains(text, "\xff"));
  EXPECT_FALSE(contains(text, "\\n"));
  EXPECT_TRUE(contains(text, "<script>alert(1)</script> & \\\"quotes\\\", 'single' commas"));
}

}  // namespace
}  // namespace palpate
