// The table, the diagrams and the page of the accuracy report, for made-up knobs.

#include "engine/accuracy/accuracy_report.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/accuracy_csv.h"
#include "engine/report/gnuplot.h"
#include "engine/report/html.h"
#include "engine/report/human_units.h"
#include "engine/report/label_places.h"
#include "engine/report/plot_axis.h"
#include "engine/report/text_file.h"
#include "geometry/base/printable.h"
#include "tests/engine/accuracy/sample_knobs.h"
#include "tests/helpers/needs.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::Random;

class Folder {
 public:
  Folder()
      : path_(testing::TempDir() + "palpate report's \"folder\" " + std::to_string(::getpid())) {
    fs::remove_all(path_);
    fs::create_directory(path_);
  }
  ~Folder() { fs::remove_all(path_); }

  std::string file(const std::string& name) const { return path_ / name; }
  auto count() const { return std::distance(fs::directory_iterator(path_), {}); }

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

// The tags of an XML document, checked to be well-formed: elements nest, attributes are quoted and
// unique, and texts contain known entities only.
class Xml {
 public:
  explicit Xml(std::string_view text) : rest_(text) {
    while (!rest_.empty() && problem_.empty()) step();
    if (problem_.empty() && !open_.empty()) problem_ = "not closed: " + open_.back();
  }

  const std::string& problem() const { return problem_; }
  const std::vector<std::string>& ids() const { return ids_; }
  const std::vector<std::string>& references() const { return references_; }
  const std::string& text() const { return text_; }
  int count(const std::string& name) const {
    const auto found = counts_.find(name);
    return found == counts_.end() ? 0 : found->second;
  }

 private:
  void step() {
    if (rest_.starts_with("<?") || rest_.starts_with("<!")) {
      rest_.remove_prefix(std::min(rest_.find('>'), rest_.size() - 1) + 1);
    } else if (rest_.front() == '<') {
      tag();
    } else {
      const std::size_t end = std::min(rest_.find('<'), rest_.size());
      check_entities(rest_.substr(0, end));
      text_ += rest_.substr(0, end);
      rest_.remove_prefix(end);
    }
  }

  void check_entities(std::string_view text) {
    static const std::regex kBad("&(?!(amp|lt|gt|quot|apos|#[0-9]+);)");
    if (std::regex_search(text.begin(), text.end(), kBad)) {
      problem_ = "an entity in: " + std::string(text.substr(0, 80));
    }
  }

  void tag() {
    static const std::regex kTag(
        "^<(/?)([A-Za-z][\\w:.-]*)((?:\\s+[A-Za-z_:][\\w:.-]*\\s*=\\s*(?:\"[^\"<]*\"|'[^'<]*'))*)"
        "\\s*(/?)>");
    std::cmatch match;
    const std::size_t length = std::min<std::size_t>(rest_.find('>') + 1, rest_.size());
    if (!std::regex_search(rest_.data(), rest_.data() + length, match, kTag)) {
      problem_ = "no tag: " + std::string(rest_.substr(0, 80));
      return;
    }
    const std::string name = match[2];
    if (match[1].length() > 0) {
      if (open_.empty() || open_.back() != name) problem_ = "closes nothing: " + name;
      if (!open_.empty()) open_.pop_back();
    } else {
      ++counts_[name];
      attributes(match[3]);
      if (match[4].length() == 0) open_.push_back(name);
    }
    rest_.remove_prefix(static_cast<std::size_t>(match.length()));
  }

  void attributes(const std::string& text) {
    static const std::regex kAttribute("([\\w:.-]+)\\s*=\\s*(?:\"([^\"]*)\"|'([^']*)')");
    std::set<std::string> names;
    for (std::sregex_iterator i(text.begin(), text.end(), kAttribute), end; i != end; ++i) {
      const std::string name = (*i)[1], value = (*i)[2].matched ? (*i)[2] : (*i)[3];
      if (!names.insert(name).second) problem_ = "twice: " + name;
      check_entities(value);
      if (name == "id") ids_.push_back(value);
      if (name == "href" || name == "xlink:href") references_.push_back(value);
      static const std::regex kUrl("url\\((#[^)]*)\\)");
      std::smatch url;
      if (std::regex_search(value, url, kUrl)) references_.push_back(url[1]);
    }
  }

