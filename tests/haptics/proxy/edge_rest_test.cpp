// A point in the corner of two walls and the plane of a blade, just beside the edge or a corner of
// the blade. Three planes hold it, but the blade does not reach as far as its plane: a segment past
// its edge, at a stand-off from it, may lead nearer to the goal. The judge of rests decides.

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "haptics/proxy/god_object.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/rest_judge.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::OwnedWorld;
using test::Random;
using test::Soup;

constexpr int kBladeTrials = 4000;

// Distance of the point beyond the edge of the blade, along the plane of the blade, in stand-offs.
// The point stops 7/8 of a stand-off above the plane, so that it touches the edge up to 0.48.
constexpr double kLeastBeyond = 0.4;
constexpr double kMostBeyond = 1.5;

double power_between(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

// The frame of the corner has its origin where the point rests. The unit is the size of the scene.
class CornerWithBlade {
 public:
  explicit CornerWithBlade(Random& random)
      : size_m_(std::pow(10.0, random.uniform(-3.0, 3.0))),
        normals_(independent(random)),
        world_(soup(random)),
        exact_(test::solver_triangles(world_)) {}

  // A goal that the three planes keep the point away from.
  Vec3 goal_m(const Vec3& proxy_m, Random& random) const {
    Vec3 lag = Vec3::Zero();
    for (const Vec3& normal : normals_) lag -= power_between(random, 1e-2, 1.0) * normal;
    return proxy_m + size_m_ * power_between(random, 1e-6, 0.3) * lag.normalized();
  }
  Vec3 start_m() const { return world_.world().to_solver(Vec3::Zero()); }
  double size_m() const { return world_.world().size_m; }
  const ContactWorld& world() const { return world_.world(); }
  const test::ExactJudge& exact() const { return exact_; }

 private:
  static std::array<Vec3, 3> independent(Random& random) {
    std::array<Vec3, 3> n;
    do {
      for (Vec3& normal : n) normal = random.unit_vector();
    } while (std::abs(n[0].dot(n[1].cross(n[2]))) < 0.2);
    return n;
  }

  Soup soup(Random& random) const {
    const double stand_off = SolverScale::kStandOffPerSize;
    const double stop = SolverScale::kStopPerStandOff * stand_off;
    Soup soup;
    for (int wall = 0; wall < 2; ++wall) {
      const Vec3& n = normals_[wall];
      const Vec3 u = n.unitOrthogonal();
      const Vec3 v = n.cross(u);
      const Vec3 foot = -stop * n;
      soup.add_quad(foot - 0.3 * u, foot - 0.3 * v, foot + 0.3 * u, foot + 0.3 * v);
    }
    const Vec3& n = normals_[2];
    const Vec3 beyond = n.cross(random.unit_vector()).normalized();
    const Vec3 edge = n.cross(beyond);
    const double by = stand_off * random.uniform(kLeastBeyond, kMostBeyond);
    const Vec3 foot = -stop * n - by * beyond;
    const double spread = random.uniform(0.1, 1.0);
    if (random.index(3)) {
      soup.add(foot - 0.3 * edge, foot + 0.3 * edge, foot - 0.3 * beyond);
    } else {
      soup.add(foot, foot - 0.3 * (beyond + spread * edge), foot - 0.3 * (beyond - spread * edge));
    }
    // Two specks in the corners of a cube give the scene its size.
    for (const double side : {-0.5, 0.5}) {
      const Vec3 corner = side * Vec3::Ones();
      const double speck = 1e-3 * side;
      soup.add(corner, corner - speck * Vec3::UnitX(), corner - speck * Vec3::UnitY());
    }
    for (Vec3& p : soup.positions) p = size_m_ * p;
    return soup;
  }

  double size_m_;
  std::array<Vec3, 3> normals_;
  OwnedWorld world_;
  test::ExactJudge exact_;
};

TEST(PointBesideABlade, RestsOnlyWhereNoSegmentPastTheEdgeLeadsNearer) {
  Random random(94);
  int rests = 0;
  for (int trial = 0; trial < kBladeTrials; ++trial) {
    const CornerWithBlade scene(random);
    auto god_object = test::made(GodObject::create(scene.world(), {}));
    god_object.place(scene.start_m());
    const test::RestJudge judge(scene.size_m(), 0.0, god_object.scale().stand_off_m);
    const Vec3 goal = scene.goal_m(god_object.proxy(), random);
    const ProxyState state = god_object.move_to(goal);
    if (state.capped) continue;
    ++rests;
    const auto escape = judge.escape_from(scene.exact(), {state.proxy, goal});
    EXPECT_FALSE(escape) << "trial " << trial << ": " << test::to_text(*escape) << ", which is "
                         << escape->gain_m / scene.size_m() << " sizes";
  }
  EXPECT_GT(rests, kBladeTrials / 2);
}

}  // namespace
}  // namespace palpate
