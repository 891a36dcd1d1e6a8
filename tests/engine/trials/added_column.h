#pragma once

// A column that is added to a copy of a table by one line.

#include <string>

#include <gtest/gtest.h>

#include "engine/trials/csv_cells.h"
#include "engine/trials/csv_table.h"

namespace palpate::test {

// Expects the column in the first line, in columns.csv, and in the fields that are written, read
// and refused. row: a row that the table reads as it writes it.
template <class Row>
void expect_added_column_everywhere(CsvTable<Row> table, const Row& row) {
  const std::string names = names_in(table);
  double pressure_Pa = 0.25;
  table.columns.push_back(
      {"pressure_Pa", "Pa", "pressure of the \"hand\"", "", Presence::kRequired,
       CsvCells<Row>::number(
           [&](auto&) -> auto& { return pressure_Pa; }, NumberRange{0.0, 2.0})});
  EXPECT_EQ(names_in(table), names + ",pressure_Pa");
  const std::string text = columns_text(table);
  const std::string line = "\npressure_Pa,Pa,\"pressure of the \"\"hand\"\"\"";
  const std::string values = ",required,number 0..2\n";
  EXPECT_TRUE(text.ends_with(line + values) || text.ends_with(line + "," + values)) << text;

  CsvLines lines(names_in(table));
  write_row(table, row, lines);
  EXPECT_TRUE(lines.text().ends_with(",0.25\n")) << lines.text();
  pressure_Pa = 0.0;
  const auto rows = read_table(table, lines.text(), "t.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_EQ(pressure_Pa, 0.25);
  CsvLines again(names_in(table));
  write_row(table, rows->front(), again);
  EXPECT_EQ(again.text(), lines.text());

  std::string beyond = lines.text();
  beyond.replace(beyond.size() - 5, 4, "2.25");
  const auto refused = read_table(table, beyond, "t.csv");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().to_string(),
            "t.csv: line 2, column pressure_Pa: is \"2.25\"; expected a number from 0 to 2");
}

}  // namespace palpate::test
