#include "haptics/a4/elementary_rotation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "haptics/a4/scene_pose.h"
#include "haptics/a4/theoretical_rotation.h"
#include "tests/haptics/a4/degrees.h"
#include "tests/helpers/floating_point.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::degrees;
using test::kEpsilon;
using test::radians;
using test::Random;

constexpr std::array<double, 3> kRates_Hz = {60.0, 1000.0, 10000.0};

// Closed form of the time to align with Figure 3's profile: 90 deg/s above 30 deg, 5 + (17/6) a
// below.
double closed_form_s(double from_deg, double to_deg) {
  const auto below = [](double a) { return 6.0 / 17.0 * std::log1p(17.0 / 30.0 * a); };
  const auto above = [](double a) { return std::max(0.0, a - 30.0) / 90.0; };
  return above(from_deg) - above(to_deg) + below(std::min(from_deg, 30.0)) -
         below(std::min(to_deg, 30.0));
}

double step_rad(double angle_rad, double dt_s, StepRule rule = StepRule::kExact) {
  return elementary_rotation_rad(RotationProfile{}, rule, angle_rad, dt_s);
}

TEST(RotationProfile, IsFigure3) {
  const RotationProfile profile;
  for (const auto& [angle_deg, speed] :
       {std::pair(0.0, 5.0), std::pair(15.0, 47.5), std::pair(14.4, 45.8), std::pair(30.0, 90.0),
        std::pair(60.0, 90.0), std::pair(180.0, 90.0)}) {
    EXPECT_NEAR(degrees(profile.speed_rad_per_s(radians(angle_deg))), speed, 1e-12 * speed);
  }
}

TEST(ElementaryRotation, NeverTurnsPastAlignment) {
  Random random(3501);
  for (const StepRule rule : {StepRule::kExact, StepRule::kSpeedByDt}) {
    for (int i = 0; i < 10000; ++i) {
      const double angle_rad = std::pow(10.0, random.uniform(-20.0, 0.5));
      const double dt_s = std::pow(10.0, random.uniform(-9.0, 3.0));
      const double turned_rad = step_rad(angle_rad, dt_s, rule);
      ASSERT_GT(turned_rad, 0.0);
      ASSERT_LE(turned_rad, angle_rad);
    }
    EXPECT_EQ(step_rad(0.0, 1.0, rule), 0.0);
    EXPECT_EQ(step_rad(radians(20.0), 0.0, rule), 0.0);
    EXPECT_EQ(step_rad(radians(20.0), 1e6, rule), radians(20.0));
  }
}

// With any profile, a tick turns at least at the slower and at most at the faster of its two
// speeds.
TEST(ElementaryRotation, StaysBetweenTheSpeedsOfAnyProfile) {
  constexpr double kRoundoff = 64 * kEpsilon;
  Random random(3507);
  const auto power = [&](double low, double high) {
    return std::pow(10.0, random.uniform(low, high));
  };
  for (int i = 0; i < 100000; ++i) {
    const double decades = random.index(2) == 0 ? 3.0 : 150.0;
    const RotationProfile profile{power(-decades, decades), power(-decades, decades),
                                  power(-decades, 1.0)};
    const double angle_rad = random.index(4) == 0 ? profile.knee_rad : power(-decades, 0.5);
    const double dt_s = power(-9.0, 0.0);
    const auto [slower, faster] =
        std::minmax({profile.speed_at_zero_rad_per_s, profile.speed_at_knee_rad_per_s});
    for (const StepRule rule : {StepRule::kExact, StepRule::kSpeedByDt}) {
      const double turned_rad = elementary_rotation_rad(profile, rule, angle_rad, dt_s);
      ASSERT_LE(turned_rad, std::min(angle_rad, (1.0 + kRoundoff) * faster * dt_s));
      ASSERT_GE(turned_rad, std::min(angle_rad, (1.0 - kRoundoff) * slower * dt_s));
    }
  }
}

TEST(ElementaryRotation, SpeedByDtIsThePapersProduct) {
  Random random(3502);
  const RotationProfile profile;
  for (int i = 0; i < 1000; ++i) {
    const double angle_rad = random.uniform(0.02, std::numbers::pi);
    EXPECT_EQ(step_rad(angle_rad, 1e-3, StepRule::kSpeedByDt),
              profile.speed_rad_per_s(angle_rad) * 1e-3);
  }
}

