#include "engine/analysis/strategy_trials.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace palpate {
namespace {

// The place of a name, or the size of the list.
std::size_t place_of_name(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// The sum of numbers, and how many there are.
struct RunningMean {
  double sum = 0.0;
  int count = 0;

  void add(double value) {
    sum += value;
    ++count;
  }
};

void add_if_any(const RunningMean& mean, std::vector<double>& values) {
  if (mean.count > 0) values.push_back(mean.sum / mean.count);
}

}  // namespace

StrategyTrials::StrategyTrials(const std::vector<TrialRow>& rows, const std::string& following,
                               std::vector<std::string> strategies, std::vector<std::string> scenes)
    : strategies_(std::move(strategies)), scenes_(std::move(scenes)) {
  const auto counts = [&](const TrialRow& row) {
    return row.following == following && row.block > 0 &&
           place_of_name(strategies_, row.strategy) < strategies_.size();
  };
  for (const TrialRow& row : rows) {
    if (counts(row) && place_of_name(hands_, row.participant) == hands_.size()) {
      hands_.push_back(row.participant);
    }
  }
  // "2" before "10".
  std::sort(hands_.begin(), hands_.end(), [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  trials_.resize(strategies_.size() * hands_.size());
  for (const TrialRow& row : rows) {
    if (!counts(row)) continue;
    const std::size_t at = place_of_name(strategies_, row.strategy) * hands_.size() +
                           place_of_name(hands_, row.participant);
    trials_[at].push_back({place_of_name(scenes_, row.object), row.block, row});
  }
  for (std::vector<Trial>& of_hand : trials_) {
    std::sort(of_hand.begin(), of_hand.end(), [](const Trial& a, const Trial& b) {
      return std::tie(a.scene, a.block) < std::tie(b.scene, b.block);
    });
  }
}

StrategyCounts StrategyTrials::counts(std::size_t strategy) const {
  StrategyCounts counts;
  for (std::size_t hand = 0; hand < hands_.size(); ++hand) {
    for (const Trial& trial : trials(strategy, hand)) {
      ++counts.trials;
      if (trial.row.status == TrialStatus::kDone) ++counts.done;
      if (trial.row.status == TrialStatus::kTimeout) ++counts.timeouts;
      if (trial.row.status == TrialStatus::kFault) ++counts.faults;
    }
  }
  return counts;
}

MeanInterval StrategyTrials::mean(std::size_t strategy, const std::optional<std::size_t>& scene,
                                  const ComparedMeasure& measure) const {
  std::vector<double> values;
  for (std::size_t hand = 0; hand < hands_.size(); ++hand) {
    RunningMean of_hand;
    for (const Trial& trial : trials(strategy, hand)) {
      const auto value = compared_value(measure, trial.row);
      if (value && trial.scene == scene.value_or(trial.scene)) of_hand.add(*value);
    }
    add_if_any(of_hand, values);
  }
  return mean_interval(values);
}

MeanInterval StrategyTrials::difference(std::size_t strategy, std::size_t other,
                                        const std::optional<std::size_t>& scene,
                                        const ComparedMeasure& measure) const {
  std::vector<double> values;
  for (std::size_t hand = 0; hand < hands_.size(); ++hand) {
    RunningMean of_hand;
    for (const Trial& trial : trials(strategy, hand)) {
      if (trial.scene != scene.value_or(trial.scene)) continue;
      const auto& others = trials(other, hand);
      const auto pair = std::find_if(others.begin(), others.end(), [&](const Trial& each) {
        return each.scene == trial.scene && each.block == trial.block;
      });
      if (pair == others.end()) continue;
      const auto value = compared_value(measure, trial.row);
      const auto other_value = compared_value(measure, pair->row);
      if (value && other_value) of_hand.add(*value - *other_value);
    }
    add_if_any(of_hand, values);
  }
  return mean_interval(values);
}

}  // namespace palpate