  std::string_view rest_;
  std::string problem_, text_;
  std::vector<std::string> open_, ids_, references_;
  std::map<std::string, int> counts_;
};

std::string unescaped(std::string text) {
  for (const auto& [entity, character] : std::vector<std::pair<std::string, std::string>>{
           {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}}) {
    for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at) {
      text.replace(at, entity.size(), character);
    }
  }
  return text;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// All numbers in it are numbers.
void expect_finite(const std::string& svg) {
  static const std::regex kBad("[^A-Za-z](nan|inf)[^A-Za-z]", std::regex::icase);
  std::smatch match;
  EXPECT_FALSE(std::regex_search(svg, match, kBad)) << match.str();
}

AccuracyReport report_of(const std::vector<KnobResult>& results) {
  AccuracyReport report;
  report.title = "What accuracy <costs>";
  report.facts = {{"machine", "a & b"}, {"commit", "\"unknown\""}};
  report.chapters = chapters_of(results);
  return report;
}

// The svg elements of a page, each as a document.
std::vector<std::string> figures_of(const std::string& html) {
  std::vector<std::string> figures;
  for (std::size_t at = html.find("<svg"); at != std::string::npos; at = html.find("<svg", at)) {
    const std::size_t end = html.find("</svg>", at) + 6;
    figures.push_back(html.substr(at, end - at));
    at = end;
  }
  return figures;
}

class AllSamples : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    results_ = new std::vector<KnobResult>(test::all_samples());
    html_ = new std::string(report_html(report_of(*results_)));
  }
  static void TearDownTestSuite() {
    delete results_;
    delete html_;
  }
  static const std::vector<KnobResult>& results() { return *results_; }
  static const std::string& html() { return *html_; }

 private:
  static inline std::vector<KnobResult>* results_ = nullptr;
  static inline std::string* html_ = nullptr;
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
  ASSERT_TRUE(write_accuracy_csv(results, path).ok());
  EXPECT_EQ(content_of(path), accuracy_csv(results));

  const auto nowhere = write_accuracy_csv(results, folder.file("no/such/report.csv"));
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

// gnuplot

TEST(Gnuplot, DrawsAnyText) {
  const Folder folder;
  for (const std::string& text :
       {"`touch '" + folder.file("oops") + "'` $(touch x)", std::string(R"('a''b''')"),
        std::string(R"(""c\)"), std::string(R"(\n\047 @a a_b^{c} 9)"), std::string("<b>&amp;</b>"),
        std::string("50 % %g %%"), std::string("µ 10⁻⁶")}) {
    SCOPED_TRACE(text);
    const std::string quoted = gnuplot_quoted(text);
    const auto svg =
        gnuplot_svg("a = 'macro'\nset title " + quoted + "\nset xtics (" + gnuplot_tick(text) +
                        " 0)\nset label " + quoted + " at 0,0\nplot [-1:1] x title " + quoted,
                    400, 300, 14);
    ASSERT_TRUE(svg.ok()) << svg.error().to_string();
    const Xml xml(*svg);
    EXPECT_EQ(xml.problem(), "");
    const std::string drawn = unescaped(xml.text());
    int found = 0;
    for (std::size_t at = 0; (at = drawn.find(text, at)) != std::string::npos; ++at) ++found;
    EXPECT_EQ(found, 4);  // title, tick, label, legend
  }
  EXPECT_EQ(folder.count(), 0);
}

