// Invalid settings, goals and poses are refused and named, and they affect neither force nor state.

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/check_settings.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "tests/haptics/three_axes.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/same_cone.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::kInfinity;
using test::kNan;
using test::kTick_s;
using test::OwnedBodies;
using test::OwnedWorld;
using test::Random;
using test::three_axes;

constexpr double kRadius_m = 1e-3;
const Vec3 kHalf_m(0.05, 0.04, 0.03);

HapticSettings good_settings(double radius_m = 0.0) {
  HapticSettings s;
  s.god_object.radius_m = radius_m;
  s.a4.enabled = false;
  return s;
}

struct BadSetting {
  const char* field;
  std::function<void(HapticSettings&)> spoil;
};

// Each field with each of its invalid values.
std::vector<BadSetting> bad_settings() {
  std::vector<BadSetting> all;
  const auto add = [&](const char* field, std::initializer_list<double> values, auto set) {
    for (const double value : values) {
      all.push_back({field, [=](HapticSettings& s) { set(s, value); }});
    }
  };
  add("god_object.radius_m",
      {-1e-3, -0x1p-1074, 0x1p-1074, 1e-100, 1e-14, -kInfinity, kInfinity, kNan, 2e-3, 1.0, 1e300},
      [](HapticSettings& s, double v) { s.god_object.radius_m = v; });
  add("god_object.accuracy.tolerance", {0.0, -0.01, kNan, kInfinity, -kInfinity},
      [](HapticSettings& s, double v) { s.god_object.accuracy.tolerance = v; });
  for (const int iterations : {0, -1, std::numeric_limits<int>::min(),
                               Accuracy::kMostIterations + 1, std::numeric_limits<int>::max()}) {
    all.push_back({"god_object.accuracy.iterations",
                   [=](HapticSettings& s) { s.god_object.accuracy.iterations = iterations; }});
  }
  add("coupling.stiffness_N_per_m", {-1.0, kNan, kInfinity, -kInfinity, 1e300, 1e150},
      [](HapticSettings& s, double v) { s.coupling.stiffness_N_per_m = v; });
  add("coupling.damping_Ns_per_m", {-1.0, kNan, kInfinity, -kInfinity, 1e300, 1e140},
      [](HapticSettings& s, double v) { s.coupling.damping_Ns_per_m = v; });
  add("a4.profile", {0.0, -1.0, kNan, kInfinity}, [](HapticSettings& s, double v) {
    s.a4.enabled = true;
    s.a4.profile.speed_at_knee_rad_per_s = v;
  });
  add("plane_height_m", {kNan, kInfinity},
      [](HapticSettings& s, double v) { s.plane_height_m = v; });
  add("initial_pose", {kNan, kInfinity, 1e12, -1e200},
      [](HapticSettings& s, double v) { s.initial_pose.translation_m.y() = v; });
  add("initial_pose", {kNan, kInfinity, 0.0, 1.001},
      [](HapticSettings& s, double v) { s.initial_pose.rotation = Quat(v, 0, 0, 0); });
  return all;
}

TEST(CheckSettings, NamesTheFieldOutOfRange) {
  const OwnedWorld world(box_soup(kHalf_m), {}, kRadius_m);
  for (const double radius_m : {0.0, 1e-3 * kRadius_m, 0.5 * kRadius_m, kRadius_m}) {
    const auto error = check_settings(world.world(), good_settings(radius_m));
    ASSERT_FALSE(error) << error->to_string();
    for (const Accuracy& preset : {Accuracy::fast(), Accuracy::balanced(), Accuracy::exact()}) {
      ASSERT_FALSE(check_settings(world.world(), GodObjectSettings{radius_m, preset}));
    }
  }
  for (const BadSetting& bad : bad_settings()) {
    HapticSettings settings = good_settings(kRadius_m);
    bad.spoil(settings);
    const auto error = check_settings(world.world(), settings);
    ASSERT_TRUE(error) << bad.field;
    EXPECT_EQ(error->element, bad.field);
    EXPECT_EQ(error->code, ErrorCode::kInvalidArgument);
    EXPECT_NE(error->problem.find("expected"), std::string::npos) << error->to_string();
    const std::string field = bad.field;
    const std::string of_god_object = "god_object.";
    const auto error_alone = check_settings(world.world(), settings.god_object);
    EXPECT_EQ(error_alone.has_value(), field.starts_with(of_god_object)) << field;
    if (error_alone) {
      EXPECT_EQ(of_god_object + error_alone->element, field);
    }
  }
}

