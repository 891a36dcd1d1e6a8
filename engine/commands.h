#pragma once

// The subcommands of the program. Each returns the exit code: 0, 1 for a fault of ours, 2 for bad
// arguments or bad input, which is told in one line on stderr.

#include <string>

#include "engine/exploration.h"
#include "engine/run_options.h"

namespace palpate {

struct RunCommand {
  SceneOptions scene;
  RunOptions options;
  ExplorationSettings exploration;
  std::string out_dir = "out";
  bool json = false;
};

struct ReplayCommand {
  SceneOptions scene;
  std::string trajectory;
  RunOptions options;
  std::string trace;
  int repeat = 1;
  bool json = false;
};

struct InfoCommand {
  SceneOptions scene;
  bool list = false;  // the node tree instead
  bool json = false;
};

int run(const RunCommand& command);
int replay(const ReplayCommand& command);
int info(const InfoCommand& command);

}  // namespace palpate
