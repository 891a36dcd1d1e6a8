#pragma once

// Runs the program as a script does. Needs PALPATE_PROGRAM, the path of the program, and
// PALPATE_MODELS_DIR, the folder of the models.

#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <spawn.h>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/gltf_builder.h"

namespace palpate::test {

inline constexpr const char* kStar = PALPATE_MODELS_DIR "/star.glb";

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

// A program that was started.
struct StartedProgram {
  pid_t process = 0;
  std::string out;  // path of the file that receives stdout; empty if stdout is redirected
  std::string err;
};

// Starts the program in the folder. stdout_path: if not empty, stdout is redirected to this file.
// program: its path.
inline StartedProgram start_program(const TemporaryFolder& folder,
                                    std::vector<std::string> arguments,
                                    const std::string& stdout_path = {},
                                    const char* program = PALPATE_PROGRAM) {
  StartedProgram started{0, stdout_path.empty() ? folder.path("stdout") : "",
                         folder.path("stderr")};
  const std::string out = stdout_path.empty() ? started.out : stdout_path;
  arguments.insert(arguments.begin(), program);
  std::vector<char*> argv;
  for (std::string& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const int flags = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), flags, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, started.err.c_str(), flags, 0600);
  posix_spawn_file_actions_addchdir_np(&actions, folder.path().c_str());
  const int refused =
      posix_spawn(&started.process, program, &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  EXPECT_EQ(refused, 0);
  return started;
}

// Waits for the program to end. The outcome does not contain redirected output.
inline Outcome outcome_of(const StartedProgram& started) {
  int status = 0;
  EXPECT_EQ(waitpid(started.process, &status, 0), started.process);
  Outcome outcome;
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  if (!started.out.empty()) outcome.out = content_of(started.out);
  outcome.err = content_of(started.err);
  return outcome;
}

// Runs the program in the folder. stdout_path: if not empty, stdout is redirected to this file, and
// the outcome does not contain it.
inline Outcome run_program(const TemporaryFolder& folder, std::vector<std::string> arguments,
                           const std::string& stdout_path = {}) {
  return outcome_of(start_program(folder, std::move(arguments), stdout_path));
}

// While it lives, no file of a process that is started grows beyond this, as on a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limited{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limited);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
};

}  // namespace palpate::test
