#include "haptics/haptic_loop.h"

#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/decompositions.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/made.h"
#include "tests/helpers/owned_bodies.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::box_soup;
using test::kInfinity;
using test::kNan;
using test::OwnedWorld;
using test::Random;
using test::Soup;

constexpr double kStiffness = 1000.0;
constexpr double kDt = 1e-3;
constexpr double kDeg = std::numbers::pi / 180.0;

ActuationModel device(int sensors, int actuators) {
  return ActuationModel::from_counts(sensors, actuators).value();
}

HapticSettings settings(bool a4, double damping = 0.0) {
  HapticSettings s;
  s.coupling = {kStiffness, damping};
  s.a4.enabled = a4;
  return s;
}

// A plane through the origin, 2 m wide. Its front faces +A1 turned by `angle` towards `towards`.
RigidTransform tilted(double angle_rad, const Vec3& towards = Vec3::UnitY()) {
  const Vec3 normal = std::cos(angle_rad) * Vec3::UnitX() + std::sin(angle_rad) * towards;
  return {turn_between(Vec3::UnitZ(), normal), Vec3::Zero()};
}

Soup square_plane() {
  Soup soup;
  soup.add_quad({-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0});
  return soup;
}

// Moves in a straight line of small steps. Returns the work of the port on the hand, with each
// force held until the next tick, as a device does.
class Port {
 public:
  explicit Port(HapticLoop& loop) : loop_(loop) {}

  void move(const Vec3& to_m, int steps, double dt_s) {
    const Vec3 from_m = at_m_;
    for (int i = 1; i <= steps; ++i) {
      const Vec3 next_m = from_m + (to_m - from_m) * (static_cast<double>(i) / steps);
      work_J_ += force_N_.dot(next_m - at_m_);
      at_m_ = next_m;
      force_N_ = vec3(loop_.tick(at_m_, dt_s).force_device_N);
    }
  }
  void start(const Vec3& at_m) {
    at_m_ = at_m;
    force_N_ = vec3(loop_.tick(at_m_, kDt).force_device_N);
  }
  void hold(int ticks, double dt_s) { move(at_m_, ticks, dt_s); }
  const Vec3& at_m() const { return at_m_; }
  double take_work_J() { return std::exchange(work_J_, 0.0); }

 private:
  HapticLoop& loop_;
  Vec3 at_m_ = Vec3::Zero();
  Vec3 force_N_ = Vec3::Zero();
  double work_J_ = 0.0;
};

// A random walk of the device around a box: it slides, crosses edges and corners, and jumps.
Vec3 wander(Random& random, const Vec3& at_m) {
  if (random.index(200) == 0) return random.in_box(0.12);
  const Vec3 direction = random.unit_vector();
  const Vec3 next = at_m + random.uniform(0.0, 2e-3) * direction;
  return next.cwiseMin(0.12).cwiseMax(-0.12);
}

struct CertificateCase {
  int sensors, actuators;
  double radius_m;
  bool a4;
};

void PrintTo(const CertificateCase& c, std::ostream* out) {
  *out << c.sensors << " sensors, " << c.actuators << " actuators, proxy radius " << c.radius_m
       << " m, A4 " << (c.a4 ? "on" : "off");
}

class EnergyCertificate : public testing::TestWithParam<CertificateCase> {};

