#pragma once

// `experiment sweep`: repeats the experiment with other assumptions about the hand.

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace palpate {

struct SweepRequest {
  std::string sweep;
  std::string out_dir = "sweep";
  std::string shard;
  std::optional<int> jobs;
};

// Adds the subcommand to `experiment`.
void add_sweep(CLI::App& experiment, SweepRequest& request);

// Runs it and returns the exit code.
int run_sweep_command(const SweepRequest& request);

}  // namespace palpate