TEST(Gnuplot, InvalidUtf8BecomesValidXml) {
  for (const char* bad : {"\xff", "\xc0\xaf", "\xe0\x80\x80", "a\xe2\x82", "\xed\xa0\x80",
                          "\xf5\x80\x80\x80", "\x01\x7f", "\xef\xbf\xbf", "a\nb\tc"}) {
    const std::string fit = printable(bad);
    EXPECT_EQ(printable(fit), fit);
    EXPECT_TRUE(std::none_of(fit.begin(), fit.end(), [](unsigned char c) {
      return c < 32 || c >= 127;
    })) << fit;
  }
  EXPECT_EQ(printable("µm, 10⁻⁶, €, 😀"), "µm, 10⁻⁶, €, 😀");
}

TEST(Gnuplot, ReportsAnErrorInAScript) {
  const auto svg = gnuplot_svg("plot no_such_function(x)\n", 400, 300, 14);
  ASSERT_FALSE(svg.ok());
  EXPECT_TRUE(contains(svg.error().problem, "no_such_function")) << svg.error().problem;
}

TEST(Gnuplot, ReportsThatItIsMissing) {
  const Folder folder;
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.file("").c_str(), 1);
  const auto svg = gnuplot_svg("plot x\n", 400, 300, 14);
  const auto panels = work_precision_panels(test::sample_mesh());
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(svg.ok());
  EXPECT_TRUE(contains(svg.error().hint, "install gnuplot-nox"));
  // The rest of the report is complete.
  ASSERT_FALSE(panels.ok());
  AccuracyReport report;
  report.chapters.push_back({test::sample_mesh(), panels});
  const std::string html = report_html(report);
  EXPECT_TRUE(contains(html, "No diagram"));
  EXPECT_TRUE(contains(html, "install gnuplot-nox"));
  EXPECT_TRUE(contains(html, "797")) << "levels";
}

// Diagrams

TEST_F(AllSamples, ADiagramIsWellFormedAndHasBothPanels) {
  for (const KnobResult& result : results()) {
    SCOPED_TRACE(result.knob.name);
    const auto svg = work_precision_svg(result);
    ASSERT_TRUE(svg.ok()) << svg.error().to_string();
    const Xml xml(*svg);
    EXPECT_EQ(xml.problem(), "");
    EXPECT_TRUE(contains(xml.text(), "error against time"));
    EXPECT_TRUE(contains(xml.text(), "error against level") ||
                contains(xml.text(), "time against level"));
    expect_finite(*svg);
  }
}

TEST(WorkPrecision, AxesHaveNamesAndUnits) {
  const auto mesh = work_precision_panels(test::sample_mesh());
  ASSERT_TRUE(mesh.ok());
  EXPECT_TRUE(contains(mesh->error_against_time, ">depth error (µm)<"));
  EXPECT_TRUE(contains(mesh->error_against_time, ">time of a tick (µs)<"));
  EXPECT_TRUE(contains(mesh->error_against_level, ">edge length (mm)<"));
  EXPECT_TRUE(contains(mesh->error_against_level, ">depth error (µm)<"));
  const auto integrator = work_precision_panels(test::sample_integrator());
  ASSERT_TRUE(integrator.ok());
  EXPECT_TRUE(contains(integrator->error_against_time, ">computing for a second of contact (ms)<"));
}

TEST(WorkPrecision, FloorOrderPresetsAndFailuresAreNamed) {
  const auto panels = work_precision_panels(test::sample_integrator());
  ASSERT_TRUE(panels.ok());
  EXPECT_TRUE(contains(panels->error_against_time, ">floor<"));
  EXPECT_TRUE(contains(panels->error_against_time, "explicit Euler (2 failed)"));
  EXPECT_TRUE(contains(panels->error_against_time, "Runge-Kutta 4 (1 failed)"));
  EXPECT_TRUE(contains(panels->error_against_time, ">preset exact<"));
  EXPECT_FALSE(contains(panels->error_against_time, ">preset fast<")) << "it failed";
  EXPECT_TRUE(contains(panels->error_against_time, ">recommended<"));
  EXPECT_TRUE(contains(panels->error_against_level, "Runge-Kutta 4: order 4.00 (theory 4)"));
  EXPECT_TRUE(contains(panels->error_against_level, ">floor<"));
}

