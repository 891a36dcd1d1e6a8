#include "models/paper_objects.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

// Both labyrinths lie on a grid of 5 x 5 cells. The contour starts at the lower right corner,
// upwards; `moves` has the grid line where each wall ends, alternating between y and x. Walls and
// corridors are one cell wide. A cell of 32 mm has enough clearance for a hand that overshoots, and
// gives a contour of 36 cells = 1.152 m, which is 43 mm/s for a turn in 27 s. Whole millimetres
// make every coordinate a rounded decimal.
Contour grid_contour(const std::vector<int>& moves) {
  std::array<int, 2> cell{5, 0};
  Contour contour;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    contour.emplace_back((32 * cell[0] - 80) / 1000.0, (32 * cell[1] - 80) / 1000.0);
    cell[(i + 1) % 2] = moves[i];
  }
  return contour;
}

Point2 millimetres(double x, double y) {
  return {x / 1000.0, y / 1000.0};
}

}  // namespace

// A pentagram with a tip towards +y in a circle of radius 100 mm. The radius of the notches is
// smaller by the golden ratio squared, so that the walls lie on the five lines of a pentagram, 36
// deg apart. The mean angle to any line is therefore between 43.2 and 46.8 deg. The walls are 72.7
// mm long, the contour 0.727 m. Sines are computed from square roots, which give the same result on
// every platform.
Contour star_contour() {
  const double root5 = std::sqrt(5.0);
  const double golden = (1.0 + root5) / 2.0;
  const double cos36 = (root5 + 1.0) / 4.0;
  const double cos72 = (root5 - 1.0) / 4.0;
  const double sin36 = std::sqrt(10.0 - 2.0 * root5) / 4.0;
  const double sin72 = std::sqrt(10.0 + 2.0 * root5) / 4.0;
  const double tip = 100.0;
  const double notch = tip / (golden * golden);
  return {millimetres(0.0, tip),
          millimetres(-notch * sin36, notch * cos36),
          millimetres(-tip * sin72, tip * cos72),
          millimetres(-notch * sin72, -notch * cos72),
          millimetres(-tip * sin36, -tip * cos36),
          millimetres(0.0, -notch),
          millimetres(tip * sin36, -tip * cos36),
          millimetres(notch * sin72, -notch * cos72),
          millimetres(tip * sin72, tip * cos72),
          millimetres(notch * sin36, notch * cos36)};
}

// A dead-end corridor from the left, and a corridor with a side arm from below. Horizontal and
// vertical walls have the same total length, 18 cells each, so that the mean angle to any line is
// 45 deg.
//   # # # # #
//   . . # . #
//   # # # . #
//   # . . . #
//   # # # . #
Contour labyrinth_contour() {
  return grid_contour({5, 0, 4, 2, 3, 0, 0, 3, 1, 1, 2, 3, 4, 4, 0, 5});
}

// The corridors of the labyrinth as a solid, joined around its lower left corner. If this shape is
// placed over the labyrinth one cell further left and down, the two shapes fit without gap or
// overlap. Horizontal and vertical walls again have 18 cells each.
//   # # # . #
//   # . . . #
//   # . # # #
//   # . . . #
//   # # # # #
Contour inverted_labyrinth_contour() {
  return grid_contour({5, 4, 3, 2, 2, 4, 1, 1, 4, 3, 5, 0, 0, 5});
}

// An open padlock: a body of 160 x 90 mm, and a shackle whose left leg ends 30 mm above the body.
// The bow is half a hexagon, inside and outside, so that its walls are as long as its radius: 52 mm
// outside and 26 mm inside, just above the minimum wall length. The body is wider than high to
// balance the walls: the mean angle to any line is between 43.3 and 46.7 deg. The contour is 0.894
// m long.
Contour lock_contour() {
  const double half_root3 = std::sqrt(3.0) / 2.0;
  const double bow = 50.0;  // y of the centre of the bow
  return {millimetres(80.0, -95.0),
          millimetres(80.0, -5.0),
          millimetres(52.0, -5.0),
          millimetres(52.0, bow),
          millimetres(26.0, bow + 52.0 * half_root3),
          millimetres(-26.0, bow + 52.0 * half_root3),
          millimetres(-52.0, bow),
          millimetres(-52.0, bow - 25.0),
          millimetres(-26.0, bow - 25.0),
          millimetres(-26.0, bow),
          millimetres(-13.0, bow + 26.0 * half_root3),
          millimetres(13.0, bow + 26.0 * half_root3),
          millimetres(26.0, bow),
          millimetres(26.0, -5.0),
          millimetres(-80.0, -5.0),
          millimetres(-80.0, -95.0)};
}

std::vector<PaperObject> paper_objects() {
  return {{"star", star_contour()},
          {"labyrinth", labyrinth_contour()},
          {"inverted_labyrinth", inverted_labyrinth_contour()},
          {"lock", lock_contour()}};
}

ContourRoute contour_route(const Contour& contour_m) {
  const Point2& from = contour_m[0];
  const Point2 wall = contour_m[1] - from;
  const double wall_m = std::sqrt(wall.x() * wall.x() + wall.y() * wall.y());
  const auto place = [&](double beyond_middle_m) {
    const double share = 0.5 + beyond_middle_m / wall_m;
    return Vec3(from.x() + share * wall.x(), from.y() + share * wall.y(), 0.0);
  };
  return {place(0.01), place(-0.01)};
}

double mean_contact_angle_rad(const Contour& contour_m, double orientation_rad) {
  const double c = std::cos(orientation_rad);
  const double s = std::sin(orientation_rad);
  double sum_m_rad = 0.0;
  double length_m = 0.0;
  for (std::size_t i = 0; i < contour_m.size(); ++i) {
    const Point2 wall = contour_m[(i + 1) % contour_m.size()] - contour_m[i];
    const double x = c * wall.x() - s * wall.y();
    const double y = s * wall.x() + c * wall.y();
    // The normal is (y, -x), so the angle of the normal to the x axis is the angle of the wall to
    // the y axis.
    const double wall_m = std::hypot(x, y);
    sum_m_rad += wall_m * std::atan2(std::abs(x), std::abs(y));
    length_m += wall_m;
  }
  return sum_m_rad / length_m;
}

}  // namespace palpate
