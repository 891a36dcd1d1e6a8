// What the haptic thread sees of a pantograph.

#include "engine/devices/hapi_view.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/devices/five_bar_workspace.h"
#include "haptics/motor_limits.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

HapiSettings calibrated() {
  HapiSettings settings;
  settings.torque_per_Nm = 2.0;
  settings.peak_torque_Nm = 0.1;
  return settings;
}

HapiSample sample_at(const HapiPose& pose, std::uint64_t sequence) {
  HapiSample sample;
  sample.tip_m = {pose.tip_m.x(), pose.tip_m.y()};
  const Mat2& j = pose.jacobian;
  sample.jacobian = {j(0, 0), j(0, 1), j(1, 0), j(1, 1)};
  sample.sequence = sequence;
  sample.is_working = true;
  return sample;
}

HapiPose pose_at(const FiveBar& bar, const Vec2& tip_m) {
  HapiPose pose;
  pose.joints_rad = *bar.inverse(tip_m);
  pose.tip_m = tip_m;
  pose.jacobian = *bar.jacobian(pose.joints_rad);
  return pose;
}

TEST(FiveBarWorkspace, HasFullForceEverywhereAndCannotGrow) {
  Random random(1);
  for (int n = 0; n < 20; ++n) {
    const FiveBar bar(n == 0 ? FiveBarLinks{}
                             : FiveBarLinks{random.uniform(0.01, 0.04), random.uniform(0.05, 0.08),
                                            random.uniform(0.07, 0.12)});
    const auto box = full_force_workspace(bar);
    ASSERT_TRUE(box);
    EXPECT_NEAR(box->low_m.x() + box->high_m.x(), bar.links().base_m, 1e-12);
    const double step_m = (bar.links().proximal_m + bar.links().distal_m) / kGridSteps;
    const auto condition = [&](double x, double y) {
      const auto joints = bar.inverse({x, y});
      const auto jacobian = joints ? bar.jacobian(*joints) : std::nullopt;
      return jacobian ? condition_number(*jacobian) : 1e300;
    };
    // On the grid exactly; a point between has at most the growth over one step.
    bool can_widen = true;
    for (double y = box->low_m.y(); y < box->high_m.y() + 0.5 * step_m; y += step_m) {
      for (double x = box->low_m.x(); x < box->high_m.x() + 0.5 * step_m; x += step_m) {
        ASSERT_LE(condition(x, y), kFullForceCondition * (1.0 + 1e-9));
      }
      can_widen = can_widen && condition(box->high_m.x() + step_m, y) <= kFullForceCondition &&
                  condition(box->low_m.x() - step_m, y) <= kFullForceCondition;
    }
    EXPECT_FALSE(can_widen);
  }
}

TEST(FiveBarWorkspace, LinksThatCannotMeetHaveNone) {
  EXPECT_FALSE(full_force_workspace(FiveBar({.base_m = 1.0, .proximal_m = 0.05})));
}

TEST(HapiView, DescribesThePantograph) {
  const DeviceDescription device = hapi_description(calibrated());
  EXPECT_EQ(device.sensed_axes, 2);
  EXPECT_EQ(device.motor_count, 2);
  EXPECT_TRUE(device.moves_motors);
  EXPECT_EQ(device.when_host_is_silent, HostSilence::kHoldsForce);
  EXPECT_GT(device.peak_force_N, 0.0);
  EXPECT_GT(device.encoder_quantum_m, 0.0);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_GT(device.workspace_high_m[k], 0.02);
    EXPECT_EQ(device.workspace_low_m[k], -device.workspace_high_m[k]);
    const Vec3 direction(device.motors[k].direction_device.data());
    EXPECT_TRUE(is_unit(direction));
  }
}

TEST(HapiView, HasNoMotorsWithoutACalibration) {
  HapiView view{HapiSettings{}};
  EXPECT_EQ(view.description().motor_count, 0);
  EXPECT_TRUE(view.description().moves_motors);  // so that the governor gives it no force
  EXPECT_TRUE(view.motors().empty());
}

