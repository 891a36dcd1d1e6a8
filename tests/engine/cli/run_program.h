#pragma once

// Runs the program as a script does. Needs PALPATE_PROGRAM, the path of the program.

#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <spawn.h>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/gltf_builder.h"

namespace palpate::test {

// The results of one run of the program.
struct Outcome {
  int exit_code = -1;  // -1: ended by a signal
  std::string out;
  std::string err;
};

inline std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Runs the program in the folder. stdout_path: if not empty, stdout is redirected to this file, and
// the outcome does not contain it.
inline Outcome run_program(const TemporaryFolder& folder, std::vector<std::string> arguments,
                           const std::string& stdout_path = {}) {
  const std::string out = stdout_path.empty() ? folder.path("stdout") : stdout_path;
  const std::string err = folder.path("stderr");
  arguments.insert(arguments.begin(), PALPATE_PROGRAM);
  std::vector<char*> argv;
  for (std::string& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const int flags = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), flags, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), flags, 0600);
  posix_spawn_file_actions_addchdir_np(&actions, folder.path().c_str());
  pid_t child = 0;
  const int refused = posix_spawn(&child, PALPATE_PROGRAM, &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  EXPECT_EQ(refused, 0);
  int status = 0;
  waitpid(child, &status, 0);
  Outcome outcome;
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  if (stdout_path.empty()) outcome.out = content_of(out);
  outcome.err = content_of(err);
  return outcome;
}

}  // namespace palpate::test
