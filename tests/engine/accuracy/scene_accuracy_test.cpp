// The results for a user's own scene.

#include "engine/accuracy/scene_accuracy.h"

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/built_scene.h"
#include "engine/accuracy/measurement.h"
#include "engine/accuracy/scene_findings.h"
#include "engine/accuracy/sine_relief.h"
#include "engine/accuracy/surface_couplings.h"
#include "models/primitives.h"

namespace palpate {
namespace {

MeasurementEffort scene_effort() {
  MeasurementEffort effort;
  effort.quick = true;
  effort.seed = 3;
  return effort;
}

RunSetup setup() {
  RunSettings options;
  options.haptics.coupling.stiffness_N_per_m = 500.0;
  return *make_setup(options);
}

Scene loaded(const std::string& model) {
  Result<Scene> scene = Scene::load(std::string(PALPATE_MODELS_DIR) + "/" + model);
  EXPECT_TRUE(scene.ok());
  return std::move(*scene);
}

TEST(SceneAccuracy, ReportsTimesErrorsAndTheRateOfAScene) {
  const auto scene = mesh_scene(bumpy_sphere(5, 0.1, 3e-3, 7));
  const auto measured = measure_scene(*scene, setup(), scene_effort(), nullptr);
  ASSERT_TRUE(measured.ok()) << measured.error().to_string();
  EXPECT_GT(measured->contact_share, 0.3);
  EXPECT_GE(measured->repeats, 20);
  for (const PresetOnScene& preset : measured->presets) {
    EXPECT_GT(preset.ticks, 1000u) << preset.name;
    EXPECT_GT(preset.p50_ns.median, 0.0);
    EXPECT_LE(preset.p50_ns.median, preset.p99_ns.median);
    EXPECT_LE(preset.p99_ns.median, preset.worst_ns.median);
    EXPECT_LE(preset.rms_error_m, preset.worst_error_m);
    EXPECT_GE(preset.iterations, 1.0);
  }
  EXPECT_EQ(measured->presets[2].worst_error_m, 0.0) << "exact against itself";
  EXPECT_LT(measured->presets[1].worst_error_m, measured->floor_m);
  const KeptRate& kept = measured->kept_rate;
  ASSERT_FALSE(kept.trials.empty());
  // The test does not depend on the rates kept: a busy machine may keep only the slowest.
  for (std::size_t i = 0; i < kept.trials.size(); ++i) {
    EXPECT_EQ(kept.trials[i].passed(), kept.trials[i].rate_Hz <= kept.by_trial_Hz);
    if (i > 0) {
      EXPECT_LT(kept.trials[i - 1].rate_Hz, kept.trials[i].rate_Hz);
    }
  }
  EXPECT_LE(kept.rate_Hz(), kept.by_trial_Hz);
  EXPECT_LE(kept.rate_Hz(), kept.by_computing_Hz);
}

TEST(SceneAccuracy, FindsTheErrorOfFewerTriangles) {
  const auto scene = mesh_scene(icosphere(5, 0.1));
  std::string why;
  const auto knob = simplification_knob(*scene, setup(), scene_effort(), why);
  ASSERT_TRUE(knob.has_value()) << why;
  ASSERT_GE(knob->methods[0].levels.size(), 4u);
  const KnobResult result = measure(*knob, scene_effort(), nullptr);
  const auto& levels = result.methods[0].levels;
  EXPECT_TRUE(levels.back().at_floor) << "all triangles";
  for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
    // A coarser mesh of a sphere lies deeper, by at most h^2 / (6 R), and proxies differ
    // tangentially.
    EXPECT_GT(levels[l].value, levels[l + 1].value);
    EXPECT_GT(levels[l].error.median, levels[l + 1].error.median) << levels[l].label;
    EXPECT_EQ(levels[l].failures, 0) << levels[l].failure;
  }
}

TEST(SceneAccuracy, StatesWhyAMeshIsNotSimplified) {
  const auto scene = mesh_scene(box(Vec3(0.1, 0.1, 0.1)));
  std::string why;
  EXPECT_FALSE(simplification_knob(*scene, setup(), scene_effort(), why).has_value());
  EXPECT_EQ(why, "it has 12 triangles; expected 256 to 2000000");
}

TEST(SceneAccuracy, KnowsTheStiffnessOfEveryMaterial) {
  const Scene scene = loaded("effect_stiffness.glb");
  const auto couplings = couplings_of(scene, {1000.0, 0.25});
  ASSERT_EQ(couplings.size(), 4u);
  EXPECT_EQ(couplings[0].coupling.stiffness_N_per_m, 1000.0);
  EXPECT_EQ(couplings[0].coupling.damping_Ns_per_m, 0.25);
  std::vector<double> stiffness;
  for (const SurfaceCoupling& surface : couplings) {
    stiffness.push_back(surface.coupling.stiffness_N_per_m);
  }
  std::sort(stiffness.begin(), stiffness.end());
  EXPECT_EQ(stiffness, (std::vector<double>{200.0, 800.0, 1000.0, 3000.0}));
}

DeviceDescription device_with(double damping_Ns_per_m, double encoder_quantum_m) {
  DeviceDescription device;
  device.mass_kg = 0.1;
  device.damping_Ns_per_m = damping_Ns_per_m;
  device.encoder_quantum_m = encoder_quantum_m;
  return device;
}

// b = 1, B = 0.25, T = 1 ms: passive below 2 (b - B) / T = 1500 N/m; stable below nearly
// 2 (b + B) / T = 2500 N/m.
TEST(SceneAccuracy, FlagsPassiveAndStableSurfaces) {
  const DeviceDescription device = device_with(1.0, 0.0);
  const std::vector<SurfaceCoupling> couplings{
      {"soft", {1400.0, 0.25}}, {"between", {1600.0, 0.25}}, {"hard", {2600.0, 0.25}}};
  const auto verdicts = judge_couplings(couplings, device, {1e-3, 0}, 3e-3);
  ASSERT_TRUE(verdicts.ok());
  EXPECT_TRUE((*verdicts)[0].is_passive);
  EXPECT_TRUE((*verdicts)[0].is_stable);
  EXPECT_FALSE((*verdicts)[1].is_passive);
  EXPECT_TRUE((*verdicts)[1].is_stable);
  EXPECT_FALSE((*verdicts)[2].is_passive);
  EXPECT_FALSE((*verdicts)[2].is_stable);
  EXPECT_NEAR((*verdicts)[0].limits.passive_N_per_m, 1500.0, 1e-9);
}

// An encoder on a device without friction allows no passive wall; the text must not name the
// damper.
TEST(SceneAccuracy, NamesTheBoundOfALimitOfZero) {
  SceneFindings findings;
  const std::vector<SurfaceCoupling> wall{{"wall", {100.0, 0.1}}};
  findings.verdicts = *judge_couplings(wall, device_with(0.5, 20e-6), {1e-3, 0}, 0.0);
  EXPECT_NE(scene_text(findings).find("not passive (passive up to 0)"), std::string::npos)
      << scene_text(findings);
  findings.verdicts = *judge_couplings(wall, device_with(0.05, 0.0), {1e-3, 0}, 0.0);
  EXPECT_NE(scene_text(findings).find("not passive at any K with its damper of 0.1 N s/m"),
            std::string::npos)
      << scene_text(findings);
}

// A sine of amplitude a and length L adds a spring of K d a (2 pi / L)^2 along the surface.
TEST(SceneAccuracy, AddsTheReliefOfATexture) {
  const SineRelief relief;
  const auto scene = sine_slab(relief, 64, ImageDepth::k16Bit, 0.3);
  ASSERT_TRUE(scene.ok());
  const auto couplings = couplings_of(*scene, {1000.0, 0.0});
  ASSERT_EQ(couplings.size(), 2u);
  EXPECT_EQ(couplings[0].relief_per_m, 0.0);
  const double wave_per_m = 2.0 * std::numbers::pi / relief.wave_m;
  const double theory = 0.5 * relief.height_m * wave_per_m * wave_per_m;
  EXPECT_NEAR(couplings[1].relief_per_m, theory, 0.02 * theory);
  const double effective = 1000.0 * (1.0 + 2e-3 * theory);
  EXPECT_NEAR(couplings[1].effective_stiffness_N_per_m(2e-3), effective, 0.02 * effective);
}

TEST(SceneAccuracy, QuotesTextsOfAFile) {
  SceneFindings findings;
  findings.verdicts.push_back({{"<script>\"x\"", {1.0, 0.0}}, 1.0, {}, true, true});
  EXPECT_NE(scene_csv(findings).find("\"<script>\"\"x\"\"\""), std::string::npos);
}

}  // namespace
}  // namespace palpate
