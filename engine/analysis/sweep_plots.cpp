#include "engine/analysis/sweep_plots.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <utility>

#include "engine/report/diagram_panel.h"
#include "engine/report/gnuplot.h"
#include "engine/report/human_units.h"

namespace palpate {
namespace {

// Pixels. The figure is so narrow that its texts stay readable on a phone.
constexpr double kFigureWidth = 460.0;
constexpr double kFigureLeft = 84.0, kFigureRight = 446.0;
constexpr double kFirstTop = 26.0;
constexpr double kPanelHeight = 166.0, kPanelGap = 26.0;
constexpr double kBelowPanels = 92.0;  // ticks and name of the horizontal axis
constexpr double kKeyHeight = 74.0;
constexpr int kFigureFontPx = 14;

constexpr double kConditionDodge = 0.05;  // between conditions, in levels
constexpr double kSweepMargin = 0.08;     // of the vertical range
constexpr const char* kFlipColour = "#9c3f00";
constexpr const char* kMissingColour = "#eeeeee";

double panel_top(std::size_t panel) {
  return kFirstTop + static_cast<double>(panel) * (kPanelHeight + kPanelGap);
}
double figure_height() {
  return panel_top(kSweepOutcomes.size()) - kPanelGap + kBelowPanels + kKeyHeight;
}

std::string on_screen(double x, double y) {
  std::ostringstream out;
  out << "screen " << x / kFigureWidth << ", screen " << 1.0 - y / figure_height();
  return out.str();
}

struct Condition {
  std::size_t haptic, rotation;

  std::string name() const {
    return std::string(kHapticNames[haptic]) + ", " + std::string(kRotationNames[rotation]);
  }
  // The colour states the force; filled points and a solid line state that the scene turns.
  std::string style() const {
    const int point = curve_point(haptic);
    return std::string("linespoints lw 1.6 ps 0.8 lc rgb '") + curve_colour(haptic) + "' pt " +
           std::to_string(rotation == 0 ? point - 1 : point) + (rotation == 0 ? " dt 2" : " dt 1");
  }
};

std::vector<Condition> all_conditions() {
  std::vector<Condition> all;
  for (std::size_t rotation = 0; rotation < kRotationNames.size(); ++rotation) {
    for (std::size_t haptic = 0; haptic < kHapticNames.size(); ++haptic) {
      all.push_back({haptic, rotation});
    }
  }
  return all;
}

// The data of one panel.
struct PanelRows {
  std::vector<std::string> means, whiskers;  // of each condition
  double low = INFINITY, high = -INFINITY;
};

PanelRows panel_rows(const SweepAnalysis& analysis, const SweepAxis& axis, std::size_t outcome) {
  PanelRows rows;
  const std::vector<Condition> conditions = all_conditions();
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    std::string means, whiskers;
    const double middle = 0.5 * static_cast<double>(conditions.size() - 1);
    const double shift = kConditionDodge * (static_cast<double>(c) - middle);
    for (std::size_t i = 0; i < axis.points.size(); ++i) {
      const SweepMean mean = sweep_mean(analysis.points[axis.points[i]], outcome,
                                        conditions[c].haptic, conditions[c].rotation);
      if (!mean.mean) continue;
      const double x = static_cast<double>(i) + shift;
      const double reach = mean.sd.value_or(0.0);
      means += data_row({x, *mean.mean});
      if (mean.sd) whiskers += data_row({x, *mean.mean, reach});
      rows.low = std::min(rows.low, *mean.mean - reach);
      rows.high = std::max(rows.high, *mean.mean + reach);
    }
    rows.means.push_back(std::move(means));
    rows.whiskers.push_back(std::move(whiskers));
  }
  if (!(rows.low <= rows.high)) rows.low = rows.high = 0.0;
  return rows;
}

void put_ticks_of_levels(const SweepAnalysis& analysis, const SweepAxis& axis, bool is_last,
                         std::ostringstream& out) {
  out << "set xtics nomirror scale 0 (";
  for (std::size_t i = 0; i < axis.points.size(); ++i) {
    const SweepRow& row = analysis.points[axis.points[i]].rows.front();
    std::string text = sweep_value_text(axis.parameter, *row.values[axis.parameter]);
    if (row.block == SweepBlock::kBase) text += "\\n(base)";  // a line break of gnuplot
    const SweepTrials trials = trials_of(analysis.points[axis.points[i]]);
    if (trials.done < trials.trials) {
      text += "\\n" + std::to_string(trials.done) + "/" + std::to_string(trials.trials);
    }
    out << (i > 0 ? ", " : "") << "\"" << (is_last ? text : "") << "\" " << i;
  }
  out << ")\n";
}

void put_flips(const SweepAnalysis& analysis, const SweepAxis& axis, std::size_t outcome,
               std::ostringstream& out) {
  std::map<std::size_t, std::string> labels;  // by the level after the flip
  std::map<std::size_t, bool> clear;
  const auto flips = flips_along(analysis, axis);
  for (std::size_t i = 0; i < flips.size(); ++i) {
    if (sweep_rankings()[flips[i].ranking].outcome != outcome) continue;
    std::size_t level = 0;
    while (*analysis.points[axis.points[level]].rows.front().values[axis.parameter] < flips[i].to) {
      ++level;
    }
    std::string& label = labels[level];
    const std::string number = std::to_string(i + 1);
    label += (label.empty() ? "" : ", ") + (flips[i].is_clear ? number : "(" + number + ")");
    clear[level] = clear[level] || flips[i].is_clear;
  }
  for (const auto& [level, label] : labels) {
    const double x = static_cast<double>(level) - 0.5;
    out << "set arrow from " << x << ", graph 0 to " << x << ", graph 1 nohead lw 1.2 lc rgb '"
        << kFlipColour << "' dt " << (clear[level] ? 1 : 2) << "\nset label "
        << gnuplot_quoted(label) << " at " << x << ", graph 1.06 center tc rgb '" << kFlipColour
        << "'\n";
  }
}

// Shades the levels at which trials are missing.
void put_missing(const SweepAnalysis& analysis, const SweepAxis& axis, std::ostringstream& out) {
  for (std::size_t i = 0; i < axis.points.size(); ++i) {
    const SweepTrials trials = trials_of(analysis.points[axis.points[i]]);
    if (trials.done == trials.trials) continue;
    const double x = static_cast<double>(i);
    out << "set object rectangle from " << x - 0.5 << ", graph 0 to " << x + 0.5
        << ", graph 1 behind fs solid noborder fc rgb '" << kMissingColour << "'\n";
  }
}

void put_range(const PanelRows& rows, double top, std::size_t levels, std::ostringstream& out) {
  const double margin =
      kSweepMargin * (rows.high > rows.low ? rows.high - rows.low : std::max(rows.high, 1.0));
  const double low = rows.low >= 0.0 ? std::max(0.0, rows.low - margin) : rows.low - margin;
  out << "set lmargin at screen " << kFigureLeft / kFigureWidth << "\nset rmargin at screen "
      << kFigureRight / kFigureWidth << "\nset tmargin at screen " << 1.0 - top / figure_height()
      << "\nset bmargin at screen " << 1.0 - (top + kPanelHeight) / figure_height()
      << "\nset xrange [-0.5:" << static_cast<double>(levels) - 0.5 << "]\nset yrange [" << low
      << ":" << rows.high + margin << "]\n";
}

// The name of the measure and, below the last panel, that of the parameter and the legend.
void put_names(const SweepAxis& axis, std::size_t outcome, double top, bool is_last,
               std::ostringstream& out) {
  const OutcomeText& text = outcome_text(kSweepOutcomes[outcome]);
  const double bottom = top + kPanelHeight;
  out << "set label " << gnuplot_quoted(with_unit(text.name, text.unit)) << " at "
      << on_screen(16.0, 0.5 * (top + bottom)) << " center rotate\n";
  if (!is_last) {
    out << "unset key\n";
    return;
  }
  out << "set label " << gnuplot_quoted(sweep_parameter_title(axis.parameter)) << " at "
      << on_screen(0.5 * (kFigureLeft + kFigureRight), bottom + 80.0) << " center\n"
      << "set key at " << on_screen(14.0, bottom + kBelowPanels)
      << " left top Left reverse vertical maxrows 3 samplen 2.6 spacing 1.2 width 4\n";
}

// The curves, above their whiskers. A condition that nobody completed is in the legend only.
void put_curves(const PanelRows& rows, std::size_t outcome, std::ostringstream& out) {
  std::string plots, whiskers;
  const std::vector<Condition> conditions = all_conditions();
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const std::string name = std::to_string(outcome) + "_" + std::to_string(c);
    const bool is_empty = rows.means[c].empty();
    if (!is_empty) out << "$m" << name << " << EOD\n" << rows.means[c] << "EOD\n";
    plots += ", \\\n  " + (is_empty ? "keyentry" : "$m" + name) + " with " + conditions[c].style() +
             " title " + gnuplot_quoted(conditions[c].name());
    if (rows.whiskers[c].empty()) continue;
    out << "$w" << name << " << EOD\n" << rows.whiskers[c] << "EOD\n";
    whiskers += ", \\\n  $w" + name + " with yerrorbars ps 0 lw 1 lc rgb '#80" +
                std::string(curve_colour(conditions[c].haptic)).substr(1) + "' notitle";
  }
  out << "plot NaN notitle" << whiskers << plots << "\n";
}