// In every tick, K/2 |p - g|^2 grows by at most the work of the hand. The check uses scene
// coordinates, in which a rotation of the scene moves the goal and never the mesh.
TEST_P(EnergyCertificate, HoldsEveryTick) {
  const CertificateCase c = GetParam();
  Random random(21);
  const OwnedWorld world(box_soup({0.08, 0.06, 0.05}), random.pose(0.02), c.radius_m);
  HapticSettings s = settings(c.a4);
  s.god_object.radius_m = c.radius_m;
  auto loop = test::made(HapticLoop::create(world.world(), device(c.sensors, c.actuators), s));
  Vec3 at_m(0.12, 0.0, 0.0);
  TickRecord last = loop.tick(at_m, kDt);
  int contact_ticks = 0;
  for (int n = 0; n < 70000; ++n) {
    at_m = wander(random, at_m);
    const TickRecord now = loop.tick(at_m, kDt);
    const Vec3 dx = vec3(now.goal_scene_m) - vec3(last.goal_scene_m);
    const double before_J =
        0.5 * kStiffness * (vec3(last.proxy_scene_m) - vec3(last.goal_scene_m)).squaredNorm();
    const double after_J =
        0.5 * kStiffness * (vec3(now.proxy_scene_m) - vec3(now.goal_scene_m)).squaredNorm();
    const double given_J =
        -kStiffness * (vec3(last.proxy_scene_m) - vec3(last.goal_scene_m)).dot(dx);
    const double leak_J = 0.5 * kStiffness * dx.squaredNorm();
    const double scale_J = before_J + after_J + std::abs(given_J) + leak_J;
    ASSERT_LE(after_J, before_J + given_J + leak_J + 1e-12 * scale_J) << "tick " << n;
    contact_ticks += now.contact;
    last = now;
  }
  EXPECT_GT(contact_ticks, 5000);
}

INSTANTIATE_TEST_SUITE_P(
    Devices, EnergyCertificate,
    testing::Values(CertificateCase{3, 3, 0.0, false}, CertificateCase{3, 1, 0.0, true},
                    CertificateCase{3, 2, 0.0, true}, CertificateCase{2, 1, 0.0, true},
                    CertificateCase{3, 3, 5e-3, false}, CertificateCase{3, 1, 5e-3, true}));

TEST(A4, TurningTheSceneAboutTheProxyLeavesTheSpringAlone) {
  Random random(22);
  for (const int actuators : {1, 2}) {
    const OwnedWorld world(square_plane(), tilted(80 * kDeg, random.unit_vector()));
    auto loop = test::made(HapticLoop::create(world.world(), device(3, actuators), settings(true)));
    loop.tick(world.world().to_scene(tilted(80 * kDeg).direction({0, 0, 0.1})), kDt);
    Vec3 at_m = 0.3 * random.in_box(0.02);
    double last_J = -1.0;
    for (int n = 0; n < 3000; ++n) {
      const TickRecord r = loop.tick(at_m, kDt);
      const double spring_J =
          0.5 * kStiffness * (vec3(r.proxy_scene_m) - vec3(r.goal_scene_m)).squaredNorm();
      if (last_J >= 0.0) {
        ASSERT_LE(std::abs(spring_J - last_J), 1e-12);
      }
      last_J = spring_J;
    }
  }
}

// A force projected on one axis has curl.
double loop_work_J(double angle_rad, bool a4, double side_m) {
  const OwnedWorld world(square_plane(), tilted(angle_rad));
  auto loop = test::made(HapticLoop::create(world.world(), device(3, 1), settings(a4)));
  Port port(loop);
  port.start({0.1, 0.0, 0.0});
  // The loop lies so far inside that all of it is in contact, even while the scene turns.
  port.move({-0.05, 0.0, 0.0}, 2000, 1e-9);
  if (a4) port.hold(4000, kDt);
  port.take_work_J();
  const Vec3 corner = port.at_m();
  const double dt_s = 1e-9;  // quasi-static: fine steps, no time for the scene to turn
  port.move(corner + side_m * Vec3(1, 0, 0), 4000, dt_s);
  port.move(corner + side_m * Vec3(1, 1, 0), 4000, dt_s);
  port.move(corner + side_m * Vec3(0, 1, 0), 4000, dt_s);
  port.move(corner, 4000, dt_s);
  return port.take_work_J();
}

