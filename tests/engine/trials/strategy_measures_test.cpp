// The measures of a trial that only comparisons of strategies need, against values computed by
// hand.

#include "engine/trials/strategy_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// Rounding of a handful of operations on numbers of this size.
void expect_near(double value, double expected) {
  EXPECT_NEAR(value, expected, 1e-12 * std::abs(expected)) << expected;
}

constexpr double kDt_s = 1e-3;

// A tick with a wall along y below the device, whose normal is y.
TickRecord tick(double x_m, double y_m, bool contact) {
  TickRecord record;
  record.device_m[0] = x_m;
  record.device_m[1] = y_m;
  record.contact = contact ? 1 : 0;
  if (contact) record.normal_scene[1] = 1.0;
  return record;
}

std::array<std::optional<double>, kMeasureCount> measured(const std::vector<TickRecord>& ticks) {
  StrategyMeasures measures(kDt_s);
  measures.begin(ticks.front());
  for (const TickRecord& record : ticks) measures.add(record);
  std::array<std::optional<double>, kMeasureCount> values;
  measures.put(values);
  return values;
}

TEST(StrategyMeasures, CountsWorkAlongTheWallOnlyWhereTheForcePushes) {
  std::vector<TickRecord> ticks = {tick(0, 0, true), tick(0.25, 0.5, true), tick(0, 0.5, true),
                                   tick(4, 4, false), tick(8, 8, true)};
  for (TickRecord& record : ticks) put(Vec3(2.0, 8.0, 0.0), record.force_device_N);
  // Along x: 2 * 0.25, then -2 * 0.25, which does not count, then 2 * 4; not after the loss.
  EXPECT_EQ(measured(ticks)[kWallWork], 0.5 + 8.0);
}

TEST(StrategyMeasures, TakesTheNormalInTheDeviceFrame) {
  std::vector<TickRecord> ticks = {tick(0, 0, true), tick(0.25, 0.5, true)};
  // The scene is turned by 180 deg about x and y: the normal y becomes x.
  const double h = std::sqrt(0.5);
  for (TickRecord& record : ticks) {
    put(Vec3(2.0, 8.0, 0.0), record.force_device_N);
    put(ScenePose{Quat(0.0, h, h, 0.0), Vec3::Zero()}, record.q_before_wxyz, record.o_before_m);
  }
  expect_near(*measured(ticks)[kWallWork], 8.0 * 0.5);
}

TEST(StrategyMeasures, TheLargestContactWorkIsOfOneContact) {
  std::vector<TickRecord> ticks = {tick(0, 0, true),   tick(0, 1, true), tick(0, 0.5, false),
                                   tick(0, 9, false),  tick(0, 0, true), tick(0, 0.25, true),
                                   tick(0, 0.5, false)};
  for (TickRecord& record : ticks) put(Vec3(0.0, 4.0, 0.0), record.force_device_N);
  // First contact: 4 * 1 - 4 * 0.5 = 2; free motion does not count; second: 4 * 0.5 = 2 up to here.
  EXPECT_EQ(measured(ticks)[kLargestContactWork], 2.0);
  ticks.push_back(tick(0, 0, true));
  put(Vec3(0.0, 4.0, 0.0), ticks.back().force_device_N);
  ticks.push_back(tick(0, 0.75, true));
  EXPECT_EQ(measured(ticks)[kLargestContactWork], 3.0) << "the last contact goes on";
  for (TickRecord& record : ticks) record.force_device_N[1] = -1.0;
  EXPECT_EQ(measured(ticks)[kLargestContactWork], -0.5) << "every contact took energy";
}

// Ticks of free motion; the scene turns in the first ones.
std::vector<TickRecord> turn(int turning, int still, bool touches) {
  std::vector<TickRecord> ticks;
  for (int i = 0; i < turning + still; ++i) {
    ticks.push_back(tick(0, 0, false));
    if (i < turning) ticks.back().rotation_rad = 0.01;
  }
  if (touches) ticks.push_back(tick(0, 0, true));
  return ticks;
}

TEST(StrategyMeasures, ATurnIsEmptyAfterATenthOfASecondWithoutATouch) {
  EXPECT_EQ(measured(turn(5, 0, true))[kEmptyTurns], 0.0);
  EXPECT_EQ(measured(turn(5, 99, true))[kEmptyTurns], 0.0);
  EXPECT_EQ(measured(turn(5, 100, true))[kEmptyTurns], 1.0);
  EXPECT_EQ(measured(turn(5, 99, false))[kEmptyTurns], 0.0) << "cut off by the end";
  std::vector<TickRecord> several;
  for (const auto& part : {turn(3, 50, false), turn(3, 150, false), turn(1, 200, true)}) {
    several.insert(several.end(), part.begin(), part.end());
  }
  several.back().rotation_rad = 0.01;  // A4 in contact
  several.push_back(tick(0, 0, false));
  EXPECT_EQ(measured(several)[kEmptyTurns], 2.0);
}

