#include "engine/analysis/canonical_plot.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "engine/report/diagram_panel.h"
#include "engine/report/gnuplot.h"
#include "engine/report/label_places.h"

namespace palpate {
namespace {

// Pixels. As wide as the other panels of the experiment, so that texts stay readable on a phone.
constexpr double kCanonicalWidth = 460.0;
constexpr double kCanonicalHeight = 436.0;
constexpr PixelBox kCanonicalArea = {68.0, 40.0, 448.0, 300.0};
constexpr int kCanonicalFontPx = 14;

// The range of the vertical axis ends above the highest value by this share.
constexpr double kAboveHighest = 0.08;
constexpr double kLeastTop = 0.5;  // of the ratio
// The range of the horizontal axis, and the number of steps of the curve tan a.
constexpr double kBesideAngles_deg = 4.0;
constexpr int kCurveSteps = 180;
// The whiskers stand this far beside their point, of NoR on its left and of R on its right: behind
// the point they would be hidden.
constexpr double kWhiskersBeside_deg = 2.0;

struct CanonicalCurve {
  std::string title;
  std::vector<CanonicalMean> means;
  std::size_t colour;
  bool has_line;  // between the points
};

// Without a line: larger open points, which are visible behind those of another curve.
std::string style_of(const CanonicalCurve& curve) {
  if (curve.has_line) return curve_style(curve.colour);
  return "points lw 2 ps 1.3 pt " + std::to_string(curve_point(curve.colour) - 1) + " lc rgb '" +
         curve_colour(curve.colour) + "'";
}

std::string across_canvas(double x, double y) {
  std::ostringstream out;
  out << "screen " << x / kCanonicalWidth << ", screen " << 1.0 - y / kCanonicalHeight;
  return out.str();
}

double reach_of(const MeanInterval& interval) {
  return interval.mean + (std::isnan(interval.half_width) ? 0.0 : interval.half_width);
}

// 0 if no mean has a value.
double highest_of(const std::vector<CanonicalMean>& means) {
  double highest = 0.0;
  for (const CanonicalMean& mean : means) {
    if (mean.interval.count > 0) highest = std::max(highest, reach_of(mean.interval));
  }
  return highest;
}

// NoR and R. A line between the points of NoR would leave tan a, and slope where the share jumps.
std::vector<CanonicalCurve> curves_of(const std::vector<CanonicalRow>& rows,
                                      CanonicalMeasure measure, CanonicalMotion motion) {
  return {{"NoR: the wall stands still", canonical_means(rows, measure, motion, false), 0, false},
          {"R: A4 turns the wall", canonical_means(rows, measure, motion, true), 1, true}};
}

// The end of the vertical axis. tan a has no limit, and R would be invisible beside it.
double top_of(CanonicalMeasure measure, const std::vector<CanonicalCurve>& curves) {
  if (measure != CanonicalMeasure::kAlongOverInto) return 1.0 + kAboveHighest;
  const double without = highest_of(curves[0].means);
  const double with = highest_of(curves[1].means);
  const double highest = std::min(std::max(without, with), std::max(with, kRatioShown));
  return std::max(highest, kLeastTop) * (1.0 + kAboveHighest);
}

bool has_values(const std::vector<CanonicalCurve>& curves) {
  return std::any_of(curves.begin(), curves.end(), [](const CanonicalCurve& curve) {
    return std::any_of(curve.means.begin(), curve.means.end(),
                       [](const CanonicalMean& mean) { return mean.interval.count > 0; });
  });
}

void put_canonical_frame(CanonicalMeasure measure, CanonicalMotion motion, double top,
                         std::ostringstream& out) {
  const PixelBox& area = kCanonicalArea;
  const bool is_ratio = measure == CanonicalMeasure::kAlongOverInto;
  const std::string up = is_ratio ? "force along the wall / into the hand" : "share within 30 deg";
  const std::string title = motion == CanonicalMotion::kPressed ? "Pressed: simulated operators"
                                                                : "Stroked: simulated operators";
  out << "set lmargin at screen " << area.left / kCanonicalWidth << "\nset rmargin at screen "
      << area.right / kCanonicalWidth << "\nset tmargin at screen "
      << 1.0 - area.top / kCanonicalHeight << "\nset bmargin at screen "
      << 1.0 - area.bottom / kCanonicalHeight
      << "\nset grid ytics lc rgb '#E4E4E4' lw 1\nset border 3 lc rgb '#404040'\n"
      << "set xtics 15 nomirror scale 0.7\nset ytics nomirror scale 0.7\nset pointintervalbox 0\n"
      << "set title " << gnuplot_quoted(title) << " offset 0,-0.2\nset xrange ["
      << -kBesideAngles_deg << ":" << 90.0 + kBesideAngles_deg << "]\nset yrange [0:" << top
      << "]\nset key at " << across_canvas(area.left - 40.0, area.bottom + 62.0)
      << " left top Left reverse vertical maxrows 3 samplen 2.2 spacing 1.1\n"
      << "set label " << gnuplot_quoted("angle a of the wall to the motor (deg)") << " at "
      << across_canvas(0.5 * (area.left + area.right), area.bottom + 46.0) << " center\n"
      << "set label " << gnuplot_quoted(up) << " at "
      << across_canvas(14.0, 0.5 * (area.top + area.bottom)) << " center rotate\n";
}

// The curve tan a up to the end of the axis as a data block, and its entry of the plot command.
std::string put_tangent(double top, std::ostringstream& out) {
  const double end_deg = std::atan(top) * 180.0 / std::numbers::pi;
  out << "$tangent << EOD\n";
  for (int i = 0; i <= kCurveSteps; ++i) {
    const double a_deg = end_deg * i / kCurveSteps;
    out << data_row({a_deg, std::min(top, std::tan(a_deg * std::numbers::pi / 180.0))});
  }
  out << "EOD\n";
  return ", \\\n  $tangent with lines lw 2 dt 2 lc rgb '#606060' title " +
         gnuplot_quoted("tan a: the motor alone, wall at rest");
}

std::string put_means(const CanonicalCurve& curve, double top, std::ostringstream& out) {
  std::string points, whiskers;
  const double beside_deg = curve.has_line ? kWhiskersBeside_deg : -kWhiskersBeside_deg;
  for (const CanonicalMean& mean : curve.means) {
    const MeanInterval& interval = mean.interval;
    if (interval.count == 0 || interval.mean > top) continue;
    points += data_row({mean.cell.angle_deg, interval.mean});
    if (!std::isnan(interval.half_width)) {
      whiskers += data_row({mean.cell.angle_deg + beside_deg, interval.mean, interval.half_width});
    }
  }
  if (points.empty()) return "";
  const std::string number = std::to_string(curve.colour);
  out << "$points" << number << " << EOD\n" << points << "EOD\n";
  std::string plots = ", \\\n  $points" + number + " with " + style_of(curve) + " title " +
                      gnuplot_quoted(curve.title);
  if (whiskers.empty()) return plots;
  out << "$whiskers" << number << " << EOD\n" << whiskers << "EOD\n";
  return ", \\\n  $whiskers" + number + " with yerrorbars ps 0 lw 1.5 lc rgb '" +
         curve_colour(curve.colour) + "' notitle" + plots;
}

}  // namespace

Result<std::string> canonical_svg(const std::vector<CanonicalRow>& rows, CanonicalMeasure measure,
                                  CanonicalMotion motion) {
  const std::vector<CanonicalCurve> curves = curves_of(rows, measure, motion);
  if (!has_values(curves)) return invalid_argument("figure", "no trial has a value");
  const double top = top_of(measure, curves);
  std::ostringstream out;
  out.precision(9);
  put_canonical_frame(measure, motion, top, out);
  std::string plots;
  if (measure == CanonicalMeasure::kAlongOverInto) plots += put_tangent(top, out);
  for (const CanonicalCurve& curve : curves) plots += put_means(curve, top, out);
  out << "plot NaN notitle" << plots << "\n";
  return gnuplot_svg(out.str(), static_cast<int>(kCanonicalWidth),
                     static_cast<int>(kCanonicalHeight), kCanonicalFontPx);
}

bool is_canonical_ratio_cut(const std::vector<CanonicalRow>& rows, CanonicalMotion motion) {
  const auto curves = curves_of(rows, CanonicalMeasure::kAlongOverInto, motion);
  const double top = top_of(CanonicalMeasure::kAlongOverInto, curves);
  return std::any_of(curves[0].means.begin(), curves[0].means.end(),
                     [&](const CanonicalMean& mean) { return mean.interval.mean > top; });
}

}  // namespace palpate
