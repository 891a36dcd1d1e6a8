#pragma once

// Starts the Python package palpate.analysis, which makes statistics, figures and pages from the
// tables that a command has written.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/report/output_files.h"
#include "geometry/base/result.h"

namespace palpate {

enum class PageEnd : std::uint8_t {
  kMade,
  kRefused,      // bad input
  kMissing,      // no interpreter has all packages
  kFailed,       // a fault of the package or of the machine
  kInterrupted,  // signal_flag() was set; the process has been killed
};

struct PageOutcome {
  PageEnd end = PageEnd::kMade;
  std::string text;                   // for the terminal
  std::vector<std::string> warnings;  // lines without "palpate: warning: "
  // Of kRefused, kMissing and kFailed: one line that states the problem and what to do.
  std::string problem;
};

// Runs `python3 -P -m palpate.analysis COMMAND --out=FOLDER ...`, where FOLDER is the hidden folder
// of the files, and waits for its end. arguments: the command, then options as `--name=value`, then
// `--` and files: a name that begins with a dash is no option. The package writes files of the
// names that `files` has; the caller moves them into place.
//
// The interpreter is PALPATE_PYTHON, or else the first of `python3` in PATH and /usr/bin/python3
// that has all packages. Option -P and the threads of BLAS (one) do not depend on the environment.
// The process ends with this program, also if this program is killed.
PageOutcome make_page(const std::vector<std::string>& arguments, const OutputFiles& files);

// For a command of which the page was all that was asked for: prints what the outcome says, moves
// the files into place if it is kMade, and returns the exit code.
int finish_page(const PageOutcome& outcome, OutputFiles& files);

// For a command that has measured: the warnings of the command with those of the outcome. A page
// that is missing is one of them.
std::vector<std::string> with_page_warnings(std::vector<std::string> warnings,
                                            const PageOutcome& outcome);

// For a command that has measured, and whose measured files are complete: makes the page beside
// them, and moves all of them into place together. Without a page, the measured files alone are
// moved, and former files of page_names are removed. If the outcome is kInterrupted, nothing is
// moved. page_names: the files that the page may have; names of `files`.
Result<PageOutcome> place_with_page(const std::vector<std::string>& arguments,
                                    const std::vector<std::string>& page_names, OutputFiles& files);

}  // namespace palpate
