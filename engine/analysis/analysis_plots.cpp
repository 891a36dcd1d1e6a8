#include "engine/analysis/analysis_plots.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include "engine/report/diagram_panel.h"
#include "engine/report/gnuplot.h"
#include "engine/report/human_units.h"
#include "engine/report/label_places.h"

namespace palpate {
namespace {

// Pixels. The panel is so narrow that its texts stay readable on a phone.
constexpr double kWidth = 460.0;
constexpr PixelBox kArea = {80.0, 40.0, 448.0, 300.0};
constexpr double kLegendTop = kArea.bottom + 80.0;
constexpr double kLegendRow = 22.0;
constexpr int kFontPx = 14;

constexpr double kDodge = 0.06;       // between curves, in levels
constexpr double kPaperDodge = 0.18;  // of the paper's means
constexpr const char* kPaperColour = "#606060";

// The range of the vertical axis is wider than the values by this share on each side. The axis
// begins at 0 if the lowest value is less than this share of the highest one.
constexpr double kMargin = 0.1;
constexpr double kNearZero = 0.4;

// A mean with its whisker; half_width NaN: without whisker.
struct PlotPoint {
  double x, mean, half_width;
};

struct PlotCurve {
  std::string title;
  std::vector<PlotPoint> points;
  std::string style;  // of gnuplot, of points and line
  std::string colour;
};

struct PlotPanel {
  std::string title;
  std::string across, up;
  std::vector<std::string> ticks;  // gnuplot strings, at 0, 1, ...
  std::vector<PlotCurve> curves;
};

// A tick label of two lines. The arguments are texts of this file.
std::string two_lines(std::string_view first, std::string_view second) {
  return "\"" + std::string(first) + "\\n" + std::string(second) + "\"";
}

std::string haptic_tick(const std::string& level) {
  if (level == "NoH") return two_lines("NoH", "no force");
  if (level == "UaH") return two_lines("UaH", "actuated axis");
  return two_lines("H", "full force");
}

std::string rotation_text(const std::string& level) {
  return level == "R" ? "R: the scene turns" : "NoR: the scene stands still";
}

std::pair<double, double> range_of(const std::vector<PlotCurve>& curves) {
  double low = INFINITY, high = -INFINITY;
  for (const PlotCurve& curve : curves) {
    for (const PlotPoint& point : curve.points) {
      const double reach = std::isnan(point.half_width) ? 0.0 : point.half_width;
      low = std::min(low, point.mean - reach);
      high = std::max(high, point.mean + reach);
    }
  }
  const double margin = kMargin * (high > low ? high - low : std::max(std::abs(high), 1.0));
  const bool is_from_zero = low >= 0.0 && low - margin < kNearZero * high;
  return {is_from_zero ? 0.0 : low - margin, high + margin};
}

// A position in pixels from the upper left corner, in gnuplot's coordinates.
std::string screen(double x, double y, double height) {
  std::ostringstream out;
  out << "screen " << x / kWidth << ", screen " << 1.0 - y / height;
  return out.str();
}

// gnuplot itself would place the names of the axes beside the widest tick, or over the second line
// of the ticks.
void put_axis_names(const PlotPanel& panel, double height, std::ostringstream& out) {
  out << "set label " << gnuplot_quoted(panel.across) << " at "
      << screen(0.5 * (kArea.left + kArea.right), kArea.bottom + 64.0, height) << " center\n"
      << "set label " << gnuplot_quoted(panel.up) << " at "
      << screen(16.0, 0.5 * (kArea.top + kArea.bottom), height) << " center rotate\n";
}

void put_frame(const PlotPanel& panel, double height, std::ostringstream& out) {
  const auto [low, high] = range_of(panel.curves);
  out << "set lmargin at screen " << kArea.left / kWidth << "\nset rmargin at screen "
      << kArea.right / kWidth << "\nset tmargin at screen " << 1.0 - kArea.top / height
      << "\nset bmargin at screen " << 1.0 - kArea.bottom / height
      << "\nset grid ytics lc rgb '#E4E4E4' lw 1\nset border 3 lc rgb '#404040'\n"
      << "set xtics nomirror scale 0\nset ytics nomirror scale 0.7\nset pointintervalbox 0\n"
      << "set title " << gnuplot_quoted(panel.title)
      << " offset 0,-0.2\nset xrange [-0.5:" << static_cast<double>(panel.ticks.size()) - 0.5
      << "]\nset yrange [" << low << ":" << high << "]\nset xtics (";
  for (std::size_t i = 0; i < panel.ticks.size(); ++i) {
    out << (i > 0 ? ", " : "") << panel.ticks[i] << " " << i;
  }
  out << ")\nset key at " << screen(kArea.left - 60.0, kLegendTop, height)
      << " left top Left reverse vertical maxrows " << panel.curves.size()
      << " samplen 2.2 spacing 1.1\n";
  put_axis_names(panel, height, out);
}

Result<std::string> drawn(const PlotPanel& panel) {
  const double height = kLegendTop + kLegendRow * static_cast<double>(panel.curves.size()) + 8.0;
  std::ostringstream out;
  out.precision(9);
  put_frame(panel, height, out);
  std::string points_plots, whisker_plots;
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    const PlotCurve& curve = panel.curves[i];
    std::string points, whiskers;
    for (const PlotPoint& point : curve.points) {
      points += data_row({point.x, point.mean});
      if (!std::isnan(point.half_width)) {
        whiskers += data_row({point.x, point.mean, point.half_width});
      }
    }
    const std::string number = std::to_string(i);
    out << "$points" << number << " << EOD\n" << points << "EOD\n";
    points_plots += ", \\\n  $points" + number + " with " + curve.style + " title " +
                    gnuplot_quoted(curve.title);
    if (whiskers.empty()) continue;
    out << "$whiskers" << number << " << EOD\n" << whiskers << "EOD\n";
    whisker_plots += ", \\\n  $whiskers" + number + " with yerrorbars ps 0 lw 1.5 lc rgb '" +
                     curve.colour + "' notitle";
  }
  out << "plot NaN notitle" << whisker_plots << points_plots << "\n";
  return gnuplot_svg(out.str(), static_cast<int>(kWidth), static_cast<int>(height), kFontPx);
}

Error not_drawn() {
  return invalid_argument("figure", "no participant has completed trials in all its conditions");
}

PlotCurve paper_curve(std::string title, std::vector<PlotPoint> points) {
  return {std::move(title), std::move(points),
          std::string("points pt 12 ps 1.2 lw 1.5 lc rgb '") + kPaperColour + "'", kPaperColour};
}

std::string capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

}  // namespace

