#pragma once

// canonical.csv and its columns.csv: what `palpate experiment run` writes for a canonical plan.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/report/csv.h"
#include "engine/trials/canonical/canonical_plan.h"
#include "engine/trials/csv_table.h"
#include "geometry/base/result.h"

namespace palpate {

struct CanonicalRow {
  int participant = 0;
  CanonicalCell cell;
  // See CanonicalMeasures. No value: undefined, or the trial is spoilt.
  std::optional<double> along_over_into;
  std::optional<double> share_within_30deg;
};

// The columns.
const CsvTable<CanonicalRow>& canonical_table();

// The first line: participant, angle_deg, motion, rotation, along_over_into, share_within_30deg.
const std::string& canonical_columns();

// Appends a row. A number has 17 digits; a measure without a value is an empty field.
void add_canonical_row(CsvLines& lines, const CanonicalRow& row);

// The text of columns.csv: name, unit and meaning of each column.
std::string canonical_columns_csv();

// Reads canonical.csv. The error names the line and the column. path: for messages.
Result<std::vector<CanonicalRow>> parse_canonical_rows(std::string_view text,
                                                       const std::string& path);

// An error if the file begins with canonical_columns(), so that it is no file of trials. A file
// that cannot be read is no error here.
std::optional<Error> check_not_canonical(const std::string& path);

}  // namespace palpate
