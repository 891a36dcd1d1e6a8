// In a convex room, the position nearest to a goal outside is unique: the projection of the goal
// onto the room with its walls moved inwards by the proxy's distance from walls. The tests compare
// every rest with this projection, computed by a quadratic program that shares no code with the
// solver. PALPATE_SEED=N runs only room N; PALPATE_REST_TICKS=N sets the number of ticks.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/proxy/anisotropic_norm.h"
#include "haptics/proxy/god_object.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/rest_judge.h"
#include "tests/helpers/rest_scenes.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::Corners;
using test::OwnedWorld;
using test::Random;
using test::RestHand;

using Wide = long double;
using Wide3 = Eigen::Matrix<Wide, 3, 1>;

// The half-space normal . x <= reach_m.
struct Wall {
  Wide3 normal;
  Wide reach_m;
};

// The walls of a room whose faces point inwards, moved inwards by keep_m.
std::vector<Wall> walls_of(const std::vector<Corners>& triangles, Wide keep_m) {
  std::vector<Wall> walls;
  for (const Corners& t : triangles) {
    const Wide3 a = t.a.cast<Wide>();
    const Wide3 out = (t.c.cast<Wide>() - a).cross(t.b.cast<Wide>() - a).normalized();
    walls.push_back({out, out.dot(a) - keep_m});
  }
  return walls;
}

// Rounding of the height of a point on a wall.
constexpr Wide kOnWall = 1e-16L;

// Planes count as parallel if the sine of their angle is smaller than this.
constexpr Wide kParallel = 1e-9L;

// The point of the room nearest to the goal. The candidates are the goal itself and its projections
// onto one wall, the line of two walls and the corner of three; the nearest one inside the room is
// the result.
Wide3 nearest_in_room(const std::vector<Wall>& walls, const Wide3& goal) {
  Wide3 best = goal;
  Wide best_m = std::numeric_limits<Wide>::infinity();
  const auto offer = [&](const Wide3& x) {
    const Wide distance_m = (x - goal).norm();
    if (!(distance_m < best_m)) return;
    for (const Wall& wall : walls) {
      if (wall.normal.dot(x) > wall.reach_m + kOnWall) return;
    }
    best = x;
    best_m = distance_m;
  };
  offer(goal);
  const std::size_t count = walls.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Wall& u = walls[i];
    const Wide over_u = u.normal.dot(goal) - u.reach_m;
    if (over_u <= 0) continue;  // a wall can hold only if the goal is beyond it
    offer(goal - over_u * u.normal);
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Wall& u = walls[i];
      const Wall& v = walls[j];
      const Wide3 uv = u.normal.cross(v.normal);
      if (uv.norm() < kParallel) continue;
      // Cramer's rule gives the line through the goal's projection, and then the corners on it.
      const auto meet = [&](const Wide3& n, Wide reach_m) -> Wide3 {
        const Wide3 sum = u.reach_m * v.normal.cross(n) + v.reach_m * n.cross(u.normal);
        return (sum + reach_m * uv) / uv.dot(n);
      };
      offer(meet(uv, uv.dot(goal)));
      for (std::size_t k = 0; k < j; ++k) {
        const Wall& w = walls[k];
        if (std::abs(uv.dot(w.normal)) >= kParallel) offer(meet(w.normal, w.reach_m));
      }
    }
  }
  return best;
}

TEST(NearestInARoom, IsThatOfABox) {
  std::vector<Wall> walls;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) walls.push_back({side * Wide3::Unit(axis), 1});
  }
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Wide3 goal = random.in_box(3.0).cast<Wide>();
    const Wide3 nearest = goal.cwiseMin(Wide3::Ones()).cwiseMax(-Wide3::Ones());
    EXPECT_LT((nearest_in_room(walls, goal) - nearest).norm(), 1e-15L);
  }
}

// W^(1/2) of an anisotropic norm in long double, from the norm's definition; the unit matrix
// without a norm.
struct OutsideStretch {
  using Matrix = Eigen::Matrix<Wide, 3, 3>;
  std::optional<AnisotropicNorm> norm;
  Matrix root = Matrix::Identity();

  // The norm of a device with one or two motors.
  static OutsideStretch anisotropic(Random& random) {
    const double anisotropy = std::pow(16.0, random.uniform(-1.0, 1.0));
    std::vector<Vec3> axes{random.unit_vector()};
    if (random.index(2)) axes.push_back(axes[0].unitOrthogonal());
    OutsideStretch stretch;
    stretch.norm.emplace(anisotropy, axes);
    Matrix P = Matrix::Zero();
    for (const Vec3& axis : axes) P += axis.cast<Wide>() * axis.cast<Wide>().transpose();
    stretch.root += (std::sqrt(Wide{anisotropy}) - 1) * (Matrix::Identity() - P);
    return stretch;
  }

