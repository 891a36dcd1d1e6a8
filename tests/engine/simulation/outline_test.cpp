// The parts that a hand can reach of curves that overlap.

#include "engine/simulation/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kSmall_m = 1e-3;

std::vector<Outline> outlines_of(const std::vector<Polyline>& curves, const Vec3& plane_normal,
                                 double small_m) {
  auto found = outlines(curves, plane_normal, small_m);
  EXPECT_TRUE(found) << "gave up";
  return found ? std::move(*found) : std::vector<Outline>();
}

struct Rectangle {
  double x, y, half_x, half_y;

  bool holds(double px, double py, double within) const {
    return std::abs(px - x) < half_x - within && std::abs(py - y) < half_y - within;
  }
};

// Material on the left; in the plane z = 0 after the rotation.
Polyline curve_of(const Rectangle& r, const Quat& rotation = Quat::Identity()) {
  Polyline curve;
  curve.closed = true;
  for (const auto& [sx, sy] :
       std::array<std::pair<int, int>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
    curve.points_m.push_back(rotation * Vec3(r.x + sx * r.half_x, r.y + sy * r.half_y, 0.0));
  }
  return curve;
}

std::vector<Polyline> crossing_bars(Random& random, int count) {
  std::vector<Polyline> bars;
  for (int i = 0; i < count; ++i) {
    const double angle_rad = random.uniform(0.0, std::numbers::pi);
    const Quat turn(Eigen::AngleAxisd(angle_rad, Vec3::UnitZ()));
    bars.push_back(curve_of({0, 0, 0.05, 0.0005}, turn));
    const Vec3 at(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), 0.0);
    for (Vec3& p : bars.back().points_m) p += at;
  }
  return bars;
}

// Pieces hardly longer than the merging distance, three of which form a triangle, are cut only
// once.
TEST(Outlines, AreFoundForBarsThatCrossHundredsOfOthers) {
  Random random(8202);
  for (const int count : {20, 200, 300}) {
    const auto found = outlines_of(crossing_bars(random, count), Vec3::UnitZ(), kSmall_m);
    ASSERT_FALSE(found.empty());
    for (const Outline& outline : found) EXPECT_TRUE(outline.curve.closed);
  }
}

TEST(Outlines, AreNotComputedForCurvesThatCrossTooManyOthers) {
  Random random(8203);
  EXPECT_FALSE(outlines(crossing_bars(random, 2000), Vec3::UnitZ(), kSmall_m));
}

TEST(Outlines, OfOverlappingCurvesAreTheOutlineOfTheirUnion) {
  Random random(8201);
  for (int i = 0; i < 50; ++i) {
    const Quat rotation = random.rotation();
    const Vec3 normal = rotation * Vec3::UnitZ();
    // A cross, and a bar across the end of another.
    const auto cross =
        outlines_of({curve_of({0, 0, 0.1, 0.02}, rotation), curve_of({0, 0, 0.03, 0.08}, rotation)},
                    normal, kSmall_m);
    ASSERT_EQ(cross.size(), 1u);
    EXPECT_TRUE(cross[0].curve.closed);
    EXPECT_FALSE(cross[0].has_two_sides);
    EXPECT_NEAR(length_m(cross[0].curve), 4 * (0.1 + 0.08), 1e-8);
    const auto tee = outlines_of(
        {curve_of({0, 0, 0.1, 0.02}, rotation), curve_of({0.1, 0, 0.01, 0.05}, rotation)}, normal,
        kSmall_m);
    ASSERT_EQ(tee.size(), 1u);
    EXPECT_NEAR(length_m(tee[0].curve), 2 * (0.21 + 0.1), 1e-8);
  }
}

