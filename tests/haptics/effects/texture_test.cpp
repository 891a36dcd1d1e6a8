// Compares relief from height maps with sines in closed form, and bounds its energy around loops.

#include "haptics/effects/texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptics/proxy/body_hand.h"
#include "tests/helpers/ticks.h"

namespace palpate {
namespace {

using test::BodyHand;
using test::effect_entry;
using test::hand_settings;
using test::kStiffness_N_per_m;
using test::kTick_s;
using test::Random;
using test::square_soup;

constexpr double kTexturedHalf_m = 0.1;

// value = 1/2 + 1/2 sin(2 pi waves u + phase); constant along v.
HeightMap sine_map(std::uint32_t texels, int waves, double phase = 0.0) {
  std::vector<float> values(std::size_t{texels} * texels);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double u = (static_cast<double>(i % texels) + 0.5) / texels;
    values[i] = static_cast<float>(0.5 + 0.5 * std::sin(2 * std::numbers::pi * waves * u + phase));
  }
  return HeightMap::build(texels, texels, std::move(values), MapWrap::kRepeat, MapWrap::kRepeat);
}

// A square whose map is `period_m` wide: u = x / period, v = y / period.
class TexturedPlane {
 public:
  TexturedPlane(HeightMap map, double height_m, double period_m, const RigidTransform& pose,
                std::vector<EffectProgramBuilder::Entry> others = {})
      : hand({square_soup(kTexturedHalf_m)}, pose), height_m_(height_m), period_m_(period_m) {
    EffectProgram& program = hand.effects.builder.program;
    program.maps.push_back(std::move(map));
    map_ = &program.maps.back();
    SurfaceAttributes attributes;
    test::for_each_slot(hand.index(), [&](std::uint32_t slot) {
      const TriangleGeometry& t = hand.index().triangle(slot);
      CornerCoordinates corners;
      const Vec3* points[] = {&t.a, &t.b, &t.c};
      for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = {points[i]->x() / period_m, points[i]->y() / period_m};
      }
      attributes.texture_uv.push_back(UvMap::over(t, corners));
    });
    others.push_back(effect_entry<TextureEffect>({height_m, map_}));
    hand.effects.add_body(others, std::move(attributes));
  }

  // The map at a place, without blending: height, and slope along x and y.
  Vec3 relief(const Vec3& p) const {
    const auto sample = map_->sample(p.x() / period_m_, p.y() / period_m_, 0.0);
    return {height_m_ * (sample.value - 1.0), height_m_ / period_m_ * sample.d_du,
            height_m_ / period_m_ * sample.d_dv};
  }

  BodyHand hand;

 private:
  double height_m_;
  double period_m_;
  const HeightMap* map_;
};

// Keys' interpolant with n texels per wave has an error of (2 pi / n)^3 / 62 of the amplitude; its
// slope has an error of (2 pi / n)^2 / 6 of the steepest slope (height_map.h). Both hold to first
// order: 5 % more allows for the next.
TEST(Texture, RendersTheSineOfTheMap) {
  Random random(6701);
  constexpr int kTexels = 256;
  constexpr int kWaves = 16;
  constexpr double kPeriod_m = 0.08;
  constexpr double kHeight_m = 3e-4;
  constexpr double kPerWave = static_cast<double>(kTexels) / kWaves;
  const double angle = 2 * std::numbers::pi / kPerWave;
  const double steepest = std::numbers::pi * kHeight_m * kWaves / kPeriod_m;
  const double height_error_m = 1.05 * angle * angle * angle / 62 * 0.5 * kHeight_m;
  const double slope_error = 1.05 * angle * angle / 6 * steepest;
  double worst_height = 0.0;
  double worst_slope = 0.0;
  for (int run = 0; run < 10; ++run) {
    const double phase = random.uniform(0.0, 2 * std::numbers::pi);
    TexturedPlane plane(sine_map(kTexels, kWaves, phase), kHeight_m, kPeriod_m, random.pose(0.3));
    plane.hand.begin(hand_settings());
    const double heading = random.uniform(0.0, 2 * std::numbers::pi);
    // 0.03 m/s is a tenth of a texel per tick: no wave is blended out.
    const Vec3 step = 3e-5 * Vec3(std::cos(heading), std::sin(heading), 0);
    Vec3 goal(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 1e-4);
    plane.hand.go_to(goal);
    for (int tick = 0; tick < 2000; ++tick) {
      goal += step;
      const double depth = 2e-4 + 2e-4 * std::sin(0.01 * tick);  // sometimes off contact
      goal.z() = -depth;
      plane.hand.go_to(goal);
      const double x = 2 * std::numbers::pi * kWaves * goal.x() / kPeriod_m + phase;
      const double height = 0.5 * kHeight_m * (std::sin(x) - 1.0);
      const double slope = steepest * std::cos(x);
      const double deep = std::max(0.0, depth + height);
      const Vec3 force = plane.hand.force();
      const double tolerance =
          kStiffness_N_per_m * height_error_m + 1e-5 * kStiffness_N_per_m * kHeight_m;
      ASSERT_NEAR(force.z(), kStiffness_N_per_m * deep, tolerance) << tick;
      ASSERT_NEAR(force.x(), -kStiffness_N_per_m * deep * slope,
                  kStiffness_N_per_m * deep * slope_error + tolerance * steepest)
          << tick;
      ASSERT_NEAR(force.y(), 0.0, 1e-6 * kStiffness_N_per_m * kHeight_m);
      worst_height =
          std::max(worst_height, std::abs(force.z() / kStiffness_N_per_m - deep) / kHeight_m);
      if (deep > 0.1 * kHeight_m) {
        worst_slope = std::max(
            worst_slope, std::abs(force.x() / (kStiffness_N_per_m * deep) + slope) / steepest);
      }
    }
  }
  std::printf(
      "worst height %.2e of the texture's (allowed %.2e), slope %.2e of the steepest "
      "(allowed %.2e)\n",
      worst_height, height_error_m / kHeight_m, worst_slope, slope_error / steepest);
}

