#pragma once

// sweep.csv: the means of each participant at each point of a sweep in each of the six conditions.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/report/csv.h"
#include "engine/trials/csv_table.h"
#include "engine/trials/sweep/sweep_points.h"
#include "engine/trials/trial_outcome.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"

namespace palpate {

// The measures of a sweep: those that the paper reports.
inline constexpr std::array<Outcome, 4> kSweepOutcomes = {
    Outcome::kTime, Outcome::kLosses, Outcome::kPenetration, Outcome::kContactAngle};

// A row. means: over the trials that ended at the red sphere; no value if there is none.
struct SweepRow {
  int point = 0;  // 1 for the first of sweep_points()
  SweepBlock block = SweepBlock::kBase;
  std::optional<std::size_t> varied;  // as in SweepPoint
  SweepValues values;
  int participant = 0;
  std::size_t haptic = 0;    // index into kHapticNames
  std::size_t rotation = 0;  // index into kRotationNames
  int trials = 0, done = 0, timeouts = 0, faults = 0;
  double limit_s = 0.0;                                            // the time of a timeout
  std::array<std::optional<double>, kSweepOutcomes.size()> means;  // in the order of kSweepOutcomes
};

// The columns.
const CsvTable<SweepRow>& sweep_table();

// The first line: point, block, parameter (that varies; empty in the other blocks), the parameters
// (empty: each participant has its own value), participant, haptic, rotation, trials, done,
// timeouts, faults, limit_s, and the measures with their names in trials.csv.
const std::string& sweep_columns();

// The rows of a point, by participant and condition, from its trials (trials.csv). limit_s: the
// time limit of these trials.
std::vector<SweepRow> sweep_rows(int number, const SweepPoint& point,
                                 std::span<const TrialRow> trials, double limit_s);
void add_sweep_row(CsvLines& lines, const SweepRow& row);

// The text of columns.csv: name, unit, meaning and values of each column.
std::string sweep_columns_csv();

// Reads sweep.csv as add_sweep_row() writes it. Errors, with the line and the column: any other
// content. path: for messages.
Result<std::vector<SweepRow>> parse_sweep_rows(std::string_view text, const std::string& path);

}  // namespace palpate