TEST(Outlines, LeaveOutInnerCurvesAndKeepTheRestToTheBit) {
  const Polyline outer = curve_of({0, 0, 0.1, 0.1});
  const Polyline inner = curve_of({0.02, 0, 0.05, 0.05});
  const Polyline apart = curve_of({0.5, 0, 0.05, 0.05});
  Polyline cavity = curve_of({0, 0, 0.08, 0.08});
  std::reverse(cavity.points_m.begin(), cavity.points_m.end());
  const auto solid = outlines_of({outer, inner, apart}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(solid.size(), 2u);
  EXPECT_EQ(solid[0].curve.points_m, outer.points_m);
  EXPECT_EQ(solid[1].curve.points_m, apart.points_m);
  // Curves in a cavity are not hidden.
  EXPECT_EQ(outlines_of({outer, cavity, inner}, Vec3::UnitZ(), kSmall_m).size(), 3u);
}

TEST(Outlines, OfASheetHaveTwoSidesAndEndWhereItEntersASolid) {
  const Polyline sheet{{Vec3(0, 0, 0), Vec3(0.3, 0, 0)}, false};
  const auto alone = outlines_of({sheet}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(alone.size(), 1u);
  EXPECT_TRUE(alone[0].has_two_sides);
  EXPECT_EQ(alone[0].curve.points_m, sheet.points_m);
  const auto stuck = outlines_of({curve_of({0, 0, 0.1, 0.005}), sheet}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(stuck.size(), 2u);
  const auto out =
      std::find_if(stuck.begin(), stuck.end(), [](const Outline& o) { return o.has_two_sides; });
  ASSERT_NE(out, stuck.end());
  EXPECT_NEAR(length_m(out->curve), 0.2, 1e-8);
}

// A shell without a bottom stands on a box: their outline covers both. A part in front of a bent
// sheet, in a bowl, is not hidden.
TEST(Outlines, TreatAShellAsTheSolidBehindIt) {
  const Polyline shell{
      {Vec3(0.05, 0.1, 0), Vec3(0.05, 0.15, 0), Vec3(-0.05, 0.15, 0), Vec3(-0.05, 0.1, 0)}, false};
  const auto found = outlines_of({curve_of({0, 0, 0.1, 0.1001}), shell}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].curve.closed);
  EXPECT_NEAR(length_m(found[0].curve), 0.8 + 2 * 0.05, 1e-3);
  const Polyline bowl{{Vec3(0.1, 0.1, 0), Vec3(0.1, 0, 0), Vec3(-0.1, 0, 0), Vec3(-0.1, 0.1, 0)},
                      false};
  const auto spoon = outlines_of({bowl, curve_of({0, 0.05, 0.02, 0.02})}, Vec3::UnitZ(), kSmall_m);
  EXPECT_EQ(spoon.size(), 2u);
}

// Compared with separate tests of places on every side.
TEST(Outlines, ContainExactlyThePartsOutsideAllSolids) {
  Random random(8202);
  for (int i = 0; i < 100; ++i) {
    std::vector<Rectangle> rectangles;
    std::vector<Polyline> curves;
    for (int k = 0; k < 6; ++k) {
      rectangles.push_back({random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1),
                            random.uniform(0.02, 0.08), random.uniform(0.02, 0.08)});
      curves.push_back(curve_of(rectangles.back()));
    }
    const auto is_hidden = [&](const Vec3& p, double within) {
      return std::any_of(rectangles.begin(), rectangles.end(),
                         [&](const Rectangle& r) { return r.holds(p.x(), p.y(), within); });
    };
    double free_m = 0.0;
    for (const Polyline& curve : curves) {
      constexpr int kSteps = 4000;
      for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 way = curve.points_m[(k + 1) % 4] - curve.points_m[k];
        for (int n = 0; n < kSteps; ++n) {
          if (!is_hidden(curve.points_m[k] + (n + 0.5) / kSteps * way, 1e-9))
            free_m += way.norm() / kSteps;
        }
      }
    }
    double found_m = 0.0;
    for (const Outline& outline : outlines_of(curves, Vec3::UnitZ(), kSmall_m)) {
      found_m += length_m(outline.curve);
      EXPECT_TRUE(outline.curve.closed);
      for (const Vec3& p : outline.curve.points_m) EXPECT_FALSE(is_hidden(p, kSmall_m));
    }
    EXPECT_NEAR(found_m, free_m, 20 * kSmall_m) << i;
  }
}

