#include "engine/analysis/primary_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/analysis/intervals.h"

namespace palpate {
namespace {

using Values = std::vector<std::optional<double>>;  // of the cells of a participant

// The mean, if all values are there.
std::optional<double> complete_mean(const Values& values) {
  double sum = 0.0;
  for (const auto& value : values) {
    if (!value) return std::nullopt;
    sum += *value;
  }
  if (values.empty()) return std::nullopt;
  return sum / static_cast<double>(values.size());
}

// The rows in which all values are there.
Eigen::MatrixXd complete_rows(const std::vector<Values>& rows) {
  std::vector<const Values*> complete;
  for (const Values& row : rows) {
    if (complete_mean(row)) complete.push_back(&row);
  }
  Eigen::MatrixXd matrix(complete.size(), rows.empty() ? 0 : rows[0].size());
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) matrix(i, c) = *(*complete[i])[c];
  }
  return matrix;
}

class Cells {
 public:
  Cells(const TrialTable& table, Outcome outcome, std::optional<int> only_haptic)
      : table_(table), outcome_(outcome), only_haptic_(only_haptic) {}

  int participants() const { return static_cast<int>(table_.participants().size()); }

  // The conditions at these levels of Haptic and Rotation; -1: at all levels.
  std::vector<int> conditions(int haptic, int rotation) const {
    std::vector<int> found;
    if (only_haptic_) haptic = *only_haptic_;
    for (int c = 0; c < table_.conditions(); ++c) {
      if (haptic >= 0 && table_.level_in(c, kHapticFactor) != haptic) continue;
      if (rotation >= 0 && table_.level_in(c, kRotationFactor) != rotation) continue;
      found.push_back(c);
    }
    return found;
  }

  // The mean of the blocks that are there.
  std::optional<double> cell(int participant, int condition) const {
    Values there;
    for (int t = 0; t < table_.level_count(kTrialFactor); ++t) {
      const auto value = table_.value(participant, condition, t, outcome_);
      if (value) there.push_back(value);
    }
    return complete_mean(there);
  }

  // One row a participant, one column a condition; with_trial: one column a condition and block.
  std::vector<Values> rows(bool with_trial) const {
    const int blocks = table_.level_count(kTrialFactor);
    std::vector<Values> all(static_cast<std::size_t>(participants()));
    for (int p = 0; p < participants(); ++p) {
      for (const int c : conditions(-1, -1)) {
        if (!with_trial) all[p].push_back(cell(p, c));
        for (int t = 0; with_trial && t < blocks; ++t) {
          all[p].push_back(table_.value(p, c, t, outcome_));
        }
      }
    }
    return all;
  }

  // The mean of a participant's cells at these levels.
  std::optional<double> mean(int participant, int haptic, int rotation) const {
    Values values;
    for (const int c : conditions(haptic, rotation)) values.push_back(cell(participant, c));
    return complete_mean(values);
  }

 private:
  const TrialTable& table_;
  Outcome outcome_;
  std::optional<int> only_haptic_;
};

// The factors with several levels among these cells.
std::vector<ExperimentFactor> varied_factors(const TrialTable& table, bool is_one_haptic) {
  std::vector<ExperimentFactor> factors;
  for (const ExperimentFactor f : {kHapticFactor, kRotationFactor, kObjectFactor, kTrialFactor}) {
    if (table.level_count(f) > 1 && !(f == kHapticFactor && is_one_haptic)) factors.push_back(f);
  }
  return factors;
}

// All effects of these factors. Those with Trial are tested on the table with a cell a block, the
// others on the table with a cell a condition.
std::vector<PrimaryEffect> effects_of(const TrialTable& table, const Cells& cells,
                                      std::vector<ExperimentFactor> factors, bool with_trial) {
  std::vector<PrimaryEffect> effects;
  if (!with_trial) std::erase(factors, kTrialFactor);
  if (factors.empty()) return effects;
  std::vector<int> levels;
  for (const ExperimentFactor f : factors) levels.push_back(table.level_count(f));
  const Eigen::MatrixXd complete = complete_rows(cells.rows(with_trial));
  const bool is_testable = complete.rows() >= 2;
  RepeatedMeasures tested;
  if (is_testable) tested = repeated_measures(levels, complete);
  const auto terms = all_terms(factors.size());
  for (std::size_t i = 0; i < terms.size(); ++i) {
    PrimaryEffect effect;
    for (const std::size_t f : terms[i]) effect.term.push_back(factors[f]);
    if ((effect.term.back() == kTrialFactor) != with_trial) continue;
    effect.participants = static_cast<int>(complete.rows());
    if (is_testable && !std::isnan(tested.effects[i].f)) effect.test = tested.effects[i];
    effects.push_back(std::move(effect));
  }
  return effects;
}

