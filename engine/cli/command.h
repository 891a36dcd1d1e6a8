#pragma once

// A subcommand of the program.

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace palpate {

// Files appear under their names together, when all of them are whole (output_files.h). SIGINT,
// SIGTERM and SIGHUP end a command at once while there is nothing to put in order; a run is ended
// in order, with what it did so far as its results.
class Command {
 public:
  virtual ~Command() = default;
  // Adds the subcommand with its options and its help. What is given comes into this object, which
  // must outlive the program.
  virtual CLI::App* add_to(CLI::App& program) = 0;
  // arguments: of the program, as they were given. Returns the exit code: 0, 1 for a fault of ours,
  // 2 for bad arguments or bad input, which one line on stderr names, 3 for a run that is not
  // comparable, and 128 + the signal if one came.
  virtual int run(const std::vector<std::string>& arguments) = 0;
};

}  // namespace palpate