TEST(Texture, BeginsSoftlyAtTheSurfaceOfTheMesh) {
  Random random(6702);
  constexpr double kPeriod_m = 0.08;
  constexpr double kHeight_m = 3e-4;
  const double steepest = std::numbers::pi * kHeight_m * 16 / kPeriod_m;
  for (int run = 0; run < 40; ++run) {
    TexturedPlane plane(sine_map(256, 16), kHeight_m, kPeriod_m, random.pose(0.3));
    plane.hand.begin(hand_settings());
    const Vec3 place(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), 0);
    constexpr double kStep_m = 1e-6;
    Vec3 last = Vec3::Zero();
    for (double z = 1e-5; z > -2 * kHeight_m; z -= kStep_m) {
      plane.hand.go_to(place + Vec3(0, 0, z));
      const Vec3 force = plane.hand.force();
      ASSERT_LE((force - last).norm(), 1.05 * kStiffness_N_per_m * kStep_m * (1 + steepest) + 1e-8)
          << z;
      last = force;
    }
    EXPECT_GT(last.z(), 0.0);
  }
}

TEST(Texture, KeepsTheRatioOfFriction) {
  Random random(6703);
  constexpr double kPeriod_m = 0.08;
  for (int run = 0; run < 20; ++run) {
    const double mu = random.uniform(0.1, 1.0);
    TexturedPlane plane(sine_map(256, 16), 3e-4, kPeriod_m, random.pose(0.3),
                        {effect_entry<FrictionEffect>({mu, mu, nullptr})});
    plane.hand.begin(hand_settings());
    Vec3 goal(-0.05, 0.01, 1e-4);
    plane.hand.go_to(goal);
    int slides = 0;
    for (int tick = 0; tick < 1500; ++tick) {
      goal += Vec3(3e-5, 1e-5, 0);
      goal.z() = -5e-4 - 3e-4 * std::sin(0.01 * tick);
      plane.hand.go_to(goal);
      const Vec3 force = plane.hand.force();
      const Vec3 relief = plane.relief(plane.hand.proxy());
      const double press = force.z();
      const double deep = std::max(0.0, -goal.z() + relief.x());
      ASSERT_NEAR(press, kStiffness_N_per_m * deep, 1e-7);
      const Vec3 side(force.x() + press * relief.y(), force.y() + press * relief.z(), 0);
      if (tick < 100) continue;
      ASSERT_NEAR(side.norm(), mu * press, 1e-7) << tick;
      const Vec3 lag = plane.hand.proxy() - goal;
      ASSERT_GE(side.dot(lag), 0.0);
      slides += press > 0.0;
    }
    EXPECT_GT(slides, 1000);
  }
}

// ---- loops -------------------------------------------------------------------------------------

// The mean force that drives the hand along a straight path of equal steps: the work on the hand
// divided by the path's length. The force is held for a tick, as by a device.
struct Drive {
  double rendered_N = 0.0;
  double unblended_N = 0.0;  // as if the map itself were rendered at any speed
  double press_N = 0.0;      // mean pressing force
};

Drive drive_along(TexturedPlane& plane, const Vec3& start, const Vec3& step, int steps) {
  Drive drive;
  plane.hand.go_to({start.x(), start.y(), 1e-3});
  plane.hand.go_to(start - step);
  for (int k = 0; k < steps; ++k) {
    const Vec3 x = start + k * step;
    plane.hand.go_to(x);
    drive.rendered_N += plane.hand.force().dot(step.normalized());
    drive.press_N += plane.hand.force().z();
    const Vec3 relief = plane.relief(x);
    const double depth_m = std::max(0.0, -x.z() + relief.x());
    drive.unblended_N -=
        kStiffness_N_per_m * depth_m * Vec3(relief.y(), relief.z(), 0).dot(step.normalized());
  }
  drive.rendered_N /= steps;
  drive.unblended_N /= steps;
  drive.press_N /= steps;
  return drive;
}