TEST(UnderActuation, DoesWorkAroundALoopAndA4RemovesThatWork) {
  const double side_m = 0.01;
  const double area_m2 = side_m * side_m;
  for (const double deg : {15.0, 30.0, 45.0, 60.0, 75.0}) {
    const double expected_J = kStiffness * area_m2 * std::sin(deg * kDeg) * std::cos(deg * kDeg);
    EXPECT_NEAR(std::abs(loop_work_J(deg * kDeg, false, side_m)), expected_J, 0.01 * expected_J);
  }
  const double at_45deg_J = 0.5 * kStiffness * area_m2;
  EXPECT_LT(std::abs(loop_work_J(45.0 * kDeg, true, side_m)), 0.05 * at_45deg_J);
}

// An inherent cost of A4: pressing costs the hand only the work of the actuated part, but the
// release after alignment returns the energy of the whole spring.
TEST(A4, PressAlignReleaseReturnsTheUnchargedEnergyOfTheSpring) {
  const double depth_m = 5e-3;
  for (const double deg : {10.0, 30.0, 60.0, 80.0}) {
    const double angle_rad = deg * kDeg;
    const OwnedWorld world(square_plane(), tilted(angle_rad));
    auto loop = test::made(HapticLoop::create(world.world(), device(3, 1), settings(true)));
    const Vec3 normal = tilted(angle_rad).direction(Vec3::UnitZ());
    Port port(loop);
    port.start(0.01 * normal);
    port.move(-depth_m * normal, 20000, 1e-9);
    port.hold(3000, kDt);
    port.move(port.at_m() + 2 * depth_m * Vec3::UnitX(), 20000, 1e-9);
    const double expected_J =
        0.5 * kStiffness * depth_m * depth_m * std::sin(angle_rad) * std::sin(angle_rad);
    EXPECT_NEAR(port.take_work_J(), expected_J, 0.01 * expected_J) << deg << " deg";
  }
}

TEST(A4, DoesNotTurnOffContactAtZeroAngleOrWithAllAxesActuated) {
  const OwnedWorld world(box_soup(Vec3::Constant(0.05)));
  for (const auto& [sensors, actuators] : {std::pair(3, 1), std::pair(3, 3), std::pair(3, 0)}) {
    auto loop =
        test::made(HapticLoop::create(world.world(), device(sensors, actuators), settings(true)));
    for (const double x : {0.1, 0.06, 0.04, 0.03, 0.1}) {
      loop.tick({x, 0.01, 0.0}, kDt);
      EXPECT_EQ(loop.T_device_scene().rotation.coeffs(), Quat::Identity().coeffs());
      EXPECT_EQ(loop.T_device_scene().translation_m, Vec3(Vec3::Zero()));
    }
  }
}

TEST(A4, AlignsEveryCaseAndKeepsTheContact) {
  Random random(23);
  struct Case {
    int sensors, actuators;
  };
  for (const Case c : {Case{2, 1}, Case{3, 1}, Case{3, 2}}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Vec3 towards = c.sensors == 2 ? Vec3::UnitY() : random.unit_vector();
      const RigidTransform pose = tilted(random.uniform(-80, 80) * kDeg, towards);
      const OwnedWorld world(square_plane(), pose);
      auto loop = test::made(
          HapticLoop::create(world.world(), device(c.sensors, c.actuators), settings(true)));
      const Vec3 normal = pose.direction(Vec3::UnitZ());
      Vec3 start = 0.01 * normal;
      loop.tick(start, kDt);
      TickRecord r;
      for (int n = 0; n < 2500; ++n) {
        r = loop.tick(-0.005 * normal, kDt);
        ASSERT_TRUE(r.contact);
      }
      EXPECT_LE(r.alpha_rad, 1e-9);
    }
  }
}

