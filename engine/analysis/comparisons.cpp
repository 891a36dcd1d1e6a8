#include "engine/analysis/comparisons.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/analysis/distributions.h"
#include "engine/analysis/intervals.h"

namespace palpate {

std::vector<PlsdPair> fisher_plsd(std::span<const LevelMean> levels, double mean_square_error,
                                  double error_df) {
  std::vector<PlsdPair> pairs;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    for (std::size_t j = i + 1; j < levels.size(); ++j) {
      const double standard_error =
          std::sqrt(mean_square_error * (1.0 / levels[i].count + 1.0 / levels[j].count));
      PlsdPair pair{i, j};
      pair.difference = levels[i].mean - levels[j].mean;
      pair.t = pair.difference / standard_error;
      pair.p = t_two_sided(pair.t, error_df);
      pair.least_significant = t_for_coverage(kIntervalCoverage, error_df) * standard_error;
      pairs.push_back(pair);
    }
  }
  return pairs;
}

PairedT paired_t(std::span<const double> a, std::span<const double> b) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  PairedT test;
  test.pairs = static_cast<int>(a.size());
  const auto n = static_cast<double>(a.size());
  double sum = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += a[i] - b[i];
    largest = std::max({largest, std::abs(a[i]), std::abs(b[i])});
  }
  test.difference = n > 0.0 ? sum / n : kNone;
  test.df = n > 0.0 ? n - 1.0 : kNone;
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    squares += (a[i] - b[i] - test.difference) * (a[i] - b[i] - test.difference);
  }
  // A difference from the mean rounds n + 2 times.
  const double rounding = (n + 2.0) * std::numeric_limits<double>::epsilon() * largest;
  if (n < 2.0 || !(squares > n * rounding * rounding)) {
    test.t = test.p = test.half_width = kNone;
    return test;
  }
  const double standard_error = std::sqrt(squares / (n - 1.0) / n);
  test.t = test.difference / standard_error;
  test.p = t_two_sided(test.t, test.df);
  test.half_width = t_for_coverage(kIntervalCoverage, test.df) * standard_error;
  return test;
}

std::vector<double> holm_adjusted(std::span<const double> p) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!std::isnan(p[i])) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return p[i] < p[j]; });
  std::vector<double> adjusted(p.begin(), p.end());
  double largest = 0.0;  // a p value is never adjusted to less than that of a smaller one
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const auto remaining = static_cast<double>(order.size() - rank);
    largest = std::min(1.0, std::max(largest, remaining * p[order[rank]]));
    adjusted[order[rank]] = largest;
  }
  return adjusted;
}

}  // namespace palpate
