// The knobs of effects, against closed forms: the error of the interpolant of texels, and the force
// that each effect adds.

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/effect_cases.h"
#include "engine/accuracy/knobs.h"
#include "engine/accuracy/measurement.h"
#include "engine/accuracy/session_pass.h"
#include "engine/accuracy/sine_relief.h"
#include "engine/accuracy/sphere_paths.h"
#include "haptics/record_vectors.h"
#include "tests/engine/accuracy/measured_knobs.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::kEffort;
using test::Random;

KnobResult measured_effect(const std::string& name) {
  return test::measured(effect_knobs(kEffort), name);
}

void expect_levels_and_presets_count(const KnobResult& result) {
  for (const MethodResult& m : result.methods) {
    for (const LevelResult& level : m.levels) {
      EXPECT_TRUE(level.counts()) << m.name << ", " << level.label << ": " << level.failure;
      EXPECT_GT(level.time.low, 0.0) << m.name << ", " << level.label;
    }
  }
  for (const LevelResult& preset : result.presets) EXPECT_TRUE(preset.counts()) << preset.failure;
}

TEST(EffectKnobs, AreComplete) {
  const std::vector<Knob> knobs = effect_knobs(kEffort);
  ASSERT_EQ(knobs.size(), 3u);
  for (const Knob& knob : knobs) {
    for (const std::string* text : {&knob.name, &knob.title, &knob.level.name, &knob.error.name,
                                    &knob.time.name, &knob.workload, &knob.reference,
                                    &knob.floor_is, &knob.enough_because, &knob.default_because}) {
      EXPECT_FALSE(text->empty()) << knob.name;
    }
    EXPECT_GT(knob.enough, 0.0) << knob.name;
    ASSERT_LT(knob.default_method, knob.methods.size());
    ASSERT_LT(knob.default_level, knob.methods[knob.default_method].levels.size());
    for (const Method& m : knob.methods) EXPECT_GT(m.floor, 0.0) << m.name;
  }
}

// ---- texels ------------------------------------------------------------------------------------

// The rms error over a wave of the Catmull-Rom spline through n points per wave of sin(x), over the
// height from the lowest to the highest point. Computed for exp(i x), whose error is the same at
// all phases.
double spline_error(int n) {
  using Wave = std::complex<double>;
  const double angle = 2.0 * std::numbers::pi / n;
  const auto wave = [&](double at) { return std::polar(1.0, angle * at); };
  constexpr int kPlaces = 1000;  // the mean over them of a smooth, nearly periodic error
  double sum = 0.0;
  for (int place = 0; place < kPlaces; ++place) {
    const double t = (place + 0.5) / kPlaces;
    // Hermite's cubic, its slopes by central differences.
    const Wave from = wave(0.0);
    const Wave to = wave(1.0);
    const Wave slope_from = 0.5 * (wave(1.0) - wave(-1.0));
    const Wave slope_to = 0.5 * (wave(2.0) - wave(0.0));
    const Wave between = (2 * t * t * t - 3 * t * t + 1) * from +
                         (t * t * t - 2 * t * t + t) * slope_from +
                         (3 * t * t - 2 * t * t * t) * to + (t * t * t - t * t) * slope_to;
    sum += std::norm(between - wave(t));
  }
  const double amplitude_rms = std::sqrt(sum / kPlaces / 2.0);
  return 0.5 * amplitude_rms;
}

// Uniformly distributed rounding has an rms of 1 / sqrt(12) of a step; the weights of the spline
// reduce it by sqrt(0.814).
double rounding_error(ImageDepth depth) {
  return 2.0 * image_floor(depth) * std::sqrt(0.814 / 12.0);
}

TEST(TextureSampling, HasTheErrorOfTheSplineThroughTheTexels) {
  const KnobResult result = measured_effect("texture_sampling");
  expect_levels_and_presets_count(result);
  for (const auto& [name, depth] :
       {std::pair("16 bits", ImageDepth::k16Bit), {"8 bits", ImageDepth::k8Bit}}) {
    const MethodResult& m = test::method_of(result, name);
    ASSERT_EQ(m.levels.size(), 6u);
    for (const LevelResult& level : m.levels) {
      const int texels = std::stoi(level.label);
      EXPECT_DOUBLE_EQ(level.value, SineRelief{}.wave_m / texels);
      const double theory = std::hypot(spline_error(texels), rounding_error(depth));
      // Rounding scatters where texels are few, and where a wave's texels repeat.
      const double scatter = 0.15 * rounding_error(depth) / theory;
      EXPECT_NEAR(level.raw_error / theory, 1.0, 0.002 + scatter) << name << ", " << level.label;
      EXPECT_EQ(level.at_floor, level.raw_error <= image_floor(depth)) << level.label;
    }
  }
}

// Third order in theory; with few texels a wave the fourth is as large.
TEST(TextureSampling, IsOfThirdOrderWhereTexelsAreMany) {
  EXPECT_NEAR(std::log2(spline_error(256) / spline_error(512)), 3.0, 0.01);
  const KnobResult result = measured_effect("texture_sampling");
  const MethodResult& m = test::method_of(result, "16 bits");
  ASSERT_TRUE(m.order.has_value());
  double last = 10.0;
  for (std::size_t l = 1; l < 4; ++l) {
    const double order = std::log2(m.levels[l - 1].raw_error / m.levels[l].raw_error);
    EXPECT_GT(order, 3.0) << m.levels[l].label;
    EXPECT_LT(order, last) << m.levels[l].label;
    last = order;
  }
  EXPECT_LT(last, 3.15);
}

