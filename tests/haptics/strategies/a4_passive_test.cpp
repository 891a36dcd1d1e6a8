// The strategy a4-passive: what a turn adds to the spring, and what the motors give back.

#include "haptics/strategies/a4_passive.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "geometry/base/decompositions.h"
#include "haptics/effects/gravity.h"
#include "haptics/effects/stiffness.h"
#include "haptics/haptic_loop.h"
#include "haptics/record_vectors.h"
#include "models/paper_objects.h"
#include "models/primitives.h"
#include "tests/helpers/effect_programs.h"
#include "tests/helpers/hard_case_shapes.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/ticks.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::kDeg;
using test::kTick_s;
using test::OwnedWorld;
using test::Random;

// A tick so short that A4 does not turn in it: by 90 deg/s * 1 ns at most.
constexpr double kNoTurn_s = 1e-9;
constexpr double kEpsilon = 0x1p-52;

HapticSettings passive_settings(double stiffness_N_per_m, double budget_J) {
  HapticSettings settings;
  settings.coupling = {stiffness_N_per_m, 0.0};
  set_strategy({&kA4PassiveStrategy, 1e3 * budget_J}, settings);
  return settings;
}

ActuationModel device_with(SeededRandom& random, int sensors, int motors) {
  if (sensors == 2) {
    const double angle = random.uniform(-3.0, 3.0);
    return *ActuationModel::from_axes(2, {Vec3(std::cos(angle), std::sin(angle), 0.0)});
  }
  std::vector<Vec3> axes;
  for (int m = 0; m < motors; ++m) axes.push_back(random.unit_vector());
  return *ActuationModel::from_axes(3, axes);
}

// A unit vector of the sensed span at this angle to the actuated span.
Vec3 normal_at(SeededRandom& random, const ActuationModel& device, double angle_rad) {
  Vec3 across = random.unit_vector();
  if (device.is_planar()) across.z() = 0.0;
  across = (across - device.actuated_part(across)).normalized();
  Vec3 along = device.actuated_part(random.unit_vector());
  along.normalize();
  return std::cos(angle_rad) * along + std::sin(angle_rad) * across;
}

// A hand at a wall, and the work of the commanded force on it. The device holds the force of a tick
// while the hand moves to the place of the next one.
class HandAtWall {
 public:
  HandAtWall(const HapticSettings& settings, const ActuationModel& device, const Vec3& normal,
             const std::shared_ptr<const EffectProgram>& effects = nullptr)
      : world_(test::sheet_soup(0.2, 0.2)), normal_(normal), at_m_(1e-9 * normal) {
    if (effects) world_.set_effects(effects);
    HapticSettings posed = settings;
    posed.initial_pose.rotation = turn_between(Vec3::UnitZ(), normal).normalized();
    loop_.emplace(test::made(HapticLoop::create(world_.world(), device, posed)));
    rest(kNoTurn_s);
  }

  void move(const Vec3& by_m, double dt_s = kNoTurn_s) {
    work_J_ += force_N().dot(by_m);
    at_m_ += by_m;
    rest(dt_s);
  }
  void move_in_steps(const Vec3& by_m, int steps) {
    for (int n = 0; n < steps; ++n) move(by_m / steps);
  }
  void rest(double dt_s) { record_ = loop_->tick(at_m_, dt_s); }
  // Until the wall faces the motors; Figure 3 needs 1.3 s from 90 deg.
  void align() {
    for (int n = 0; n < 3000; ++n) rest(kTick_s);
    see_normal();
  }

  void see_normal() {
    if (record_.contact) normal_ = pose_before(record_).direction(vec3(record_.normal_scene));
  }

  Vec3 force_N() const { return vec3(record_.force_device_N); }
  const TickRecord& record() const { return record_; }
  const Vec3& normal() const { return normal_; }  // device frame
  double work_J() const { return work_J_; }
  double depth_m() const {
    return (vec3(record_.proxy_scene_m) - vec3(record_.goal_scene_m)).norm();
  }