// A step sweeps the sphere and its stand-off. A scene is built with one stand-off in reserve.
TEST(CheckSettings, AcceptsRadiiUpToTheOneThatTheIndicesWereBuiltFor) {
  Random random(8101);
  for (int trial = 0; trial < 100; ++trial) {
    const double built_for_m = std::pow(10.0, random.uniform(-6.0, 1.0));
    const OwnedWorld world(box_soup(kHalf_m), random.pose(1.0), built_for_m);
    const double stand_off_m = SolverScale::of(world.world().size_m, built_for_m).stand_off_m;
    const auto is_good = [&](double radius_m) {
      return !check_settings(world.world(), GodObjectSettings{radius_m});
    };
    EXPECT_TRUE(is_good(built_for_m));
    EXPECT_TRUE(is_good(built_for_m + 0.9 * stand_off_m));
    EXPECT_FALSE(is_good(built_for_m + 1.1 * stand_off_m));
    EXPECT_FALSE(is_good(built_for_m * 1.01));
  }
  // A radius that no box in single precision can hold, although the world was built for it.
  const OwnedWorld for_giants(box_soup(kHalf_m), {}, 1e20);
  EXPECT_FALSE(check_settings(for_giants.world(), GodObjectSettings{1e17}));
  EXPECT_TRUE(check_settings(for_giants.world(), GodObjectSettings{1e20}));
  const OwnedWorld for_points(box_soup(kHalf_m));
  EXPECT_TRUE(check_settings(for_points.world(), GodObjectSettings{1e-300}));
  EXPECT_FALSE(check_settings(for_points.world(), GodObjectSettings{0.0}));
}

TEST(CheckSettings, ChecksEveryIndexAndTheTreeOverThem) {
  const std::vector<OwnedBodies::Placed> bodies{
      {box_soup(kHalf_m), {}}, {box_soup(kHalf_m), {Quat::Identity(), Vec3(0.2, 0, 0)}}};
  const OwnedBodies small(bodies, kRadius_m, true);
  const OwnedBodies large(bodies, 4 * kRadius_m, true);
  const GodObjectSettings settings{2 * kRadius_m};
  EXPECT_TRUE(check_settings(small.world(), settings));
  EXPECT_FALSE(check_settings(large.world(), settings));
  ContactWorld one_index = large.world();
  one_index.bodies[1].index = small.world().bodies[1].index;
  EXPECT_TRUE(check_settings(one_index, settings));
  ContactWorld tree_alone = large.world();
  tree_alone.tree = small.world().tree;
  EXPECT_TRUE(check_settings(tree_alone, settings));
}

// At this distance, half of a double's digits are left to resolve the scene's size.
TEST(CheckSettings, LimitsTheDistanceOfTheSceneByTheDigitsOfPositions) {
  Random random(8103);
  for (int trial = 0; trial < 20; ++trial) {
    const double size = std::pow(10.0, random.uniform(-6.0, 3.0));
    const OwnedWorld world(box_soup(size * kHalf_m), random.pose(size));
    const double most_m = farthest_place_m(world.world());
    const double rounding_m = std::nextafter(most_m, HUGE_VAL) - most_m;
    EXPECT_LE(rounding_m, 0x1p-26 * world_extent_m(world.world()));
    HapticSettings settings = good_settings();
    const Vec3 direction = random.rotation() * Vec3::UnitX();
    settings.initial_pose.translation_m = 0.999 * most_m * direction;
    const auto near = check_settings(world.world(), settings);
    EXPECT_FALSE(near) << near->to_string();
    settings.initial_pose.translation_m = 1.001 * most_m * direction;
    const auto far = check_settings(world.world(), settings);
    ASSERT_TRUE(far);
    EXPECT_EQ(far->element, "initial_pose");
  }
}

