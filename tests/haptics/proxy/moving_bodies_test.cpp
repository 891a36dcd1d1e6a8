// Bodies that move while the hand touches them push the proxy and never pass it, for any motion. A
// proxy is judged in the frame of each body, where its path must touch no triangle.

#include <cmath>
#include <limits>
#include <optional>
#include <ostream>

#include <gtest/gtest.h>

#include "haptics/haptic_loop.h"
#include "haptics/proxy/god_object.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::ExactJudge;
using test::kTick_s;
using test::OwnedBodies;
using test::Random;
using test::Soup;

// Number of random scenes; a soak test has 1.2 million ticks.
std::uint64_t random_scenes() {
  return test::in_soak_or_else<std::uint64_t>(6000, 100);
}

RigidTransform moved(const RigidTransform& T, const Vec3& by_m, const Vec3& turn_rad) {
  RigidTransform to = T;
  const double angle_rad = turn_rad.norm();
  if (angle_rad > 0.0) {
    const Quat turn(Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad));
    to.rotation = (turn * T.rotation).normalized();
  }
  to.translation_m += by_m;
  return to;
}

// A god-object among bodies, with a judge for each body. Bodies move one after the other, so that
// the path of the proxy in the frame of each body is known.
class JudgedProxy {
 public:
  JudgedProxy(const OwnedBodies& bodies, double radius_m, const Accuracy& accuracy = {})
      : radius_m_(radius_m),
        god_object_(test::made(GodObject::create(bodies.world(), {radius_m, accuracy}))) {
    for (std::size_t b = 0; b < bodies.world().bodies.size(); ++b) {
      judges_.emplace_back(bodies.triangles(b));
    }
    // Tolerance for the rounding of positions and distances, as in hard_scene_leak_test.
    nearest_m_ = radius_m - 64 * std::numeric_limits<double>::epsilon() *
                                (bodies.world().size_m + radius_m) * kFarthest;
  }

  GodObject& god_object() { return god_object_; }
  const Vec3& proxy() const { return god_object_.proxy(); }

  // Moves a body and judges the path. True if the body reached the pose.
  bool move(std::uint32_t body, const RigidTransform& T_solver_body) {
    const Vec3 before = proxy();
    std::vector<Vec3> starts;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) starts.push_back(placed(b).to_body(before));
    const BodyMotion motion{body, T_solver_body};
    const bool is_there = god_object_.move_bodies(std::span(&motion, 1)) == 0;
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      const Vec3 path[] = {starts[b], placed(b).to_body(proxy())};
      expect_free(b, path);
    }
    return is_there;
  }

  ProxyState follow(const Vec3& goal) {
    const ProxyState state = god_object_.move_to(goal);
    const auto path = god_object_.path();
    for (std::uint32_t b = 0; b < judges_.size(); ++b) {
      std::vector<Vec3> path_body;
      for (const Vec3& p : path) path_body.push_back(placed(b).to_body(p));
      expect_free(b, path_body);
    }
    return state;
  }

  const ContactBody& placed(std::uint32_t b) const { return god_object_.world().body(b); }
  const ExactJudge& judge(std::uint32_t b) const { return judges_[b]; }

 private:
  // Largest distance of bodies from the middle, in sizes; it determines the rounding of
  // coordinates.
  static constexpr double kFarthest = 4.0;

  void expect_free(std::uint32_t b, std::span<const Vec3> path) {
    const auto touch = radius_m_ == 0.0 ? judges_[b].touch_of_point(path)
                                        : judges_[b].touch_of_sphere(path, nearest_m_);
    if (touch) {
      ADD_FAILURE() << "body " << b << ", triangle " << touch->triangle << ", piece "
                    << touch->piece << " of " << path.size() << ", distance " << touch->distance_m;
    }
  }

  double radius_m_;
  double nearest_m_;
  GodObject god_object_;
  std::vector<ExactJudge> judges_;
};

// A closed plate of 0.1 x 0.1 x 0.002 m, or the open sheet in its middle.
Soup plate(bool is_closed) {
  const Vec3 half(0.05, 0.05, 0.001);
  if (is_closed) return test::box_soup(half);
  Soup sheet;
  sheet.add_quad({-0.05, -0.05, 0.0}, {0.05, -0.05, 0.0}, {0.05, 0.05, 0.0}, {-0.05, 0.05, 0.0});
  return sheet;
}