TEST(ElementaryRotation, ExactStepsTakeTheTimeOfTheClosedForm) {
  Random random(3503);
  for (int i = 0; i < 10000; ++i) {
    const double from_rad = random.uniform(0.0, std::numbers::pi);
    const double dt_s = std::pow(10.0, random.uniform(-6.0, 0.0));
    const double left_rad = from_rad - step_rad(from_rad, dt_s);
    const double time_s = closed_form_s(degrees(from_rad), degrees(left_rad));
    // The rounding of angles up to pi, divided by the slowest speed.
    const double rounding_s =
        4 * std::numbers::pi * kEpsilon / RotationProfile{}.speed_at_zero_rad_per_s;
    ASSERT_LE(time_s, dt_s + rounding_s);
    if (left_rad > 0.0) {
      ASSERT_GE(time_s, dt_s - rounding_s);
    }
  }
}

TEST(ElementaryRotation, AStepEqualsItsTwoHalvesTogether) {
  Random random(3504);
  for (int i = 0; i < 10000; ++i) {
    // Profiles include those that slow down towards the knee and flat ones.
    RotationProfile profile;
    profile.speed_at_zero_rad_per_s = random.uniform(0.01, 2.0);
    profile.speed_at_knee_rad_per_s =
        random.index(4) == 0 ? profile.speed_at_zero_rad_per_s : random.uniform(0.01, 2.0);
    profile.knee_rad = random.uniform(0.3, 1.5);
    const double angle_rad = random.uniform(0.0, std::numbers::pi);
    const double first_s = random.uniform(0.0, 0.5);
    const double second_s = random.uniform(0.0, 0.5);
    const auto turn = [&profile](double angle, double dt_s) {
      return elementary_rotation_rad(profile, StepRule::kExact, angle, dt_s);
    };
    const double first = turn(angle_rad, first_s);
    const double cut = first + turn(angle_rad - first, second_s);
    // If the speed rises while the angle falls, rounding errors grow with it.
    const double slope =
        (profile.speed_at_knee_rad_per_s - profile.speed_at_zero_rad_per_s) / profile.knee_rad;
    const double magnified = std::exp(std::max(0.0, -slope) * (first_s + second_s));
    ASSERT_NEAR(cut, turn(angle_rad, first_s + second_s), 64 * kEpsilon * magnified);
  }
}

TEST(ElementaryRotation, RatesAgreeAtTheTimesTheyShare) {
  for (const double from_deg : {90.0, 60.0, 30.0, 10.0}) {
    double at_60_hz_rad = radians(from_deg);
    double at_1_khz_rad = radians(from_deg);
    while (at_60_hz_rad > 0.0) {  // every 50 ms
      for (int i = 0; i < 3; ++i) at_60_hz_rad -= step_rad(at_60_hz_rad, 1.0 / 60.0);
      for (int i = 0; i < 50; ++i) at_1_khz_rad -= step_rad(at_1_khz_rad, 1e-3);
      ASSERT_NEAR(at_60_hz_rad, at_1_khz_rad, 1e-12);
    }
  }
}

// The time from 90 deg to to_deg by steps S dt: whole ticks, and a fraction of the last tick by its
// speed.
double speed_by_dt_s(double to_deg, double dt_s) {
  double angle_rad = radians(90.0);
  for (int ticks = 0;; ++ticks) {
    const double turned_rad = step_rad(angle_rad, dt_s, StepRule::kSpeedByDt);
    const double left_rad = angle_rad - radians(to_deg);
    if (turned_rad >= left_rad) {
      return ticks * dt_s + left_rad / RotationProfile{}.speed_rad_per_s(angle_rad);
    }
    angle_rad -= turned_rad;
  }
}

TEST(ElementaryRotation, SpeedByDtIsEarly) {
  const double exact_s = closed_form_s(90.0, 1.0);
  EXPECT_NEAR(exact_s - speed_by_dt_s(1.0, 1e-3), 1.22e-3, 0.005e-3);
  EXPECT_NEAR(exact_s - speed_by_dt_s(1.0, 1.0 / 60.0), 20e-3, 0.5e-3);
}

// Actions 5 and 6 of A4 for a contact normal that is fixed in the scene.
class AligningScene {
 public:
  AligningScene(const ActuationModel& model, const Vec3& normal_device, Random& random)
      : rotation_(model, Table1Form::kCorrected) {
    const Quat start(Eigen::AngleAxisd(random.uniform(0.0, 2.0 * std::numbers::pi), Vec3::UnitZ()));
    pose_ = {model.is_planar() ? start : random.rotation(), random.in_box(0.1)};
    normal_scene_ = pose_.inverse_direction(normal_device);
    pivot_scene_m_ = random.in_box(0.1);
  }