TEST(StrategyMeasures, DriftIsTheWayOfASceneThatDoesNotTurn) {
  std::vector<TickRecord> ticks(4, tick(0, 0, false));
  put(Vec3(1.0, 0.0, 0.0), ticks[0].o_before_m);
  put(Vec3(4.0, 4.0, 0.0), ticks[1].o_before_m);
  put(Vec3(1.0, 0.0, 0.0), ticks[2].o_before_m);
  put(Vec3(1.0, 0.0, 1.0), ticks[3].o_before_m);
  auto values = measured(ticks);
  EXPECT_EQ(values[kMeanDrift], 1.5);
  EXPECT_EQ(values[kWorstDrift], 5.0);
  ticks[2].q_before_wxyz[3] = 1e-9;
  values = measured(ticks);
  EXPECT_FALSE(values[kMeanDrift] || values[kWorstDrift]);
}

TEST(StrategyMeasures, CountsTicksInWhichTheGovernorActedOnTheForce) {
  std::vector<TickRecord> ticks(8, tick(0, 0, true));
  ticks[1].rules = kRuleClamp;
  ticks[2].rules = kRuleClamp | kRuleMotors;
  ticks[3].rules = kRuleTripped;
  ticks[4].rules = kRuleOrder;
  ticks[5].faults = kFaultSolverCapped;
  EXPECT_EQ(measured(ticks)[kGovernorShare], 3.0 / 8.0);
}

// A wall at 60 deg to A1, 10 mm above the device point, turns to 30 deg under A4. The motor along
// A1 gives a part of its force, before the turn and after it.
std::vector<TickRecord> turning_wall(double part_before, double part_after) {
  std::vector<TickRecord> ticks(2, tick(0, 0, true));
  const double degrees[] = {60.0, 30.0};
  const double parts[] = {part_before, part_after};
  for (std::size_t i = 0; i < 2; ++i) {
    TickRecord& record = ticks[i];
    const double angle = degrees[i] * std::numbers::pi / 180.0;
    const Vec3 n(std::cos(angle), std::sin(angle), 0.0);
    const Quat turned = Quat::FromTwoVectors(Vec3::UnitY(), n);
    put(ScenePose{turned, Vec3::Zero()}, record.q_before_wxyz, record.o_before_m);
    record.contacts = 1;
    record.proxy_scene_m[1] = 10e-3 * (i == 0 ? 1.0 : std::cos(std::numbers::pi / 6));
    record.alpha_rad = angle;
    const Vec3 full_N = 1000.0 * record.proxy_scene_m[1] * n;
    put(full_N, record.full_force_device_N);
    put(Vec3(parts[i] * full_N.x(), 0.0, 0.0), record.force_device_N);
  }
  ticks[0].rotation_rad = std::numbers::pi / 6;
  std::copy_n(ticks[1].q_before_wxyz, 4, ticks[0].q_after_wxyz);
  return ticks;
}

TEST(StrategyMeasures, CountsWhatTurnsAddToTheSpringOfTheMotors) {
  const auto energy_J = [](const std::vector<TickRecord>& ticks) {
    return *measured(ticks)[kTurningEnergy];
  };
  // 500 N/m times the square of e cos(a): e = 10 mm at 60 deg, 8.66 mm at 30 deg.
  const double before_J = 500.0 * 25e-6;
  const double after_J = 500.0 * 56.25e-6;
  expect_near(energy_J(turning_wall(1.0, 1.0)), after_J - before_J);
  expect_near(energy_J(turning_wall(0.5, 1.0)), after_J - 0.25 * before_J);
  expect_near(energy_J(turning_wall(0.5, 0.5)), 0.25 * (after_J - before_J));
  EXPECT_EQ(energy_J(turning_wall(1.0, 0.5)), 0.0) << "a turn that adds nothing";
  EXPECT_EQ(energy_J(turning_wall(1.0, 0.0)), 0.0) << "no force";
  auto ticks = turning_wall(1.0, 1.0);
  ticks[1].rules = kRuleClamp;
  EXPECT_EQ(energy_J(ticks), 0.0);
  ticks[1].rules = kRuleOrder;
  expect_near(energy_J(ticks), after_J - before_J);
  ticks[1].normal_scene[1] = 0.5;
  EXPECT_EQ(energy_J(ticks), 0.0) << "another wall";
  ticks = turning_wall(1.0, 1.0);
  ticks[0].rotation_rad = 0.0;
  EXPECT_EQ(energy_J(ticks), 0.0) << "no turn";
}

}  // namespace
}  // namespace palpate
