// No proxy leaks, for any scene and any motion of the device. Every piece of the path that a tick
// commits is judged against every triangle (exact_judge.h): a point must touch no triangle, and the
// centre of a sphere must keep its radius from all triangles. Consecutive pieces and ticks share
// their end points, so that these tests prove the whole path free. They do not assume that surfaces
// are closed. A slit that the proxy fits through is a hole: passing it touches nothing. The parity
// of closed bodies is an independent second test.
//
// The seed determines a scene: PALPATE_SEED=N runs only scene N, with the same random numbers as
// among the others; PALPATE_FIRST_SCENE=N begins with scene N.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "haptics/proxy/anisotropic_norm.h"
#include "haptics/proxy/god_object.h"
#include "tests/haptics/proxy/judging_tolerances.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/hard_scenes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/rest_judge.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::Corners;
using test::DeviceMotion;
using test::ExactJudge;
using test::hard_scene;
using test::HardKind;
using test::HardScene;
using test::hex;
using test::in_soak_or_else;
using test::kEpsilon;
using test::kNearUlps;
using test::OwnedWorld;
using test::Random;
using test::SameCone;
using test::Soup;
using test::Violation;

// In a soak test, the kinds together have 1e7 ticks.
int ticks_per_kind() {
  return in_soak_or_else(920'000, 10'000);
}
int ticks_per_scene() {
  return in_soak_or_else(4'000, 500);
}

constexpr std::uint64_t kFirstScene = 1;

double pick_radius_m(Random& random) {
  constexpr double kRadii_m[] = {0.4e-6, 0.6e-6, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2};
  return random.index(2) ? 0.0 : kRadii_m[random.index(std::size(kRadii_m))];
}

struct LeakTotals {
  int ticks = 0;
  int contacts = 0;
  int capped = 0;
  int held = 0;    // contacts with friction
  int rested = 0;  // contacts with friction that did not slide
  int most_iterations = 0;
  std::size_t scenes = 0;
  std::size_t triangles = 0;
};

enum class Proxy : std::uint8_t { kFree, kUnderFriction, kInNorm };

// A run of one proxy and one device in one scene.
class HardSceneRun {
 public:
  HardSceneRun(HardKind kind, Random& random, Proxy proxy)
      : random_(random),
        scene_(hard_scene(kind, random)),
        radius_m_(proxy == Proxy::kInNorm ? 0.0 : pick_radius_m(random)),
        world_(scene_.soup, {}, radius_m_),
        judge_(test::solver_triangles(world_)),
        god_object_(test::made(GodObject::create(world_.world(), {.radius_m = radius_m_}))),
        position_roundoff_m_(kEpsilon * world_.world().size_m),
        start_(pick_start()),
        motion_(judge_.triangles(), aims(), start_, random) {
    if (random.index(5) == 0) plane_normal_ = pick_plane();
    god_object_.place(start_);
    was_inside_ = scene_.is_closed && judge_.is_inside(start_);
    state_.proxy = start_;
    if (proxy == Proxy::kUnderFriction) cone_.emplace(pick_cone());
    if (proxy == Proxy::kInNorm) norm_.emplace(pick_norm());
  }

  const ExactJudge& judge() const { return judge_; }
  const OwnedWorld& world() const { return world_; }

  // Simulates and judges a tick. True if no judgement failed.
  bool tick(LeakTotals& totals) {
    goal_ = motion_.next_goal(state_);
    if (plane_normal_) goal_ -= plane_normal_->dot(goal_ - state_.proxy) * *plane_normal_;
    const Vec3 before = god_object_.proxy();
    state_ = cone_   ? god_object_.move_with_friction(goal_, plane_normal_, friction())
             : norm_ ? god_object_.move_in_norm(goal_, plane_normal_, *norm_)
                     : god_object_.move_to(goal_, plane_normal_);
    ++tick_;
    ++totals.ticks;
    totals.held += state_.is_held;
    totals.rested += state_.is_held && !state_.slid;
    totals.contacts += state_.in_contact;
    totals.capped += state_.capped;
    totals.most_iterations = std::max(totals.most_iterations, state_.iterations);
    return path_is_whole(before) && does_not_leak() && never_goes_farther() && keeps_side();
  }

 private:
  std::vector<Vec3> aims() const {
    std::vector<Vec3> solver;
    for (const Vec3& p : scene_.aims) solver.push_back(world_.world().to_solver(p));
    return solver;
  }

  // A start that the proxy fits in, usually near a face.
  Vec3 pick_start() {
    for (int trial = 0;; ++trial) {
      const std::vector<Corners>& all = judge_.triangles();
      const Corners& t = all[random_.index(all.size())];
      const double away_m = radius_m_ + std::pow(10.0, random_.uniform(-7.0, -2.0));
      Vec3 start = (t.a + t.b + t.c) / 3.0 + away_m * random_.unit_vector();
      if (trial > 50) start = random_.in_box(0.2 + 4 * radius_m_);
      if (judge_.distance_m(start) > radius_m_ + 1e-8 * world_.world().size_m) return start;
    }
  }

  Vec3 pick_plane() {
    return random_.index(2) ? random_.unit_vector() : Vec3(Vec3::Unit(random_.index(3)));
  }

  // Coefficients from low to high friction, with or without a gap between static and dynamic
  // friction, which causes stick-slip.
  FrictionCone pick_cone() {
    const double mu_s = random_.index(3) ? random_.uniform(0.0, 1.5) : random_.uniform(0.0, 10.0);
    return {mu_s, random_.index(2) ? mu_s : mu_s * random_.uniform(0.0, 1.0)};
  }

  FrictionSource friction() { return FrictionSource{*cone_}; }

  // The norm of a device with no, one or two motors. In a plane of motion, the motors are in the
  // plane, as those of a device with two sensors.
  AnisotropicNorm pick_norm() {
    std::vector<Vec3> axes;
    Vec3 axis = random_.unit_vector();
    if (plane_normal_) axis -= axis.dot(*plane_normal_) * *plane_normal_;
    if (random_.index(8) != 0) axes.push_back(axis.normalized());
    if (!plane_normal_ && !axes.empty() && random_.index(2) == 0) {
      axes.push_back(axes[0].unitOrthogonal());
    }
    return AnisotropicNorm(std::pow(16.0, random_.uniform(-1.0, 1.0)), axes);
  }

  testing::Message where() const {
    testing::Message message;
    message << "tick " << tick_ << ", radius " << radius_m_ << " m, goal " << hex(goal_);
    if (cone_) {
      message << ", friction " << cone_->cone.static_friction << ", "
              << cone_->cone.dynamic_friction;
    }
    if (plane_normal_) message << ", in the plane with normal " << hex(*plane_normal_);
    message << "\npath:";
    for (const Vec3& p : god_object_.path()) message << "\n  " << hex(p);
    return message;
  }

  bool path_is_whole(const Vec3& before) {
    const auto path = god_object_.path();
    const bool whole = !path.empty() && path.front() == before && path.back() == state_.proxy &&
                       god_object_.proxy() == state_.proxy && state_.proxy.allFinite() &&
                       state_.normal.allFinite() &&
                       state_.iterations <= GodObjectSettings{}.accuracy.iterations;
    EXPECT_TRUE(whole) << where();
    return whole;
  }

  bool does_not_leak() {
    const auto path = god_object_.path();
    const double least_m = radius_m_ - kNearUlps * position_roundoff_m_;
    const std::optional<Violation> violation =
        radius_m_ == 0.0 ? judge_.touch_of_point(path) : judge_.touch_of_sphere(path, least_m);
    if (!violation) return true;
    const Corners& t = judge_.triangles()[violation->triangle];
    ADD_FAILURE() << "piece " << violation->piece << " is " << violation->distance_m
                  << " m from triangle " << violation->triangle << " " << hex(t.a) << " "
                  << hex(t.b) << " " << hex(t.c) << "\n"
                  << where();
    return false;
  }

  // Tests that no piece of a point's path increases the distance to the goal, in the norm of the
  // proxy, and that no tick of a sphere does.
  bool never_goes_farther() {
    const auto to_goal_m = [&](const Vec3& v) { return norm_ ? norm_->length(v) : v.norm(); };
    // The norm weighs the rounding of positions by up to 4, the root of the largest anisotropy.
    const double round_m = (norm_ ? 4.0 : 1.0) * position_roundoff_m_;
    const auto farther = test::moves_away(god_object_.path(), goal_, radius_m_, round_m, to_goal_m);
    if (!farther) return true;
    ADD_FAILURE() << "piece " << farther->piece << " increases the distance to the goal by "
                  << farther->by_m << " m\n"
                  << where();
    return false;
  }

  bool keeps_side() {
    if (!scene_.is_closed || tick_ % 64 != 0) return true;
    const bool is_inside = judge_.is_inside(state_.proxy);
    EXPECT_EQ(is_inside, was_inside_) << where();
    return is_inside == was_inside_;
  }

  Random& random_;
  HardScene scene_;
  double radius_m_;
  OwnedWorld world_;
  ExactJudge judge_;
  GodObject god_object_;
  double position_roundoff_m_;
  Vec3 start_;
  DeviceMotion motion_;
  std::optional<Vec3> plane_normal_;
  std::optional<SameCone> cone_;
  std::optional<AnisotropicNorm> norm_;
  ProxyState state_;
  Vec3 goal_ = Vec3::Zero();
  bool was_inside_ = false;
  int tick_ = 0;
};

class HardScenes : public testing::TestWithParam<HardKind> {};

void expect_no_leak(HardKind kind, Proxy proxy) {
  constexpr int kEnoughFailures = 5;
  LeakTotals totals;
  int failures = 0;
  const int ticks = ticks_per_scene();
  for (std::uint64_t scene = test::from_environment("PALPATE_FIRST_SCENE", kFirstScene);
       totals.ticks < ticks_per_kind(); ++scene) {
    Random random(scene);
    HardSceneRun run(kind, random, proxy);
    totals.triangles += run.judge().triangles().size();
    ++totals.scenes;
    for (int tick = 0; tick < ticks; ++tick) {
      if (run.tick(totals)) continue;
      ++failures;
      break;
    }
    if (failures == kEnoughFailures || std::getenv("PALPATE_SEED")) break;
  }
  testing::Test::RecordProperty("scenes", static_cast<int>(totals.scenes));
  testing::Test::RecordProperty("triangles", static_cast<int>(totals.triangles));
  testing::Test::RecordProperty("ticks", totals.ticks);
  testing::Test::RecordProperty("ticks_in_contact", totals.contacts);
  testing::Test::RecordProperty("ticks_capped", totals.capped);
  testing::Test::RecordProperty("most_iterations", totals.most_iterations);
  std::printf("%zu scenes, %d ticks, %d in contact, %d capped, at most %d iterations",
              totals.scenes, totals.ticks, totals.contacts, totals.capped, totals.most_iterations);
  if (proxy == Proxy::kUnderFriction)
    std::printf(", %d held, %d at rest", totals.held, totals.rested);
  std::printf("\n");
}

TEST_P(HardScenes, NeverLetTheProxyThrough) {
  expect_no_leak(GetParam(), Proxy::kFree);
}

// The start and the device of each scene are the same as without friction.
TEST_P(HardScenes, NeverLetTheProxyThroughUnderFriction) {
  expect_no_leak(GetParam(), Proxy::kUnderFriction);
}

TEST_P(HardScenes, NeverLetAPointThroughInAnAnisotropicNorm) {
  expect_no_leak(GetParam(), Proxy::kInNorm);
}

INSTANTIATE_TEST_SUITE_P(Of, HardScenes, testing::ValuesIn(test::kAllHardKinds),
                         [](const auto& kind) { return test::name_of(kind.param); });

// The judge must use the coordinates of the engine's index bit for bit.
TEST(HardScene, IsJudgedAtTheCoordinatesOfTheIndex) {
  for (const HardKind kind : test::kAllHardKinds) {
    Random random(71);
    const OwnedWorld world(hard_scene(kind, random).soup);
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 high = -low;
    for (const Corners& t : test::solver_triangles(world)) {
      low = low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
      high = high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
    }
    EXPECT_EQ(world.index().box().low, low) << test::name_of(kind);
    EXPECT_EQ(world.index().box().high, high) << test::name_of(kind);
  }
}

TEST(HardScene, OfAClosedKindHasAnInsideAndAnOutside) {
  for (const HardKind kind : {HardKind::kWedge, HardKind::kNeedle, HardKind::kSliver}) {
    Random random(72);
    for (int trial = 0; trial < 50; ++trial) {
      const OwnedWorld world(hard_scene(kind, random).soup);
      EXPECT_EQ(world.mesh().report().boundary_edges, 0u) << test::name_of(kind);
      const ExactJudge judge(test::solver_triangles(world));
      EXPECT_FALSE(judge.is_inside(random.unit_vector()));
    }
  }
}

// Leaks that these scenes once found, each reduced to one triangle. Two small triangles far away
// place the middle of the world exactly at the origin, so that the coordinates keep their bits.
struct FoundLeak {
  const char* name;
  double radius_m;
  Corners triangle;
  std::vector<Vec3> path;  // start of the proxy and the goals
};

void PrintTo(const FoundLeak& leak, std::ostream* out) {
  *out << leak.name;
}

std::vector<FoundLeak> found_leaks() {
  return {
      // Scene 4 of the wedges: the step is free along the rounded difference of its ends, but not
      // between the ends themselves.
      {"PastAnEdge",
       0.0,
       {{0x1.2c0c4988089acp-8, -0x1.85f3160a66e4p-11, 0x1.9080b33174c82p-4},
        {-0x1.19494f9ec06bep-4, -0x1.4707731d710fep-7, 0x1.1254c1b28eb3p-4},
        {-0x1.2c0c4988089acp-8, -0x1.08c1933642246p-4, -0x1.1ad9d7f40aa67p-4}},
       {{0x1.0189b0eca7d86p-6, 0x1.a420d3ed31a8ep-6, 0x1.b1b53d9e57cacp-4},
        {-0x1.24ae30cf73641p-3, -0x1.6b16bec1bb343p-5, 0x1.08e46ed8a0c84p-5}}},
      // Scene 1831 of the wedges: the proxy is in the plane of a face to within rounding, beside
      // its
      // corner, and moves from there under the face.
      {"FromTheRimOfAPlane",
       0.0,
       {{0x1.9045eb5b900fcp-6, 0x1.7996051c5a8p-9, -0x1.992b9e1b722p-9},
        {-0x1.4448ccefff924p-4, -0x1.05a5157a8afap-4, -0x1.949a17dbf13d2p-5},
        {-0x1.47f2c511dc2a5p-4, 0x1.915c7f6b4bp-15, -0x1.54b3aad4c8cp-10}},
       {{-0x1.7p-4, 0x1p-10, 0x1p-8},
        {-0x1.47f2c511ffa8dp-4, 0x1.915c7f6398512p-15, -0x1.54b3aad4a1241p-10},
        {-0x1.4704ea53b3017p-4, -0x1.cf4590a64391p-22, -0x1.6076e3e88c721p-10}}},
      // Scene 118 of the repeated faces: a vertex and an adjacent edge are equally near to the last
      // bit; the choice between them turns the normal by 1e-9 rad.
      {"ByAVertexOrItsEdge",
       0x1.4f8b588e368f1p-17,
       {{-0x1.97f0e3856d9e4p-7, 0x1.1030624be30f8p-7, -0x1.21eb02a3a9b65p-5},
        {0x1.4a91f16999888p-6, -0x1.0bd377dcb2f46p-5, -0x1.74cecc3d0148p-11},
        {-0x1.4c8a315fa8de2p-6, -0x1.f9744eb402854p-6, -0x1.5bf538f4d38fp-7}},
       {{-0x1.4c82de3bedc52p-6, -0x1.f98b6cc7d829ap-6, -0x1.5c39aaa4a9122p-7},
        {-0x1.97e24b384253ap-7, 0x1.1001e07f03a4cp-7, -0x1.21fc14067db22p-5}}},
      // Scene 83 of the coplanar overlaps: the proxy moves along an edge, with a radius so small
      // that
      // the normal has few exact digits.
      {"AlongAnEdge",
       0x1.ad7f29abcaf48p-22,
       {{-0x1.9ce5a22706f68p-8, 0x1.76a44ed7553fdp-5, 0x0p+0},
        {0x1.bcbda6eaa6241p-5, -0x1.ab852a54ee7f5p-5, 0x0p+0},
        {0x1.74d204a7f4ae5p-5, 0x1.b457b6c23ed44p-4, 0x0p+0}},
       {{0x1.98c8940b84c0ep-5, 0x1.bd2dc490c8e7cp-6, -0x1.17559ce57p-38},
        {0x1.bdefc034640edp-5, -0x1.c113bf96009b4p-5, -0x1.17552c71bp-38}}},
  };
}

class Found : public testing::TestWithParam<FoundLeak> {};

TEST_P(Found, LeakIsClosed) {
  const auto& [name, radius_m, t, path] = GetParam();
  Soup soup;
  soup.add(t.a, t.b, t.c);
  constexpr double kFar_m = 0.125;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 speck = Vec3::Constant(side * kFar_m);
    soup.add(speck, 0.999 * speck, speck - side * Vec3(1e-4, 0.0, 0.0));
  }
  const OwnedWorld world(soup, {}, radius_m);
  ASSERT_EQ(world.world().anchor_scene_m, Vec3(Vec3::Zero()));
  const ExactJudge judge(test::solver_triangles(world));
  const double least_m = radius_m - kNearUlps * kEpsilon * world.world().size_m;
  auto god_object = test::made(GodObject::create(world.world(), {.radius_m = radius_m}));
  god_object.place(path.front());
  ASSERT_EQ(god_object.proxy(), path.front());
  for (std::size_t i = 1; i < path.size(); ++i) {
    god_object.move_to(path[i]);
    const auto violation = radius_m == 0.0 ? judge.touch_of_point(god_object.path())
                                           : judge.touch_of_sphere(god_object.path(), least_m);
    EXPECT_FALSE(violation) << "on the path to goal " << i << ", "
                            << (violation ? radius_m - violation->distance_m : 0.0)
                            << " m too near";
  }
}

