#include "engine/accuracy/stiffness_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "engine/report/html.h"
#include "engine/report/human_units.h"

namespace palpate {
namespace {

// Pixels of a panel, y downwards.
constexpr double kWidth = 480.0, kHeight = 320.0;
constexpr double kLeft = 62.0, kRight = 466.0, kTop = 30.0, kBottom = 274.0;
constexpr double kLabel = 12.0;  // from the middle of a label to the border of a panel
constexpr double kLegendLine = 22.0, kLegendWidth = 600.0;

// Okabe and Ito's colours, which colour-blind readers tell apart.
constexpr const char* kStable = "#009E73";
constexpr const char* kControlled = "#0072B2";
constexpr const char* kRefused = "#D55E00";
constexpr const char* kInk = "#1d2329";
constexpr const char* kLightDash = "7 4";
constexpr const char* kFirmDash = "2 3";

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", value);
  return text.data();
}

double x_of(double delay_s) {
  const double share = std::clamp(delay_s / StiffnessChartRange::kLongestDelay_s, 0.0, 1.0);
  return kLeft + (kRight - kLeft) * share;
}

double y_of(double stiffness_N_per_m) {
  using Range = StiffnessChartRange;
  const double inside = std::clamp(stiffness_N_per_m, Range::kLeast_N_per_m, Range::kMost_N_per_m);
  return kBottom - (kBottom - kTop) * std::log(inside / Range::kLeast_N_per_m) /
                       std::log(Range::kMost_N_per_m / Range::kLeast_N_per_m);
}

std::string text_at(double x, double y, const char* anchor, const std::string& text) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\">" +
         html_escaped(text) + "</text>\n";
}

std::string line(const std::string& points, const char* colour, const char* dash, double width) {
  return "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + colour +
         "\" stroke-width=\"" + number(width) + "\" stroke-dasharray=\"" + dash + "\"/>\n";
}

// The points of a limit over the delay.
template <typename Limit>
std::string points(const ChartedRate& rate, Limit limit) {
  std::string text;
  for (const ChartedLimits& at : rate.limits) {
    text += number(x_of(at.delay_s)) + "," + number(y_of(limit(at))) + " ";
  }
  return text;
}

// What lies below a line, down to the axis.
std::string area(const std::string& above, const char* colour) {
  return "<polygon points=\"" + above + number(kRight) + "," + number(kBottom) + " " +
         number(kLeft) + "," + number(kBottom) + "\" fill=\"" + colour + "\"/>\n";
}

// Areas lie on one another, each in a light tint of its colour.
std::string zone_areas(const ChartedRate& rate) {
  const std::string stable = points(rate, [](const auto& at) { return at.zones.stable_N_per_m; });
  const std::string calm = points(rate, [](const auto& at) { return at.zones.calm_N_per_m; });
  const std::string top =
      number(kLeft) + "," + number(kTop) + " " + number(kRight) + "," + number(kTop) + " ";
  return area(top, "#fbe6d9") + area(calm, "#d6e8f3") + area(stable, "#d3efe6") +
         line(calm, kControlled, "none", 2.0) + line(stable, kStable, "none", 2.0) +
         line(points(rate, [](const auto& at) { return at.light_N_per_m; }), kInk, kLightDash,
              1.2) +
         line(points(rate, [](const auto& at) { return at.firm_N_per_m; }), kInk, kFirmDash, 1.2);
}

std::string axes(const ChartedRate& rate) {
  std::string svg = "<rect x=\"" + number(kLeft) + "\" y=\"" + number(kTop) + "\" width=\"" +
                    number(kRight - kLeft) + "\" height=\"" + number(kBottom - kTop) +
                    "\" fill=\"none\" stroke=\"" + kInk + "\"/>\n";
  for (int delay_ms = 0; 1e-3 * delay_ms <= StiffnessChartRange::kLongestDelay_s; ++delay_ms) {
    svg += text_at(x_of(1e-3 * delay_ms), kBottom + 18.0, "middle", std::to_string(delay_ms));
  }
  for (const int stiffness : {100, 300, 1000, 3000, 10'000}) {
    svg += text_at(kLeft - 6.0, y_of(stiffness) + 4.0, "end", std::to_string(stiffness));
  }
  return svg + text_at(kRight, kBottom + 36.0, "end", "delay (ms)") +
         text_at(6.0, kTop - 10.0, "start", "K (N/m)") +
         text_at(0.5 * (kLeft + kRight), kTop - 10.0, "middle", human(rate.rate_Hz, "Hz"));
}

std::string spot(double x, double y) {
  return "<circle cx=\"" + number(x) + "\" cy=\"" + number(y) + "\" r=\"6\" fill=\"" + kInk +
         "\" stroke=\"#fff\" stroke-width=\"2\"/>\n";
}

std::string own_point(const StiffnessChart& chart) {
  const double x = x_of(chart.own.mechanics.delay.most_s);
  const double y = y_of(chart.stiffness_N_per_m);
  const bool is_right = x > 0.5 * (kLeft + kRight);
  const double middle = std::clamp(y, kTop + kLabel, kBottom - kLabel);
  return spot(x, y) + text_at(x + (is_right ? -11.0 : 11.0), middle + 4.0,
                              is_right ? "end" : "start", human(chart.stiffness_N_per_m, "N/m"));
}

std::string svg_head(double width, double height, const std::string& more) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width) + " " +
         number(height) +
         "\" font-family=\"system-ui, 'DejaVu Sans', sans-serif\" font-size=\"13\" fill=\"" + kInk +
         "\" " + more + ">\n";
}