struct PlateCase {
  double speed_m_per_s;
  double turn_rad_per_s;  // rotation about an axis in the plate and about its normal
  bool is_closed;
  double radius_m;
};

void PrintTo(const PlateCase& c, std::ostream* out) {
  *out << c.speed_m_per_s << " m/s, " << c.turn_rad_per_s << " rad/s, radius " << c.radius_m;
}

class MovingPlate : public testing::TestWithParam<PlateCase> {
 protected:
  MovingPlate()
      : random_(7),
        frame_(random_.pose(0.01)),
        bodies_({{plate(GetParam().is_closed), at(0.05)}}, GetParam().radius_m),
        hand_(bodies_, GetParam().radius_m) {
    hand_.god_object().place(goal_);
  }

  // The pose of the plate `height_m` above the hand, in a frame with an arbitrary pose.
  RigidTransform at(double height_m) const {
    return {frame_.rotation, frame_.point(Vec3(0, 0, height_m))};
  }
  Vec3 direction(const Vec3& d) const { return frame_.direction(d); }
  double height_over_plate_m() const { return hand_.placed(0).to_body(hand_.proxy()).z(); }

  // Moves the plate for some ticks; each tick passes the state of the proxy to `check`.
  template <typename Check>
  void move_for(double seconds, const Vec3& velocity, Check check) {
    const Vec3 turn =
        direction(Vec3(GetParam().turn_rad_per_s, 0, 0.5 * GetParam().turn_rad_per_s));
    const int ticks = static_cast<int>(std::lround(seconds / kTick_s));
    for (int n = 0; n < ticks; ++n) {
      pose_ = moved(pose_, kTick_s * velocity, kTick_s * turn);
      ASSERT_TRUE(hand_.move(0, pose_));
      check(hand_.follow(goal_));
      if (HasFailure()) FAIL() << "tick " << n;
    }
  }

  Random random_;
  RigidTransform frame_;
  Vec3 goal_ = frame_.point(Vec3::Zero());
  RigidTransform pose_ = at(0.05);
  OwnedBodies bodies_;
  JudgedProxy hand_;
};

TEST_P(MovingPlate, PushesARestingHandAndNeverPassesIt) {
  const double speed = GetParam().speed_m_per_s;
  bool was_pushed = false;
  move_for(0.12 / speed, direction({0, 0, -speed}), [&](const ProxyState& state) {
    was_pushed |= state.in_contact;
    // The hand is under the plate and stays on that side while it is within the plate's edges.
    const Vec3 p = hand_.placed(0).to_body(hand_.proxy());
    const bool is_beside = std::max(std::abs(p.x()), std::abs(p.y())) > 0.05;
    EXPECT_TRUE(is_beside || p.z() < 0.0);
    if (state.in_contact && GetParam().turn_rad_per_s == 0.0) {
      const double plate_m = (pose_.translation_m - goal_).dot(direction({0, 0, 1}));
      const double half_m = GetParam().is_closed ? 0.001 : 0.0;
      EXPECT_NEAR((state.proxy - goal_).norm(), half_m + GetParam().radius_m - plate_m,
                  4 * hand_.god_object().scale().stand_off_m);
    }
  });
  EXPECT_TRUE(was_pushed);
}

TEST_P(MovingPlate, ReleasesTheHandWhenItMovesAway) {
  const double speed = GetParam().speed_m_per_s;
  move_for(0.07 / speed, direction({0, 0, -speed}), [](const ProxyState&) {});
  move_for(0.1 / speed, direction({0, 0, speed}), [](const ProxyState&) {});
  const ProxyState state = hand_.follow(goal_);
  if (GetParam().turn_rad_per_s == 0.0) {
    EXPECT_FALSE(state.in_contact);
    EXPECT_EQ(state.proxy, goal_);
  }
}

