// The hard cases that lie in the device: at the limit of stability, quantised, late, or broken.
// Each tick is judged by JudgedLoop.

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/stability_limits.h"
#include "haptics/record_vectors.h"
#include "tests/engine/session/hard_case_device.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::device;
using test::facing;
using test::HardDevice;
using test::JudgedLoop;
using test::kDeg;
using test::kTick_s;
using test::OwnedWorld;
using test::posed;
using test::Random;
using test::RubbingMass;
using test::settings;
using test::Soup;
using test::trials;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ---- 15 a device at the limit of stability -----------------------------------------------------

class HardCase15_StiffnessAtItsLimit : public testing::TestWithParam<double> {
 protected:
  static constexpr double kMass_kg = 0.1;
  static constexpr double kDeviceDamping = 0.5;    // N s/m
  static constexpr double kCouplingDamping = 1.0;  // N s/m

  // The amplitude in each of five windows of 100 ms, of a device that a steady hand presses on a
  // wall and that was knocked by a micrometre. The first window, in which other modes die, is left
  // out.
  static std::vector<double> amplitudes_m(double stiffness_N_per_m, double radius_m) {
    Random random(301);
    const Vec3 normal = random.unit_vector();
    const RigidTransform pose = facing(normal, random.in_box(1.0), random);
    const OwnedWorld world(posed(test::sheet_soup(0.2, 0.2), pose), {}, radius_m);
    JudgedLoop loop(world, device(3, 3),
                    settings(stiffness_N_per_m, kCouplingDamping, false, radius_m));
    const Vec3 hand_N = -5.0 * normal;
    const Vec3 rest_m = pose.translation_m + radius_m * normal + hand_N / stiffness_N_per_m;
    loop.tick(rest_m + 0.05 * normal, kTick_s);
    MassDamper plant(kMass_kg, kDeviceDamping);
    plant.put(rest_m + 1e-6 * normal, Vec3::Zero());
    std::vector<double> amplitudes;
    for (int window = 0; window < 6; ++window) {
      double amplitude = 0.0;
      for (int n = 0; n < 100; ++n) {
        const TickRecord& record = loop.tick(plant.position_m(), kTick_s);
        EXPECT_TRUE(record.contact);
        plant.advance(vec3(record.force_device_N) + hand_N, kTick_s);
        amplitude = std::max(amplitude, std::abs(normal.dot(plant.position_m() - rest_m)));
      }
      if (window > 0) amplitudes.push_back(amplitude);
    }
    EXPECT_EQ(loop.verdict(), "");
    return amplitudes;
  }
};

TEST_P(HardCase15_StiffnessAtItsLimit, DecaysBelowAndGrowsAbove) {
  const Result<StabilityLimits> limits =
      stability_limits({kMass_kg, kDeviceDamping}, kCouplingDamping, {kTick_s});
  ASSERT_TRUE(limits.ok());
  const double limit = limits->stable_N_per_m;
  const std::vector<double> below = amplitudes_m(0.95 * limit, GetParam());
  const std::vector<double> above = amplitudes_m(1.05 * limit, GetParam());
  for (std::size_t window = 1; window < below.size(); ++window) {
    EXPECT_LT(below[window], below[window - 1]);
    EXPECT_GT(above[window], above[window - 1]);
  }
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase15_StiffnessAtItsLimit, testing::Values(0.0, 5e-3),
                         [](const auto& radius_m) {
                           return radius_m.param == 0.0 ? "Point" : "Sphere";
                         });

// ---- 16 dither over one step of the encoder ----------------------------------------------------

class HardCase16_QuantisedDither : public testing::TestWithParam<double> {
 protected:
  static constexpr double kQuantum_m = 20e-6;
  static constexpr double kFriction_N = 0.05;
  double stiffness_N_per_m() const { return GetParam() * 2 * kFriction_N / kQuantum_m; }
  static double read(double position_m) { return kQuantum_m * std::round(position_m / kQuantum_m); }
  // A wall at x = 0, from the right, at any y and z, felt through an encoder.
  static OwnedWorld wall(Random& random) {
    const Vec3 beside = random.in_box(0.05).cwiseProduct(Vec3(0, 1, 1));
    return OwnedWorld(posed(test::sheet_soup(0.2, 0.2), facing(Vec3::UnitX(), beside, random)));
  }
  static constexpr double kBoundary_m = -50.5 * kQuantum_m;  // between two readings
};

