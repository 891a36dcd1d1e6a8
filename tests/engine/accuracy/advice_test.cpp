// The answers that the report gives first.

#include "engine/accuracy/advice.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/accuracy/knobs.h"
#include "engine/accuracy/recommendation.h"
#include "engine/devices/light_device.h"
#include "tests/helpers/made.h"

namespace palpate {
namespace {

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

LevelResult made_level(double value, const std::string& label, double time, double error) {
  LevelResult level;
  level.value = value;
  level.label = label;
  level.repeats = MeasurementEffort::kRepeats;
  level.time = {time, time, time};
  level.error = {error, error, error};
  return level;
}

KnobResult made_knob(const char* name, std::vector<MethodResult> methods, std::size_t usual,
                     double enough) {
  KnobResult result;
  result.knob.name = name;
  result.knob.default_level = usual;
  result.knob.enough = enough;
  result.methods = std::move(methods);
  for (LevelResult& preset : result.presets) preset = made_level(0.0, "", 100.0, 0.0);
  judge(result);
  return result;
}

KnobResult servo(const char* name, double error_at_1_kHz, double enough) {
  MethodResult held{"held force", {}, {}, {}, 0.0};
  for (const double rate_kHz : {0.5, 1.0, 2.0, 4.0}) {
    held.levels.push_back(
        made_level(1e-3 / rate_kHz, "", 100.0 * rate_kHz, error_at_1_kHz / rate_kHz));
  }
  return made_knob(name, {held}, 1, enough);
}

KnobResult mesh_depth() {
  MethodResult sphere{"sphere", {}, {}, {}, 0.0};
  sphere.levels = {made_level(4.1e-3, "20k triangles", 240.0, 18e-6),
                   made_level(2.05e-3, "82k triangles", 285.0, 4.6e-6)};
  return made_knob("mesh_depth", {sphere}, 0, 1e-5);
}

KnobResult scene_resolution(double coarse_time) {
  MethodResult own{"simplified", {}, {}, {}, 0.0};
  own.levels = {made_level(2e-3, "5120 triangles", coarse_time, 7e-6),
                made_level(1e-3, "20480 triangles", 300.0, 6e-9)};
  return made_knob("scene_resolution", {own}, 1, 1e-5);
}

KnobResult velocity_total() {
  MethodResult difference{"difference", {}, {}, {}, 0.0};
  difference.levels = {made_level(1, "1 tick", 300.0, 8.2e-3),
                       made_level(4, "4 ticks", 310.0, 3e-3),
                       made_level(32, "32 ticks", 310.0, 18e-3)};
  return made_knob("velocity_total", {difference}, 0, 5e-3);
}

std::vector<KnobResult> all_results() {
  return {mesh_depth(), servo("servo_rate", 0.12, 0.14), servo("servo_pressed", 0.076, 0.07),
          velocity_total()};
}

SceneFindings findings(double kept_Hz) {
  SceneFindings f;
  f.path = "a scene.glb";
  f.measured.kept_rate.by_trial_Hz = kept_Hz;
  f.measured.kept_rate.by_computing_Hz = 1e6;
  for (std::size_t p = 0; p < 3; ++p) {
    PresetOnScene& preset = f.measured.presets[p];
    preset.name = kPresetNames[p];
    preset.p50_ns = {300, 300, 300};
    preset.p99_ns = {400, 400, 400};
  }
  return f;
}

AdviceInput input_of(const std::vector<KnobResult>& results) {
  AdviceInput input;
  input.results = results;
  input.device = light_device();
  return input;
}

const Answer& answer_of(const Advice& advice, const std::string& setting) {
  for (const Answer& answer : advice.answers) {
    if (answer.setting == setting) return answer;
  }
  ADD_FAILURE() << "no answer for " << setting;
  return advice.answers.front();
}

// ---- text --------------------------------------------------------------------------------------

// What the box at the top of the page has.
std::string box_of(const Advice& advice) {
  std::string text = advice.subject + "\n";
  for (const Answer& answer : advice.answers) {
    text +=
        answer.setting + ": " + answer.value + "\n" + answer.reason + "\n" + answer.limit + "\n";
  }
  return text;
}

TEST(Advice, TheBoxAnswersEachQuestionInASentence) {
  const std::vector<KnobResult> results = all_results();
  AdviceInput input = input_of(results);
  input.device.coulomb_friction_N = 0.01;
  const auto advice = advise(input);
  ASSERT_TRUE(advice.ok()) << advice.error().to_string();
  const std::string box = box_of(*advice);
  for (const char* sentence :
       {"For this device\n",
        // Which rate?
        "Rate: 2 kHz\n",
        "The path of a device pressed on 1000 N/m deviates by 3.8 %, at most the 7 % that people "
        "notice.",
        // Which stiffness, and what limits it?
        "Stiffness: 1000 N/m\n",
        "The default: passive at 2 kHz, so no hand gets more energy out of a wall than it put in.",
        "The encoder limits passive walls to 1000 N/m (2 x friction / quantum); the loop is stable "
        "below 2000 N/m.",
        "Damping: 0 N s/m\n",
        // Which preset?
        "Preset: balanced\n", "The default: exact is needed on none of the 4 knobs measured.",
        // Which window?
        "Velocity window: 4 ticks, difference\n",
        "Noise and lag together are about the least, 3 mm/s at an encoder step of 20 µm; noise "
        "alone favours more "
        "ticks, lag fewer.",
        // Which mesh?
        "Mesh: edges of 2.05 mm\n",
        "The quickest mesh of a sphere of 0.2 m with a depth error within 10 µm: 82k triangles, "
        "4.6 µm."}) {
    EXPECT_TRUE(says(box, sentence)) << sentence << "\n" << box;
  }
  EXPECT_TRUE(
      says(command_line(*advice),
           "palpate run models/sphere.glb --fit auto --virtual --rate 2000 --stiffness 1000 "
           "--damping 0 --accuracy balanced --velocity-estimator difference --velocity-window 4 "
           "--device-mass 0.1 --device-damping 0.5 --device-friction 0.01 "
           "--encoder-quantum 2e-05"))
      << command_line(*advice);
}

TEST(Advice, TheBoxReconcilesTheMeshOfASceneWithTheSmoothSphere) {
  const SceneFindings scene = findings(8000.0);
  for (const bool is_quicker : {true, false}) {
    std::vector<KnobResult> results = all_results();
    results.push_back(scene_resolution(is_quicker ? 200.0 : 290.0));
    AdviceInput input = input_of(results);
    input.scene = &scene;
    input.scene_options = {"a scene.glb", "--fit", "0.2"};
    const auto advice = advise(input);
    ASSERT_TRUE(advice.ok());
    const std::string box = box_of(*advice);
    EXPECT_TRUE(says(box, "For this device and this scene"));
    EXPECT_TRUE(
        says(box, "This machine: keeps up to 8 kHz\nIt keeps this rate with this scene.\n"));
    EXPECT_TRUE(says(box, is_quicker ? "Mesh: 5120 triangles instead of 20480 triangles\n"
                                     : "Mesh: 20480 triangles, as in the file\n"))
        << box;
    EXPECT_TRUE(says(box, "a smooth sphere of 0.2 m needs 82k triangles (edges of 2.05 mm)."));
    EXPECT_EQ(command_line(*advice).rfind("palpate run 'a scene.glb' --fit 0.2 --virtual ", 0), 0u);
  }
}

TEST(Advice, TheTerminalHasTheSameAnswers) {
  const std::vector<KnobResult> results = all_results();
  const auto advice = advise(input_of(results));
  ASSERT_TRUE(advice.ok());
  const std::string text = advice_text(*advice);
  for (const Answer& answer : advice->answers) {
    EXPECT_TRUE(says(text, answer.setting)) << text;
    EXPECT_TRUE(says(text, answer.value)) << text;
    EXPECT_FALSE(answer.reason.empty()) << answer.setting;
    EXPECT_FALSE(answer.limit.empty()) << answer.setting;
  }
  EXPECT_TRUE(says(text, command_line(*advice)));
}

TEST(Advice, SettingsThatWereNotMeasuredStayAtTheDefault) {
  const auto advice = advise(input_of({}));
  ASSERT_TRUE(advice.ok());
  EXPECT_EQ(advice->rate_Hz, 1000.0);
  EXPECT_EQ(advice->coupling.stiffness_N_per_m, 1000.0);
  EXPECT_EQ(advice->coupling.velocity.window_ticks, 1);
  EXPECT_EQ(advice->preset, kDefaultPreset);
  EXPECT_TRUE(says(answer_of(*advice, "Rate").reason, "were not measured"));
  EXPECT_TRUE(says(answer_of(*advice, "Mesh").reason, "were not measured"));
}

TEST(Advice, OneKnobIsOne) {
  std::vector<KnobResult> results = all_results();
  const auto preset = [&] { return answer_of(*advise(input_of(results)), "Preset").reason; };
  EXPECT_EQ(preset(), "The default: exact is needed on none of the 4 knobs measured.");
  // Each knob alone: those that a preset does not touch are not counted.
  std::string found;
  for (const KnobResult& only : all_results()) {
    results = {only};
    found += preset() + "\n";
  }
  EXPECT_TRUE(says(found, "The default: exact is not needed on the one knob measured.\n")) << found;
  EXPECT_FALSE(says(found, "1 knob")) << found;
}

// ---- decisions ---------------------------------------------------------------------------------

TEST(Advice, WhiskersWiderThanTheEffectChangeNoSetting) {
  std::vector<KnobResult> results = all_results();
  results.push_back(scene_resolution(200.0));
  for (KnobResult& result : results) {
    result.undecided = std::exchange(result.recommended, std::nullopt);
  }
  const auto is_unchanged = [&](const AdviceInput& input) {
    const Advice advice = test::made(advise(input));
    EXPECT_EQ(advice.command, test::made(advise(input_of({}))).command);
    EXPECT_EQ(
        answer_of(advice, "Rate").reason,
        "The default: the effect of servo_rate and servo_pressed is smaller than the spread of "
        "the repeats; measure again on an idle machine.");
    EXPECT_TRUE(says(answer_of(advice, "Velocity window").reason, "the effect of velocity_total"));
    EXPECT_TRUE(says(answer_of(advice, "Mesh").reason, "scene_resolution is smaller than the"));
    EXPECT_EQ(answer_of(advice, "Mesh").value, "as in the file");
  };
  is_unchanged(input_of(results));
  results[0] = mesh_depth();
  const SceneFindings scene = findings(8000.0);
  AdviceInput on_scene = input_of(results);
  on_scene.scene = &scene;
  is_unchanged(on_scene);
}

// A slow machine, or a busy one, changes no answer; what it keeps is said beside them.
TEST(Advice, WhatTheMachineKeepsIsAnAnswerOfItsOwn) {
  const std::vector<KnobResult> results = all_results();
  const SceneFindings fast = findings(8000.0), slow = findings(857.0), none = findings(0.0);
  AdviceInput input = input_of(results);
  input.device.encoder_quantum_m = 0.0;
  input.scene = &fast;
  const Advice on_fast = test::made(advise(input));
  EXPECT_EQ(on_fast.rate_Hz, 2000.0);
  input.scene = &slow;
  const Advice on_slow = test::made(advise(input));
  EXPECT_EQ(on_slow.command, on_fast.command);
  const Answer& machine = answer_of(on_slow, "This machine");
  EXPECT_EQ(machine.value, "keeps up to 857 Hz, less than 2 kHz");
  // 2 b / T at 850 Hz, and the same in the terminal.
  EXPECT_EQ(machine.reason,
            "At 2 kHz it misses deadlines with this scene. For this machine take --rate 850 "
            "--stiffness 850 --damping 0.");
  EXPECT_TRUE(says(advice_text(on_slow), "Rate             2 kHz\n")) << advice_text(on_slow);
  EXPECT_TRUE(says(advice_text(on_slow), "keeps up to 857 Hz, less than 2 kHz\n"));
  input.scene = &none;
  EXPECT_EQ(answer_of(*advise(input), "This machine").value, "keeps none of the rates tried");
  EXPECT_EQ(advise(input)->command, on_fast.command);
}

TEST(Advice, ABusyMachineIsSaidInBoxAndTerminal) {
  AdviceInput input = input_of({});
  EXPECT_EQ(advise(input)->busy, "");
  EXPECT_FALSE(says(advice_text(*advise(input)), "busy"));
  input.others_cores = 1.34;
  const Advice advice = test::made(advise(input));
  EXPECT_TRUE(says(advice.busy, "This machine was busy: other programs used 1.34 of its "));
  EXPECT_TRUE(
      says(advice_text(advice), "):\n  This machine was busy: other programs used 1.34 of "));
}

TEST(Advice, TheRateAskedForIsAnswered) {
  const std::vector<KnobResult> results = all_results();
  const SceneFindings scene = findings(857.0);
  AdviceInput input = input_of(results);
  input.device.encoder_quantum_m = 0.0;
  input.scene = &scene;
  input.rate_Hz = 500.0;
  const Advice slower = test::made(advise(input));
  EXPECT_EQ(answer_of(slower, "Rate").value, "500 Hz");
  EXPECT_TRUE(says(answer_of(slower, "Rate").reason,
                   "The value given; the knobs recommend 2 kHz. There: The path of a device"));
  EXPECT_EQ(slower.coupling.stiffness_N_per_m, 500.0) << "2 b / T at 500 Hz";
  EXPECT_EQ(answer_of(slower, "This machine").reason, "It keeps this rate with this scene.");
  EXPECT_TRUE(says(command_line(slower), "--rate 500 --stiffness 500"));
  input.rate_Hz = 2000.0;
  const Advice same = test::made(advise(input));
  EXPECT_EQ(answer_of(same, "Rate").value, "2 kHz");
  EXPECT_TRUE(says(answer_of(same, "Rate").reason, "The path of a device"));
  EXPECT_FALSE(says(answer_of(same, "Rate").reason, "The value given"));
  input.results = {};
  EXPECT_EQ(answer_of(*advise(input), "Rate").reason,
            "The value given; the knobs servo_rate and servo_pressed were not measured.");
}

// 2 (b - B) / T at 1 kHz, and 2 f_c / D.
TEST(Advice, TheTighterBoundLimitsTheStiffness) {
  AdviceInput input = input_of({});
  input.device.damping_Ns_per_m = 0.3;
  auto advice = advise(input);
  EXPECT_EQ(advice->coupling.stiffness_N_per_m, 600.0);
  EXPECT_TRUE(says(answer_of(*advice, "Stiffness").limit, "Sampling limits passive walls"));
  EXPECT_TRUE(says(answer_of(*advice, "Stiffness").limit, "to 600 N/m"));
  EXPECT_TRUE(
      says(answer_of(*advice, "Stiffness").reason, "the default, 1000 N/m, is not passive"));
  input.device.damping_Ns_per_m = 5.0;
  input.device.coulomb_friction_N = 5e-3;
  advice = advise(input);
  EXPECT_EQ(advice->coupling.stiffness_N_per_m, 500.0);
  EXPECT_TRUE(says(answer_of(*advice, "Stiffness").limit, "The encoder limits passive walls"));
}

TEST(Advice, ADamperThatLeavesNoWallPassiveIsNotRecommended) {
  AdviceInput input = input_of({});
  input.coupling = {900.0, 0.5};
  const auto advice = advise(input);
  EXPECT_EQ(advice->coupling.damping_Ns_per_m, 0.0);
  EXPECT_EQ(advice->coupling.stiffness_N_per_m, 900.0);
  EXPECT_TRUE(says(answer_of(*advice, "Damping").reason, "No wall is passive with the 0.5"));
}

TEST(Advice, ADeviceWithoutAPassiveWallGetsAStableOne) {
  for (const double damping : {0.5, 0.0}) {
    AdviceInput input = input_of({});
    input.device.coulomb_friction_N = 0.0;  // the encoder allows no passive wall
    input.device.damping_Ns_per_m = damping;
    const auto advice = advise(input);
    ASSERT_TRUE(advice.ok());
    const CouplingSettings& c = advice->coupling;
    EXPECT_GT(c.stiffness_N_per_m, 0.0);
    const auto limits = stability_limits(DeviceMechanics::of(input.device), c.damping_Ns_per_m, {});
    EXPECT_LE(c.stiffness_N_per_m, 0.5 * limits->stable_N_per_m);
    EXPECT_TRUE(says(answer_of(*advice, "Stiffness").reason, "No wall is passive"));
  }
}

// b / (T / 2 + D), to first order: 139 N/m for the bare tip, at 3.1 ms and 1 kHz.
TEST(Advice, WithoutAStatedDelayTheStiffnessNamesThatOfMotors) {
  AdviceInput input = input_of({});
  input.device.mass_kg = 0.1;
  input.device.damping_Ns_per_m = 0.5;
  EXPECT_TRUE(says(answer_of(*advise(input), "Stiffness").limit,
                   "if it is up to 3.1 ms, walls are stable below 130 N/m."));
  input.device.delay = {1e-3, 1e-3};
  EXPECT_FALSE(says(answer_of(*advise(input), "Stiffness").limit, "With motors"));
}

TEST(Advice, ASurfaceThatIsNotPassiveIsNamed) {
  SceneFindings scene = findings(8000.0);
  const CouplingSettings steel{3000.0, 0.0};
  scene.verdicts = {{{"steel", steel}, 3000.0, {}, false, false},
                    {{"foam", {200.0, 0.0}}, 200.0, {}, true, true}};
  AdviceInput input = input_of({});
  input.scene = &scene;
  const auto advice = advise(input);
  const std::string& limit = answer_of(*advice, "Stiffness").limit;
  EXPECT_TRUE(says(limit, "not passive: steel (3000 N/m, not stable).")) << limit;
  EXPECT_FALSE(says(limit, "foam")) << limit;
}

TEST(Advice, APresetThatFitsThePeriodIsChosenByItsError) {
  SceneFindings scene = findings(8000.0);
  AdviceInput input = input_of({});
  input.scene = &scene;
  EXPECT_EQ(advise(input)->preset, 1u) << "a tie: the default wins";
  scene.measured.presets[1].rms_error_m = 1e-4;
  EXPECT_EQ(advise(input)->preset, 2u) << "balanced errs, exact does not";
  scene.measured.presets[1].p99_ns = {6e5, 6e5, 6e5};
  EXPECT_EQ(advise(input)->preset, 0u) << "balanced takes more than half a millisecond";
}

// ---- the device --------------------------------------------------------------------------------

const Knob& knob_named(const std::vector<Knob>& knobs, const std::string& name) {
  const auto found =
      std::find_if(knobs.begin(), knobs.end(), [&](const Knob& knob) { return knob.name == name; });
  EXPECT_NE(found, knobs.end()) << name;
  return *found;
}

TEST(DeviceOptions, ReachEveryKnobThatHasADevice) {
  const MeasurementEffort effort{.quick = true, .seed = 1};
  DeviceDescription heavy = light_device();
  heavy.mass_kg = 0.3;
  heavy.damping_Ns_per_m = 1.5;
  heavy.encoder_quantum_m = 5e-6;
  const std::vector<Knob> light_knobs = all_knobs(effort);
  const std::vector<Knob> heavy_knobs = all_knobs(effort, heavy);
  for (const char* name : {"servo_rate", "servo_pressed", "jitter", "integrator", "velocity_noise",
                           "velocity_total"}) {
    const Knob& light = knob_named(light_knobs, name);
    const Knob& other = knob_named(heavy_knobs, name);
    const auto error = [](const Knob& knob) {
      return knob.methods[0].levels[knob.default_level].run(3).error;
    };
    EXPECT_NE(error(light), error(other)) << name;
    EXPECT_NE(light.run_preset(3, {}).error, other.run_preset(3, {}).error) << name;
  }
  for (const char* name : {"servo_rate", "servo_pressed", "integrator"}) {
    EXPECT_TRUE(says(knob_named(heavy_knobs, name).workload, "0.3 kg")) << name;
  }
  for (const char* name : {"velocity_noise", "velocity_lag", "velocity_total"}) {
    EXPECT_TRUE(says(knob_named(heavy_knobs, name).workload, "5 µm")) << name;
  }
  EXPECT_EQ(knob_named(heavy_knobs, "substeps").enough, 2.5e-6);
  EXPECT_NE(knob_named(heavy_knobs, "servo_rate").enough,
            knob_named(light_knobs, "servo_rate").enough);
  EXPECT_NE(knob_named(heavy_knobs, "jitter").enough, knob_named(light_knobs, "jitter").enough);
}

TEST(DeviceOptions, AnExactEncoderIsAccepted) {
  DeviceDescription exact = light_device();
  exact.encoder_quantum_m = 0.0;
  const MeasurementEffort effort{.quick = true, .seed = 1};
  for (const Knob& knob : velocity_knobs(effort, exact)) {
    for (const Method& method : knob.methods) {
      EXPECT_EQ(method.levels.front().run(1).failure, "") << knob.name << ", " << method.name;
    }
  }
  AdviceInput input = input_of({});
  input.device = exact;
  EXPECT_FALSE(says(command_line(*advise(input)), "--encoder-quantum"));
}

}  // namespace
}  // namespace palpate
