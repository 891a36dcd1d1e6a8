#pragma once

// Where small texts of a diagram can go without covering anything.

#include <optional>
#include <string_view>
#include <vector>

namespace palpate {

// Pixels, y downwards.
struct PixelBox {
  double left = 0.0, top = 0.0, right = 0.0, bottom = 0.0;

  static PixelBox about(double x, double y, double half_width, double half_height);
  bool overlaps(const PixelBox& other) const;
  bool is_within(const PixelBox& other) const;
};

class LabelPlaces {
 public:
  explicit LabelPlaces(const PixelBox& area) : area_(area) {}

  // What must stay visible.
  void block(const PixelBox& box) { taken_.push_back(box); }
  void block_line(double x0, double y0, double x1, double y1);

  // Takes a free place beside a point; none if there is none. `reach`: from the point to the label;
  // one that is urgent may be somewhat farther.
  std::optional<PixelBox> take_beside(double x, double y, double width, double height, double reach,
                                      bool is_urgent);
  // Takes this place if it is free.
  bool take(const PixelBox& box);

 private:
  PixelBox area_;
  std::vector<PixelBox> taken_;
};

// About the width of a text in a sans-serif font. UTF-8.
double text_width_px(std::string_view text, double font_px);

}  // namespace palpate
