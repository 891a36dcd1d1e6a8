#pragma once

// `experiment live`: a person takes part in an experiment.

#include <cstdint>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "engine/viewer/view_server.h"

namespace palpate {

struct ExperimentLiveRequest {
  std::string plan;
  std::optional<int> participant;  // a value, because it is required
  std::string out_dir = "experiment";
  std::string device;             // empty: a pointer of the page
  bool no_guard = false;          // see DeviceRequest
  bool without_realtime = false;  // as well
  std::string script;             // the name or the file of a simulated person; empty: a person
  bool is_pilot = false;
  std::optional<std::uint64_t> cpu;
  ServerSettings server;
};

// Adds the subcommand. The request must outlive `experiment`.
void add_live(CLI::App& experiment, ExperimentLiveRequest& request);

// Returns the exit code.
int run_live(const ExperimentLiveRequest& request);

}  // namespace palpate