TEST_P(MovingPlate, SlidesPastSideways) {
  const double speed = GetParam().speed_m_per_s;
  move_for(0.055 / speed, direction({0, 0, -speed}), [](const ProxyState&) {});
  double lag_before = std::numeric_limits<double>::infinity();
  move_for(0.3 / speed, direction({0.8 * speed, 0.6 * speed, 0}), [&](const ProxyState& state) {
    if (GetParam().turn_rad_per_s != 0.0) return;
    const double lag = (state.proxy - goal_).norm();
    EXPECT_LE(lag, lag_before + 4 * hand_.god_object().scale().stand_off_m);
    lag_before = lag;
  });
  if (GetParam().turn_rad_per_s == 0.0) {
    EXPECT_FALSE(hand_.follow(goal_).in_contact);
  }
}

std::vector<PlateCase> plate_cases() {
  std::vector<PlateCase> cases;
  for (const double speed : {0.1, 1.0}) {
    for (const double turn : {0.0, 2.0}) {
      for (const bool is_closed : {true, false}) {
        for (const double radius : {0.0, 0.003}) {
          cases.push_back({speed, turn, is_closed, radius});
        }
      }
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Speeds, MovingPlate, testing::ValuesIn(plate_cases()),
                         [](const testing::TestParamInfo<PlateCase>& plate_case) {
                           const PlateCase& c = plate_case.param;
                           return std::string(c.speed_m_per_s < 1.0 ? "Slow" : "Fast") +
                                  (c.turn_rad_per_s > 0.0 ? "Turning" : "Straight") +
                                  (c.is_closed ? "Closed" : "Sheet") +
                                  (c.radius_m > 0.0 ? "Sphere" : "Point");
                         });

// A plate descends on the hand, which is between the plate and a floor at rest.
TEST(MovingBodies, AreHeldBackWhileTheHandHasNoSpace) {
  for (const double radius_m : {0.0, 0.002}) {
    const OwnedBodies bodies({{test::box_soup({0.2, 0.2, 0.01}), {}},
                              {plate(true), {Quat::Identity(), Vec3(0.0, 0.0, 0.05)}}},
                             radius_m);
    JudgedProxy hand(bodies, radius_m);
    const Vec3 goal(0.001, 0.002, 0.0);  // inside the floor
    hand.god_object().place({0.001, 0.002, 0.02});
    ProxyState state;
    RigidTransform pose = bodies.world().bodies[1].T_solver_body;
    bool was_held = false;
    for (int n = 0; n < 60; ++n) {
      pose.translation_m.z() -= 1e-3;
      was_held |= !hand.move(1, pose);
      state = hand.follow(goal);
    }
    EXPECT_TRUE(was_held);
    EXPECT_GT(state.proxy.z(), 0.01);
    pose.translation_m.z() = 0.04;
    EXPECT_TRUE(hand.move(1, pose));
    EXPECT_NEAR(hand.follow(goal).proxy.z(), 0.01 + radius_m, 1e-9);
  }
}

// A wall that moves along the floor of a wedge pushes the hand up the wedge.
TEST(MovingBodies, PushTheHandAlongAnObstacle) {
  Soup ramp;  // rises by 1/2 to the right
  ramp.add_quad({-0.2, -0.2, -0.1}, {0.2, -0.2, 0.1}, {0.2, 0.2, 0.1}, {-0.2, 0.2, -0.1});
  Soup wall;
  wall.add_quad({0, -0.2, -0.3}, {0, 0.2, -0.3}, {0, 0.2, 0.3}, {0, -0.2, 0.3});
  const OwnedBodies bodies({{ramp, {}}, {wall, {Quat::Identity(), Vec3(-0.05, 0, 0)}}});
  JudgedProxy hand(bodies, 0.0);
  const Vec3 goal(0.0, 0.01, -0.05);  // below the ramp
  hand.god_object().place({0.0, 0.01, 0.01});
  hand.follow(goal);
  RigidTransform pose = bodies.world().bodies[1].T_solver_body;
  for (int n = 0; n < 100; ++n) {
    pose.translation_m.x() += 1e-3;
    ASSERT_TRUE(hand.move(1, pose)) << n;
    const Vec3 proxy = hand.follow(goal).proxy;
    const double nearest_x = 0.8 * (0.0 + 0.5 * -0.05);  // point of the ramp nearest to the goal
    EXPECT_NEAR(proxy.x(), std::max(pose.translation_m.x(), nearest_x), 1e-9);
    EXPECT_NEAR(proxy.z(), 0.5 * proxy.x(), 1e-9);
  }
}

// Two plates of one node are nearer to each other than the distance that they move in a tick.
TEST(MovingBodies, MovingTogetherCarryTheHandBetweenThem) {
  const RigidTransform low{Quat::Identity(), Vec3(0, 0, -0.0002)};
  const RigidTransform high{Quat::Identity(), Vec3(0, 0, 0.0003)};
  for (const double speed : {1.0, -1.0}) {
    const OwnedBodies bodies({{plate(false), low}, {plate(false), high}});
    auto hand = test::made(GodObject::create(bodies.world(), {}));
    hand.place(Vec3::Zero());
    for (int n = 1; n <= 200; ++n) {
      const Vec3 by(0, 0, n * kTick_s * speed);
      const BodyMotion motions[] = {{0, moved(low, by, Vec3::Zero())},
                                    {1, moved(high, by, Vec3::Zero())}};
      ASSERT_EQ(hand.move_bodies(motions), 0u) << n;
      hand.move_to(Vec3::Zero());
      ASSERT_GT(hand.proxy().z(), -0.0002 + by.z());
      ASSERT_LT(hand.proxy().z(), 0.0003 + by.z());
    }
  }
}

// All bodies and the hand move randomly.
TEST(MovingBodies, NeverPassTheHandForAnyMotion) {
  int contacts = 0;
  const std::uint64_t scenes = random_scenes();
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    Random random(seed);
    const double radius_m = random.index(2) ? 0.0 : random.uniform(1e-4, 5e-3);
    std::vector<OwnedBodies::Placed> placed;
    for (int b = 0; b < 3; ++b) {
      const auto kind = test::kAllHardKinds[random.index(std::size(test::kAllHardKinds))];
      placed.push_back({hard_scene(kind, random).soup, random.pose(0.1)});
    }
    const OwnedBodies bodies(placed, radius_m);
    JudgedProxy hand(bodies, radius_m);
    Vec3 start = Vec3::Zero();
    const auto is_free = [&](const Vec3& p) {
      for (std::uint32_t b = 0; b < 3; ++b) {
        if (hand.judge(b).distance_m(hand.placed(b).to_body(p)) <= 1.5 * radius_m + 1e-6) {
          return false;
        }
      }
      return true;
    };
    while (!is_free(start)) start = random.in_box(0.3);
    hand.god_object().place(start);
    Vec3 goal = start;
    Vec3 aim_body = Vec3::Zero();
    std::uint32_t aimed_body = 0;
    for (int n = 0; n < 200; ++n) {
      for (std::uint32_t b = 0; b < 2; ++b) {  // the third rests
        const RigidTransform& now = hand.placed(b).T_solver_body;
        const double leap = random.index(10) == 0 ? 0.1 : 2e-3;
        const Vec3 home = -0.02 * now.translation_m;
        hand.move(b, moved(now, random.in_box(leap) + home, random.in_box(10 * leap)));
      }
      // From time to time, the hand moves towards another triangle of any body and through it.
      if (n % 25 == 0) {
        aimed_body = static_cast<std::uint32_t>(random.index(3));
        const auto& triangles = hand.judge(aimed_body).triangles();
        aim_body = triangles[random.index(triangles.size())].a + random.in_box(2e-3);
      }
      const Vec3 aim = hand.placed(aimed_body).to_solver(aim_body);
      goal += random.uniform(0.0, 0.3) * (aim - goal) + random.in_box(1e-3);
      contacts += hand.follow(goal).in_contact;
      ASSERT_FALSE(HasFailure()) << "tick " << n << ", radius " << radius_m;
    }
  }
  EXPECT_GT(contacts, 1000);
}

// A common motion of all bodies and the hand changes the proxy by rounding only.
TEST(MovingBodies, MovingWithTheHandGiveTheSameProxyAsBodiesAtRest) {
  Random random(5);
  const RigidTransform at_first = random.pose(0.05);
  const OwnedBodies bodies({{test::box_soup({0.05, 0.06, 0.07}), at_first}});
  auto resting = test::made(GodObject::create(bodies.world(), {}));
  auto moving = test::made(GodObject::create(bodies.world(), {}));
  const Vec3 start = at_first.point(Vec3(0.0, 0.0, 0.1));
  resting.place(start);
  moving.place(start);
  Vec3 goal_body(0.0, 0.0, 0.1);
  RigidTransform pose = at_first;
  const double tolerance = 1e3 * resting.scale().stand_off_m;  // a thousand ticks of rounding
  for (int n = 0; n < 1000; ++n) {
    goal_body = 0.97 * goal_body + random.in_box(0.004);
    pose = moved(pose, random.in_box(1e-3), random.in_box(1e-2));
    resting.move_to(at_first.point(goal_body));
    const BodyMotion motion{0, pose};
    ASSERT_EQ(moving.move_bodies(std::span(&motion, 1)), 0u);
    moving.move_to(pose.point(goal_body));
    const Vec3 difference =
        at_first.inverse_point(resting.proxy()) - pose.inverse_point(moving.proxy());
    ASSERT_LT(difference.norm(), tolerance) << n;
  }
}

TEST(MovingBodies, AfterStoppingGiveTheSameProxyAsBodiesThatNeverMoved) {
  Random random(6);
  const RigidTransform there = random.pose(0.05);
  const Soup box = test::box_soup({0.05, 0.06, 0.07});
  const OwnedBodies bodies({{box, there}});
  auto resting = test::made(GodObject::create(bodies.world(), {}));
  auto moved_there = test::made(GodObject::create(bodies.world(), {}));
  ASSERT_TRUE(moved_there.place_body(0, random.pose(0.05)));
  ASSERT_TRUE(moved_there.place_body(0, there));
  const Vec3 start(0.2, 0.1, 0.1);
  resting.place(start);
  moved_there.place(start);
  Vec3 goal = start;
  for (int n = 0; n < 2000; ++n) {
    goal = 0.97 * goal + random.in_box(0.004);
    const ProxyState a = resting.move_to(goal);
    const ProxyState b = moved_there.move_to(goal);
    ASSERT_EQ(a.proxy, b.proxy) << n;
    ASSERT_EQ(a.normal, b.normal) << n;
  }
}

// Bodies found by a tree give the same results as bodies tested one by one.
TEST(ManyBodies, GiveTheSameProxyWithAndWithoutATree) {
  for (const double radius_m : {0.0, 0.004}) {
    Random random(8);
    std::vector<OwnedBodies::Placed> placed;
    for (int b = 0; b < 300; ++b) {
      placed.push_back({test::box_soup({0.01, 0.012, 0.008}), random.pose(0.1)});
    }
    const OwnedBodies with_tree(placed, radius_m, true);
    const OwnedBodies without(placed, radius_m, false);
    auto a = test::made(GodObject::create(with_tree.world(), {radius_m, {}}));
    auto b = test::made(GodObject::create(without.world(), {radius_m, {}}));
    Vec3 goal(0.2, 0.2, 0.2);
    a.place(goal);
    b.place(goal);
    int contacts = 0;
    for (int n = 0; n < 4000; ++n) {
      goal = 0.99 * goal + random.in_box(0.004);
      if (n % 500 == 0) goal = random.in_box(0.3);
      const ProxyState at_a = a.move_to(goal);
      const ProxyState at_b = b.move_to(goal);
      ASSERT_EQ(at_a.proxy, at_b.proxy) << n;
      ASSERT_EQ(at_a.normal, at_b.normal) << n;
      contacts += at_a.in_contact;
    }
    EXPECT_GT(contacts, 500);
  }
}

// More bodies are near the proxy than the cache can hold. Rooms enclose all of them; the walls of
// the rooms are far away, but their boxes contain everything.
TEST(ManyBodies, CrowdedInRoomsGiveTheSameProxyWithAndWithoutATree) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    std::vector<OwnedBodies::Placed> placed;
    for (int b = 0; b < 60; ++b) {
      placed.push_back({test::box_soup({0.01, 0.012, 0.008}), random.pose(0.03)});
    }
    for (const double half_m : {0.2, 0.21, 0.22}) {
      placed.push_back({test::box_soup(Vec3::Constant(half_m)), {}});
    }
    const OwnedBodies with_tree(placed, 0.0, true);
    const OwnedBodies without(placed, 0.0, false);
    JudgedProxy a(with_tree, 0.0);
    auto b = test::made(GodObject::create(without.world(), {}));
    Vec3 goal(0.1, 0.1, 0.1);
    a.god_object().place(goal);
    b.place(goal);
    for (int n = 0; n < 300; ++n) {
      goal = 0.97 * goal + random.in_box(0.006);
      ASSERT_EQ(a.follow(goal).proxy, b.move_to(goal).proxy) << n;
    }
    ASSERT_FALSE(HasFailure());
  }
}

