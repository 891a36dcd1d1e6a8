#include "engine/accuracy/accuracy_json.h"

#include <filesystem>
#include <optional>

#include <nlohmann/json.hpp>

#include "engine/accuracy/build_facts.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

Json optional_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json quantity_json(const Quantity& quantity) {
  return {{"name", printable(quantity.name)}, {"unit", printable(quantity.unit)}};
}

Json spread_json(const Spread& spread) {
  return {{"low", spread.low}, {"median", spread.median}, {"high", spread.high}};
}

Json place_json(const LevelPlace& place) {
  return {{"method", place.method}, {"level", place.level}};
}

// ---- advice ------------------------------------------------------------------------------------

Json advice_json(const Advice& advice) {
  Json answers = Json::array();
  for (const Answer& answer : advice.answers) {
    answers.push_back({{"setting", answer.setting},
                       {"value", printable(answer.value)},
                       {"reason", printable(answer.reason)},
                       {"limit", printable(answer.limit)}});
  }
  Json words = Json::array();
  for (const std::string& word : command_words(advice)) words.push_back(printable(word));
  return {{"subject", advice.subject},
          {"device", advice.device},
          {"busy", advice.busy},
          {"answers", answers},
          {"command", words}};
}

Json facts_json(const MeasurementEffort& effort) {
  Json facts = Json::array();
  const auto add = [&](const std::string& name, const std::string& value) {
    facts.push_back({{"name", name}, {"value", value}});
  };
  for (const auto& [name, value] : build_facts()) add(name, value);
  add("Seed", std::to_string(effort.seed));
  add("Repeats", std::to_string(MeasurementEffort::kRepeats));
  add("Effort", effort.quick ? "quick" : "full");
  return facts;
}

// ---- knobs -------------------------------------------------------------------------------------

Json level_json(const LevelResult& level) {
  const bool has = level.was_measured();
  return {{"label", printable(level.label)},
          {"value", level.value},
          {"error", has ? spread_json(level.error) : Json(nullptr)},
          {"time", has ? spread_json(level.time) : Json(nullptr)},
          {"iterations", has ? Json(level.iterations) : Json(nullptr)},
          {"repeats", level.repeats},
          {"failures", level.failures},
          {"failure", printable(level.failure)},
          {"at_floor", level.at_floor},
          {"on_front", level.on_front}};
}

Json method_json(const MethodResult& method) {
  Json levels = Json::array();
  for (const LevelResult& level : method.levels) levels.push_back(level_json(level));
  return {{"name", printable(method.name)},
          {"order", optional_json(method.order)},
          {"expected_order", optional_json(method.expected_order)},
          {"floor", method.floor},
          {"levels", levels}};
}

Json knob_json(const KnobResult& result) {
  const Knob& knob = result.knob;
  Json methods = Json::array(), presets = Json::array();
  for (const MethodResult& method : result.methods) methods.push_back(method_json(method));
  for (const LevelResult& preset : result.presets) presets.push_back(level_json(preset));
  return {{"name", printable(knob.name)},
          {"title", printable(knob.title)},
          {"level", quantity_json(knob.level)},
          {"error", quantity_json(knob.error)},
          {"time", quantity_json(knob.time)},
          {"workload", printable(knob.workload)},
          {"reference", printable(knob.reference)},
          {"floor_is", printable(knob.floor_is)},
          {"levels_are_given", knob.levels_are_given},
          {"methods_are_given", knob.methods_are_given},
          {"default", place_json(result.default_place())},
          {"recommended", result.recommended ? place_json(*result.recommended) : Json(nullptr)},
          {"undecided", result.undecided ? place_json(*result.undecided) : Json(nullptr)},
          {"decided_by", printable(result.decided_by_title)},
          {"enough", knob.enough},
          {"enough_because", printable(knob.enough_because)},
          {"default_because", printable(knob.default_because)},
          {"default_on_front", result.default_is_on_front()},
          {"default_behind", result.default_behind},
          {"better_than_default", printable(result.better_than_default)},
          {"methods", methods},
          {"presets", presets}};
}

// ---- scene -------------------------------------------------------------------------------------