// To and fro by one quantum a tick: going in, the force of the outer reading is held; going out,
// the force of the inner one. Each turn gives K D^2, and friction takes 2 f_c D.
TEST_P(HardCase16_QuantisedDither, GivesMoreThanFrictionTakesAboveTheLimitOnly) {
  Random random(302);
  const OwnedWorld world = wall(random);
  JudgedLoop loop(world, device(3, 3), settings(stiffness_N_per_m(), 0.0, false));
  loop.tick({0.01, 0, 0}, kTick_s);
  const int turns = 1000;
  double at_m = kBoundary_m + 0.5 * kQuantum_m;
  double held_N = loop.tick({read(at_m), 0, 0}, kTick_s).force_device_N[0];
  double given_J = 0.0;
  for (int n = 0; n < 2 * turns; ++n) {
    const double next_m = kBoundary_m + (n % 2 ? 0.5 : -0.5) * 0.999 * kQuantum_m;
    given_J += held_N * (next_m - at_m);
    at_m = next_m;
    held_N = loop.tick({read(at_m), 0, 0}, kTick_s).force_device_N[0];
  }
  const double stroke_m = 0.999 * kQuantum_m;  // so that rounding decides no reading
  const double expected_J = turns * stiffness_N_per_m() * kQuantum_m * stroke_m;
  EXPECT_NEAR(given_J, expected_J, 1e-3 * expected_J);
  const double taken_J = turns * 2 * kFriction_N * stroke_m;
  EXPECT_EQ(given_J > taken_J, GetParam() > 1.0);
  EXPECT_EQ(loop.verdict(), "");
}

// A mass that rubs, pressed with the force half-way between those of two readings: friction can
// hold it at either reading, or at none.
TEST_P(HardCase16_QuantisedDither, ComesToRestBelowTheLimitOnly) {
  Random random(303);
  const OwnedWorld world = wall(random);
  JudgedLoop loop(world, device(3, 3), settings(stiffness_N_per_m(), 0.0, false));
  loop.tick({0.01, 0, 0}, kTick_s);
  // Damped far above K T / 2, so that sampling is not what keeps it going.
  RubbingMass plant(0.1, 10.0, kFriction_N);
  plant.position_m = kBoundary_m + 0.1 * kQuantum_m;
  plant.velocity_m_per_s = -1e-3;
  const double hand_N = stiffness_N_per_m() * kBoundary_m;
  int moving_ticks = 0;
  for (int n = 0; n < 5000; ++n) {
    const double force_N = loop.tick({read(plant.position_m), 0, 0}, kTick_s).force_device_N[0];
    const double before_m = plant.position_m;
    plant.advance(force_N + hand_N, kTick_s);
    if (n >= 4000) moving_ticks += plant.position_m != before_m;
  }
  EXPECT_EQ(moving_ticks, GetParam() > 1.0 ? 1000 : 0);
  EXPECT_EQ(loop.verdict(), "");
}

INSTANTIATE_TEST_SUITE_P(OfTheLimit, HardCase16_QuantisedDither, testing::Values(0.95, 1.05),
                         [](const auto& part) { return part.param < 1 ? "Below" : "Above"; });

// ---- 17 ticks that come early, late or not at all ----------------------------------------------

// A period of 1 ms +- 50 %, one tick in ten left out, a stall of 20 ms in 500.
double uneven_tick_s(Random& random) {
  double dt_s = kTick_s * random.uniform(0.5, 1.5);
  while (random.index(10) == 0) dt_s += kTick_s * random.uniform(0.5, 1.5);
  return random.index(500) == 0 ? 0.02 : dt_s;
}

class HardCase17_UnevenTicks : public testing::TestWithParam<double> {};

