#pragma once

// The answers at the beginning of the report: the settings recommended for a device, and for a
// scene if one was measured. If several knobs have a recommendation for one setting, the advice
// states a single answer.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/accuracy/measurement.h"
#include "engine/accuracy/scene_findings.h"
#include "haptics/effects/virtual_coupling.h"
#include "palpate/device.h"

namespace palpate {

// One answer of the advice, in plain text. reason and limit are sentences.
struct Answer {
  std::string setting;  // "Rate"
  std::string value;    // "2 kHz"
  std::string reason;
  std::string limit;  // what limits the value, or the validity of the statement
};

struct Advice {
  // The settings.
  double rate_Hz = 1000.0;
  CouplingSettings coupling;            // including the velocity estimator of its damper
  std::size_t preset = kDefaultPreset;  // index into kAccuracyPresets

  // The same settings as texts for readers: rate, stiffness, damping, preset, velocity window,
  // mesh. The settings answer the question for the rate asked for, or else for the rate that the
  // knobs recommend; what this machine keeps is an answer of its own, behind the rate.
  std::string subject;  // "For this device and this scene"
  std::string device;   // "mass 0.1 kg, damping ..."
  std::string busy;     // a sentence, if other programs used the machine meanwhile
  std::vector<Answer> answers;
  // A command that applies the settings to a simulated device; it begins with AdviceInput::program.
  std::vector<std::string> command;
};

struct AdviceInput {
  std::span<const KnobResult> results;   // after reconcile()
  const SceneFindings* scene = nullptr;  // null: no scene was measured
  DeviceDescription device;
  CouplingSettings coupling;               // coupling of the loop: set by the user, or the default
  std::optional<double> rate_Hz = {};      // the rate that the user asks for; no value: none
  double others_cores = 0.0;               // cores_of_others() while it was measured
  std::vector<std::string> scene_options;  // for `palpate run`: the path, then scene options
  std::string program = "palpate";         // first word of the command
};

// The scene in Advice::command if no scene was measured: a model of this repository.
inline constexpr const char* kAdviceModel = "models/sphere.glb";

// If a knob was not measured, its setting keeps the default, and the reason states that. Returns
// the errors of stability_limits().
Result<Advice> advise(const AdviceInput& input);

// The shortest digits that give back the same number: "0.2", "2e-05".
std::string shortest_digits(double value);

// command_words(): the words of the command, each quoted for a shell. command_line(): the command
// as one line.
std::vector<std::string> command_words(const Advice& advice);
std::string command_line(const Advice& advice);

// A few lines for the terminal.
std::string advice_text(const Advice& advice);

}  // namespace palpate