Json preset_json(const PresetOnScene& preset) {
  return {{"name", preset.name},
          {"p50_ns", spread_json(preset.p50_ns)},
          {"p99_ns", spread_json(preset.p99_ns)},
          {"worst_ns", spread_json(preset.worst_ns)},
          {"rms_error_m", preset.rms_error_m},
          {"p99_error_m", preset.p99_error_m},
          {"worst_error_m", preset.worst_error_m},
          {"worst_force_error_N", preset.worst_force_error_N},
          {"iterations", preset.iterations},
          {"capped_ticks", preset.capped_ticks}};
}

Json kept_rate_json(const KeptRate& kept) {
  Json trials = Json::array();
  for (const RateTrial& trial : kept.trials) {
    trials.push_back({{"rate_Hz", trial.rate_Hz},
                      {"passed", trial.passed()},
                      {"trials", trial.trials},
                      {"kept", trial.kept},
                      {"ticks", trial.ticks},
                      {"missed", trial.missed},
                      {"longest_ns", trial.worst_ns}});
  }
  return {{"rate_Hz", kept.rate_Hz()},
          {"by_trial_Hz", kept.by_trial_Hz},
          {"by_computing_Hz", kept.by_computing_Hz},
          {"realtime_note", printable(kept.realtime_note)},
          {"trials", trials}};
}

Json surface_json(const CouplingVerdict& v) {
  const ComparedTexts passivity = passivity_texts(v);
  return {{"name", printable(v.surface.name)},
          {"is_passive", v.is_passive},
          {"is_stable", v.is_stable},
          {"zone", name_of(v.zone())},
          {"is_refused", v.zone() == StiffnessZone::kRefused},
          {"effective", passivity.stiffness},
          {"passive_up_to", passivity.limit},
          {"limited_by", name_of(v.limits.passivity_bound)},
          {"stable_below", stability_texts(v).limit},
          {"stiffness_N_per_m", v.surface.coupling.stiffness_N_per_m},
          {"damping_Ns_per_m", v.surface.coupling.damping_Ns_per_m}};
}

Json scene_json(const SceneFindings& f) {
  Json presets = Json::array(), surfaces = Json::array(), rates = Json::array();
  for (const PresetOnScene& preset : f.measured.presets) presets.push_back(preset_json(preset));
  for (const CouplingVerdict& verdict : f.verdicts) surfaces.push_back(surface_json(verdict));
  for (const LimitsAtRate& at : f.by_rate) {
    rates.push_back({{"rate_Hz", at.rate_Hz},
                     {"passive_N_per_m", at.limits.passive_N_per_m},
                     {"stable_N_per_m", at.limits.stable_N_per_m}});
  }
  return {{"name", printable(std::filesystem::path(f.path).filename().string())},
          {"start_note", printable(f.measured.start_note)},
          {"no_simplification", printable(f.no_simplification)},
          {"hands", f.measured.hands},
          {"seconds", f.measured.seconds},
          {"contact_share", f.measured.contact_share},
          {"repeats", f.measured.repeats},
          {"floor_m", f.measured.floor_m},
          {"presets", presets},
          {"kept_rate", kept_rate_json(f.measured.kept_rate)},
          {"device", mechanics_text(f.device)},
          {"delay", delay_text(f.device)},
          {"motors_delay_s", assumed_mechanics(f.device).delay.most_s},
          {"deepest_m", f.measured.deepest_m},
          {"rate_Hz", f.rate_Hz},
          {"surfaces", surfaces},
          {"limits", rates}};
}

Json stiffness_json(const StiffnessChart& chart) {
  return {{"device", assumed_text(chart.own.mechanics)},
          {"assumes_delay", chart.own.mechanics.assumes_delay},
          {"rate_Hz", chart.rate_Hz},
          {"verdict", zone_text(chart.stiffness_N_per_m, chart.own)}};
}

}  // namespace

std::string accuracy_json(const AccuracyResults& results) {
  Json knobs = Json::array();
  for (const KnobResult& result : results.knobs) knobs.push_back(knob_json(result));
  const Json json = {{"format", kAccuracyJsonFormat},
                     {"repeats", MeasurementEffort::kRepeats},
                     {"advice", advice_json(results.advice)},
                     {"scene", results.scene ? scene_json(*results.scene) : Json(nullptr)},
                     {"stiffness", stiffness_json(results.chart)},
                     {"knobs", knobs},
                     {"facts", facts_json(results.effort)}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace palpate
