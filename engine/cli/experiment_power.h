#pragma once

// `experiment power`: how many people an experiment needs.

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "engine/analysis/power_study.h"

namespace palpate {

struct ExperimentPowerRequest {
  PowerRequest power;
  std::string out_dir = "power";
  std::optional<int> jobs;
};

// Adds the subcommand. The request must outlive `experiment`.
void add_power(CLI::App& experiment, ExperimentPowerRequest& request);

// Returns the exit code.
int run_power(const ExperimentPowerRequest& request);

}  // namespace palpate
