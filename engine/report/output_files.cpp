#include "engine/report/output_files.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <string_view>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "engine/report/output_lock.h"
#include "geometry/base/file_roles.h"

namespace palpate {

// An open folder. A lock on it shows that the process that made the folder is alive; the lock ends
// with the process.
class FolderLock {
 public:
  enum class Outcome { kLocked, kHeldByAnother, kNotSupported };

  explicit FolderLock(const std::filesystem::path& folder)
      : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)) {}
  ~FolderLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  bool is_open() const { return descriptor_ >= 0; }

  Outcome lock() const {
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return Outcome::kLocked;
    return errno == EWOULDBLOCK ? Outcome::kHeldByAnother : Outcome::kNotSupported;
  }

 private:
  int descriptor_;
};

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHiddenPrefix = ".palpate-unfinished-";
constexpr std::string_view kHiddenRandom = "XXXXXX";  // the template of mkdtemp()
constexpr const char* kOld = "old";                   // subfolder for the previous files
constexpr int kMaxAttempts = 100;

Error folder_error(const std::string& folder, const std::string& problem) {
  return {ErrorCode::kFileUnwritable, folder, "`OutputFiles::folder`", problem,
          "name a folder that can be written to"};
}

std::string text_of(int reason) {
  return std::error_code(reason, std::generic_category()).message();
}

bool is_hidden_name(std::string_view name) {
  if (!name.starts_with(kHiddenPrefix)) return false;
  name.remove_prefix(kHiddenPrefix.size());
  return name.size() == kHiddenRandom.size() && std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
         });
}

// An error if a file anywhere in this folder is an input of the program.
std::optional<Error> check_holds_no_input(const fs::path& folder) {
  std::error_code failed;
  for (fs::recursive_directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    if (auto error = add_output(entry->path().string())) return error;
  }
  return std::nullopt;
}

// The hidden folders in this folder.
std::vector<fs::path> hidden_folders(const fs::path& folder) {
  std::error_code failed;
  std::vector<fs::path> hidden;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    if (is_hidden_name(entry->path().filename().string())) hidden.push_back(entry->path());
  }
  return hidden;
}

// Finds the hidden folders whose command is no longer alive. What they hold are outputs from now
// on: an error if the program has read one of them, and later if it reads one.
Result<std::vector<fs::path>> find_leftovers(const fs::path& folder) {
  std::vector<fs::path> leftovers;
  for (const fs::path& hidden : hidden_folders(folder)) {
    const FolderLock lock(hidden);
    if (!lock.is_open() || lock.lock() != FolderLock::Outcome::kLocked) continue;
    if (auto error = check_holds_no_input(hidden)) return *error;
    leftovers.push_back(hidden);
  }
  return leftovers;
}

// Removes the leftovers, unless a file in them has become an input in the meantime.
void remove_leftovers(const std::vector<fs::path>& leftovers) {
  for (const fs::path& leftover : leftovers) {
    const FolderLock lock(leftover);
    if (!lock.is_open() || lock.lock() != FolderLock::Outcome::kLocked) continue;
    if (check_holds_no_input(leftover)) continue;
    std::error_code ignored;
    fs::remove_all(leftover, ignored);
  }
}

bool is_there(const fs::path& path) {
  std::error_code failed;
  return fs::exists(fs::symlink_status(path, failed));
}

}  // namespace

struct OutputFiles::State {
  std::string folder;  // as the caller named it
  std::vector<std::string> names;
  OutputLock use;                      // keeps other commands out of the folder
  std::vector<fs::path> made_folders;  // outermost first
  fs::path hidden;                     // empty: not created yet, or removed
  OutputLock hidden_use;
  std::vector<fs::path> leftovers;  // hidden folders of commands that were killed

  State(std::string folder_given, std::vector<std::string> names_given)
      : folder(std::move(folder_given)), names(std::move(names_given)) {}
  ~State() {
    std::error_code ignored;
    if (!hidden.empty()) fs::remove_all(hidden, ignored);
    // A folder that another process has used in the meantime is not empty and is kept.
    for (auto made = made_folders.rbegin(); made != made_folders.rend(); ++made) {
      fs::remove(*made, ignored);
    }
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  fs::path place_of(const std::string& name) const { return fs::path(folder) / name; }
  // Makes the folder, and keeps other commands out of it.
  std::optional<Error> take_folder();
  std::optional<Error> make_folder();
  std::optional<Error> check_names() const;
  std::optional<Error> make_hidden_folder();
  int write_through() const;
  // Moves the existing files of these names from one folder to the other, in this order. Returns 0,
  // or errno of the first failure; `moved` receives the names of the moved files.
  static int move_all(const std::vector<std::string>& names, const fs::path& from,
                      const fs::path& to, std::vector<std::string>& moved);
};

std::optional<Error> OutputFiles::State::make_folder() {
  fs::path path;
  for (const fs::path& part : fs::path(folder)) {
    if (part.empty()) continue;  // after a trailing slash
    path /= part;
    if (::mkdir(path.c_str(), 0777) == 0) {
      made_folders.push_back(path);
      continue;
    }
    const int reason = errno;
    std::error_code failed;
    if (fs::is_directory(path, failed)) continue;
    const bool is_other = reason == EEXIST || reason == ENOTDIR;
    return folder_error(folder, path.string() + " cannot be created: " +
                                    (is_other ? "a file has this name" : text_of(reason)));
  }
  return std::nullopt;
}

std::optional<Error> OutputFiles::State::take_folder() {
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    if (auto error = make_folder()) return error;
    auto taken = OutputLock::take(folder, FolderUse::kAlone);
    if (!taken) return taken.error();
    use = std::move(*taken);
    if (use.is_at(folder)) return std::nullopt;
    made_folders.clear();  // another command has removed the folder that it had made
  }
  return folder_error(folder, "other commands make and remove it");
}

