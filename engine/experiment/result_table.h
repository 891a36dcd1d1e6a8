#pragma once

// Tables of results for other programs, as CSV and as JSON.

#include <string>
#include <variant>
#include <vector>

namespace palpate {

// Nothing: the value is undefined, or does not apply. A number that is not finite is undefined too.
using ResultCell = std::variant<std::monostate, std::string, int, double>;

struct ResultTable {
  std::string name;  // of the file without ".csv", and of the key in JSON
  std::vector<std::string> columns;
  std::vector<std::vector<ResultCell>> rows;  // one cell a column
};

// With one line a row; undefined: an empty field.
std::string csv_of(const ResultTable& table);

// A JSON array with one object a row, whose keys are the columns; undefined: null. A number has as
// many digits as reading the same double back takes. indent: the spaces before each line.
std::string json_rows_of(const ResultTable& table, int indent);

}  // namespace palpate
