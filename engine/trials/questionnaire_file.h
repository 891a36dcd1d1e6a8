#pragma once

// questionnaires.csv: what participants answered after each condition of a block, which `palpate
// experiment analyse` compares if the file lies beside the trials.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/report/csv.h"
#include "engine/trials/csv_table.h"
#include "engine/trials/levels.h"
#include "geometry/base/result.h"

namespace palpate {

// The questions: the six scales of NASA-TLX, and how real the contacts felt.
enum class QuestionnaireItem : std::uint8_t {
  kMental,
  kPhysical,
  kTemporal,
  kPerformance,
  kEffort,
  kFrustration,
  kReal
};
inline constexpr ConditionLevels<QuestionnaireItem, 7> kQuestionnaireItemLevels = {
    {{"tlx_mental", "", QuestionnaireItem::kMental},
     {"tlx_physical", "", QuestionnaireItem::kPhysical},
     {"tlx_temporal", "", QuestionnaireItem::kTemporal},
     {"tlx_performance", "", QuestionnaireItem::kPerformance},
     {"tlx_effort", "", QuestionnaireItem::kEffort},
     {"tlx_frustration", "", QuestionnaireItem::kFrustration},
     {"real", "", QuestionnaireItem::kReal}}};
inline constexpr auto kQuestionnaireItemNames = names_of(kQuestionnaireItemLevels);
static_assert(are_in_order(kQuestionnaireItemLevels));

// The values that an item permits.
struct QuestionnaireScale {
  int least, most, step;

  bool contains(int value) const {
    return value >= least && value <= most && (value - least) % step == 0;
  }
};
inline constexpr QuestionnaireScale scale_of(QuestionnaireItem item) {
  return item == QuestionnaireItem::kReal ? QuestionnaireScale{1, 7, 1}
                                          : QuestionnaireScale{0, 100, 5};
}

// One answer.
struct QuestionnaireRow {
  std::string participant;
  int block = 1;
  std::string haptic;    // a name of kHapticLevels
  std::string rotation;  // a name of kRotationLevels
  QuestionnaireItem item = QuestionnaireItem::kMental;
  int value = 0;  // of scale_of(item)
};

// The columns: participant, block, haptic, rotation, item, value.
const CsvTable<QuestionnaireRow>& questionnaire_table();

// Appends a row. Lines begin with names_in(questionnaire_table()).
void add_questionnaire_row(CsvLines& lines, const QuestionnaireRow& row);

// The text of columns.csv: name, unit, meaning and values of each column.
std::string questionnaire_columns_csv();

// Reads the answers of a text with exactly these columns. Errors, with the line and the column:
// what read_trials() refuses of fields, a value that is not on the scale of its item, and a
// question that a participant answered twice after a condition of a block. path: for messages.
Result<std::vector<QuestionnaireRow>> parse_questionnaires(std::string_view text,
                                                           const std::string& path);

// The same of a file of at most kMostTrialsBytes.
Result<std::vector<QuestionnaireRow>> read_questionnaires(const std::string& path);

}  // namespace palpate