TEST(WorkPrecision, TheSlopeOfEachExpectedOrderIsDrawn) {
  const auto dashed_lines = [](const KnobResult& result) {
    const std::string svg = work_precision_panels(result)->error_against_level;
    static const std::regex kDashed("stroke-dasharray");
    return std::distance(std::sregex_iterator(svg.begin(), svg.end(), kDashed), {});
  };
  KnobResult result = test::sample_integrator();
  const auto with_orders = dashed_lines(result);
  for (MethodResult& method : result.methods) method.expected_order.reset();
  EXPECT_EQ(with_orders - dashed_lines(result), 3) << "two methods and the legend";
}

TEST(WorkPrecision, AKnobWithoutASuccessfulLevelIsDrawn) {
  KnobResult result = test::sample_integrator();
  for (MethodResult& method : result.methods) {
    for (LevelResult& level : method.levels)
      level = {level.value, level.label, {}, {}, 0, 0, 0, 21, 21, "no", false, false};
  }
  for (LevelResult& preset : result.presets) preset.failures = 21;
  result.recommended.reset();
  const auto svg = work_precision_svg(result);
  ASSERT_TRUE(svg.ok()) << svg.error().to_string();
  expect_finite(*svg);
}

TEST(WorkPrecision, ExtremeNumbersAreDrawn) {
  Random random(20261);
  for (int i = 0; i < 10; ++i) {
    KnobResult result = test::sample_mesh();
    for (MethodResult& method : result.methods) {
      for (LevelResult& level : method.levels) {
        const auto any = [&] { return std::pow(10.0, random.uniform(-300.0, 300.0)); };
        level.value = random.index(4) == 0 ? 0.0 : any();
        level.error = Spread::of({any(), random.index(4) == 0 ? 0.0 : any(), any()});
        level.time = Spread::of({any(), any(), -any()});
        level.label = std::string(random.index(60), 'x');
      }
    }
    const auto svg = work_precision_svg(result);
    ASSERT_TRUE(svg.ok()) << svg.error().to_string();
    expect_finite(*svg);
  }
}

TEST(PlotAxis, ShowsZeroBelowAllPositiveValues) {
  PlotAxis axis;
  for (const double value : {1e-6, 0.0, 1e-3}) axis.see(value);
  axis.settle("m");
  EXPECT_LT(axis.begin(), axis.at(0.0));
  ASSERT_TRUE(axis.zero_band().has_value());
  EXPECT_LT(axis.at(0.0), *axis.zero_band());
  EXPECT_LT(*axis.zero_band(), axis.at(1e-6));
  EXPECT_DOUBLE_EQ(axis.at(1e-3), -3.0);
  EXPECT_TRUE(std::any_of(axis.ticks().begin(), axis.ticks().end(), [&](const PlotAxis::Tick& t) {
    return t.label == "0" && t.position == axis.at(0.0);
  }));
}

TEST(PlotAxis, TicksAreWhereTheirLabelsSay) {
  const std::map<std::string, double> metres = {
      {"m", 1.0}, {"mm", 1e-3}, {"µm", 1e-6}, {"nm", 1e-9}};
  Random random(20262);
  int checked = 0;
  for (int i = 0; i < 2000; ++i) {
    const double low = std::pow(10.0, random.uniform(-12.0, 3.0));
    const double high = low * std::pow(10.0, random.uniform(0.0, 3.0));
    PlotAxis axis;
    axis.see(low);
    axis.see(high);
    axis.settle("m");
    int labelled = 0;
    for (const PlotAxis::Tick& tick : axis.ticks()) {
      EXPECT_GE(tick.position, axis.begin());
      EXPECT_LE(tick.position, axis.end());
      if (tick.label.empty()) continue;
      ++labelled;
      char* end = nullptr;
      const double said = std::strtod(tick.label.c_str(), &end);
      if (*end != '\0') continue;  // a power of ten with a superscript
      ++checked;
      constexpr double kThreeDigits = 0.0022;  // log10 of 1.005
      EXPECT_NEAR(std::log10(said * metres.at(axis.unit())), tick.position, kThreeDigits)
          << low << " to " << high;
    }
    EXPECT_GE(labelled, 2) << low << " to " << high;
    EXPECT_LE(labelled, 12) << low << " to " << high;
  }
  EXPECT_GT(checked, 5000);
}

