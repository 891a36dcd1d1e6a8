// Compares stiffness and damping by material with closed forms, and checks that no damper adds
// energy.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/effects/damping.h"
#include "haptics/effects/stiffness.h"
#include "haptics/record_vectors.h"
#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::BodyHand;
using test::effect_entry;
using test::groove_side_soup;
using test::hand_settings;
using test::kTick_s;
using test::Random;
using test::SmoothLoop;
using test::Soup;
using test::square_soup;

constexpr double kSideHalf_m = 0.1;

std::vector<EffectProgramBuilder::Entry> spring(double stiffness, double damping) {
  return {effect_entry<StiffnessEffect>({stiffness}), effect_entry<DampingEffect>({damping})};
}

// A square whose left half, right half and far end have separate materials; the far end has no
// effects.
class Patchwork {
 public:
  Patchwork(const RigidTransform& pose, Random& random) : hand({soup()}, pose) {
    EffectProgram& program = hand.effects.builder.program;
    program.attributes.emplace_back();
    SurfaceAttributes& attributes = program.attributes.back();
    test::for_each_slot(hand.index(), [&](std::uint32_t slot) {
      const TriangleGeometry& t = hand.index().triangle(slot);
      const double x = (t.a.x() + t.b.x() + t.c.x()) / 3.0;
      attributes.part.push_back(static_cast<std::uint16_t>(part_at(x)));
    });
    program.bodies.push_back({&attributes, 0});
    for (int part = 0; part < 2; ++part) {
      couplings[part] = {random.uniform(100.0, 3000.0), random.uniform(0.0, 5.0)};
      program.material_of_part.push_back(hand.effects.builder.add_material(
          spring(couplings[part].stiffness_N_per_m, couplings[part].damping_Ns_per_m)));
    }
    program.material_of_part.push_back(0);
    couplings[2] = {700.0, 1.5};
    hand.begin(hand_settings(700.0, 1.5));
  }

  static int part_at(double x) { return x < 0.0 ? 0 : x < 0.05 ? 1 : 2; }

  BodyHand hand;
  CouplingSettings couplings[3];