TEST(TextureSampling, IsTheSameUnderEveryPreset) {
  const KnobResult result = measured_effect("texture_sampling");
  const LevelResult& usual = result.methods[0].levels[result.knob.default_level];
  for (const LevelResult& preset : result.presets) {
    EXPECT_NEAR(preset.raw_error, usual.raw_error, 1e-3 * usual.raw_error);
  }
}

// ---- effects -----------------------------------------------------------------------------------

constexpr double kRadius_m = 0.1;
constexpr double kSpeed_m_per_s = kSpherePathSpeed_m_per_s;

TEST(Effects, AddTheForceOfTheirModel) {
  const KnobResult result = measured_effect("effects");
  expect_levels_and_presets_count(result);
  ASSERT_EQ(result.methods.size(), measured_effects().size() + 2);
  for (const std::string_view effect : measured_effects()) {
    const std::string name = "all but " + std::string(effect);
    const MethodResult& left_out = test::method_of(result, name);
    for (const LevelResult& level : left_out.levels) {
      EXPECT_FALSE(level.at_floor) << left_out.name << ", " << level.label;
    }
  }
  const auto missing_N = [&](const std::string& effect) {
    return test::method_of(result, "all but " + effect).levels.back().error.median;
  };
  EXPECT_NEAR(missing_N("magnet"), 1.0, 1e-3);
  EXPECT_NEAR(missing_N("gravity"), 0.05 * 9.81, 1e-4);
  EXPECT_NEAR(missing_N("viscosity"), 2.0 * kSpeed_m_per_s, 1e-3 * 2.0 * kSpeed_m_per_s);
  EXPECT_NEAR(missing_N("vibration"), 0.3 / std::numbers::sqrt2, 0.02);
}

TEST(Effects, LackNoForceIfAllAreSimulatedAndMostIfNoneIs) {
  const KnobResult result = measured_effect("effects");
  const MethodResult& all = test::method_of(result, "all");
  const MethodResult& none = result.methods.back();
  for (std::size_t l = 0; l < all.levels.size(); ++l) {
    EXPECT_EQ(all.levels[l].raw_error, 0.0);
    for (const MethodResult& m : result.methods) {
      EXPECT_LE(m.levels[l].error.median, none.levels[l].error.median) << m.name;
    }
  }
  EXPECT_EQ(result.knob.methods[result.knob.default_method].name, "all");
  EXPECT_TRUE(result.methods[result.knob.default_method].levels[result.knob.default_level].on_front)
      << "no other method lacks no force";
}

TEST(Effects, AloneChangeTheForceByTheirModel) {
  const KnobResult result = measured_effect("effect_costs");
  expect_levels_and_presets_count(result);
  ASSERT_EQ(result.methods.size(), measured_effects().size() + 1);
  const auto changed_N = [&](const std::string& effect) {
    return test::method_of(result, effect).levels.back().error.median;
  };
  for (const MethodResult& m : result.methods) EXPECT_FALSE(m.levels.back().at_floor) << m.name;
  EXPECT_NEAR(changed_N("magnet"), 1.0, 1e-3);
  EXPECT_NEAR(changed_N("gravity"), 0.05 * 9.81, 1e-4);
  EXPECT_NEAR(changed_N("viscosity"), 2.0 * kSpeed_m_per_s, 1e-3 * 2.0 * kSpeed_m_per_s);
  EXPECT_NEAR(changed_N("vibration"), 0.3 / std::numbers::sqrt2, 0.02);
}

std::vector<Vec3> forces_N(const Scene& scene, const std::vector<Vec3>& path_m) {
  std::vector<Vec3> forces;
  run_path(scene.world(), PassSetup::fully_actuated({1000.0, 2.0}), path_m, kSpherePathPeriod_s, 0,
           [&](const TickRecord& record) { forces.push_back(vec3(record.force_device_N)); });
  return forces;
}

TEST(Effects, OfASurfaceThatIsNotTouchedChangeNoBit) {
  Random random(7103);
  const auto with = effect_scene(3, kRadius_m, effects_elsewhere());
  const auto without = effect_scene(3, kRadius_m, without_effects(effects_elsewhere()));
  ASSERT_TRUE(with && without);
  for (int run = 0; run < 5; ++run) {
    const Quat turn = random.rotation();
    std::vector<Vec3> path_m = path_over_sphere(kRadius_m, {-3e-3, 1e-3, 0.25}, 1000);
    for (Vec3& p_m : path_m) p_m = turn * p_m;
    const std::vector<Vec3> rendered = forces_N(*with, path_m);
    EXPECT_GT(rendered.size(), 500u);
    EXPECT_EQ(rendered, forces_N(*without, path_m));
  }
}

TEST(Effects, OfACaseAreTheEffectsNamed) {
  EXPECT_EQ(all_effects().effects.size(), measured_effects().size());
  for (const std::string_view effect : measured_effects()) {
    EXPECT_TRUE(only(effect).has(effect));
    EXPECT_FALSE(all_but(effect).has(effect));
    EXPECT_EQ(all_but(effect).effects.size(), measured_effects().size() - 1);
    EXPECT_TRUE(without_effects(only(effect)).effects.empty());
  }
}

}  // namespace
}  // namespace palpate
