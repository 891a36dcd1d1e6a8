#include "engine/trials/deal/trial_journal.h"

#include <cerrno>
#include <charconv>
#include <fcntl.h>
#include <filesystem>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "engine/report/write_error.h"
#include "engine/report/write_whole.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/file_roles.h"
#include "io/gltf/file.h"

namespace palpate {
namespace {

constexpr std::string_view kJournalEnd = ".trials";

std::string journal_head(const DealtUnits& units, int unit) {
  return "palpate trials 1, run " + hash_text(units.identity) + ", " + units.noun + " " +
         std::to_string(unit) + "\n" + units.columns + "\n";
}

// The line above the rows of a trial.
std::string line_of_trial(std::uint64_t trial, std::string_view rows) {
  return "trial " + std::to_string(trial) + ", " + std::to_string(rows.size()) + " bytes, hash " +
         hash_text(KeyHash().add(trial).add(rows).value()) + "\n";
}

// Reads "WORD NUMBER" at the start of the text, and removes it.
std::optional<std::uint64_t> take_number(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return std::nullopt;
  std::uint64_t number = 0;
  const char* const begin = text.data() + word.size();
  const auto [end, failed] = std::from_chars(begin, text.data() + text.size(), number);
  if (failed != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

struct JournalEntry {
  std::uint64_t trial = 0;
  std::string_view rows;
  std::size_t bytes = 0;  // with its line
};

// The trial at the start of the text; no value if it is not whole.
std::optional<JournalEntry> entry_at(std::string_view text) {
  std::string_view rest = text;
  const auto trial = take_number(rest, "trial ");
  if (!trial) return std::nullopt;
  const auto length = take_number(rest, ", ");
  if (!length) return std::nullopt;
  const std::size_t line = text.find('\n');
  if (line == std::string_view::npos || text.size() - line - 1 < *length) return std::nullopt;
  const std::string_view rows = text.substr(line + 1, *length);
  if (text.substr(0, line + 1) != line_of_trial(*trial, rows)) return std::nullopt;
  return JournalEntry{*trial, rows, line + 1 + rows.size()};
}

}  // namespace

std::string journal_path(const std::string& folder, std::string_view noun, int unit) {
  return unit_file_path(folder, noun, unit, kJournalEnd);
}

std::vector<int> units_with_journals(const std::string& folder, std::string_view noun) {
  return units_with_files(folder, noun, kJournalEnd);
}

TrialJournal::TrialJournal(TrialJournal&& other) noexcept
    : path_(std::move(other.path_)),
      head_(std::move(other.head_)),
      bytes_(other.bytes_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      rows_(std::move(other.rows_)) {}

TrialJournal::~TrialJournal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<TrialJournal> TrialJournal::open(const std::string& path, const DealtUnits& units,
                                        int unit) {
  TrialJournal journal(path);
  const std::string head = journal_head(units, unit);
  journal.head_ = head;
  const OwnResultsScope own;
  const auto bytes = read_regular_file(path, kMostTrialsBytes);
  if (!bytes && bytes.error().code == ErrorCode::kFileNotFound) return journal;
  if (!bytes) return bytes.error();
  std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  if (!text.starts_with(head)) {
    // A process that was killed as it wrote the first lines has left a part of them.
    if (std::string_view(head).starts_with(text)) return journal;
    const std::string found(text.substr(0, std::min(text.find('\n'), head.find('\n'))));
    return Error{ErrorCode::kInvalidContent, path, "line 1",
                 "is \"" + found + "\"; expected \"" + head.substr(0, head.find('\n')) + "\"",
                 "move the file away: it has trials of another run"};
  }
  journal.head_.clear();
  journal.bytes_ = head.size();
  text.remove_prefix(head.size());
  while (const auto entry = entry_at(text)) {
    journal.rows_[entry->trial] = entry->rows;
    journal.bytes_ += entry->bytes;
    text.remove_prefix(entry->bytes);
  }
  return journal;
}

const std::string* TrialJournal::rows_of(std::uint64_t trial) const {
  const auto found = rows_.find(trial);
  return found == rows_.end() ? nullptr : &found->second;
}

int TrialJournal::append(std::string_view text) {
  if (descriptor_ < 0) {
    descriptor_ =
        ::open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NOCTTY, 0666);
    if (descriptor_ < 0) return errno;
    if (::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) return errno;
  }
  const int reason = write_whole(descriptor_, text, bytes_);
  if (reason == 0) bytes_ += text.size();
  return reason;
}

std::optional<Error> TrialJournal::add(std::uint64_t trial, std::string_view rows) {
  std::string text = head_ + line_of_trial(trial, rows);
  text += rows;
  if (const int reason = append(text)) {
    // A part of the trial would be cut off later; without it, the disk has more space.
    if (descriptor_ >= 0) {
      [[maybe_unused]] const int ignored = ::ftruncate(descriptor_, static_cast<off_t>(bytes_));
    }
    return write_error(path_, reason);
  }
  head_.clear();
  return std::nullopt;
}

void TrialJournal::remove() {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  ::unlink(path_.c_str());
}

}  // namespace palpate
