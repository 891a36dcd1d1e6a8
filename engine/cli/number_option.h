#pragma once

// Numbers of the command line. CLI11's own conversion accepts octal and hexadecimal integers, "nan"
// and, in newer versions, digit separators; it clamps integers that are too large. Therefore no
// option with a number uses CLI11's conversion.

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>

#include <CLI/CLI.hpp>

#include "engine/session/number_range.h"
#include "geometry/base/result.h"

namespace palpate {

struct IntegerRange {
  std::uint64_t least = 0;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
};

// Accepts decimal digits only. The error states the range; its element is the option.
Result<std::uint64_t> parse_integer(const std::string& option, std::string_view text,
                                    const IntegerRange& range);

// Accepts a finite decimal number, with or without a point and an exponent, in every locale.
Result<double> parse_real(const std::string& option, std::string_view text,
                          const NumberRange& range);

template <typename T>
struct OptionValue {
  using Type = T;
};
template <typename T>
struct OptionValue<std::optional<T>> {
  using Type = T;
};

// Adds an option; `parse` converts its text, and the result is stored in `value`. If `value` is a
// std::optional, the option has no default.
template <typename T, typename Range, typename Parsed>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, T& value, const Range& range,
                        Result<Parsed> (*parse)(const std::string&, std::string_view, const Range&),
                        const char* type_name, const std::string& help) {
  const auto read = [&value, range, name, parse](const std::string& text) {
    const Result<Parsed> parsed = parse(name, text, range);
    if (!parsed) throw CLI::ValidationError(name, parsed.error().problem);
    value = static_cast<typename OptionValue<T>::Type>(*parsed);
  };
  CLI::Option* const option =
      app.add_option_function<std::string>(name, read, help)->type_name(type_name);
  if constexpr (std::is_same_v<T, typename OptionValue<T>::Type>) {
    std::ostringstream text;
    text << value;
    option->default_str(text.str());
  }
  return option;
}

// range: must lie within the range of T.
template <typename T>
CLI::Option* add_integer(CLI::App& app, const std::string& name, T& value,
                         const IntegerRange& range, const std::string& help) {
  return add_parsed(app, name, value, range, &parse_integer, "INTEGER", help);
}

template <typename T>
CLI::Option* add_real(CLI::App& app, const std::string& name, T& value, const NumberRange& range,
                      const std::string& help) {
  return add_parsed(app, name, value, range, &parse_real, "NUMBER", help);
}

}  // namespace palpate