 private:
  OwnedWorld world_;
  std::optional<HapticLoop> loop_;
  Vec3 normal_;
  Vec3 at_m_;
  TickRecord record_;
  double work_J_ = 0.0;
};

struct Press {
  double stiffness_N_per_m;
  double depth_m;
  double angle_rad;
  double budget_J;
};

constexpr int kPressSteps = 400;

// What the hand gets back in a press, an alignment and a release.
double returned_J(SeededRandom& random, const Press& press, int sensors, int motors) {
  const ActuationModel device = device_with(random, sensors, motors);
  HandAtWall hand(passive_settings(press.stiffness_N_per_m, press.budget_J), device,
                  normal_at(random, device, press.angle_rad));
  hand.move_in_steps(-press.depth_m * hand.normal(), kPressSteps);
  hand.align();
  hand.move_in_steps(1.01 * press.depth_m * hand.normal(), kPressSteps);
  EXPECT_EQ(hand.force_N().norm(), 0.0);
  return hand.work_J();
}

// A turn by a at depth d may add K d^2 sin^2(a) / 2. Forces that are held while the hand moves by
// dx add or take K dx^2 / 2 in each step.
TEST(A4Passive, ReturnsTheBudgetOfAPressOrWhatTheTurnHas) {
  Random random(4901);
  for (int n = 0; n < 60; ++n) {
    Press press{random.uniform(300.0, 3000.0), random.uniform(2e-3, 10e-3),
                random.uniform(5.0, 89.0) * kDeg, 0.0};
    const int motors = 1 + n % 2;
    const int sensors = motors == 2 || n % 4 == 0 ? 3 : 2;
    const double K = press.stiffness_N_per_m;
    const double turn_J = 0.5 * K * std::pow(press.depth_m * std::sin(press.angle_rad), 2);
    const double dx_m = 1.01 * press.depth_m / kPressSteps;
    const double held_J = 2 * kPressSteps * 0.5 * K * dx_m * dx_m;
    // Each turning tick by an angle b shortens the lag to its part cos b: up to 90 deg/s of a tick.
    const double lost = std::pow(90.0 * kDeg * kTick_s, 2) * 3000;
    for (const double budget_J : {0.0, 0.5 * turn_J, 2.0 * turn_J}) {
      press.budget_J = budget_J;
      const double got_J = returned_J(random, press, sensors, motors);
      const double expected_J = std::min(budget_J, turn_J);
      EXPECT_LE(got_J, expected_J + held_J) << "press " << n << ", budget " << budget_J;
      EXPECT_GE(got_J, expected_J - held_J - lost * 0.5 * K * press.depth_m * press.depth_m)
          << "press " << n << ", budget " << budget_J;
    }
  }
}

TEST(A4Passive, PressesOnWithTheFullStiffness) {
  Random random(4902);
  for (int n = 0; n < 20; ++n) {
    const ActuationModel device = device_with(random, 2 + n % 2, 1);
    const double angle_rad = random.uniform(20.0, 80.0) * kDeg;
    HandAtWall hand(passive_settings(1000.0, 0.0), device, normal_at(random, device, angle_rad));
    hand.move_in_steps(-5e-3 * hand.normal(), 10);
    hand.align();
    const double before_N = hand.force_N().norm();
    EXPECT_NEAR(before_N, 5.0 * std::cos(angle_rad), 1e-2) << "the turn leaves the force";
    EXPECT_LE(before_N, 5.0 * std::cos(angle_rad) * (1 + 1e-9));
    hand.move(-1e-3 * hand.normal());
    EXPECT_NEAR(hand.force_N().norm(), before_N + 1.0, 1e-6);
    // The start goes with a hand that retreats beyond it, and the spring never pulls.
    hand.move(5e-3 * hand.normal());
    EXPECT_GT(hand.record().contact, 0);
    EXPECT_GE(hand.force_N().dot(hand.normal()), 0.0);
    const double left_m = hand.depth_m();
    const double force_N = hand.force_N().norm();
    hand.move(-1e-3 * hand.normal());
    EXPECT_NEAR(hand.force_N().norm(), force_N + 1.0, 1e-6);
    EXPECT_NEAR(hand.depth_m(), left_m + 1e-3, 1e-8);
  }
}

