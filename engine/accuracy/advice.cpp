#include "engine/accuracy/advice.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "engine/accuracy/machine_load.h"
#include "engine/accuracy/percent.h"
#include "engine/accuracy/recommendation.h"
#include "engine/devices/light_device.h"
#include "engine/devices/stiffness_zones.h"
#include "engine/report/human_units.h"
#include "engine/report/shell_word.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

// An error of the proxy that is small enough, as in the knobs of the solver.
constexpr double kEnoughProxy_m = 1e-6;

// A stiffness that is stable but not passive keeps this part of the limit: a gain margin of two.
constexpr double kStablePart = 0.5;

const KnobResult* measured_knob(const AdviceInput& input, const std::string& name) {
  for (const KnobResult& result : input.results) {
    if (result.knob.name == name && result.recommended) return &result;
  }
  return nullptr;
}

// Why a setting stays as it is, if none of these knobs recommends a level: they were not measured,
// or the spread is wider than the effect. `stays`: "The default".
bool is_undecided(const AdviceInput& input, const std::string& name) {
  return std::any_of(input.results.begin(), input.results.end(), [&](const KnobResult& result) {
    return result.knob.name == name && result.undecided;
  });
}
std::string why_unchanged(const AdviceInput& input, const std::string& stays,
                          const std::vector<std::string>& names) {
  std::string all, undecided;
  for (const std::string& name : names) {
    all += (all.empty() ? "" : " and ") + name;
    if (is_undecided(input, name)) undecided += (undecided.empty() ? "" : " and ") + name;
  }
  if (!undecided.empty()) {
    return stays + ": the effect of " + undecided +
           " is smaller than the spread of the repeats; measure again on an idle machine.";
  }
  return stays + "; the knob" + (names.size() == 1 ? " " : "s ") + all +
         (names.size() == 1 ? " was" : " were") + " not measured.";
}

const LevelResult& chosen(const KnobResult& result) {
  return result.methods[result.recommended->method].levels[result.recommended->level];
}

bool chose_default(const KnobResult& result) {
  return *result.recommended == result.default_place();
}

// Down to two significant digits. A value that has two digits already keeps them: the rounding of
// the power of ten and of the quotient, below 4 epsilon, must not lower it.
double rounded_down(double value) {
  if (!(value > 0.0)) return 0.0;
  constexpr double kRounding = 4.0 * std::numeric_limits<double>::epsilon();
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::floor(value / unit * (1.0 + kRounding)) * unit;
}

std::string stiffness_text(double stiffness_N_per_m) {
  return short_number(stiffness_N_per_m) + " N/m";
}

// ---- rate --------------------------------------------------------------------------------------

// Level values of the servo knobs are periods.
double rate_of(const KnobResult& result) {
  return std::round(1.0 / chosen(result).value);
}

// The figures of a servo knob at its recommended rate, as a sentence.
std::string servo_sentence(const KnobResult& result) {
  const LevelResult& level = chosen(result);
  const std::string error = percent_text(level.error.median);
  const std::string bound = percent_text(result.knob.enough);
  const char* relation = level.error.median <= result.knob.enough ? "at most" : "more than";
  if (result.knob.name == "servo_rate") {
    return "A bounce off 1000 N/m gains " + error + " energy, " + relation + " the " + bound +
           " that the device's damping takes.";
  }
  return "The path of a device pressed on 1000 N/m deviates by " + error + ", " + relation +
         " the " + bound + " that people notice.";
}

// The rate asked for, or else the one that the knobs recommend.
Answer rate_answer(const AdviceInput& input, Advice& advice) {
  Answer answer{"Rate", "", "", ""};
  const KnobResult* deciding = nullptr;
  for (const char* name : {"servo_rate", "servo_pressed"}) {
    const KnobResult* result = measured_knob(input, name);
    if (result && (!deciding || rate_of(*result) > rate_of(*deciding))) deciding = result;
  }
  const double best_Hz = deciding ? rate_of(*deciding) : light_device().rate_Hz;
  advice.rate_Hz = input.rate_Hz.value_or(best_Hz);
  answer.value = human(advice.rate_Hz, "Hz");
  if (!deciding) {
    answer.reason = why_unchanged(input, input.rate_Hz ? "The value given" : "The default",
                                  {"servo_rate", "servo_pressed"});
  } else if (advice.rate_Hz != best_Hz) {
    answer.reason = "The value given; the knobs recommend " + human(best_Hz, "Hz") +
                    ". There: " + servo_sentence(*deciding);
  } else {
    answer.reason = servo_sentence(*deciding);
  }
  answer.limit = input.scene
                     ? "What this machine keeps does not change it; the next answer says it."
                     : "The rates that this machine keeps were not measured; give a SCENE.";
  return answer;
}

