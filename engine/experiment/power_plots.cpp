#include "engine/experiment/power_plots.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "engine/experiment/intervals.h"
#include "engine/experiment/power_text.h"
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

// The curves of an effect: corrected ones as lines, uncorrected ones dashed if there are both.
std::vector<PowerCurve> effect_curves(const PowerStudy& study, const std::string& effect,
                                      const std::vector<std::size_t>& drawn) {
  std::vector<PowerCurve> curves;
  bool has_gg = false;
  for (const PowerTest& test : study.tests.tests) {
    has_gg =
        has_gg || (test.name == effect && test.correction == PowerCorrection::kGreenhouseGeisser);
  }
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    for (std::size_t t = 0; t < study.tests.tests.size(); ++t) {
      const PowerTest& test = study.tests.tests[t];
      if (test.name != effect) continue;
      const bool is_dashed = has_gg && test.correction == PowerCorrection::kNone;
      std::string title = assumption_text(study, drawn[i]);
      if (is_dashed) title = "the same, uncorrected";
      if (drawn.size() == 1) {
        title = kPowerCorrectionNames[static_cast<std::size_t>(test.correction)];
      }
      curves.push_back({std::move(title), drawn[i], t, i, is_dashed});
    }
  }
  return curves;
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
  std::vector<PowerPanel> panels;
  const auto add = [&](const std::string& title,
                       const std::vector<PowerCurve>& curves) -> std::optional<Error> {
    auto panel = draw_power(study, title, curves);
    if (!panel) return panel.error();
    panels.push_back(std::move(*panel));
    return std::nullopt;
  };
  const auto& tests = study.tests.tests;
  for (std::size_t t = 0; t < tests.size();) {
    std::size_t count = 1;
    while (t + count < tests.size() &&
           (tests[t].family.empty() ? tests[t + count].name == tests[t].name
                                    : tests[t + count].family == tests[t].family)) {
      ++count;
    }
    std::optional<Error> failed;
    if (tests[t].family.empty()) {
      failed = add(tests[t].name, effect_curves(study, tests[t].name, drawn));
    } else if (count > 1) {
      std::vector<PowerCurve> curves;
      for (std::size_t i = 0; i < count; ++i) {
        curves.push_back({tests[t + i].name, drawn[drawn.size() / 2], t + i, i, false});
      }
      failed = add(tests[t].family + ", Holm", curves);
    }
    if (failed) return *failed;
    t += count;
  }
  return panels;
}

}  // namespace palpate