// With K at its limit, the farthest good sample still gives a force whose square is finite.
TEST(CheckSettings, LimitsTheCouplingByTheLargestLagOfAGoodSample) {
  Random random(8102);
  for (int trial = 0; trial < 20; ++trial) {
    const RigidTransform pose = random.pose(10.0);
    const OwnedWorld world(box_soup(kHalf_m), pose);
    HapticSettings settings = good_settings();
    settings.force = ForceMode::kFull;
    settings.initial_pose = random.pose(5.0);
    const double most = 0.5 * kLargestForce_N / largest_lag_m(world.world(), settings.initial_pose);
    settings.coupling = {most, most * kShortestTick_s};
    ASSERT_FALSE(check_settings(world.world(), settings));
    for (const auto& spoil :
         {std::function([](CouplingSettings& c) { c.stiffness_N_per_m *= 1.01; }),
          std::function([](CouplingSettings& c) { c.damping_Ns_per_m *= 1.01; })}) {
      HapticSettings more = settings;
      spoil(more.coupling);
      EXPECT_TRUE(check_settings(world.world(), more));
    }
    auto loop = test::made(HapticLoop::create(world.world(), three_axes(), settings));
    const double farthest_m =
        farthest_sample_m(world_extent_m(world.world()), settings.initial_pose);
    // The hand presses on the upper face of the box and is then dragged through it, as far as
    // samples may be.
    const auto device = [&](const Vec3& p) { return settings.initial_pose.point(pose.point(p)); };
    ASSERT_EQ(loop.tick(device({0, 0, 0.05}), kTick_s).faults, kFaultNone);
    ASSERT_TRUE(loop.tick(device({0, 0, 0.02}), kTick_s).contact);
    const Vec3 down = settings.initial_pose.direction(pose.direction(-Vec3::UnitZ()));
    loop.tick(0.99 * farthest_m * down,
              kShortestTick_s);  // a jump; the second sample there is good
    const TickRecord& far = loop.tick(0.99 * farthest_m * down, kShortestTick_s);
    ASSERT_EQ(far.faults & kFaultsWithoutForce, 0u);
    EXPECT_TRUE(std::isfinite(vec3(far.force_device_N).squaredNorm()));
    if (far.contact) {
      EXPECT_LE((vec3(far.proxy_scene_m) - vec3(far.goal_scene_m)).norm(),
                largest_lag_m(world.world(), settings.initial_pose));
    }
  }
}

