#pragma once

// The trials of an experiment, checked, and arranged by participant, block and condition.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/analysis/factorial_model.h"
#include "engine/analysis/trial_variant.h"
#include "engine/trials/levels.h"
#include "engine/trials/trial_outcome.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"

namespace palpate {

// The factors of the paper. Trial is the block, from 1.
enum ExperimentFactor : std::size_t { kHapticFactor, kRotationFactor, kObjectFactor, kTrialFactor };
inline constexpr std::array<std::string_view, 4> kExperimentFactorNames = {"Haptic", "Rotation",
                                                                           "Object", "Trial"};

// The name of an effect, as the paper writes it: "Rotation x Haptic". term: ExperimentFactors,
// ascending.
std::string effect_name(const FactorSet& term);

// The largest number of combinations of Haptic, Rotation, Object and Trial. The time of the paper's
// analysis grows with the third power of this number: 600 combinations take about a second.
inline constexpr std::size_t kMostCells = 600;

// The trials of one kind of operator in one variant of the experiment: of one following, or of
// people. Immutable.
class TrialTable {
 public:
  // rows: the rows of one following and one variant; practice blocks (block 0) are left out.
  // limit_s: the time limit of a trial. If a trial has several attempts, the last attempt counts.
  //
  // Errors: a level of Haptic or Rotation that is not known, a repeated row, a number that is not
  // finite in a completed trial, fewer than two participants, a condition without any row.
  static Result<TrialTable> create(std::vector<TrialRow> rows, double limit_s);

  // Empty: people.
  const std::string& following() const { return following_; }
  const TrialVariant& variant() const { return variant_; }
  // "following delayed, view still, "; empty for people in the paper's variant.
  std::string whose() const;
  double limit_s() const { return limit_s_; }
  // In the order of numbers within names: P2 before P10.
  const std::vector<std::string>& participants() const { return participants_; }
  // The names of a factor's levels.
  const std::vector<std::string>& levels(ExperimentFactor factor) const { return levels_[factor]; }
  int level_count(ExperimentFactor factor) const {
    return static_cast<int>(levels_[factor].size());
  }
  // Rows of earlier attempts, which do not count.
  int earlier_attempts() const { return earlier_attempts_; }

  // A condition is a level of Haptic, of Rotation and of Object.
  int conditions() const {
    return level_count(kHapticFactor) * level_count(kRotationFactor) * level_count(kObjectFactor);
  }
  int condition(int haptic, int rotation, int object) const {
    return (haptic * level_count(kRotationFactor) + rotation) * level_count(kObjectFactor) + object;
  }
  // The level of Haptic, Rotation or Object in a condition.
  int level_in(int condition, ExperimentFactor factor) const;
  // "UaH, R, O2"
  std::string condition_name(int condition) const;

  // Null if the trial is absent. trial: the index of the block, from 0.
  const TrialRow* row(int participant, int condition, int trial) const;
  std::optional<double> value(int participant, int condition, int trial, Outcome outcome) const;
  // Whether any trial has this outcome.
  bool has(Outcome outcome) const;
  bool has_timeouts() const;
  bool has_completed_trial() const;

 private:
  TrialTable() = default;
  std::size_t place(int participant, int condition, int trial) const;
  std::optional<Error> find_levels();
  std::optional<Error> arrange();
  std::optional<Error> check_conditions() const;

  std::string following_;
  TrialVariant variant_;
  double limit_s_ = 0.0;
  std::vector<TrialRow> rows_;
  std::vector<std::string> participants_;
  std::array<std::vector<std::string>, 4> levels_;
  std::vector<int> row_of_place_;  // -1: absent
  int earlier_attempts_ = 0;
};

// The most experiments in one file: each has its own figures and tables.
inline constexpr std::size_t kMostTables = 100;

// A table for each variant and following that occurs: the variants in the order of TrialVariant; in
// each first `delayed`, then the others in the order of kFollowingNames, then people. Errors as for
// create(), a file without trials, and one with more than kMostTables tables.
Result<std::vector<TrialTable>> trial_tables(std::vector<TrialRow> rows, double limit_s);

}  // namespace palpate