TEST(HapticLoop, ForceModeMasksTheForceAndNothingElse) {
  const OwnedWorld world(square_plane(), tilted(40 * kDeg));
  HapticSettings s = settings(true, 2.0);
  std::vector<std::vector<TickRecord>> traces;
  for (const ForceMode mode : {ForceMode::kNone, ForceMode::kActuated, ForceMode::kFull}) {
    s.force = mode;
    auto loop = test::made(HapticLoop::create(world.world(), device(2, 1), s));
    std::vector<TickRecord> trace;
    for (int n = 0; n < 200; ++n) {
      trace.push_back(loop.tick({0.05 - 5e-4 * n, 1e-4 * n, 0.0}, kDt));
    }
    traces.push_back(trace);
  }
  for (std::size_t n = 0; n < 200; ++n) {
    const TickRecord& none = traces[0][n];
    const TickRecord& actuated = traces[1][n];
    const TickRecord& full = traces[2][n];
    EXPECT_EQ(vec3(none.force_device_N), Vec3(Vec3::Zero()));
    EXPECT_EQ(vec3(actuated.force_device_N), Vec3(vec3(full.force_device_N).x(), 0, 0));
    EXPECT_EQ(vec3(full.force_device_N), vec3(full.full_force_device_N));
    EXPECT_EQ(vec3(none.proxy_scene_m), vec3(full.proxy_scene_m));
    EXPECT_EQ(none.alpha_rad, actuated.alpha_rad);
    EXPECT_EQ(pose_before(none).rotation.coeffs(), pose_before(full).rotation.coeffs());
  }
}

// The loop refers to its own parts; create() moves it, and so may its owner.
TEST(HapticLoop, KeepsItsStateAndItsBitsWhenItIsMoved) {
  Random random(8110);
  const Vec3 half_m(0.05, 0.04, 0.03);
  test::OwnedBodies bodies(
      {{box_soup(half_m), {}}, {box_soup(half_m), {Quat::Identity(), Vec3(0.2, 0, 0)}}}, 1e-3,
      true);
  test::EffectBodies effects;
  effects.add_body({test::effect_entry<FrictionEffect>({0.5, 0.4, nullptr})});
  effects.add_body_without_effects();
  bodies.set_effects(effects.finish());
  for (const double radius_m : {0.0, 1e-3}) {
    HapticSettings s = settings(true, 2.0);
    s.god_object.radius_m = radius_m;
    const auto create = [&] { return HapticLoop::create(bodies.world(), device(3, 1), s); };
    auto moved = std::make_unique<HapticLoop>(test::made(create()));
    auto stays = test::made(create());
    int contacts = 0;
    for (int n = 0; n < 500; ++n) {
      moved = std::make_unique<HapticLoop>(std::move(*moved));
      const RigidTransform pose{Quat::Identity(), random.in_box(1e-3)};
      moved->move_body(n % 2, pose);
      stays.move_body(n % 2, pose);
      const double t = 0.02 * n;  // the hand presses on the upper face, slides on it and leaves it
      const Vec3 at_m(0.04 * std::cos(t), 0.03 * std::sin(t), 0.03 + 0.005 * std::cos(3.0 * t));
      const TickRecord& record = moved->tick(at_m, kDt);
      const TickRecord& expected = stays.tick(at_m, kDt);
      ASSERT_EQ(std::memcmp(&record, &expected, sizeof record), 0) << "tick " << n;
      contacts += record.contact ? 1 : 0;
    }
    EXPECT_GT(contacts, 100);
  }
}

struct BadInput {
  Vec3 sample_m;
  double dt_s;
  std::uint32_t fault;
};

void PrintTo(const BadInput& input, std::ostream* out) {
  *out << input.sample_m.transpose() << " m after " << input.dt_s << " s";
}

class BadSample : public testing::TestWithParam<BadInput> {};

TEST_P(BadSample, CommandsZeroForceSetsItsFaultBitAndTheNextSampleIsGood) {
  const auto [bad_m, bad_dt_s, fault] = GetParam();
  const OwnedWorld world(square_plane(), tilted(0.0));
  auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
  auto undisturbed = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
  for (const double x : {0.01, -0.001, -0.002}) {
    loop.tick({x, 0, 0}, kDt);
    undisturbed.tick({x, 0, 0}, kDt);
  }
  const TickRecord bad = loop.tick(bad_m, bad_dt_s);
  EXPECT_EQ(bad.faults, fault);
  EXPECT_EQ(vec3(bad.force_device_N), Vec3(Vec3::Zero()));
  EXPECT_TRUE(bad.contact);
  const TickRecord next = loop.tick({-0.003, 0.001, 0}, kDt);
  const TickRecord expected = undisturbed.tick({-0.003, 0.001, 0}, kDt);
  EXPECT_EQ(next.faults, 0u);
  EXPECT_EQ(vec3(next.proxy_scene_m), vec3(expected.proxy_scene_m));
  EXPECT_EQ(vec3(next.force_device_N), vec3(expected.force_device_N));
}