// A hand that keeps still while the scene turns under it, seen from the force alone.
TEST(A4Passive, GivesAStillHandNoMoreThanTheBudget) {
  Random random(4903);
  for (int n = 0; n < 60; ++n) {
    const int sensors = 2 + n % 2;
    const ActuationModel device = device_with(random, sensors, sensors == 2 ? 1 : 1 + n % 4 / 2);
    const double K = random.uniform(300.0, 3000.0);
    const double depth_m = random.uniform(2e-3, 10e-3);
    const double budget_J = n % 3 == 0 ? 0.0 : random.uniform(0.0, 20e-3);
    const double mu = random.uniform(0.1, 1.0);
    HandAtWall hand(passive_settings(K, budget_J), device,
                    normal_at(random, device, random.uniform(5.0, 89.0) * kDeg),
                    n % 2 ? test::with_friction(mu, 0.8 * mu) : nullptr);
    Vec3 aside = random.unit_vector();
    if (sensors == 2) aside.z() = 0.0;
    hand.move(-depth_m * hand.normal());
    hand.move(random.uniform(0.0, 0.5) * depth_m * aside);
    const double before_J = hand.force_N().squaredNorm() / (2 * K);
    double added_J = 0.0;
    for (int tick = 0; tick < 2000; ++tick) {
      hand.rest(kTick_s);
      added_J = std::max(added_J, hand.force_N().squaredNorm() / (2 * K) - before_J);
    }
    EXPECT_LE(added_J, budget_J + 1e-6 * K * depth_m * depth_m) << "hand " << n << " mu " << mu;
  }
}

// The depth at which a hand of 400 N/m that aims 10 mm deep rests at a wall, while the scene turns.
double rest_depth_m(const Strategy& strategy, double angle_rad) {
  constexpr double kHand_N_per_m = 400.0;
  constexpr double kAim_m = 10e-3;
  HapticSettings settings;
  settings.coupling = {1000.0, 0.0};
  set_strategy(strategy, settings);
  HandAtWall hand(settings, *ActuationModel::from_counts(2, 1),
                  {std::cos(angle_rad), std::sin(angle_rad), 0.0});
  // It finds its rest before the scene turns, and then follows it.
  for (int n = 0; n < 3000; ++n) {
    const double push_N = kHand_N_per_m * (kAim_m - hand.depth_m());
    const double step_m = (push_N - hand.force_N().dot(hand.normal())) / (1000.0 + kHand_N_per_m);
    hand.move(-step_m * hand.normal(), n < 100 ? kNoTurn_s : kTick_s);
    hand.see_normal();
  }
  return hand.depth_m();
}

// The gain in penetration of one contact, over mask and as a share of A4's.
TEST(A4Passive, HasMostOfTheGainOfASingleContactFor10mJAndAThirdForNothing) {
  const auto mean_depth_m = [](const Strategy& strategy) {
    double sum_m = 0.0;
    for (int degrees = 5; degrees < 90; degrees += 5)
      sum_m += rest_depth_m(strategy, degrees * kDeg);
    return sum_m / 17;
  };
  const double mask_m = mean_depth_m({&kMaskStrategy});
  const double a4_m = mean_depth_m({&kA4Strategy});
  const auto gain = [&](double budget_mJ) {
    return (mask_m - mean_depth_m({&kA4PassiveStrategy, budget_mJ})) / (mask_m - a4_m);
  };
  EXPECT_GT(gain(10.0), 0.8);
  EXPECT_GT(gain(0.0), 0.25);
  EXPECT_LT(gain(0.0), gain(5.0));
  EXPECT_LT(gain(5.0), gain(10.0));
}

