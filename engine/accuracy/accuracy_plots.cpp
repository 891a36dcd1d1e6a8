#include "engine/accuracy/accuracy_plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "engine/report/diagram_panel.h"
#include "engine/report/gnuplot.h"
#include "engine/report/human_units.h"
#include "engine/report/label_places.h"
#include "engine/report/plot_axis.h"

namespace palpate {
namespace {

// Pixels.
constexpr double kTitleHeight = 30.0;  // of the document with both panels
constexpr int kSmallFontPx = 12;
constexpr double kPointRadius = 6.0;
constexpr double kRingRadius = 9.0;
constexpr double kPresetRadius = 12.0;
constexpr double kRecommendedRadius = 13.0;
constexpr double kLabelGap = 3.0;
constexpr double kSlopeBelow = 0.06;  // of the axis

// Longer texts are cut; the report has them in full.
constexpr std::size_t kLongestLegend = 56;
constexpr std::size_t kLongestLabel = 24;
constexpr std::size_t kMostNamedLevels = 3;

// Black, open and larger than points: triangle down, square, diamond.
constexpr std::array kPresetPoints = {10, 4, 12};

enum class Against { kTime, kLevel };

std::string failures_text(const MethodResult& method) {
  const auto failed = std::count_if(method.levels.begin(), method.levels.end(),
                                    [](const LevelResult& l) { return !l.counts(); });
  if (failed == 0) return "";
  return " (" + std::to_string(failed) + " failed)";
}

std::string order_text(const MethodResult& method) {
  if (!method.order && !method.expected_order) return "";
  std::string text = method.order ? ": order " + order_number(*method.order) : ": no order fitted";
  if (method.expected_order) text += " (theory " + short_number(*method.expected_order) + ")";
  return text;
}

constexpr const char* kFrontLine = "lw 6 lc rgb '#D0D0D0'";
constexpr const char* kFrontRing = "pt 6 ps 1.5 lc rgb '#707070'";
constexpr const char* kRecommendedRing = "pt 6 ps 2.2 lc rgb '#000000'";
constexpr const char* kExpectedSlope = "lines dt (6,4) lw 1.5 lc rgb '#404040'";

std::string preset_style(std::size_t preset) {
  return "points pt " + std::to_string(kPresetPoints[preset]) + " ps 1.7 lc rgb '#000000'";
}

std::vector<LegendEntry> legend_of(const KnobResult& result, Against against) {
  std::vector<LegendEntry> entries;
  bool has_expected = false;
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    const MethodResult& method = result.methods[m];
    const std::string suffix =
        against == Against::kTime ? failures_text(method) : order_text(method);
    entries.push_back({shortened_label(method.name, kLongestLegend - std::min(suffix.size(),
                                                                              kLongestLegend / 2)) +
                           suffix,
                       curve_style(m)});
    has_expected = has_expected || method.expected_order.has_value();
  }
  if (against == Against::kLevel) {
    if (has_expected) entries.push_back({"slope of the order in theory", kExpectedSlope});
    return entries;
  }
  const bool given = result.knob.levels_are_given;
  if (!given && !result.knob.methods_are_given)
    entries.push_back({"Pareto front", std::string("lines ") + kFrontLine});
  if (result.has_choice()) {
    entries.push_back(
        {given ? "best at its level" : "on the front", std::string("points ") + kFrontRing});
    if (result.recommended)
      entries.push_back({"recommended", std::string("points ") + kRecommendedRing});
  }
  for (std::size_t p = 0; p < result.presets.size(); ++p) {
    if (!result.presets[p].counts()) continue;
    entries.push_back({std::string("preset ") + kPresetNames[p], preset_style(p)});
  }
  return entries;
}

// A level in a diagram. Positions on the axes.
struct Dot {
  double x, x_low, x_high;
  double y, y_low, y_high;
  bool is_open;
};

// The data and the axes of both panels.
class Diagram {
 public:
  explicit Diagram(const KnobResult& result) : result_(result) {
    settle_axes();
    rows_ = std::max(legend_rows(legend_of(result, Against::kTime)),
                     legend_rows(legend_of(result, Against::kLevel)));
  }

