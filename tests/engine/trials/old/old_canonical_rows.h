#pragma once

// The reader and writer of canonical.csv before csv_table.h, to compare with.

#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/canonical/canonical_rows.h"

namespace palpate::old {

const std::string& canonical_columns();
void add_canonical_row(CsvLines& lines, const CanonicalRow& row);
std::string canonical_columns_csv();
Result<std::vector<CanonicalRow>> parse_canonical_rows(std::string_view text,
                                                       const std::string& path);

}  // namespace palpate::old