// A material states K, which is not the loop's, and a field pulls in the scene. The budget is for
// the spring of the material; the field's force is given whole.
TEST(A4Passive, TakesTheStiffnessOfTheMaterialAndLeavesOtherForcesWhole) {
  Random random(4905);
  for (int n = 0; n < 20; ++n) {
    const ActuationModel device = device_with(random, 3, 1);
    const double K = random.uniform(300.0, 900.0);
    const Vec3 field_N = 2.0 * random.unit_vector();
    test::EffectBodies bodies;
    bodies.add_body({test::effect_entry<StiffnessEffect>({K})});
    bodies.builder.add_surroundings(test::effect_entry<GravityEffect>(
        {0.0, {0.0, 0.0, 0.0}, {field_N.x(), field_N.y(), field_N.z()}}));
    const double budget_J = n % 2 == 0 ? 0.0 : 2e-3;
    HandAtWall hand(passive_settings(1000.0, budget_J), device,
                    normal_at(random, device, 60 * kDeg), bodies.finish());
    const auto spring_N = [&] {
      const Mat3 R = pose_before(hand.record()).rotation.toRotationMatrix();
      return Vec3(hand.force_N() - device.actuated_part(R * field_N));
    };
    hand.move(-8e-3 * hand.normal());
    const double pressed_N = spring_N().norm();
    EXPECT_NEAR(pressed_N, 0.5 * K * 8e-3, 1e-6 * K);
    hand.align();
    // The turn could add 3 K (4 mm)^2 / 2, which is more than the budget.
    const double spring_J = spring_N().squaredNorm() / (2 * K);
    const double most_J = pressed_N * pressed_N / (2 * K) + budget_J;
    EXPECT_LE(spring_J, most_J * (1 + 1e-6));
    EXPECT_GE(spring_J, most_J * (1 - 1e-2));
    const double depth_m = spring_N().norm() / K;
    hand.move((depth_m + 1e-4) * hand.normal());
    EXPECT_GT(hand.record().contact, 0);
    EXPECT_LE(spring_N().norm(), 64 * kEpsilon * K * 8e-3) << "behind the start of the spring";
  }
}

Vec3 lag_device_m(const TickRecord& record) {
  return pose_before(record).direction(vec3(record.proxy_scene_m) - vec3(record.goal_scene_m));
}

// What the turns add, computed from records and from nothing that the strategy knows. Two sensors,
// one motor, no damper and no effect: the motor has the part e/|lag| of the full force.
class TurnOracle {
 public:
  TurnOracle(const ActuationModel& device, double stiffness_N_per_m)
      : motor_(device.actuated_axis(0)), K_(stiffness_N_per_m) {}

  // The turn of the last tick added this, as the force of this one shows, J. Negative: it took it.
  // settled_m: the lag after that turn of a hand that stayed where it was, device frame.
  double added_J(const TickRecord& last, const TickRecord& now, const Vec3& settled_m) const {
    if (!last.contact || last.rotation_rad == 0.0) return 0.0;
    const double before_J = vec3(last.force_device_N).squaredNorm() / (2 * K_);
    const double kept_J = energy_J(settled_m, start_m(last));  // with the old start
    if (kept_J <= before_J) return kept_J - before_J;
    if (!now.contact) return 0.0;         // no force shows it
    if (!(share(now) > 0.0)) return 0.0;  // the hand went back to the start, wherever it was
    // A start that is less than the old one: the hand went back to it, or is across the motor.
    return std::min(kept_J, energy_J(settled_m, start_m(now))) - before_J;
  }

