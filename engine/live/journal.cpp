#include "engine/live/journal.h"

#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "engine/report/write_error.h"
#include "engine/report/write_whole.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/strict_json.h"

namespace palpate {
namespace {

constexpr std::size_t kHashDigits = 16;

std::string text_of_entry(const JournalEntry& entry) {
  return entry.dump(-1, ' ', false, JournalEntry::error_handler_t::replace);
}

std::string hash_after(const std::string& before, std::string_view text) {
  return hash_text(KeyHash().add(std::string_view(before)).add(text).value());
}

Error changed(const std::string& path, std::size_t line, std::string problem) {
  return {ErrorCode::kInvalidContent, path, "line " + std::to_string(line), std::move(problem),
          "restore the file from a backup: the program does not repair a journal"};
}

struct Lines {
  std::vector<JournalEntry> entries;  // with the head
  std::string hash;                   // of the last line
  std::uint64_t bytes = 0;            // of whole lines
};

// Reads whole lines. What follows the last line end was not written to its end.
Result<Lines> lines_of(std::string_view text, const std::string& path) {
  Lines lines;
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    const std::string_view line = text.substr(0, end);
    const std::size_t number = lines.entries.size() + 1;
    const std::string_view json = line.substr(std::min(line.size(), kHashDigits + 1));
    std::string hash = hash_after(lines.hash, json);
    if (json.empty() || line[kHashDigits] != ' ' || line.substr(0, kHashDigits) != hash) {
      return changed(path, number, "is not as it was written: its checksum does not fit");
    }
    JournalEntry entry = JournalEntry::parse(json, nullptr, /* allow_exceptions = */ false);
    if (!entry.is_object() || !entry.contains("kind") || !entry["kind"].is_string()) {
      return changed(path, number, "is no entry; expected a JSON object with a kind");
    }
    lines.entries.push_back(std::move(entry));
    lines.hash = std::move(hash);
    lines.bytes += end + 1;
    text.remove_prefix(end + 1);
  }
  return lines;
}

// The entry of a new file's name is on the disk only when that of its folder is.
void sync_folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int descriptor =
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

Journal::Journal(Journal&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      bytes_(other.bytes_),
      hash_(std::move(other.hash_)),
      entries_(std::move(other.entries_)),
      was_cut_(other.was_cut_) {}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<std::vector<JournalEntry>> Journal::read(const std::string& path) {
  const auto text = read_settings_text(path, kMostJournalBytes);
  if (!text) return text.error();
  auto lines = lines_of(*text, path);
  if (!lines) return lines.error();
  return std::move(lines->entries);
}

bool Journal::is_in_use(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return false;
  const bool is_locked = ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return is_locked;
}

Result<Journal> Journal::open(const std::string& path, const JournalEntry& head) {
  Journal journal(path);
  journal.descriptor_ =
      ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NOCTTY | O_NONBLOCK, 0600);
  if (journal.descriptor_ < 0) return write_error(path, errno);
  if (::flock(journal.descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return Error{ErrorCode::kFileUnwritable, path, "",
                 "is in use: another `experiment live` runs for this participant",
                 "end it first, or choose another participant"};
  }
  if (auto error = journal.load(head)) return *error;
  return journal;
}

std::optional<Error> Journal::load(const JournalEntry& head) {
  const auto text = read_settings_text(path_, kMostJournalBytes);
  if (!text) return text.error();
  auto lines = lines_of(*text, path_);
  if (!lines) return lines.error();
  bytes_ = lines->bytes;
  hash_ = lines->hash;
  // A line whose end alone is another byte was written whole.
  const std::string_view tail = std::string_view(*text).substr(bytes_);
  if (tail.size() > kHashDigits + 2 &&
      tail.substr(0, kHashDigits) ==
          hash_after(hash_, tail.substr(kHashDigits + 1, tail.size() - kHashDigits - 2))) {
    return changed(path_, lines->entries.size() + 1, "is not as it was written: it has no end");
  }
  was_cut_ = text->size() > bytes_;
  if (was_cut_ && ::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) {
    return write_error(path_, errno);
  }
  entries_ = std::move(lines->entries);
  if (entries_.empty()) {
    if (auto error = add(head)) return error;
    sync_folder_of(path_);
    entries_.clear();
    return std::nullopt;
  }
  if (entries_.front() != head) {
    return changed(path_, 1,
                   "is " + text_of_entry(entries_.front()) + "; expected " + text_of_entry(head));
  }
  entries_.erase(entries_.begin());
  return std::nullopt;
}

int Journal::append(std::string_view line) {
  if (const int reason = write_whole(descriptor_, line, bytes_)) return reason;
  return ::fdatasync(descriptor_) == 0 ? 0 : errno;
}

std::optional<Error> Journal::add(JournalEntry entry) {
  const std::string text = text_of_entry(entry);
  std::string hash = hash_after(hash_, text);
  const std::string line = hash + " " + text + "\n";
  if (const int reason = append(line)) {
    [[maybe_unused]] const int ignored = ::ftruncate(descriptor_, static_cast<off_t>(bytes_));
    return write_error(path_, reason);
  }
  bytes_ += line.size();
  hash_ = std::move(hash);
  entries_.push_back(std::move(entry));
  return std::nullopt;
}

}  // namespace palpate
