#pragma once

// The texts of a folder of Psych-DS 1.5.0, a layout for data sets of behaviour
// (https://psych-ds.github.io): a description with each column, and names of files.

#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/csv_table.h"

namespace palpate {

inline constexpr std::string_view kPsychDsVersion = "1.5.0";

// A column of a table: name, unit, meaning, and the values as Cell::values states them.
struct DescribedColumn {
  std::string name, unit, meaning, values;
};

template <class Row>
std::vector<DescribedColumn> described_columns(const CsvTable<Row>& table) {
  std::vector<DescribedColumn> columns;
  for (const Column<Row>& column : table.columns) {
    columns.push_back(
        {std::string(column.name), std::string(column.unit), column.meaning, column.cell.values});
  }
  return columns;
}

// The text of dataset_description.json: a Dataset of schema.org with each column in
// variableMeasured, with its unit, range, levels and meaning. Columns of the same name are one.
std::string dataset_description(const std::string& name, const std::string& description,
                                const std::vector<DescribedColumn>& columns);

// "subject-01": numbers have at least two digits.
std::string psych_ds_subject(int subject);

// "subject-01_task-contour_data.csv". task: letters and digits.
std::string psych_ds_file(int subject, std::string_view task);

}  // namespace palpate