// The plane and unit of a test: all transforms that a scene's points undergo.
struct LaidPlane {
  RigidTransform pose;
  double size;
  bool is_single;  // points are rounded to single precision, as in glTF

  Vec3 point(double x, double y) const {
    const Vec3 p = pose.point(size * Vec3(x, y, 0.0));
    return is_single ? Vec3(p.cast<float>().cast<double>()) : p;
  }
  Vec3 normal() const { return pose.direction(Vec3::UnitZ()); }
};

// For points within a few units of a lattice; the translation is of the same size.
LaidPlane lay_plane(Random& random, double extent) {
  const double size = std::pow(10.0, random.uniform(-3.0, 3.0));
  return {{random.rotation(), size * random.in_box(extent)}, size, random.index(2) == 0};
}

// Rectangles on a lattice, as cells with their winding numbers.
constexpr int kCells = 14;
struct Lattice {
  std::array<std::array<int, kCells>, kCells> winding{};
  std::vector<Polyline> curves;

  void add(int x0, int y0, int x1, int y1, int turns, const LaidPlane& placed) {
    Polyline curve{
        {placed.point(x0, y0), placed.point(x1, y0), placed.point(x1, y1), placed.point(x0, y1)},
        true};
    if (turns < 0) std::reverse(curve.points_m.begin(), curve.points_m.end());
    curves.push_back(std::move(curve));
    for (int x = x0; x < x1; ++x) {
      for (int y = y0; y < y1; ++y) winding[x][y] += turns;
    }
  }
  // Cells around the lattice are free.
  bool is_solid(int x, int y) const {
    return x >= 0 && y >= 0 && x < kCells && y < kCells && winding[x][y] > 0;
  }
};

// Solids and hollow solids that overlap, coincide, and touch along faces, edges and corners.
Lattice random_lattice(Random& random, const LaidPlane& placed) {
  Lattice lattice;
  const auto between = [&](int low, int high) {
    return low + static_cast<int>(random.index(static_cast<std::size_t>(high - low + 1)));
  };
  for (std::size_t k = 0; k < 2 + random.index(9); ++k) {
    const int x0 = between(0, kCells - 2);
    const int y0 = between(0, kCells - 2);
    const int x1 = std::min(kCells, x0 + between(1, 6));
    const int y1 = std::min(kCells, y0 + between(1, 6));
    lattice.add(x0, y0, x1, y1, 1, placed);
    if (x1 - x0 > 2 && y1 - y0 > 2 && random.index(3) == 0) {
      lattice.add(x0 + 1, y0 + 1, x1 - 1, y1 - 1, -1, placed);
    }
  }
  return lattice;
}

// The component number of each cell. Free cells are connected by their sides only, because a point
// does not pass between two solids that touch in a corner; solid cells are also connected by
// corners.
std::map<std::pair<int, int>, int> components(const Lattice& lattice) {
  std::map<std::pair<int, int>, int> component;
  int count = 0;
  for (int x = -1; x <= kCells; ++x) {
    for (int y = -1; y <= kCells; ++y) {
      if (component.count({x, y})) continue;
      std::vector<std::pair<int, int>> open = {{x, y}};
      component[{x, y}] = count;
      const bool solid = lattice.is_solid(x, y);
      while (!open.empty()) {
        const auto [cx, cy] = open.back();
        open.pop_back();
        for (int dx = -1; dx <= 1; ++dx) {
          for (int dy = -1; dy <= 1; ++dy) {
            const std::pair<int, int> next{cx + dx, cy + dy};
            if (next.first < -1 || next.second < -1 || next.first > kCells ||
                next.second > kCells || (!solid && dx != 0 && dy != 0) ||
                lattice.is_solid(next.first, next.second) != solid || component.count(next)) {
              continue;
            }
            component[next] = count;
            open.push_back(next);
          }
        }
      }
      ++count;
    }
  }
  return component;
}