// ---- stiffness and damping ---------------------------------------------------------------------

// By how much the stiffest relief of the surfaces without their own stiffness exceeds it.
double relief_factor(const AdviceInput& input) {
  double most = 1.0;
  if (!input.scene) return most;
  for (const CouplingVerdict& v : input.scene->verdicts) {
    const double stiffness = v.surface.coupling.stiffness_N_per_m;
    if (stiffness != input.coupling.stiffness_N_per_m || !(stiffness > 0.0)) continue;
    most = std::max(most, v.effective_N_per_m / stiffness);
  }
  return most;
}

struct ChosenCoupling {
  double stiffness_N_per_m = 0.0;
  double damping_Ns_per_m = 0.0;
  StabilityLimits limits;
  bool is_passive = false;
  bool has_delay = false;
};

// The stiffness wanted, or the largest below it that this damping allows.
Result<ChosenCoupling> coupling_with(const AdviceInput& input, double rate_Hz,
                                     double damping_Ns_per_m) {
  const auto limits = stability_limits(wall_mechanics(input.device), damping_Ns_per_m,
                                       {1.0 / rate_Hz, wall_delay_s(input.device)});
  if (!limits) return limits.error();
  const double factor = relief_factor(input);
  ChosenCoupling found{input.coupling.stiffness_N_per_m, damping_Ns_per_m, *limits, false,
                       wall_delay_s(input.device) > 0.0};
  // Passive walls are stable.
  found.is_passive = limits->allows_passive_walls();
  const double effective_N_per_m = factor * found.stiffness_N_per_m;
  const double half_stable_N_per_m = kStablePart * limits->stable_N_per_m;
  const bool is_allowed = found.is_passive ? limits->is_passive(effective_N_per_m)
                                           : effective_N_per_m <= half_stable_N_per_m;
  if (is_allowed) return found;
  const double most = found.is_passive ? limits->passive_N_per_m : half_stable_N_per_m;
  found.stiffness_N_per_m = rounded_down(most / factor);
  return found;
}