TEST(Misuse, NoLoopIsCreatedWithBadSettings) {
  OwnedBodies bodies(
      {{box_soup(kHalf_m), {}}, {box_soup(kHalf_m), {Quat::Identity(), Vec3(0.2, 0, 0)}}},
      kRadius_m, true);
  test::EffectBodies effects;
  effects.add_body({test::effect_entry<FrictionEffect>({0.5, 0.4, nullptr})});
  effects.add_body_without_effects();
  bodies.set_effects(effects.finish());
  for (const double radius_m : {0.0, 1e-3 * kRadius_m, 0.5 * kRadius_m, kRadius_m}) {
    const auto loop = HapticLoop::create(bodies.world(), three_axes(), good_settings(radius_m));
    ASSERT_TRUE(loop.ok()) << loop.error().to_string();
  }
  for (const BadSetting& bad : bad_settings()) {
    HapticSettings settings = good_settings(kRadius_m);
    bad.spoil(settings);
    const auto loop = HapticLoop::create(bodies.world(), three_axes(), settings);
    ASSERT_FALSE(loop.ok()) << bad.field;
    EXPECT_EQ(loop.error().element, bad.field);
    EXPECT_EQ(loop.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(loop.error().to_string(), check_settings(bodies.world(), settings)->to_string());
  }
}

// The observable state of a god-object, to the bit.
std::vector<double> bits_of(const GodObject& god_object) {
  std::vector<double> bits;
  const auto add = [&](const Vec3& v) { bits.insert(bits.end(), v.begin(), v.end()); };
  add(god_object.proxy());
  for (const Vec3& corner : god_object.path()) add(corner);
  for (const FaceContact& contact : god_object.contacts()) add(contact.normal);
  for (const ContactBody& body : god_object.world().bodies()) {
    add(body.T_solver_body.translation_m);
    for (const double c : body.T_solver_body.rotation.coeffs()) bits.push_back(c);
  }
  add(god_object.world().bounds_solver().low);
  bits.push_back(static_cast<double>(god_object.world().moving().size()));
  return bits;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

test::SameCone sticky_cone({0.5, 0.4});
const FrictionSource kSticky{sticky_cone};

TEST(Misuse, NoGodObjectIsCreatedWithBadSettings) {
  const OwnedWorld world(box_soup(kHalf_m), {}, kRadius_m);
  for (const BadSetting& bad : bad_settings()) {
    HapticSettings settings = good_settings(kRadius_m);
    bad.spoil(settings);
    const bool is_bad = std::string_view(bad.field).starts_with("god_object.");
    const auto error = check_settings(world.world(), settings.god_object);
    const auto god_object = GodObject::create(world.world(), settings.god_object);
    ASSERT_EQ(!god_object.ok(), is_bad) << bad.field;
    ASSERT_EQ(error.has_value(), is_bad) << bad.field;
    if (!is_bad) continue;
    EXPECT_EQ("god_object." + god_object.error().element, bad.field);
    EXPECT_EQ(god_object.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(god_object.error().to_string(), error->to_string());
  }
}

// The invalid calls interrupt a motion along a box, which continues as if they had not been made.
TEST(Misuse, InvalidGoalsAndPosesChangeNothing) {
  Random random(8104);
  SeededRandom normals(8105);
  for (const double radius_m : {0.0, kRadius_m}) {
    const OwnedBodies bodies(
        {{box_soup(kHalf_m), {}}, {box_soup(kHalf_m), {Quat::Identity(), Vec3(0.2, 0, 0)}}},
        radius_m);
    auto misused = test::made(GodObject::create(bodies.world(), {radius_m, {}}));
    auto spared = test::made(GodObject::create(bodies.world(), {radius_m, {}}));
    const auto refuse_all = [&] {
      const auto before = bits_of(misused);
      for (const double bad : {kNan, kInfinity, -kInfinity, 1e200}) {
        Vec3 goal = random.in_box(0.05);
        goal[static_cast<Eigen::Index>(random.index(3))] = bad;
        EXPECT_FALSE(misused.place(goal));
        EXPECT_FALSE(misused.place(Vec3::Zero(), goal)) << "a plane without a normal";
        for (const ProxyState& state :
             {misused.move_to(goal), misused.move_to(goal, Vec3(Vec3::UnitZ())),
              misused.move_with_friction(goal, std::nullopt, kSticky)}) {
          EXPECT_TRUE(state.is_refused);
          EXPECT_FALSE(state.in_contact);
          EXPECT_EQ(state.proxy, misused.proxy());
        }
        BodyMotion motion{0, {Quat::Identity(), goal}};
        EXPECT_EQ(misused.move_bodies({&motion, 1}), 1u);
        EXPECT_FALSE(misused.place_body(0, motion.T_solver_body));
        if (bad == 1e200) continue;
        EXPECT_TRUE(misused.move_to(Vec3::Zero(), goal).is_refused) << "a plane without a normal";
        motion.T_solver_body = {Quat(bad, 0, 0, 1), Vec3::Zero()};
        EXPECT_EQ(misused.move_bodies({&motion, 1}), 1u);
        EXPECT_FALSE(misused.place_body(0, motion.T_solver_body));
      }
      const BodyMotion moved{0, {Quat::Identity(), Vec3(0, 0, 0.001)}};
      for (const double length : {0.0, 0.5, 2.0, 1e200, kInfinity, kNan}) {
        const Vec3 normal = length * normals.unit_vector();
        EXPECT_TRUE(misused.move_to(Vec3::Zero(), normal).is_refused) << length;
        EXPECT_TRUE(misused.move_with_friction(Vec3::Zero(), normal, kSticky).is_refused) << length;
        EXPECT_EQ(misused.move_bodies({&moved, 1}, normal), 1u) << length;
      }
      for (const double size_m : {-1.0, kInfinity, -kInfinity, kNan}) {
        const FrictionSource source{sticky_cone, size_m};
        EXPECT_TRUE(misused.move_with_friction(Vec3::Zero(), std::nullopt, source).is_refused);
      }
      const BodyMotion shrunk{0, {Quat(0.5, 0, 0, 0), Vec3::Zero()}};
      EXPECT_EQ(misused.move_bodies({&shrunk, 1}), 1u);
      const BodyMotion nobody{2, {}};
      EXPECT_EQ(misused.move_bodies({&nobody, 1}), 1u);
      EXPECT_FALSE(misused.place_body(2, {}));
      EXPECT_TRUE(same_bits(bits_of(misused), before));
    };
    refuse_all();
    misused.place({0, 0, 0.05});
    spared.place({0, 0, 0.05});
    Vec3 goal(0, 0, 0.02);
    int contacts = 0;
    for (int n = 0; n < 400; ++n) {
      refuse_all();
      goal = (goal + random.in_box(2e-3)).cwiseMin(0.05).cwiseMax(-0.05);
      const ProxyState a = misused.move_to(goal);
      const ProxyState b = spared.move_to(goal);
      ASSERT_FALSE(a.is_refused);
      ASSERT_EQ(a.in_contact, b.in_contact);
      ASSERT_TRUE(same_bits(bits_of(misused), bits_of(spared))) << n;
      contacts += a.in_contact;
    }
    EXPECT_GT(contacts, 100);
  }
}

}  // namespace
}  // namespace palpate