// Each pair of a free and a solid component that touch has one loop.
std::vector<double> loops_of(const Lattice& lattice) {
  const auto component = components(lattice);
  std::map<std::pair<int, int>, double> length;
  for (const auto& [cell, number] : component) {
    if (!lattice.is_solid(cell.first, cell.second)) continue;
    for (const auto& [dx, dy] :
         std::array<std::pair<int, int>, 4>{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}}) {
      const std::pair<int, int> next{cell.first + dx, cell.second + dy};
      if (!lattice.is_solid(next.first, next.second)) {
        length[{component.at(next), number}] += 1.0;
      }
    }
  }
  std::vector<double> loops;
  for (const auto& [pair, sum] : length) loops.push_back(sum);
  std::sort(loops.rbegin(), loops.rend());
  return loops;
}

// Compared with the cells: their solidity and connectivity.
TEST(Outlines, OfTouchingSolidsBoundTheFreeRegions) {
  Random random(8203);
  for (int i = 0; i < 1500; ++i) {
    const LaidPlane placed = lay_plane(random, kCells);
    const Lattice lattice = random_lattice(random, placed);
    const std::vector<double> expected = loops_of(lattice);
    const auto found = outlines_of(lattice.curves, placed.normal(), kSmall_m);
    ASSERT_EQ(found.size(), expected.size()) << i;
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_TRUE(found[k].curve.closed) << i;
      EXPECT_FALSE(found[k].has_two_sides);
      EXPECT_NEAR(length_m(found[k].curve) / placed.size, expected[k], 1e-3) << i;
    }
  }
}

struct Polygon {
  std::vector<Eigen::Vector2d> corners;  // convex, counter-clockwise

  bool holds(const Eigen::Vector2d& p) const {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d way = corners[(i + 1) % corners.size()] - corners[i];
      const Eigen::Vector2d to_p = p - corners[i];
      if (way.x() * to_p.y() - way.y() * to_p.x() < 0.0) return false;
    }
    return true;
  }
};

Polygon random_polygon(Random& random) {
  Polygon polygon;
  const Eigen::Vector2d middle(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
  const double radius = random.uniform(0.1, 1.0);
  const double flat = std::pow(10.0, random.uniform(-2.0, 0.0));
  const Eigen::Rotation2Dd turned(random.uniform(0.0, 7.0));
  const std::size_t count = 3 + random.index(6);
  for (std::size_t k = 0; k < count; ++k) {
    const double angle = 2.0 * M_PI * (static_cast<double>(k) + random.uniform(0.0, 0.7)) /
                         static_cast<double>(count);
    polygon.corners.push_back(
        middle + radius * (turned * Eigen::Vector2d(std::cos(angle), flat * std::sin(angle))));
  }
  return polygon;
}

// The length of the sides outside all other polygons, cut at every intersection.
double free_length(const std::vector<Polygon>& polygons) {
  double free = 0.0;
  for (std::size_t p = 0; p < polygons.size(); ++p) {
    const auto& corners = polygons[p].corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d a = corners[i];
      const Eigen::Vector2d way = corners[(i + 1) % corners.size()] - a;
      std::vector<double> cuts = {0.0, 1.0};
      for (const Polygon& other : polygons) {
        for (std::size_t k = 0; k < other.corners.size(); ++k) {
          const Eigen::Vector2d c = other.corners[k] - a;
          const Eigen::Vector2d d = other.corners[(k + 1) % other.corners.size()] - a - c;
          const double det = way.x() * d.y() - way.y() * d.x();
          const double at = (c.x() * d.y() - c.y() * d.x()) / det;
          if (at > 0.0 && at < 1.0) cuts.push_back(at);
        }
      }
      std::sort(cuts.begin(), cuts.end());
      for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
        const Eigen::Vector2d middle = a + 0.5 * (cuts[k] + cuts[k + 1]) * way;
        bool is_free = true;
        for (std::size_t o = 0; o < polygons.size(); ++o) {
          is_free = is_free && (o == p || !polygons[o].holds(middle));
        }
        if (is_free) free += (cuts[k + 1] - cuts[k]) * way.norm();
      }
    }
  }
  return free;
}

