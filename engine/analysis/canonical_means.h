#pragma once

// Means of the canonical protocol over participants.

#include <array>
#include <optional>
#include <vector>

#include "engine/analysis/intervals.h"
#include "engine/trials/canonical/canonical_rows.h"

namespace palpate {

// The measures of a row, in the order of canonical.csv.
enum class CanonicalMeasure : std::uint8_t { kAlongOverInto, kShareWithin30deg };

const std::optional<double>& value_of(const CanonicalRow& row, CanonicalMeasure measure);

// The participants' mean of a measure under some conditions. The interval has no participant if
// none has a value.
struct CanonicalMean {
  CanonicalCell cell;
  MeanInterval interval;
};

// The means of all rows with this motion and rotation, by ascending angle.
std::vector<CanonicalMean> canonical_means(const std::vector<CanonicalRow>& rows,
                                           CanonicalMeasure measure, CanonicalMotion motion,
                                           bool rotates);

}  // namespace palpate
