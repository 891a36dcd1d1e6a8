#include "engine/analysis/power_plots.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "engine/analysis/intervals.h"
#include "engine/analysis/power_text.h"
#include "engine/report/diagram_panel.h"
#include "engine/report/gnuplot.h"

namespace palpate {
namespace {

// Pixels. The panel is so narrow that its texts stay readable on a phone.
constexpr double kPowerWidth = 460.0;
constexpr PixelBox kPowerArea = {66.0, 40.0, 444.0, 290.0};
constexpr double kPowerLegendTop = kPowerArea.bottom + 54.0;
constexpr double kPowerLegendRow = 22.0;
constexpr int kPowerFontPx = 14;

// Noises that differ by less than this share have the same curve: far below the error of a million
// data sets, 1e-3.
constexpr double kSameNoise = 1e-6;

struct PowerCurve {
  std::string title;
  std::size_t assumption, test;
  std::size_t colour;
  bool is_dashed;
};

std::string power_screen(double x, double y, double height) {
  std::ostringstream out;
  out << "screen " << x / kPowerWidth << ", screen " << 1.0 - y / height;
  return out.str();
}

void put_power_frame(const std::string& title, std::size_t curves, int participants, double height,
                     std::ostringstream& out) {
  out << "set lmargin at screen " << kPowerArea.left / kPowerWidth << "\nset rmargin at screen "
      << kPowerArea.right / kPowerWidth << "\nset tmargin at screen "
      << 1.0 - kPowerArea.top / height << "\nset bmargin at screen "
      << 1.0 - kPowerArea.bottom / height
      << "\nset grid ytics lc rgb '#E4E4E4' lw 1\nset border 3 lc rgb '#404040'\n"
      << "set xtics nomirror scale 0.7\nset ytics nomirror scale 0.7 0.2\n"
      << "set title " << gnuplot_quoted(title) << " offset 0,-0.2\nset xrange [0:" << participants
      << "]\nset yrange [0:1.02]\n"
      << "set label 'number of people' at "
      << power_screen(0.5 * (kPowerArea.left + kPowerArea.right), kPowerArea.bottom + 40.0, height)
      << " center\nset label 'power' at "
      << power_screen(16.0, 0.5 * (kPowerArea.top + kPowerArea.bottom), height)
      << " center rotate\n"
      << "set key at " << power_screen(kPowerArea.left - 50.0, kPowerLegendTop, height)
      << " left top Left reverse vertical maxrows " << curves << " samplen 2.2 spacing 1.1\n";
  for (const int percent : kPowerPercents) {
    out << "set arrow from 0," << percent / 100.0 << " to " << participants << ","
        << percent / 100.0 << " nohead dt 3 lc rgb '#606060'\n";
  }
}

// The rows "n low high power".
std::string curve_rows(const PowerStudy& study, const PowerCurve& curve) {
  std::string rows;
  for (int n = 2; n <= study.settings().participants; ++n) {
    const int count = study.counts.at(curve.assumption, curve.test, n);
    const Interval interval = wilson_interval(count, study.settings().sets);
    rows += data_row({static_cast<double>(n), interval.low, interval.high,
                      static_cast<double>(count) / study.settings().sets});
  }
  return rows;
}

Result<PowerPanel> draw_power(const PowerStudy& study, const std::string& title,
                              const std::vector<PowerCurve>& curves) {
  const double height =
      kPowerLegendTop + kPowerLegendRow * static_cast<double>(curves.size()) + 8.0;
  std::ostringstream out;
  out.precision(9);
  put_power_frame(title, curves.size(), study.settings().participants, height, out);
  std::string bands, lines;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const PowerCurve& curve = curves[i];
    const std::string block = "$curve" + std::to_string(i);
    const std::string colour = " lc rgb '" + std::string(curve_colour(curve.colour)) + "'";
    out << block << " << EOD\n" << curve_rows(study, curve) << "EOD\n";
    bands += ", \\\n  " + block +
             " using 1:2:3 with filledcurves fs transparent solid 0.25 noborder" + colour +
             " notitle";
    lines += ", \\\n  " + block + " using 1:4 with lines lw " +
             (curve.is_dashed ? "1.5 dt 2" : "2") + colour + " title " +
             gnuplot_quoted(curve.title);
  }
  out << "plot NaN notitle" << bands << lines << "\n";
  auto svg =
      gnuplot_svg(out.str(), static_cast<int>(kPowerWidth), static_cast<int>(height), kPowerFontPx);
  if (!svg) return svg.error();
  return PowerPanel{title, std::move(*svg)};
}

// "least noise: error 8.98 s, u 0.8, w 0.1" for the drawn assumption i.
std::string drawn_title(const PowerStudy& study, const std::vector<std::size_t>& drawn,
                        std::size_t i) {
  const std::string text = assumption_text(study, drawn[i]);
  if (i == 0) return "least noise: " + text;
  return (i + 1 == drawn.size() ? "most noise: " : "middle: ") + text;
}

// The curves of the effect whose tests are `count` from `first` on: corrected ones as lines, and
// then uncorrected ones dashed, if there are both.
std::vector<PowerCurve> effect_curves(const PowerStudy& study, std::size_t first, std::size_t count,
                                      const std::vector<std::size_t>& drawn) {
  std::vector<PowerCurve> curves;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    for (std::size_t t = first + count; t-- > first;) {  // the corrected test is the last one
      const bool is_dashed = t + 1 < first + count;
      const auto correction = static_cast<std::size_t>(study.tests.tests[t].correction);
      const std::string title = drawn.size() == 1 ? std::string(kPowerCorrectionNames[correction])
                                : is_dashed       ? "the same, uncorrected"
                                                  : drawn_title(study, drawn, i);
      curves.push_back({title, drawn[i], t, i, is_dashed});
    }
  }
  return curves;
}

