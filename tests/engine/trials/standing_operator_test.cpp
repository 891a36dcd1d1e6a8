// The simulated operator who stands at a straight wall, against exact results.

#include <cmath>
#include <cstdint>
#include <iostream>
#include <numbers>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "engine/rig/rig.h"
#include "engine/simulation/simulated_device.h"
#include "engine/simulation/simulated_run.h"
#include "engine/trials/operator_hand.h"
#include "engine/trials/trial_clock.h"
#include "models/primitives.h"
#include "tests/engine/trials/prepared_object.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using test::PreparedObject;

constexpr double kWall_N_per_m = 1000.0;
constexpr double kHand_N_per_m = 443.0;
constexpr double kPressDepth_m = 10e-3;
constexpr double kNoise_Hz = 0.3;

// A person who stands still. The target stays kPressDepth_m inside the wall.
OperatorParameters standing_person(double noise_m) {
  OperatorParameters person;
  person.force_noise = 0.0;
  person.intention_noise_m = noise_m;
  person.intention_noise_Hz = kNoise_Hz;
  person.hand_stiffness_N_per_m = kHand_N_per_m;
  person.press_depth_m = kPressDepth_m;
  person.speed_m_per_s = 0.0;
  return person;
}

// A block with walls of 0.4 m and 0.2 m; the spheres are on a wall of 0.4 m. angle_rad: from the
// normal of this wall to the only motor.
PreparedObject straight_wall(double angle_rad) {
  const TriangleMesh mesh = box({0.4, 0.2, 0.04});
  SceneDescription description;
  description.meshes.push_back({"", mesh.positions_m, mesh.triangles});
  description.nodes.emplace_back();
  description.tree.emplace_back();
  RunSettings device = test::paper_device();
  device.haptics.coupling.stiffness_N_per_m = kWall_N_per_m;
  // The wall is parallel to the x axis.
  device.actuated_axes = {{std::sin(angle_rad), std::cos(angle_rad), 0.0}};
  return test::prepared(test::compiled(std::move(description)), device);
}

// Leads the hand of a person who does not walk to the wall: as long as the person aims at the place
// of rest in front of the wall, the hand's target is displaced by to_wall_m, to the press depth.
class LedToTheWall final : public HandPlan {
 public:
  LedToTheWall(OperatorHand& person, const Vec3& to_wall_m)
      : person_(person), to_wall_m_(to_wall_m) {}

  HandTarget target(double time_s, const ScenePose& T_device_scene,
                    const TickRecord& last) noexcept override {
    HandTarget target = person_.target(time_s, T_device_scene, last);
    if (time_s == 0.0) rest_m_ = target.position_m;
    // The person's own target jumps from the place of rest by to_wall_m.
    is_led_ =
        is_led_ && (target.position_m - rest_m_).dot(to_wall_m_) < 0.5 * to_wall_m_.squaredNorm();
    if (is_led_) target.position_m += T_device_scene.direction(to_wall_m_);
    return target;
  }
  bool is_led() const { return is_led_; }

 private:
  OperatorHand& person_;
  Vec3 to_wall_m_;
  Vec3 rest_m_ = Vec3::Zero();
  bool is_led_ = true;
};

// The clock's measures of a person who stands for this time.
struct Standing {
  double depth_m = 0.0;  // mean in contact
  double losses_per_s = 0.0;
};

Standing stand(const PreparedObject& wall, const OperatorParameters& person, ForceMode force,
               std::uint64_t seed, double duration_s) {
  RunSetup setup = wall.setup;
  setup.haptics.force = force;
  const PlantSettings plant = plant_of(setup, person, seed);
  EXPECT_FALSE(check_setup(wall.scene, setup));
  EXPECT_FALSE(check_plant(plant, setup.dt_s));
  TrialSettings settings;
  settings.limit_s = duration_s;
  OperatorHand hand(wall.way, person, Following::kDelayed, settings, 0.0, Recovery::kOff);
  const Vec3 outside_m = hand.start_scene_m() - wall.way.green_m;
  LedToTheWall plan(hand, outside_m.normalized() * -(outside_m.norm() + person.press_depth_m));
  TrialClock clock(wall.way, settings, 0.0, setup.dt_s);
  SimulatedDevice device =
      device_in_hand(plant, setup, plan, setup.haptics.initial_pose.point(hand.start_scene_m()));
  const auto rig = Rig::create(wall.scene, setup, device, {.observers = {&clock, &device}});
  if (!rig.ok()) {
    ADD_FAILURE() << rig.error().to_string();
    return {};
  }
  const auto ticks = static_cast<std::uint64_t>(std::llround(duration_s / setup.dt_s));
  run_simulated((*rig)->session(), setup.dt_s, ticks,
                [&](std::uint64_t) { return clock.is_over(); });
  EXPECT_FALSE(plan.is_led()) << "the person never felt the wall";
  EXPECT_EQ(hand.recoveries(), 0u);
  const auto measures = clock.measures();
  return {measures[kPenetration].value_or(0.0), measures[kLossesPerSecond].value_or(0.0)};
}