TEST(ManyBodies, AtOnePositionDoNotExceedTheCapacityForContacts) {
  const std::vector<OwnedBodies::Placed> placed(2000, {test::box_soup(Vec3::Constant(0.1)), {}});
  const OwnedBodies bodies(placed, 0.0, true);
  auto hand = test::made(GodObject::create(bodies.world(), {}));
  hand.place({0.1, 0.02, 0.03});  // on the surface of every body
  EXPECT_TRUE(hand.move_to({0.05, 0.02, 0.03}).in_contact);
  EXPECT_NEAR(hand.proxy().x(), 0.1, 1e-9);
}

// Planes that close at a small angle could push the hand out arbitrarily far.
TEST(MovingBodies, DoNotThrowTheHand) {
  for (const double angle_rad : {1e-2, 1e-3, 1e-5, 1e-8, 0.0}) {
    const Quat tilt(Eigen::AngleAxisd(angle_rad, Vec3::UnitY()));
    const OwnedBodies bodies({{plate(true), {}}, {plate(true), {tilt, Vec3(0.0, 0.0, 0.01)}}});
    JudgedProxy hand(bodies, 0.0);
    const Vec3 goal(0.001, 0.002, -0.01);
    hand.god_object().place({0.001, 0.002, 0.005});
    RigidTransform pose = bodies.world().bodies[1].T_solver_body;
    for (int n = 0; n < 12; ++n) {
      const Vec3 before = hand.proxy();
      pose.translation_m.z() -= 1e-3;
      hand.move(1, pose);
      EXPECT_LT((hand.proxy() - before).norm(), 0.2) << angle_rad;
      hand.follow(goal);
    }
  }
}

