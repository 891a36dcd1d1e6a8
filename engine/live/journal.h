#pragma once

// The journal of one participant: an append-only file with all that happened, in order.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "geometry/base/result.h"

namespace palpate {

using JournalEntry = nlohmann::ordered_json;  // an object

inline constexpr std::uint64_t kMostJournalBytes = std::uint64_t{1} << 28;

// A line of the file is the hash of the line before it and of this entry (KeyHash, 16 hexadecimal
// digits), a blank and the entry as JSON. The first entry is the head, which states whose journal
// this is. A line is on the disk when add() returns. A process that is killed while it writes
// leaves a line without an end: open() cuts it off. Any other change of the file is refused.
//
// While an object lives, other processes cannot open the file (flock), where the file system has
// locks. Only one thread may use an object.
class Journal {
 public:
  // Opens the file, or creates it with this head. Errors: it is no journal, it has another head, a
  // line is not as it was written, another process has it open, or the system refuses.
  static Result<Journal> open(const std::string& path, const JournalEntry& head);
  // Reads a journal with any head, and opens nothing.
  static Result<std::vector<JournalEntry>> read(const std::string& path);

  // Whether a process has it open.
  static bool is_in_use(const std::string& path);

  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();

  // Those after the head.
  const std::vector<JournalEntry>& entries() const { return entries_; }
  // open() has cut off an incomplete line.
  bool was_cut() const { return was_cut_; }
  // Appends an entry. After an error the file has all earlier ones, and no part of this one.
  std::optional<Error> add(JournalEntry entry);
  const std::string& path() const { return path_; }

 private:
  explicit Journal(std::string path) : path_(std::move(path)) {}
  std::optional<Error> load(const JournalEntry& head);
  int append(std::string_view line);

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t bytes_ = 0;  // of whole lines
  std::string hash_;         // of the last line
  std::vector<JournalEntry> entries_;
  bool was_cut_ = false;
};

}  // namespace palpate