 private:
  // The part of the spring's force that the motor has.
  double share(const TickRecord& record) const {
    return vec3(record.force_device_N).dot(motor_) / vec3(record.full_force_device_N).dot(motor_);
  }
  double start_m(const TickRecord& record) const {
    return (1.0 - share(record)) * lag_device_m(record).norm();
  }
  double energy_J(const Vec3& lag_m, double start_m) const {
    const double depth = std::max(0.0, 1.0 - start_m / lag_m.norm());
    return 0.5 * K_ * std::pow(lag_m.dot(motor_) * depth, 2);
  }

  Vec3 motor_;
  double K_;
};

// The same hand under plain A4, which turns the scene alike. After each tick it stays for a moment
// in which nothing turns: its lag is that after the turn, with edges, corners and whatever else is
// there.
class StillHand {
 public:
  explicit StillHand(HapticLoop loop) : loop_(std::move(loop)) {}
  // No value: a proxy at an edge has gone another way since the hand stayed for a moment.
  std::optional<TickRecord> settled(const TickRecord& now) {
    const TickRecord same = loop_.tick(vec3(now.device_m), kTick_s);
    if (!lag_device_m(same).isApprox(lag_device_m(now), 1e-9)) return std::nullopt;
    return loop_.tick(vec3(now.device_m), std::numeric_limits<double>::min());
  }

 private:
  HapticLoop loop_;
};

struct HandResult {
  double most_of_budget = 0.0;  // added until a tick of a contact, as a share of its budget
  double worst_excess_J = 0.0;  // above the budget and the rounding of lags
  int turns = 0;
  int turns_away = 0;  // that took energy
  int falls = 0;       // over an edge, by a turn
  int lost = 0;        // the still hand is elsewhere, and the oracle ends
};

// A hand that wanders in and out of an object, faster and slower.
HandResult wander(const PaperObject& object, SeededRandom& random, int hand_number) {
  const TriangleMesh mesh =
      test::made(prism(object.contour_m, -kPaperObjectHeight_m / 2, kPaperObjectHeight_m / 2));
  OwnedWorld world(test::Soup{mesh.positions_m, mesh.triangles});
  const bool has_friction = hand_number % 3 == 0;
  if (has_friction) {
    const double mu = random.uniform(0.1, 1.0);
    world.set_effects(test::with_friction(mu, mu));
  }
  const ActuationModel device = device_with(random, 2, 1);
  const double K = random.uniform(300.0, 3000.0);
  const double budget_J = hand_number % 4 == 0 ? 0.0 : random.uniform(0.0, 20e-3);
  auto loop = test::made(HapticLoop::create(world.world(), device, passive_settings(K, budget_J)));
  // Twice the stand-off, in which a proxy rests before a wall.
  const double gap_m = 2e-11 * world.world().size_m;
  const TurnOracle oracle(device, K);
  HapticSettings a4 = passive_settings(K, budget_J);
  set_strategy({&kA4Strategy}, a4);
  StillHand still(test::made(HapticLoop::create(world.world(), device, a4)));
  TickRecord settled;
  // Around the contour, up to 10 mm deep and 5 mm above it, in the scene.
  const auto place = [&] {
    const std::size_t wall = random.index(object.contour_m.size());
    const Point2& from = object.contour_m[wall];
    const Point2& to = object.contour_m[(wall + 1) % object.contour_m.size()];
    const Point2 along = (to - from).normalized();
    const Point2 p = from + random.uniform(0.0, 1.0) * (to - from) +
                     random.uniform(-5e-3, 10e-3) * Point2(-along.y(), along.x());
    return Vec3(p.x(), p.y(), 0.0);
  };
  Vec3 aim_m = place();
  Vec3 at_m = 1.5 * aim_m;
  HandResult result;
  TickRecord last;
  double added_J = 0.0;
  double rounding_J = 0.0;
  double last_touch_s = 0.0;
  for (int tick = 0; tick < 4000; ++tick) {
    if (tick % 500 == 0) aim_m = loop.T_device_scene().point(place());
    at_m += 5e-3 * (aim_m - at_m);
    const TickRecord now = loop.tick(at_m, kTick_s);
    const double turn_J = oracle.added_J(last, now, lag_device_m(settled));
    added_J += turn_J;
    if (now.contact) {
      if (now.time_s - last_touch_s > 1.0) added_J = rounding_J = 0.0;
      if (!last.contact) added_J = std::max(0.0, added_J);  // no contact has more than the budget
      last_touch_s = now.time_s;
      result.turns_away += turn_J < -gap_m * vec3(now.full_force_device_N).norm();
      rounding_J += gap_m * vec3(now.full_force_device_N).norm();
      result.worst_excess_J = std::max(result.worst_excess_J, added_J - budget_J - rounding_J);
      if (budget_J > 0.0) {
        result.most_of_budget = std::max(result.most_of_budget, added_J / budget_J);
      }
      result.turns += now.rotation_rad != 0.0;
    }
    const auto after = still.settled(now);
    if (!after) {
      result.lost += !has_friction;  // what friction holds depends on every step
      break;
    }
    settled = *after;
    result.falls += now.rotation_rad != 0.0 && now.contacts == 1 && settled.contacts == 1 &&
                    vec3(settled.normal_scene) != vec3(now.normal_scene);
    last = now;
  }
  return result;
}