TEST(LabelPlaces, NoLabelCoversAnotherOrLeavesTheArea) {
  Random random(20263);
  const PixelBox area{0.0, 0.0, 300.0, 200.0};
  for (int i = 0; i < 200; ++i) {
    LabelPlaces places(area);
    const PixelBox point = PixelBox::about(150.0, 100.0, 6.0, 6.0);
    places.block(point);
    std::vector<PixelBox> taken = {point};
    for (int label = 0; label < 30; ++label) {
      const auto box = places.take_beside(random.uniform(0.0, 300.0), random.uniform(0.0, 200.0),
                                          random.uniform(10.0, 90.0), 14.0, 9.0, true);
      if (!box) continue;
      EXPECT_TRUE(box->is_within(area));
      for (const PixelBox& other : taken) EXPECT_FALSE(box->overlaps(other));
      taken.push_back(*box);
    }
    EXPECT_GT(taken.size(), 3u);
  }
}

// Units

TEST(HumanUnits, AreReadable) {
  EXPECT_EQ(human(134.0, "ns"), "134 ns");
  EXPECT_EQ(human(1340.0, "ns"), "1.34 µs");
  EXPECT_EQ(human(1.3e-6, "m"), "1.3 µm");
  EXPECT_EQ(human(0.025, "m"), "25 mm");
  EXPECT_EQ(human(3.2e-9, "m"), "3.2 nm");
  EXPECT_EQ(human(1e-15, "m"), "1e-15 m");
  EXPECT_EQ(human(1500.0, "m"), "1500 m");
  EXPECT_EQ(human(0.9999e-6, "s"), "1 µs");
  EXPECT_EQ(human(2500.0, "us"), "2.5 ms");
  EXPECT_EQ(human(0.012, "N"), "12 mN");
  EXPECT_EQ(human(2000.0, "Hz"), "2 kHz");
  EXPECT_EQ(human(0.3, "m/s"), "300 mm/s");
  EXPECT_EQ(human(12.345, "deg"), "12.3 deg");
  EXPECT_EQ(human(0.5, ""), "0.5");
  EXPECT_EQ(human(0.0, "m"), "0");
  EXPECT_EQ(short_number(123456.0), "123456");
  EXPECT_EQ(short_number(1.2e7), "1.2e7");
  EXPECT_EQ(short_number(-0.000012), "-1.2e-5");
}

// Page

TEST_F(AllSamples, EveryIdOnThePageIsUniqueAndEveryReferenceResolves) {
  static const std::regex kId("\\sid=[\"']([^\"']*)[\"']");
  std::set<std::string> ids;
  for (std::sregex_iterator i(html().begin(), html().end(), kId), end; i != end; ++i) {
    EXPECT_TRUE(ids.insert((*i)[1]).second) << (*i)[1];
  }
  EXPECT_GT(ids.size(), 20 * results().size());
  for (const std::string& figure : figures_of(html())) {
    const Xml xml(figure);
    EXPECT_EQ(xml.problem(), "");
    EXPECT_FALSE(xml.references().empty());
    for (const std::string& reference : xml.references()) {
      ASSERT_EQ(reference.front(), '#');
      EXPECT_TRUE(std::count(xml.ids().begin(), xml.ids().end(), reference.substr(1)) == 1)
          << reference;
    }
  }
}

