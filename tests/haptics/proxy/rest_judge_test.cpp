// The judge of rests on scenes with known solutions.

#include "tests/helpers/rest_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::Corners;
using test::Escape;
using test::ExactJudge;
using test::Random;
using test::Rest;
using test::RestJudge;
using test::Soup;

constexpr double kSize_m = 1.0;
constexpr double kStandOff_m = 1e-11;

// A soup in a pose, and the judgement of a rest given in the frame of the soup.
class Posed {
 public:
  Posed(const Soup& soup, const RigidTransform& pose, double radius_m = 0.0)
      : pose_(pose), exact_(corners(soup, pose)), judge_(kSize_m, radius_m, kStandOff_m) {}

  std::optional<Escape> escape_from(const Rest& rest) const {
    Rest posed = rest;
    posed.proxy = pose_.point(rest.proxy);
    posed.goal = pose_.point(rest.goal);
    if (rest.motion_plane_normal) {
      posed.motion_plane_normal = pose_.direction(*rest.motion_plane_normal);
    }
    return judge_.escape_from(exact_, posed);
  }
  const ExactJudge& exact() const { return exact_; }

 private:
  static std::vector<Corners> corners(const Soup& soup, const RigidTransform& pose) {
    std::vector<Corners> all;
    for (const Triangle& t : soup.triangles) {
      all.push_back({pose.point(soup.positions[t[0]]), pose.point(soup.positions[t[1]]),
                     pose.point(soup.positions[t[2]])});
    }
    return all;
  }

  RigidTransform pose_;
  ExactJudge exact_;
  RestJudge judge_;
};

// A random pose that moves the soup by less than its size.
RigidTransform pose_of(Random& random) {
  return random.index(3) ? random.pose(0.1) : RigidTransform{};
}

// Distance of a proxy from a plane that keeps the stand-off despite rounding.
double keep_m(double radius_m) {
  return radius_m + kStandOff_m;
}

Soup floor() {
  Soup soup;
  soup.add_quad({-0.4, -0.3, 0.0}, {0.5, -0.4, 0.0}, {0.4, 0.4, 0.0}, {-0.5, 0.4, 0.0});
  return soup;
}

#define EXPECT_REST(posed, ...)                                       \
  do {                                                                \
    const auto way = (posed).escape_from(__VA_ARGS__);                \
    EXPECT_FALSE(way) << (way ? test::to_text(*way) : std::string()); \
  } while (false)

class Proxies : public testing::TestWithParam<double> {};

TEST_P(Proxies, RestOnAPlaneOnlyAtTheFootOfTheGoal) {
  Random random(1);
  const double z = keep_m(GetParam());
  for (int trial = 0; trial < 200; ++trial) {
    const Posed posed(floor(), pose_of(random), GetParam());
    const Vec3 goal(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), -0.05);
    EXPECT_REST(posed, {{goal.x(), goal.y(), z}, goal});
    const double aside_m = 1e-3 * std::pow(10.0, random.uniform(0.0, 2.0));
    const double turn_rad = random.uniform(0.0, 6.0);
    const Vec3 aside(aside_m * std::cos(turn_rad), aside_m * std::sin(turn_rad), 0.0);
    const Vec3 beside = Vec3(goal.x(), goal.y(), z) + aside;
    EXPECT_TRUE(posed.escape_from({beside, goal}));
    EXPECT_TRUE(posed.escape_from({{goal.x(), goal.y(), z + 1e-8}, goal})) << "above the foot";
    // In a plane of motion perpendicular to the shift, the proxy may rest there.
    Rest held{beside, goal + aside, aside.normalized()};
    EXPECT_REST(posed, held);
    held.goal = goal + aside + Vec3(-aside.y(), aside.x(), 0.0);
    EXPECT_TRUE(posed.escape_from(held));
  }
}

TEST_P(Proxies, RestInACornerWhereAllWallsPush) {
  Random random(2);
  const Soup room = box_soup(Vec3::Constant(0.25));
  const double at = 0.25 - keep_m(GetParam());
  for (int trial = 0; trial < 200; ++trial) {
    const Posed posed(room, pose_of(random), GetParam());
    const Vec3 out(random.uniform(0.01, 0.1), random.uniform(0.01, 0.1), random.uniform(0.01, 0.1));
    EXPECT_REST(posed, {Vec3::Constant(at), Vec3::Constant(at) + out});
    // A goal that is not behind one of the walls pulls the proxy along that wall.
    const int free = static_cast<int>(random.index(3));
    Vec3 goal = Vec3::Constant(at) + out;
    goal[free] = at - random.uniform(0.001, 0.1);
    EXPECT_TRUE(posed.escape_from({Vec3::Constant(at), goal}));
    // On the remaining edge, the solution is the foot of the goal.
    Vec3 foot = Vec3::Constant(at);
    foot[free] = goal[free];
    EXPECT_REST(posed, {foot, goal});
    foot[free] += 1e-3;
    EXPECT_TRUE(posed.escape_from({foot, goal}));
  }
}

