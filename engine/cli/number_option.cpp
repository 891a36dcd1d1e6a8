#include "engine/cli/number_option.h"

#include <charconv>
#include <cmath>
#include <system_error>

#include "geometry/base/printable.h"

namespace palpate {
namespace {

// The argument, shortened and without line breaks, for a message.
std::string quoted(std::string_view text) {
  constexpr std::size_t kMaxLength = 40;
  return "is \"" + printable(text.substr(0, kMaxLength)) +
         (text.size() > kMaxLength ? "...\"" : "\"") + "; expected ";
}

Error error_of(const std::string& option, const std::string& problem) {
  return {ErrorCode::kInvalidArgument, "", option, problem, ""};
}

std::string range_text(const NumberRange& range) {
  std::ostringstream text;
  text << "a finite number";
  const bool has_least = std::isfinite(range.least);
  if (has_least && std::isfinite(range.most)) {
    text << (range.is_least_out ? " above " : " from ") << range.least
         << (range.is_least_out ? " and at most " : " to ") << range.most;
  } else if (has_least) {
    text << (range.is_least_out ? " above " : " of at least ") << range.least;
  }
  return text.str();
}

}  // namespace

Result<std::uint64_t> parse_integer(const std::string& option, std::string_view text,
                                    const IntegerRange& range) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, failed] = std::from_chars(text.data(), end, value);
  if (failed == std::errc() && stop == end && value >= range.least && value <= range.most) {
    return value;
  }
  return error_of(option, quoted(text) + "a whole number from " + std::to_string(range.least) +
                              " to " + std::to_string(range.most) + ", in decimal digits");
}

Result<double> parse_real(const std::string& option, std::string_view text,
                          const NumberRange& range) {
  std::string_view digits = text;
  // from_chars refuses a plus sign.
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0.0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, failed] = std::from_chars(digits.data(), end, value);
  const bool is_in =
      value >= range.least && value <= range.most && !(range.is_least_out && value == range.least);
  if (failed == std::errc() && stop == end && std::isfinite(value) && is_in) return value;
  std::string problem = quoted(text) + range_text(range);
  if (failed == std::errc::result_out_of_range) problem += " within the range of a double";
  return error_of(option, problem);
}

}  // namespace palpate
