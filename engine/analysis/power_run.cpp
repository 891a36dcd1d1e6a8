#include "engine/analysis/power_run.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <mutex>

#include "engine/analysis/power_sums.h"
#include "engine/trials/key_hash.h"
#include "geometry/base/parallel.h"
#include "geometry/base/random.h"

namespace palpate {
namespace {

// Standard normal numbers of one participant.
struct PowerDraw {
  double u = 0.0;
  std::array<double, kMostPowerConditions> cells{};  // w and the mean of e
};

// The participants of a set, in their order.
void draw_set(const PowerModel& model, const PowerSettings& settings, int set,
              std::vector<PowerDraw>& draws) {
  SeededRandom random(
      KeyHash().add("power").add(settings.seed).add(static_cast<std::uint64_t>(set)).value());
  const std::size_t conditions = model.design.conditions();
  draws.resize(static_cast<std::size_t>(settings.participants));
  for (PowerDraw& draw : draws) {
    draw.u = random.normal();
    for (std::size_t c = 0; c < conditions; ++c) draw.cells[c] = random.normal();
  }
}

// The standard deviations in the mean of m trials.
struct PowerDeviations {
  PowerDeviations(const PowerModel& model, std::size_t i)
      : u(std::sqrt(model.variances[i].u)), cells(std::sqrt(model.noise(i))) {}
  double u, cells;
};

void put_conditions(const PowerModel& model, const PowerDeviations& sd, const PowerDraw& draw,
                    std::span<double> conditions) {
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    conditions[c] = model.means[c] + sd.u * draw.u + sd.cells * draw.cells[c];
  }
}

// The threads that simulate, and what they share.
class PowerJobs {
 public:
  PowerJobs(const PowerModel& model, const PowerTests& tests, const PowerSettings& settings,
            const StopFlag* stop)
      : model_(model),
        tests_(tests),
        settings_(settings),
        stop_(stop),
        limits_(tests, settings.participants),
        first_(first_of_equal_noise(model)),
        counts_(no_counts()) {}

  std::optional<PowerCounts> run(const std::function<void(double)>& progress);

 private:
  PowerCounts no_counts() const {
    return {model_.variances.size(), tests_.tests.size(), settings_.participants};
  }
  bool goes_on() const { return !(stop_ && stop_->requested()); }
  void work();
  void count_set(const std::vector<PowerDraw>& draws, PowerSums& sums, PowerCounts& counts) const;
  void wait_for(std::vector<std::future<void>>& threads,
                const std::function<void(double)>& progress);

  const PowerModel& model_;
  const PowerTests& tests_;
  const PowerSettings& settings_;
  const StopFlag* stop_;
  PowerLimits limits_;
  std::vector<std::size_t> first_;  // the models that are simulated
  std::atomic<int> next_{0};
  std::mutex mutex_;  // of counts_
  PowerCounts counts_;
};

void PowerJobs::count_set(const std::vector<PowerDraw>& draws, PowerSums& sums,
                          PowerCounts& counts) const {
  std::array<double, kMostPowerConditions> storage{};
  const std::span<double> conditions(storage.data(), model_.design.conditions());
  std::array<bool, 2 * kMostPowerScores> significant{};
  for (std::size_t i = 0; i < model_.variances.size(); ++i) {
    if (first_[i] != i) continue;
    const PowerDeviations sd(model_, i);
    sums.clear();
    for (const PowerDraw& draw : draws) {
      put_conditions(model_, sd, draw, conditions);
      sums.add(conditions);
      const int n = sums.participants();
      if (n < 2) continue;
      sums.decide(limits_, significant);
      for (std::size_t t = 0; t < tests_.tests.size(); ++t) counts.at(i, t, n) += significant[t];
    }
  }
}

void PowerJobs::work() {
  PowerSums sums(tests_);
  PowerCounts counts = no_counts();
  std::vector<PowerDraw> draws;
  while (goes_on()) {
    const int set = next_.fetch_add(1);
    if (set >= settings_.sets) break;
    draw_set(model_, settings_, set, draws);
    count_set(draws, sums, counts);
  }
  const std::lock_guard lock(mutex_);
  counts_.add(counts);
}

void PowerJobs::wait_for(std::vector<std::future<void>>& threads,
                         const std::function<void(double)>& progress) {
  constexpr std::chrono::milliseconds kPause(100);
  for (auto& thread : threads) {
    while (thread.wait_for(kPause) != std::future_status::ready) {
      if (progress) {
        progress(std::min(1.0, static_cast<double>(next_.load()) / settings_.sets));
      }
    }
    thread.get();
  }
}

std::optional<PowerCounts> PowerJobs::run(const std::function<void(double)>& progress) {
  std::vector<std::future<void>> threads;
  for (int i = 0; i < std::min(settings_.jobs, settings_.sets); ++i) {
    auto thread = start_thread([this] { work(); });
    if (thread.valid()) threads.push_back(std::move(thread));
  }
  if (threads.empty()) work();
  wait_for(threads, progress);
  if (!goes_on()) return std::nullopt;
  for (std::size_t i = 0; i < first_.size(); ++i) counts_.copy(first_[i], i);
  return std::move(counts_);
}

}  // namespace