std::string whose_trials(const OperatorAnalysis& analysis) {
  return analysis.is_simulated() ? "simulated operators, " + analysis.name() : analysis.name();
}

Result<std::string> rotation_haptic_svg(const OperatorAnalysis& analysis, Outcome outcome) {
  const PrimaryAnalysis* primary = analysis.primary_of(outcome);
  const auto& haptic = analysis.table.levels(kHapticFactor);
  const auto& rotation = analysis.table.levels(kRotationFactor);
  if (!primary || !primary->mean(0, 0)) return not_drawn();
  const OutcomeText& text = outcome_text(outcome);
  PlotPanel panel{capitalised(std::string(text.name)) + ": " + whose_trials(analysis),
                  "commanded force (Haptic)",
                  with_unit(text.name, text.unit),
                  {},
                  {}};
  for (const std::string& level : haptic) panel.ticks.push_back(haptic_tick(level));
  for (int r = 0; r < static_cast<int>(rotation.size()); ++r) {
    const auto place = static_cast<std::size_t>(rotation[r] == "R");
    PlotCurve curve{rotation_text(rotation[r]), {}, curve_style(place), curve_colour(place)};
    for (int h = 0; h < static_cast<int>(haptic.size()); ++h) {
      const PrimaryMean* mean = primary->mean(h, r);
      if (mean)
        curve.points.push_back({h + kDodge * (2.0 * r - 1.0), mean->mean, mean->half_width});
    }
    panel.curves.push_back(std::move(curve));
  }
  std::vector<PlotPoint> paper;
  for (std::size_t h = 0; h < haptic.size(); ++h) {
    const PaperMean* mean = paper_mean(outcome, haptic[h]);
    if (mean) paper.push_back({static_cast<double>(h) + kPaperDodge, mean->mean, NAN});
  }
  if (!paper.empty()) {
    panel.curves.push_back(paper_curve("the paper's people, mean of NoR and R", std::move(paper)));
  }
  return drawn(panel);
}

Result<std::string> angle_svg(const OperatorAnalysis& analysis) {
  const auto& rotation = analysis.table.levels(kRotationFactor);
  if (!analysis.angle_of_uah || !analysis.angle_of_uah->mean(-1, 0)) return not_drawn();
  PlotPanel panel{"Contact angle in UaH: " + whose_trials(analysis),
                  "rotation of the scene",
                  "mean contact angle (deg)",
                  {},
                  {}};
  PlotCurve ours{analysis.is_simulated() ? "simulated operators, 95 % interval"
                                         : "people of this file, 95 % interval",
                 {},
                 curve_style(0),
                 curve_colour(0)};
  std::vector<PlotPoint> paper;
  for (int r = 0; r < static_cast<int>(rotation.size()); ++r) {
    panel.ticks.push_back(rotation[r] == "R" ? two_lines("R", "the scene turns")
                                             : two_lines("NoR", "the scene stands still"));
    const PrimaryMean* mean = analysis.angle_of_uah->mean(-1, r);
    if (mean) ours.points.push_back({static_cast<double>(r), mean->mean, mean->half_width});
    const PaperMean* printed = paper_mean(Outcome::kContactAngle, rotation[r]);
    if (printed) paper.push_back({r + kPaperDodge, printed->mean, printed->sd});
  }
  panel.curves.push_back(std::move(ours));
  panel.curves.push_back(paper_curve("the paper's people, standard deviation", std::move(paper)));
  return drawn(panel);
}

}  // namespace palpate