TEST(HapiView, PositionsAreRelativeToTheMiddleOfTheWorkspace) {
  const auto box = full_force_workspace(FiveBar(FiveBarLinks{}));
  HapiView view(calibrated());
  const DeviceSample corner =
      view.take(sample_at(pose_at(FiveBar(FiveBarLinks{}), box->high_m), 1));
  EXPECT_NEAR(corner.position_m[0], view.description().workspace_high_m[0], 1e-12);
  EXPECT_NEAR(corner.position_m[1], view.description().workspace_high_m[1], 1e-12);
  EXPECT_EQ(corner.position_m[2], 0.0);
}

// Each motor alone with its peak torque exerts its peak force along its direction: the torques of
// that force are the peak torque and zero.
TEST(HapiView, MotorsHaveTheDirectionsAndPeaksOfThePose) {
  Random random(2);
  const HapiSettings settings = calibrated();
  const FiveBar bar(settings.links);
  const auto box = *full_force_workspace(bar);
  HapiView view(settings);
  for (int n = 0; n < 500; ++n) {
    const Vec2 tip_m(random.uniform(box.low_m.x(), box.high_m.x()),
                     random.uniform(box.low_m.y(), box.high_m.y()));
    const HapiPose pose = pose_at(bar, tip_m);
    view.take(sample_at(pose, static_cast<std::uint64_t>(n) + 1));
    ASSERT_EQ(view.motors().size(), 2u);
    for (int k = 0; k < 2; ++k) {
      const MotorDescription& motor = view.motors()[static_cast<std::size_t>(k)];
      const Vec2 force_N = motor.peak_force_N * Vec2(motor.direction_device.data());
      const Vec2 torques_Nm = pose.jacobian.transpose() * force_N;
      // The condition is at most 10, and some ten operations round.
      ASSERT_NEAR(torques_Nm[k], 0.1, 1e-13);
      ASSERT_NEAR(torques_Nm[1 - k], 0.0, 1e-13);
    }
    // The governor's peak rule therefore limits the torques.
    const MotorLimits limits(view.motors());
    const Vec3 wanted_N(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), 0.0);
    const Vec2 given_N = limits.scale(wanted_N) * wanted_N.head<2>();
    const double largest = (pose.jacobian.transpose() * given_N).cwiseAbs().maxCoeff();
    ASSERT_LE(largest, 0.1 * (1.0 + 1e-12));
  }
}

TEST(HapiView, KeepsItsMotorsAtAPoseWithoutAJacobian) {
  HapiView view(calibrated());
  const HapiPose pose = pose_at(FiveBar(FiveBarLinks{}), {0.0, 0.08});
  view.take(sample_at(pose, 1));
  const MotorDescription before = view.motors()[0];
  HapiSample singular = sample_at(pose, 2);
  singular.jacobian = {};
  view.take(singular);
  EXPECT_EQ(view.motors()[0].direction_device, before.direction_device);
  EXPECT_EQ(view.motors()[0].peak_force_N, before.peak_force_N);
}

TEST(HapiView, AsksForATripOnceForEachTripAndWhileTheMotorsDoNotObey) {
  HapiView view(calibrated());
  HapiSample sample = sample_at(pose_at(FiveBar(FiveBarLinks{}), {0.0, 0.08}), 1);
  EXPECT_FALSE(view.take(sample).asks_for_trip);
  sample.is_working = false;
  sample.trips = 1;
  EXPECT_TRUE(view.take(sample).asks_for_trip);
  EXPECT_TRUE(view.take(sample).asks_for_trip);
  sample.is_working = true;
  EXPECT_FALSE(view.take(sample).asks_for_trip);
  sample.trips = 3;  // two trips between two ticks, and the board answers again
  EXPECT_TRUE(view.take(sample).asks_for_trip);
  EXPECT_FALSE(view.take(sample).asks_for_trip);
}

TEST(HapiView, ASampleIsInvalidBeforeTheFirstAnswer) {
  HapiView view(calibrated());
  EXPECT_FALSE(view.take(HapiSample{}).is_valid);
}

}  // namespace
}  // namespace palpate
