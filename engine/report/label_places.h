#pragma once

// Places the labels of a diagram so that they cover neither curves nor each other.

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

// Finds places for labels within an area. A place is free if it lies within the area and overlaps
// no blocked or taken place. Pixels, y downwards.
class LabelPlaces {
 public:
  explicit LabelPlaces(const PixelBox& area) : area_(area) {}

  // Marks a box or a straight line of the diagram that no label may cover.
  void block(const PixelBox& box) { taken_.push_back(box); }
  void block_line(double x0, double y0, double x1, double y1);

  // Finds a free place of this size beside the point (x, y), takes it and returns it. Returns no
  // value if no place is free. reach: the distance from the point to the label, in pixels. The
  // distance of an urgent label may be up to 12 pixels larger.
  std::optional<PixelBox> take_beside(double x, double y, double width, double height, double reach,
                                      bool is_urgent);
  // Takes this place and returns true if it is free. Otherwise returns false.
  bool take(const PixelBox& box);

 private:
  PixelBox area_;
  std::vector<PixelBox> taken_;
};

// The approximate width in pixels of a UTF-8 text in a sans-serif font of this size.
double text_width_px(std::string_view text, double font_px);

}  // namespace palpate