  const KnobResult& result() const { return result_; }
  const PlotAxis& x(Against against) const { return against == Against::kTime ? time_ : level_; }
  const PlotAxis& y(Against against) const { return shows_time(against) ? time_ : error_; }
  // If all errors are at the floor, they do not distinguish levels, and the second panel shows
  // times.
  bool shows_time(Against against) const { return against == Against::kLevel && !has_errors_; }
  double height() const { return panel_height(rows_); }

  Dot dot(const LevelResult& level, Against against) const {
    const Spread at_level{level.value, level.value, level.value};
    const Spread& across = against == Against::kTime ? level.time : at_level;
    const Spread& up = shows_time(against) ? level.time : level.error;
    const PlotAxis& x_axis = x(against);
    const PlotAxis& y_axis = y(against);
    return {x_axis.at(across.median),
            x_axis.at(across.low),
            x_axis.at(across.high),
            y_axis.at(up.median),
            y_axis.at(up.low),
            y_axis.at(up.high),
            level.at_floor};
  }

  template <typename Visit>
  void for_each_level(Visit visit) const {
    for (std::size_t m = 0; m < result_.methods.size(); ++m) {
      for (std::size_t l = 0; l < result_.methods[m].levels.size(); ++l) {
        const LevelResult& level = result_.methods[m].levels[l];
        if (level.counts()) visit(LevelPlace{m, l}, level);
      }
    }
  }

 private:
  void settle_axes() {
    const auto see = [this](const LevelResult& level) {
      error_.see(level.error.median);
      time_.see(level.time.median);
    };
    const auto see_whiskers = [this](const LevelResult& level) {
      error_.see_whisker(level.error.low, level.error.high);
      time_.see_whisker(level.time.low, level.time.high);
    };
    for_each_level([&](const LevelPlace&, const LevelResult& level) {
      see(level);
      level_.see(level.value);
      has_errors_ = has_errors_ || (!level.at_floor && level.error.median > 0.0);
    });
    for (const LevelResult& preset : result_.presets) {
      if (preset.counts()) see(preset);
    }
    for_each_level([&](const LevelPlace&, const LevelResult& level) { see_whiskers(level); });
    error_.settle(result_.knob.error.unit);
    time_.settle(result_.knob.time.unit);
    level_.settle(result_.knob.level.unit);
    name_levels();
  }

  // Two or three levels are named, because they are rather kinds than numbers.
  void name_levels() {
    std::vector<PlotAxis::Tick> ticks;
    for_each_level([&](const LevelPlace&, const LevelResult& level) {
      ticks.push_back({level_.at(level.value), level.label});
    });
    const auto before = [](const auto& a, const auto& b) { return a.position < b.position; };
    const auto same = [](const auto& a, const auto& b) { return a.position == b.position; };
    std::stable_sort(ticks.begin(), ticks.end(), before);
    ticks.erase(std::unique(ticks.begin(), ticks.end(), same), ticks.end());
    if (ticks.size() > kMostNamedLevels) return;
    level_.widen();
    const double px = (kPanelArea.right - kPanelArea.left) / (level_.end() - level_.begin());
    const auto half_width = [](const PlotAxis::Tick& tick) {
      constexpr double kGap = 6.0;
      return 0.5 * (text_width_px(tick.label, kPanelFontPx) + kGap);
    };
    for (std::size_t i = 1; i < ticks.size(); ++i) {
      const double space = px * (ticks[i].position - ticks[i - 1].position);
      if (space < half_width(ticks[i]) + half_width(ticks[i - 1])) return;
    }
    level_.use_names(std::move(ticks));
  }

  const KnobResult& result_;
  PlotAxis time_, error_, level_;
  bool has_errors_ = false;  // above the floor
  int rows_ = 0;
};

// Writes the script of one panel, part by part.
class Panel {
 public:
  Panel(const Diagram& diagram, Against against, const PanelPlace& place)
      : diagram_(diagram),
        against_(against),
        panel_(diagram.x(against), diagram.y(against), place,
               against == Against::kTime ? "$t" : "$l") {}