// The proxy approaches the rim of a plate in the plane of the plate.
TEST_P(Proxies, DoNotHoverBeforeARim) {
  Random random(3);
  Soup plate;
  plate.add_quad({0.0, -0.4, 0.0}, {0.5, -0.4, 0.0}, {0.5, 0.4, 0.0}, {0.0, 0.4, 0.0});
  for (int trial = 0; trial < 200; ++trial) {
    const Posed posed(plate, pose_of(random), GetParam());
    const Vec3 goal(random.uniform(0.05, 0.2), random.uniform(-0.2, 0.2), 0.0);
    const double short_m = std::pow(10.0, random.uniform(-6.0, -1.0));
    const Vec3 at_rim(-keep_m(GetParam()), goal.y(), 0.0);
    EXPECT_TRUE(posed.escape_from({at_rim - Vec3(short_m, 0.0, 0.0), goal}));
    // For a proxy slightly above the plane, the goal is under the plate.
    const Vec3 above(-short_m, goal.y(), (0.5 + random.uniform(0.0, 1.0)) * keep_m(GetParam()));
    EXPECT_TRUE(posed.escape_from({above - Vec3(keep_m(GetParam()), 0.0, 0.0), goal}));
    EXPECT_TRUE(posed.escape_from({above + Vec3(2e-3 + short_m, 0.0, keep_m(GetParam())), goal}));
  }
}

TEST_P(Proxies, RestInAGroove) {
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const double half_rad = random.uniform(0.1, 1.4);
    const Vec3 arm(0.0, std::sin(half_rad), std::cos(half_rad));
    Soup groove;
    const Vec3 along(0.4, 0.0, 0.0);
    for (const double side : {-1.0, 1.0}) {
      const Vec3 up = 0.3 * Vec3(0.0, side * arm.y(), arm.z());
      groove.add_quad(-along, along, along + up, -along + up);
    }
    const Posed posed(groove, pose_of(random), GetParam());
    // The middle of the groove where both walls are at the required distance.
    const double z = keep_m(GetParam()) / std::sin(half_rad);
    const double x = random.uniform(-0.2, 0.2);
    EXPECT_REST(posed, {{x, 0.0, z}, {x, 0.0, z - 0.05}});
    EXPECT_TRUE(posed.escape_from({{x, 0.0, z}, {x + 1e-3, 0.0, z - 0.05}}));
    EXPECT_TRUE(posed.escape_from({{x, 0.0, z + 1e-6}, {x, 0.0, z - 0.05}}));
  }
}

// The proxy rises along one wall to the foot of the goal if the lag is steeper than the wall's
// normal.
TEST_P(Proxies, LeaveAGrooveAlongAWall) {
  const double radius_m = GetParam();
  Soup groove;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 up(0.0, 0.3 * side, 0.3);
    groove.add_quad({-0.4, 0.0, 0.0}, {0.4, 0.0, 0.0}, Vec3(0.4, 0.0, 0.0) + up,
                    Vec3(-0.4, 0.0, 0.0) + up);
  }
  const Posed posed(groove, {}, radius_m);
  const double z = std::sqrt(2.0) * keep_m(radius_m);
  EXPECT_REST(posed, {{0.0, 0.0, z}, {0.0, 0.049, z - 0.05}});
  EXPECT_TRUE(posed.escape_from({{0.0, 0.0, z}, {0.0, 0.051, z - 0.05}}));
}