TEST_P(HardCase17_UnevenTicks, KeepTheSideAndTheCertificate) {
  const double radius = GetParam();
  Random random(304);
  for (const PaperObject& object : paper_objects()) {
    const OwnedWorld world(posed(test::paper_object_soup(object), random.pose(0.02)), {}, radius);
    JudgedLoop loop(world, device(3, 1), settings(1000.0, 2.0, true, radius));
    Vec3 at_m(0.2, 0.0, 0.0);
    Vec3 aim_m = at_m;
    loop.tick(at_m, kTick_s);
    int contact_ticks = 0;
    for (int n = 0; n < 20000; ++n) {
      const double dt_s = uneven_tick_s(random);
      if (random.index(100) == 0) aim_m = random.in_box(0.1);
      // As far as a hand at 0.5 m/s gets in that time.
      const Vec3 way = aim_m - at_m;
      at_m += way * std::min(1.0, 0.5 * dt_s / std::max(way.norm(), 1e-12));
      const TickRecord& record = loop.tick(at_m, dt_s);
      ASSERT_EQ(record.faults & ~kFaultSolverCapped, 0u);
      ASSERT_EQ(loop.verdict(), "") << object.name << " tick " << n;
      contact_ticks += record.contact;
    }
    EXPECT_GT(contact_ticks, 1000);
  }
}

// The scene turns by the clock and not by the tick: whatever the ticks, the angle that is left
// after the same time is the same, to the rounding of turning it in thousands of pieces.
TEST_P(HardCase17_UnevenTicks, TurnTheSceneAsEvenOnesDo) {
  const double radius = GetParam();
  Random random(305);
  const Vec3 normal = std::cos(80 * kDeg) * Vec3::UnitX() + std::sin(80 * kDeg) * Vec3::UnitY();
  const RigidTransform pose = facing(normal, {0, 0, 0}, random);
  const OwnedWorld world(posed(test::sheet_soup(1.0, 1.0), pose), {}, radius);
  std::vector<double> alphas_rad;
  for (const bool even : {true, false}) {
    JudgedLoop loop(world, device(3, 1), settings(1000.0, 0.0, true, radius));
    loop.tick((radius + 0.01) * normal, kTick_s);
    const Vec3 pressed = (radius - 0.005) * normal;
    double left_s = 1.2;  // so that it is not aligned yet
    while (left_s > 0.0) {
      const double dt_s = std::min(left_s, even ? kTick_s : uneven_tick_s(random));
      loop.tick(pressed, dt_s);
      left_s -= dt_s;
    }
    alphas_rad.push_back(loop.tick(pressed, 1e-9).alpha_rad);
    EXPECT_EQ(loop.verdict(), "");
  }
  EXPECT_GT(alphas_rad[0], 1 * kDeg);
  EXPECT_NEAR(alphas_rad[0], alphas_rad[1], 1e-9);
}

// A device that is passive for the longest tick (b >= K T_max / 2) only loses energy, whenever the
// ticks come. Of the spring's energy it counts what the hand could get back.
TEST_P(HardCase17_UnevenTicks, LetAPassiveDeviceCalmDown) {
  const double radius = GetParam();
  const double stiffness_N_per_m = 300.0;
  const double damping_Ns_per_m = 1.05 * 0.5 * stiffness_N_per_m * 0.02;
  Random random(306);
  const Vec3 normal = random.unit_vector();
  const RigidTransform pose = facing(normal, random.in_box(1.0), random);
  const OwnedWorld world(posed(test::sheet_soup(0.5, 0.5), pose), {}, radius);
  JudgedLoop loop(world, device(3, 3), settings(stiffness_N_per_m, 0.0, false, radius));
  MassDamper plant(0.1, damping_Ns_per_m);
  const Vec3 hand_N = -2.0 * normal;
  const Vec3 rest_m = pose.translation_m + radius * normal + hand_N / stiffness_N_per_m;
  loop.tick(rest_m + 0.05 * normal, kTick_s);
  plant.put(rest_m + 5e-3 * normal, -0.3 * normal);
  const double begin_J = plant.kinetic_J() + 0.5 * stiffness_N_per_m * 25e-6;
  double end_J = begin_J;
  for (int n = 0; n < 3000; ++n) {
    const double dt_s = uneven_tick_s(random);
    plant.advance(vec3(loop.tick(plant.position_m(), dt_s).force_device_N) + hand_N, dt_s);
    const Vec3 off_m = plant.position_m() - rest_m;
    end_J = plant.kinetic_J() + 0.5 * stiffness_N_per_m * off_m.squaredNorm();
    ASSERT_LE(end_J, begin_J);
  }
  EXPECT_LE(end_J, 1e-12 * begin_J);
  EXPECT_EQ(loop.verdict(), "");
}

