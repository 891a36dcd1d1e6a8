#pragma once

// Shapes that are hard for a god-object. Metres; each shape in a frame of its own.

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "models/paper_objects.h"
#include "models/primitives.h"
#include "tests/helpers/mesh_soup.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

inline constexpr double kDeg = std::numbers::pi / 180.0;  // rad

// One of the paper's four objects, with the dimensions of the models.
inline Soup paper_object_soup(const PaperObject& object) {
  const double half = 0.5 * kPaperObjectHeight_m;
  return soup_of(prism(object.contour_m, -half, half).value());
}

// A rectangle about the origin, z = 0, front up.
inline Soup sheet_soup(double half_x, double half_y) {
  Soup soup;
  soup.add_quad({-half_x, -half_y, 0}, {half_x, -half_y, 0}, {half_x, half_y, 0},
                {-half_x, half_y, 0});
  return soup;
}

// Two rectangles that meet in a ridge along x, with the solid below. solid_rad is the angle inside
// the solid; with more than 180 deg, the ridge is a valley.
inline Vec3 wedge_slope(double solid_rad, double side) {
  return {0.0, side * std::sin(0.5 * solid_rad), -std::cos(0.5 * solid_rad)};
}
inline Vec3 wedge_normal(double solid_rad, double side) {
  return {0.0, side * std::cos(0.5 * solid_rad), std::sin(0.5 * solid_rad)};
}
inline Soup wedge_soup(double solid_rad) {
  const Vec3 x = Vec3::UnitX();
  const Vec3 right = wedge_slope(solid_rad, 1.0);
  const Vec3 left = wedge_slope(solid_rad, -1.0);
  Soup soup;
  soup.add_quad(-x, -x + right, x + right, x);
  soup.add_quad(-x, x, x + left, -x + left);
  return soup;
}

// A fan of `valence` triangles about the origin. height(i) is the z of ring vertex i, whose
// distance from the axis is 1.
template <typename Height>
Soup fan_soup(int valence, Height height) {
  Soup soup;
  soup.positions.push_back(Vec3::Zero());
  for (int i = 0; i < valence; ++i) {
    const double angle = 2 * std::numbers::pi * i / valence;
    soup.positions.push_back({std::cos(angle), std::sin(angle), height(i)});
  }
  for (int i = 0; i < valence; ++i) {
    const auto a = static_cast<std::uint32_t>(1 + i);
    const auto b = static_cast<std::uint32_t>(1 + (i + 1) % valence);
    soup.triangles.push_back({0, a, b});
  }
  return soup;
}

// A pyramid with its apex at the origin. Its sides fall by `slope`; a fan closes it below.
inline Soup pyramid_soup(int valence, double slope) {
  Soup soup = fan_soup(valence, [slope](int) { return -slope; });
  const auto centre = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.push_back({0.0, 0.0, -slope});
  for (std::size_t i = 0; i < static_cast<std::size_t>(valence); ++i) {
    const Triangle side = soup.triangles[i];
    soup.triangles.push_back({centre, side[2], side[1]});
  }
  return soup;
}

// A square sheet made of rows of strips, with gaps between them. Every second row in y is shifted
// by half a strip, so that each corner of a strip lies in the middle of an edge of the next row (a
// T-junction, exact if gap_m = 0 and half is a power of two).
inline Soup tiled_sheet_soup(double half, int rows, int strips, double gap_m) {
  Soup soup;
  const double width = 2 * half / strips;
  const double height = 2 * half / rows;
  const double inset = 0.5 * gap_m;
  for (int row = 0; row < rows; ++row) {
    const double y0 = -half + row * height + inset;
    const double y1 = -half + (row + 1) * height - inset;
    for (int strip = 0; strip <= strips; ++strip) {
      const double left = -half + (strip - 0.5 * (row % 2)) * width;
      const double x0 = std::max(-half, left) + inset;
      const double x1 = std::min(half, left + width) - inset;
      if (x1 <= x0) continue;
      soup.add_quad({x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0});
    }
  }
  return soup;
}

// A strip in the plane z = 0, front up, from x = -half to half and from y0 to y1. It consists of a
// fan of `count` slivers, which share the corner (half, y1) and have bases of length half * 1e-8,
// and of two larger triangles.
inline void add_sliver_fan(Soup& soup, double half, double y0, double y1, int count) {
  const Vec3 tip(half, y1, 0);
  const auto base = [&](int i) { return Vec3(-half + i * half * 1e-8, y0, 0); };
  soup.add(Vec3(-half, y0, 0), tip, Vec3(-half, y1, 0));
  for (int i = 0; i < count; ++i) soup.add(base(i), base(i + 1), tip);
  soup.add(base(count), Vec3(half, y0, 0), tip);
}

}  // namespace palpate::test
