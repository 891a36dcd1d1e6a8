#include "io/text_fields.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "io/ascii.h"

namespace palpate {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

// Calls use(i, c) for each character outside of quotes and brackets, until it returns true.
template <typename Use>
void for_each_outside(std::string_view line, const Use& use) {
  bool is_in_quotes = false;
  int depth = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') is_in_quotes = !is_in_quotes;
    if (is_in_quotes) continue;
    if (c == '[' || c == '(' || c == '{') ++depth;
    if (depth > 0 && (c == ']' || c == ')' || c == '}')) --depth;
    if (depth == 0 && use(i, c)) return;
  }
}

bool has_outside(std::string_view line, char wanted) {
  bool found = false;
  for_each_outside(line, [&](std::size_t, char c) { return found = c == wanted; });
  return found;
}

TextField field_of(std::string_view text) {
  text = trimmed(text);
  if (text.size() < 2 || !text.starts_with('"') || !text.ends_with('"')) return {text, false};
  return {trimmed(text.substr(1, text.size() - 2)), true};
}

std::vector<TextField> split_at(std::string_view line, char separator) {
  std::vector<TextField> fields;
  std::size_t begin = 0;
  for_each_outside(line, [&](std::size_t i, char c) {
    if (c != separator) return false;
    fields.push_back(field_of(line.substr(begin, i - begin)));
    begin = i + 1;
    return false;
  });
  fields.push_back(field_of(line.substr(begin)));
  return fields;
}

std::vector<TextField> split_at_blanks(std::string_view line) {
  std::vector<TextField> fields;
  line = trimmed(line);
  for (bool more = !line.empty(); more;) {
    std::size_t end = line.size();
    for_each_outside(line, [&](std::size_t i, char c) {
      if (!is_blank(c) && c != ',') return false;
      end = i;
      return true;
    });
    fields.push_back(field_of(line.substr(0, end)));
    const std::string_view rest = trimmed(line.substr(end));
    const bool has_comma = rest.starts_with(',');
    line = has_comma ? trimmed(rest.substr(1)) : rest;
    more = has_comma || !line.empty();
  }
  return fields;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

Separator separator_of_header(std::string_view line) {
  if (has_outside(line, ';')) return Separator::kSemicolon;
  if (has_outside(trimmed(line), '\t')) return Separator::kTab;
  if (has_outside(line, ',')) return Separator::kComma;
  return Separator::kBlankOrComma;
}

Separator separator_of_row(std::string_view line, Separator of_header) {
  if (has_outside(line, ';')) return Separator::kSemicolon;
  const bool has_tab = has_outside(trimmed(line), '\t');
  if (of_header == Separator::kTab && has_tab) return Separator::kTab;
  if (of_header == Separator::kComma && has_outside(line, ',')) return Separator::kComma;
  if (!has_tab || line.find(' ') != std::string_view::npos) return Separator::kBlankOrComma;
  return has_ambiguous_comma(line) ? Separator::kTab : Separator::kBlankOrComma;
}

std::vector<TextField> split_fields(std::string_view line, Separator separator) {
  switch (separator) {
    case Separator::kComma:
      return split_at(line, ',');
    case Separator::kTab:
      return split_at(line, '\t');
    case Separator::kSemicolon:
      return split_at(line, ';');
    default:
      return split_at_blanks(line);
  }
}

bool has_ambiguous_comma(std::string_view line) {
  line = trimmed(line);
  bool has_decimal = false;
  bool has_bare_blank = false;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    if (line[i] == ',') has_decimal |= is_digit(line[i - 1]) && is_digit(line[i + 1]);
    if (!is_blank(line[i]) || is_blank(line[i - 1])) continue;
    const std::size_t next = line.find_first_not_of(" \t\r", i);
    has_bare_blank |= line[i - 1] != ',' && line[next] != ',';
  }
  return has_decimal && has_bare_blank;
}

Number parse_number(std::string_view field, int power) {
  // from_chars() does not accept a plus sign.
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  double value = 0.0;
  const char* end = field.data() + field.size();
  auto [stop, code] = std::from_chars(field.data(), end, value);
  if (stop != end || code == std::errc::invalid_argument) return {};
  const bool has_digits = std::any_of(field.begin(), field.end(), is_digit);
  if (power != 0 && has_digits) {
    // The power is added to the exponent, so that the number is rounded once.
    const std::size_t mark = std::min(field.find_first_of("eE"), field.size());
    std::string_view exponent = field.substr(std::min(mark + 1, field.size()));
    if (exponent.starts_with('+')) exponent.remove_prefix(1);
    long own = 0;
    const auto read = std::from_chars(exponent.data(), exponent.data() + exponent.size(), own);
    constexpr long kHuge = 1'000'000;  // beyond any exponent of a double
    if (read.ec == std::errc::result_out_of_range) own = exponent[0] == '-' ? -kHuge : kHuge;
    own = std::clamp(own, -kHuge, kHuge);
    const std::string moved =
        std::string(field.substr(0, mark)) + "e" + std::to_string(own + power);
    code = std::from_chars(moved.data(), moved.data() + moved.size(), value).ec;
  }
  if (code == std::errc::result_out_of_range) return {NumberKind::kOutOfRange};
  return {NumberKind::kNumber, value};
}

std::string with_decimal_point(std::string_view field) {
  std::string text(field);
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos || text.find('.') != std::string::npos) return {};
  text[comma] = '.';
  return parse_number(text).kind == NumberKind::kNone ? std::string() : text;
}

}  // namespace palpate
