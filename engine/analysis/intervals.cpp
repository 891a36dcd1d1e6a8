#include "engine/analysis/intervals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/analysis/distributions.h"

namespace palpate {

Eigen::VectorXd cousineau_morey_half_widths(const Eigen::MatrixXd& table) {
  const auto n = static_cast<double>(table.rows()), k = static_cast<double>(table.cols());
  if (n < 2.0 || k < 2.0) {
    return Eigen::VectorXd::Constant(table.cols(), std::numeric_limits<double>::quiet_NaN());
  }
  const Eigen::VectorXd of_participant = table.rowwise().mean();
  const Eigen::MatrixXd normalised = table.colwise() - of_participant;
  const Eigen::RowVectorXd mean = normalised.colwise().mean();
  const Eigen::VectorXd variance =
      (normalised.rowwise() - mean).colwise().squaredNorm().transpose() / (n - 1.0);
  return t_for_coverage(kIntervalCoverage, n - 1.0) * (variance * (k / (k - 1.0) / n)).cwiseSqrt();
}

bool MeanInterval::excludes_zero() const {
  return std::abs(mean) > half_width;
}

MeanInterval mean_interval(std::span<const double> values) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const auto n = static_cast<double>(values.size());
  MeanInterval found{kUnknown, kUnknown, static_cast<int>(values.size())};
  if (values.empty()) return found;
  double sum = 0.0;
  for (const double value : values) sum += value;
  found.mean = sum / n;
  if (values.size() < 2) return found;
  double squares = 0.0;
  for (const double value : values) squares += (value - found.mean) * (value - found.mean);
  found.half_width =
      t_for_coverage(kIntervalCoverage, n - 1.0) * std::sqrt(squares / (n - 1.0) / n);
  return found;
}

Interval wilson_interval(int count, int all) {
  if (all <= 0) return {0.0, 1.0};
  const double n = all, share = count / n;
  const double z2 = z_for_coverage(kIntervalCoverage) * z_for_coverage(kIntervalCoverage);
  const double centre = (share + 0.5 * z2 / n) / (1.0 + z2 / n);
  const double half = std::sqrt(z2 * (share * (1.0 - share) + 0.25 * z2 / n) / n) / (1.0 + z2 / n);
  // At a share of 0 or 1 the end is exact.
  return {count == 0 ? 0.0 : std::max(0.0, centre - half),
          count == all ? 1.0 : std::min(1.0, centre + half)};
}

}  // namespace palpate
