#include "engine/trials/questionnaire_file.h"

#include <optional>

#include "engine/trials/csv_cells.h"
#include "engine/trials/strict_json.h"
#include "engine/trials/trials_file.h"

namespace palpate {
namespace {

using Answer = CsvCells<QuestionnaireRow>;

constexpr WholeRange kValues{0, 100};
constexpr WholeRange kRatedBlocks{1, 1'000'000};  // practice is not rated

// The item is read before.
Cell<QuestionnaireRow> value_on_its_scale() {
  const Cell<QuestionnaireRow> whole = Answer::whole(&QuestionnaireRow::value, kValues);
  return {
      whole.write,
      [whole](const std::string& field, QuestionnaireRow& row) -> std::optional<FieldError> {
        if (auto error = whole.read(field, row)) return error;
        const QuestionnaireScale scale = scale_of(row.item);
        if (scale.contains(row.value)) return std::nullopt;
        return FieldError{"a whole number from " + std::to_string(scale.least) + " to " +
                          std::to_string(scale.most) +
                          (scale.step > 1 ? " in steps of " + std::to_string(scale.step) : "") +
                          ", because the item is " +
                          std::string(kQuestionnaireItemNames[static_cast<std::size_t>(row.item)])};
      },
      whole.values};
}

CsvTable<QuestionnaireRow> make_questionnaire_table() {
  CsvTable<QuestionnaireRow> table;
  table.columns = {
      {"participant", "", "the person", "", Presence::kRequired,
       Answer::name(&QuestionnaireRow::participant)},
      {"block", "", "the block, 1 for the first", "", Presence::kRequired,
       Answer::whole(&QuestionnaireRow::block, kRatedBlocks)},
      {"haptic", "", haptic_meaning(kHapticNames.size()), "", Presence::kRequired,
       Answer::level(&QuestionnaireRow::haptic, kHapticNames)},
      {"rotation", "", rotation_meaning(), "", Presence::kRequired,
       Answer::level(&QuestionnaireRow::rotation, kRotationNames)},
      {"item", "",
       "the question: tlx_mental, tlx_physical, tlx_temporal, tlx_performance, tlx_effort and "
       "tlx_frustration of NASA-TLX; real: how real the contacts felt",
       "", Presence::kRequired, Answer::level(&QuestionnaireRow::item, kQuestionnaireItemNames)},
      {"value", "1", "the answer: of tlx items 0 to 100 in steps of 5, of real 1 to 7", "",
       Presence::kRequired, value_on_its_scale()},
  };
  table.other_columns = "has other columns; expected " + names_in(table);
  table.other_count = [](std::size_t found, std::size_t expected) {
    return "has " + std::to_string(found) + " fields; expected " + std::to_string(expected) +
           ", as in the first line";
  };
  table.noun = "answer";
  table.description = [](const QuestionnaireRow& row) {
    return "participant " + row.participant + ", block " + std::to_string(row.block) + ", " +
           row.haptic + ", " + row.rotation + ", " +
           std::string(kQuestionnaireItemNames[static_cast<std::size_t>(row.item)]);
  };
  table.key = table.description;
  table.repeated_hint = "remove one of the lines";
  return table;
}

}  // namespace

const CsvTable<QuestionnaireRow>& questionnaire_table() {
  static const CsvTable<QuestionnaireRow> table = make_questionnaire_table();
  return table;
}

void add_questionnaire_row(CsvLines& lines, const QuestionnaireRow& row) {
  write_row(questionnaire_table(), row, lines);
}

std::string questionnaire_columns_csv() {
  return columns_text(questionnaire_table());
}

Result<std::vector<QuestionnaireRow>> parse_questionnaires(std::string_view text,
                                                           const std::string& path) {
  return read_table(questionnaire_table(), text, path);
}

Result<std::vector<QuestionnaireRow>> read_questionnaires(const std::string& path) {
  const auto text = read_settings_text(path, kMostTrialsBytes);
  if (!text) return text.error();
  return parse_questionnaires(*text, path);
}

}  // namespace palpate