ActuationModel fully_actuated() {
  return *ActuationModel::from_counts(3, 3);
}

TEST(HapticLoopWithBodies, RendersAMovingPlateAndReportsInvalidPoses) {
  const RigidTransform at_first{Quat::Identity(), Vec3(0.0, 0.0, 0.02)};
  const OwnedBodies bodies({{plate(true), at_first}});
  auto loop = test::made(HapticLoop::create(bodies.world(), fully_actuated(), {}));
  const Vec3 hand = Vec3::Zero();
  EXPECT_EQ(loop.tick(hand, kTick_s).faults, kFaultNone);
  RigidTransform pose = at_first;
  for (int n = 0; n < 30; ++n) {
    pose.translation_m.z() -= 1e-3;
    loop.move_body(0, pose);
    EXPECT_EQ(loop.tick(hand, kTick_s).faults, kFaultNone);
  }
  const TickRecord pressed = loop.tick(hand, kTick_s);
  EXPECT_TRUE(pressed.contact);
  EXPECT_NEAR(vec3(pressed.proxy_scene_m).z(), -0.011, 1e-9);
  EXPECT_LT(vec3(pressed.force_device_N).z(), 0.0);

  const double nan = std::numeric_limits<double>::quiet_NaN();
  const RigidTransform bad[] = {
      {Quat::Identity(), Vec3(0, nan, 0)}, {Quat(nan, 0, 0, 0), Vec3::Zero()},
      {Quat(2, 0, 0, 0), Vec3::Zero()},    {Quat(0, 0, 0, 0), Vec3::Zero()},
      {Quat::Identity(), Vec3(1e3, 0, 0)},
  };
  for (const RigidTransform& T : bad) {
    loop.move_body(0, T);
    const TickRecord& record = loop.tick(hand, kTick_s);
    EXPECT_EQ(record.faults, kFaultBadBodyPose);
    EXPECT_EQ(vec3(record.proxy_scene_m), vec3(pressed.proxy_scene_m));
    EXPECT_TRUE(record.contact);
    EXPECT_EQ(loop.tick(hand, kTick_s).faults, kFaultNone);
  }
  loop.move_body(1, {});
  EXPECT_EQ(loop.tick(hand, kTick_s).faults, kFaultBadBodyPose);
}