std::vector<std::size_t> first_of_equal_noise(const PowerModel& model) {
  // A noise comes from shares and a variance by fewer roundings.
  constexpr double kRoundings = 32.0;
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < model.variances.size(); ++i) {
    const double bound = kRoundings * std::numeric_limits<double>::epsilon() * model.noise(i);
    std::size_t other = 0;
    while (other < i && std::abs(model.noise(other) - model.noise(i)) > bound) ++other;
    first.push_back(other);
  }
  return first;
}

PowerCounts::PowerCounts(std::size_t models, std::size_t tests, int participants)
    : tests_(tests),
      participants_(participants),
      counts_(models * tests * static_cast<std::size_t>(participants - 1)) {}

void PowerCounts::add(const PowerCounts& other) {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
}

void PowerCounts::copy(std::size_t from, std::size_t to) {
  const auto size = static_cast<std::ptrdiff_t>(place(1, 0, 2));
  const auto begin = counts_.begin() + static_cast<std::ptrdiff_t>(from) * size;
  if (from != to) {
    std::copy(begin, begin + size, counts_.begin() + static_cast<std::ptrdiff_t>(to) * size);
  }
}

std::optional<int> PowerCounts::first_from(std::size_t model, std::size_t test,
                                           const std::function<bool(int)>& is_enough) const {
  std::optional<int> found;
  for (int n = participants_; n >= 2 && is_enough(at(model, test, n)); --n) found = n;
  return found;
}

std::optional<int> PowerCounts::smallest(std::size_t model, std::size_t test, int sets,
                                         int percent) const {
  return first_from(model, test, [&](int count) {
    return std::int64_t{100} * count >= std::int64_t{percent} * sets;
  });
}

std::optional<PowerCounts> simulate_power(const PowerModel& model, const PowerTests& tests,
                                          const PowerSettings& settings,
                                          const std::function<void(double)>& progress,
                                          const StopFlag* stop) {
  return PowerJobs(model, tests, settings, stop).run(progress);
}

Eigen::MatrixXd power_data_set(const PowerModel& model, std::size_t variances,
                               const PowerSettings& settings, int set) {
  std::vector<PowerDraw> draws;
  draw_set(model, settings, set, draws);
  const PowerDeviations sd(model, variances);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> table(
      settings.participants, static_cast<Eigen::Index>(model.design.conditions()));
  for (Eigen::Index p = 0; p < table.rows(); ++p) {
    put_conditions(model, sd, draws[static_cast<std::size_t>(p)],
                   {table.row(p).data(), model.design.conditions()});
  }
  return table;
}

}  // namespace palpate