INSTANTIATE_TEST_SUITE_P(Radius, HardCase17_UnevenTicks, testing::Values(0.0, 2e-3),
                         [](const auto& radius_m) {
                           return radius_m.param == 0.0 ? "Point" : "Sphere";
                         });

// ---- bad input ---------------------------------------------------------------------------------

struct BadInput {
  const char* name;
  std::optional<Vec3> sample_m;  // none: where the device is
  double dt_s;
  std::uint32_t fault;
};

void PrintTo(const BadInput& bad, std::ostream* out) {
  *out << bad.name;
}

class HardCaseBadInput : public testing::TestWithParam<BadInput> {
 protected:
  // Where a turn round the labyrinth begins, on the wall, and the way out of it.
  static Vec3 start_m() {
    return contour_route(labyrinth_contour()).start_m.cwiseProduct(Vec3(1, 1, 0));
  }
  static Vec3 outward() {
    const Contour contour = labyrinth_contour();
    const Point2 wall = contour[1] - contour[0];
    return Vec3(wall.x(), wall.y(), 0.0).normalized().cross(Vec3::UnitZ());
  }
};

// In contact, while A4 turns the scene: zero force and a fault bit for that tick, the pose held,
// and with the next good sample contact goes on where it was.
TEST_P(HardCaseBadInput, CostsOneTickAndNoContact) {
  const BadInput bad = GetParam();
  Random random(312);
  const Soup soup = test::paper_object_soup({"labyrinth", labyrinth_contour()});
  for (const HardDevice& c :
       {HardDevice{3, 1, 0.0}, HardDevice{2, 1, 0.0}, HardDevice{3, 2, 2e-3}}) {
    const OwnedWorld world(soup, {}, c.radius_m);
    JudgedLoop loop(world, device(c.sensors, c.actuators), settings(1000.0, 2.0, true, c.radius_m));
    loop.tick(start_m() + (c.radius_m + 2e-3) * outward(), kTick_s);
    Vec3 at_m = start_m() + (c.radius_m - 2e-3) * outward();
    for (int n = 0; n < 200; ++n) {
      at_m += 1e-5 * random.unit_vector();
      const TickRecord before = loop.tick(at_m, kTick_s);
      const ScenePose pose = loop.T_device_scene();
      ASSERT_TRUE(before.contact);
      const TickRecord faulty = loop.tick(bad.sample_m.value_or(at_m), bad.dt_s);
      ASSERT_EQ(faulty.faults, bad.fault);
      ASSERT_EQ(vec3(faulty.force_device_N), Vec3(Vec3::Zero()));
      ASSERT_EQ(vec3(faulty.full_force_device_N), Vec3(Vec3::Zero()));
      ASSERT_TRUE(faulty.contact);
      ASSERT_EQ(loop.T_device_scene().rotation.coeffs(), pose.rotation.coeffs());
      const TickRecord next = loop.tick(at_m, kTick_s);
      ASSERT_EQ(next.faults & ~kFaultSolverCapped, 0u);
      ASSERT_TRUE(next.contact);
      ASSERT_GT(vec3(next.full_force_device_N).norm(), 0.0);
      ASSERT_EQ(loop.verdict(), "") << "tick " << n;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, HardCaseBadInput,
    testing::Values(BadInput{"NanX", Vec3(kNan, 0, 0), kTick_s, kFaultNonFiniteSample},
                    BadInput{"NanY", Vec3(0, kNan, 0), kTick_s, kFaultNonFiniteSample},
                    BadInput{"Infinite", Vec3(0, -kInfinity, 0), kTick_s, kFaultNonFiniteSample},
                    BadInput{"Huge", Vec3(1e200, 0, 0), kTick_s, kFaultFarSample},
                    BadInput{"ZeroDt", std::nullopt, 0.0, kFaultBadTimeStep},
                    BadInput{"NegativeDt", std::nullopt, -kTick_s, kFaultBadTimeStep},
                    BadInput{"NanDt", std::nullopt, kNan, kFaultBadTimeStep},
                    BadInput{"InfiniteDt", std::nullopt, kInfinity, kFaultBadTimeStep},
                    BadInput{"LongDt", std::nullopt, 1.5, kFaultBadTimeStep}),
    [](const auto& bad) { return std::string(bad.param.name); });

// A jump across the object is a good sample: the proxy stays in front of the wall, and is back
// where it was when the device is.
TEST(HardCaseBadInputJump, KeepsTheContactOnItsSide) {
  Random random(314);
  const Vec3 half(0.1, 0.08, 0.06);
  for (const double radius : {0.0, 2e-3}) {
    const RigidTransform pose = random.pose(0.1);
    const OwnedWorld world(posed(test::box_soup(half), pose), {}, radius);
    JudgedLoop loop(world, device(3, 3), settings(1000.0, 0.0, false, radius));
    loop.tick(pose.point({0.0, 0.0, 0.1}), kTick_s);
    const Vec3 pressed(0.01, 0.02, half.z() + radius - 2e-3);
    const Vec3 across(0.01, 0.02, -0.1);
    for (int n = 0; n < 100; ++n) {
      const Vec3 before = vec3(loop.tick(pose.point(pressed), kTick_s).proxy_scene_m);
      const TickRecord jumped = loop.tick(pose.point(across), kTick_s);
      ASSERT_TRUE(jumped.contact);
      ASSERT_LE((vec3(jumped.proxy_scene_m) - before).norm(), 1e-9 * world.world().size_m);
      const TickRecord back = loop.tick(pose.point(pressed), kTick_s);
      ASSERT_TRUE(back.contact);
      ASSERT_LE((vec3(back.proxy_scene_m) - before).norm(), 1e-9 * world.world().size_m);
    }
    ASSERT_EQ(loop.verdict(), "");
  }
}

// Large finite samples, and very short and long ticks: taken or refused as jumps, they leave the
// proxy on its side as long as the format of double can tell the sample from its neighbour to a
// thousandth of the scene.
TEST(HardCaseBadInputExtremes, AreTakenAndTheSideIsKept) {
  Random random(313);
  for (const PaperObject& object : paper_objects()) {
    const OwnedWorld world(test::paper_object_soup(object));
    JudgedLoop loop(world, device(3, 1), settings(1000.0, 2.0, true));
    const double farthest = std::log10(1e-3 * world.world().size_m / 0x1p-52);
    loop.tick({0.0, 0.0, 0.3}, kTick_s);
    int refused = 0;
    for (int n = 0; n < trials(2000); ++n) {
      const double reach_m = std::pow(10.0, random.uniform(-3.0, n % 10 == 0 ? farthest : 0.0));
      const double dt_s = std::pow(10.0, random.uniform(-12.0, 1.0));
      const TickRecord& record = loop.tick(reach_m * random.unit_vector(), dt_s);
      refused += (record.faults & ~kFaultSolverCapped) != 0;
      if (record.faults & ~kFaultSolverCapped) {
        ASSERT_EQ(vec3(record.force_device_N), Vec3::Zero()) << "tick " << n;
      }
      ASSERT_EQ(loop.verdict(), "") << object.name << " tick " << n << " reach " << reach_m;
    }
    EXPECT_GT(refused, 0);
    EXPECT_LT(refused, trials(2000) / 2);
  }
}

// Beyond that a sample is only taken without harm: finite forces, and free when it is out again.
TEST(HardCaseBadInputExtremes, DoNoHarmHoweverLarge) {
  Random random(315);
  const OwnedWorld world(test::paper_object_soup(paper_objects().front()));
  auto loop =
      test::made(HapticLoop::create(world.world(), device(3, 1), settings(1000.0, 2.0, true)));
  for (int n = 0; n < trials(20000); ++n) {
    const double reach_m = std::pow(10.0, random.uniform(-3.0, 150.0));
    const TickRecord& record = loop.tick(reach_m * random.unit_vector(), kTick_s);
    ASSERT_TRUE(vec3(record.proxy_scene_m).allFinite() && vec3(record.force_device_N).allFinite())
        << "tick " << n;
    const TickRecord& out = loop.tick({0.0, 0.0, 0.3}, kTick_s);
    ASSERT_TRUE(vec3(out.proxy_scene_m).allFinite() && vec3(out.force_device_N).allFinite())
        << "tick " << n;
  }
}

}  // namespace
}  // namespace palpate
