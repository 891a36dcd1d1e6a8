#pragma once

// Writes tables as comma-separated values (RFC 4180), which other programs can read.

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

// Builds the lines of a table. A double is written with 17 significant digits, so that reading it
// restores the same double. The decimal separator is a point in every locale, and non-finite
// numbers are written as nan, inf and -inf. Quotation marks enclose a text that contains a comma, a
// quotation mark or a line break. Lines end with "\n".
class CsvLines {
 public:
  // columns: the first line, that is, the column names joined by commas.
  explicit CsvLines(std::string_view columns);

  // Each call of add() appends one field to the current line.
  CsvLines& add(double value);
  CsvLines& add(std::string_view text);
  CsvLines& add(const char* text) { return add(std::string_view(text)); }
  CsvLines& add(bool flag) { return raw(flag ? "1" : "0"); }
  template <std::integral Integer>
  CsvLines& add(Integer value) {
    if constexpr (std::signed_integral<Integer>) {
      return add_signed(value);
    } else {
      return add_unsigned(value);
    }
  }
  // Appends this many empty fields.
  CsvLines& skip(int fields);
  // Ends the current line, which must have at least one field.
  void end_line();

  // Returns all lines since the start or the last clear(). Call only after end_line().
  const std::string& text() const { return text_; }
  // Discards the lines. Call it after writing them to a file.
  void clear() { text_.clear(); }

 private:
  CsvLines& raw(std::string_view field);
  CsvLines& add_signed(std::int64_t value);
  CsvLines& add_unsigned(std::uint64_t value);

  std::string text_;
};

}  // namespace palpate
