// The plant that judges the engine: exact motion and works, delay and hold, and growth and period
// of a loop as the theory states them.

#include "engine/simulation/port_loop.h"

#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/stability_limits.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

TipSettings some_tip(Random& random) {
  TipSettings tip;
  tip.mass_kg = std::pow(10.0, random.uniform(-2.0, 0.0));
  tip.damping_Ns_per_m = std::pow(10.0, random.uniform(-1.0, 1.0));
  if (random.index(3) != 0) {
    tip.hand = {random.uniform(0.0, 1.0), std::pow(10.0, random.uniform(-1.0, 2.0)),
                std::pow(10.0, random.uniform(0.0, 3.0))};
  }
  return tip;
}

// The same motion and works by Runge-Kutta steps of the fourth order: place, velocity, works of the
// motors, of the hand, and of the damping.
struct Integrated {
  Vec3 x, v;
  double motors_J = 0.0, hand_J = 0.0, lost_J = 0.0;
};

struct Forces {
  Vec3 motors_N, push_N, hand_m, hand_m_per_s;
};

Integrated rate(const Integrated& s, const TipSettings& tip, const Forces& f, double t_s) {
  const Vec3 place_m = f.hand_m + t_s * f.hand_m_per_s;
  const Vec3 hand_N = f.push_N - tip.hand.stiffness_N_per_m * (s.x - place_m) -
                      tip.hand.damping_Ns_per_m * (s.v - f.hand_m_per_s);
  const Vec3 sum_N = f.motors_N + hand_N - tip.damping_Ns_per_m * s.v;
  return {s.v, sum_N / (tip.mass_kg + tip.hand.mass_kg), f.motors_N.dot(s.v), hand_N.dot(s.v),
          tip.damping_Ns_per_m * s.v.squaredNorm()};
}

Integrated moved(const Integrated& s, double h, const Integrated& d) {
  return {s.x + h * d.x, s.v + h * d.v, s.motors_J + h * d.motors_J, s.hand_J + h * d.hand_J,
          s.lost_J + h * d.lost_J};
}

