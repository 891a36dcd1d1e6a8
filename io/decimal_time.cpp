#include "io/decimal_time.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

namespace palpate {
namespace {

constexpr int kMostDigits = 30;
constexpr int kPowerOfNanosecond = 6;  // 1 ns = 10^6 fs
constexpr Int128 kTooLong_fs = Int128{1'000'000'000} * 1'000'000'000 * 1'000'000'000;

// Whether the text is a number in the grammar of from_chars(). The value may be out of the range of
// a double.
TimeTextKind kind_of(std::string_view text) noexcept {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (stop != end || code == std::errc::invalid_argument) return TimeTextKind::kNone;
  const bool is_finite = code == std::errc::result_out_of_range || std::isfinite(value);
  return is_finite ? TimeTextKind::kTime : TimeTextKind::kNotFinite;
}

struct Decimal {
  Int128 digits = 0;
  int power = 0;
  bool has_more = false;  // digits that are not 0 follow
};

Decimal decimal_of(std::string_view text) noexcept {
  Decimal d;
  int count = 0;
  bool is_fraction = false;
  std::size_t i = 0;
  for (; i < text.size() && text[i] != 'e' && text[i] != 'E'; ++i) {
    if (text[i] == '.') {
      is_fraction = true;
      continue;
    }
    const int digit = text[i] - '0';
    const bool is_kept = count < kMostDigits;
    if (is_kept) {
      d.digits = 10 * d.digits + digit;
      if (d.digits != 0) ++count;
    } else {
      d.has_more |= digit != 0;
    }
    if (is_kept && is_fraction) --d.power;
    if (!is_kept && !is_fraction) ++d.power;
  }
  if (i == text.size()) return d;
  std::string_view exponent = text.substr(i + 1);
  if (exponent.starts_with('+')) exponent.remove_prefix(1);
  // An exponent beyond the range of int: the number is 0 or too large with any such exponent.
  constexpr int kHuge = std::numeric_limits<int>::max() / 4;
  int value = 0;
  const auto read = std::from_chars(exponent.data(), exponent.data() + exponent.size(), value);
  if (read.ec == std::errc::result_out_of_range) value = exponent[0] == '-' ? -kHuge : kHuge;
  d.power += std::clamp(value, -kHuge, kHuge);
  return d;
}

}  // namespace

TimeText read_time(std::string_view text, TimeScale scale) noexcept {
  // from_chars() does not accept a plus sign.
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const TimeTextKind kind = kind_of(text);
  if (kind != TimeTextKind::kTime) return {kind};
  const bool is_negative = text.starts_with('-');
  Decimal d = decimal_of(text.substr(is_negative ? 1 : 0));
  Int128 fs = d.digits * scale.factor;
  int power = d.power + scale.power + kPowerOfNanosecond;
  if (fs == 0) power = 0;
  for (; power > 0; --power) {
    if (fs >= kTooLong_fs) return {TimeTextKind::kOutOfRange};
    fs *= 10;
  }
  bool has_rest = d.has_more;
  for (; power < 0 && fs != 0; ++power) {
    has_rest |= fs % 10 != 0;
    fs /= 10;
  }
  if (fs >= kTooLong_fs) return {TimeTextKind::kOutOfRange};
  if (!is_negative) return {TimeTextKind::kTime, fs};
  return {TimeTextKind::kTime, has_rest ? -fs - 1 : -fs};
}

std::int64_t nanoseconds_between(Int128 earlier_fs, Int128 later_fs) noexcept {
  const auto rounded = [](Int128 time_fs) {
    const Int128 shifted_fs = time_fs + kFemtosecondsPerNanosecond / 2;
    const bool is_below = shifted_fs % kFemtosecondsPerNanosecond < 0;
    return shifted_fs / kFemtosecondsPerNanosecond - (is_below ? 1 : 0);
  };
  const Int128 length_fs = later_fs - earlier_fs;
  const Int128 whole_ns = rounded(length_fs);
  const auto off_fs = static_cast<double>(length_fs - whole_ns * kFemtosecondsPerNanosecond);
  // Each of two additions is rounded by half of the last digit of a time, and so is each of two
  // printed numbers. In another unit, the last digit can be twice as large.
  constexpr double kSumDigits = 4.0;
  const double size_fs =
      std::max(std::abs(static_cast<double>(earlier_fs)), std::abs(static_cast<double>(later_fs)));
  const double sum_fs = kSumDigits * std::numeric_limits<double>::epsilon() * size_fs;
  const bool is_sum = sum_fs < 0.25 * kFemtosecondsPerNanosecond && std::abs(off_fs) <= sum_fs;
  const Int128 length_ns = is_sum ? whole_ns : rounded(later_fs) - rounded(earlier_fs);
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  return length_ns < kMost ? static_cast<std::int64_t>(length_ns) : kMost;
}

}  // namespace palpate
