#include "haptics/proxy/plane_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
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

// The solver in two coordinates, against all pairs of lines in long double.
using LongVec2 = Eigen::Matrix<long double, 2, 1>;
using Line = HalfSpace<Vec2>;

LongVec2 wide(const Vec2& v) {
  return v.cast<long double>();
}

// By how much y violates the worst line, beyond `slack` times the lengths involved.
long double worst_violation(std::span<const Line> lines, const LongVec2& y, long double slack) {
  long double worst = -std::numeric_limits<long double>::infinity();
  for (const Line& line : lines) {
    const auto offset = static_cast<long double>(line.offset_m);
    const long double allowed = slack * (y.norm() + std::abs(offset));
    worst = std::max(worst, offset - wide(line.normal).dot(y) - allowed);
  }
  return worst;
}

// The least distance from the target to a point that violates no line by more than `slack` times
// the lengths involved; infinity if there is none. The nearest point is the target, or lies on one
// line, or on two.
long double least_distance(std::span<const Line> lines, const Vec2& target, long double slack) {
  long double least = std::numeric_limits<long double>::infinity();
  const LongVec2 t = wide(target);
  const auto try_point = [&](const LongVec2& y) {
    if (worst_violation(lines, y, slack) <= 0.0L) least = std::min(least, (y - t).norm());
  };
  try_point(t);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const LongVec2 n = wide(lines[i].normal);
    const auto a = static_cast<long double>(lines[i].offset_m);
    try_point(t + (a - n.dot(t)) / n.squaredNorm() * n);
    for (std::size_t j = 0; j < i; ++j) {
      const LongVec2 m = wide(lines[j].normal);
      const auto b = static_cast<long double>(lines[j].offset_m);
      const long double sine = n.x() * m.y() - n.y() * m.x();
      if (sine == 0.0L) continue;
      try_point(LongVec2(a * m.y() - b * n.y(), b * n.x() - a * m.x()) / sine);
    }
  }
  return least;
}

// Lines around a displacement, in directions that are random, nearly equal or nearly opposite, with
// offsets that a body at rest (<= 0) or a moving body (any sign) gives.
std::vector<Line> some_lines(Random& random, bool is_at_start) {
  std::vector<Line> lines(1 + random.index(6));
  const auto direction = [](double angle_rad) {
    return Vec2(std::cos(angle_rad), std::sin(angle_rad));
  };
  double angle_rad = random.uniform(0.0, 6.28);
  const double size_m = std::pow(10.0, random.uniform(-12.0, 0.0));
  for (Line& line : lines) {
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
  constexpr double kUlp = std::numeric_limits<double>::epsilon();
  int solved = 0;
  int unsolvable = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    const bool is_at_start = random.index(2) == 0;
    const std::vector<Line> lines = some_lines(random, is_at_start);
    Vec2 target = Vec2::Zero();
    if (is_at_start) target = std::pow(10.0, random.uniform(-12.0, 2.0)) * random.unit_vector().head<2>();
    const auto start = is_at_start ? Feasibility::kAtStart : Feasibility::kMustMove;
    const auto answer = project_onto_planes(std::span<const Line>(lines), target, start);
    // What no rounding of the lines can decide: a solution exists even if each line is stricter, or
    // none exists even if each is laxer.
    const auto strictest = least_distance(lines, target, -64.0L * kUlp);
    const auto laxest = least_distance(lines, target, 64.0L * kUlp);
    if (answer.solved) {
      const LongVec2 y = wide(answer.displacement_m);
      const long double roundoff = 64.0L * kUlp * wide(target).norm();
      ASSERT_LE(worst_violation(lines, y, 32.0L * kUlp), roundoff) << trial;
      ASSERT_LE(answer.active_count, 2);
      const long double distance = (y - wide(target)).norm();
      ASSERT_GE(distance * (1.0L + 1e-9L) + roundoff, laxest) << trial;
      ASSERT_LE(distance * (1.0L - 1e-9L) - roundoff, strictest) << trial;
      ++solved;
    } else {
      // Lines that meet farther away than this are parallel to within rounding.
      const long double far = 1e-3L / kUlp;
      long double size = wide(target).norm();
      for (const Line& line : lines) size = std::max(size, std::abs(static_cast<long double>(line.offset_m)));
      ASSERT_GE(strictest, far * size) << trial;
      ++unsolvable;
    }
  }
  EXPECT_GT(solved, 50000);
  EXPECT_GT(unsolvable, 10000);
}

}  // namespace
}  // namespace palpate
