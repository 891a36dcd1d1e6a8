#include "engine/trials/csv_cells.h"

#include <charconv>

#include "geometry/base/printable.h"

namespace palpate {
namespace {

template <class Number>
std::optional<Number> parsed_field(std::string_view field) {
  Number value{};
  const char* const end = field.data() + field.size();
  const auto [stop, failed] = std::from_chars(field.data(), end, value);
  if (failed != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::string text_of(const WholeRange& range) {
  const WholeRange all;
  if (range.least == all.least && range.most == all.most) return "a whole number";
  return "a whole number from " + std::to_string(range.least) + " to " + std::to_string(range.most);
}

}  // namespace

bool is_blank(std::string_view field, Blank blank) {
  return (blank != Blank::kNone && field.empty()) || (blank == Blank::kEmptyOrNA && field == "NA");
}

std::optional<double> number_in(std::string_view field) {
  return parsed_field<double>(field);
}

std::optional<FieldError> read_whole(const std::string& field, const WholeRange& range,
                                     int& value) {
  const std::optional<int> found = parsed_field<int>(field);
  if (!found || *found < range.least || *found > range.most) return FieldError{text_of(range)};
  value = *found;
  return std::nullopt;
}

std::optional<FieldError> read_name(const std::string& field, std::string& name) {
  // "Ann" and "Ann " would be two persons.
  const bool has_blanks = field.starts_with(' ') || field.ends_with(' ');
  if (field.empty() || field.size() > kMostNameBytes || has_blanks || printable(field) != field) {
    return FieldError{"a name of 1 to " + std::to_string(kMostNameBytes) +
                      " bytes in UTF-8, without blanks around it and control characters"};
  }
  name = field;
  return std::nullopt;
}

}  // namespace palpate
