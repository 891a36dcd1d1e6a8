#include "engine/analysis/statistics_text.h"

#include <array>
#include <charconv>
#include <cmath>

#include "engine/report/human_units.h"

namespace palpate {

std::string with_decimals(double value, int decimals) {
  if (std::isnan(value)) return "-";
  std::array<char, 400> text;  // the largest double has 309 digits before the point
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals);
  return std::string(text.data(), end.ptr);
}

std::string p_number(double p) {
  if (std::isnan(p)) return "-";
  if (p < 0.001) return "< 0.001";
  return with_decimals(p, p < 0.0995 ? 3 : 2);
}

std::string p_text(double p) {
  const std::string number = p_number(p);
  return number[0] == '<' ? "p " + number : "p = " + number;
}

std::string df_text(double df) {
  return with_decimals(df, std::abs(df - std::round(df)) < 0.05 ? 0 : 1);
}

std::string f_text(double f, double df1, double df2) {
  return "F(" + df_text(df1) + ", " + df_text(df2) + ") = " + number_or_dash(f);
}

std::string number_or_dash(double value) {
  return std::isnan(value) ? "-" : short_number(value);
}

}  // namespace palpate
