#include "haptics/proxy/plane_projection.h"

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;
using LongVec3 = Eigen::Matrix<long double, 3, 1>;

// Rounding of a solution relative to the target: that of its coordinates and of products with it.
constexpr double kRoundoff = 64 * std::numeric_limits<double>::epsilon();

LongVec3 wide(const Vec3& v) {
  return v.cast<long double>();
}

// The projection of the target onto the intersection of a few planes, by a linear system. Nullopt
// if the planes are dependent.
std::optional<LongVec3> on_all(std::span<const ContactPlane> planes, const LongVec3& target) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const auto count = static_cast<Eigen::Index>(planes.size());
  Matrix normals(count, 3);
  Matrix residual(count, 1);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ContactPlane& plane = planes[static_cast<std::size_t>(i)];
    normals.row(i) = wide(plane.normal).transpose();
    residual(i, 0) = static_cast<long double>(plane.offset_m) - wide(plane.normal).dot(target);
  }
  const Matrix gram = normals * normals.transpose();
  const Eigen::FullPivLU<Matrix> solver(gram);
  if (!solver.isInvertible()) return std::nullopt;
  return LongVec3(target + normals.transpose() * solver.solve(residual));
}

// The least distance from the target to a point that violates no plane, found by trying all sets of
// up to three planes.
long double least_distance(std::span<const ContactPlane> planes, const Vec3& target) {
  long double least = std::numeric_limits<long double>::infinity();
  const auto try_point = [&](const LongVec3& y) {
    for (const ContactPlane& plane : planes) {
      const long double slack = 1e-15L * (y.norm() + wide(target).norm());
      if (wide(plane.normal).dot(y) < static_cast<long double>(plane.offset_m) - slack) return;
    }
    least = std::min(least, (y - wide(target)).norm());
  };
  try_point(wide(target));
  const std::size_t n = planes.size();
  for (std::size_t set = 1; set < (std::size_t{1} << n); ++set) {
    std::vector<ContactPlane> chosen;
    for (std::size_t i = 0; i < n; ++i) {
      if (set >> i & 1) chosen.push_back(planes[i]);
    }
    if (chosen.size() > 3) continue;
    if (const auto y = on_all(chosen, wide(target))) try_point(*y);
  }
  return least;
}

double worst_violation(std::span<const ContactPlane> planes, const Vec3& y) {
  double worst = 0.0;
  for (const ContactPlane& plane : planes) {
    worst = std::max(worst, plane.offset_m - plane.normal.dot(y));
  }
  return worst;
}

TEST(PlaneProjection, IsTheNearestPointThatViolatesNoPlane) {
  Random random(41);
  for (int trial = 0; trial < 20000; ++trial) {
    std::vector<ContactPlane> planes(1 + random.index(6));
    for (ContactPlane& plane : planes) {
      plane = {random.unit_vector(), random.index(2) ? 0.0 : -random.uniform(0.0, 1.0)};
    }
    const Vec3 target = random.uniform(0.1, 10.0) * random.unit_vector();
    const PlaneProjection answer = project_onto_planes(planes, target);
    ASSERT_TRUE(answer.solved) << trial;
    ASSERT_LE(worst_violation(planes, answer.displacement_m), kRoundoff * target.norm()) << trial;
    const auto distance = static_cast<double>(least_distance(planes, target));
    ASSERT_NEAR((answer.displacement_m - target).norm(), distance, 1e-9 * target.norm()) << trial;
  }
}

