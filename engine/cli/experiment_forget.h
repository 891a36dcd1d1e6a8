#pragma once

// `experiment forget`: removes what is known of a participant.

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace palpate {

struct ExperimentForgetRequest {
  std::string folder;
  std::optional<int> participant;  // a value, because it is required
};

// Adds the subcommand. The request must outlive `experiment`.
void add_forget(CLI::App& experiment, ExperimentForgetRequest& request);

// Returns the exit code.
int run_forget(const ExperimentForgetRequest& request);

}  // namespace palpate