// Static friction mu holds a tangential lag of at most mu times the depth.
TEST_P(Proxies, RestUnderFrictionWithinTheCone) {
  Random random(5);
  const double z = keep_m(GetParam());
  for (int trial = 0; trial < 100; ++trial) {
    const Posed posed(floor(), pose_of(random), GetParam());
    const double mu = random.uniform(0.1, 1.5);
    const double depth_m = random.uniform(0.01, 0.05);
    const double turn_rad = random.uniform(0.0, 6.0);
    const Vec3 along(std::cos(turn_rad), std::sin(turn_rad), 0.0);
    const Vec3 proxy(0.0, 0.0, z);
    Rest rest{proxy, proxy + 0.999 * mu * depth_m * along - Vec3(0.0, 0.0, depth_m), {}, mu};
    EXPECT_REST(posed, rest);
    rest.goal = proxy + 1.01 * mu * depth_m * along - Vec3(0.0, 0.0, depth_m);
    EXPECT_TRUE(posed.escape_from(rest));
    // Friction does not hold a proxy that is free to move.
    rest.goal = proxy + Vec3(0.0, 0.0, 1e-3);
    EXPECT_TRUE(posed.escape_from(rest));
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Proxies, testing::Values(0.0, 1e-6, 1e-3, 0.03),
                         [](const auto& radius) {
                           return std::to_string(std::lround(radius.param * 1e6)) + "_um";
                         });

// The edge of a plate stops a proxy that moves straight down onto it, but not one beside it.
TEST(RestJudge, FindsTheSegmentPastAnEdgeThatIsNotUnderTheProxy) {
  const Posed posed(floor(), {});
  // The proxy is 1e-8 beside the edge from (0.5, -0.4) to (0.4, 0.4): downwards is free.
  EXPECT_TRUE(posed.escape_from({{0.45 + 1e-8, 0.0, 1e-11}, {0.45 + 1e-8, 0.0, -0.1}}));
  EXPECT_REST(posed, {{0.45 - 1e-8, 0.0, 1e-11}, {0.45 - 1e-8, 0.0, -0.1}});
}

// The faces round a vertex of a terrain rise and fall alternately. The proxy is 3.6 stand-offs from
// the vertex, before a gap between two faces that is less than a stand-off wide and leads nearer to
// the goal. The gap is closed for this proxy, but open for a proxy that must keep only a quarter of
// a stand-off.
TEST(RestJudge, FindsTheGapBetweenTwoFacesOfASaddleIfItIsWideEnough) {
  const Vec3 hub(-0.011290322989225388, -0.03387096896767616, 0.018608149141073227);
  const Vec3 ring[] = {{-0.011290322989225388, -0.0370967723429203, 0.020422888919711113},
                       {-0.008064515888690948, -0.03387096896767616, 0.029601819813251495},
                       {-0.008064515888690948, -0.030645161867141724, 0.01709231361746788},
                       {-0.011290322989225388, -0.030645161867141724, 0.036082521080970764},
                       {-0.014516129158437252, -0.03387096896767616, 0.036082521080970764},
                       {-0.014516129158437252, -0.0370967723429203, 0.029921622946858406}};
  std::vector<Corners> fan;
  for (std::size_t i = 0; i < std::size(ring); ++i) {
    fan.push_back({hub, ring[i], ring[(i + 1) % std::size(ring)]});
  }
  const ExactJudge exact(fan);
  const Vec3 proxy(-0x1.71f617fffb9e6p-7, -0x1.157892001c879p-5, 0x1.30e03c00f558ap-6);
  const Vec3 goal(-0x1.093a8d36296p-9, -0x1.3613015ed1354p-6, -0x1.33f4e70972324p-5);
  EXPECT_FALSE(RestJudge(0.1, 0.0, 1e-12).escape_from(exact, {proxy, goal}));
  const auto way = RestJudge(0.1, 0.0, 0.25e-12).escape_from(exact, {proxy, goal});
  ASSERT_TRUE(way);
  EXPECT_GT(way->gain_m, 1e-6);
}

// The judgement is the same for bodies with other frames.
TEST(RestJudge, JudgesBodiesAtTheirPoses) {
  Random random(6);
  for (int trial = 0; trial < 100; ++trial) {
    const double radius_m = random.index(2) ? 0.0 : 0.01;
    const RestJudge judge(kSize_m, radius_m, kStandOff_m);
    std::vector<Corners> wall;
    for (const Triangle& t : floor().triangles) {
      const Soup soup = floor();
      wall.push_back({soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]});
    }
    const ExactJudge exact(wall);
    const RigidTransform frame = random.pose(0.1);
    // Two walls that meet at a right angle, perpendicular to x and z.
    const Quat upright =
        frame.rotation * Quat(Eigen::AngleAxisd(0.5 * 3.14159265358979323846, Vec3::UnitY()));
    const test::JudgedBody bodies[] = {{&exact, frame}, {&exact, {upright, frame.translation_m}}};
    const double at = keep_m(radius_m);
    // The margin covers the rounding of the rotation by pi / 2.
    const Vec3 proxy(at + 1e-14, 0.0, at + 1e-14);
    const auto way_to = [&](const Vec3& goal) {
      return judge.escape_from(bodies, {frame.point(proxy), frame.point(goal)});
    };
    EXPECT_FALSE(way_to({-0.1, 0.0, -0.1}));
    EXPECT_TRUE(way_to({-0.1, 0.01, -0.1}));
    EXPECT_TRUE(way_to({0.1, 0.0, -0.1}));
  }
}

