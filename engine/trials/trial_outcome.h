#pragma once

// The quantities of a trial that are analysed.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "engine/trials/trial_row.h"

namespace palpate {

// A quantity of a trial that is analysed.
enum class Outcome : std::uint8_t {
  kTime,
  kLosses,
  kPenetration,
  kLossesPerSecond,
  kLosses100ms,
  kContactAngle,
  kTimeToLimit  // the time, and the time limit for a trial with the status timeout
};
inline constexpr std::size_t kOutcomeCount = 7;

struct OutcomeText {
  std::string_view name;    // "total time"
  std::string_view unit;    // "s"; empty for counts
  std::string_view column;  // of trials.csv
};
const OutcomeText& outcome_text(Outcome outcome);

// The outcome of a row, if the row has it: a trial that was not completed has no outcome, except
// kTimeToLimit after a timeout.
std::optional<double> outcome_of(const TrialRow& row, Outcome outcome, double limit_s);

}  // namespace palpate
