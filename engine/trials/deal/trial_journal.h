#pragma once

// The finished trials of a unit of a dealt run (dealt_run.h) that is not complete yet. A process
// that is killed leaves them, and the next one goes on from there.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/deal/unit_part.h"
#include "geometry/base/result.h"

namespace palpate {

std::string journal_path(const std::string& folder, std::string_view noun, int unit);

// The units that have a journal in the folder, in ascending order.
std::vector<int> units_with_journals(const std::string& folder, std::string_view noun);

// A file to which each trial is appended when it has ended: a line with its number, its length and
// its hash, and its rows. The file does not exist before the first trial. Only one thread may use
// an object.
class TrialJournal {
 public:
  // Reads the file if it exists. What follows the last whole trial is cut off: a killed process or
  // a full disk may have left part of a trial there. Errors: the file is not a journal of this run
  // and unit, or cannot be read.
  static Result<TrialJournal> open(const std::string& path, const DealtUnits& units, int unit);

  TrialJournal(TrialJournal&& other) noexcept;
  TrialJournal& operator=(TrialJournal&&) = delete;
  ~TrialJournal();

  // The number of trials that open() has found.
  std::size_t count() const { return rows_.size(); }
  // The rows of a trial that open() has found, else null. trial: its place in the unit.
  const std::string* rows_of(std::uint64_t trial) const;
  // Appends a trial. After an error, the file has all earlier trials.
  std::optional<Error> add(std::uint64_t trial, std::string_view rows);
  // Removes the file. Call it when the trials are in the part of the unit.
  void remove();

 private:
  explicit TrialJournal(std::string path) : path_(std::move(path)) {}
  // Returns 0 or errno.
  int append(std::string_view text);

  std::string path_;
  std::string head_;         // the first lines, if the file does not have them yet
  std::uint64_t bytes_ = 0;  // of the file
  int descriptor_ = -1;      // for appending; -1: not open yet
  std::map<std::uint64_t, std::string> rows_;
};

}  // namespace palpate