  // The point of the room nearest to the goal in the norm: in the stretched room, it is the nearest
  // one to the stretched goal.
  Wide3 nearest(const std::vector<Wall>& walls, const Wide3& goal) const {
    if (!norm) return nearest_in_room(walls, goal);
    const Matrix inverse = root.inverse();
    std::vector<Wall> stretched;
    for (const Wall& wall : walls) {
      const Wide3 normal = inverse * wall.normal;
      stretched.push_back({normal.normalized(), wall.reach_m / normal.norm()});
    }
    return inverse * nearest_in_room(stretched, root * goal);
  }
};

// kind: of the proxy. with_norm: distances are those of an anisotropic norm.
void expect_rests_at_the_projection(test::ProxyKind kind, bool with_norm) {
  constexpr int kTicksPerRoom = 100;
  const bool is_point = kind == test::ProxyKind::kPoint;
  const auto ticks = static_cast<int>(
      test::from_environment("PALPATE_REST_TICKS", test::in_soak_or_else(400'000u, 4'000u)));
  int contacts = 0;
  int capped = 0;
  int misses = 0;
  double worst = 0.0;
  for (int n = 0; n < ticks && misses < 5; n += kTicksPerRoom) {
    Random random(static_cast<std::uint64_t>(1 + n / kTicksPerRoom));
    const test::Soup room = test::convex_room(random);
    const double radius_m = is_point ? 0.0 : 1e-6 * std::pow(4e3, random.uniform(0.0, 1.0));
    const OwnedWorld world(room, {}, radius_m);
    const std::vector<Corners> triangles = test::solver_triangles(world);
    const Accuracy accuracy = random.index(4) ? Accuracy::balanced() : Accuracy::exact();
    auto god_object = test::made(GodObject::create(world.world(), {radius_m, accuracy}));
    const double size_m = world.world().size_m;
    const double stand_off_m = god_object.scale().stand_off_m;
    const auto walls = walls_of(triangles, static_cast<Wide>(radius_m + stand_off_m));
    const Vec3 start = world.world().to_solver(Vec3::Zero());
    god_object.place(start);
    ProxyState state;
    state.proxy = start;
    const OutsideStretch stretch =
        with_norm ? OutsideStretch::anisotropic(random) : OutsideStretch{};
    RestHand hand(triangles, {}, radius_m, stand_off_m, 0.0, start, random);
    for (int tick = 0; tick < kTicksPerRoom; ++tick) {
      const Vec3 goal = hand.next_goal(state);
      state = stretch.norm ? god_object.move_in_norm(goal, std::nullopt, *stretch.norm)
                           : god_object.move_to(goal);
      contacts += state.in_contact;
      capped += state.capped;
      if (state.capped) continue;
      const Wide3 nearest = stretch.nearest(walls, goal.cast<Wide>());
      const auto off = static_cast<double>((state.proxy.cast<Wide>() - nearest).norm()) / size_m;
      worst = std::max(worst, off);
      if (off <= test::RestJudge::kGainPerSize) continue;
      ++misses;
      ADD_FAILURE() << "PALPATE_SEED=" << random.seed() << ", tick " << tick << ", radius "
                    << radius_m << ": " << off << " sizes off\ngoal " << test::hex(goal)
                    << "\nproxy " << test::hex(state.proxy) << "\nnearest "
                    << test::hex(nearest.cast<double>()) << "\n"
                    << state.iterations << " iterations, " << state.active_planes << " planes";
      break;
    }
    if (std::getenv("PALPATE_SEED")) break;
  }
  std::printf("%d contacts, %d capped, %d rooms missed, worst %.3g sizes\n", contacts, capped,
              misses, worst);
  EXPECT_LE(capped, 0.01 * contacts);
}

class Rooms : public testing::TestWithParam<test::ProxyKind> {};

TEST_P(Rooms, HoldTheProxyAtTheProjectionOfTheGoal) {
  expect_rests_at_the_projection(GetParam(), false);
}

TEST(AnisotropicRooms, HoldAPointAtTheProjectionOfTheGoalInTheirNorm) {
  expect_rests_at_the_projection(test::ProxyKind::kPoint, true);
}

INSTANTIATE_TEST_SUITE_P(Of, Rooms,
                         testing::Values(test::ProxyKind::kPoint, test::ProxyKind::kSphere),
                         [](const auto& proxy) {
                           return proxy.param == test::ProxyKind::kPoint ? "Points" : "Spheres";
                         });

}  // namespace
}  // namespace palpate
