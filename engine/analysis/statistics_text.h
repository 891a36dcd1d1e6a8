#pragma once

// Statistics as texts for readers.

#include <string>

namespace palpate {

// "0.012"; "< 0.001"; "-" for NaN.
std::string p_number(double p);
// "p = 0.012"; "p < 0.001".
std::string p_text(double p);
// "F(2, 18) = 12.3"; degrees of freedom that are not integers have one decimal.
std::string f_text(double f, double df1, double df2);
// Three digits; "-" for NaN.
std::string number_or_dash(double value);
// A number with this many decimals; "-" for NaN.
std::string with_decimals(double value, int decimals);
// "2", "1572.3"
std::string df_text(double df);

}  // namespace palpate
