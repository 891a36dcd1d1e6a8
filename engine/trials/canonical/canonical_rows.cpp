#include "engine/trials/canonical/canonical_rows.h"

#include "engine/trials/csv_cells.h"
#include "engine/trials/levels.h"
#include "engine/trials/trials_file.h"
#include "io/gltf/file.h"

namespace palpate {
namespace {

using Row = CanonicalRow;
using Field = CsvCells<CanonicalRow>;

constexpr NumberRange kAtLeast0{0.0};
constexpr NumberRange kParticipants{0.0, 1e9};
constexpr FieldRule kNumber{"a number >= 0", Blank::kNone, {}};
constexpr FieldRule kMeasure{"a number >= 0", Blank::kEmpty, {}};

CsvTable<Row> make_canonical_table() {
  CsvTable<Row> table;
  table.columns = {
      {"participant", "", "the number of the simulated operator", "", Presence::kRequired,
       Field::number(&Row::participant, kParticipants, kNumber)},
      {"angle_deg", "deg", "angle between the wall's normal and the motor's axis at the start", "",
       Presence::kRequired,
       Field::number(
           [](auto& row) -> auto& { return row.cell.angle_deg; }, kAtLeast0, kNumber)},
      {"motion", "", meanings_of(kCanonicalMotionLevels, ": ", "; "), "", Presence::kRequired,
       Field::level(
           [](auto& row) -> auto& { return row.cell.motion; }, kCanonicalMotionNames)},
      {"rotation", "", rotation_meaning(), "", Presence::kRequired,
       Field::level(
           [](auto& row) -> auto& { return row.cell.rotates; }, kRotationNames)},
      {"along_over_into", "1",
       "mean part of the commanded force along the wall, divided by its mean part along the wall's "
       "normal, over contact; empty without contact, if the latter is 0, or if a fault or an end "
       "of "
       "the wall ended the trial",
       "", Presence::kRequired, Field::number(&Row::along_over_into, kAtLeast0, kMeasure)},
      {"share_within_30deg", "1",
       "share of the contact with a contact angle of at most 30 deg; empty without contact, or if "
       "a "
       "fault or an end of the wall ended the trial",
       "", Presence::kRequired, Field::number(&Row::share_within_30deg, kAtLeast0, kMeasure)},
  };
  table.other_columns = "has other columns; expected " + names_in(table);
  table.other_count = [](std::size_t found, std::size_t expected) {
    return "has " + std::to_string(found) + " fields; expected " + std::to_string(expected);
  };
  return table;
}

}  // namespace

const CsvTable<CanonicalRow>& canonical_table() {
  static const CsvTable<CanonicalRow> table = make_canonical_table();
  return table;
}

const std::string& canonical_columns() {
  static const std::string text = names_in(canonical_table());
  return text;
}

void add_canonical_row(CsvLines& lines, const CanonicalRow& row) {
  write_row(canonical_table(), row, lines);
}

std::string canonical_columns_csv() {
  return columns_text(canonical_table());
}

Result<std::vector<CanonicalRow>> parse_canonical_rows(std::string_view text,
                                                       const std::string& path) {
  if (!text.starts_with(canonical_columns() + "\n")) {  // not even as quoted names
    Error error = table_error("line 1", canonical_table().other_columns);
    error.path = path;
    return error;
  }
  return read_table(canonical_table(), text, path);
}

std::optional<Error> check_not_canonical(const std::string& path) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  const auto bytes =
      read_regular_file(path, kMostTrialsBytes, kByteOrderMark.size() + canonical_columns().size());
  if (!bytes) return std::nullopt;
  std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (!text.starts_with(canonical_columns())) return std::nullopt;
  return Error{ErrorCode::kInvalidContent, path, "line 1",
               "has the columns of canonical.csv; expected those of trials.csv",
               "canonical.html beside canonical.csv has its analysis"};
}

}  // namespace palpate