std::optional<Error> OutputFiles::State::check_names() const {
  for (const std::string& name : names) {
    if (auto error = add_output(place_of(name).string())) return error;
    std::error_code failed;
    const fs::file_status status = fs::symlink_status(place_of(name), failed);
    if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_symlink(status)) continue;
    return Error{ErrorCode::kFileUnwritable, place_of(name).string(), "",
                 "is not a file, but a result needs this name",
                 "move it, or choose another folder"};
  }
  return std::nullopt;
}

std::optional<Error> OutputFiles::State::make_hidden_folder() {
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    std::string pattern =
        place_of(std::string(kHiddenPrefix) + std::string(kHiddenRandom)).string();
    if (!::mkdtemp(pattern.data())) {
      return folder_error(folder, "cannot be written to: " + text_of(errno));
    }
    auto fresh = OutputLock::take(pattern, FolderUse::kAlone);
    if (!fresh || !fresh->is_at(pattern)) continue;  // another command removes it as a leftover
    hidden = pattern;
    hidden_use = std::move(*fresh);
    std::error_code failed;
    if (fs::create_directory(hidden / kOld, failed)) return std::nullopt;
    return folder_error(folder, "cannot be written to: " + failed.message());
  }
  return folder_error(folder, "other commands are writing there");
}

int OutputFiles::State::move_all(const std::vector<std::string>& names, const fs::path& from,
                                 const fs::path& to, std::vector<std::string>& moved) {
  for (const std::string& name : names) {
    if (!is_there(from / name)) continue;
    if (::rename((from / name).c_str(), (to / name).c_str()) != 0) return errno;
    moved.push_back(name);
  }
  return 0;
}

// Writes the files to the disk, so that a loss of power after the move leaves no empty file.
// Returns 0 or errno.
int OutputFiles::State::write_through() const {
  for (const std::string& name : names) {
    const int descriptor = ::open((hidden / name).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (descriptor < 0) continue;  // not written
    const int reason = ::fsync(descriptor) == 0 ? 0 : errno;
    ::close(descriptor);
    if (reason == EIO || reason == ENOSPC || reason == EDQUOT) return reason;
  }
  return 0;
}

OutputFiles::OutputFiles(std::unique_ptr<State> state) : state_(std::move(state)) {}
OutputFiles::OutputFiles(OutputFiles&&) noexcept = default;
OutputFiles& OutputFiles::operator=(OutputFiles&&) noexcept = default;
OutputFiles::~OutputFiles() = default;

Result<OutputFiles> OutputFiles::create(const std::string& folder, std::vector<std::string> names) {
  auto state = std::make_unique<State>(folder, std::move(names));
  if (auto error = state->take_folder()) return *error;
  if (auto error = state->check_names()) return *error;
  auto leftovers = find_leftovers(folder);
  if (!leftovers) return leftovers.error();
  state->leftovers = std::move(*leftovers);
  if (auto error = state->make_hidden_folder()) return *error;
  return OutputFiles(std::move(state));
}

void OutputFiles::pause() {
  std::error_code ignored;
  fs::remove_all(state_->hidden, ignored);
  state_->hidden.clear();
  state_->hidden_use = OutputLock();
}

std::optional<Error> OutputFiles::resume() {
  return state_->make_hidden_folder();
}

std::string OutputFiles::path(const std::string& name) const {
  assert(std::find(state_->names.begin(), state_->names.end(), name) != state_->names.end());
  return (state_->hidden / name).string();
}

std::string OutputFiles::hidden_folder() const {
  return state_->hidden.string();
}

Error OutputFiles::in_place(Error error) const {
  const std::string hidden = (state_->hidden / "").string();
  if (error.path.starts_with(hidden)) {
    error.path = state_->place_of(error.path.substr(hidden.size())).string();
  }
  return error;
}

std::optional<Error> OutputFiles::move_into_place() {
  State& s = *state_;
  // Again, because a file may have got its name while the command ran.
  if (auto error = s.check_names()) return error;
  if (const int reason = s.write_through()) {
    return folder_error(s.folder, "cannot be written to: " + text_of(reason));
  }
  const fs::path old = s.hidden / kOld;
  // The last name comes first and goes last: whenever the process is killed, the file of this name
  // is there only beside all others.
  const std::vector<std::string> last_first(s.names.rbegin(), s.names.rend());
  std::vector<std::string> aside;
  std::vector<std::string> placed;
  int reason = State::move_all(last_first, s.folder, old, aside);
  if (reason == 0) reason = State::move_all(s.names, s.hidden, s.folder, placed);
  if (reason != 0) {
    for (auto name = placed.rbegin(); name != placed.rend(); ++name) {
      ::unlink(s.place_of(*name).c_str());
    }
    for (auto name = aside.rbegin(); name != aside.rend(); ++name) {
      ::rename((old / *name).c_str(), s.place_of(*name).c_str());
    }
    return folder_error(s.folder, "results cannot be moved there: " + text_of(reason));
  }
  s.made_folders.clear();
  std::error_code ignored;
  fs::remove_all(s.hidden, ignored);
  s.hidden.clear();
  remove_leftovers(s.leftovers);  // not before all inputs are known
  return std::nullopt;
}

}  // namespace palpate