INSTANTIATE_TEST_SUITE_P(By, Found, testing::ValuesIn(found_leaks()),
                         [](const auto& leak) { return leak.param.name; });

// A slit of 1 um in a sheet, in random poses. The hand moves through its middle.
class Slit : public testing::TestWithParam<double> {};

TEST_P(Slit, LetsOnlyNarrowerProxiesThrough) {
  const double radius_m = GetParam();
  const bool fits = 2 * radius_m < test::kGapWidth_m;
  Random random(73);
  for (int trial = 0; trial < 200; ++trial) {
    const RigidTransform pose = random.pose(0.1);
    Soup soup;
    const double half = 0.5 * test::kGapWidth_m;
    const double side = 0.08;
    soup.add_quad(pose.point({half, -side, 0}), pose.point({side, -side, 0}),
                  pose.point({side, side, 0}), pose.point({half, side, 0}));
    soup.add_quad(pose.point({-side, -side, 0}), pose.point({-half, -side, 0}),
                  pose.point({-half, side, 0}), pose.point({-side, side, 0}));
    const OwnedWorld world(soup, {}, radius_m);
    const ExactJudge judge(test::solver_triangles(world));
    auto god_object = test::made(GodObject::create(world.world(), {.radius_m = radius_m}));
    const double y = random.uniform(-0.07, 0.07);
    const double height_m = radius_m + std::pow(10.0, random.uniform(-6.0, -2.0));
    god_object.place(world.world().to_solver(pose.point({0, y, height_m})));
    const Vec3 goal = world.world().to_solver(pose.point({0, y, -height_m}));
    const ProxyState state = god_object.move_to(goal);
    EXPECT_EQ(state.in_contact, !fits);
    if (fits) {
      ASSERT_EQ(state.proxy, goal);
    } else {
      const double z = pose.inverse_point(world.world().to_scene(state.proxy)).z();
      ASSERT_GT(z, 0.0);
    }
    ASSERT_FALSE(judge.touch_of_sphere(god_object.path(),
                                       radius_m - kNearUlps * kEpsilon * world.world().size_m));
  }
}

