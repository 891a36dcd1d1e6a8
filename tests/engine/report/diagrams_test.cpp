// Scripts for gnuplot, axes and labels of diagrams.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "engine/report/gnuplot.h"
#include "engine/report/label_places.h"
#include "engine/report/plot_axis.h"
#include "geometry/base/printable.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::Random;

class ScriptFolder {
 public:
  ScriptFolder()
      : path_(testing::TempDir() + "palpate report's \"folder\" " + std::to_string(::getpid())) {
    fs::remove_all(path_);
    fs::create_directory(path_);
  }
  ~ScriptFolder() { fs::remove_all(path_); }

  std::string file(const std::string& name) const { return path_ / name; }
  auto count() const { return std::distance(fs::directory_iterator(path_), {}); }

 private:
  fs::path path_;
};

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

bool has_part(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// gnuplot

TEST(Gnuplot, DrawsAnyText) {
  const ScriptFolder folder;
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
  EXPECT_TRUE(has_part(svg.error().problem, "no_such_function")) << svg.error().problem;
}

TEST(Gnuplot, ReportsThatItIsMissing) {
  const ScriptFolder folder;
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.file("").c_str(), 1);
  const auto svg = gnuplot_svg("plot x\n", 400, 300, 14);
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(svg.ok());
  EXPECT_TRUE(has_part(svg.error().hint, "install gnuplot-nox"));
}

// Axes and labels

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

}  // namespace
}  // namespace palpate
