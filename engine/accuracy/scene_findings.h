#pragma once

// The results for a user's own scene, as a table and as a text.

#include <optional>
#include <string>
#include <vector>

#include "engine/accuracy/scene_accuracy.h"
#include "engine/accuracy/surface_couplings.h"

namespace palpate {

// The stability limits of the loop's coupling at another rate.
struct LimitsAtRate {
  double rate_Hz = 0.0;
  StabilityLimits limits;
};

struct SceneFindings {
  std::string path;  // as given on the command line
  SceneAccuracy measured;
  DeviceDescription device;
  double rate_Hz = 0.0;  // of the servo loop, as set by the user
  std::vector<CouplingVerdict> verdicts;
  std::vector<LimitsAtRate> by_rate;
  std::string no_simplification;  // why the mesh was not simplified; empty if it was
};

// "mass 0.1 kg, damping 0.5 N s/m, ..."
std::string mechanics_text(const DeviceDescription& device);

// "delay at most 3.1 ms" or "without delay": the delay of the limits, wall_delay_s().
std::string delay_text(const DeviceDescription& device);

// A stiffness and its limit as texts, with as many digits as keep them in the order of the numbers.
struct ComparedTexts {
  std::string stiffness;
  std::string limit;
};
ComparedTexts passivity_texts(const CouplingVerdict& verdict);
ComparedTexts stability_texts(const CouplingVerdict& verdict);

// A table of the presets, the trials and the limits as CSV. Each line has the fields
// "what,name,quantity,value,unit".
std::string scene_csv(const SceneFindings& findings);

// A few lines for the terminal.
std::string scene_text(const SceneFindings& findings);

}  // namespace palpate