// Adjacent faces, or a face and the edge of its neighbour, give planes that hardly differ, while a
// deep goal is far below them. The angles go down to the rounding of a normal.
// A slide that is much shorter than the depth gains less than the rounding of the squared distance
// to the goal.
TEST(PlaneProjection, PreciselyTakesASlideThatIsMuchShorterThanTheDepth) {
  Random random(1907);
  for (int n = 0; n < 20000; ++n) {
    const MotionPlane motion_plane(random.unit_vector());
    const bool is_planar = n % 2 == 0;
    Vec3 normal = random.unit_vector();
    if (is_planar) normal = motion_plane.part_of(normal).normalized();
    const Vec3 along =
        is_planar ? Vec3(motion_plane.normal().cross(normal)) : normal.unitOrthogonal();
    const double slide = std::pow(10.0, random.uniform(-13.0, -6.0));
    const double size = std::pow(10.0, random.uniform(-3.0, 3.0));
    const Vec3 target = size * (slide * along - normal);
    std::vector<ContactPlane> planes{{normal, 0.0}};
    // Another face beside the line of the slide makes the set of planes larger, or the basis.
    if (n % 4 == 1) planes.push_back({(normal + along.cross(normal)).normalized(), 0.0});
    if (n % 4 == 3) planes.push_back({(normal - 1e-3 * along.cross(normal)).normalized(), 0.0});
    const PlaneProjection y =
        is_planar ? project_within(motion_plane, planes, target, Feasibility::kAtStartPrecise)
                  : project_onto_planes(planes, target, Feasibility::kAtStartPrecise);
    ASSERT_TRUE(y.solved) << n;
    const LongVec3 exact = wide(target).dot(wide(along)) * wide(along);
    ASSERT_LE((wide(y.displacement_m) - exact).norm(), kRoundoff * size) << n << " " << slide;
  }
}

TEST(PlaneProjection, ViolatesNoneOfNearlyIdenticalPlanes) {
  Random random(42);
  for (int trial = 0; trial < 200000; ++trial) {
    const Vec3 normal = random.unit_vector();
    std::vector<ContactPlane> planes(2 + random.index(2));
    for (ContactPlane& plane : planes) {
      const double angle_rad = std::pow(10.0, random.uniform(-16.0, -5.0));
      const double offset_m = random.index(2) ? 0.0 : -std::pow(10.0, random.uniform(-14.0, -9.0));
      plane = {(normal + angle_rad * random.unit_vector()).normalized(), offset_m};
    }
    const double sideways = std::pow(10.0, random.uniform(-16.0, 1.0));
    const double depth_m = std::pow(10.0, random.uniform(-6.0, 3.0));
    const Vec3 target = depth_m * (sideways * random.unit_vector() - normal);
    const PlaneProjection answer = project_onto_planes(planes, target);
    ASSERT_TRUE(answer.solved) << trial;
    ASSERT_LE(worst_violation(planes, answer.displacement_m), kRoundoff * target.norm()) << trial;
  }
}

// The solver in two coordinates, against all pairs of lines in quadruple precision: two lines that
// differ by the rounding of a double meet at a point of which long double leaves three digits.
using Quad = boost::multiprecision::cpp_bin_float_quad;
using HalfPlane = HalfSpace<Vec2>;

// The rounding that a solution may have, relative to the lengths involved.
constexpr double kRounded = 32 * std::numeric_limits<double>::epsilon();

struct Quad2 {
  Quad x, y;
  explicit Quad2(const Vec2& v) : x(v.x()), y(v.y()) {}
  Quad2(const Quad& x_of, const Quad& y_of) : x(x_of), y(y_of) {}
  Quad dot(const Quad2& other) const { return x * other.x + y * other.y; }
  Quad norm() const { return sqrt(dot(*this)); }
  Quad distance(const Quad2& other) const { return Quad2(x - other.x, y - other.y).norm(); }
};

// The least distance from the target to a point that violates no line, of which each is moved by
// shift_m against the target (a positive shift makes it stricter); infinity if there is none. The
// nearest point is the target, or lies on one line, or on two.
Quad least_distance(std::span<const HalfPlane> lines, const Vec2& target, const Quad& shift_m) {
  const Quad slack = kRounded / 16;  // much more than the rounding of the meeting points here
  const Quad2 t(target);
  const Quad t_norm = t.norm();
  std::vector<std::pair<Quad2, Quad>> wide;
  for (const HalfPlane& line : lines) wide.push_back({Quad2(line.normal), line.offset_m + shift_m});
  Quad least = std::numeric_limits<Quad>::infinity();
  const auto try_point = [&](const Quad2& y) {
    const Quad length = abs(y.x) + abs(y.y) + t_norm;
    for (const auto& [normal, offset] : wide) {
      if (normal.dot(y) < offset - slack * (length + abs(offset))) return;
    }
    least = std::min(least, y.distance(t));
  };
  try_point(t);
  for (std::size_t i = 0; i < wide.size(); ++i) {
    const auto& [n, a] = wide[i];
    const Quad by = (a - n.dot(t)) / n.dot(n);
    try_point({t.x + by * n.x, t.y + by * n.y});
    for (std::size_t j = 0; j < i; ++j) {
      const auto& [m, b] = wide[j];
      const Quad sine = n.x * m.y - n.y * m.x;
      if (sine == 0) continue;
      try_point({(a * m.y - b * n.y) / sine, (b * n.x - a * m.x) / sine});
    }
  }
  return least;
}