// The damping given, else none, if walls are passive with it; else the smallest damping of a ladder
// with which the stiffness wanted is stable, or the damping that allows the stiffest wall.
Result<ChosenCoupling> choose_coupling(const AdviceInput& input, double rate_Hz) {
  for (const double damping : {input.coupling.damping_Ns_per_m, 0.0}) {
    const auto found = coupling_with(input, rate_Hz, damping);
    if (!found || found->is_passive) return found;
  }
  std::optional<ChosenCoupling> best;
  for (const double damping : {0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) {
    const auto found = coupling_with(input, rate_Hz, damping);
    if (!found) return found.error();
    if (!best || found->stiffness_N_per_m > best->stiffness_N_per_m) best = *found;
  }
  return *best;
}

std::string bound_sentence(const ChosenCoupling& c) {
  const StabilityLimits& limits = c.limits;
  const std::string passive = stiffness_text(rounded_down(limits.passive_N_per_m));
  const std::string stable =
      "; the loop is stable below " + stiffness_text(rounded_down(limits.stable_N_per_m)) + ".";
  switch (limits.passivity_bound) {
    case PassivityBound::kEncoder:
      return "The encoder limits passive walls to " + passive + " (2 x friction / quantum)" +
             stable;
    case PassivityBound::kDamper:
      return "The damper limits it: B leaves none of the device's damping b" + stable;
    case PassivityBound::kSampling:
      break;
  }
  return (c.has_delay ? "Sampling and delay limit passive walls to " + passive +
                            " (b > K (T / 2 + D) + |B|)"
                      : "Sampling limits passive walls to " + passive + " (b > K T / 2 + |B|)") +
         stable;
}

// The surfaces of the scene that have a coupling of their own which is not passive at this rate.
std::string stiff_surfaces(const AdviceInput& input, double rate_Hz) {
  if (!input.scene) return "";
  constexpr std::size_t kMostNamed = 3;
  std::string names;
  std::size_t count = 0;
  for (const CouplingVerdict& v : input.scene->verdicts) {
    if (v.surface.coupling.stiffness_N_per_m == input.coupling.stiffness_N_per_m) continue;
    const auto limits =
        stability_limits(wall_mechanics(input.device), v.surface.coupling.damping_Ns_per_m,
                         {1.0 / rate_Hz, wall_delay_s(input.device)});
    if (!limits || limits->is_passive(v.effective_N_per_m)) continue;
    if (++count > kMostNamed) continue;
    names += (names.empty() ? "" : ", ") + printable(v.surface.name) + " (" +
             stiffness_text(v.effective_N_per_m) +
             (limits->is_stable(v.effective_N_per_m) ? ")" : ", not stable)");
  }
  if (count == 0) return "";
  return " Surfaces of this scene that are not passive: " + names +
         (count > kMostNamed ? " and " + std::to_string(count - kMostNamed) + " more." : ".");
}

// What the motors of a device that states no delay may add to it.
std::string motors_sentence(const AdviceInput& input, const ChosenCoupling& c, double rate_Hz) {
  if (c.has_delay) return "";
  const auto zones = stiffness_zones(input.device, c.damping_Ns_per_m, 1.0 / rate_Hz);
  if (!zones) return "";
  return " With motors, the delay of the force counts (--device-delay); if it is up to " +
         human(zones->mechanics.delay.most_s, "s") + ", walls are stable below " +
         stiffness_text(rounded_down(zones->stable_N_per_m)) + ".";
}

Answer stiffness_answer(const AdviceInput& input, const ChosenCoupling& c, double rate_Hz) {
  Answer answer{"Stiffness", stiffness_text(c.stiffness_N_per_m), "", ""};
  const double wanted = input.coupling.stiffness_N_per_m;
  const bool is_default = wanted == CouplingSettings{}.stiffness_N_per_m;
  const std::string at = " at " + human(rate_Hz, "Hz");
  if (!c.is_passive) {
    answer.reason =
        "No wall is passive on this device; this one is half as stiff as the stability "
        "limit" +
        at + ", or softer.";
  } else if (c.stiffness_N_per_m == wanted) {
    answer.reason = std::string(is_default ? "The default" : "The value given") + ": passive" + at +
                    ", so no hand gets more energy out of a wall than it put in.";
  } else {
    answer.reason = "The stiffest passive wall" + at + "; the " +
                    (is_default ? "default" : "value given") + ", " + stiffness_text(wanted) +
                    ", is not passive.";
  }
  answer.limit =
      bound_sentence(c) + motors_sentence(input, c, rate_Hz) + stiff_surfaces(input, rate_Hz);
  return answer;
}

// What this machine keeps, with the stiffest wall at that rate; it changes none of the settings.
Result<Answer> machine_answer(const AdviceInput& input, double rate_Hz) {
  const KeptRate& kept = input.scene->measured.kept_rate;
  Answer answer{"This machine", "", "", "It depends on the other load of this machine."};
  if (!(kept.rate_Hz() > 0.0)) {
    answer.value = "keeps none of the rates tried";
    answer.reason = "At " + human(rate_Hz, "Hz") + " it misses deadlines with this scene.";
    return answer;
  }
  answer.value = "keeps up to " + human(kept.rate_Hz(), "Hz");
  if (kept.rate_Hz() >= rate_Hz) {
    answer.reason = "It keeps this rate with this scene.";
    return answer;
  }
  const double kept_Hz = rounded_down(kept.rate_Hz());
  const auto coupling = choose_coupling(input, kept_Hz);
  if (!coupling) return coupling.error();
  answer.value += ", less than " + human(rate_Hz, "Hz");
  answer.reason = "At " + human(rate_Hz, "Hz") + " it misses deadlines with this scene. For this " +
                  "machine take --rate " + shortest_digits(kept_Hz) + " --stiffness " +
                  shortest_digits(coupling->stiffness_N_per_m) + " --damping " +
                  shortest_digits(coupling->damping_Ns_per_m) + ".";
  return answer;
}

Answer damping_answer(const AdviceInput& input, const ChosenCoupling& c, double rate_Hz) {
  Answer answer{"Damping", short_number(c.damping_Ns_per_m) + " N s/m", "", ""};
  const double given = input.coupling.damping_Ns_per_m;
  if (!c.is_passive) {
    answer.reason = c.damping_Ns_per_m > 0.0
                        ? "The damper of the coupling stabilises a device that has too little "
                          "damping of its own."
                        : "The loop is stable without a damper.";
  } else if (c.damping_Ns_per_m == given) {
    answer.reason = given > 0.0 ? "The value given: walls are passive with it."
                                : "The default: a damper B lowers the passive stiffness, "
                                  "2 (b - B) / T.";
  } else {
    answer.reason = "No wall is passive with the " + short_number(given) +
                    " N s/m given, because the device's own damping is no larger.";
  }
  const double step = 0.1 * input.device.damping_Ns_per_m;
  if (step > 0.0) {
    answer.limit =
        "B must stay below the device's b = " + human(input.device.damping_Ns_per_m, "N s/m") +
        "; each " + short_number(step) + " N s/m lowers the sampling limit by " +
        stiffness_text(2.0 * step * rate_Hz) + ".";
  } else {
    answer.limit = "The device has no damping, so no damper is passive.";
  }
  return answer;
}

// ---- preset ------------------------------------------------------------------------------------

// A preset on the scene as a level of the decision.
LevelResult level_of(const PresetOnScene& preset, double floor_m) {
  LevelResult level;
  const double error_m = std::max(preset.rms_error_m, floor_m);
  level.error = {error_m, error_m, error_m};
  level.time = preset.p50_ns;
  level.repeats = 1;
  return level;
}

std::string preset_clause(const PresetOnScene& preset, double floor_m) {
  return "99 % of its ticks take at most " + human(preset.p99_ns.median, "ns") +
         ", and its proxy is within " + human(std::max(preset.worst_error_m, floor_m), "m") +
         " of exact";
}

Answer preset_on_scene(const SceneAccuracy& measured, Advice& advice) {
  Answer answer{"Preset", "", "", ""};
  const auto& presets = measured.presets;
  const double half_period_ns = 0.5e9 / advice.rate_Hz;
  if (presets[kDefaultPreset].p99_ns.median > half_period_ns) {
    advice.preset = 0;
    answer.reason = "Ticks of balanced take " + human(presets[kDefaultPreset].p99_ns.median, "ns") +
                    " (99 %), more than half a period.";
  } else {
    // Both are certified; fast is not.
    const std::array levels = {level_of(presets[1], measured.floor_m),
                               level_of(presets[2], measured.floor_m)};
    const std::array pointers = {&levels[0], &levels[1]};
    const std::array<std::size_t, 2> distances = {0, 1};
    const auto best = chosen_level(pointers, distances, kEnoughProxy_m);
    advice.preset = 1 + best.value_or(0);
    answer.reason = (advice.preset == kDefaultPreset ? std::string("The default: ")
                                                     : std::string("Clearly better here: ")) +
                    preset_clause(presets[advice.preset], measured.floor_m) + ".";
  }
  answer.limit = "fast may pass a thin surface (not certified). Median ticks: fast " +
                 human(presets[0].p50_ns.median, "ns") + ", balanced " +
                 human(presets[1].p50_ns.median, "ns") + ", exact " +
                 human(presets[2].p50_ns.median, "ns") + ".";
  return answer;
}

Answer preset_of_knobs(const AdviceInput& input, Advice& advice) {
  Answer answer{"Preset", "", "", ""};
  std::string better;
  std::size_t count = 0;
  for (const KnobResult& result : input.results) {
    const LevelResult& balanced = result.presets[1];
    const LevelResult& exact = result.presets[2];
    if (!balanced.counts() || !exact.counts()) continue;
    ++count;
    const bool is_better = balanced.error.median > result.knob.enough &&
                           exact.error.median <= result.knob.enough &&
                           !is_alike(balanced.error, exact.error);
    if (is_better) better += (better.empty() ? "" : ", ") + result.knob.name;
  }
  advice.preset = better.empty() ? kDefaultPreset : 2;
  if (count == 0) {
    answer.reason = "The default; no knob was measured.";
  } else if (better.empty()) {
    answer.reason = count == 1 ? "The default: exact is not needed on the one knob measured."
                               : "The default: exact is needed on none of the " +
                                     std::to_string(count) + " knobs measured.";
  } else {
    answer.reason = "The error of balanced is too large on " + better + ", that of exact is not.";
  }
  answer.limit =
      "fast may pass a thin surface (not certified). Times depend on the scene; give a SCENE.";
  return answer;
}

Answer preset_answer(const AdviceInput& input, Advice& advice) {
  Answer answer =
      input.scene ? preset_on_scene(input.scene->measured, advice) : preset_of_knobs(input, advice);
  answer.value = kPresetNames[advice.preset];
  return answer;
}

// ---- velocity ----------------------------------------------------------------------------------

VelocityMethod estimator_of(const std::string& method) {
  if (method == "line fit") return VelocityMethod::kLineFit;
  return method == "adaptive" ? VelocityMethod::kAdaptive : VelocityMethod::kDifference;
}

const char* estimator_name(VelocityMethod method) {
  return method == VelocityMethod::kLineFit    ? "line"
         : method == VelocityMethod::kAdaptive ? "adaptive"
                                               : "difference";
}

Answer velocity_answer(const AdviceInput& input, Advice& advice) {
  Answer answer{"Velocity window", "", "", ""};
  const KnobResult* total = measured_knob(input, "velocity_total");
  VelocitySettings& velocity = advice.coupling.velocity;
  velocity = {VelocityMethod::kDifference, 1, input.device.encoder_quantum_m};
  if (!total) {
    answer.value = "1 tick, difference";
    answer.reason = why_unchanged(input, "The default", {"velocity_total"});
  } else {
    const std::string& method = total->methods[total->recommended->method].name;
    const LevelResult& level = chosen(*total);
    velocity.method = estimator_of(method);
    velocity.window_ticks = static_cast<int>(std::lround(level.value));
    answer.value = level.label + ", " + method;
    const std::string quantum =
        input.device.encoder_quantum_m > 0.0
            ? "an encoder step of " + human(input.device.encoder_quantum_m, "m")
            : std::string("an exact encoder");
    answer.reason = (chose_default(*total) ? "The default: noise and lag together are "
                                           : "Noise and lag together are about the least, ") +
                    human(level.error.median, "m/s") + " at " + quantum +
                    "; noise alone favours more ticks, lag fewer.";
  }
  answer.limit =
      "For surfaces with a damper. Above one tick the damper returns energy, which the "
      "limits ignore.";
  return answer;
}

// ---- mesh --------------------------------------------------------------------------------------

// The mesh that the knob of the smooth sphere recommends.
std::string smooth_sphere_clause(const KnobResult& depth) {
  const LevelResult& level = chosen(depth);
  return " smooth sphere of 0.2 m needs " + level.label + " (edges of " + human(level.value, "m") +
         ")";
}

Answer mesh_on_scene(const KnobResult& own, const KnobResult* depth) {
  const LevelResult& level = chosen(own);
  const LevelResult& whole = own.methods.front().levels.back();
  Answer answer{"Mesh", level.label, "", ""};
  if (chose_default(own)) {
    answer.value += ", as in the file";
    answer.reason = "The default: no coarser mesh is clearly quicker and within " +
                    human(own.knob.enough, "m") + " of it.";
  } else {
    answer.value += " instead of " + whole.label;
    answer.reason = "The quickest mesh within " + human(own.knob.enough, "m") +
                    " of the file's: " + human(level.error.median, "m") + " off, ticks of " +
                    human(level.time.median, "ns") + " instead of " +
                    human(whole.time.median, "ns") + ".";
  }
  answer.limit = "Compared with the file's own mesh";
  answer.limit += depth ? "; a" + smooth_sphere_clause(*depth) + "." : ".";
  return answer;
}

Answer mesh_answer(const AdviceInput& input) {
  const KnobResult* depth = measured_knob(input, "mesh_depth");
  if (const KnobResult* own = measured_knob(input, "scene_resolution")) {
    return mesh_on_scene(*own, depth);
  }
  Answer answer{"Mesh", "as in the file", "", ""};
  if (!depth) {
    answer.reason = why_unchanged(input, "The default", {"mesh_depth", "scene_resolution"});
    answer.limit = "More triangles than the shape needs cost time and memory alone.";
  } else if (input.scene) {
    answer.reason = is_undecided(input, "scene_resolution")
                        ? why_unchanged(input, "The default", {"scene_resolution"})
                        : "The default; the scene's own mesh was not simplified.";
    answer.limit = "A" + smooth_sphere_clause(*depth) + " for a depth error within " +
                   human(depth->knob.enough, "m") + ".";
  } else {
    const LevelResult& level = chosen(*depth);
    answer.value = "edges of " + human(level.value, "m");
    answer.reason = "The quickest mesh of a sphere of 0.2 m with a depth error within " +
                    human(depth->knob.enough, "m") + ": " + level.label + ", " +
                    human(level.error.median, "m") + ".";
    answer.limit =
        "Half the edge leaves a quarter of the error; smaller radii of curvature need "
        "shorter edges.";
  }
  return answer;
}

// ---- the machine -------------------------------------------------------------------------------

std::string busy_sentence(double others_cores) {
  if (others_cores < kBusyCores) return "";
  const int cores = machine_cores();
  return "This machine was busy: other programs used " + short_number(others_cores) + " of its " +
         std::to_string(cores) + (cores == 1 ? " core" : " cores") +
         " meanwhile. Times are longer and rates lower than on an idle one; measure again on an "
         "idle "
         "one.";
}

// ---- command -----------------------------------------------------------------------------------

std::vector<std::string> command_of(const AdviceInput& input, const Advice& advice) {
  std::vector<std::string> command{input.program, "run"};
  if (input.scene_options.empty()) {
    command.insert(command.end(), {kAdviceModel, "--fit", "auto"});
  } else {
    command.insert(command.end(), input.scene_options.begin(), input.scene_options.end());
  }
  command.emplace_back("--virtual");
  const auto add = [&](const char* option, const std::string& value) {
    command.emplace_back(option);
    command.push_back(value);
  };
  add("--rate", shortest_digits(advice.rate_Hz));
  add("--stiffness", shortest_digits(advice.coupling.stiffness_N_per_m));
  add("--damping", shortest_digits(advice.coupling.damping_Ns_per_m));
  add("--accuracy", kPresetNames[advice.preset]);
  const VelocitySettings& velocity = advice.coupling.velocity;
  add("--velocity-estimator", estimator_name(velocity.method));
  add("--velocity-window", std::to_string(velocity.window_ticks));
  add("--device-mass", shortest_digits(input.device.mass_kg));
  add("--device-damping", shortest_digits(input.device.damping_Ns_per_m));
  add("--device-friction", shortest_digits(input.device.coulomb_friction_N));
  // The adaptive estimator needs a quantum, and `run` rejects a quantum of 0.
  if (input.device.encoder_quantum_m > 0.0) {
    add("--encoder-quantum", shortest_digits(input.device.encoder_quantum_m));
  } else if (velocity.method == VelocityMethod::kAdaptive) {
    add("--encoder-quantum", shortest_digits(light_device().encoder_quantum_m));
  }
  return command;
}

}  // namespace