TEST(A4Passive, TurnsAddAtMostTheBudgetOnThePapersObjects) {
  int turns = 0;
  int turns_away = 0;
  int falls = 0;
  int lost = 0;
  int spent = 0;
  const Random base(490400);
  std::cout << "seed " << base.seed() << "\n";
  for (int n = 0; n < 200; ++n) {
    SeededRandom random(base.seed() + static_cast<std::uint64_t>(n));
    const auto objects = paper_objects();
    const HandResult result = wander(objects[n % objects.size()], random, n);
    EXPECT_LE(result.worst_excess_J, 0.0) << "hand " << n;
    turns += result.turns;
    turns_away += result.turns_away;
    falls += result.falls;
    lost += result.lost;
    spent += result.most_of_budget > 0.999;
  }
  EXPECT_GT(turns, 200 * 1000);
  EXPECT_GT(turns_away, 200);
  EXPECT_GT(spent, 20);
  EXPECT_GT(falls, 0);
  EXPECT_LT(lost, 20);
}

// A spring of 1000 N/m, 10 mm long, at this angle to the motor.
MotorSpring spring_at(double angle_rad) {
  return {1000.0, 10e-3, 10e-3 * std::cos(angle_rad)};
}

TEST(A4PassiveBudget, IsInheritedWithinASecondAndWholeAfterIt) {
  for (const double pause_s : {0.0, 0.5, 1.0, 1.001, 20.0}) {
    TurnBudget budget(10e-3);
    budget.touch(spring_at(60 * kDeg), 2.0);
    budget.turn(spring_at(55 * kDeg));
    const double paid_J =
        0.5 * 1000.0 * 1e-4 * (std::pow(std::cos(55 * kDeg), 2) - std::pow(std::cos(60 * kDeg), 2));
    EXPECT_NEAR(budget.left_J(), 10e-3 - paid_J, 1e-15);
    EXPECT_EQ(budget.start_m(), 0.0) << "the budget pays the whole turn";
    budget.turn(spring_at(0.0));
    EXPECT_EQ(budget.left_J(), 0.0);
    const double start_m = budget.start_m();
    EXPECT_NEAR(0.5 * 1000.0 * std::pow(10e-3 - start_m, 2), 12.5e-3 + 10e-3, 1e-15);
    budget.touch(spring_at(0.0), 3.0);
    EXPECT_EQ(budget.start_m(), start_m) << "a contact keeps its start";
    budget.end_contact();
    EXPECT_EQ(budget.start_m(), 0.0);
    budget.touch(spring_at(60 * kDeg), 3.0 + pause_s);
    EXPECT_EQ(budget.left_J(), pause_s > 1.0 ? 10e-3 : 0.0) << pause_s;
    EXPECT_EQ(budget.start_m(), 0.0);
  }
}

