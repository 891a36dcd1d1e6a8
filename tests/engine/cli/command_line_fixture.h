#pragma once

// The program as a user or a script runs it: exit codes, stdout, stderr and files. What the tests
// of several commands share.

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/engine/cli/run_program.h"
#include "tests/helpers/gltf_builder.h"

namespace palpate::test {

inline constexpr const char* kCube = PALPATE_MODELS_DIR "/cube.glb";

class CommandLine : public testing::Test {
 protected:
  // stdout_path: redirects stdout.
  Outcome call(std::vector<std::string> arguments, const std::string& stdout_path = {}) const;

  // Runs the program in a shell, as `palpate ... >&-`.
  Outcome call_with_output_closed(const std::vector<std::string>& arguments) const;

  // Bad arguments or input: code 2, nothing on stdout, one line on stderr with all of `names`.
  void expect_refused(const std::vector<std::string>& arguments,
                      const std::vector<std::string>& names) const;

  Outcome expect_done(const std::vector<std::string>& arguments, int exit_code = 0) const;
  // A run, comparable or not.
  Outcome expect_run(const std::vector<std::string>& arguments) const;
  // A run whose time is too short for the whole contour.
  Outcome expect_not_comparable(const std::vector<std::string>& arguments) const;

  // Into the star from the side, along it and out again.
  std::string write_path(const std::string& name = "path.txt") const;

  std::vector<std::string> replay(const std::vector<std::string>& more) const;

  TemporaryFolder folder;
};

std::vector<std::string> lines_of(const std::string& text);

// The rows of a trace as texts, without the header.
std::vector<std::vector<std::string>> rows_of(const std::string& csv);

// A trace without the columns of measured times.
std::string without_times(const std::string& csv);

// In alphabetical order.
std::vector<std::string> keys_of(const nlohmann::json& object);

std::vector<std::string> sorted(std::vector<std::string> texts);

// The keys that a replay and each run of `run` have in JSON.
extern const std::vector<std::string> kSummaryKeys;

}  // namespace palpate::test