std::string shortest_digits(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

Result<Advice> advise(const AdviceInput& input) {
  Advice advice;
  advice.subject = input.scene ? "For this device and this scene" : "For this device";
  advice.device = mechanics_text(input.device);
  advice.busy = busy_sentence(input.others_cores);
  advice.answers.push_back(rate_answer(input, advice));
  if (input.scene) {
    const auto machine = machine_answer(input, advice.rate_Hz);
    if (!machine) return machine.error();
    advice.answers.push_back(*machine);
  }
  const auto coupling = choose_coupling(input, advice.rate_Hz);
  if (!coupling) return coupling.error();
  advice.coupling.stiffness_N_per_m = coupling->stiffness_N_per_m;
  advice.coupling.damping_Ns_per_m = coupling->damping_Ns_per_m;
  advice.answers.push_back(stiffness_answer(input, *coupling, advice.rate_Hz));
  advice.answers.push_back(damping_answer(input, *coupling, advice.rate_Hz));
  advice.answers.push_back(preset_answer(input, advice));
  advice.answers.push_back(velocity_answer(input, advice));
  advice.answers.push_back(mesh_answer(input));
  advice.command = command_of(input, advice);
  return advice;
}

std::vector<std::string> command_words(const Advice& advice) {
  std::vector<std::string> words;
  for (const std::string& argument : advice.command) words.push_back(shell_word(argument));
  return words;
}

std::string command_line(const Advice& advice) {
  std::string line;
  for (const std::string& word : command_words(advice)) line += (line.empty() ? "" : " ") + word;
  return line;
}

std::string advice_text(const Advice& advice) {
  std::size_t width = 0;
  for (const Answer& answer : advice.answers) width = std::max(width, answer.setting.size());
  std::ostringstream text;
  text << advice.subject << " (" << advice.device << "):\n";
  if (!advice.busy.empty()) text << "  " << advice.busy << "\n";
  for (const Answer& answer : advice.answers) {
    text << "  " << answer.setting << std::string(width + 2 - answer.setting.size(), ' ')
         << answer.value << "\n";
  }
  text << "  " << printable(command_line(advice)) << "\n";
  return text.str();
}

}  // namespace palpate
