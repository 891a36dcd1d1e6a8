#pragma once

// Comparisons of pairs of means.

#include <cstddef>
#include <span>
#include <vector>

namespace palpate {

// Two levels of a factor: the indices of their means, first < second.
struct PlsdPair {
  std::size_t first = 0, second = 0;
  double difference = 0.0;         // mean of first - mean of second
  double t = 0.0;                  // difference / sqrt(MSE (1/n1 + 1/n2))
  double p = 0.0;                  // two-sided, not adjusted
  double least_significant = 0.0;  // the least difference with p <= 0.05
};

// The mean of a level and the number of values in it.
struct LevelMean {
  double mean = 0.0;
  double count = 0.0;
};

// Fisher's protected least significant difference, for all pairs. The caller must check that the F
// of the factor is significant; this check is the protection.
std::vector<PlsdPair> fisher_plsd(std::span<const LevelMean> levels, double mean_square_error,
                                  double error_df);

// A t test of paired values.
struct PairedT {
  int pairs = 0;
  double difference = 0.0;  // mean of a - b
  double t = 0.0;           // NaN if all differences are equal to within rounding, or pairs < 2
  double df = 0.0;
  double p = 0.0;           // two-sided
  double half_width = 0.0;  // of the 95 % interval of the difference
};

// Requires equal sizes.
PairedT paired_t(std::span<const double> a, std::span<const double> b);

// Holm's step-down adjustment (1979) of the p values of one family. The result has the order of p.
// A NaN stays NaN and does not count as a test.
std::vector<double> holm_adjusted(std::span<const double> p);

}  // namespace palpate
