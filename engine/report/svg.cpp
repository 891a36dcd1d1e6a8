#include "engine/report/svg.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "geometry/base/printable.h"

namespace palpate {
namespace {

// Pixels.
constexpr double kTickLength = 5.0;
constexpr double kTickGap = 8.0;        // from the frame to a label
constexpr double kAcrossLabels = 20.0;  // from the frame to the base line of the labels
constexpr double kAcrossName = 43.0;    // from the frame to the base line of the name
constexpr double kUpName = 58.0;        // from the frame to the base line of the name
constexpr double kSpotRadius = 6.0;

// The ground and the ink of a picture, in both colour schemes. Programs that know no style sheets
// use the attributes, which are those of a light ground.
constexpr std::string_view kSvgStyle =
    "<style>.palpate-picture{color-scheme:light "
    "dark}@media(prefers-color-scheme:dark){.palpate-picture{"
    "color:#e6edf3}.palpate-ground{fill:#0d1117}.palpate-rim{stroke:#0d1117}}</style>\n";

std::string fixed(double value, int decimals = 2) {
  std::array<char, 340> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals)
                       .ptr;
  std::string digits(text.data(), end);
  const bool is_zero = digits.find_first_not_of("-0.") == std::string::npos;
  return is_zero && digits.front() == '-' ? digits.substr(1) : digits;
}

std::string escaped_text(std::string_view text) {
  std::string out;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

// name="value"; the value is one of ours and needs no escape.
std::string attribute_text(std::string_view name, std::string_view value) {
  std::string out = " ";
  return out.append(name).append("=\"").append(value).append("\"");
}
std::string attribute_text(std::string_view name, double value) {
  return attribute_text(name, fixed(value));
}

std::string stroke_attributes(const SvgStroke& stroke) {
  return attribute_text("stroke", stroke.colour) + attribute_text("stroke-width", stroke.width_px) +
         attribute_text("stroke-dasharray", stroke.dash);
}

std::string point_text(const SvgPoint& p) {
  return fixed(p.x()) + "," + fixed(p.y());
}

}  // namespace

std::vector<SvgTick> round_ticks(double low, double high) {
  constexpr double kMostSteps = 6.0;
  const double least = (high - low) / kMostSteps;
  int exponent = static_cast<int>(std::floor(std::log10(least)));
  double step = 0.0;
  for (const int digit : {1, 2, 5, 10}) {
    step = digit * std::pow(10.0, exponent);
    if (step < least) continue;
    if (digit == 10) ++exponent;
    break;
  }
  std::vector<SvgTick> ticks;
  const double first = std::ceil(low / step);
  for (double n = 0.0; n <= kMostSteps && (first + n) * step <= high; n += 1.0) {
    const double value = (first + n) * step;
    ticks.push_back({value, fixed(value, std::max(0, -exponent))});
  }
  return ticks;
}

SvgPicture::SvgPicture(double width_px, double height_px, double font_px) {
  text_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"palpate-picture\"" +
          attribute_text("width", width_px) + attribute_text("height", height_px) +
          attribute_text("viewBox", "0 0 " + fixed(width_px) + " " + fixed(height_px)) +
          attribute_text("font-family", "system-ui, 'DejaVu Sans', sans-serif") +
          attribute_text("font-size", font_px) + attribute_text("color", "#1d2329") +
          attribute_text("fill", kSvgInk) + ">\n";
  text_ += kSvgStyle;
  text_ += "<rect class=\"palpate-ground\" width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
}

void SvgPicture::begin_panel(const SvgBox& box) {
  const std::string width = fixed(box.right - box.left), height = fixed(box.bottom - box.top);
  text_ += "<svg" + attribute_text("x", box.left) + attribute_text("y", box.top) +
           attribute_text("width", width) + attribute_text("height", height) +
           attribute_text("viewBox", "0 0 " + width + " " + height) + ">\n";
}

void SvgPicture::end_panel() {
  text_ += "</svg>\n";
}

void SvgPicture::text(const SvgPoint& at, std::string_view text, const SvgText& style) {
  if (text.empty()) return;
  text_ += "<text" + attribute_text("x", at.x()) + attribute_text("y", at.y()) +
           attribute_text("text-anchor", style.anchor);
  if (style.size_px > 0.0) text_ += attribute_text("font-size", style.size_px);
  if (style.is_upright) text_ += attribute_text("transform", "rotate(-90 " + point_text(at) + ")");
  text_ += ">" + escaped_text(text) + "</text>\n";
}

void SvgPicture::lines(std::span<const SvgLine> lines, const SvgStroke& stroke) {
  std::string path;
  for (const SvgLine& line : lines) {
    char command = 'M';
    for (const SvgPoint& p : line) {
      path += command + point_text(p);
      command = 'L';
    }
  }
  if (path.empty()) return;
  text_ += "<path" + attribute_text("fill", "none") + stroke_attributes(stroke) +
           attribute_text("d", path) + "/>\n";
}

void SvgPicture::area(const SvgLine& corners, const char* colour, double opacity) {
  std::string points;
  for (const SvgPoint& p : corners) points += (points.empty() ? "" : " ") + point_text(p);
  text_ += "<polygon" + attribute_text("fill", colour) + attribute_text("fill-opacity", opacity) +
           attribute_text("points", points) + "/>\n";
}

void SvgPicture::area(const SvgBox& box, const char* colour, double opacity) {
  area({{box.left, box.top}, {box.right, box.top}, {box.right, box.bottom}, {box.left, box.bottom}},
       colour, opacity);
}

void SvgPicture::spot(const SvgPoint& middle) {
  text_ += "<circle" + attribute_text("cx", middle.x()) + attribute_text("cy", middle.y()) +
           attribute_text("r", kSpotRadius) + attribute_text("class", "palpate-rim") +
           attribute_text("stroke", "#ffffff") + attribute_text("stroke-width", 2.0) + "/>\n";
}

void SvgPicture::axes(const SvgAxes& axes) {
  const SvgBox& box = axes.area;
  std::vector<SvgLine> grid, ticks;
  for (const SvgTick& tick : axes.across) {
    grid.push_back({{tick.at, box.top}, {tick.at, box.bottom}});
    ticks.push_back({{tick.at, box.bottom}, {tick.at, box.bottom + kTickLength}});
    text({tick.at, box.bottom + kAcrossLabels}, tick.label, {"middle"});
  }
  for (const SvgTick& tick : axes.up) {
    grid.push_back({{box.left, tick.at}, {box.right, tick.at}});
    ticks.push_back({{box.left - kTickLength, tick.at}, {box.left, tick.at}});
    text({box.left - kTickGap, tick.at + kTickLength}, tick.label, {"end"});
  }
  lines(grid, {"#80808040", 1.0});
  lines(ticks, {});
  line({{box.left, box.top},
        {box.right, box.top},
        {box.right, box.bottom},
        {box.left, box.bottom},
        {box.left, box.top}},
       {});
  text({box.middle().x(), box.bottom + kAcrossName}, axes.across_name, {"middle"});
  text({box.left - kUpName, box.middle().y()}, axes.up_name, {"middle", 0.0, true});
}

}  // namespace palpate
