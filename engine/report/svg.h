#pragma once

// Writes pictures as SVG.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// Pixels from the upper left corner of the picture or of its open panel, y downwards.
using SvgPoint = Eigen::Vector2d;
using SvgLine = std::vector<SvgPoint>;

// A rectangle, such as the area of an axis pair. Pixels.
struct SvgBox {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;

  SvgPoint middle() const { return {0.5 * (left + right), 0.5 * (top + bottom)}; }
};

// Dark on a light ground and light on a dark one.
inline constexpr const char* kSvgInk = "currentColor";
// Okabe and Ito's colours, which colour-blind readers tell apart.
inline constexpr const char* kSvgBlue = "#0072B2";
inline constexpr const char* kSvgVermillion = "#D55E00";
inline constexpr const char* kSvgGreen = "#009E73";

struct SvgStroke {
  const char* colour = kSvgInk;
  double width_px = 1.0;
  const char* dash = "none";  // lengths of dashes and gaps, as in "7 4"
};

struct SvgText {
  const char* anchor = "start";  // start, middle or end
  double size_px = 0.0;          // 0: that of the picture
  bool is_upright = false;       // turned to read from below
};

struct SvgTick {
  double at = 0.0;  // x of an axis across, y of an axis up; pixels
  std::string label;
};

// Both axes of a diagram. Names have their units; an empty one is not drawn.
struct SvgAxes {
  SvgBox area;
  std::vector<SvgTick> across, up;
  std::string across_name, up_name;
};

// The labels of the multiples of 1, 2 or 5 times a power of ten from `low` to `high`, at most
// seven, with as many decimals as they need: "-0.5", "0.0", "0.5". SvgTick::at is the value.
std::vector<SvgTick> round_ticks(double low, double high);

// A picture with a ground of its own: white, or dark where the reader's browser prefers dark. Every
// text is shown as it is, whatever its characters; a control character becomes a space. Numbers
// must be finite and are written with two decimals. The same calls give the same bytes.
class SvgPicture {
 public:
  SvgPicture(double width_px, double height_px, double font_px);

  // A part of the picture, an `svg` element of its own, until end_panel(). Its origin is its upper
  // left corner, and nothing is drawn outside of it. Panels do not nest.
  void begin_panel(const SvgBox& box);
  void end_panel();

  void text(const SvgPoint& at, std::string_view text, const SvgText& style = {});
  // Lines of one style, each from its first to its last point.
  void lines(std::span<const SvgLine> lines, const SvgStroke& stroke);
  void line(const SvgLine& line, const SvgStroke& stroke) { lines({&line, 1}, stroke); }
  // A polygon without an outline; opacity from 0 to 1.
  void area(const SvgLine& corners, const char* colour, double opacity);
  void area(const SvgBox& box, const char* colour, double opacity);
  // A spot of ink with a rim of the ground.
  void spot(const SvgPoint& middle);
  // The frame, the ticks with their labels and grid lines, and the names beside the axes.
  void axes(const SvgAxes& axes);

  std::string document() const { return text_ + "</svg>\n"; }

 private:
  std::string text_;
};

}  // namespace palpate
