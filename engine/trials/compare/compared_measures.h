#pragma once

// The measures by which strategies are compared.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "engine/trials/trial_row.h"

namespace palpate {

// Which of two values of a measure is the better one.
enum class Better : std::uint8_t {
  kLower,
  // The one nearer to 0: the magnitude of a trial's value is compared. For works and forces that
  // differ from those of a complete device in either direction.
  kNearerToZero
};

// The measure that is compared with the workspace, too.
inline constexpr std::string_view kTravelMeasure = "device travel";

struct ComparedMeasure {
  std::string_view name;    // "contact angle"
  std::string_view column;  // of trials.csv
  std::string_view unit;    // of the column; empty for counts
  std::string_view shown_unit;
  double shown_per_unit;  // a value of the column times this has the shown unit
  Better better;
};

// All of them, in the order of tables.
std::span<const ComparedMeasure> compared_measures();

// The value of a trial. The measure "timeouts" (column `status`) is 1 after a timeout and otherwise
// 0. Any other measure has no value unless the trial was completed.
std::optional<double> compared_value(const ComparedMeasure& measure, const TrialRow& row);

}  // namespace palpate
