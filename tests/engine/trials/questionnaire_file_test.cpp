// The file of what participants answered.

#include "engine/trials/questionnaire_file.h"

#include <array>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/engine/trials/added_column.h"

namespace palpate {
namespace {

const std::string kAnswersHeader = "participant,block,haptic,rotation,item,value\n";

TEST(QuestionnaireFile, RestoresEveryAnswerThatItsItemPermits) {
  CsvLines lines(names_in(questionnaire_table()));
  std::size_t count = 0;
  for (const auto& level : kQuestionnaireItemLevels) {
    const QuestionnaireScale scale = scale_of(level.value);
    for (int value = scale.least; value <= scale.most; value += scale.step, ++count) {
      add_questionnaire_row(lines,
                            {"P" + std::to_string(value), 2, "UaH", "NoR", level.value, value});
    }
  }
  EXPECT_EQ(count, 6u * 21u + 7u);
  ASSERT_TRUE(lines.text().starts_with(kAnswersHeader + "P0,2,UaH,NoR,tlx_mental,0\n"))
      << lines.text();
  const auto rows = parse_questionnaires(lines.text(), "q.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().to_string();
  EXPECT_EQ(rows->size(), count);
  CsvLines again(names_in(questionnaire_table()));
  for (const QuestionnaireRow& row : *rows) add_questionnaire_row(again, row);
  EXPECT_EQ(again.text(), lines.text());
}

// The lines of tests/engine/python/questionnaires_test.py are the same.
TEST(QuestionnaireFile, RefusesWhatItsItemDoesNotPermit) {
  const std::vector<std::array<std::string, 2>> broken = {
      {"1,1,NoH,R,tlx_effort,47",
       "line 2, column value: is \"47\"; expected a whole number from 0 to 100 in steps of 5, "
       "because the item is tlx_effort"},
      {"1,1,NoH,R,real,8",
       "line 2, column value: is \"8\"; expected a whole number from 1 to 7, because the item is "
       "real"},
      {"1,1,NoH,R,real,0",
       "line 2, column value: is \"0\"; expected a whole number from 1 to 7, because the item is "
       "real"},
      {"1,1,NoH,R,tlx_effort,105",
       "line 2, column value: is \"105\"; expected a whole number from 0 to 100"},
      {"1,1,NoH,R,tlx_effort,",
       "line 2, column value: is \"\"; expected a whole number from 0 to 100"},
      {"1,1,NoH,R,Real,4",
       "line 2, column item: is \"Real\"; expected tlx_mental, tlx_physical, tlx_temporal, "
       "tlx_performance, tlx_effort, tlx_frustration or real"},
      {"1,0,NoH,R,real,4",
       "line 2, column block: is \"0\"; expected a whole number from 1 to 1000000"},
      {"1,1,UaR,R,real,4",
       "line 2, column haptic: is \"UaR\"; expected NoH, UaH, H, seen-UaH or seen-H"},
      {"1,1,NoH,R,real", "line 2: has 5 fields; expected 6, as in the first line"},
      {"1,1,NoH,R,real,4\n1,1,NoH,R,real,5",
       "line 3: has the answer of line 2 again: participant 1, block 1, NoH, R, real; expected "
       "each answer "
       "once (remove one of the lines)"}};
  for (const auto& [lines, problem] : broken) {
    const auto rows = parse_questionnaires(kAnswersHeader + lines + "\n", "q.csv");
    ASSERT_FALSE(rows.ok()) << lines;
    EXPECT_EQ(rows.error().to_string(), "q.csv: " + problem);
  }
}

// The package reads a table by this copy.
TEST(QuestionnaireFile, HasTheColumnsThatPythonReads) {
  std::ifstream file(PALPATE_MODELS_DIR
                     "/../engine/python/palpate/analysis/experiment/questionnaire_columns.csv");
  EXPECT_EQ(questionnaire_columns_csv(), std::string(std::istreambuf_iterator<char>(file), {}));
}

TEST(AddedColumn, IsEverywhereInQuestionnaires) {
  test::expect_added_column_everywhere(
      questionnaire_table(), QuestionnaireRow{"Ann", 1, "H", "R", QuestionnaireItem::kReal, 4});
}

}  // namespace
}  // namespace palpate