 private:
  static Soup soup() {
    Soup soup;
    soup.add_quad({-0.1, -0.1, 0}, {0, -0.1, 0}, {0, 0.1, 0}, {-0.1, 0.1, 0});
    soup.add_quad({0, -0.1, 0}, {0.05, -0.1, 0}, {0.05, 0.1, 0}, {0, 0.1, 0});
    soup.add_quad({0.05, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {0.05, 0.1, 0});
    return soup;
  }
};

TEST(StiffnessAndDamping, AreThoseOfTheMaterialUnderTheProxy) {
  Random random(6101);
  int ticks_of_part[3] = {};
  int pulled = 0;
  for (int run = 0; run < 30; ++run) {
    Patchwork patchwork(random.pose(0.5), random);
    BodyHand& hand = patchwork.hand;
    Vec3 goal(0, 0, 0.001);
    hand.go_to(goal);
    double last_depth = -1.0;
    Vec3 heading = random.in_box(4e-4);
    for (int tick = 0; tick < 800; ++tick) {
      if (tick % 40 == 0) heading = random.in_box(1e-3);
      goal += heading + random.in_box(5e-5);
      goal = goal.cwiseMax(Vec3(-0.09, -0.09, -0.004)).cwiseMin(Vec3(0.09, 0.09, 0.001));
      hand.go_to(goal, kTick_s);
      const double depth = -goal.z();
      ASSERT_EQ(hand.record().contact, depth > 0.0);
      if (depth <= 0.0) {
        last_depth = -1.0;
        ASSERT_EQ(hand.force(), Vec3(0, 0, 0));
        continue;
      }
      const int part = Patchwork::part_at(goal.x());
      const double K = patchwork.couplings[part].stiffness_N_per_m;
      const double B = patchwork.couplings[part].damping_Ns_per_m;
      const double rate = last_depth > 0.0 ? (depth - last_depth) / kTick_s : 0.0;
      const double expected = std::max(0.0, K * depth + B * rate);
      last_depth = depth;
      const double tolerance = (K + 2 * B / kTick_s) * hand.tolerance_m() + 1e-12;
      ASSERT_NEAR(hand.force().z(), expected, tolerance) << tick;
      ASSERT_NEAR(hand.force().head<2>().norm(), 0.0, tolerance);
      ++ticks_of_part[part];
      pulled += expected == 0.0;
    }
  }
  for (const int ticks : ticks_of_part) EXPECT_GT(ticks, 500);
  EXPECT_GT(pulled, 50);
}

// The sides of a groove have one material each; the spring constant is mixed by the load on each
// side.
TEST(StiffnessAndDamping, AreMixedInAGrooveByTheLoadOnEachSide) {
  Random random(6102);
  for (int run = 0; run < 200; ++run) {
    const double rise = random.uniform(0.1, 1.4);
    const CouplingSettings right{random.uniform(100.0, 3000.0), random.uniform(0.0, 5.0)};
    const CouplingSettings left{random.uniform(100.0, 3000.0), random.uniform(0.0, 5.0)};
    BodyHand hand(
        {groove_side_soup(kSideHalf_m, rise, true), groove_side_soup(kSideHalf_m, rise, false)},
        random.pose(0.5));
    hand.effects.add_body(spring(right.stiffness_N_per_m, right.damping_Ns_per_m));
    hand.effects.add_body(spring(left.stiffness_N_per_m, left.damping_Ns_per_m));
    hand.begin(hand_settings());
    const Vec3 n_right(-std::sin(rise), 0, std::cos(rise));
    const Vec3 n_left(std::sin(rise), 0, std::cos(rise));
    hand.go_to({0, 0, 0.01}, kTick_s);
    Vec3 last_lag = Vec3::Zero();
    for (int tick = 0; tick < 20; ++tick) {
      const double a = random.uniform(5e-4, 2e-3);
      const double b = random.uniform(5e-4, 2e-3);
      const Vec3 lag = a * n_right + b * n_left;
      const Vec3 y(0, random.uniform(-1e-3, 1e-3), 0);
      hand.go_to(y - lag, kTick_s);
      const double K = (a * right.stiffness_N_per_m + b * left.stiffness_N_per_m) / (a + b);
      const double B = (a * right.damping_Ns_per_m + b * left.damping_Ns_per_m) / (a + b);
      Vec3 expected = K * lag;
      if (tick > 0) expected += B * (lag - last_lag) / kTick_s;
      expected.z() = std::max(0.0, expected.z());  // the mean normal points up
      last_lag = lag;
      // The stand-offs of both sides move the corner by 1 / sine of the angle between the sides.
      const double tolerance =
          (3000.0 + 2 * 5.0 / kTick_s) * hand.tolerance_m() / std::sin(rise) / std::cos(rise);
      ASSERT_LE((hand.force() - expected).norm(), 2 * tolerance) << tick;
    }
  }
}

// ---- a damper dissipates energy around every closed loop ---------------------------------------

// The work on the hand by the force that the damper adds to the spring, over the second pass of a
// closed path.
struct DamperWork {
  double backward_J = 0.0;    // sum F_k . (x_k - x_k-1)
  double port_J = 0.0;        // sum F_k . (x_k+1 - x_k): the force is held from tick to tick
  double dissipated_J = 0.0;  // sum of the backward terms that remove energy
  // The largest gain that proxies moving along the normal in a tick can cause: see below.
  double allowed_J = 0.0;
  double whole_lag_J = 0.0;   // energy that a damper on all of d(p - g)/dt adds
  double worst_tick_J = 0.0;  // largest excess over the allowed gain of a tick
};

using Path = std::function<Vec3(double turn)>;

// The force is B P (dl / T), with l = p - g the lag and P the projection on the pressed directions.
// The hand moves by dg = dp - dl. With w = P dl and e = P dp, the force's work is B (w . e - w . w)
// / T, which is at most B e^2 / (4 T). A proxy that stays on one plane or edge has e = 0 and gains
// nothing in any tick. On a mesh, e is the bend of the path, of second order in the step.
DamperWork damper_work(BodyHand& damped, BodyHand& undamped, const Vec3& start, const Path& path,
                       double period_s, double dt_s, double damping,
                       const std::function<Vec3(const BodyHand&, const Vec3&)>& pressed) {
  const int ticks = static_cast<int>(std::lround(period_s / dt_s));
  DamperWork work;
  for (BodyHand* hand : {&damped, &undamped}) hand->go_to(start, dt_s);
  Vec3 last_lag = Vec3::Zero();
  Vec3 last_proxy = Vec3::Zero();
  bool had_contact = false;
  for (int k = 0; k <= 2 * ticks; ++k) {
    const auto at = [&](int tick) { return path(static_cast<double>(tick % ticks) / ticks); };
    const Vec3 x = at(k);
    damped.go_to(x, dt_s);
    undamped.go_to(x, dt_s);
    const Vec3 proxy = damped.proxy();
    const Vec3 lag = proxy - damped.goal();
    const bool contact = damped.record().contact;
    EXPECT_EQ(vec3(damped.record().proxy_scene_m), vec3(undamped.record().proxy_scene_m));
    if (k > ticks) {
      const Vec3 back = x - at(k - 1);
      const Vec3 force = damped.force() - undamped.force();
      const double taken_J = force.dot(back);
      double allowed_J = 0.0;
      if (contact && had_contact) {
        allowed_J =
            damping / (4.0 * dt_s) * pressed(damped, Vec3(proxy - last_proxy)).squaredNorm();
        work.whole_lag_J += damping / dt_s * (lag - last_lag).dot(back);
      }
      work.backward_J += taken_J;
      work.dissipated_J += std::max(0.0, -taken_J);
      work.port_J += force.dot(at(k + 1) - x);
      work.allowed_J += allowed_J;
      work.worst_tick_J = std::max(work.worst_tick_J, taken_J - allowed_J);
    }
    had_contact = contact;
    last_lag = lag;
    last_proxy = proxy;
  }
  return work;
}

// Two hands: one has the damper, either of the loop or of the material.
struct Pair {
  BodyHand damped;
  BodyHand undamped;