TEST(A4PassiveBudget, GetsBackWhatATurnTakesFromTheSpring) {
  TurnBudget budget(1e-3);
  budget.touch(spring_at(30 * kDeg), 0.0);
  budget.turn(spring_at(60 * kDeg));
  EXPECT_NEAR(budget.left_J(), 1e-3 + 37.5e-3 - 12.5e-3, 1e-15);
  budget.turn(spring_at(30 * kDeg));
  EXPECT_NEAR(budget.left_J(), 1e-3, 1e-15);
  EXPECT_EQ(budget.start_m(), 0.0) << "a turn back costs nothing";
  budget.turn(spring_at(0.0));
  EXPECT_EQ(budget.left_J(), 0.0);
  EXPECT_NEAR(spring_at(0.0).energy_J(budget.start_m()), 37.5e-3 + 1e-3, 1e-15);
}

TEST(A4PassiveBudget, PaysTheMostThatAFallCanHaveAddedBeforeTheStepOfTheHand) {
  for (const double budget_J : {0.0, 5e-3, 1.0}) {
    TurnBudget budget(budget_J);
    budget.touch(spring_at(60 * kDeg), 0.0);
    budget.turn(spring_at(60 * kDeg));
    // It fell to 10 mm along the motor, and the hand went back by 1 mm.
    const MotorSpring before_step = spring_at(0.0);
    budget.touch({1000.0, 9e-3, 9e-3}, 1e-3, 1e-3);
    const double most_J = std::min(12.5e-3 + budget_J, 50e-3);
    EXPECT_NEAR(before_step.energy_J(budget.start_m()), most_J, 1e-15);
    EXPECT_NEAR(budget.left_J(), 12.5e-3 + budget_J - most_J, 1e-15);
  }
}

TEST(A4PassiveBudget, GetsNothingBackFromAFallOrForALaterContact) {
  TurnBudget budget(1e-3);
  budget.touch(spring_at(30 * kDeg), 0.0);
  budget.turn(spring_at(30 * kDeg));
  budget.touch(spring_at(60 * kDeg), 0.1, 1e-6);
  EXPECT_NEAR(budget.left_J(), 1e-3, 1e-15) << "a fall takes energy that the hand may have got";
  budget.turn(spring_at(70 * kDeg));
  EXPECT_GT(budget.left_J(), 1e-3);
  budget.end_contact();
  budget.touch(spring_at(60 * kDeg), 0.2);
  EXPECT_EQ(budget.left_J(), 1e-3) << "a contact has its budget at most";
}

// Turns and motions of the hand in any order. The oracle adds up what the turns change in U. A turn
// moves the start only if this sum would be above the budget, and then to the budget.
TEST(A4PassiveBudget, IsTheMostThatTurnsHaveAddedAtAnyTime) {
  Random random(4908);
  constexpr double kRounding_J = 1e-12;  // of 1000 sums of energies below 0.1 J
  int spent = 0;
  for (int n = 0; n < 200; ++n) {
    const double budget_J = n % 4 == 0 ? 0.0 : random.uniform(0.0, 20e-3);
    TurnBudget budget(budget_J);
    const auto spring = [&] {
      const double stretch_m = random.uniform(1e-3, 10e-3);
      return MotorSpring{1000.0, stretch_m, stretch_m * random.uniform(0.1, 1.0)};
    };
    MotorSpring now = spring();
    budget.touch(now, 0.0);
    double added_J = 0.0;
    for (int tick = 1; tick < 1000; ++tick) {
      const double before_J = now.energy_J(budget.start_m());
      const double start_m = budget.start_m();
      const MotorSpring next = spring();
      if (random.index(4) == 0) {
        budget.touch(next, 1e-3 * tick);
        EXPECT_EQ(budget.start_m(), std::min(start_m, next.stretch_m));
      } else {
        budget.turn(next);
        added_J += next.energy_J(budget.start_m()) - before_J;
        EXPECT_GE(budget.start_m(), start_m);
        if (budget.start_m() > start_m) {
          EXPECT_NEAR(added_J, budget_J, kRounding_J);
          ++spent;
        }
      }
      ASSERT_LE(added_J, budget_J + kRounding_J) << "case " << n << " tick " << tick;
      now = next;
    }
  }
  EXPECT_GT(spent, 1000);
}