// The length that determines the rounding of a problem.
double size_of(std::span<const HalfPlane> lines, const Vec2& target) {
  double size_m = target.norm();
  for (const HalfPlane& line : lines) size_m = std::max(size_m, std::abs(line.offset_m));
  return size_m;
}

// Lines around a displacement, in directions that are random, nearly equal or nearly opposite, with
// offsets that a body at rest (<= 0) or a moving body (any sign) gives.
std::vector<HalfPlane> some_lines(Random& random, bool is_at_start) {
  std::vector<HalfPlane> lines(1 + random.index(6));
  const auto direction = [](double angle_rad) {
    return Vec2(std::cos(angle_rad), std::sin(angle_rad));
  };
  double angle_rad = random.uniform(0.0, 6.28);
  const double size_m = std::pow(10.0, random.uniform(-12.0, 0.0));
  for (HalfPlane& line : lines) {
    switch (random.index(4)) {
      case 0:
        angle_rad = random.uniform(0.0, 6.28);
        break;
      case 1:
        angle_rad += std::pow(10.0, random.uniform(-17.0, 0.0));
        break;
      case 2:
        angle_rad += std::numbers::pi - std::pow(10.0, random.uniform(-17.0, 0.0));
        break;
      default:
        break;
    }
    line.normal = direction(angle_rad);
    line.offset_m = size_m * random.uniform(-1.0, is_at_start ? 0.0 : 1.0);
    if (random.index(4) == 0) line.offset_m = is_at_start ? 0.0 : size_m;
  }
  return lines;
}

// The definition of "solved": the displacement keeps all lines within the rounding of the
// displacement, the offsets and the target. A set of lines without a solution is not solved, even
// if rounding gives one far away.
TEST(PlaneProjection, InAPlaneIsTheNearestPointOfAllPairsOrNotSolved) {
  Random random(43);
  int solved = 0;
  int unsolved = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const bool is_at_start = random.index(2) == 0;
    const std::vector<HalfPlane> lines = some_lines(random, is_at_start);
    Vec2 target = Vec2::Zero();
    if (is_at_start)
      target = std::pow(10.0, random.uniform(-12.0, 2.0)) * random.unit_vector().head<2>();
    const auto start = is_at_start ? Feasibility::kAtStart : Feasibility::kMustMove;
    const auto answer = project_onto_planes(std::span<const HalfPlane>(lines), target, start);
    const double size_m = size_of(lines, target);
    if (answer.solved) {
      const Vec2& y = answer.displacement_m;
      ASSERT_LE(answer.active_count, 2);
      for (const HalfPlane& line : lines) {
        const Quad violation = line.offset_m - Quad2(line.normal).dot(Quad2(y));
        ASSERT_LE(violation, kRounded * (y.norm() + std::abs(line.offset_m) + target.norm()))
            << trial;
      }
      // What rounding of the lines cannot decide: y is neither nearer than if each line were laxer,
      // nor farther than if each were stricter.
      const double shift_m = 2 * kRounded * (y.norm() + size_m);
      const Quad distance = Quad2(y).distance(Quad2(target));
      ASSERT_GE(distance + shift_m, least_distance(lines, target, -shift_m)) << trial;
      ASSERT_LE(distance - shift_m, least_distance(lines, target, shift_m)) << trial;
      ++solved;
      continue;
    }
    // No solution exists, not even far away, that rounding would leave.
    ASSERT_FALSE(is_at_start) << trial;
    for (const double far : {1e1, 1e4, 1e7, 1e10}) {
      ASSERT_GT(least_distance(lines, target, 2 * kRounded * far * size_m), far * size_m) << trial;
    }
    ++unsolved;
  }
  EXPECT_GT(solved, 10000);
  EXPECT_GT(unsolved, 1000);
}

