#include "engine/analysis/power_sums.h"

#include <algorithm>
#include <cmath>

#include "engine/analysis/distributions.h"
#include "engine/analysis/intervals.h"

namespace palpate {
namespace {

constexpr double kLeastEpsilon = 0.5;  // of two degrees of freedom

// A critical value has the error of its computation, some roundings. An F that is nearer to it than
// this share is decided by its p value.
constexpr double kNear = 1e-9;

}  // namespace

PowerLimits::PowerLimits(const PowerTests& tests, int participants) : participants_(participants) {
  const bool has_two_df = std::any_of(
      tests.tests.begin(), tests.tests.end(),
      [](const PowerTest& test) { return test.correction == PowerCorrection::kGreenhouseGeisser; });
  const auto count = static_cast<std::size_t>(participants) + 1;
  for (auto& values : f_) values.resize(count);
  for (auto& values : t2_) values.resize(count);
  if (has_two_df) gg_.resize(count);
  for (int n = 2; n <= participants; ++n) {
    const double df2 = n - 1.0;
    for (std::size_t df1 = 1; df1 <= f_.size(); ++df1) {
      f_[df1 - 1][n] =
          f_for_tail(kSignificance, static_cast<double>(df1), static_cast<double>(df1) * df2);
    }
    for (std::size_t remaining = 1; remaining <= t2_.size(); ++remaining) {
      const double t = t_for_coverage(1.0 - kSignificance / static_cast<double>(remaining), df2);
      t2_[remaining - 1][n] = t * t;
    }
    for (int i = 0; has_two_df && i <= kEpsilonSteps; ++i) {
      const double df1 = 2.0 * (kLeastEpsilon + (1.0 - kLeastEpsilon) * i / kEpsilonSteps);
      gg_[n][i] = f_for_tail(kSignificance, df1, df1 * df2);
    }
  }
}

bool PowerLimits::is_significant_gg(double f, double epsilon, int n) const {
  const double place = (epsilon - kLeastEpsilon) / (1.0 - kLeastEpsilon) * kEpsilonSteps;
  // With two participants epsilon is 1/2, or less by roundings.
  const int step = std::clamp(static_cast<int>(place), 0, kEpsilonSteps - 1);
  if (f > gg_[n][step] * (1.0 + kNear)) return true;
  if (f < gg_[n][step + 1] * (1.0 - kNear)) return false;
  return f_upper_tail(f, epsilon * 2.0, epsilon * 2.0 * (n - 1.0)) < kSignificance;
}

PowerSums::PowerSums(const PowerTests& tests) : tests_(tests) {}

void PowerSums::clear() {
  participants_ = 0;
  mean_.fill(0.0);
  squares_.fill(0.0);
  products_.fill(0.0);
}

// Welford (1962): the sums of squares are of deviations from the present means, so that large means
// do not cancel.
void PowerSums::add(std::span<const double> conditions) {
  const auto scores = static_cast<std::size_t>(tests_.weights.cols());
  const double* weight = tests_.weights.data();  // column by column
  const double share = 1.0 / ++participants_;
  double before = 0.0;  // deviation of the score before this one from its mean without this row
  for (std::size_t i = 0; i < scores; ++i) {
    double score = 0.0;
    for (const double value : conditions) score += *weight++ * value;
    const double deviation = score - mean_[i];
    mean_[i] += deviation * share;
    const double remaining = score - mean_[i];
    squares_[i] += deviation * remaining;
    if (i > 0) products_[i - 1] += before * remaining;
    before = deviation;
  }
}

double PowerSums::sum_of_squares(const PowerTest& test) const {
  double sum = squares_[test.first_score];
  if (test.scores == 2) sum += squares_[test.first_score + 1];
  return sum;
}

double PowerSums::f(const PowerTest& effect) const {
  double of_means = mean_[effect.first_score] * mean_[effect.first_score];
  if (effect.scores == 2) of_means += mean_[effect.first_score + 1] * mean_[effect.first_score + 1];
  const double n = participants_;
  return n * (n - 1.0) * of_means / sum_of_squares(effect);
}

double PowerSums::epsilon(const PowerTest& effect) const {
  if (effect.scores == 1) return 1.0;
  const double a = squares_[effect.first_score], b = squares_[effect.first_score + 1];
  const double product = products_[effect.first_score];
  return (a + b) * (a + b) / (2.0 * (a * a + b * b + 2.0 * product * product));
}

double PowerSums::t2(const PowerTest& pair) const {
  return f(pair);
}

// Step-down: the largest |t| is compared first, and the first that fails ends the family.
void PowerSums::decide_family(std::size_t first, std::size_t count, const PowerLimits& limits,
                              std::span<bool> significant) const {
  std::array<std::size_t, 3> order{};
  std::array<double, 3> t2s{};
  for (std::size_t i = 0; i < count; ++i) {
    order[i] = i;
    t2s[i] = t2(tests_.tests[first + i]);
    significant[first + i] = false;
    for (std::size_t at = i; at > 0 && t2s[order[at]] > t2s[order[at - 1]]; --at) {
      std::swap(order[at], order[at - 1]);
    }
  }
  for (std::size_t rank = 0; rank < count; ++rank) {
    if (!(t2s[order[rank]] > limits.t2(count - rank, participants_))) return;
    significant[first + order[rank]] = true;
  }
}

void PowerSums::decide(const PowerLimits& limits, std::span<bool> significant) const {
  const auto& tests = tests_.tests;
  for (std::size_t i = 0; i < tests.size();) {
    const PowerTest& test = tests[i];
    std::size_t count = 1;
    switch (test.correction) {
      case PowerCorrection::kNone:
        significant[i] = f(test) > limits.f(test.scores, participants_);
        break;
      case PowerCorrection::kGreenhouseGeisser:
        significant[i] = limits.is_significant_gg(f(test), epsilon(test), participants_);
        break;
      case PowerCorrection::kHolm:
        while (i + count < tests.size() && tests[i + count].family == test.family) ++count;
        decide_family(i, count, limits, significant);
        break;
    }
    i += count;
  }
}

}  // namespace palpate
