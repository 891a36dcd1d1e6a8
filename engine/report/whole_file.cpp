#include "engine/report/whole_file.h"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include "engine/report/output_lock.h"
#include "engine/report/write_error.h"
#include "geometry/base/file_roles.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = 1u << 20;
constexpr int kMaxNameAttempts = 100;
constexpr int kMaxLinks = 40;  // as many as Linux follows
constexpr std::string_view kPartEnding = ".part";

// The writer locks the temporary file for as long as the writer is alive.
enum class PartLock { kMine, kAnothers, kNotSupported };

PartLock lock_part(int descriptor) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return PartLock::kMine;
  return errno == EWOULDBLOCK ? PartLock::kAnothers : PartLock::kNotSupported;
}

// Whether another process removed the file before it was locked.
bool has_lost_its_name(int descriptor) {
  struct stat status = {};
  return ::fstat(descriptor, &status) == 0 && status.st_nlink == 0;
}

bool is_part_of(const std::string& name, const std::string& target_name) {
  if (!name.starts_with(target_name + ".") || !name.ends_with(kPartEnding)) return false;
  const std::size_t begin = target_name.size() + 1;
  if (name.size() <= begin + kPartEnding.size()) return false;
  const std::string numbers = name.substr(begin, name.size() - begin - kPartEnding.size());
  return numbers.find_first_not_of("0123456789-") == std::string::npos;
}

// Whether a file that would be replaced, or the file of which it would be the log, is locked: the
// recorder and other programs that use SQLite lock their files so.
bool is_locked(std::string path) {
  for (const std::string_view log : {"-wal", "-shm", "-journal"}) {
    if (path.ends_with(log)) path.resize(path.size() - log.size());
  }
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return false;
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  const bool is_known = ::fcntl(descriptor, F_OFD_GETLK, &lock) == 0;
  ::close(descriptor);
  return is_known && lock.l_type != F_UNLCK;
}

// Removes temporary files that killed writers of this file have left. An error if one of them is an
// input of the program.
std::optional<Error> remove_leftovers(const std::string& target_path) {
  const fs::path target(target_path);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code failed;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    if (is_part_of(entry->path().filename().string(), target.filename().string())) {
      leftovers.push_back(entry->path());
    }
  }
  for (const fs::path& leftover : leftovers) {
    const int descriptor =
        ::open(leftover.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY);
    if (descriptor < 0) continue;
    struct stat status = {};
    const bool is_file = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    std::optional<Error> error;
    if (is_file && lock_part(descriptor) == PartLock::kMine) {
      error = add_output(leftover.string());
      if (!error) ::unlink(leftover.c_str());
    }
    ::close(descriptor);
    if (error) return error;
  }
  return std::nullopt;
}

}  // namespace

