#pragma once

// `experiment power`: how many people an experiment needs.

#include <cstdint>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace palpate {

// What the options say. palpate.analysis.power gives their meaning, and checks what one option
// alone does not tell.
struct ExperimentPowerRequest {
  std::string measure = "time";
  std::string effects;  // "NoH-NoR=29, NoH-R=31, ...", each condition once; empty: the paper's
  std::string pilot;    // file of trials; empty: none
  std::string following;
  std::optional<double> error_sd;          // of one trial; no value: the paper's
  std::optional<double> share_u, share_w;  // of the variance of one trial; no value: a grid
  // Of a participant in a condition; no value: the pilot's, rounded, or the paper's without a
  // pilot.
  std::optional<int> trials;
  int participants = 60;  // the largest number
  int sets = 10'000;      // simulated data sets
  std::uint64_t seed = 2005;
  std::optional<int> jobs;  // threads; no value: the number of cores
  std::string out_dir = "power";
};

// Adds the subcommand. The request must outlive `experiment`.
void add_power(CLI::App& experiment, ExperimentPowerRequest& request);

// Returns the exit code.
int run_power(const ExperimentPowerRequest& request);

}  // namespace palpate
