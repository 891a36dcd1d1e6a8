#pragma once

// Everything that a report of `accuracy` shows, as JSON for the program that draws the page.

#include <span>
#include <string>
#include <string_view>

#include "engine/accuracy/advice.h"
#include "engine/accuracy/measurement.h"
#include "engine/accuracy/scene_findings.h"
#include "engine/accuracy/stiffness_chart.h"

namespace palpate {

struct AccuracyResults {
  const Advice& advice;
  const MeasurementEffort& effort;
  std::span<const KnobResult> knobs;
  const SceneFindings* scene;  // null: no scene was measured
  const StiffnessChart& chart;
};

inline constexpr std::string_view kAccuracyJsonFormat = "palpate-accuracy-1";

// One object; docs/reference/files.md describes its members. Numbers are doubles with all digits,
// and null if they are not finite or were not measured. Texts from files are printable().
std::string accuracy_json(const AccuracyResults& results);

}  // namespace palpate
