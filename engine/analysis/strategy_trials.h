#pragma once

// The trials of a comparison of strategies, arranged by strategy, hand and scene, and their means.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "engine/analysis/compared_measures.h"
#include "engine/analysis/intervals.h"
#include "engine/trials/trial_row.h"

namespace palpate {

// How the trials of a strategy ended.
struct StrategyCounts {
  int trials = 0;
  int done = 0;
  int timeouts = 0;
  int faults = 0;

  // At least 90 % of the trials were completed.
  bool is_comparable() const { return 10 * done >= 9 * trials; }
};

// The trials of one following. A hand is a participant. In all functions, a strategy and a scene
// are places in the lists of the constructor; scene: no value stands for all scenes together.
//
// The value of a hand is the mean over its scenes and blocks; a trial without a value of the
// measure is left out. A mean is over hands that have a value. A difference is paired: the value of
// a hand is the mean of the differences between trials on the same scene, for which both have a
// value.
class StrategyTrials {
 public:
  // rows: of trials.csv, in any order. Rows of other followings, of practice and with other
  // strategies are left out; scenes lists all objects.
  StrategyTrials(const std::vector<TrialRow>& rows, const std::string& following,
                 std::vector<std::string> strategies, std::vector<std::string> scenes);

  const std::vector<std::string>& strategies() const { return strategies_; }
  const std::vector<std::string>& scenes() const { return scenes_; }
  int hands() const { return static_cast<int>(hands_.size()); }

  StrategyCounts counts(std::size_t strategy) const;
  MeanInterval mean(std::size_t strategy, const std::optional<std::size_t>& scene,
                    const ComparedMeasure& measure) const;
  // The strategy minus the other one.
  MeanInterval difference(std::size_t strategy, std::size_t other,
                          const std::optional<std::size_t>& scene,
                          const ComparedMeasure& measure) const;

 private:
  struct Trial {
    std::size_t scene;
    int block;
    TrialRow row;
  };
  // Sorted by scene and block.
  const std::vector<Trial>& trials(std::size_t strategy, std::size_t hand) const {
    return trials_[strategy * hands_.size() + hand];
  }

  std::vector<std::string> strategies_;
  std::vector<std::string> scenes_;
  std::vector<std::string> hands_;  // names of participants
  std::vector<std::vector<Trial>> trials_;
};

}  // namespace palpate
