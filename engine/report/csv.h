#pragma once

// Tables for other programs: comma-separated values (RFC 4180).

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

namespace palpate {

// Lines of a table, as text. Numbers have 17 significant digits, which give back the same double;
// decimals have a point in every locale; nan, inf and -inf stand for themselves. Text is quoted
// where it has to be; lines end with "\n".
class CsvLines {
 public:
  // columns: names joined by commas, the first line.
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

  // Those that are ended; nothing of the next one has been added.
  const std::string& text() const { return text_; }
  // The same, for whoever writes them out as they come. They are then none.
  void clear() { text_.clear(); }

 private:
  CsvLines& raw(std::string_view field);
  CsvLines& add_signed(std::int64_t value);
  CsvLines& add_unsigned(std::uint64_t value);

  std::string text_;
};

}  // namespace palpate
