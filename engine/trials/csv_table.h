#pragma once

// Tables of comma-separated values. The columns of a table are declared once, in one list. The
// first line, columns.csv, the writer and the strict reader follow from this list.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/report/csv.h"
#include "engine/trials/csv_reader.h"
#include "geometry/base/result.h"

namespace palpate {

// Why a field is refused.
struct FieldError {
  std::string expected;  // "a number of at least 0"
  std::string hint = {};
};

// How the field of a row is written and read (csv_cells.h).
template <class Row>
struct Cell {
  // Appends one field.
  std::function<void(const Row&, CsvLines&)> write;
  // Puts the value of a field into the row.
  std::function<std::optional<FieldError>(const std::string&, Row&)> read;
  // The values that are read, for columns.csv: `text`, `whole 0..9`, `number 0..`, `a|b|c`
  // (`a:0..9` is a name with a colon and a number behind it), with ` or empty` or
  // ` or empty or NA` behind them.
  std::string values = {};
};

enum class Presence : std::uint8_t {
  kRequired,
  kOptional  // a file with FirstLine::kByName may be without it
};

template <class Row>
struct Column {
  std::string_view name;
  std::string_view unit;  // "1": dimensionless; empty: no unit
  std::string meaning;
  std::string_view paper;  // the paper's name of the column; empty: the paper does not have it
  Presence presence = Presence::kRequired;
  Cell<Row> cell;
  // The fields of a lower turn are read first. Within a turn, they are read in the order of the
  // list. A cell may use the members of the row that are read before.
  int turn = 0;
};

enum class FirstLine : std::uint8_t {
  kExact,  // the names of all columns, in their order
  // The names of the required columns and of any others, in any order. Unknown columns are ignored,
  // as are a byte order mark and blank lines. A zero byte is an error, and so is a table without
  // rows.
  kByName
};

template <class Row>
struct CsvTable {
  std::vector<Column<Row>> columns;
  FirstLine first_line = FirstLine::kExact;
  // The problem of a first line with other columns; only for kExact.
  std::string other_columns;
  // The problem of a line with another number of fields.
  std::function<std::string(std::size_t found, std::size_t expected)> other_count;
  // A rule about several fields, which is checked when all fields up to this turn are read.
  std::function<std::optional<Error>(const Row&, std::size_t line)> rule;
  int rule_turn = 0;
  std::string noun = "row";  // what a row is
  std::size_t most_rows = std::numeric_limits<std::size_t>::max();
  // Two rows with the same key are refused by their description. Without a key, rows may repeat.
  std::function<std::string(const Row&)> key;
  std::function<std::string(const Row&)> description;
  std::string repeated_hint;
};

inline constexpr std::size_t kAbsentColumn = static_cast<std::size_t>(-1);

Error table_error(std::string element, std::string problem, std::string hint = {});
Error field_error(std::size_t line, std::string_view column, const std::string& found,
                  FieldError error);
// The text of a table with FirstLine::kByName.
Result<std::string_view> text_behind_mark(std::string_view text);
// The place of a column in the first line, or kAbsentColumn.
Result<std::size_t> place_by_name(const std::vector<std::string>& header, std::string_view name,
                                  Presence presence);

// The first line.
template <class Row>
std::string names_in(const CsvTable<Row>& table) {
  std::string text;
  for (const Column<Row>& column : table.columns) text.append(column.name).append(",");
  text.pop_back();
  return text;
}

template <class Row>
void write_row(const CsvTable<Row>& table, const Row& row, CsvLines& lines) {
  for (const Column<Row>& column : table.columns) column.cell.write(row, lines);
  lines.end_line();
}

// The text of columns.csv: name, unit, meaning, the paper's names if the paper has any, whether a
// file may be without the column, and the values (Cell).
template <class Row>
std::string columns_text(const CsvTable<Row>& table) {
  const bool has_paper = std::any_of(table.columns.begin(), table.columns.end(),
                                     [](const auto& column) { return !column.paper.empty(); });
  CsvLines lines(has_paper ? "name,unit,meaning,paper,presence,values"
                           : "name,unit,meaning,presence,values");
  for (const Column<Row>& column : table.columns) {
    lines.add(column.name).add(column.unit).add(column.meaning);
    if (has_paper) lines.add(column.paper);
    lines.add(column.presence == Presence::kRequired ? "required" : "optional");
    lines.add(column.cell.values).end_line();
  }
  return lines.text();
}

// Reads the rows of one text.
template <class Row>
class TableReader {
 public:
  // The arguments must outlive the reader.
  TableReader(const CsvTable<Row>& table, std::string_view text) : table_(table), text_(text) {
    for (std::size_t i = 0; i < table.columns.size(); ++i) order_.push_back(i);
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      return table.columns[a].turn < table.columns[b].turn;
    });
  }

  Result<std::vector<Row>> rows() {
    const bool is_by_name = table_.first_line == FirstLine::kByName;
    if (is_by_name) {
      const auto text = text_behind_mark(text_);
      if (!text) return text.error();
      text_ = *text;
    }
    CsvReader reader(text_);
    const auto has_header = reader.next(fields_);
    if (!has_header) return has_header.error();
    if (*has_header) {
      if (auto error = find_columns()) return *error;
    } else if (is_by_name) {
      return table_error("", "is empty; expected a line with the names of columns");
    }
    if (auto error = read_lines(reader)) return *error;
    if (is_by_name && rows_.empty()) {
      return table_error("", "has no " + table_.noun + "; expected a line for each " + table_.noun +
                                 " below the first line");
    }
    return std::move(rows_);
  }

 private:
  std::optional<Error> find_columns() {
    count_ = fields_.size();
    if (table_.first_line == FirstLine::kExact) {
      places_ = order_;
      std::sort(places_.begin(), places_.end());
      const bool is_same =
          std::equal(fields_.begin(), fields_.end(), table_.columns.begin(), table_.columns.end(),
                     [](const auto& name, const auto& of) { return name == of.name; });
      if (is_same) return std::nullopt;
      return table_error("line 1", table_.other_columns);
    }
    for (const Column<Row>& column : table_.columns) {
      const auto place = place_by_name(fields_, column.name, column.presence);
      if (!place) return place.error();
      places_.push_back(*place);
    }
    return std::nullopt;
  }

  std::optional<Error> read_lines(CsvReader& reader) {
    while (true) {
      const auto has_line = reader.next(fields_);
      if (!has_line) return has_line.error();
      if (!*has_line) return std::nullopt;
      const bool is_blank = fields_.size() == 1 && fields_.front().empty();
      if (is_blank && table_.first_line == FirstLine::kByName) continue;
      if (auto error = add_row(reader.line())) return error;
    }
  }

  std::optional<Error> add_row(std::size_t line) {
    const std::string element = "line " + std::to_string(line);
    if (fields_.size() != count_) {
      return table_error(element, table_.other_count(fields_.size(), count_));
    }
    if (rows_.size() == table_.most_rows) {
      return Error{ErrorCode::kLimitExceeded, "", element,
                   "is beyond the limit; expected at most " + std::to_string(table_.most_rows) +
                       " " + table_.noun + "s",
                   "divide the file"};
    }
    Row row;
    if (auto error = read_fields(line, row)) return error;
    if (table_.key) {
      const auto [first, is_new] = line_of_key_.try_emplace(table_.key(row), line);
      if (!is_new) {
        return table_error(element,
                           "has the " + table_.noun + " of line " + std::to_string(first->second) +
                               " again: " + table_.description(row) + "; expected each " +
                               table_.noun + " once",
                           table_.repeated_hint);
      }
    }
    rows_.push_back(std::move(row));
    return std::nullopt;
  }

  std::optional<Error> read_fields(std::size_t line, Row& row) const {
    bool is_rule_due = static_cast<bool>(table_.rule);
    for (const std::size_t i : order_) {
      const Column<Row>& column = table_.columns[i];
      if (is_rule_due && column.turn > table_.rule_turn) {
        if (auto error = table_.rule(row, line)) return error;
        is_rule_due = false;
      }
      if (places_[i] == kAbsentColumn) continue;
      const std::string& field = fields_[places_[i]];
      if (auto error = column.cell.read(field, row)) {
        return field_error(line, column.name, field, std::move(*error));
      }
    }
    return is_rule_due ? table_.rule(row, line) : std::nullopt;
  }

  const CsvTable<Row>& table_;
  std::string_view text_;
  std::vector<std::size_t> order_;   // of the columns, by turn
  std::vector<std::size_t> places_;  // of the columns, in a line
  std::size_t count_ = 0;            // of the fields of a line
  std::vector<std::string> fields_;
  std::vector<Row> rows_;
  std::map<std::string, std::size_t> line_of_key_;
};

// Reads the rows of a text. An error names the line and the column. path: for messages.
template <class Row>
Result<std::vector<Row>> read_table(const CsvTable<Row>& table, std::string_view text,
                                    const std::string& path) {
  auto rows = TableReader<Row>(table, text).rows();
  if (rows) return rows;
  Error error = rows.error();
  error.path = path;
  return error;
}

}  // namespace palpate