  std::string script() {
    panel_.put_frame();
    put_axes();
    panel_.put_zero_bands();
    block_data();
    put_floors();
    if (against_ == Against::kTime) {
      put_level_labels();
      put_front();
    }
    for (std::size_t m = 0; m < result().methods.size(); ++m) put_curve(m);
    put_rings();
    if (against_ == Against::kTime) {
      put_presets();
    } else {
      put_expected_slopes();
    }
    panel_.put_legend(legend_of(result(), against_));
    return panel_.script();
  }

 private:
  const KnobResult& result() const { return diagram_.result(); }
  const Knob& knob() const { return result().knob; }
  const PlotAxis& y() const { return diagram_.y(against_); }

  void put_axes() {
    const Quantity& across = against_ == Against::kTime ? knob().time : knob().level;
    const Quantity& up = diagram_.shows_time(against_) ? knob().time : knob().error;
    panel_.put_axes(against_ == Against::kTime      ? "error against time"
                    : diagram_.shows_time(against_) ? "time against level"
                                                    : "error against level",
                    across.name, up.name);
  }

  // Labels must not cover points, whiskers and curves.
  void block_data() {
    const auto block = [&](const Dot& d, double radius) {
      const double px = panel_.x_px(d.x), py = panel_.y_px(d.y);
      panel_.places().block(PixelBox::about(px, py, radius, radius));
      panel_.places().block_line(panel_.x_px(d.x_low), py, panel_.x_px(d.x_high), py);
      panel_.places().block_line(px, panel_.y_px(d.y_low), px, panel_.y_px(d.y_high));
    };
    diagram_.for_each_level([&](const LevelPlace&, const LevelResult& level) {
      block(diagram_.dot(level, against_), level.on_front ? kRingRadius : kPointRadius);
    });
    for (const MethodResult& method : result().methods) {
      for (std::size_t l = 1; l < method.levels.size(); ++l) {
        if (!method.levels[l - 1].counts() || !method.levels[l].counts()) continue;
        const Dot a = diagram_.dot(method.levels[l - 1], against_);
        const Dot b = diagram_.dot(method.levels[l], against_);
        panel_.places().block_line(panel_.x_px(a.x), panel_.y_px(a.y), panel_.x_px(b.x),
                                   panel_.y_px(b.y));
      }
    }
    if (against_ != Against::kTime) return;
    const std::vector<Dot> front = front_line();
    for (std::size_t i = 1; i < front.size(); ++i) {
      const double before_px = panel_.y_px(front[i - 1].y), corner_px = panel_.x_px(front[i].x);
      panel_.places().block_line(panel_.x_px(front[i - 1].x), before_px, corner_px, before_px);
      panel_.places().block_line(corner_px, before_px, corner_px, panel_.y_px(front[i].y));
    }
    for (const LevelResult& preset : result().presets) {
      if (preset.counts()) block(diagram_.dot(preset, against_), kPresetRadius);
    }
  }

  void put_floors() {
    if (diagram_.shows_time(against_)) return;
    std::vector<double> floors;
    for (const MethodResult& method : result().methods) {
      if (method.floor > 0.0) floors.push_back(method.floor);
    }
    std::sort(floors.begin(), floors.end());
    floors.erase(std::unique(floors.begin(), floors.end()), floors.end());
    for (const double floor : floors) {
      const double position = std::log10(floor);
      if (position < y().begin() || position > y().end()) continue;
      panel_.put_line_across(position);
      put_floor_label(panel_.y_px(position));
    }
  }

  void put_floor_label(double line_px) {
    constexpr double kHalfWidth = 17.0, kHalfHeight = 7.0, kGap = 3.0;
    for (const double above : {-1.0, 1.0}) {
      for (double px = kPanelArea.right - kHalfWidth - kGap; px > kPanelArea.left + kHalfWidth;
           px -= 12.0) {
        const PixelBox box =
            PixelBox::about(px, line_px + above * (kHalfHeight + kGap), kHalfWidth, kHalfHeight);
        if (!panel_.places().take(box)) continue;
        panel_.put_label("floor", box, "#505050");
        panel_.places().block_line(kPanelArea.left, line_px, kPanelArea.right, line_px);
        return;
      }
    }
  }

