#pragma once

// `experiment export`: the trials of an experiment as a folder of Psych-DS.

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace palpate {

struct ExperimentExportRequest {
  std::string folder;             // of `experiment live --out` or `experiment run --out`
  std::string out_dir;            // must not exist
  std::vector<std::string> with;  // of kExportParts, what only a request adds
};

// Adds the subcommand. The request must outlive `experiment`.
void add_export(CLI::App& experiment, ExperimentExportRequest& request);

// Returns the exit code. The folder appears when it is complete.
int run_export(const ExperimentExportRequest& request);

}  // namespace palpate
