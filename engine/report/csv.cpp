#include "engine/report/csv.h"

#include <array>
#include <charconv>
#include <cmath>

namespace palpate {
namespace {

constexpr int kSignificantDigits = 17;  // enough to restore every double

using NumberText = std::array<char, 32>;  // "-1.2345678901234567e-308" and shorter ones

}  // namespace

CsvLines::CsvLines(std::string_view columns) : text_(columns) {
  text_ += '\n';
}

CsvLines& CsvLines::raw(std::string_view field) {
  text_ += field;
  text_ += ',';
  return *this;
}

CsvLines& CsvLines::add(double value) {
  if (std::isnan(value)) return raw("nan");  // for either sign of NaN
  NumberText text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, kSignificantDigits);
  return raw({text.data(), end.ptr});
}

CsvLines& CsvLines::add_signed(std::int64_t value) {
  NumberText text;
  return raw({text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr});
}

CsvLines& CsvLines::add_unsigned(std::uint64_t value) {
  NumberText text;
  return raw({text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr});
}

CsvLines& CsvLines::add(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return raw(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return raw(quoted + "\"");
}

CsvLines& CsvLines::skip(int fields) {
  while (fields-- > 0) raw("");
  return *this;
}

void CsvLines::end_line() {
  text_.back() = '\n';
}

}  // namespace palpate
