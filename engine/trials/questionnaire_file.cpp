#include "engine/trials/questionnaire_file.h"

#include <optional>

#include "engine/trials/csv_cells.h"

namespace palpate {
namespace {

using Row = QuestionnaireRow;
using Field = CsvCells<Row>;

constexpr WholeRange kValues{0, 100};

// The item is read before.
Cell<Row> value_on_its_scale() {
  const Cell<Row> whole = Field::whole(&Row::value, kValues);
  return {
      whole.write,
      [whole](const std::string& field, Row& row) -> std::optional<FieldError> {
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

CsvTable<Row> make_table() {
  CsvTable<Row> table;
  table.columns = {
      {"participant", "", "the person", "", Presence::kRequired, Field::name(&Row::participant)},
      {"haptic", "", "commanded force: " + meanings_of(kHapticLevels, " ", ", "), "",
       Presence::kRequired, Field::level(&Row::haptic, kHapticNames)},
      {"rotation", "", rotation_meaning(), "", Presence::kRequired,
       Field::level(&Row::rotation, kRotationNames)},
      {"item", "",
       "the question: tlx_mental, tlx_physical, tlx_temporal, tlx_performance, tlx_effort and "
       "tlx_frustration of NASA-TLX; real: how real the contacts felt",
       "", Presence::kRequired, Field::level(&Row::item, kQuestionnaireItemNames)},
      {"value", "1", "the answer: of tlx items 0 to 100 in steps of 5, of real 1 to 7", "",
       Presence::kRequired, value_on_its_scale()},
  };
  table.other_columns = "has other columns; expected " + names_in(table);
  table.other_count = [](std::size_t found, std::size_t expected) {
    return "has " + std::to_string(found) + " fields; expected " + std::to_string(expected) +
           ", as in the first line";
  };
  table.noun = "answer";
  table.description = [](const Row& row) {
    return "participant " + row.participant + ", " + row.haptic + ", " + row.rotation + ", " +
           std::string(kQuestionnaireItemNames[static_cast<std::size_t>(row.item)]);
  };
  table.key = table.description;
  table.repeated_hint = "remove one of the lines";
  return table;
}

}  // namespace

const CsvTable<QuestionnaireRow>& questionnaire_table() {
  static const CsvTable<QuestionnaireRow> table = make_table();
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

}  // namespace palpate
