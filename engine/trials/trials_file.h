#pragma once

// trials.csv and columns.csv: what `palpate experiment run` writes and `analyse` reads.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/report/csv.h"
#include "engine/trials/csv_table.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"

namespace palpate {

// The largest file that is read. A row of a plan has at most 400 bytes (kMostTrials in plan.h).
inline constexpr std::uint64_t kMostTrialsBytes = std::uint64_t{1} << 28;
inline constexpr std::size_t kMostTrialRows = std::size_t{1} << 18;

// The kinds of files. What distinguishes their trials: haptic and rotation, or the strategy; or
// haptic and rotation in live trials.
enum class TrialColumns : std::uint8_t { kFactors, kStrategies, kLive };

// The columns of all kinds, for the reader: this list is all that a new column needs, apart from
// its member of TrialRow.
const CsvTable<TrialRow>& trials_table();

// The columns of such a file, for writing.
const CsvTable<TrialRow>& written_trials_table(TrialColumns columns);

// The columns of the measures, by MeasureIndex.
const std::array<std::string_view, kMeasureCount>& measure_names();

// The first line: following, participant, block, trial, haptic, rotation, object, attempt, status,
// then the measures, then view, align, start_orientation_deg and scale. With strategies, haptic and
// rotation are empty in every row; the measures from kPlainMeasureCount on are present, and
// `strategy` follows them. Live files have the members of LiveColumns after scale.
const std::string& trials_columns(TrialColumns columns = TrialColumns::kFactors);

// Appends a row, with the columns of kStrategies if it has a strategy, and with those of kLive if
// it has LiveColumns; not both. A measure without a value is an empty field; a measure has 17
// digits.
void add_row(CsvLines& lines, const TrialRow& row);

// The text of columns.csv: name, unit, meaning and the paper's name of each column of such a file.
// Levels that simulated trials do not have, of haptic and status, are only in live files.
std::string columns_csv(TrialColumns columns = TrialColumns::kFactors);
// The same of trials_table().
std::string all_columns_csv();

// Reads the rows of a file, of people or of simulated operators, in the order of the file. The
// format is RFC 4180 with lines that end in LF or CRLF; a byte order mark and blank lines are
// ignored.
//
// The columns participant, block, haptic, rotation, object and status are required. following,
// trial, attempt, strategy, view, align, start_orientation_deg and scale are optional, and so is
// each measure. An empty field or NA in the last four stands for turning, nearest, 0 and
// 1; the view must be the one of the following. A row has
// either a strategy or haptic and rotation. Other columns are ignored. An empty field or NA is a
// measure without a value; a trial that is not done may also have nan or inf there, which is read
// as no value. The columns of LiveColumns are optional; a row in which all are empty has no
// LiveColumns. A file with the column reason has one in each trial that was aborted or skipped, and
// in no other trial.
//
// Errors, with the line and the column: a zero byte, a quotation mark out of place, a missing or
// repeated column, a line with too few or too many fields, an unknown level, a field that is not a
// number, a measure that is not finite in a trial with the status done, a row whose following,
// participant, block, haptic, rotation, strategy, object, attempt, view, align,
// start_orientation_deg, scale and pilot occurred before, no row at all, and a file beyond the
// limits. The levels are those of levels.h; a following may be empty.
Result<std::vector<TrialRow>> read_trials(const std::string& path);

// The same for a text. path: for messages.
Result<std::vector<TrialRow>> parse_trials(std::string_view text, const std::string& path);

}  // namespace palpate