  // The recommended level and the default are labelled first.
  int urgency(const LevelPlace& place, const LevelResult& level) const {
    const auto& best = result().recommended;
    if (best && best->method == place.method && best->level == place.level) return 0;
    if (is_default(place)) return 1;
    return level.on_front ? 2 : 3;
  }
  bool is_default(const LevelPlace& place) const {
    return place.method == knob().default_method && place.level == knob().default_level;
  }

  // Where neither level nor method is a choice, labels name the methods, once each.
  bool labels_methods() const { return !result().has_choice(); }

  void put_level_labels() {
    struct Wish {
      int urgency;
      Dot dot;
      std::string text;
      bool is_on_front;
    };
    std::vector<Wish> wishes;
    diagram_.for_each_level([&](const LevelPlace& place, const LevelResult& level) {
      if (labels_methods() && place.level != knob().default_level) return;
      const std::string text =
          labels_methods() ? shortened_label(result().methods[place.method].name, kLongestLabel)
                           : shortened_label(level.label, kLongestLabel) +
                                 (is_default(place) ? " (default)" : "");
      wishes.push_back(
          {urgency(place, level), diagram_.dot(level, against_), text, level.on_front});
    });
    std::stable_sort(wishes.begin(), wishes.end(),
                     [](const Wish& a, const Wish& b) { return a.urgency < b.urgency; });
    // Where levels are given, points are dense, and a distant label would be ambiguous.
    const int farthest = labels_methods() ? 3 : knob().levels_are_given ? 1 : 2;
    for (const Wish& wish : wishes) {
      const double radius = wish.urgency == 0  ? kRecommendedRadius
                            : wish.is_on_front ? kRingRadius
                                               : kPointRadius;
      const auto box = panel_.places().take_beside(
          panel_.x_px(wish.dot.x), panel_.y_px(wish.dot.y), text_width_px(wish.text, kSmallFontPx),
          kSmallFontPx + 2.0, radius + kLabelGap, wish.urgency <= farthest);
      if (box) panel_.put_label(wish.text, *box, "#303030");
    }
  }

  void put_curve(std::size_t m) {
    std::string line, whiskers, filled, open;
    for (const LevelResult& level : result().methods[m].levels) {
      if (!level.counts()) {
        line += "\n";  // interrupts it
        continue;
      }
      const Dot d = diagram_.dot(level, against_);
      line += data_row({d.x, d.y});
      whiskers += data_row({d.x, d.y, d.x_low, d.x_high, d.y_low, d.y_high});
      (d.is_open ? open : filled) += data_row({d.x, d.y});
    }
    const std::string colour = std::string(" lc rgb '") + curve_colour(m) + "'";
    const std::string width = knob().levels_are_given ? " lw 1" : " lw 2";
    if (filled.empty() && open.empty()) return;
    panel_.put_block(line, "with lines" + width + colour);
    panel_.put_block(whiskers, "with xyerrorbars pt 0 ps 0 lw 1" + colour);
    panel_.put_block(filled, "with points ps 0.9 pt " + std::to_string(curve_point(m)) + colour);
    // White points beneath hide the line.
    panel_.put_block(
        open, "with points ps 0.9 pt " + std::to_string(curve_point(m)) + " lc rgb '#FFFFFF'");
    panel_.put_block(open, "with points ps 0.9 pt " + std::to_string(curve_point(m) - 1) + colour);
  }

