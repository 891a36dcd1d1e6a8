// On meshes that approximate curved shapes, the proxy converges to the exact result for the shape.

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/proxy/god_object.h"
#include "models/primitives.h"
#include "tests/helpers/made.h"
#include "tests/helpers/mesh_soup.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::OwnedWorld;
using test::Random;
using test::Soup;
using test::soup_of;

constexpr double kOrderTolerance = 0.15;

// The slope of log error against log h, by least squares.
double fitted_order(const std::vector<double>& h, const std::vector<double>& error) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const auto n = static_cast<double>(h.size());
  for (std::size_t i = 0; i < h.size(); ++i) {
    const double x = std::log(h[i]);
    const double y = std::log(error[i]);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

double longest_edge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      longest =
          std::max(longest, (mesh.positions_m[t[e]] - mesh.positions_m[t[(e + 1) % 3]]).norm());
    }
  }
  return longest;
}

// A random point of the exact shape and its outward normal.
struct ExactPoint {
  Vec3 point;
  Vec3 normal;
};
using ExactShape = std::function<ExactPoint(Random&)>;

double largest_depth_error(const TriangleMesh& mesh, const ExactShape& shape, double radius,
                           double outwards) {
  Random random(41);
  const RigidTransform pose = random.pose(1.0);
  const OwnedWorld world(soup_of(mesh), pose, radius);
  auto god_object = test::made(GodObject::create(world.world(), {.radius_m = radius}));
  double largest = 0.0;
  for (int trial = 0; trial < 400; ++trial) {
    const ExactPoint on = shape(random);
    const Vec3 out = outwards * on.normal;
    const double depth = random.uniform(0.01, 0.03);
    const auto solver = [&](const Vec3& p) { return world.world().to_solver(pose.point(p)); };
    god_object.place(solver(on.point + (radius + 0.05) * out));
    const Vec3 goal = solver(on.point + (radius - depth) * out);
    const ProxyState state = god_object.move_to(goal);
    EXPECT_FALSE(state.capped);
    largest = std::max(largest, std::abs((state.proxy - goal).norm() - depth));
  }
  return largest;
}

ExactPoint on_sphere(Random& random) {
  const Vec3 u = random.unit_vector();
  return {u, u};
}

ExactPoint on_torus(Random& random) {
  const double around = random.uniform(0, 2 * std::numbers::pi);
  const double tube = random.uniform(0, 2 * std::numbers::pi);
  const Vec3 centre(std::cos(around), std::sin(around), 0.0);
  const Vec3 normal = std::cos(tube) * centre + std::sin(tube) * Vec3::UnitZ();
  return {centre + 0.25 * normal, normal};
}

struct CurvedCase {
  const char* name;
  std::function<TriangleMesh(int)> mesh;
  ExactShape shape;
  int first_level;
  double radius;
  double outwards;  // -1: touched from inside
};

void PrintTo(const CurvedCase& c, std::ostream* out) {
  *out << c.name;
}

class CurvedSurface : public testing::TestWithParam<CurvedCase> {};

TEST_P(CurvedSurface, DepthConvergesWithTheSquareOfTheEdgeLength) {
  const CurvedCase& c = GetParam();
  std::vector<double> h;
  std::vector<double> error;
  for (int level = c.first_level; level < c.first_level + 4; ++level) {
    const TriangleMesh mesh = c.mesh(level);
    h.push_back(longest_edge(mesh));
    error.push_back(largest_depth_error(mesh, c.shape, c.radius, c.outwards));
  }
  EXPECT_NEAR(fitted_order(h, error), 2.0, kOrderTolerance)
      << error[0] << " " << error[1] << " " << error[2] << " " << error[3];
}

TriangleMesh unit_sphere(int level) {
  return icosphere(level, 1.0);
}
TriangleMesh unit_torus(int level) {
  return torus(1.0, 0.25, level);
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, CurvedSurface,
    testing::Values(CurvedCase{"sphere", unit_sphere, on_sphere, 2, 0.0, 1.0},
                    CurvedCase{"cavity", unit_sphere, on_sphere, 2, 0.0, -1.0},
                    CurvedCase{"torus", unit_torus, on_torus, 2, 0.0, 1.0},
                    CurvedCase{"sphere by a sphere", unit_sphere, on_sphere, 2, 0.05, 1.0},
                    CurvedCase{"cavity by a sphere", unit_sphere, on_sphere, 2, 0.05, -1.0},
                    CurvedCase{"torus by a sphere", unit_torus, on_torus, 2, 0.05, 1.0}),
    [](const auto& shape) {
      std::string name = shape.param.name;
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

}  // namespace
}  // namespace palpate