TEST(HapticLoopWithBodies, KeepsThePlaneOfAPlanarDevice) {
  const double slope_rad = 0.3;
  const Quat tilt(Eigen::AngleAxisd(slope_rad, Vec3::UnitY()));
  RigidTransform pose{tilt, Vec3(-0.05, 0.0, 0.0)};
  Soup wall;
  wall.add_quad({0, -0.2, -0.3}, {0, 0.2, -0.3}, {0, 0.2, 0.3}, {0, -0.2, 0.3});
  const OwnedBodies bodies({{wall, pose}});
  auto loop =
      test::made(HapticLoop::create(bodies.world(), *ActuationModel::from_counts(2, 2), {}));
  loop.tick(Vec3::Zero(), kTick_s);
  for (int n = 0; n < 100; ++n) {
    pose.translation_m.x() += 1e-3;
    loop.move_body(0, pose);
    const TickRecord& record = loop.tick(Vec3::Zero(), kTick_s);
    ASSERT_EQ(record.faults, kFaultNone);
    ASSERT_EQ(vec3(record.proxy_scene_m).z(), 0.0);
    ASSERT_NEAR(vec3(record.proxy_scene_m).x(), std::max(0.0, pose.translation_m.x()), 1e-9);
  }
}

// The length of a quaternion in single precision is not exactly 1, but the pose is accepted.
// Without normalisation, the body would grow slightly in each tick and pass a proxy that friction
// holds.
TEST(MovingBodies, WithPosesInSinglePrecisionNeverPassTheProxy) {
  test::SameCone cone({0.5, 0.4});
  const FrictionSource sticky{cone};
  const Vec3 half_m(0.05, 0.04, 0.03);
  for (const double radius_m : {0.0, 0.002}) {
    const OwnedBodies bodies({{test::box_soup(half_m), {}}}, radius_m);
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      Random random(seed);
      auto god_object = test::made(GodObject::create(bodies.world(), {radius_m, {}}));
      god_object.place({0.01, 0.01, 0.06});
      const Vec3 axis = random.unit_vector();
      for (int n = 1; n <= 400; ++n) {
        const Quat exact(Eigen::AngleAxisd(1e-3 * n, axis));
        const RigidTransform pose{exact.cast<float>().cast<double>(), Vec3::Zero()};
        const BodyMotion motion{0, pose};
        god_object.move_bodies({&motion, 1});
        const Vec3 goal = pose.point(Vec3(0.01 + 3e-5 * n, 0.01, 0.02));
        god_object.move_with_friction(goal, std::nullopt, sticky);
        const Vec3 p_body = god_object.world().body(0).to_body(god_object.proxy());
        ASSERT_GE((p_body.cwiseAbs() - half_m).maxCoeff(), radius_m) << "tick " << n;
      }
    }
  }
}

// A body that was held during invalid samples moves again when samples are valid.
TEST(HapticLoopWithBodies, HoldsBodiesWhileSamplesAreBad) {
  const RigidTransform at_first{Quat::Identity(), Vec3(0.0, 0.0, 0.02)};
  const OwnedBodies bodies({{plate(true), at_first}});
  auto loop = test::made(HapticLoop::create(bodies.world(), fully_actuated(), {}));
  loop.tick(Vec3::Zero(), kTick_s);
  loop.move_body(0, {Quat::Identity(), Vec3(0.0, 0.0, -0.02)});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(vec3(loop.tick(Vec3(nan, 0, 0), kTick_s).force_device_N), Vec3::Zero());
  const TickRecord& after = loop.tick(Vec3::Zero(), kTick_s);
  EXPECT_NEAR(vec3(after.proxy_scene_m).z(), -0.021, 1e-9);
}

}  // namespace
}  // namespace palpate
