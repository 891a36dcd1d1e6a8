#pragma once

// Tables of results for other programs, as CSV and as JSON.

#include <string>
#include <variant>
#include <vector>

namespace palpate {

// monostate: the value is undefined, or does not apply. A number that is not finite is undefined
// too.
using ResultCell = std::variant<std::monostate, std::string, int, double>;

struct ResultTable {
  std::string name;  // of the file without ".csv", and of the key in JSON
  std::vector<std::string> columns;
  std::vector<std::vector<ResultCell>> rows;  // one cell a column
};

// CSV with one line per row. An undefined value is an empty field.
std::string csv_of(const ResultTable& table);

// A JSON array with one object per row. The keys of an object are the columns; an undefined value
// is null. A number has as many digits as are needed to read the same double back. indent: the
// spaces before each line.
std::string json_rows_of(const ResultTable& table, int indent);

}  // namespace palpate
