#pragma once

// Places the labels of a diagram so that they cover nothing.

#include <optional>
#include <string_view>
#include <vector>

namespace palpate {

// A rectangle in pixels, y downwards.
struct PixelBox {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;

  static PixelBox about(double x, double y, double half_width, double half_height);
  bool overlaps(const PixelBox& other) const;
  bool is_within(const PixelBox& other) const;
};

class LabelPlaces {
 public:
  explicit LabelPlaces(const PixelBox& area) : area_(area) {}

  // Marks a part of the diagram that must stay visible.
  void block(const PixelBox& box) { taken_.push_back(box); }
  void block_line(double x0, double y0, double x1, double y1);

  // Occupies a free place beside a point and returns it; nothing if no place is free. `reach`:
  // distance from the point to the label; an urgent label may be somewhat farther away.
  std::optional<PixelBox> take_beside(double x, double y, double width, double height, double reach,
                                      bool is_urgent);
  // Occupies this place if it is free.
  bool take(const PixelBox& box);

 private:
  PixelBox area_;
  std::vector<PixelBox> taken_;
};

// The approximate width of a text in a sans-serif font. UTF-8.
double text_width_px(std::string_view text, double font_px);

}  // namespace palpate