const Vec3 kPressed_m(-0.002, 0, 0);
INSTANTIATE_TEST_SUITE_P(All, BadSample,
                         testing::Values(BadInput{{kNan, 0, 0}, kDt, kFaultNonFiniteSample},
                                         BadInput{{0, 0, kInfinity}, kDt, kFaultNonFiniteSample},
                                         BadInput{{0, -kInfinity, 0}, kDt, kFaultNonFiniteSample},
                                         BadInput{{1e300, 0, 0}, kDt, kFaultFarSample},
                                         BadInput{{0, -1e30, 0}, kDt, kFaultFarSample},
                                         BadInput{{0, 0, 1.01 * 2 * 0x1p26}, kDt, kFaultFarSample},
                                         BadInput{{0, 0, 0.99 * 2 * 0x1p26}, kDt, kFaultJump},
                                         BadInput{kPressed_m, 0.0, kFaultBadTimeStep},
                                         BadInput{kPressed_m, -kDt, kFaultBadTimeStep},
                                         BadInput{kPressed_m, kNan, kFaultBadTimeStep},
                                         BadInput{kPressed_m, kInfinity, kFaultBadTimeStep},
                                         BadInput{kPressed_m, std::nextafter(1.0, 2.0),
                                                  kFaultBadTimeStep},
                                         BadInput{kPressed_m, 3600.0, kFaultBadTimeStep}));

TEST(HapticLoop, AcceptsTicksOfUpToASecond) {
  const OwnedWorld world(square_plane(), tilted(0.0));
  auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
  loop.tick({0.01, 0, 0}, kDt);
  for (const double dt_s : {1e-12, 1e-3, 0.5, 1.0}) {
    const TickRecord& record = loop.tick(kPressed_m, dt_s);
    EXPECT_EQ(record.faults, kFaultNone) << dt_s;
    EXPECT_NEAR(vec3(record.force_device_N).x(), kStiffness * 0.002, 1e-6);
  }
}

// The hand presses on the plane; then one sample is far beyond everything. That tick commands no
// force, and the next one has its contact as before.
TEST(HapticLoop, CommandsNoForceForAJumpAndKeepsTheContact) {
  Random random(27);
  for (int trial = 0; trial < 50; ++trial) {
    const RigidTransform pose = random.pose(10.0);
    const OwnedWorld world(square_plane(), pose);
    auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
    const Vec3 pressed(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), -2e-3);
    loop.tick(pose.point({0.0, 0.0, 0.1}), kDt);
    const TickRecord before = loop.tick(pose.point(pressed), kDt);
    ASSERT_TRUE(before.contact);
    const Vec3 beyond = pose.point(Vec3(0.0, 0.0, -3.0) + random.in_box(0.5));
    const TickRecord wild = loop.tick(beyond, kDt);
    EXPECT_EQ(wild.faults, kFaultJump);
    EXPECT_EQ(vec3(wild.force_device_N), Vec3::Zero());
    EXPECT_EQ(vec3(wild.proxy_scene_m), vec3(before.proxy_scene_m));
    const TickRecord after = loop.tick(pose.point(pressed), kDt);
    EXPECT_EQ(after.faults, kFaultNone);
    EXPECT_TRUE(after.contact);
    EXPECT_EQ(vec3(after.proxy_scene_m), vec3(before.proxy_scene_m));
    // If the device stays there, its sample is good, and it pulls at the same side of the plane.
    EXPECT_EQ(loop.tick(beyond, kDt).faults, kFaultJump);
    const TickRecord there = loop.tick(beyond, kDt);
    EXPECT_EQ(there.faults, kFaultNone);
    EXPECT_TRUE(there.contact);
    EXPECT_GT(pose.inverse_point(vec3(there.proxy_scene_m)).z(), 0.0);
  }
}