// At scales at which the detail that a hand ignores is everything or nothing.
TEST(Outlines, SeparateSolidFromFreeCompletely) {
  Random random(8204);
  for (int i = 0; i < 1000; ++i) {
    const LaidPlane placed = lay_plane(random, 2.0);
    std::vector<Polygon> polygons;
    std::vector<Polyline> curves;
    for (std::size_t k = 0; k < 1 + random.index(10); ++k) {
      polygons.push_back(random_polygon(random));
      Polyline curve{{}, true};
      for (const auto& c : polygons.back().corners) {
        curve.points_m.push_back(placed.point(c.x(), c.y()));
      }
      curves.push_back(std::move(curve));
    }
    const auto holds = [&](const Eigen::Vector2d& p) {
      return std::any_of(polygons.begin(), polygons.end(),
                         [&](const Polygon& polygon) { return polygon.holds(p); });
    };
    double found = 0.0;
    for (const Outline& outline : outlines_of(curves, placed.normal(), kSmall_m)) {
      ASSERT_TRUE(outline.curve.closed) << i;
      found += length_m(outline.curve) / placed.size;
      const auto& points = outline.curve.points_m;
      for (std::size_t k = 0; k < points.size(); ++k) {
        const auto flat = [&](const Vec3& p) -> Eigen::Vector2d {
          return placed.pose.inverse_point(p).head<2>() / placed.size;
        };
        const Eigen::Vector2d a = flat(points[k]);
        const Eigen::Vector2d way = flat(points[(k + 1) % points.size()]) - a;
        if (way.norm() < 1e-2) continue;  // in a wedge the other side may be equally near
        const Eigen::Vector2d right = 1e-5 * Eigen::Vector2d(way.y(), -way.x()).normalized();
        EXPECT_FALSE(holds(a + 0.5 * way + right)) << i;
        EXPECT_TRUE(holds(a + 0.5 * way - right)) << i;
      }
    }
    EXPECT_NEAR(found, free_length(polygons), 1e-3) << i;
  }
}

// The gap is narrower than the joining distance, but curves that meet are joined first.
TEST(Outlines, DoNotJoinANearEndInsteadOfTheEnteredCurve) {
  const double thin = 4e-4;
  const auto found =
      outlines_of({curve_of({0, 0, 0.05, 0.05}), curve_of({0.06, 0, 0.04, 0.5 * thin})},
                  Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(length_m(found[0].curve), 0.4 + 2 * 0.05, 0x1p-20 * 0.2);
}

// Separately drawn walls that do not quite meet.
TEST(Outlines, JoinTheNearestOpenEndsFirst) {
  const double gap = 0.3 * kSmall_m;
  const Polyline first{{Vec3(0, 0, 0), Vec3(0.1, 0, 0)}, false};
  const Polyline second{{Vec3(0.1 + gap, 0, 0), Vec3(0.1 + gap, 0.1, 0)}, false};
  const Polyline farther{{Vec3(0.1 + 2 * gap, -gap, 0), Vec3(0.3, 0, 0)}, false};
  const auto found = outlines_of({first, farther, second}, Vec3::UnitZ(), kSmall_m);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(length_m(found[0].curve), 0.2 + gap, 1e-12);
}

}  // namespace
}  // namespace palpate
