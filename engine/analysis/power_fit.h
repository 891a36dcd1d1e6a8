#pragma once

// Whether the model of power_run.h fits a pilot.

#include <string>
#include <vector>

#include "engine/analysis/power_design.h"
#include "engine/analysis/power_pilot.h"

namespace palpate {

// The standard deviation over people of the difference between their means in a pair.
struct PilotPair {
  std::string pair;       // "H - UaH"
  double observed = 0.0;  // in the pilot; it has MS_pc's parts of this pair alone
  double model = 0.0;     // from the variances that are used, with the pilot's m
};

struct PilotFit {
  double f = 0.0;  // MS_pc / MS_e; by the model at least 1 on average. NaN: both are 0
  // P(F(df_pc, df_e) <= f): small if f is too low for the model. A person's scatter from object to
  // object, which the model lacks, makes it low.
  double p_below = 1.0;
  std::vector<PilotPair> pairs;

  bool is_too_low() const;  // at kSignificance
};

// tests: of the pilot's design.
PilotFit pilot_fit(const PilotEstimate& pilot, const PowerTests& tests);

}  // namespace palpate