// The largest gain of a free segment, found by trying random directions, and then directions near
// the best one. Slow, and misses narrow gaps.
double gain_by_trying(const ExactJudge& exact, const Vec3& p, const Vec3& goal, double keep_from_m,
                      Random& random) {
  std::vector<double> least_m;
  for (std::size_t i = 0; i < exact.triangles().size(); ++i) {
    least_m.push_back(std::min(exact.distance_m(p, p, i), keep_from_m) - 4e-16);
  }
  const auto is_free = [&](const Vec3& q) {
    for (std::size_t i = 0; i < least_m.size(); ++i) {
      if (exact.distance_m(p, q, i) < least_m[i]) return false;
    }
    return true;
  };
  const Vec3 lag = goal - p;
  double best_m = 0.0;
  Vec3 best_direction = lag.normalized();
  for (int trial = 0; trial < 400; ++trial) {
    const double spread = trial < 200 ? 1.0 : std::pow(10.0, random.uniform(-6.0, 0.0));
    const Vec3 u = trial == 0 ? Vec3(lag.normalized())
                              : Vec3((best_direction + spread * random.unit_vector()).normalized());
    const double foot_m = u.dot(lag);
    if (foot_m <= 0.0) continue;
    for (double part = 1.0; part > 1e-7; part *= 0.25) {
      const Vec3 q = p + part * foot_m * u;
      const double gain_m = lag.norm() - (goal - q).norm();
      if (gain_m <= best_m) break;
      if (!is_free(q)) continue;
      best_m = gain_m;
      best_direction = u;
      break;
    }
  }
  return best_m;
}

// A direction that presses the proxy against the touched triangles, in a random mixture.
Vec3 pressed(const ExactJudge& exact, const Vec3& p, double keep_from_m, Random& random) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < exact.triangles().size(); ++i) {
    if (exact.distance_m(p, p, i) > 1.001 * keep_from_m) continue;
    const Vec3 normal = exact.directions(i).normal.cast<double>();
    const double side = normal.dot(p - exact.triangles()[i].a) < 0.0 ? 1.0 : -1.0;
    sum += random.uniform(0.0, 1.0) * side * normal;
  }
  return sum.isZero(0.0) ? random.unit_vector() : sum.normalized();
}

// The proxy is at vertices of random fans of triangles, a stand-off above some of their faces.
TEST(RestJudge, FindsASegmentWheneverRandomTrialsFindOne) {
  constexpr std::array<std::size_t, 8> numbers = {0, 1, 2, 3, 4, 5, 6, 7};
  int ways = 0;
  int rests = 0;
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    Random random(seed);
    const double radius_m = random.index(2) ? 0.0 : 0.02;
    const double keep = keep_m(radius_m);
    std::vector<Corners> fan;
    const int spokes = 3 + static_cast<int>(random.index(6));
    std::vector<Vec3> ring;
    for (int i = 0; i < spokes; ++i) {
      const double turn_rad = (i + random.uniform(0.0, 0.7)) * 2 * 3.14159265358979323846 / spokes;
      ring.emplace_back(0.3 * std::cos(turn_rad), 0.3 * std::sin(turn_rad),
                        random.uniform(-0.3, 0.3));
    }
    for (std::size_t i = 0; i < ring.size(); ++i) {
      fan.push_back({Vec3::Zero(), ring[i], ring[(i + 1) % ring.size()]});
    }
    const ExactJudge exact(fan);
    // The proxy descends along random segments, each as far as it is free by definition.
    Vec3 p(0.0, 0.0, 0.2 + radius_m);
    const Vec3 aim = random.in_box(0.01) - Vec3(0.0, 0.0, 0.2);
    for (int step = 0; step < 60; ++step) {
      const double spread = random.uniform(0.0, 1.0);
      const Vec3 u = ((aim - p).normalized() + spread * random.unit_vector()).normalized();
      const auto is_free = [&](double length_m) {
        return std::all_of(numbers.begin(), numbers.begin() + spokes, [&](std::size_t i) {
          return exact.distance_m(p, p + length_m * u, i) >= keep;
        });
      };
      double free_m = 0.0;
      double blocked_m = u.dot(aim - p);
      if (blocked_m <= 0.0) continue;
      for (int i = 0; i < 48; ++i) {
        const double middle_m = 0.5 * (free_m + blocked_m);
        (is_free(middle_m) ? free_m : blocked_m) = middle_m;
      }
      p += free_m * u;
    }
    const Vec3 towards = random.index(4) ? pressed(exact, p, keep, random) : random.unit_vector();
    const Vec3 goal = p + random.uniform(0.01, 0.1) * towards;
    const RestJudge judge(kSize_m, radius_m, kStandOff_m);
    const double tried_m = gain_by_trying(exact, p, goal, keep, random);
    const auto way = judge.escape_from(exact, {p, goal});
    (way ? ways : rests) += 1;
    if (tried_m > 2 * judge.tolerance_m()) {
      EXPECT_TRUE(way) << "seed " << seed << ", gain " << tried_m;
    }
  }
  EXPECT_GT(ways, 20);
  EXPECT_GT(rests, 10);
}

}  // namespace
}  // namespace palpate