TEST_F(AllSamples, ThePageShowsAPairOfDiagramsForEachKnob) {
  const std::vector<std::string> figures = figures_of(html());
  ASSERT_EQ(figures.size(), 2 * results().size());
  for (const std::string& figure : figures) {
    EXPECT_TRUE(contains(figure, "role=\"img\" aria-label=\""));
    EXPECT_EQ(Xml(figure).count("title"), 1);
    expect_finite(figure);
  }
}

TEST_F(AllSamples, ThePageListsEveryLevelThatFailed) {
  int failed = 0;
  for (const KnobResult& result : results()) {
    for (const MethodResult& method : result.methods) {
      for (const LevelResult& level : method.levels) {
        if (level.counts()) continue;
        ++failed;
        const std::string item = html_escaped(method.name + ", " + level.label) + ": " +
                                 std::to_string(level.failures) + " of 21 repeats, " +
                                 html_escaped(level.failure);
        EXPECT_TRUE(contains(html(), item)) << item;
      }
    }
  }
  EXPECT_EQ(failed, 5);
  EXPECT_TRUE(contains(html(), "preset fast: 21 of 21 repeats, leaked: passed a surface"));
}

TEST_F(AllSamples, ThePageLoadsNoOtherFile) {
  std::string text = html();
  for (const char* name : {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}) {
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) {
      text.erase(at, std::string(name).size());
    }
  }
  for (const char* word : {"http:", "https:", "//www", "<script", "<iframe", "<img", "@import",
                           "src=", "javascript:", "<?xml"}) {
    EXPECT_FALSE(contains(text, word)) << word;
  }
  EXPECT_TRUE(contains(text, "<meta charset=\"utf-8\">"));
  EXPECT_TRUE(contains(text, "name=\"viewport\""));
}

TEST_F(AllSamples, NamesOnThePageAreEscaped) {
  EXPECT_FALSE(contains(html(), "<script"));
  EXPECT_FALSE(contains(html(), "\xff"));
  EXPECT_TRUE(contains(html(), "&lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;quotes&quot;"));
  EXPECT_TRUE(contains(html(), "What accuracy &lt;costs&gt;"));
  EXPECT_TRUE(contains(html(), "<dd>a &amp; b</dd>"));
}

TEST_F(AllSamples, ThePageStatesWhyADefaultIsNotOnTheFront) {
  const KnobResult& mesh = results()[0];
  ASSERT_FALSE(mesh.default_is_on_front());
  EXPECT_TRUE(contains(html(), "not on the front: " + html_escaped(mesh.better_than_default)));
  EXPECT_TRUE(contains(html(), "Why it is the default: " + mesh.knob.default_because));
  EXPECT_TRUE(contains(html(), "It is the quickest with an error of at most 1 µm"));
}

TEST(AccuracyReport, FloorAndOrdersAreInTheTable) {
  const std::string html = report_html(report_of({test::sample_integrator()}));
  EXPECT_TRUE(contains(html, "explicit Euler, order 1.00 (theory 1), floor 1e-15 m"));
  EXPECT_TRUE(contains(html, "<span class=\"mark floor\">floor</span>"));
  EXPECT_TRUE(contains(html, "<strong>Floor:</strong> Round-off"));
  EXPECT_TRUE(contains(html, "Open points are at the floor."));
}

TEST(AccuracyReport, ASectionOfTheCallerIsInsertedUnchanged) {
  AccuracyReport report;
  report.title = "t";
  report.sections.push_back({"Your <scene>", "<p id=\"mine\">x</p>"});
  const std::string html = report_html(report);
  EXPECT_TRUE(contains(html, "<h2>Your &lt;scene&gt;</h2>"));
  EXPECT_TRUE(contains(html, "<p id=\"mine\">x</p>"));
}

}  // namespace
}  // namespace palpate
