#pragma once

// Reads comma-separated values (RFC 4180) line by line.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/result.h"

namespace palpate {

// A line ends with LF, CRLF or the end of the text. A field may be quoted; a quoted field may
// contain commas, line ends and doubled quotation marks.
class CsvReader {
 public:
  // The text must outlive the reader.
  explicit CsvReader(std::string_view text) : rest_(text) {}

  // Reads the fields of the next line. False at the end of the text. Errors, whose element is the
  // line: a quotation mark out of place, or a carriage return that does not end a line.
  Result<bool> next(std::vector<std::string>& fields);

  // The number of the line in which the fields of the last next() begin, 1 for the first line.
  std::size_t line() const { return line_; }

 private:
  std::optional<Error> read_quoted(std::string& field);
  std::optional<Error> read_plain(std::string& field);
  Error refused(const std::string& problem) const;

  std::string_view rest_;
  std::size_t line_ = 0;
  std::size_t next_line_ = 1;
};

}  // namespace palpate
