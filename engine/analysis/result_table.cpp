#include "engine/analysis/result_table.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "engine/report/csv.h"

namespace palpate {
namespace {

bool is_defined(double value) {
  return std::isfinite(value);
}

void add_cell(CsvLines& lines, const ResultCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) {
    lines.add(*text);
  } else if (const auto* count = std::get_if<int>(&cell)) {
    lines.add(*count);
  } else if (const auto* value = std::get_if<double>(&cell); value && is_defined(*value)) {
    lines.add(*value);
  } else {
    lines.skip(1);
  }
}

nlohmann::ordered_json json_cell(const ResultCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* count = std::get_if<int>(&cell)) return *count;
  const auto* value = std::get_if<double>(&cell);
  if (value && is_defined(*value)) return *value;
  return nullptr;
}

}  // namespace

std::string csv_of(const ResultTable& table) {
  std::string columns;
  for (const std::string& column : table.columns) columns += (columns.empty() ? "" : ",") + column;
  CsvLines lines(columns);
  for (const auto& row : table.rows) {
    for (const ResultCell& cell : row) add_cell(lines, cell);
    lines.end_line();
  }
  return lines.text();
}

std::string json_rows_of(const ResultTable& table, int indent) {
  const std::string before(static_cast<std::size_t>(indent), ' ');
  std::string text = "[";
  for (const auto& row : table.rows) {
    nlohmann::ordered_json object;
    for (std::size_t i = 0; i < row.size(); ++i) object[table.columns[i]] = json_cell(row[i]);
    text += (text.size() == 1 ? "\n" : ",\n") + before + "  " +
            object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  }
  return text + (table.rows.empty() ? "]" : "\n" + before + "]");
}

}  // namespace palpate