  // The corners of the Pareto front, from the quickest to the most accurate; empty if each level or
  // each curve has a front of its own.
  std::vector<Dot> front_line() const {
    std::vector<Dot> front;
    if (knob().levels_are_given || knob().methods_are_given) return front;
    diagram_.for_each_level([&](const LevelPlace&, const LevelResult& level) {
      if (level.on_front) front.push_back(diagram_.dot(level, against_));
    });
    std::sort(front.begin(), front.end(),
              [](const Dot& a, const Dot& b) { return a.x != b.x ? a.x < b.x : a.y > b.y; });
    // Levels tied with the front may lie behind it.
    double least = std::numeric_limits<double>::infinity();
    std::erase_if(front, [&](const Dot& d) {
      if (d.y > least) return true;
      least = d.y;
      return false;
    });
    return front;
  }

  void put_front() {
    std::string steps, rings;
    for (const Dot& d : front_line()) steps += data_row({d.x, d.y});
    diagram_.for_each_level([&](const LevelPlace&, const LevelResult& level) {
      const Dot d = diagram_.dot(level, against_);
      if (level.on_front && result().has_choice()) rings += data_row({d.x, d.y});
    });
    panel_.put_block(steps, std::string("with steps ") + kFrontLine);
    panel_.put_block(rings, std::string("with points ") + kFrontRing);
  }

  void put_rings() {
    if (!result().recommended || !result().has_choice()) return;
    const LevelPlace& place = *result().recommended;
    const Dot d = diagram_.dot(result().methods[place.method].levels[place.level], against_);
    panel_.put_block(data_row({d.x, d.y}), std::string("with points ") + kRecommendedRing);
  }

  void put_presets() {
    for (std::size_t p = 0; p < result().presets.size(); ++p) {
      if (!result().presets[p].counts()) continue;
      const Dot d = diagram_.dot(result().presets[p], against_);
      panel_.put_block(data_row({d.x, d.y}), "with " + preset_style(p));
    }
  }

  // Drawn slightly below the levels that the order is fitted to; only the slope has a meaning.
  void put_expected_slopes() {
    for (const MethodResult& method : result().methods) {
      if (!method.expected_order) continue;
      std::vector<Dot> dots;
      for (const LevelResult& level : method.levels) {
        const bool is_fitted = level.counts() && !level.at_floor && level.error.median > 0.0;
        if (is_fitted && level.value > 0.0) dots.push_back(diagram_.dot(level, against_));
      }
      if (dots.size() < 2) continue;
      double x_mean = 0.0, y_mean = -kSlopeBelow * (y().end() - y().begin());
      for (const Dot& d : dots) {
        x_mean += d.x / static_cast<double>(dots.size());
        y_mean += d.y / static_cast<double>(dots.size());
      }
      std::string rows;
      for (const double end : {dots.front().x, dots.back().x}) {
        rows += data_row({end, y_mean + *method.expected_order * (end - x_mean)});
      }
      panel_.put_block(rows, std::string("with ") + kExpectedSlope);
    }
  }

  const Diagram& diagram_;
  Against against_;
  DiagramPanel panel_;
};

Result<std::string> drawn(const std::string& script, double width, double height) {
  return gnuplot_svg(script, static_cast<int>(width), static_cast<int>(height), kPanelFontPx);
}

}  // namespace

Result<WorkPrecisionPanels> work_precision_panels(const KnobResult& result) {
  const Diagram diagram(result);
  const PanelPlace alone{0.0, 0.0, kPanelWidth, diagram.height()};
  auto left = drawn(Panel(diagram, Against::kTime, alone).script(), alone.width, alone.height);
  if (!left) return left.error();
  auto right = drawn(Panel(diagram, Against::kLevel, alone).script(), alone.width, alone.height);
  if (!right) return right.error();
  return WorkPrecisionPanels{std::move(*left), std::move(*right)};
}

Result<std::string> work_precision_svg(const KnobResult& result) {
  const Diagram diagram(result);
  PanelPlace place{0.0, kTitleHeight, 2.0 * kPanelWidth, kTitleHeight + diagram.height()};
  std::string script = "set multiplot title " + gnuplot_quoted(result.knob.title) +
                       " font ',17'\n" + Panel(diagram, Against::kTime, place).script();
  place.left = kPanelWidth;
  script += Panel(diagram, Against::kLevel, place).script() + "unset multiplot\n";
  return drawn(script, place.width, place.height);
}

}  // namespace palpate
