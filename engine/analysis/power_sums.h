#pragma once

// The primary analysis of the first n participants, for n = 2, 3, ... in turn: from sums that grow
// by one participant at a time, and from the critical values of its tests. It decides as
// repeated_measures(), paired_t() and holm_adjusted() do on a table of the same n rows; a test
// compares them.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "engine/analysis/power_design.h"

namespace palpate {

// Haptic has at most three levels and Rotation two: two effects of two degrees of freedom, one of
// one, and six pairs.
inline constexpr std::size_t kMostPowerConditions = 6;
inline constexpr std::size_t kMostPowerScores = 11;

// The values that statistics must exceed to be significant at kSignificance, for 2 to
// `participants` participants. Immutable; any number of threads may use one object.
class PowerLimits {
 public:
  PowerLimits(const PowerTests& tests, int participants);

  int participants() const { return participants_; }
  // Of F(df1, df1 (n - 1)); df1 is 1 or 2.
  double f(std::size_t df1, int n) const { return f_[df1 - 1][n]; }
  // Whether F is significant by Greenhouse and Geisser; df1 is 2.
  bool is_significant_gg(double f, double epsilon, int n) const;
  // Of t^2, with Holm's correction if this many hypotheses remain.
  double t2(std::size_t remaining, int n) const { return t2_[remaining - 1][n]; }

 private:
  // The critical F falls with epsilon, which is at least 1/2 for two degrees of freedom. Between
  // two steps of epsilon, only an F between the critical values of both needs its p value.
  static constexpr int kEpsilonSteps = 32;

  int participants_;
  std::array<std::vector<double>, 2> f_;   // by n
  std::array<std::vector<double>, 3> t2_;  // by n
  std::vector<std::array<double, kEpsilonSteps + 1>> gg_;
};

class PowerSums {
 public:
  explicit PowerSums(const PowerTests& tests);

  // Forgets all participants.
  void clear();
  // The means of the next participant, one a condition.
  void add(std::span<const double> conditions);

  int participants() const { return participants_; }
  // The statistics of the participants so far. Requires two of them. NaN if nothing scatters.
  double f(const PowerTest& effect) const;
  double epsilon(const PowerTest& effect) const;
  double t2(const PowerTest& pair) const;

  // Sets significant[i] for each test of PowerTests. Requires 2 to limits.participants()
  // participants.
  void decide(const PowerLimits& limits, std::span<bool> significant) const;

 private:
  void decide_family(std::size_t first, std::size_t count, const PowerLimits& limits,
                     std::span<bool> significant) const;
  double sum_of_squares(const PowerTest& test) const;

  const PowerTests& tests_;
  int participants_ = 0;
  std::array<double, kMostPowerScores> mean_{};
  std::array<double, kMostPowerScores> squares_{};   // sum of squared deviations
  std::array<double, kMostPowerScores> products_{};  // of a score and the next one
};

}  // namespace palpate
