#pragma once

// The fields of a line of a text table.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

// What separates the fields of a line.
enum class Separator : std::uint8_t {
  kBlankOrComma,  // blanks, or a comma with or without blanks around it; a field between two commas
                  // may be empty
  kComma,         // commas alone: fields may contain blanks or be empty
  kTab,
  kSemicolon,
};

struct TextField {
  std::string_view text;  // without blanks at the ends and without quotes
  bool is_quoted = false;
};

// The separator of a header line: a semicolon, a tab or a comma outside of quotes and brackets, in
// this order, else blanks.
Separator separator_of_header(std::string_view line);

// The separator of a line of numbers in a table whose header has the separator `of_header`. Commas
// are decimal commas beside semicolons, and beside tabs that separate all fields.
Separator separator_of_row(std::string_view line, Separator of_header);

// Splits a line. Quotes (") around a field are removed. Separators in quotes or in brackets do not
// separate. kBlankOrComma: a name keeps the unit that follows it in brackets, after "/" or after
// "in".
std::vector<TextField> split_fields(std::string_view line, Separator separator);

// True if a comma between two digits could be a decimal comma as well as a separator: the line has
// fields that only blanks separate, too.
bool has_ambiguous_comma(std::string_view line);

std::string_view trimmed(std::string_view text);

// Text from a file, quoted and limited to one line of a message.
std::string field_in_quotes(std::string_view text);

enum class NumberKind : std::uint8_t { kNumber, kOutOfRange, kNone };

struct Number {
  NumberKind kind = NumberKind::kNone;
  double value = 0.0;
};

// Reads the nearest double of a decimal number times 10^power. nan and inf are numbers. A plus sign
// is allowed; nothing else than the number is. The decimal separator is a point in every locale.
Number parse_number(std::string_view field, int power = 0);

// A number with a decimal comma, such as "-1,5e3", with a point; empty for any other text.
std::string with_decimal_point(std::string_view field);

}  // namespace palpate
