#include "geometry/base/file_roles.h"

#include <atomic>
#include <fcntl.h>
#include <map>
#include <mutex>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace palpate {
namespace {

using FileId = std::pair<dev_t, ino_t>;

struct FileRoles {
  std::mutex mutex;  // of the maps, which hold the paths as the program was given them
  std::map<FileId, std::string> inputs;
  std::map<FileId, std::string> outputs;
};

FileRoles& file_roles() {
  static FileRoles roles;
  return roles;
}

std::atomic<bool> are_roles_watched{false};
thread_local int own_results_scopes = 0;

std::optional<FileId> id_of(const struct stat& status) {
  if (!S_ISREG(status.st_mode)) return std::nullopt;
  return FileId(status.st_dev, status.st_ino);
}

std::optional<FileId> id_at(const std::string& path) {
  struct stat status = {};
  return ::stat(path.c_str(), &status) == 0 ? id_of(status) : std::nullopt;
}

constexpr const char* kHint = "choose another name or folder for the output";

Error output_is_input(const std::string& output, const std::string& input) {
  return {ErrorCode::kFileUnwritable, output, "",
          "is the same file as the input " + input + ", which the output would replace", kHint};
}

Error input_is_output(const std::string& input, const std::string& output) {
  return {ErrorCode::kFileUnwritable, input, "",
          "is an input, but the same file as " + output + ", which would replace it", kHint};
}

bool is_redirected_to(int descriptor, const FileId& file) {
  struct stat status = {};
  return ::fstat(descriptor, &status) == 0 && id_of(status) == file;
}

// What the program prints on this stream from now on is lost.
void discard_stream(int descriptor) {
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere < 0) {
    ::close(descriptor);
    return;
  }
  ::dup2(nowhere, descriptor);
  ::close(nowhere);
}

// An error if a standard stream is redirected to this file. Nothing is printed into the file
// afterwards, not even the error.
std::optional<Error> check_streams(const FileId& file, const std::string& path) {
  std::optional<Error> error;
  for (const auto& [descriptor, name] :
       {std::pair(STDOUT_FILENO, "standard output"), std::pair(STDERR_FILENO, "standard error")}) {
    if (!is_redirected_to(descriptor, file)) continue;
    discard_stream(descriptor);
    if (!error) error = input_is_output(path, name);
  }
  return error;
}

std::optional<Error> add_input(const struct stat& status, const std::string& path) {
  const auto file = id_of(status);
  if (!file) return std::nullopt;
  if (auto error = check_streams(*file, path)) return error;
  if (own_results_scopes > 0) return std::nullopt;
  FileRoles& roles = file_roles();
  const std::lock_guard lock(roles.mutex);
  const auto output = roles.outputs.find(*file);
  // An output that was replaced in the meantime may have left its inode to another file.
  if (output != roles.outputs.end() && id_at(output->second) == file) {
    return input_is_output(path, "the output " + output->second);
  }
  roles.inputs.try_emplace(*file, path);
  return std::nullopt;
}

}  // namespace

void watch_file_roles() {
  are_roles_watched.store(true);
}

std::optional<Error> add_input(const std::string& path) {
  struct stat status = {};
  if (!are_roles_watched.load() || ::stat(path.c_str(), &status) != 0) return std::nullopt;
  return add_input(status, path);
}

std::optional<Error> add_input(int descriptor, const std::string& path) {
  struct stat status = {};
  if (!are_roles_watched.load() || ::fstat(descriptor, &status) != 0) return std::nullopt;
  return add_input(status, path);
}

std::optional<Error> add_output(const std::string& path) {
  if (!are_roles_watched.load()) return std::nullopt;
  FileRoles& roles = file_roles();
  const std::lock_guard lock(roles.mutex);
  const auto file = id_at(path);
  if (!file) return std::nullopt;
  const auto input = roles.inputs.find(*file);
  if (input != roles.inputs.end()) return output_is_input(path, input->second);
  roles.outputs.try_emplace(*file, path);
  return std::nullopt;
}

OwnResultsScope::OwnResultsScope() {
  ++own_results_scopes;
}

OwnResultsScope::~OwnResultsScope() {
  --own_results_scopes;
}

}  // namespace palpate
