#include "engine/trials/csv_table.h"

#include "geometry/base/quoted.h"

namespace palpate {

Error table_error(std::string element, std::string problem, std::string hint) {
  return {ErrorCode::kInvalidContent, "", std::move(element), std::move(problem), std::move(hint)};
}

Error field_error(std::size_t line, std::string_view column, const std::string& found,
                  FieldError error) {
  return table_error("line " + std::to_string(line) + ", column " + std::string(column),
                     "is " + in_quotes(found) + "; expected " + error.expected,
                     std::move(error.hint));
}

Result<std::string_view> text_behind_mark(std::string_view text) {
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    return table_error("byte " + std::to_string(zero), "is zero; expected text",
                       "save the table as comma-separated text in UTF-8");
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

Result<std::size_t> place_by_name(const std::vector<std::string>& header, std::string_view name,
                                  Presence presence) {
  const std::string element = "line 1, column " + std::string(name);
  const auto first = std::find(header.begin(), header.end(), name);
  if (first == header.end()) {
    if (presence != Presence::kRequired) return kAbsentColumn;
    const bool has_semicolons = header.size() == 1 && header[0].find(';') != std::string::npos;
    return table_error(element, "is missing; expected this column",
                       has_semicolons ? "separate the columns by commas, not by semicolons"
                                      : "the first line must have the names of the columns");
  }
  if (std::find(first + 1, header.end(), name) != header.end()) {
    return table_error(element, "is present more than once; expected once",
                       "remove or rename one of the columns");
  }
  return static_cast<std::size_t>(first - header.begin());
}

}  // namespace palpate