  Pair(const std::vector<Soup>& soups, const RigidTransform& pose, bool by_material, double damping)
      : damped(soups, pose), undamped(soups, pose) {
    for (BodyHand* hand : {&damped, &undamped}) {
      const double B = hand == &damped ? damping : 0.0;
      if (by_material) {
        for (std::size_t i = 0; i < soups.size(); ++i) hand->effects.add_body(spring(800.0, B));
      }
      hand->begin(hand_settings(800.0, by_material ? 99.0 : B));
    }
  }
};

// The rounding error of the work of one tick, from positions and from the stand-off's rounding in
// the pose.
double rounding_J(const BodyHand& hand, double damping, double dt_s, double step_m) {
  return damping / dt_s * 1e-3 * hand.tolerance_m() * step_m;
}

Vec3 up_only(const BodyHand&, const Vec3& v) {
  return {0, 0, v.z()};
}

TEST(Damper, DissipatesEnergyInEveryTickOnAPlane) {
  Random random(6103);
  for (int run = 0; run < 40; ++run) {
    const double damping = random.uniform(0.5, 10.0);
    Pair pair({square_soup(kSideHalf_m)}, random.pose(0.3), run % 2 == 0, damping);
    // Half of the runs leave the plane on their path.
    const double depth_z_m = run % 4 < 2 ? -0.003 : -0.0005;
    const SmoothLoop loop({0, 0, depth_z_m}, {0.05, 0.05, 0.0025}, random);
    const DamperWork work = damper_work(
        pair.damped, pair.undamped, {0, 0, 0.02}, [&](double turn) { return loop.at(turn); }, 0.5,
        kTick_s, damping, up_only);
    EXPECT_LE(work.worst_tick_J, rounding_J(pair.damped, damping, kTick_s, 1e-3));
    EXPECT_LT(work.backward_J, 0.0);
    // sum a_k a_k+1 = sum a_k^2 - sum (a_k+1 - a_k)^2 / 2 around a loop. A force held for a tick
    // therefore dissipates less by at most (w T)^2 / 2, with w the fastest harmonic, and by a
    // tick's part where the contact is left.
    const double most = 2 * std::numbers::pi * SmoothLoop::kHarmonics * kTick_s / 0.5;
    EXPECT_LT(work.port_J, (depth_z_m == -0.003 ? 1.0 - 0.5 * most * most : 0.5) * work.backward_J);
  }
}

TEST(Damper, DissipatesEnergyInAGroove) {
  Random random(6104);
  int in_groove = 0;
  for (int run = 0; run < 120; ++run) {
    // Every third loop is so fast that the damper would pull; that part is removed.
    const double period_s = run % 3 == 0 ? 0.05 : 0.4;
    const double damping = random.uniform(0.5, 20.0);
    const double rise = random.uniform(0.2, 1.3);
    Pair pair(
        {groove_side_soup(kSideHalf_m, rise, true), groove_side_soup(kSideHalf_m, rise, false)},
        random.pose(0.3), run % 2 == 0, damping);
    const SmoothLoop loop({0, 0, -0.003}, {0.006, 0.05, 0.005}, random);
    const auto pressed = [&](const BodyHand& hand, const Vec3& v) -> Vec3 {
      const Vec3 p = hand.proxy();
      if (std::abs(p.x()) < 10 * hand.tolerance_m() / std::sin(rise)) {
        ++in_groove;
        return {v.x(), 0, v.z()};
      }
      const Vec3 n((p.x() > 0.0 ? -1 : 1) * std::sin(rise), 0, std::cos(rise));
      return v.dot(n) * n;
    };
    const DamperWork work = damper_work(
        pair.damped, pair.undamped, {0, 0, 0.02}, [&](double turn) { return loop.at(turn); },
        period_s, kTick_s, damping, pressed);
    EXPECT_LE(work.worst_tick_J, 100 * rounding_J(pair.damped, damping, kTick_s, 1e-3)) << run;
    EXPECT_LT(work.backward_J, 0.0);
    EXPECT_LT(work.port_J, 0.5 * work.backward_J);
  }
  EXPECT_GT(in_groove, 1000);
}

// Paths around a sphere, at a constant or varying depth. A damper on the whole lag would add B d
// v^2 / r per second here, and this test would detect a thousandth of it.
TEST(Damper, AddsNoEnergyAroundASphere) {
  Random random(6105);
  constexpr double kRadius_m = 0.05;
  constexpr double kPeriod_s = 0.6;
  for (const int subdivisions : {2, 4}) {
    const Soup soup = test::soup_of(icosphere(subdivisions, kRadius_m));
    for (int run = 0; run < 20; ++run) {
      const double damping = random.uniform(0.5, 10.0);
      Pair pair({soup}, random.pose(0.3), run % 2 == 0, damping);
      const Vec3 u = random.unit_vector();
      const Vec3 v = u.cross(random.unit_vector()).normalized();
      const bool varies = run % 4 >= 2;
      const SmoothLoop wobble({-0.004, 0, 0}, {varies ? 0.002 : 0.0, 0.3, 0.0}, random);
      const Path path = [&](double turn) -> Vec3 {
        const Vec3 w = wobble.at(turn);
        const double angle = 2 * std::numbers::pi * turn;
        const Vec3 radial = std::cos(angle) * u + std::sin(angle) * v;
        const Vec3 bent = varies ? Vec3(radial + w.y() * u.cross(v)).normalized() : radial;
        return (kRadius_m + w.x()) * bent;
      };
      const DamperWork work =
          damper_work(pair.damped, pair.undamped, Vec3(1.2 * path(0.0)), path, kPeriod_s, kTick_s,
                      damping, [](const BodyHand& hand, const Vec3& d) -> Vec3 {
                        return d.dot(hand.normal()) * hand.normal();
                      });
      EXPECT_LE(work.worst_tick_J, rounding_J(pair.damped, damping, kTick_s, 1e-3));
      EXPECT_LE(work.backward_J, work.allowed_J);
      // The test would detect a damper on the whole lag.
      const double speed = 2 * std::numbers::pi * kRadius_m / kPeriod_s;
      const double mutant_J = damping * 0.004 * speed * speed / kRadius_m * kPeriod_s;
      if (!varies) {
        EXPECT_GT(work.whole_lag_J, 0.5 * mutant_J);
        EXPECT_LT(work.whole_lag_J, 2.0 * mutant_J);
        EXPECT_LT(work.allowed_J, 0.02 * mutant_J);
        EXPECT_LT(work.port_J, 0.02 * mutant_J);
      } else {
        EXPECT_LT(work.backward_J, 0.0);
        EXPECT_LT(work.port_J, 0.5 * work.backward_J);
      }
      if (run < 4) {
        RecordProperty("back_of_mutant", std::to_string(work.backward_J / mutant_J));
        std::printf(
            "sphere %d: backward %.2e, port %.2e, allowed %.2e, dissipated %.2e, whole lag "
            "%.2e, B d v^2 / r %.2e J\n",
            subdivisions, work.backward_J, work.port_J, work.allowed_J, work.dissipated_J,
            work.whole_lag_J, mutant_J);
      }
    }
  }
}

// With friction, too, the whole contact force dissipates energy around a loop, although it is held
// for a tick.
TEST(Damper, DissipatesEnergyTogetherWithFriction) {
  Random random(6106);
  for (int run = 0; run < 40; ++run) {
    const double mu_k = random.uniform(0.05, 1.0);
    BodyHand hand({square_soup(kSideHalf_m)}, random.pose(0.3));
    auto entries = spring(800.0, random.uniform(0.0, 5.0));
    entries.push_back(
        effect_entry<FrictionEffect>({mu_k * random.uniform(1.0, 1.5), mu_k, nullptr}));
    hand.effects.add_body(entries);
    hand.begin(hand_settings());
    const SmoothLoop loop({0, 0, -0.003}, {0.03, 0.03, 0.002}, random);
    constexpr int kTicks = 500;
    hand.go_to({0, 0, 0.01}, kTick_s);
    double port_J = 0.0;
    for (int k = 0; k < 2 * kTicks; ++k) {
      const Vec3 x = loop.at(static_cast<double>(k % kTicks) / kTicks);
      hand.go_to(x, kTick_s);
      if (k >= kTicks) {
        port_J += hand.force().dot(loop.at(static_cast<double>((k + 1) % kTicks) / kTicks) - x);
      }
    }
    EXPECT_LT(port_J, 0.0);
  }
}

}  // namespace
}  // namespace palpate
