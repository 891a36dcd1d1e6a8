#include "engine/analysis/distributions.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

namespace policies = boost::math::policies;

// Errors are NaN, not exceptions. Double precision throughout: the same bits on every processor.
using Quiet = policies::policy<
    policies::domain_error<policies::ignore_error>, policies::pole_error<policies::ignore_error>,
    policies::overflow_error<policies::ignore_error>,
    policies::evaluation_error<policies::ignore_error>, policies::promote_double<false>>;
using FisherF = boost::math::fisher_f_distribution<double, Quiet>;
using StudentsT = boost::math::students_t_distribution<double, Quiet>;
using Normal = boost::math::normal_distribution<double, Quiet>;

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

bool is_coverage(double coverage) {
  return coverage > 0.0 && coverage < 1.0;
}

// Boost reports NaN arguments in several ways; here they are NaN.
bool are_degrees(double df) {
  return df > 0.0 && std::isfinite(df);
}

}  // namespace

double f_upper_tail(double f, double df1, double df2) {
  if (!(f >= 0.0) || !are_degrees(df1) || !are_degrees(df2)) return kUndefined;
  if (std::isinf(f)) return 0.0;
  return boost::math::cdf(boost::math::complement(FisherF(df1, df2), f));
}

double f_for_tail(double tail, double df1, double df2) {
  if (!is_coverage(tail) || !are_degrees(df1) || !are_degrees(df2)) return kUndefined;
  // F = (df2 / df1) x / (1 - x), where x has a beta distribution; rest is 1 - x without
  // cancellation.
  double rest = kUndefined;
  const double x = boost::math::ibetac_inv(0.5 * df1, 0.5 * df2, tail, &rest, Quiet());
  return df2 * x / (df1 * rest);
}

double t_two_sided(double t, double df) {
  if (std::isnan(t) || !are_degrees(df)) return kUndefined;
  if (std::isinf(t)) return 0.0;
  return 2.0 * boost::math::cdf(boost::math::complement(StudentsT(df), std::abs(t)));
}

double t_for_coverage(double coverage, double df) {
  if (!is_coverage(coverage) || !are_degrees(df)) return kUndefined;
  return boost::math::quantile(boost::math::complement(StudentsT(df), 0.5 * (1.0 - coverage)));
}

double z_for_coverage(double coverage) {
  if (!is_coverage(coverage)) return kUndefined;
  return boost::math::quantile(boost::math::complement(Normal(), 0.5 * (1.0 - coverage)));
}

}  // namespace palpate
