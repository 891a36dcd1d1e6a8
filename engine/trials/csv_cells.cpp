#include "engine/trials/csv_cells.h"

#include <array>
#include <charconv>
#include <cmath>

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

std::string values_text(std::string_view values, Blank blank) {
  constexpr std::array<std::string_view, 3> kBehind = {"", " or empty", " or empty or NA"};
  return std::string(values).append(kBehind[static_cast<std::size_t>(blank)]);
}

// "number 0..", "number >0..10"
std::string values_text(const NumberRange& range, Blank blank) {
  const bool has_least = std::isfinite(range.least);
  const bool has_most = std::isfinite(range.most);
  std::string text = "number";
  if (has_least || has_most) {
    text += range.is_least_out ? " >" : " ";
    if (has_least) text += number_text(range.least);
    text += "..";
    if (has_most) text += number_text(range.most);
  }
  return values_text(text, blank);
}

std::string values_text(std::span<const std::string_view> names, Blank blank) {
  std::string text;
  for (const std::string_view name : names) text.append(text.empty() ? "" : "|").append(name);
  return values_text(text, blank);
}

bool is_blank(std::string_view field, Blank blank) {
  return (blank != Blank::kNone && field.empty()) || (blank == Blank::kEmptyOrNA && field == "NA");
}

std::string values_text(const WholeRange& range) {
  const WholeRange all;
  if (range.least == all.least && range.most == all.most) return "whole";
  return "whole " + std::to_string(range.least) + ".." + std::to_string(range.most);
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
