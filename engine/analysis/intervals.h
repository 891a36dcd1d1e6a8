#pragma once

// Confidence intervals of means within participants, and of shares.

#include <span>

#include <Eigen/Core>

namespace palpate {

inline constexpr double kIntervalCoverage = 0.95;
inline constexpr double kSignificance = 0.05;

// Half widths of the 95 % intervals of the means of the columns, within participants. The
// differences between participants are removed from the values (Cousineau, 2005), and the variance
// is multiplied by k / (k - 1), where k is the number of columns (Morey, 2008). table: one row per
// participant, one column per condition. The result is NaN if there are fewer than two rows or
// columns.
Eigen::VectorXd cousineau_morey_half_widths(const Eigen::MatrixXd& table);

// The mean of a sample of normal values and half of its 95 % interval by Student's t.
struct MeanInterval {
  double mean = 0.0;        // NaN if count is 0
  double half_width = 0.0;  // NaN if count is below 2
  int count = 0;

  // Whether the interval does not hold 0; false without an interval.
  bool excludes_zero() const;
};
MeanInterval mean_interval(std::span<const double> values);

struct Interval {
  double low = 0.0, high = 0.0;
};

// Wilson's 95 % interval (1927) of the share count / all. From 0 to 1 if `all` is 0.
Interval wilson_interval(int count, int all);

}  // namespace palpate