// The density and the distribution function of the normal distribution.
double density(double x) {
  return std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
}
double distribution(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

// What a slow noise eta of standard deviation s gives a hand that is at rest in every moment. There
// is contact while D + eta > 0; without force the depth is D + eta, and with force the springs
// share it. Both expectations follow from the normal distribution, the losses from Rice's formula.
struct Expected {
  double depth_m = 0.0;
  double losses_per_s = 0.0;
  // Standard deviations in a run of some length, as shares of the values above.
  double depth_scatter = 0.0;
  double losses_scatter = 0.0;
};

// depths: D / s.
Expected expected_without_force(double depths, double duration_s) {
  const double hazard = density(depths) / distribution(depths);
  Expected e;
  e.depth_m = kPressDepth_m * (1.0 + hazard / depths);
  e.losses_per_s = kNoise_Hz * std::exp(-0.5 * depths * depths);
  // Depths in contact have the variance s^2 (1 - depths hazard - hazard^2). A mean over T has the
  // scatter of T / (4 z / w) independent ones: the integral of the noise's correlation over all
  // lags is 4 z / w, z = 0.7. Of these the share distribution(depths) is in contact.
  const double correlated_s = 4.0 * 0.7 / (2.0 * std::numbers::pi * kNoise_Hz);
  const double independent = duration_s / correlated_s * distribution(depths);
  const double variance = 1.0 - depths * hazard - hazard * hazard;
  e.depth_scatter = std::sqrt(variance / independent) / (depths + hazard);
  // The noise has to come back before it is lost again, so that losses scatter less than
  // independent events.
  e.losses_scatter = 1.0 / std::sqrt(e.losses_per_s * duration_s);
  return e;
}

class StandingOperator : public testing::TestWithParam<double> {};

// The long run has the stated bounds alone; the short run has three standard deviations more. Both
// runs of a pair have the same noise, so that what force changes has the stated bounds in each run.
TEST_P(StandingOperator, HasTheDepthAndTheLossesOfSlowNoise) {
  constexpr double kDepthBound = 0.05;
  constexpr double kLossesBound = 0.1;
  const double deviations = test::in_soak_or_else(0.0, 3.0);
  const double duration_s = test::in_soak_or_else(5000.0, 1000.0);
  const Expected expected = expected_without_force(GetParam(), duration_s);
  const test::Random random(18);
  const PreparedObject wall = straight_wall(0.0);
  const OperatorParameters person = standing_person(kPressDepth_m / GetParam());
  const Standing free = stand(wall, person, ForceMode::kNone, random.seed(), duration_s);
  const Standing felt = stand(wall, person, ForceMode::kFull, random.seed(), duration_s);
  const double springs = kHand_N_per_m / (kHand_N_per_m + kWall_N_per_m);
  const double depth = free.depth_m / expected.depth_m;
  const double losses = free.losses_per_s / expected.losses_per_s;
  const double depth_by_force = felt.depth_m / (springs * free.depth_m);
  const double losses_by_force = felt.losses_per_s / free.losses_per_s;
  const double losses_bound = kLossesBound + deviations * expected.losses_scatter;
  std::cout << "seed " << random.seed() << ", " << duration_s
            << " s; shares of the expected: depth " << depth << ", losses " << losses
            << "; with force: depth " << depth_by_force << ", losses " << losses_by_force << "\n";
  EXPECT_NEAR(depth, 1.0, kDepthBound + deviations * expected.depth_scatter);
  EXPECT_NEAR(losses, 1.0, losses_bound);
  EXPECT_NEAR(losses * losses_by_force, 1.0, losses_bound);
  EXPECT_NEAR(depth_by_force, 1.0, kDepthBound);
  EXPECT_NEAR(losses_by_force, 1.0, kLossesBound);
}

INSTANTIATE_TEST_SUITE_P(AtAWall, StandingOperator, testing::Values(1.0, 1.5),
                         [](const testing::TestParamInfo<double>& depths) {
                           return depths.param == 1.0 ? std::string("OneDeviationDeep")
                                                      : std::string("OneAndAHalfDeep");
                         });

// The motor pushes with K d cos a, of which the part cos a is along the normal. The wall gives way
// along itself, so that the hand's spring alone decides: K_h (D - d) = K d cos^2 a.
TEST(StandingUnderActuated, HasTheDepthOfTheMotorsShareOfTheNormal) {
  for (int angle_deg = 0; angle_deg <= 90; angle_deg += 15) {
    const double angle_rad = angle_deg * std::numbers::pi / 180.0;
    const Standing standing =
        stand(straight_wall(angle_rad), standing_person(0.0), ForceMode::kActuated, 1, 60.0);
    const double share = std::pow(std::cos(angle_rad), 2);
    const double depth_m = kPressDepth_m / (1.0 + kWall_N_per_m / kHand_N_per_m * share);
    EXPECT_NEAR(standing.depth_m, depth_m, 0.02 * depth_m) << angle_deg << " deg";
    EXPECT_EQ(standing.losses_per_s, 0.0) << angle_deg << " deg";
  }
}

}  // namespace
}  // namespace palpate
