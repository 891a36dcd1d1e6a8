#include "models/primitives.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace palpate {
namespace {

Vec3 to_floats(const Vec3& p) {
  return {to_float(p.x()), to_float(p.y()), to_float(p.z())};
}

// Written out, so that the last bit does not depend on a library's order of summation.
Vec3 unit(const Vec3& v) {
  const double length = std::sqrt(v.x() * v.x() + v.y() * v.y() + v.z() * v.z());
  return {v.x() / length, v.y() / length, v.z() / length};
}

TriangleMesh icosahedron() {
  const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
  std::vector<Vec3> corners;  // edges of length 2
  for (const double one : {-1.0, 1.0}) {
    for (const double phi : {-golden, golden}) {
      corners.insert(corners.end(), {{0.0, one, phi}, {one, phi, 0.0}, {phi, 0.0, one}});
    }
  }
  // Distances between corners are 2 (edges) and at least 2 golden = 3.2 (diagonals).
  const auto joined = [&](std::uint32_t a, std::uint32_t b) {
    return (corners[a] - corners[b]).norm() < 3.0;
  };
  TriangleMesh mesh;
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = a + 1; b < 12; ++b) {
      for (std::uint32_t c = b + 1; c < 12; ++c) {
        if (!joined(a, b) || !joined(b, c) || !joined(c, a)) continue;
        const bool outward = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
        mesh.triangles.push_back(outward ? Triangle{a, b, c} : Triangle{a, c, b});
      }
    }
  }
  for (const Vec3& corner : corners) mesh.positions_m.push_back(unit(corner));
  return mesh;
}

// Splits every triangle of a mesh on the unit sphere into four.
void subdivide(TriangleMesh& mesh) {
  const std::size_t edge_count = mesh.triangles.size() / 2 * 3;
  std::unordered_map<std::uint64_t, std::uint32_t> middles;
  middles.reserve(edge_count);
  mesh.positions_m.reserve(mesh.positions_m.size() + edge_count);
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto next = static_cast<std::uint32_t>(mesh.positions_m.size());
    const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    const auto [entry, is_new] = middles.try_emplace(key, next);
    if (is_new) {
      const Vec3 sum = mesh.positions_m[a] + mesh.positions_m[b];
      mesh.positions_m.push_back(unit(sum));
    }
    return entry->second;
  };
  std::vector<Triangle> split;
  split.reserve(4 * mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t ab = middle(a, b);
    const std::uint32_t bc = middle(b, c);
    const std::uint32_t ca = middle(c, a);
    split.insert(split.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  mesh.triangles = std::move(split);
}

// In double: coordinates are not rounded to float yet.
TriangleMesh unit_icosphere(int subdivisions) {
  assert(subdivisions >= 0 && subdivisions <= 12);
  TriangleMesh mesh = icosahedron();
  for (int level = 0; level < subdivisions; ++level) subdivide(mesh);
  return mesh;
}

double chebyshev(int degree, double x) {
  double previous = 1.0;
  double current = x;
  for (int n = 1; n < degree; ++n) {
    previous = std::exchange(current, 2.0 * x * current - previous);
  }
  return current;
}

// 4 * 2^doublings points, counter-clockwise from (1, 0). Unlike sin and cos, bisecting arcs keeps
// the points on the axes exact and gives the same result on every platform.
std::vector<Point2> unit_circle(int doublings) {
  std::vector<Point2> circle = {{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}};
  for (int level = 0; level < doublings; ++level) {
    std::vector<Point2> finer;
    for (std::size_t i = 0; i < circle.size(); ++i) {
      const Point2& here = circle[i];
      const Point2 sum = here + circle[(i + 1) % circle.size()];
      const double length = std::sqrt(sum.x() * sum.x() + sum.y() * sum.y());
      finer.push_back(here);
      finer.emplace_back(sum.x() / length, sum.y() / length);
    }
    circle = std::move(finer);
  }
  return circle;
}

// The exact sign of a sum, unless an operation underflows: Shewchuk, Adaptive Precision
// Floating-Point Arithmetic and Fast Robust Geometric Predicates (1997), Grow-Expansion.
int sign_of_sum(const std::array<double, 6>& terms) {
  std::array<double, 6> parts{};  // sum of the terms so far: nonoverlapping, ascending
  for (std::size_t count = 0; count < terms.size(); ++count) {
    double carry = terms[count];
    for (std::size_t i = 0; i < count; ++i) {
      const double sum = carry + parts[i];
      const double taken = sum - carry;
      parts[i] = (carry - (sum - taken)) + (parts[i] - taken);
      carry = sum;
    }
    parts[count] = carry;
  }
  const auto largest =
      std::find_if(parts.rbegin(), parts.rend(), [](double p) { return p != 0.0; });
  if (largest == parts.rend()) return 0;
  return *largest > 0.0 ? 1 : -1;
}

// +1 if a, b, c turn left, -1 if they turn right, 0 if they lie on one line. Exact for float
// values, because their products are exact in double.
int turn(const Point2& a, const Point2& b, const Point2& c) {
  return sign_of_sum({a.x() * b.y(), -a.y() * b.x(), b.x() * c.y(), -b.y() * c.x(), c.x() * a.y(),
                      -c.y() * a.x()});
}

bool lexicographically_less(const Point2& a, const Point2& b) {
  return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
}

// Whether p, known to lie on the line through a and b, lies between them, ends included.
bool between(const Point2& p, const Point2& a, const Point2& b) {
  const auto [low, high] = std::minmax(a, b, lexicographically_less);
  return !lexicographically_less(p, low) && !lexicographically_less(high, p);
}

// Whether the closed segments ab and cd have a common point.
bool touch(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const int abc = turn(a, b, c);
  const int abd = turn(a, b, d);
  const int cda = turn(c, d, a);
  const int cdb = turn(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && between(c, a, b)) || (abd == 0 && between(d, a, b)) ||
         (cda == 0 && between(a, c, d)) || (cdb == 0 && between(b, c, d));
}

// Whether no two walls have a common point, except the shared corner of neighbours. The test of
// walls that are not neighbours also detects a repeated vertex or a wall folded back on its
// neighbour, through the adjacent walls. A triangle has no such walls, but a triangle without area
// fails the test for counter-clockwise order.
bool is_simple(const Contour& contour) {
  const std::size_t n = contour.size();
  const auto corner = [&](std::size_t i) { return contour[i % n]; };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      const bool neighbours = (j + 1) % n == i;
      if (!neighbours && touch(corner(i), corner(i + 1), corner(j), corner(j + 1))) return false;
    }
  }
  return true;
}

