#pragma once

// The subcommands of the program. Each returns the exit code: 0, 1 for a fault of ours, 2 for bad
// arguments or bad input, which one line on stderr names, 3 for a run that is not comparable, and
// 128 + the signal if one came.
//
// Files appear under their names together, when all of them are whole (output_files.h). SIGINT,
// SIGTERM and SIGHUP end a command at once while there is nothing to put in order; a run is ended
// in order, with what it did so far as its results.

#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/run_options.h"
#include "engine/simulation/exploration.h"

namespace palpate {

struct RunCommand {
  SceneOptions scene;
  RunOptions options;
  ExplorationSettings exploration;
  std::string out_dir = "out";
  bool json = false;
  std::vector<std::string> arguments;  // of the program, as they were given

  // Whether a run without A4, or with it, is asked for.
  bool wants(bool a4) const { return options.a4 == "compare" || (options.a4 == "on") == a4; }
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

struct AccuracyCommand {
  SceneOptions scene;  // of an empty path: none
  RunOptions options;
  std::vector<std::string> knobs;  // only these; empty: all
  bool quick = false;
  std::uint64_t seed = 1;
  std::string out_dir = "accuracy";
};

int run(const RunCommand& command);
int replay(const ReplayCommand& command);
int info(const InfoCommand& command);
int accuracy(const AccuracyCommand& command);

}  // namespace palpate
