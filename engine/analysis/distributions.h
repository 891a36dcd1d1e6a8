#pragma once

// Tail probabilities and quantiles of the distributions that the statistics need. An argument
// outside a distribution's domain (a NaN, degrees of freedom that are not positive) gives NaN.
// Thread-safe.

namespace palpate {

// P(F > f) for Fisher's F with df1 and df2 degrees of freedom, which need not be integers.
double f_upper_tail(double f, double df1, double df2);

// The f with P(F > f) = tail; tail in (0, 1).
double f_for_tail(double tail, double df1, double df2);

// P(|T| > |t|) for Student's t.
double t_two_sided(double t, double df);

// The t with P(|T| > t) = 1 - coverage; coverage in (0, 1).
double t_for_coverage(double coverage, double df);

// The z with P(|Z| > z) = 1 - coverage for the standard normal distribution.
double z_for_coverage(double coverage);

}  // namespace palpate