// The means at the first and at the second pair of levels, of participants who have both.
PrimaryPair pair_of(const Cells& cells, std::string name, std::pair<int, int> first,
                    std::pair<int, int> second) {
  std::vector<double> a, b;
  for (int p = 0; p < cells.participants(); ++p) {
    const auto at_first = cells.mean(p, first.first, first.second);
    const auto at_second = cells.mean(p, second.first, second.second);
    if (!at_first || !at_second) continue;
    a.push_back(*at_first);
    b.push_back(*at_second);
  }
  return {std::move(name), paired_t(a, b), 0.0};
}

void adjust(PrimaryFamily& family) {
  std::vector<double> p;
  for (const PrimaryPair& pair : family.pairs) p.push_back(pair.test.p);
  const auto adjusted = holm_adjusted(p);
  for (std::size_t i = 0; i < adjusted.size(); ++i) family.pairs[i].p_holm = adjusted[i];
}

std::vector<PrimaryFamily> families_of(const TrialTable& table, const Cells& cells,
                                       std::optional<int> only_haptic) {
  const auto& haptic = table.levels(kHapticFactor);
  const auto& rotation = table.levels(kRotationFactor);
  std::vector<PrimaryFamily> families;
  if (!only_haptic && haptic.size() > 1) {
    families.push_back({"levels of Haptic", {}});
    for (int i = 0; i < static_cast<int>(haptic.size()); ++i) {
      for (int j = i + 1; j < static_cast<int>(haptic.size()); ++j) {
        families.back().pairs.push_back(
            pair_of(cells, haptic[j] + " - " + haptic[i], {j, -1}, {i, -1}));
      }
    }
  }
  if (rotation.size() > 1) {
    families.push_back({"R - NoR within each level of Haptic", {}});
    for (int h = 0; h < static_cast<int>(haptic.size()); ++h) {
      if (only_haptic && h != *only_haptic) continue;
      families.back().pairs.push_back(pair_of(cells, "R - NoR in " + haptic[h], {h, 1}, {h, 0}));
    }
  }
  for (PrimaryFamily& family : families) adjust(family);
  return families;
}

// The means at several pairs of levels, of participants who have all of them.
void put_means(const Cells& cells, const std::vector<std::pair<int, int>>& levels,
               std::vector<PrimaryMean>& means) {
  std::vector<Values> rows(static_cast<std::size_t>(cells.participants()));
  for (int p = 0; p < cells.participants(); ++p) {
    for (const auto& [haptic, rotation] : levels)
      rows[p].push_back(cells.mean(p, haptic, rotation));
  }
  const Eigen::MatrixXd table = complete_rows(rows);
  if (table.rows() == 0) return;
  const Eigen::VectorXd half_widths = cousineau_morey_half_widths(table);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    means.push_back({levels[i].first, levels[i].second, table.col(column).mean(),
                     half_widths(column), static_cast<int>(table.rows())});
  }
}

std::vector<PrimaryMean> means_of(const TrialTable& table, const Cells& cells,
                                  std::optional<int> only_haptic) {
  std::vector<std::pair<int, int>> of_haptic, of_rotation, of_both;
  for (int h = 0; h < table.level_count(kHapticFactor); ++h) {
    if (!only_haptic) of_haptic.emplace_back(h, -1);
    for (int r = 0; r < table.level_count(kRotationFactor); ++r) {
      if (!only_haptic) of_both.emplace_back(h, r);
    }
  }
  for (int r = 0; r < table.level_count(kRotationFactor); ++r) of_rotation.emplace_back(-1, r);
  std::vector<PrimaryMean> means;
  for (const auto* levels : {&of_haptic, &of_rotation, &of_both}) {
    if (!levels->empty()) put_means(cells, *levels, means);
  }
  return means;
}

}  // namespace

const PrimaryEffect* PrimaryAnalysis::effect(const FactorSet& term) const {
  const auto found = std::find_if(effects.begin(), effects.end(),
                                  [&](const PrimaryEffect& e) { return e.term == term; });
  return found == effects.end() ? nullptr : &*found;
}

const PrimaryMean* PrimaryAnalysis::mean(int haptic, int rotation) const {
  const auto found = std::find_if(means.begin(), means.end(), [&](const PrimaryMean& m) {
    return m.haptic == haptic && m.rotation == rotation;
  });
  return found == means.end() ? nullptr : &*found;
}

PrimaryAnalysis analyse_repeated_measures(const TrialTable& table, Outcome outcome,
                                          std::optional<int> only_haptic) {
  const Cells cells(table, outcome, only_haptic);
  const auto factors = varied_factors(table, only_haptic.has_value());
  PrimaryAnalysis analysis{outcome, only_haptic, effects_of(table, cells, factors, false), {}, {}};
  if (table.level_count(kTrialFactor) > 1) {
    for (PrimaryEffect& effect : effects_of(table, cells, factors, true)) {
      analysis.effects.push_back(std::move(effect));
    }
  }
  analysis.families = families_of(table, cells, only_haptic);
  analysis.means = means_of(table, cells, only_haptic);
  return analysis;
}

}  // namespace palpate
