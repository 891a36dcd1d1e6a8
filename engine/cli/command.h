#pragma once

// A subcommand of the program.

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace palpate {

// The result files of a command appear under their names together, when all are complete
// (output_files.h). SIGINT, SIGTERM and SIGHUP end a command at once as long as it has no results.
// They end a run after the current tick; the run then writes the results up to this tick.
class Command {
 public:
  virtual ~Command() = default;
  // Adds the subcommand with its options and its help. Parsing writes into this object, which must
  // outlive `program`.
  virtual CLI::App* add_to(CLI::App& program) = 0;
  // arguments: the arguments of the program, unchanged. Returns the exit code: 0 for success; 1 for
  // a fault of the program; 2 for bad arguments or bad input, reported in one line on stderr; 3 for
  // a run that is not comparable; 128 + the number of the signal after a signal.
  virtual int run(const std::vector<std::string>& arguments) = 0;
};

}  // namespace palpate