// The open file and the text not yet written to it.
class WholeFile::Output {
 public:
  explicit Output(std::string path) : path_(std::move(path)) {}
  ~Output() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!part_path_.empty()) ::unlink(part_path_.c_str());
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  const std::string& path() const { return path_; }

  std::optional<Error> open() {
    const int reason = find_target();
    if (reason != 0) return write_error(path_, reason);
    if (descriptor_ >= 0) return std::nullopt;  // not a regular file
    auto folder = OutputLock::take_for_file(target_path_);
    if (!folder) return folder.error();
    folder_ = std::move(*folder);
    if (is_locked(target_path_)) {
      return Error{ErrorCode::kFileUnwritable, path_, "",
                   "is in use: a command is writing or reading it, or the recording of which it "
                   "would be the log",
                   "wait until that command has ended, or choose another file"};
    }
    if (auto error = remove_leftovers(target_path_)) return error;
    if (const int failure = open_part()) return write_error(path_, failure);
    return std::nullopt;
  }

  void add(std::string_view text) {
    if (kBufferBytes - buffer_.size() < text.size()) flush();
    buffer_ += text;
  }

  // Returns 0 or errno, as do the functions below.
  int finish() {
    flush();
    // The duplicate keeps the lock until the file has its final name: another writer of the same
    // file would remove an unlocked temporary file as a leftover.
    const int lock = ::dup(descriptor_);
    const int closed = ::close(std::exchange(descriptor_, -1)) == 0 ? 0 : errno;
    if (failure_ == 0) failure_ = closed;
    if (failure_ == 0 && !part_path_.empty()) failure_ = rename_part();
    if (lock >= 0) ::close(lock);
    return failure_;
  }

 private:
  // Opens the path if it denotes, for example, a pipe, and otherwise finds the file to replace.
  int find_target() {
    if (path_.empty()) return ENOENT;
    std::error_code code;
    const fs::file_status status = fs::status(path_, code);
    if (fs::is_directory(status)) return EISDIR;
    if (fs::exists(status) && !fs::is_regular_file(status)) {
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
      return descriptor_ >= 0 ? 0 : errno;
    }
    return follow_links();
  }

  // Finds the target: a link is kept; the file to which it leads is replaced, or made.
  int follow_links() {
    fs::path target(path_);
    std::error_code code;
    for (int links = 0; fs::is_symlink(fs::symlink_status(target, code)); ++links) {
      if (links == kMaxLinks) return ELOOP;
      const fs::path next = fs::read_symlink(target, code);
      if (code) return code.value();
      target = target.parent_path() / next;  // `next`, if it is absolute
    }
    target_path_ = target.string();
    return 0;
  }

  int open_part() {
    for (int attempt = 0; attempt < kMaxNameAttempts; ++attempt) {
      std::string name = target_path_ + "." + std::to_string(::getpid()) + "-" +
                         std::to_string(attempt) + std::string(kPartEnding);
      descriptor_ = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ >= 0) {
        if (lock_part(descriptor_) != PartLock::kAnothers && !has_lost_its_name(descriptor_)) {
          part_path_ = std::move(name);
          return 0;
        }
        ::close(std::exchange(descriptor_, -1));  // another writer is removing it as a leftover
        continue;
      }
      if (errno != EEXIST) return errno;
    }
    return EEXIST;
  }

  int rename_part() {
    if (::rename(part_path_.c_str(), target_path_.c_str()) != 0) return errno;
    part_path_.clear();
    return 0;
  }

  void flush() {
    std::size_t written = 0;
    while (failure_ == 0 && written < buffer_.size()) {
      const ssize_t count =
          ::write(descriptor_, buffer_.data() + written, buffer_.size() - written);
      if (count >= 0) {
        written += static_cast<std::size_t>(count);
      } else if (errno != EINTR) {
        failure_ = errno;
      }
    }
    buffer_.clear();
  }

  std::string path_;         // as the caller named it
  std::string target_path_;  // final path of the file
  std::string part_path_;    // temporary path; empty: written directly
  OutputLock folder_;        // of the final path
  int descriptor_ = -1;
  int failure_ = 0;  // the first errno of a write
  std::string buffer_;
};

WholeFile::WholeFile(std::unique_ptr<Output> output) : output_(std::move(output)) {}
WholeFile::WholeFile(WholeFile&&) noexcept = default;
WholeFile& WholeFile::operator=(WholeFile&&) noexcept = default;
WholeFile::~WholeFile() = default;

Result<WholeFile> WholeFile::create(const std::string& path) {
  if (auto error = add_output(path)) return *error;
  auto output = std::make_unique<Output>(path);
  if (auto error = output->open()) return *error;
  return WholeFile(std::move(output));
}

void WholeFile::add(std::string_view text) {
  if (output_) output_->add(text);
}

std::optional<Error> WholeFile::finish() {
  if (!output_) {
    return Error{ErrorCode::kInvalidArgument, "", "", "the file is already complete", ""};
  }
  const std::unique_ptr<Output> output = std::move(output_);
  if (const int reason = output->finish()) return write_error(output->path(), reason);
  return std::nullopt;
}

}  // namespace palpate
