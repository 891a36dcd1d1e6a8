#include "engine/analysis/power_paper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/analysis/paper_findings.h"
#include "engine/trials/as_printed.h"

namespace palpate {
namespace {

constexpr double kPaperTrials = kPaperParticipants * kPaperTrialsOfCondition *
                                static_cast<double>(kHapticNames.size() * kRotationNames.size());

template <std::size_t count>
std::vector<double> paper_level_means(Outcome outcome,
                                      const std::array<std::string_view, count>& levels) {
  std::vector<double> means;
  for (const std::string_view level : levels) means.push_back(paper_mean(outcome, level)->mean);
  return means;
}

double plain_mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double squares_about(const std::vector<double>& values, double centre) {
  double sum = 0.0;
  for (const double value : values) sum += (value - centre) * (value - centre);
  return sum;
}

// The sum of squares about their mean that values may have within `means` +- half a digit. It is
// the least sum of squares about any centre, and convex. Its maximum is therefore at a corner. Its
// minimum is the least over all centres of the squared distances from the intervals; between two
// ends of intervals, only those that end before or begin after the centre count.
std::pair<double, double> squares_range(const std::vector<double>& means) {
  std::vector<double> low, high, ends;
  for (const double mean : means) {
    low.push_back(mean - paper_rounding(mean));
    high.push_back(mean + paper_rounding(mean));
    ends.insert(ends.end(), {low.back(), high.back()});
  }
  double most = 0.0;
  for (std::size_t corner = 0; corner < std::size_t{1} << means.size(); ++corner) {
    std::vector<double> at;
    for (std::size_t i = 0; i < means.size(); ++i) at.push_back(corner >> i & 1 ? high[i] : low[i]);
    most = std::max(most, squares_about(at, plain_mean(at)));
  }
  std::sort(ends.begin(), ends.end());
  double least = most;
  for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
    const double middle = 0.5 * (ends[e] + ends[e + 1]);
    std::vector<double> nearest;
    for (std::size_t i = 0; i < means.size(); ++i) {
      if (high[i] < middle) nearest.push_back(high[i]);
      if (low[i] > middle) nearest.push_back(low[i]);
    }
    if (nearest.empty()) return {0.0, most};
    const double centre = std::clamp(plain_mean(nearest), ends[e], ends[e + 1]);
    least = std::min(least, squares_about(nearest, centre));
  }
  return {least, most};
}

// F is the mean square of the effect divided by that of the error.
PaperScatter trial_scatter(Outcome outcome, ExperimentFactor factor,
                           const std::vector<double>& means) {
  const auto levels = static_cast<double>(means.size());
  const auto sd_of = [&](double squares) {
    const double mean_square = kPaperTrials / levels * squares / (levels - 1.0);
    return std::sqrt(mean_square / paper_f(outcome, {factor})->f);
  };
  const auto [least, most] = squares_range(means);
  return {kExperimentFactorNames[factor], sd_of(squares_about(means, plain_mean(means))),
          sd_of(least), sd_of(most)};
}

}  // namespace

double paper_rounding(double mean) {
  const std::string printed = as_printed(mean);
  const std::size_t point = printed.find('.');
  const std::size_t decimals = point == std::string::npos ? 0 : printed.size() - point - 1;
  return 0.5 * std::pow(10.0, -static_cast<double>(decimals));
}

std::vector<PaperScatter> paper_trial_scatter(Outcome outcome) {
  std::vector<PaperScatter> found = {
      trial_scatter(outcome, kHapticFactor, paper_level_means(outcome, kHapticNames)),
      trial_scatter(outcome, kRotationFactor, paper_level_means(outcome, kRotationNames))};
  std::sort(found.begin(), found.end(),
            [](const PaperScatter& a, const PaperScatter& b) { return a.sd < b.sd; });
  return found;
}

// F(1, n - 1) is the square of the paired t.
PaperScatter paper_angle_scatter() {
  const auto means = paper_level_means(Outcome::kContactAngle, kRotationNames);
  const double t = std::sqrt(paper_f(Outcome::kContactAngle, {kRotationFactor})->f);
  const double scale = std::sqrt(static_cast<double>(kPaperParticipants)) / t;
  const double difference = std::abs(means[1] - means[0]);
  const double rounding = paper_rounding(means[0]) + paper_rounding(means[1]);
  return {kExperimentFactorNames[kRotationFactor], scale * difference,
          scale * (difference - rounding), scale * (difference + rounding)};
}

std::vector<double> paper_condition_means(Outcome outcome) {
  const auto rotation = paper_level_means(outcome, kRotationNames);
  if (outcome == Outcome::kContactAngle) return rotation;
  std::vector<double> means;
  for (const double haptic : paper_level_means(outcome, kHapticNames)) {
    for (const double mean : rotation) means.push_back(haptic + mean - plain_mean(rotation));
  }
  return means;
}

}  // namespace palpate