void put_panel(const SweepAnalysis& analysis, const SweepAxis& axis, std::size_t outcome,
               std::ostringstream& out) {
  const PanelRows rows = panel_rows(analysis, axis, outcome);
  const bool is_last = outcome + 1 == kSweepOutcomes.size();
  const double top = panel_top(outcome);
  out << "unset label\nunset arrow\nunset object\n";
  put_range(rows, top, axis.points.size(), out);
  put_ticks_of_levels(analysis, axis, is_last, out);
  put_missing(analysis, axis, out);
  put_flips(analysis, axis, outcome, out);
  put_names(axis, outcome, top, is_last, out);
  put_curves(rows, outcome, out);
}

}  // namespace

std::vector<SweepFlip> flips_along(const SweepAnalysis& analysis, const SweepAxis& axis) {
  std::vector<SweepFlip> flips;
  std::copy_if(analysis.flips.begin(), analysis.flips.end(), std::back_inserter(flips),
               [&](const SweepFlip& flip) { return flip.parameter == axis.parameter; });
  return flips;
}

Result<std::string> sweep_axis_svg(const SweepAnalysis& analysis, const SweepAxis& axis) {
  std::ostringstream out;
  out.precision(9);
  out << "set multiplot\nset grid ytics lc rgb '#E4E4E4' lw 1\nset border 3 lc rgb '#404040'\n"
         "set ytics nomirror scale 0.7\nset pointintervalbox 0\nset bars small\n";
  for (std::size_t i = 0; i < kSweepOutcomes.size(); ++i) put_panel(analysis, axis, i, out);
  out << "unset multiplot\n";
  return gnuplot_svg(out.str(), static_cast<int>(kFigureWidth), static_cast<int>(figure_height()),
                     kFigureFontPx);
}

}  // namespace palpate
