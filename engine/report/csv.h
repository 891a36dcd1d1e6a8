#pragma once

// Tables as comma-separated values (RFC 4180), for other programs to read.

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

// The lines of a table, as text. Numbers have 17 significant digits, so that reading them restores
// the same double; the decimal separator is a point in every locale; non-finite numbers are nan,
// inf and -inf. Text is quoted if necessary; lines end with "\n".
class CsvLines {
 public:
  // columns: the column names joined by commas, which become the first line.
  explicit CsvLines(std::string_view columns);

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
  CsvLines& skip(int fields);
  void end_line();

  // All lines so far. Call only after end_line().
  const std::string& text() const { return text_; }
  // Discards the lines, for a caller that has written them out.
  void clear() { text_.clear(); }

 private:
  CsvLines& raw(std::string_view field);
  CsvLines& add_signed(std::int64_t value);
  CsvLines& add_unsigned(std::uint64_t value);

  std::string text_;
};

}  // namespace palpate