INSTANTIATE_TEST_SUITE_P(Radii, Slit, testing::Values(0.0, 0.4e-6, 0.6e-6, 1e-6, 1e-5, 1e-3),
                         [](const auto& radius) {
                           return std::to_string(std::lround(radius.param * 1e9)) + "_nm";
                         });

// The faces of a box have cracks of up to 2 um between them. A wider sphere stays on its side of
// the box.
TEST(RaggedBox, HoldsASphereThatIsWiderThanItsCracks) {
  constexpr double kRadii_m[] = {2e-6, 1e-5, 1e-4, 1e-3};
  Random random(74);
  for (int trial = 0; trial < 40; ++trial) {
    const Vec3 half(random.uniform(0.01, 0.1), random.uniform(0.01, 0.1), 0.05);
    const Soup soup = test::ragged_box(half, random);
    const double radius_m = kRadii_m[random.index(std::size(kRadii_m))];
    const OwnedWorld world(soup, {}, radius_m);
    const std::vector<Corners> triangles = test::solver_triangles(world);
    std::vector<Vec3> corners;
    for (const Vec3& p : soup.positions) corners.push_back(world.world().to_solver(p));
    const bool starts_inside = random.index(2);
    ProxyState state;
    state.proxy = starts_inside ? Vec3(Vec3::Zero()) : Vec3(0.0, 0.0, 0.2);
    DeviceMotion motion(triangles, corners, state.proxy, random);
    auto god_object = test::made(GodObject::create(world.world(), {.radius_m = radius_m}));
    god_object.place(state.proxy);
    for (int tick = 0; tick < 200; ++tick) {
      state = god_object.move_to(motion.next_goal(state));
      const Vec3 p = world.world().to_scene(state.proxy);
      const bool is_inside = (p.cwiseAbs() - half).maxCoeff() < 0.0;
      ASSERT_EQ(is_inside, starts_inside) << "trial " << trial << ", tick " << tick;
    }
  }
}

}  // namespace
}  // namespace palpate
