#include "haptics/proxy/plane_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

}  // namespace
}  // namespace palpate