// Three planes that close on the proxy within its plane of motion leave no space there. Rounding,
// or an angle at which a face is nearly parallel to the plane of motion, turns their normals a
// little out of it. The planes then meet far away from the plane of motion, where the device cannot
// be.
TEST(PlaneProjection, IsNotSolvedIfTheMeetingPointIsOutsideOfThePlaneOfMotion) {
  Random random(44);
  for (int trial = 0; trial < 20000; ++trial) {
    const MotionPlane motion_plane(random.unit_vector());
    const double size_m = std::pow(10.0, random.uniform(-9.0, 0.0));
    const double first_rad = random.uniform(0.0, 2 * std::numbers::pi);
    std::vector<ContactPlane> planes;
    for (int i = 0; i < 3; ++i) {
      const double angle_rad = first_rad + i * 2.0 + random.uniform(-0.3, 0.3);
      const Vec3 within = motion_plane.to_solver({std::cos(angle_rad), std::sin(angle_rad)});
      const double lean = std::pow(10.0, random.uniform(-17.0, -8.0));
      planes.push_back(
          {(within + lean * random.unit_vector()).normalized(), size_m * random.uniform(0.1, 1.0)});
    }
    const PlaneProjection answer =
        project_within(motion_plane, planes, Vec3::Zero(), Feasibility::kMustMove);
    ASSERT_FALSE(answer.solved) << trial;
    ASSERT_TRUE(answer.displacement_m.isZero(0.0)) << trial;
  }
}

// The displacement within a tilted plane of motion keeps its planes, and needs no correction.
TEST(PlaneProjection, StaysWithinAPlaneOfMotion) {
  Random random(45);
  for (int trial = 0; trial < 20000; ++trial) {
    const Vec3 normal = random.unit_vector();
    const MotionPlane motion_plane(normal);
    const double size_m = std::pow(10.0, random.uniform(-9.0, 0.0));
    std::vector<ContactPlane> planes;
    for (std::size_t i = 0; i < 1 + random.index(6); ++i) {
      Vec3 face = random.unit_vector();
      if (random.index(2)) face = (normal + std::pow(10.0, random.uniform(-7.0, 0.0)) * face);
      const auto plane =
          within_plane({face.normalized(), size_m * random.uniform(-1.0, 0.2)}, motion_plane);
      if (plane) planes.push_back(*plane);
    }
    const PlaneProjection answer =
        project_within(motion_plane, planes, Vec3::Zero(), Feasibility::kMustMove);
    const Vec3& y = answer.displacement_m;
    ASSERT_LE(std::abs(normal.dot(y)), kRounded * y.norm()) << trial;
    for (const ContactPlane& plane : planes) {
      ASSERT_LE(std::abs(plane.normal.dot(normal)), kRounded) << trial;
      if (!answer.solved) continue;
      ASSERT_LE(plane.offset_m - plane.normal.dot(y),
                kRounded * (y.norm() + std::abs(plane.offset_m)))
          << trial;
    }
  }
}

// The definition of "solved" in three coordinates, for planes whose normals nearly lie in a plane
// or in a line.
TEST(PlaneProjection, IsSolvedOnlyIfTheDisplacementKeepsAllPlanes) {
  Random random(46);
  int solved = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    const bool is_at_start = random.index(2) == 0;
    const Vec3 flat = random.unit_vector();
    const double lean = std::pow(10.0, random.uniform(-17.0, 0.0));
    const double size_m = std::pow(10.0, random.uniform(-12.0, 0.0));
    std::vector<ContactPlane> planes(3 + random.index(3));
    Vec3 normal = random.unit_vector();
    for (ContactPlane& plane : planes) {
      if (random.index(2)) normal = random.unit_vector();
      const Vec3 within = normal - normal.dot(flat) * flat;
      plane.normal = (within.normalized() + lean * random.unit_vector()).normalized();
      plane.offset_m = size_m * random.uniform(-1.0, is_at_start ? 0.0 : 1.0);
    }
    Vec3 target = Vec3::Zero();
    if (is_at_start) target = std::pow(10.0, random.uniform(-12.0, 2.0)) * random.unit_vector();
    const PlaneProjection answer = project_onto_planes(
        planes, target, is_at_start ? Feasibility::kAtStart : Feasibility::kMustMove);
    if (!answer.solved) continue;
    ++solved;
    const Vec3& y = answer.displacement_m;
    for (const ContactPlane& plane : planes) {
      ASSERT_LE(plane.offset_m - plane.normal.dot(y),
                kRounded * (y.norm() + std::abs(plane.offset_m) + target.norm()))
          << trial;
    }
  }
  EXPECT_GT(solved, 100000);
}

}  // namespace
}  // namespace palpate