std::string panel(const StiffnessChart& chart, const ChartedRate& rate, const std::string& more) {
  return svg_head(kWidth, kHeight, more) + zone_areas(rate) + axes(rate) +
         (rate.rate_Hz == chart.rate_Hz ? own_point(chart) : "") + "</svg>\n";
}

struct LegendLine {
  std::string words;
  const char* colour;
  const char* dash;  // null: an area
};

std::vector<LegendLine> legend_lines() {
  return {{"stable: a tip that nobody holds comes to rest by itself", kStable, nullptr},
          {"calm only by the controller, which damps the motion", kControlled, nullptr},
          {"refused: no damping that the delay permits brings the tip to rest", kRefused, nullptr},
          {"below it, a tip in a light grip is stable without the controller", kInk, kLightDash},
          {"the same for a firm grip", kInk, kFirmDash}};
}

std::string own_words(const StiffnessChart& chart) {
  return "the setting, " + human(chart.stiffness_N_per_m, "N/m") + " at a delay of " +
         human(chart.own.mechanics.delay.most_s, "s") + ": " + name_of(chart.own_zone());
}

// A sample of a line of the legend, 24 px wide.
std::string swatch(const LegendLine& entry, double x, double y) {
  if (entry.dash != nullptr) {
    return line(number(x) + "," + number(y) + " " + number(x + 24.0) + "," + number(y),
                entry.colour, entry.dash, 1.2);
  }
  return "<rect x=\"" + number(x) + "\" y=\"" + number(y - 6.0) +
         "\" width=\"24\" height=\"12\" fill=\"" + entry.colour + "\" fill-opacity=\"0.5\"/>\n";
}

double legend_height() {
  return kLegendLine * (static_cast<double>(legend_lines().size()) + 1.5);
}

std::string legend(const StiffnessChart& chart, double top) {
  constexpr double kSwatch = 16.0, kWords = 50.0;
  double y = top + kLegendLine;
  std::string svg;
  for (const LegendLine& entry : legend_lines()) {
    svg += swatch(entry, kSwatch, y) + text_at(kWords, y + 4.0, "start", entry.words);
    y += kLegendLine;
  }
  return svg + spot(kSwatch + 12.0, y) + text_at(kWords, y + 4.0, "start", own_words(chart));
}

}  // namespace

std::string stiffness_chart_svg(const StiffnessChart& chart) {
  const double rows = std::ceil(0.5 * static_cast<double>(chart.rates.size()));
  const double height = rows * kHeight + legend_height();
  std::string svg =
      svg_head(2.0 * kWidth, height,
               "width=\"" + number(2.0 * kWidth) + "\" height=\"" + number(height) + "\"") +
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  for (std::size_t n = 0; n < chart.rates.size(); ++n) {
    svg += panel(chart, chart.rates[n],
                 "x=\"" + number(n % 2 == 0 ? 0.0 : kWidth) + "\" y=\"" +
                     number(kHeight * static_cast<double>(n / 2)) + "\" width=\"" + number(kWidth) +
                     "\" height=\"" + number(kHeight) + "\"");
  }
  return svg + legend(chart, rows * kHeight) + "</svg>\n";
}

ReportSection stiffness_chart_section(const StiffnessChart& chart) {
  const AssumedMechanics& mechanics = chart.own.mechanics;
  std::string html =
      "<p>On a device that moves motors, the force acts some time after the position that it "
      "answers, and a wall is judged with the longest time. This device: " +
      html_escaped(assumed_text(mechanics)) + ". At " + html_escaped(human(chart.rate_Hz, "Hz")) +
      ", " + html_escaped(zone_text(chart.stiffness_N_per_m, chart.own)) +
      ". <code>palpate run --device</code> measures the delay of a board and judges by it.</p>\n";
  if (mechanics.assumes_delay) {
    html +=
        "<p>No delay is stated (<code>--device-delay</code>): the other limits on this page count "
        "none, as of a simulated hand.</p>\n";
  }
  html += "<figure>\n<div class=\"panels\">\n";
  for (const ChartedRate& rate : chart.rates) {
    html += panel(chart, rate,
                  "role=\"img\" aria-label=\"Zones of the stiffness at " +
                      html_escaped(human(rate.rate_Hz, "Hz")) + "\"");
  }
  const double height = legend_height();
  html += "</div>\n" + svg_head(kLegendWidth, height, "style=\"width:100%;max-width:600px\"") +
          legend(chart, 0.0) +
          "</svg>\n<figcaption>Limits of a wall, and of a groove: its walls push with K along each "
          "of two directions, and each is the loop of a wall. Limits outside of the chart are at "
          "its border; the numbers are in stiffness_zones.csv.</figcaption>\n</figure>\n";
  return {"Stiffness, delay and rate", html};
}

}  // namespace palpate
