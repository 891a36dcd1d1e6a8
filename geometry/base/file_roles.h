#pragma once

// Which files the program reads and which ones it writes, so that no output replaces an input.

#include <optional>
#include <string>

#include "geometry/base/result.h"

namespace palpate {

// Two paths denote the same file if device and inode are equal, whatever links, "..", or capital
// letters they contain. Only regular files that exist have a role; pipes and devices have none. All
// functions are thread-safe, and do nothing before watch_file_roles().

// Call it once, at the start of a program that runs one command and ends. A library that serves
// many sessions may write over what an earlier one has read.
void watch_file_roles();

// The program reads this file. An error that names both files if it also writes it, or if standard
// output or standard error is redirected to it; that stream then leads to /dev/null, so that not
// even the error gets into the file.
std::optional<Error> add_input(const std::string& path);
std::optional<Error> add_input(int descriptor, const std::string& path);

// The program writes a file of this name, and may replace or remove a file that has this name now.
// An error that names both files if it is an input. A link and its target both count.
std::optional<Error> add_output(const std::string& path);

// While it lives, add_input() on this thread makes no file an input: for results of an earlier
// command, which the program reads in order to continue or replace them. A standard stream that is
// redirected to the file is an error as ever.
class OwnResultsScope {
 public:
  OwnResultsScope();
  ~OwnResultsScope();
  OwnResultsScope(const OwnResultsScope&) = delete;
  OwnResultsScope& operator=(const OwnResultsScope&) = delete;
};

}  // namespace palpate
