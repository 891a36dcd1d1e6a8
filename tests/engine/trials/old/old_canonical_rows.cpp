#include "tests/engine/trials/old/old_canonical_rows.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "engine/trials/csv_reader.h"
#include "engine/trials/plan.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/quoted.h"
#include "io/gltf/file.h"

namespace palpate::old {
namespace {

constexpr std::array<std::string_view, 2> kRotationNames = {"NoR", "R"};
constexpr std::array<std::string_view, 2> kCanonicalMotionNames = {"pressed", "stroked"};

struct CanonicalColumn {
  std::string_view name;
  std::string_view unit;
  std::string_view meaning;
};

constexpr std::array<CanonicalColumn, 6> kCanonicalColumns = {{
    {"participant", "", "the number of the simulated operator"},
    {"angle_deg", "deg", "angle between the wall's normal and the motor's axis at the start"},
    {"motion", "",
     "pressed: the target goes to the press depth in 1 s and is held for 2 s; stroked: then it "
     "moves 100 mm along the wall as seen"},
    {"rotation", "", "R with A4, NoR without"},
    {"along_over_into", "1",
     "mean part of the commanded force along the wall, divided by its mean part along the wall's "
     "normal, over contact; empty without contact, if the latter is 0, or if a fault or an end of "
     "the wall ended the trial"},
    {"share_within_30deg", "1",
     "share of the contact with a contact angle of at most 30 deg; empty without contact, or if a "
     "fault or an end of the wall ended the trial"},
}};

std::string joined_canonical_columns() {
  std::string text;
  for (const CanonicalColumn& column : kCanonicalColumns) text.append(column.name).append(",");
  text.pop_back();
  return text;
}

void add_value(CsvLines& lines, const std::optional<double>& value) {
  if (value) {
    lines.add(*value);
  } else {
    lines.skip(1);
  }
}

// The fields of one line.
class CanonicalLine {
 public:
  CanonicalLine(const std::vector<std::string>& fields, std::size_t number)
      : fields_(fields), number_(number) {}

  Result<CanonicalRow> row() {
    CanonicalRow row;
    double participant = 0.0;
    std::size_t motion = 0, rotation = 0;
    const bool is_read = number(0, participant) && number(1, row.cell.angle_deg) &&
                         word(2, kCanonicalMotionNames, motion) &&
                         word(3, kRotationNames, rotation) && measure(4, row.along_over_into) &&
                         measure(5, row.share_within_30deg);
    if (!is_read) return *error_;
    row.participant = static_cast<int>(participant);
    row.cell.motion = static_cast<CanonicalMotion>(motion);
    row.cell.rotates = rotation == 1;
    return row;
  }

 private:
  bool refuse(std::size_t column, const std::string& expected) {
    error_ = Error{ErrorCode::kInvalidContent, "",
                   "line " + std::to_string(number_) + ", column " +
                       std::string(kCanonicalColumns[column].name),
                   "is " + in_quotes(fields_[column]) + "; expected " + expected, ""};
    return false;
  }
  bool number(std::size_t column, double& value) {
    const std::string& field = fields_[column];
    const char* const end = field.data() + field.size();
    const auto [stop, failed] = std::from_chars(field.data(), end, value);
    constexpr double kMost = 1e9;
    const bool is_number = failed == std::errc() && stop == end && value >= 0.0;
    return (is_number && (column != 0 || value <= kMost)) || refuse(column, "a number >= 0");
  }
  bool measure(std::size_t column, std::optional<double>& value) {
    double found = 0.0;
    if (fields_[column].empty()) return true;
    if (!number(column, found)) return false;
    value = found;
    return true;
  }
  bool word(std::size_t column, const std::array<std::string_view, 2>& words, std::size_t& place) {
    const auto found = std::find(words.begin(), words.end(), fields_[column]);
    place = static_cast<std::size_t>(found - words.begin());
    return found != words.end() ||
           refuse(column, std::string(words[0]) + " or " + std::string(words[1]));
  }

  const std::vector<std::string>& fields_;
  std::size_t number_;
  std::optional<Error> error_;
};

Result<std::vector<CanonicalRow>> parse_canonical_text(std::string_view text) {
  if (!text.starts_with(canonical_columns() + "\n")) {
    return Error{ErrorCode::kInvalidContent, "", "line 1",
                 "has other columns; expected " + canonical_columns(), ""};
  }
  CsvReader reader(text);
  std::vector<std::string> fields;
  [[maybe_unused]] const auto columns = reader.next(fields);
  std::vector<CanonicalRow> rows;
  for (;;) {
    const auto has_line = reader.next(fields);
    if (!has_line) return has_line.error();
    if (!*has_line) return rows;
    const std::size_t line = reader.line();
    if (fields.size() != kCanonicalColumns.size()) {
      return Error{ErrorCode::kInvalidContent, "", "line " + std::to_string(line),
                   "has " + std::to_string(fields.size()) + " fields; expected " +
                       std::to_string(kCanonicalColumns.size()),
                   ""};
    }
    auto row = CanonicalLine(fields, line).row();
    if (!row) return row.error();
    rows.push_back(*row);
  }
}

}  // namespace

const std::string& canonical_columns() {
  static const std::string text = joined_canonical_columns();
  return text;
}

void add_canonical_row(CsvLines& lines, const CanonicalRow& row) {
  lines.add(row.participant).add(row.cell.angle_deg);
  lines.add(kCanonicalMotionNames[static_cast<std::size_t>(row.cell.motion)]);
  lines.add(kRotationNames[row.cell.rotates ? 1 : 0]);
  add_value(lines, row.along_over_into);
  add_value(lines, row.share_within_30deg);
  lines.end_line();
}

std::string canonical_columns_csv() {
  CsvLines lines("name,unit,meaning");
  for (const CanonicalColumn& column : kCanonicalColumns) {
    lines.add(column.name).add(column.unit).add(column.meaning).end_line();
  }
  return lines.text();
}

Result<std::vector<CanonicalRow>> parse_canonical_rows(std::string_view text,
                                                       const std::string& path) {
  auto rows = parse_canonical_text(text);
  if (rows) return rows;
  Error error = rows.error();
  error.path = path;
  return error;
}

}  // namespace palpate::old
