#pragma once

// Power by simulation: how often the tests of the primary analysis are significant.

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/analysis/power_design.h"
#include "engine/session/stop_flag.h"

namespace palpate {

// The model of a trial: y = condition + u(participant) + w(participant, condition) + e(trial). u, w
// and e are independent and normal, with the mean 0 and these variances, in the squared unit of the
// outcome.
struct PowerVariances {
  double u = 0.0, w = 0.0, e = 0.0;
};

// The largest mean of a condition, the largest standard deviation and the largest value of a pilot,
// in the unit of the outcome. Far beyond any measure, and small enough that no square overflows.
inline constexpr double kMostPowerValue = 1e9;

struct PowerModel {
  PowerDesign design;
  std::vector<double> means;  // of the conditions, in the order of the design
  int trials = 1;             // m: of a participant in a condition
  // Each is one model; all models have the same random numbers.
  std::vector<PowerVariances> variances;

  // The variance of the mean of a participant in a condition, less u, which cancels in all tests.
  // The power depends on it alone, and on the means.
  double noise(std::size_t i) const { return variances[i].w + variances[i].e / trials; }
};

// For each of the variances, the first whose noise is equal to within rounding.
std::vector<std::size_t> first_of_equal_noise(const PowerModel& model);

struct PowerSettings {
  int participants = 60;  // the largest number, at least 2
  int sets = 10'000;      // simulated data sets
  std::uint64_t seed = 2005;
  int jobs = 1;  // threads
};

// How many data sets made a test significant.
class PowerCounts {
 public:
  PowerCounts() = default;
  PowerCounts(std::size_t models, std::size_t tests, int participants);

  // n: 2 to the largest number of participants.
  int& at(std::size_t model, std::size_t test, int n) { return counts_[place(model, test, n)]; }
  int at(std::size_t model, std::size_t test, int n) const {
    return counts_[place(model, test, n)];
  }
  void add(const PowerCounts& other);

  // Answers of model `from` become those of model `to`.
  void copy(std::size_t from, std::size_t to);

  // The first n from which on is_enough(at(model, test, n)) holds; no value if it does not hold at
  // the largest n.
  std::optional<int> first_from(std::size_t model, std::size_t test,
                                const std::function<bool(int)>& is_enough) const;
  // The first n from which on the share at(model, test, n) / sets never falls below percent / 100;
  // no value if it is below at the largest n.
  std::optional<int> smallest(std::size_t model, std::size_t test, int sets, int percent) const;

 private:
  std::size_t place(std::size_t model, std::size_t test, int n) const {
    return (model * tests_ + test) * static_cast<std::size_t>(participants_ - 1) +
           static_cast<std::size_t>(n - 2);
  }

  std::size_t tests_ = 0;
  int participants_ = 2;
  std::vector<int> counts_;
};

// Simulates the data sets and tests each one with its first 2, 3, ... participants. The sets of
// different n are therefore not independent: a curve over n is smooth, and each of its points has
// the error of `sets` data sets. The mean of a participant in a condition is drawn as one number
// with the variance w + e / m, beside u. Variances of equal noise have equal counts. The random
// numbers of set s have the seed KeyHash("power", seed, s), and those of a participant come before
// those of the next, so that no result depends on jobs or on the largest number of participants.
//
// progress: called on the calling thread with the share of the sets that are done. stop: may be
// null; if it is set, the result has no value.
std::optional<PowerCounts> simulate_power(const PowerModel& model, const PowerTests& tests,
                                          const PowerSettings& settings,
                                          const std::function<void(double)>& progress = {},
                                          const StopFlag* stop = nullptr);

// The means of the participants of one data set in each condition, of one model: one row per
// participant. For tests, and to look at.
Eigen::MatrixXd power_data_set(const PowerModel& model, std::size_t variances,
                               const PowerSettings& settings, int set);

}  // namespace palpate