// Two conditions make a jump: the distance exceeds the scene's size, and the speed over the time
// since the last valid sample exceeds that of a hand.
TEST(HapticLoop, ReportsAJumpIfTheSampleIsFartherThanTheSceneAndFasterThanAHand) {
  constexpr double kSize_m = 2.0;
  const OwnedWorld world(square_plane(), tilted(0.0));
  ASSERT_EQ(world.world().size_m, kSize_m);
  struct Leap {
    double way_m, dt_s;
    bool is_jump;
  };
  for (const Leap& leap :
       {Leap{0.99 * kSize_m, 1e-6, false}, Leap{1.01 * kSize_m, 1e-6, true},
        Leap{5.0, 0.99 * 5.0 / kFastestHand_m_per_s, true},
        Leap{5.0, 1.01 * 5.0 / kFastestHand_m_per_s, false}, Leap{1.5, 1e-9, false}}) {
    auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
    loop.tick({0.01, 0, 0}, kDt);
    loop.tick({0.01, 0, 0}, kDt);
    const TickRecord& far = loop.tick({0.01 + leap.way_m, 0, 0}, leap.dt_s);
    EXPECT_EQ(far.faults, leap.is_jump ? kFaultJump : kFaultNone) << leap.way_m << " " << leap.dt_s;
  }
  // Ticks with an invalid sample add to the time; a tick with an invalid time step does not.
  auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
  loop.tick({0.01, 0, 0}, kDt);
  for (int n = 0; n < 6; ++n) loop.tick({kNan, 0, 0}, 0.1);
  loop.tick({kNan, 0, 0}, kInfinity);
  EXPECT_EQ(loop.tick({0.01 + 0.75 * kFastestHand_m_per_s, 0, 0}, kDt).faults, kFaultJump);
  EXPECT_EQ(loop.tick({0.01, 0, 0}, kDt).faults, kFaultNone);
  for (int n = 0; n < 6; ++n) loop.tick({kNan, 0, 0}, 0.1);
  EXPECT_EQ(loop.tick({0.01 + 0.5 * kFastestHand_m_per_s, 0, 0}, kDt).faults, kFaultNone);
}

// At 1 m/s the hand moves 1 mm per tick, a hundred times the scene's size.
TEST(HapticLoop, RendersContactWithASceneSmallerThanTheMotionOfATick) {
  constexpr double kHalf = 5e-6;
  constexpr double kSpeed_m_per_s = 1.0;
  Random random(28);
  int contacts = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const RigidTransform pose = random.pose(0.05);
    const OwnedWorld world(box_soup(Vec3::Constant(kHalf)), pose);
    auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
    // From a place straight above one face to one straight below, through the scene.
    const Vec3 aim(random.uniform(-0.9, 0.9) * kHalf, random.uniform(-0.9, 0.9) * kHalf, 0.0);
    const double start_m = random.uniform(0.0, 1.0) * kSpeed_m_per_s * kDt;
    for (int n = -5; n <= 5; ++n) {
      const Vec3 at = aim - (n * kSpeed_m_per_s * kDt - start_m) * Vec3::UnitZ();
      const TickRecord& record = loop.tick(pose.point(at), kDt);
      ASSERT_EQ(record.faults, kFaultNone) << n;
      const bool is_below = at.z() < -kHalf;
      ASSERT_EQ(record.contact, at.z() < kHalf) << n;
      contacts += record.contact;
      if (!is_below) continue;
      const Vec3 proxy = pose.inverse_point(vec3(record.proxy_scene_m));
      ASSERT_NEAR(proxy.z(), kHalf, 1e-3 * kHalf);
      ASSERT_NEAR(pose.inverse_direction(vec3(record.force_device_N)).z(),
                  kStiffness * (kHalf - at.z()), 1e-3 * kStiffness * kHalf);
    }
  }
  EXPECT_GT(contacts, 800);
}

