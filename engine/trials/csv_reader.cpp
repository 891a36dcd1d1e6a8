#include "engine/trials/csv_reader.h"

#include <algorithm>

namespace palpate {

Error CsvReader::refused(const std::string& problem) const {
  return {ErrorCode::kInvalidContent, "", "line " + std::to_string(line_), problem,
          "write comma-separated values as in RFC 4180"};
}

std::optional<Error> CsvReader::read_quoted(std::string& field) {
  rest_.remove_prefix(1);
  while (true) {
    const std::size_t mark = rest_.find('"');
    if (mark == std::string_view::npos) {
      return refused("has a quotation mark without its partner; expected two");
    }
    const std::string_view part = rest_.substr(0, mark);
    field += part;
    next_line_ += static_cast<std::size_t>(std::count(part.begin(), part.end(), '\n'));
    rest_.remove_prefix(mark + 1);
    if (!rest_.starts_with('"')) break;
    field += '"';
    rest_.remove_prefix(1);
  }
  if (rest_.empty() || rest_.starts_with(',') || rest_.starts_with('\n') ||
      rest_.starts_with("\r\n")) {
    return std::nullopt;
  }
  return refused(
      "has text behind a closing quotation mark; expected a comma or the end of the line");
}

std::optional<Error> CsvReader::read_plain(std::string& field) {
  const std::size_t end = std::min(rest_.find_first_of(",\n\r\""), rest_.size());
  field = rest_.substr(0, end);
  rest_.remove_prefix(end);
  if (rest_.starts_with('"')) {
    return refused("has a quotation mark within a field; expected a quoted field");
  }
  if (rest_.starts_with('\r') && !rest_.starts_with("\r\n")) {
    return refused(
        "has a carriage return within a field; expected LF or CRLF at the end of a line");
  }
  return std::nullopt;
}

Result<bool> CsvReader::next(std::vector<std::string>& fields) {
  fields.clear();
  if (rest_.empty()) return false;
  line_ = next_line_;
  while (true) {
    std::string& field = fields.emplace_back();
    if (auto error = rest_.starts_with('"') ? read_quoted(field) : read_plain(field)) return *error;
    if (!rest_.starts_with(',')) break;
    rest_.remove_prefix(1);
  }
  if (rest_.starts_with('\r')) rest_.remove_prefix(1);
  if (rest_.starts_with('\n')) rest_.remove_prefix(1);
  ++next_line_;
  return true;
}

}  // namespace palpate
