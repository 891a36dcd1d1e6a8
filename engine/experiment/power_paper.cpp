#include "engine/experiment/power_paper.h"

#include <algorithm>
#include <cmath>

#include "engine/experiment/paper_findings.h"

namespace palpate {
namespace {

constexpr double kPaperTrials = kPaperParticipants * kPaperTrialsOfCondition *
                                static_cast<double>(kHapticLevels.size() * kRotationLevels.size());

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

// F is the mean square of the effect divided by that of the error.
PaperScatter trial_scatter(Outcome outcome, ExperimentFactor factor,
                           const std::vector<double>& means) {
  const double centre = plain_mean(means);
  double squares = 0.0;
  for (const double mean : means) squares += (mean - centre) * (mean - centre);
  const auto levels = static_cast<double>(means.size());
  const double mean_square = kPaperTrials / levels * squares / (levels - 1.0);
  return {kExperimentFactorNames[factor], std::sqrt(mean_square / paper_f(outcome, {factor})->f)};
}

}  // namespace

std::vector<PaperScatter> paper_trial_scatter(Outcome outcome) {
  std::vector<PaperScatter> found = {
      trial_scatter(outcome, kHapticFactor, paper_level_means(outcome, kHapticLevels)),
      trial_scatter(outcome, kRotationFactor, paper_level_means(outcome, kRotationLevels))};
  std::sort(found.begin(), found.end(),
            [](const PaperScatter& a, const PaperScatter& b) { return a.sd < b.sd; });
  return found;
}

// F(1, n - 1) is the square of the paired t.
PaperScatter paper_angle_scatter() {
  const auto means = paper_level_means(Outcome::kContactAngle, kRotationLevels);
  const double t = std::sqrt(paper_f(Outcome::kContactAngle, {kRotationFactor})->f);
  return {kExperimentFactorNames[kRotationFactor],
          std::abs(means[1] - means[0]) * std::sqrt(static_cast<double>(kPaperParticipants)) / t};
}

std::vector<double> paper_condition_means(Outcome outcome) {
  const auto rotation = paper_level_means(outcome, kRotationLevels);
  if (outcome == Outcome::kContactAngle) return rotation;
  std::vector<double> means;
  for (const double haptic : paper_level_means(outcome, kHapticLevels)) {
    for (const double mean : rotation) means.push_back(haptic + mean - plain_mean(rotation));
  }
  return means;
}

}  // namespace palpate