Integrated integrated(Integrated s, const TipSettings& tip, const Forces& f, double dt_s) {
  constexpr int kSteps = 4000;
  const double h = dt_s / kSteps;
  for (int n = 0; n < kSteps; ++n) {
    const double t_s = n * h;
    const Integrated a = rate(s, tip, f, t_s);
    const Integrated b = rate(moved(s, h / 2, a), tip, f, t_s + h / 2);
    const Integrated c = rate(moved(s, h / 2, b), tip, f, t_s + h / 2);
    const Integrated d = rate(moved(s, h, c), tip, f, t_s + h);
    s = moved(moved(moved(moved(s, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
  }
  return s;
}

TEST(HeldTip, MovesAndWorksAsTheIntegratedEquation) {
  Random random(4901);
  std::cout << "seed " << random.seed() << "\n";
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    const TipSettings settings = some_tip(random);
    const Vec3 start_m = random.in_box(0.1);
    HeldTip tip(settings, start_m);
    const Forces f{random.in_box(5.0), random.in_box(5.0), random.in_box(0.1), random.in_box(0.5)};
    tip.set_hand(f.hand_m, f.hand_m_per_s);
    tip.push(f.push_N);
    const Vec3 velocity = random.in_box(1.0);
    tip.throw_at(velocity);
    tip.open_account();
    const double before_J = tip.kinetic_J();
    const double dt_s = std::pow(10.0, random.uniform(-3.0, -1.0));
    tip.advance(f.motors_N, dt_s);
    const Integrated expected = integrated({start_m, velocity}, settings, f, dt_s);
    // Runge-Kutta: (rate h)^5 / 120 per step, for rates up to B / M = 1,100 1/s.
    constexpr double kTruncation = 1e-7;
    const PortAccount& account = tip.account();
    const double scale_J = before_J + tip.kinetic_J() + std::abs(account.motors_J) +
                           std::abs(account.hand_J) + account.lost_J;
    EXPECT_LE((tip.position_m() - expected.x).norm(), kTruncation * (start_m.norm() + dt_s));
    EXPECT_LE((tip.velocity_m_per_s() - expected.v).norm(), kTruncation * (velocity.norm() + 1.0));
    EXPECT_NEAR(account.motors_J, expected.motors_J, kTruncation * scale_J);
    EXPECT_NEAR(account.hand_J, expected.hand_J, kTruncation * scale_J);
    EXPECT_NEAR(account.lost_J, expected.lost_J, kTruncation * scale_J);
  }
}

// The result does not depend on where a step is split, and the account balances over many steps.
TEST(HeldTip, BalancesItsEnergyWhereverItsStepsAreSplit) {
  Random random(4902);
  std::cout << "seed " << random.seed() << "\n";
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    const TipSettings settings = some_tip(random);
    HeldTip whole(settings, Vec3::Zero());
    HeldTip split(settings, Vec3::Zero());
    double sum_J = 0.0;
    for (int n = 0; n < 300; ++n) {
      const Vec3 motors_N = random.in_box(5.0);
      if (n % 50 == 0) {
        const Vec3 place_m = random.in_box(0.05);
        const Vec3 speed_m_per_s = random.in_box(0.2);
        const Vec3 thrown_m_per_s = random.in_box(0.3);
        for (HeldTip* tip : {&whole, &split}) {
          tip->set_hand(place_m, speed_m_per_s);
          tip->throw_at(thrown_m_per_s);
        }
      }
      const double dt_s = random.uniform(0.0, 2e-3);
      const double first_s = random.uniform(0.0, dt_s);
      whole.advance(motors_N, dt_s);
      split.advance(motors_N, first_s);
      split.advance(motors_N, dt_s - first_s);
      sum_J += whole.kinetic_J() + std::abs(motors_N.norm() * dt_s);
    }
    const PortAccount& account = whole.account();
    const double rounding = 1e4 * kEpsilon * (1.0 + sum_J);  // of 300 steps, about 30 sums each
    EXPECT_NEAR(account.motors_J + account.hand_J - account.lost_J, whole.kinetic_J(), rounding);
    EXPECT_NEAR(account.motors_J, split.account().motors_J, rounding);
    EXPECT_NEAR(account.hand_J, split.account().hand_J, rounding);
    EXPECT_LE((whole.position_m() - split.position_m()).norm(), rounding);
    EXPECT_GT(account.lost_J, 0.0);
  }
}

// ---- delay and hold -----------------------------------------------------------------------------

TEST(PortDevice, ItsForceActsTheDelayAfterTheSampleAndIsHeld) {
  for (const double delay_s : {0.0, 0.3e-3, 1e-3, 2.75e-3}) {
    SCOPED_TRACE(delay_s);
    PortDeviceSettings settings;
    settings.delay_s = delay_s;
    PortDevice device(settings);
    HeldTip expected(settings.tip, Vec3::Zero());
    device.read(1e-3);
    device.command({{1.0, 2.0, 3.0}});  // z is not sensed
    device.idle(5e-3);
    expected.advance(Vec3(1.0, 2.0, 0.0), 5e-3 - delay_s);
    EXPECT_LE((device.tip().position_m() - expected.position_m()).norm(),
              8 * kEpsilon * expected.position_m().norm());
  }
}

TEST(PortDevice, HoldsItsForceWhileCommandsAreLostAndRepeatsItsSampleWhileSamplesAre) {
  PortDevice device(PortDeviceSettings{});
  DeviceSample sample = device.read(1e-3);
  device.command({{1.0, 0.0, 0.0}});
  device.lose_commands({0.5e-3, 2.5e-3});
  device.lose_samples({1.5e-3, 3.5e-3});
  for (int n = 1; n <= 5; ++n) {
    const DeviceSample next = device.read(1e-3);
    const bool is_lost = n == 2 || n == 3;
    EXPECT_EQ(next.sequence, is_lost ? sample.sequence : sample.sequence + 1) << n;
    EXPECT_EQ(next.position_m == sample.position_m, is_lost) << n;
    sample = next;
    EXPECT_EQ(device.motors_N().x(), n <= 3 ? 1.0 : -1.0) << n;
    device.command({{-1.0, 0.0, 0.0}});
  }
}

// ---- the loop against the theory ----------------------------------------------------------------

// The pair of eigenvalues that rules a motion x_n about a rest, from x_n+2 = a x_n+1 - r^2 x_n.
struct Mode {
  double radius = 0.0;
  double angle_rad = 0.0;  // per tick
};

Mode mode_of(const std::vector<double>& x) {
  double pp = 0.0, pq = 0.0, qq = 0.0, pz = 0.0, qz = 0.0;
  for (std::size_t n = 0; n + 3 < x.size(); ++n) {
    const double q = x[n + 1] - x[n];  // differences: without the rest
    const double p = x[n + 2] - x[n + 1];
    const double z = x[n + 3] - x[n + 2];
    pp += p * p, pq += p * q, qq += q * q, pz += p * z, qz += q * z;
  }
  const double det = pp * qq - pq * pq;
  const double a = (pz * qq - qz * pq) / det;
  const double b = (qz * pp - pz * pq) / det;
  Mode mode;
  mode.radius = std::sqrt(std::max(0.0, -b));
  mode.angle_rad = std::acos(0.5 * a / mode.radius);
  return mode;
}

// The tip leans on the wall with a constant push, and swings a little about its rest. moves_motors
// is false: no rule of the governor but the limits of motors acts.
Mode lean(double stiffness_N_per_m, int delay_ticks, double turn_rad) {
  PortLoopSettings settings;
  settings.turn_rad = turn_rad;
  settings.coupling.stiffness_N_per_m = stiffness_N_per_m;
  settings.device.device = motor_device(2, 20.0, 1000.0);
  settings.device.device.moves_motors = false;
  settings.device.delay_s = 1e-3 * delay_ticks;
  constexpr double kPush_N = 5.0;
  const Mat3 turn = Eigen::AngleAxisd(turn_rad, Vec3::UnitZ()).toRotationMatrix();
  const Vec3 n = turn * Vec3::UnitX();
  settings.device.start_m = 1e-3 * n;
  const auto loop = test::made(PortLoop::create(settings));
  loop->tick();  // the proxy begins outside
  const double depth_m = kPush_N / stiffness_N_per_m;
  for (int k = 0; k <= delay_ticks + 1; ++k) {  // until the force of the rest acts
    loop->tip() = HeldTip(settings.device.tip, -depth_m * n);
    loop->tip().push(-kPush_N * n);
    loop->tick();
  }
  loop->tip() = HeldTip(settings.device.tip, -depth_m * n);
  loop->tip().push(-kPush_N * n);
  loop->tip().throw_at(1e-4 * depth_m * std::sqrt(stiffness_N_per_m / settings.device.tip.mass_kg) *
                       n);
  for (int k = 0; k < 60 + 20 * delay_ticks; ++k) loop->tick();  // the other eigenvalues fade
  std::vector<double> x;
  for (int k = 0; k < 120; ++k) {
    loop->tick();
    x.push_back(loop->tip().position_m().dot(n));
    EXPECT_EQ(loop->last().contact, 1);
  }
  return mode_of(x);
}

TEST(PortLoop, GrowsAndDecaysAsTheSpectralRadiusSays) {
  Random random(4903);
  std::cout << "seed " << random.seed() << "\n";
  int grows = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const int ticks = static_cast<int>(random.index(5));
    const double stiffness = std::pow(10.0, random.uniform(2.0, 3.0));
    const double turn_rad = random.uniform(-std::numbers::pi, std::numbers::pi);
    SCOPED_TRACE(std::to_string(stiffness) + " N/m, " + std::to_string(ticks) + " ticks");
    CouplingSettings coupling;
    coupling.stiffness_N_per_m = stiffness;
    ServoTiming timing;
    timing.delay_s = 1e-3 * ticks;
    const double expected = spectral_radius({0.1, 0.5, 0.0, 0.0}, coupling, timing);
    const Mode mode = lean(stiffness, ticks, turn_rad);
    // The solver's places differ by its stand-off at most: 1e-11 m, over steps of 1e-6 m.
    EXPECT_NEAR(mode.radius, expected, 1e-6);
    // Damping, hold and delay shift the frequency of the swing by the square of what they turn its
    // phase by.
    const double w = std::sqrt(stiffness / 0.1);
    const double phase_rad = 0.5 * 0.5 / (0.1 * w) + 1e-3 * (1.0 + ticks) * w;
    EXPECT_NEAR(mode.angle_rad / (1e-3 * w), 1.0, phase_rad * phase_rad);
    grows += expected > 1.0;
  }
  EXPECT_GT(grows, kTrials / 4);
  EXPECT_LT(grows, kTrials);
}

}  // namespace
}  // namespace palpate