// Over whole periods of the map, a relief returns the energy that it took. Any remainder is caused
// by sampling and lasts as long as the motion. If a step is as long as a wave, every tick meets the
// same flank: without blending, the relief drags or drives the hand by K (d + h) pi h / l, which is
// more than the pressing force. With blending, the remainder comes from the interpolated texels of
// coarse levels: Keys' kernel lets a small part of a wave pass, which the steps alias. The
// remainder must be far less than the friction of any slippery material.
TEST(Texture, DoesNotDriveTheHandByAliasing) {
  Random random(6704);
  constexpr double kPeriod_m = 0.0512;
  constexpr double kHeight_m = 3e-4;
  constexpr double kStep_m = 0.5 * kTick_s;  // at 0.5 m/s
  constexpr double kSlippery = 1e-3;         // fraction of the pressing force
  double worst_rendered = 0.0;
  double worst_unblended = 0.0;
  for (const int waves :
       {10, 13, 17, 21, 26, 34, 41, 51, 57, 64, 73, 80, 85, 93, 99, 102, 104, 114, 128, 146, 170}) {
    const double wave_m = kPeriod_m / waves;
    TexturedPlane plane(sine_map(512, waves), kHeight_m, kPeriod_m, random.pose(0.3));
    plane.hand.begin(hand_settings());
    double rendered = 0.0;
    double unblended = 0.0;
    double work_J = 0.0;
    for (int run = 0; run < 200; ++run) {
      const double heading = random.index(2) ? 0.0 : random.uniform(-0.7, 0.7);
      // About the step kStep_m, such that a whole number of steps makes whole periods.
      const double length_m = static_cast<double>(1 + random.index(3)) * kPeriod_m;
      const int steps = static_cast<int>(std::lround(length_m / (kStep_m * std::cos(heading))));
      const double side_m = length_m / steps;
      const double sense = random.index(2) ? 1.0 : -1.0;
      const Vec3 step = sense * side_m * Vec3(1, std::tan(heading), 0);
      const Vec3 start(-sense * random.uniform(0.06, 0.09),
                       -sense * std::copysign(random.uniform(0.06, 0.09), heading),
                       -random.uniform(1.0, 3.0) * kHeight_m);
      const Drive drive = drive_along(plane, start, step, steps);
      rendered = std::max(rendered, std::abs(drive.rendered_N) / drive.press_N);
      unblended = std::max(unblended, std::abs(drive.unblended_N) / drive.press_N);
      work_J = std::max(work_J, drive.rendered_N * wave_m / std::cos(heading));
    }
    EXPECT_LE(rendered, kSlippery) << wave_m;
    worst_rendered = std::max(worst_rendered, rendered);
    worst_unblended = std::max(worst_unblended, unblended);
    std::printf(
        "waves of %.2f mm: drive of %.1e of the press at most (%.1e K h^2 a wave), "
        "unblended %.1e\n",
        1e3 * wave_m, rendered, work_J / (kStiffness_N_per_m * kHeight_m * kHeight_m), unblended);
  }
  EXPECT_GT(worst_unblended, 1.0);
  EXPECT_GT(worst_unblended, 100 * worst_rendered);
}

// Waves that the ticks can carry at the hand's speed are not blended out: ten ticks or more per
// wave.
TEST(Texture, IsRenderedWhereTheTicksCanCarryIt) {
  constexpr double kPeriod_m = 0.0512;
  constexpr double kHeight_m = 3e-4;
  constexpr double kStep_m = 1e-4;  // at 0.1 m/s
  for (const auto& [waves, least] : {std::pair(10, 0.97), {25, 0.9}, {50, 0.75}}) {
    TexturedPlane plane(sine_map(512, waves), kHeight_m, kPeriod_m, {});
    plane.hand.begin(hand_settings());
    plane.hand.go_to({-0.08, 0.01, 1e-3});
    double low = 1e9;
    double high = 0.0;
    for (int k = 0; k < 1500; ++k) {
      plane.hand.go_to({-0.08 + k * kStep_m, 0.01, -2 * kHeight_m});
      if (k < 10) continue;
      low = std::min(low, plane.hand.force().z());
      high = std::max(high, plane.hand.force().z());
    }
    const double part = (high - low) / (kStiffness_N_per_m * kHeight_m);
    std::printf("%d ticks a wave: %.3f of the height\n",
                static_cast<int>(kPeriod_m / waves / kStep_m), part);
    EXPECT_GT(part, least);
  }
}

}  // namespace
}  // namespace palpate