TEST(HapticLoop, IgnoresBadSamplesBeforeTheFirstGoodOne) {
  const OwnedWorld world(square_plane(), tilted(0.0));
  auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false)));
  EXPECT_EQ(loop.tick({kNan, 0, 0}, kDt).tick, 0u);
  const TickRecord first = loop.tick({0.01, 0, 0}, kDt);
  EXPECT_EQ(first.faults, 0u);
  EXPECT_EQ(vec3(first.proxy_scene_m), Vec3(0.01, 0, 0));
  EXPECT_TRUE(loop.tick({-0.01, 0, 0}, kDt).contact);
}

TEST(HapticLoop, KeepsATwoSensorDeviceInItsPlane) {
  const OwnedWorld world(box_soup(Vec3::Constant(0.05)));
  HapticSettings s = settings(true);
  s.plane_height_m = 0.02;
  auto loop = test::made(HapticLoop::create(world.world(), device(2, 1), s));
  for (int n = 0; n < 500; ++n) {
    const double angle = 0.01 * n;
    const TickRecord r = loop.tick({0.06 * std::cos(angle), 0.045 * std::sin(angle), 17.0}, kDt);
    ASSERT_EQ(vec3(r.device_m).z(), 0.02);
    ASSERT_NEAR(pose_before(r).point(vec3(r.proxy_scene_m)).z(), 0.02, 1e-15);
    ASSERT_NEAR(vec3(r.normal_scene).z(), 0.0, 1e-15);
  }
}

// The time step is finite, but so small that the speed of a step overflows.
TEST(HapticLoop, CommandsNoNonFiniteForce) {
  OwnedWorld world(square_plane());
  auto loop = test::made(HapticLoop::create(world.world(), device(3, 3), settings(false, 2.0)));
  loop.tick({0, 0, 0.001}, kDt);
  loop.tick({0, 0, -0.001}, kDt);
  const TickRecord& none = loop.tick({0, 0, -0.002}, 1e-312);
  EXPECT_NE(none.faults & kFaultNonFiniteForce, 0u);
  EXPECT_TRUE(vec3(none.force_device_N).isZero(0.0));
  EXPECT_TRUE(vec3(none.full_force_device_N).isZero(0.0));
  const TickRecord& next = loop.tick({0, 0, -0.002}, kDt);
  EXPECT_EQ(next.faults, kFaultNone);
  EXPECT_NEAR(vec3(next.force_device_N).z(), kStiffness * 0.002, 1e-6);
}

// A4's counter relies on this: rotation_rad is exactly 0 if no rotation is needed.
TEST(HapticLoop, DoesNotTurnIfFullyActuatedOffContactOrAligned) {
  Soup across_a1;  // faces exactly along A1: no pose, no rounding
  across_a1.add_quad({0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1});
  const auto turned_ticks = [&](double tilt_rad, int actuators, double height_m) {
    const Quat tilt(Eigen::AngleAxisd(tilt_rad, Vec3::UnitZ()));
    OwnedWorld world(across_a1, {tilt, Vec3::Zero()});
    auto loop = test::made(HapticLoop::create(world.world(), device(3, actuators), settings(true)));
    const Vec3 normal = tilt * Vec3::UnitX();
    loop.tick(0.001 * normal, kDt);
    int turned = 0;
    for (int i = 0; i < 100; ++i) {
      turned += loop.tick(height_m * normal, kDt).rotation_rad != 0.0;
    }
    return turned;
  };
  EXPECT_EQ(turned_ticks(0.5, 3, -0.001), 0);  // all sensed axes actuated
  EXPECT_EQ(turned_ticks(0.5, 1, 0.001), 0);   // free motion
  EXPECT_EQ(turned_ticks(0.0, 1, -0.001), 0);  // no angle
  EXPECT_GT(turned_ticks(0.5, 1, -0.001), 50);
}

}  // namespace
}  // namespace palpate
