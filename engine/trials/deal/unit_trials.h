#pragma once

// The trials of a unit of a dealt run (dealt_run.h), one after the other: those that an earlier
// process has finished are taken from the journal of the unit, the others are computed.

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "engine/trials/deal/trial_journal.h"
#include "geometry/base/result.h"

namespace palpate {

class UnitTrials {
 public:
  // Without a journal: every trial is computed.
  UnitTrials() = default;
  // after_trial: called after each trial that was computed; false ends the unit without a result.
  UnitTrials(TrialJournal& journal, std::function<bool(std::uint64_t trial)> after_trial)
      : journal_(&journal), after_trial_(std::move(after_trial)) {}

  // Goes to the next trial of the unit. Returns its rows if it is finished, otherwise null.
  const std::string* next() {
    ++trial_;
    return journal_ ? journal_->rows_of(trial_) : nullptr;
  }
  // Keeps the rows of the present trial, which was computed. Returns whether the unit goes on.
  Result<bool> add(const std::string& rows) {
    if (!journal_) return true;
    if (auto error = journal_->add(trial_, rows)) return *error;
    return after_trial_(trial_);
  }

 private:
  TrialJournal* journal_ = nullptr;
  std::function<bool(std::uint64_t)> after_trial_;
  std::uint64_t trial_ = 0;  // counted from 1
};

}  // namespace palpate
