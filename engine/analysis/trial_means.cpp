#include "engine/analysis/trial_means.h"

#include <cmath>
#include <limits>

namespace palpate {
namespace {

bool is_at(const TrialTable& table, int condition, const TrialLevels& at) {
  const auto holds = [&](int level, ExperimentFactor factor) {
    return level < 0 || table.level_in(condition, factor) == level;
  };
  return holds(at.haptic, kHapticFactor) && holds(at.rotation, kRotationFactor) &&
         holds(at.object, kObjectFactor);
}

// Calls visit(participant, condition, trial) for every planned trial at these levels.
template <typename Visit>
void for_each_trial(const TrialTable& table, const TrialLevels& at, Visit visit) {
  for (int p = 0; p < static_cast<int>(table.participants().size()); ++p) {
    for (int c = 0; c < table.conditions(); ++c) {
      if (!is_at(table, c, at)) continue;
      for (int t = 0; t < table.level_count(kTrialFactor); ++t) visit(p, c, t);
    }
  }
}

}  // namespace

TrialMean trial_mean(const TrialTable& table, Outcome outcome, const TrialLevels& at) {
  TrialMean result{at, 0, 0.0, 0.0};
  std::vector<double> values;
  for_each_trial(table, at, [&](int p, int c, int t) {
    const auto value = table.value(p, c, t, outcome);
    if (value) values.push_back(*value);
  });
  const auto n = static_cast<double>(values.size());
  result.trials = static_cast<int>(values.size());
  for (const double value : values) result.mean += value / n;
  for (const double value : values) result.sd += (value - result.mean) * (value - result.mean);
  result.sd = std::sqrt(result.sd / (n - 1.0));  // NaN for one value
  if (values.empty()) result.mean = result.sd = std::numeric_limits<double>::quiet_NaN();
  return result;
}

std::vector<TrialLevels> levels_of_means(const TrialTable& table) {
  const int haptics = table.level_count(kHapticFactor);
  const int rotations = table.level_count(kRotationFactor);
  const int objects = table.level_count(kObjectFactor);
  std::vector<TrialLevels> levels = {{}};
  for (int h = 0; haptics > 1 && h < haptics; ++h) levels.push_back({h, -1, -1});
  for (int r = 0; rotations > 1 && r < rotations; ++r) levels.push_back({-1, r, -1});
  for (int o = 0; objects > 1 && o < objects; ++o) levels.push_back({-1, -1, o});
  for (int h = 0; haptics > 1 && rotations > 1 && h < haptics; ++h) {
    for (int r = 0; r < rotations; ++r) levels.push_back({h, r, -1});
  }
  return levels;
}

std::string levels_name(const TrialTable& table, const TrialLevels& at) {
  std::string name;
  const auto put = [&](int level, ExperimentFactor factor) {
    if (level >= 0) name += (name.empty() ? "" : ", ") + table.levels(factor)[level];
  };
  put(at.haptic, kHapticFactor);
  put(at.rotation, kRotationFactor);
  put(at.object, kObjectFactor);
  return name.empty() ? "all trials" : name;
}

TrialCounts trial_counts(const TrialTable& table, const TrialLevels& at) {
  TrialCounts counts;
  counts.at = at;
  for_each_trial(table, at, [&](int p, int c, int t) {
    const TrialRow* row = table.row(p, c, t);
    if (!row) {
      ++counts.absent;
    } else if (row->status == TrialStatus::kDone) {
      ++counts.done;
    } else {
      ++(row->status == TrialStatus::kTimeout ? counts.timeouts : counts.faults);
    }
  });
  counts.timeout_share =
      wilson_interval(counts.timeouts, counts.done + counts.timeouts + counts.faults);
  return counts;
}

std::vector<TrialCounts> counts_by_condition(const TrialTable& table) {
  std::vector<TrialCounts> counts;
  for (int c = 0; c < table.conditions(); ++c) {
    counts.push_back(
        trial_counts(table, {table.level_in(c, kHapticFactor), table.level_in(c, kRotationFactor),
                             table.level_in(c, kObjectFactor)}));
  }
  return counts;
}

}  // namespace palpate