  // The direction with which the earlier normals were aligned.
  void remember(const Vec3& normal_device) { rotation_.update(normal_device); }

  AxisAngle theoretical() { return rotation_.update(pose_.direction(normal_scene_)); }
  void turn(const AxisAngle& elementary) {
    pose_ = turned_about(pose_, pivot_scene_m_, elementary);
  }

 private:
  TheoreticalRotation rotation_;
  ScenePose pose_;
  Vec3 normal_scene_;
  Vec3 pivot_scene_m_;
};

// The seconds until the normal is to_deg away from the direction of alignment: whole ticks, and the
// closed form for the rest of the last tick.
double time_to_align_s(AligningScene& scene, double to_deg, double rate_Hz) {
  const double dt_s = 1.0 / rate_Hz;
  for (int ticks = 0; ticks < 100000; ++ticks) {
    AxisAngle turn = scene.theoretical();
    const double angle_rad = turn.angle_rad;
    turn.angle_rad = step_rad(angle_rad, dt_s);
    if (angle_rad - turn.angle_rad <= radians(to_deg)) {
      const double rest_s = closed_form_s(degrees(angle_rad), to_deg);
      EXPECT_LE(rest_s, dt_s * (1.0 + 1e-9)) << "the last tick turned farther than its time allows";
      return ticks / rate_Hz + rest_s;
    }
    scene.turn(turn);
  }
  ADD_FAILURE() << "never aligned";
  return 0.0;
}

struct AlignmentTime {
  double from_deg;
  double to_1_deg_s;
  double to_0_s;
};
constexpr std::array<AlignmentTime, 4> kAlignmentTimes = {{
    {90.0, 1.528345, 1.686798},
    {60.0, 1.195012, 1.353465},
    {30.0, 0.861678, 1.020131},
    {10.0, 0.511119, 0.669572},
}};
constexpr double kPrintedDigits_s = 0.5e-6;
constexpr double kAlignmentAccuracy_s = 1e-9;

TEST(AlignmentTime, ClosedFormGivesThePrintedTimes) {
  for (const AlignmentTime& time : kAlignmentTimes) {
    EXPECT_NEAR(closed_form_s(time.from_deg, 1.0), time.to_1_deg_s, kPrintedDigits_s);
    EXPECT_NEAR(closed_form_s(time.from_deg, 0.0), time.to_0_s, kPrintedDigits_s);
  }
}

struct Setting {
  int sensors;
  int actuators;
};

class AlignmentAtRate : public testing::TestWithParam<std::tuple<Setting, double>> {};

// Covers both senses of rotation and both signs of the direction of alignment.
TEST_P(AlignmentAtRate, TakesTheTimeOfFigure3) {
  const auto& [setting, rate_Hz] = GetParam();
  const ActuationModel model = *ActuationModel::from_counts(setting.sensors, setting.actuators);
  Random random(3505);
  double worst_s = 0.0;
  for (const AlignmentTime& time : kAlignmentTimes) {
    for (const double side : {1.0, -1.0}) {
      for (const double sign : {1.0, -1.0}) {
        for (const double to_deg : {1.0, 0.0}) {
          const double angle_rad = radians(time.from_deg);
          Vec3 normal = sign * std::cos(angle_rad) * Vec3::UnitX();
          normal[setting.actuators] = side * std::sin(angle_rad);
          AligningScene scene(model, normal, random);
          scene.remember(sign * Vec3::UnitX());
          const double error_s =
              time_to_align_s(scene, to_deg, rate_Hz) - closed_form_s(time.from_deg, to_deg);
          worst_s = std::max(worst_s, std::abs(error_s));
        }
      }
    }
  }
  EXPECT_LE(worst_s, kAlignmentAccuracy_s);
}

std::string row_name(const testing::TestParamInfo<std::tuple<Setting, double>>& row) {
  const auto& [setting, rate_Hz] = row.param;
  return std::to_string(setting.sensors) + "Sensors" + std::to_string(setting.actuators) +
         "Actuators" + std::to_string(static_cast<int>(rate_Hz)) + "Hz";
}

INSTANTIATE_TEST_SUITE_P(Rows, AlignmentAtRate,
                         testing::Combine(testing::Values(Setting{2, 1}, Setting{3, 1},
                                                          Setting{3, 2}),
                                          testing::ValuesIn(kRates_Hz)),
                         row_name);

}  // namespace
}  // namespace palpate
