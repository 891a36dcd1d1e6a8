// The tables of csv_table.h, with trials.csv as the example.

#include "engine/trials/csv_table.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/trials/csv_reader.h"
#include "engine/trials/trials_file.h"
#include "tests/engine/trials/added_column.h"

namespace palpate {
namespace {

TrialRow row_of_a_person() {
  TrialRow row;
  row.participant = "Ann";
  row.block = 1;
  row.trial = 2;
  row.object = "star";
  row.strategy = "a4";
  row.measures[kTotalTime] = 0.5;
  return row;
}

TEST(AddedColumn, IsEverywhereInTrials) {
  test::expect_added_column_everywhere(trials_table(), row_of_a_person());
}

TEST(TrialsTable, WritesEachMeasureIntoItsOwnColumn) {
  for (std::size_t measure = 0; measure < kMeasureCount; ++measure) {
    TrialRow row = row_of_a_person();
    row.measures.fill({});
    row.measures[measure] = 0.25;
    CsvLines lines(trials_columns(TrialColumns::kStrategies));
    add_row(lines, row);
    CsvReader reader(lines.text());
    std::vector<std::string> names, fields;
    ASSERT_TRUE(reader.next(names).ok() && reader.next(fields).ok());
    ASSERT_EQ(fields.size(), names.size());
    const auto place = std::find(fields.begin(), fields.end(), "0.25") - fields.begin();
    EXPECT_EQ(names[static_cast<std::size_t>(place)], measure_names()[measure]);
    EXPECT_EQ(std::count(fields.begin(), fields.end(), "0.25"), 1);
  }
}

// A cell may use what is read before it, wherever its column is in the file.
TEST(TrialsTable, ReadsTheStatusBeforeTheMeasuresInAnyOrderOfColumns) {
  const auto rows = parse_trials(
      "total_time_s,strategy,status,object,rotation,haptic,block,participant\n"
      "nan,a4,timeout,star,,,1,Ann\n",
      "t.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_FALSE(rows->front().measures[kTotalTime].has_value());
  EXPECT_EQ(rows->front().strategy, "a4");
}

}  // namespace
}  // namespace palpate
