#pragma once

// The reader and writer of trials.csv before csv_table.h, to compare with.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "engine/report/csv.h"
#include "engine/trials/trial_row.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/result.h"

namespace palpate::old {

// A measure of a trial: its column in trials.csv.
struct TrialMeasure {
  std::string_view name;
  std::string_view unit;  // "1": dimensionless
  std::string_view meaning;
  std::string_view paper;  // the paper's name of the measure; empty: the paper does not have it
};

const std::array<TrialMeasure, kMeasureCount>& trial_measures();
const std::string& trials_columns(TrialColumns columns = TrialColumns::kFactors);
void add_row(CsvLines& lines, const TrialRow& row);
std::string columns_csv(TrialColumns columns = TrialColumns::kFactors);
Result<std::vector<TrialRow>> parse_trials(std::string_view text, const std::string& path);

}  // namespace palpate::old
