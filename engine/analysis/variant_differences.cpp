#include "engine/analysis/variant_differences.h"

#include <algorithm>
#include <optional>

namespace palpate {
namespace {

std::optional<int> place_of(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<int>(found - names.begin());
}

bool is_simulated(const TrialTable& table) {
  return !table.following().empty();
}

// The first table of the same variant and of the same kind, people or simulated persons.
std::size_t first_of_variant(const std::vector<const TrialTable*>& tables, std::size_t i) {
  for (std::size_t k = 0;; ++k) {
    if (tables[k]->variant() == tables[i]->variant() &&
        is_simulated(*tables[k]) == is_simulated(*tables[i])) {
      return k;
    }
  }
}

// The levels of one setting, in the order of the tables.
template <typename Level>
class SettingLevels {
 public:
  SettingLevels(const std::vector<const TrialTable*>& tables, Level TrialVariant::*setting)
      : setting_(setting) {
    for (const TrialTable* const table : tables) {
      const Level& level = table->variant().*setting;
      if (std::find(levels_.begin(), levels_.end(), level) == levels_.end()) {
        levels_.push_back(level);
      }
    }
  }
  bool differ(const TrialVariant& a, const TrialVariant& b) const {
    return a.*setting_ != b.*setting_;
  }
  // Whether a difference of these levels is shown: of many levels only those to the first one.
  bool are_shown(const TrialVariant& a, const TrialVariant& b) const {
    return levels_.size() <= kMostLevelsInPairs || a.*setting_ == levels_.front() ||
           b.*setting_ == levels_.front();
  }

 private:
  Level TrialVariant::*setting_;
  std::vector<Level> levels_;
};

class ComparedPairs {
 public:
  explicit ComparedPairs(const std::vector<const TrialTable*>& tables)
      : tables_(tables),
        view_(tables, &TrialVariant::view),
        align_(tables, &TrialVariant::align),
        start_(tables, &TrialVariant::start_orientation_deg),
        scale_(tables, &TrialVariant::scale) {}

  bool has(std::size_t first, std::size_t second) const {
    const TrialTable& a = *tables_[first];
    const TrialTable& b = *tables_[second];
    if (is_simulated(a) != is_simulated(b)) return false;
    const TrialVariant& va = a.variant();
    const TrialVariant& vb = b.variant();
    const int settings = view_.differ(va, vb) + align_.differ(va, vb) + start_.differ(va, vb) +
                         scale_.differ(va, vb);
    if (settings != 1) return false;
    if (!start_.are_shown(va, vb) || !scale_.are_shown(va, vb)) return false;
    if (!view_.differ(va, vb) || !is_simulated(a)) return a.following() == b.following();
    const std::size_t turning = va.view == "turning" ? first : second;
    return first_of_variant(tables_, turning) == turning;
  }

 private:
  const std::vector<const TrialTable*>& tables_;
  SettingLevels<std::string> view_, align_;
  SettingLevels<double> start_, scale_;
};

// The means of a participant in two tables, over the trials that both have.
struct PairedMeans {
  double first, second;
};

// By names: the tables may have different levels.
std::optional<PairedMeans> paired_means(const TrialTable& a, const TrialTable& b,
                                        const std::string& participant, const std::string& haptic,
                                        const std::string& rotation, Outcome outcome) {
  const auto pa = place_of(a.participants(), participant);
  const auto pb = place_of(b.participants(), participant);
  if (!pa || !pb) return std::nullopt;
  const auto condition = [&](const TrialTable& table, const std::string& object) {
    return table.condition(*place_of(table.levels(kHapticFactor), haptic),
                           *place_of(table.levels(kRotationFactor), rotation),
                           *place_of(table.levels(kObjectFactor), object));
  };
  PairedMeans sums{0.0, 0.0};
  int count = 0;
  for (const std::string& object : a.levels(kObjectFactor)) {
    if (!place_of(b.levels(kObjectFactor), object)) continue;
    for (const std::string& block : a.levels(kTrialFactor)) {
      const auto tb = place_of(b.levels(kTrialFactor), block);
      if (!tb) continue;
      const auto first =
          a.value(*pa, condition(a, object), *place_of(a.levels(kTrialFactor), block), outcome);
      const auto second = b.value(*pb, condition(b, object), *tb, outcome);
      if (!first || !second) continue;
      sums.first += *first;
      sums.second += *second;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return PairedMeans{sums.first / count, sums.second / count};
}

PairedT paired_test(const TrialTable& a, const TrialTable& b, const std::string& haptic,
                    const std::string& rotation, Outcome outcome) {
  std::vector<double> first, second;
  for (const std::string& participant : a.participants()) {
    const auto means = paired_means(a, b, participant, haptic, rotation, outcome);
    if (!means) continue;
    first.push_back(means->first);
    second.push_back(means->second);
  }
  return paired_t(second, first);
}

void put_differences(const std::vector<const TrialTable*>& tables, std::size_t first,
                     std::size_t second, std::vector<VariantDifference>& all) {
  const TrialTable& a = *tables[first];
  const TrialTable& b = *tables[second];
  for (const Outcome outcome : {Outcome::kTime, Outcome::kTimeToLimit, Outcome::kLosses,
                                Outcome::kPenetration, Outcome::kContactAngle}) {
    if (!a.has(outcome) || !b.has(outcome)) continue;
    const bool has_timeouts = a.has_timeouts() || b.has_timeouts();
    if (outcome == Outcome::kTimeToLimit && !has_timeouts) continue;
    for (const std::string& haptic : a.levels(kHapticFactor)) {
      if (!place_of(b.levels(kHapticFactor), haptic)) continue;
      for (const std::string& rotation : a.levels(kRotationFactor)) {
        if (!place_of(b.levels(kRotationFactor), rotation)) continue;
        all.push_back({first, second, outcome, haptic, rotation,
                       paired_test(a, b, haptic, rotation, outcome)});
      }
    }
  }
}

}  // namespace

std::vector<VariantDifference> variant_differences(const std::vector<const TrialTable*>& tables) {
  std::vector<VariantDifference> all;
  const ComparedPairs pairs(tables);
  for (std::size_t first = 0; first < tables.size(); ++first) {
    for (std::size_t second = first + 1; second < tables.size(); ++second) {
      if (pairs.has(first, second)) put_differences(tables, first, second, all);
    }
  }
  return all;
}

}  // namespace palpate
