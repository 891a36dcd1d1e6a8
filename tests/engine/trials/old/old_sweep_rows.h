#pragma once

// The reader and writer of sweep.csv before csv_table.h, to compare with.

#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/sweep/sweep_rows.h"

namespace palpate::old {

const std::string& sweep_columns();
void add_sweep_row(CsvLines& lines, const SweepRow& row);
Result<std::vector<SweepRow>> parse_sweep_rows(std::string_view text, const std::string& path);

}  // namespace palpate::old