// A simple polygon is counter-clockwise if it turns left at its lexicographically smallest vertex,
// which is never flat.
bool is_counter_clockwise(const Contour& contour) {
  const std::size_t n = contour.size();
  const auto least = std::min_element(contour.begin(), contour.end(), lexicographically_less);
  const auto i = static_cast<std::size_t>(least - contour.begin());
  return turn(contour[(i + n - 1) % n], contour[i], contour[(i + 1) % n]) > 0;
}

// Whether corner k of the remaining polygon is an ear: the corner is convex, and no other remaining
// vertex lies in its triangle, boundary included.
bool is_ear(const Contour& contour, const std::vector<std::uint32_t>& remaining, std::size_t k) {
  const std::size_t n = remaining.size();
  const Point2& a = contour[remaining[(k + n - 1) % n]];
  const Point2& b = contour[remaining[k]];
  const Point2& c = contour[remaining[(k + 1) % n]];
  if (turn(a, b, c) <= 0) return false;
  for (std::size_t skip = 2; skip + 1 < n; ++skip) {
    const Point2& p = contour[remaining[(k + skip) % n]];
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

// The n - 2 triangles of a simple counter-clockwise polygon. The ear with the shortest cut is
// removed first, so that slivers are rare. A simple polygon always has an ear (Meisters 1975), and
// the polygon without the ear is simple too.
std::vector<Triangle> clip_ears(const Contour& contour) {
  std::vector<std::uint32_t> remaining;
  for (std::uint32_t i = 0; i < contour.size(); ++i) remaining.push_back(i);
  std::vector<Triangle> triangles;
  while (remaining.size() >= 3) {
    const std::size_t n = remaining.size();
    std::size_t best = n;
    double shortest_squared_m2 = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      if (!is_ear(contour, remaining, k)) continue;
      const Point2 cut = contour[remaining[(k + 1) % n]] - contour[remaining[(k + n - 1) % n]];
      const double squared_m2 = cut.x() * cut.x() + cut.y() * cut.y();
      if (best == n || squared_m2 < shortest_squared_m2) {
        best = k;
        shortest_squared_m2 = squared_m2;
      }
    }
    assert(best < n);
    triangles.push_back(
        {remaining[(best + n - 1) % n], remaining[best], remaining[(best + 1) % n]});
    remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return triangles;
}

}  // namespace

TriangleMesh icosphere(int subdivisions, double radius_m) {
  assert(radius_m > 0.0);
  TriangleMesh mesh = unit_icosphere(subdivisions);
  for (Vec3& p : mesh.positions_m) p = to_floats(Vec3(radius_m * p));
  return mesh;
}

TriangleMesh bumpy_sphere(int subdivisions, double radius_m, double bump_height_m, int waves) {
  assert(bump_height_m >= 0.0 && radius_m > bump_height_m && waves >= 1);
  TriangleMesh mesh = unit_icosphere(subdivisions);
  for (Vec3& p : mesh.positions_m) {
    const double bump = chebyshev(waves, p.x()) * chebyshev(waves, p.y()) * chebyshev(waves, p.z());
    p = to_floats(Vec3((radius_m + bump_height_m * bump) * p));
  }
  return mesh;
}

TriangleMesh box(const Vec3& size_m) {
  assert(size_m.minCoeff() > 0.0);
  TriangleMesh mesh;
  for (unsigned corner = 0; corner < 8; ++corner) {  // bit k set: the high side of axis k
    const auto side = [&](unsigned axis) { return (corner >> axis & 1u) != 0 ? 0.5 : -0.5; };
    const Vec3 p(side(0) * size_m.x(), side(1) * size_m.y(), side(2) * size_m.z());
    mesh.positions_m.push_back(to_floats(p));
  }
  for (unsigned axis = 0; axis < 3; ++axis) {
    const std::uint32_t u = 1u << (axis + 1) % 3;  // u, v and the axis: a right-handed frame
    const std::uint32_t v = 1u << (axis + 2) % 3;
    const std::uint32_t high = 1u << axis;
    mesh.triangles.insert(mesh.triangles.end(), {{high, high + u, high + u + v},
                                                 {high, high + u + v, high + v},
                                                 {0, u + v, u},
                                                 {0, v, u + v}});
  }
  return mesh;
}

TriangleMesh torus(double major_radius_m, double minor_radius_m, int subdivisions) {
  assert(minor_radius_m > 0.0 && major_radius_m > minor_radius_m);
  assert(subdivisions >= 0 && subdivisions <= 10);
  const std::vector<Point2> ring = unit_circle(subdivisions + 1);
  const std::vector<Point2> tube = unit_circle(subdivisions);
  const auto vertex = [&](std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>(i % ring.size() * tube.size() + j % tube.size());
  };
  TriangleMesh mesh;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    for (std::size_t j = 0; j < tube.size(); ++j) {
      const double from_axis_m = major_radius_m + minor_radius_m * tube[j].x();
      const Vec3 p(from_axis_m * ring[i].x(), from_axis_m * ring[i].y(),
                   minor_radius_m * tube[j].y());
      mesh.positions_m.push_back(to_floats(p));
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  return mesh;
}

Result<TriangleMesh> prism(const Contour& contour_m, double z_low_m, double z_high_m) {
  const auto invalid = [](const char* problem) {
    return Error{ErrorCode::kInvalidArgument, "", "prism", problem, ""};
  };
  Contour contour;
  for (const Point2& p : contour_m) contour.emplace_back(to_float(p.x()), to_float(p.y()));
  const double low_m = to_float(z_low_m);
  const double high_m = to_float(z_high_m);
  const bool finite = std::isfinite(low_m) && std::isfinite(high_m) &&
                      std::all_of(contour.begin(), contour.end(), [](const Point2& p) {
                        return std::isfinite(p.x()) && std::isfinite(p.y());
                      });
  if (!finite) return invalid("a coordinate is not a finite float");
  if (!(low_m < high_m)) return invalid("z_high_m is not above z_low_m");
  if (contour.size() < 3) return invalid("the contour has fewer than three vertices");
  if (!is_simple(contour)) return invalid("the contour touches or crosses itself");
  if (!is_counter_clockwise(contour)) return invalid("the contour runs clockwise");

  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(contour.size());
  for (const double z_m : {low_m, high_m}) {
    for (const Point2& p : contour) mesh.positions_m.emplace_back(p.x(), p.y(), z_m);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.triangles.push_back({i, next, n + next});
    mesh.triangles.push_back({i, n + next, n + i});
  }
  for (const auto& [a, b, c] : clip_ears(contour)) {
    mesh.triangles.push_back({c, b, a});
    mesh.triangles.push_back({n + a, n + b, n + c});
  }
  return mesh;
}

}  // namespace palpate
