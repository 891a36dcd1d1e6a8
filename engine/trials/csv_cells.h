#pragma once

// How the members of a row are written to the fields of a table and read from them (csv_table.h).

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "engine/trials/csv_table.h"
#include "engine/trials/strict_json.h"

namespace palpate {

// Which fields leave the member as it is.
enum class Blank : std::uint8_t { kNone, kEmpty, kEmptyOrNA };

struct FieldRule {
  std::string_view expected = {};  // empty: follows from the range or from the levels
  Blank blank = Blank::kNone;
  std::string_view hint = {};

  FieldError error(const std::string& otherwise) const {
    return {expected.empty() ? otherwise : std::string(expected), std::string(hint)};
  }
};

struct WholeRange {
  int least = std::numeric_limits<int>::min();
  int most = std::numeric_limits<int>::max();
};

bool is_blank(std::string_view field, Blank blank);
// The texts of columns.csv (Cell::values).
std::string values_text(std::string_view values, Blank blank);
std::string values_text(const WholeRange& range);
std::string values_text(const NumberRange& range, Blank blank);
std::string values_text(std::span<const std::string_view> names, Blank blank);
// The value of a field that is a number and nothing else; also nan and inf.
std::optional<double> number_in(std::string_view field);
std::optional<FieldError> read_whole(const std::string& field, const WholeRange& range, int& value);
// A name of 1 to kMostNameBytes bytes.
std::optional<FieldError> read_name(const std::string& field, std::string& name);

// The type of the value of a member, which may be optional.
template <class Member>
struct ValueOf {
  using Type = Member;
  static constexpr bool is_optional = false;
};
template <class Value>
struct ValueOf<std::optional<Value>> {
  using Type = Value;
  static constexpr bool is_optional = true;
};

// The cells of one kind of row. member: a pointer to a member, or a function (auto& row) -> auto&.
template <class Row>
struct CsvCells {
  // A std::string.
  template <class Member>
  static Cell<Row> name(Member member) {
    return {[member](const Row& row, CsvLines& lines) { lines.add(std::invoke(member, row)); },
            [member](const std::string& field, Row& row) {
              return read_name(field, std::invoke(member, row));
            },
            values_text("text", Blank::kNone)};
  }

  // An int, which may be optional.
  template <class Member>
  static Cell<Row> whole(Member member, WholeRange range = {}) {
    return {[member](const Row& row, CsvLines& lines) {
              write(std::invoke(member, row), lines, [&](int value) { lines.add(value); });
            },
            [member, range](const std::string& field, Row& row) {
              int value = 0;
              auto error = read_whole(field, range, value);
              if (!error) std::invoke(member, row) = value;
              return error;
            },
            values_text(range)};
  }

  // A number of any type, or an optional double. Without a range, nan is allowed.
  template <class Member>
  static Cell<Row> number(Member member, std::optional<NumberRange> range, FieldRule rule = {}) {
    const FieldError error = rule.error(text_of(range.value_or(NumberRange{})));
    const auto read = [member, range, blank = rule.blank, error](
                          const std::string& field, Row& row) -> std::optional<FieldError> {
      if (is_blank(field, blank)) return std::nullopt;
      const std::optional<double> value = number_in(field);
      if (!value || (range && !range->contains(*value))) return error;
      auto& to = std::invoke(member, row);
      to = static_cast<value_of<decltype(to)>>(*value);
      return std::nullopt;
    };
    return {[member](const Row& row, CsvLines& lines) {
              write(std::invoke(member, row), lines, [&](const auto& value) { lines.add(value); });
            },
            read, values_text(range.value_or(NumberRange{}), rule.blank)};
  }

  // The name of a level as a std::string; or its place as a number, an enumeration or an optional
  // number. The names must outlive the cell.
  template <class Member>
  static Cell<Row> level(Member member, std::span<const std::string_view> names,
                         FieldRule rule = {}) {
    const FieldError error = rule.error(joined_words({names.begin(), names.end()}));
    const auto read = [member, names, blank = rule.blank, error](
                          const std::string& field, Row& row) -> std::optional<FieldError> {
      if (is_blank(field, blank)) return std::nullopt;
      const auto found = std::find(names.begin(), names.end(), field);
      if (found == names.end()) return error;
      auto& to = std::invoke(member, row);
      using To = value_of<decltype(to)>;
      if constexpr (std::is_same_v<To, std::string>) {
        to = field;
      } else {
        to = static_cast<To>(found - names.begin());
      }
      return std::nullopt;
    };
    const auto add = [names](const auto& value, CsvLines& lines) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, std::string>) {
        lines.add(value);
      } else {
        lines.add(names[static_cast<std::size_t>(value)]);
      }
    };
    return {[member, add](const Row& row, CsvLines& lines) {
              write(std::invoke(member, row), lines, [&](const auto& value) { add(value, lines); });
            },
            read, values_text(names, rule.blank)};
  }

 private:
  template <class Reference>
  using value_of = typename ValueOf<std::remove_cvref_t<Reference>>::Type;

  template <class Member, class Add>
  static void write(const Member& member, CsvLines& lines, Add add) {
    if constexpr (!ValueOf<Member>::is_optional) {
      add(member);
    } else if (member) {
      add(*member);
    } else {
      lines.skip(1);
    }
  }
};

}  // namespace palpate