// The curves of a family of pairs.
std::vector<PowerCurve> family_curves(std::size_t first, std::size_t count, const PowerStudy& study,
                                      std::size_t assumption) {
  std::vector<PowerCurve> curves;
  for (std::size_t i = 0; i < count; ++i) {
    curves.push_back({study.tests.tests[first + i].name, assumption, first + i, i, false});
  }
  return curves;
}

// The number of tests from `first` on that belong together: of one effect or of one family.
std::size_t tests_together(const std::vector<PowerTest>& tests, std::size_t first) {
  std::size_t count = 1;
  for (std::size_t t = first + 1; t < tests.size(); ++t, ++count) {
    if (tests[t].family != tests[first].family) break;
    if (tests[t].family.empty() && tests[t].name != tests[first].name) break;
  }
  return count;
}

}  // namespace

std::vector<std::size_t> drawn_assumptions(const PowerStudy& study) {
  const auto order = study.by_noise();
  const double least = study.noise(order.front()), most = study.noise(order.back());
  if (most - least <= kSameNoise * most) return {order.front()};
  if (order.size() <= 2) return order;
  return {order.front(), order[order.size() / 2], order.back()};
}

Result<std::vector<PowerPanel>> power_panels(const PowerStudy& study) {
  const auto drawn = drawn_assumptions(study);
  const auto& tests = study.tests.tests;
  std::vector<PowerPanel> panels;
  for (std::size_t t = 0, count = 0; t < tests.size(); t += count) {
    count = tests_together(tests, t);
    const bool is_effect = tests[t].family.empty();
    if (!is_effect && count == 1) continue;  // the pair is the effect of Rotation again
    auto panel = is_effect ? draw_power(study, tests[t].name, effect_curves(study, t, count, drawn))
                           : draw_power(study, tests[t].family + ", Holm",
                                        family_curves(t, count, study, drawn[drawn.size() / 2]));
    if (!panel) return panel.error();
    panels.push_back(std::move(*panel));
  }
  return panels;
}

}  // namespace palpate
