#pragma once

// What was measured on a user's own scene, for people and for other programs.

#include <optional>
#include <string>
#include <vector>

#include "engine/accuracy/accuracy_report.h"
#include "engine/accuracy/scene_accuracy.h"
#include "engine/accuracy/surface_couplings.h"

namespace palpate {

// Limits at another rate, for the coupling of the loop.
struct LimitsAtRate {
  double rate_Hz = 0.0;
  StabilityLimits limits;
};

struct SceneFindings {
  std::string path;  // as the user named it
  SceneAccuracy measured;
  DeviceDescription device;
  double rate_Hz = 0.0;  // of the servo loop, as given
  std::vector<CouplingVerdict> verdicts;
  std::vector<LimitsAtRate> by_rate;
  std::string no_simplification;  // why there is none; empty if there is one
};

ReportSection scene_section(const SceneFindings& findings);

// A table of the presets, the trials and the limits: "what,name,quantity,value,unit" a line.
std::string scene_csv(const SceneFindings& findings);

// A few lines for the terminal.
std::string scene_text(const SceneFindings& findings);

}  // namespace palpate
