#include "engine/accuracy/stiffness_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "engine/report/human_units.h"
#include "engine/report/svg.h"

namespace palpate {
namespace {

// Pixels.
constexpr double kPanelWidth = 480.0, kPanelHeight = 320.0;
constexpr SvgBox kArea{62.0, 30.0, 466.0, 274.0};  // within a panel
constexpr double kLabel = 12.0;  // from the middle of a label to the border of a panel
constexpr double kLabelAside = 11.0, kDrop = 4.0;
constexpr double kLegendLine = 22.0, kLegendWidth = 600.0;
constexpr double kFont = 13.0;

constexpr double kTint = 0.16;  // opacity of an area
constexpr SvgStroke kStableLine{kSvgGreen, 2.0}, kCalmLine{kSvgBlue, 2.0};
constexpr SvgStroke kLightLine{kSvgInk, 1.2, "7 4"}, kFirmLine{kSvgInk, 1.2, "2 3"};

double x_of(double delay_s) {
  const double share = std::clamp(delay_s / StiffnessChartRange::kLongestDelay_s, 0.0, 1.0);
  return kArea.left + (kArea.right - kArea.left) * share;
}

double y_of(double stiffness_N_per_m) {
  using Range = StiffnessChartRange;
  const double inside = std::clamp(stiffness_N_per_m, Range::kLeast_N_per_m, Range::kMost_N_per_m);
  return kArea.bottom - (kArea.bottom - kArea.top) * std::log(inside / Range::kLeast_N_per_m) /
                            std::log(Range::kMost_N_per_m / Range::kLeast_N_per_m);
}

// A limit over the delay.
template <typename Limit>
SvgLine limit_line(const ChartedRate& rate, Limit limit) {
  SvgLine line;
  for (const ChartedLimits& at : rate.limits) line.push_back({x_of(at.delay_s), y_of(limit(at))});
  return line;
}

SvgLine level_line(double y) {
  return {{kArea.left, y}, {kArea.right, y}};
}

SvgLine between(SvgLine above, const SvgLine& below) {
  above.insert(above.end(), below.rbegin(), below.rend());
  return above;
}

void draw_zones(SvgPicture& svg, const ChartedRate& rate) {
  const SvgLine stable = limit_line(rate, [](const auto& at) { return at.zones.stable_N_per_m; });
  const SvgLine calm = limit_line(rate, [](const auto& at) { return at.zones.calm_N_per_m; });
  svg.area(between(level_line(kArea.top), calm), kSvgVermillion, kTint);
  svg.area(between(calm, stable), kSvgBlue, kTint);
  svg.area(between(stable, level_line(kArea.bottom)), kSvgGreen, kTint);
}

void draw_limits(SvgPicture& svg, const ChartedRate& rate) {
  svg.line(limit_line(rate, [](const auto& at) { return at.zones.calm_N_per_m; }), kCalmLine);
  svg.line(limit_line(rate, [](const auto& at) { return at.zones.stable_N_per_m; }), kStableLine);
  svg.line(limit_line(rate, [](const auto& at) { return at.light_N_per_m; }), kLightLine);
  svg.line(limit_line(rate, [](const auto& at) { return at.firm_N_per_m; }), kFirmLine);
}

void draw_axes(SvgPicture& svg, const ChartedRate& rate) {
  SvgAxes axes{kArea, {}, {}, "", ""};
  for (int delay_ms = 0; 1e-3 * delay_ms <= StiffnessChartRange::kLongestDelay_s; ++delay_ms) {
    axes.across.push_back({x_of(1e-3 * delay_ms), std::to_string(delay_ms)});
  }
  for (const int stiffness : {100, 300, 1000, 3000, 10'000}) {
    axes.up.push_back({y_of(stiffness), std::to_string(stiffness)});
  }
  svg.axes(axes);
  svg.text({kArea.right, kArea.bottom + 38.0}, "delay (ms)", {"end"});
  svg.text({6.0, kArea.top - 10.0}, "K (N/m)");
  svg.text({kArea.middle().x(), kArea.top - 10.0}, human(rate.rate_Hz, "Hz"), {"middle"});
}

void draw_own_point(SvgPicture& svg, const StiffnessChart& chart) {
  const double x = x_of(chart.own.mechanics.delay.most_s);
  const double y = y_of(chart.stiffness_N_per_m);
  const bool is_right = x > kArea.middle().x();
  const double middle = std::clamp(y, kArea.top + kLabel, kArea.bottom - kLabel);
  svg.spot({x, y});
  svg.text({x + (is_right ? -kLabelAside : kLabelAside), middle + kDrop},
           human(chart.stiffness_N_per_m, "N/m"), {is_right ? "end" : "start"});
}

void draw_panel(SvgPicture& svg, const StiffnessChart& chart, const ChartedRate& rate,
                const SvgPoint& corner) {
  svg.begin_panel({corner.x(), corner.y(), corner.x() + kPanelWidth, corner.y() + kPanelHeight});
  draw_zones(svg, rate);
  draw_axes(svg, rate);
  draw_limits(svg, rate);
  if (rate.rate_Hz == chart.rate_Hz) draw_own_point(svg, chart);
  svg.end_panel();
}

// What a line of the legend shows: an area of this colour, else a line.
struct LegendLine {
  const char* words;
  const char* area;
  SvgStroke stroke;
};

constexpr std::array kLegend = {
    LegendLine{"stable: a tip that nobody holds comes to rest by itself", kSvgGreen, {}},
    LegendLine{"calm only by the controller, which damps the motion", kSvgBlue, {}},
    LegendLine{
        "refused: no damping that the delay permits brings the tip to rest", kSvgVermillion, {}},
    LegendLine{"below it, a tip in a light grip is stable without the controller", nullptr,
               kLightLine},
    LegendLine{"the same for a firm grip", nullptr, kFirmLine}};

std::string own_words(const StiffnessChart& chart) {
  return "the setting, " + human(chart.stiffness_N_per_m, "N/m") + " at a delay of " +
         human(chart.own.mechanics.delay.most_s, "s") + ": " + name_of(chart.own_zone());
}

constexpr double kLegendHeight = kLegendLine * (kLegend.size() + 1.5);

void draw_legend(SvgPicture& svg, const StiffnessChart& chart, double top) {
  constexpr double kSample = 16.0, kSampleEnd = 40.0, kWords = 50.0, kHalfHeight = 6.0;
  svg.begin_panel({0.0, top, kLegendWidth, top + kLegendHeight});
  double y = kLegendLine;
  for (const LegendLine& entry : kLegend) {
    if (entry.area != nullptr) {
      svg.area(SvgBox{kSample, y - kHalfHeight, kSampleEnd, y + kHalfHeight}, entry.area,
               2 * kTint);
    } else {
      svg.line({{kSample, y}, {kSampleEnd, y}}, entry.stroke);
    }
    svg.text({kWords, y + kDrop}, entry.words);
    y += kLegendLine;
  }
  svg.spot({0.5 * (kSample + kSampleEnd), y});
  svg.text({kWords, y + kDrop}, own_words(chart));
  svg.end_panel();
}

}  // namespace

std::string stiffness_chart_svg(const StiffnessChart& chart) {
  const double rows = std::ceil(0.5 * static_cast<double>(chart.rates.size()));
  SvgPicture svg(2.0 * kPanelWidth, rows * kPanelHeight + kLegendHeight, kFont);
  for (std::size_t n = 0; n < chart.rates.size(); ++n) {
    draw_panel(svg, chart, chart.rates[n],
               {n % 2 == 0 ? 0.0 : kPanelWidth, kPanelHeight * static_cast<double>(n / 2)});
  }
  draw_legend(svg, chart, rows * kPanelHeight);
  return svg.document();
}

}  // namespace palpate