// Positions of a hand that begins outside of a box of 0.2 m and wanders in and out of it.
std::vector<Vec3> path_in_box(SeededRandom& random) {
  std::vector<Vec3> path{{0.15, 0.0, 0.0}};
  Vec3 aim = path.front();
  for (int n = 0; n < 3000; ++n) {
    if (n % 100 == 0) aim = 0.12 * random.unit_vector();
    path.push_back(path.back() + 0.01 * (aim - path.back()));
  }
  return path;
}

// With a budget above all that a turn can add, or with as many motors as sensors, no start begins.
TEST(A4Passive, IsA4ToTheBitWhereTheBudgetPaysEveryTurn) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  Random random(4906);
  for (int n = 0; n < 20; ++n) {
    const bool is_full = n % 4 == 0;
    const ActuationModel device =
        is_full ? *ActuationModel::from_counts(3, 3) : device_with(random, 2 + n % 2, 1 + n % 2);
    HapticSettings passive = passive_settings(5.0, is_full ? 0.0 : 1.0);
    passive.coupling.damping_Ns_per_m = 0.01;
    HapticSettings a4 = passive;
    set_strategy({&kA4Strategy}, a4);
    auto one = test::made(HapticLoop::create(world.world(), device, passive));
    auto other = test::made(HapticLoop::create(world.world(), device, a4));
    int turns = 0;
    for (const Vec3& p : path_in_box(random)) {
      const TickRecord& record = one.tick(p, kTick_s);
      ASSERT_EQ(std::memcmp(&record, &other.tick(p, kTick_s), sizeof record), 0) << record.tick;
      turns += record.rotation_rad != 0.0;
    }
    EXPECT_EQ(turns > 100, !is_full);
  }
}

// Proxy, pose and full force are those of A4; the commanded force is a part of A4's.
TEST(A4Passive, ChangesNothingButTheCommandedForce) {
  const OwnedWorld world(test::box_soup(Vec3::Constant(0.1)));
  Random random(4907);
  for (int n = 0; n < 20; ++n) {
    const ActuationModel device = device_with(random, 2 + n % 2, 1 + n % 2);
    HapticSettings passive = passive_settings(1000.0, random.uniform(0.0, 10e-3));
    passive.coupling.damping_Ns_per_m = 1.0;
    HapticSettings a4 = passive;
    set_strategy({&kA4Strategy}, a4);
    auto one = test::made(HapticLoop::create(world.world(), device, passive));
    auto other = test::made(HapticLoop::create(world.world(), device, a4));
    for (const Vec3& p : path_in_box(random)) {
      TickRecord record = one.tick(p, kTick_s);
      const TickRecord& with_a4 = other.tick(p, kTick_s);
      const Vec3 force_N = vec3(record.force_device_N);
      const Vec3 a4_N = vec3(with_a4.force_device_N);
      ASSERT_LE(force_N.norm(), a4_N.norm() * (1 + 4 * kEpsilon));
      ASSERT_GE(force_N.dot(a4_N), 0.0);
      ASSERT_LE(force_N.cross(a4_N).norm(), 16 * kEpsilon * a4_N.squaredNorm());
      std::copy_n(with_a4.force_device_N, 3, record.force_device_N);
      ASSERT_EQ(std::memcmp(&record, &with_a4, sizeof record), 0) << record.tick;
    }
  }
}

}  // namespace
}  // namespace palpate
