#pragma once

// Confidence intervals of means within participants, and of shares.

#include <Eigen/Core>

namespace palpate {

inline constexpr double kIntervalCoverage = 0.95;
inline constexpr double kSignificance = 0.05;

// Half widths of the 95 % intervals of the columns' means, within participants: of values without
// the differences between participants (Cousineau, 2005), with Morey's correction (2008) of their
// variance by k / (k - 1), k columns. table: one row a participant, one column a condition. NaN
// with fewer than two rows or columns.
Eigen::VectorXd cousineau_morey_half_widths(const Eigen::MatrixXd& table);

struct Interval {
  double low = 0.0, high = 0.0;
};

// Wilson's 95 % interval (1927) of a share: `count` of `all`. From 0 to 1 if `all` is 0.
Interval wilson_interval(int count, int all);

}  // namespace palpate
