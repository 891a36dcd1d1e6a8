#include "engine/report/label_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace palpate {
namespace {

// Mean character width divided by font size, for the widest common sans-serif font.
constexpr double kMeanCharacterWidth = 0.6;

// Squares along a curve block it.
constexpr double kLineStepPx = 5.0;
constexpr double kLineHalfWidthPx = 2.0;

// Offsets from a point to the middle of its label, best first.
std::array<std::array<double, 2>, 8> shifts(double width, double height, double reach) {
  const double aside = reach + 0.5 * width, above = reach + 0.5 * height;
  const double slant_x = 0.7 * reach + 0.5 * width, slant_y = 0.7 * reach + 0.3 * height;
  return {{{aside, 0.0},
           {slant_x, -slant_y},
           {slant_x, slant_y},
           {0.0, -above},
           {0.0, above},
           {-aside, 0.0},
           {-slant_x, -slant_y},
           {-slant_x, slant_y}}};
}

}  // namespace

PixelBox PixelBox::about(double x, double y, double half_width, double half_height) {
  return {x - half_width, y - half_height, x + half_width, y + half_height};
}

bool PixelBox::overlaps(const PixelBox& other) const {
  return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
}

bool PixelBox::is_within(const PixelBox& other) const {
  return left >= other.left && right <= other.right && top >= other.top && bottom <= other.bottom;
}

void LabelPlaces::block_line(double x0, double y0, double x1, double y1) {
  const int steps = 1 + static_cast<int>(std::hypot(x1 - x0, y1 - y0) / kLineStepPx);
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    block(PixelBox::about(x0 + share * (x1 - x0), y0 + share * (y1 - y0), kLineHalfWidthPx,
                          kLineHalfWidthPx));
  }
}

std::optional<PixelBox> LabelPlaces::take_beside(double x, double y, double width, double height,
                                                 double reach, bool is_urgent) {
  for (const double farther : {0.0, 6.0, 12.0}) {
    if (farther > 0.0 && !is_urgent) break;
    for (const auto& [dx, dy] : shifts(width, height, reach + farther)) {
      const PixelBox box = PixelBox::about(x + dx, y + dy, 0.5 * width, 0.5 * height);
      if (take(box)) return box;
    }
  }
  return std::nullopt;
}

bool LabelPlaces::take(const PixelBox& box) {
  if (!box.is_within(area_)) return false;
  if (std::any_of(taken_.begin(), taken_.end(),
                  [&](const PixelBox& other) { return box.overlaps(other); })) {
    return false;
  }
  block(box);
  return true;
}

double text_width_px(std::string_view text, double font_px) {
  const auto characters = std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<std::uint8_t>(c) & 0xC0) != 0x80;  // not a continuation byte
  });
  return kMeanCharacterWidth * font_px * static_cast<double>(characters);
}

}  // namespace palpate
