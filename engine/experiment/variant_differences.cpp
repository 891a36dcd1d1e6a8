#include "engine/experiment/variant_differences.h"

#include <algorithm>
#include <optional>

namespace palpate {
namespace {

std::optional<int> place_of(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<int>(found - names.begin());
}

// The first table of the same variant.
std::size_t first_of_variant(const std::vector<const TrialTable*>& tables, std::size_t i) {
  for (std::size_t k = 0;; ++k) {
    if (tables[k]->variant() == tables[i]->variant()) return k;
  }
}

bool are_compared(const std::vector<const TrialTable*>& tables, std::size_t first,
                  std::size_t second) {
  const TrialTable& a = *tables[first];
  const TrialTable& b = *tables[second];
  if (a.variant() == b.variant()) return false;
  if (a.variant().view == b.variant().view) return a.following() == b.following();
  const std::size_t turning = a.variant().view == "turning" ? first : second;
  return first_of_variant(tables, turning) == turning;
}

// The mean difference of a participant, by names: the tables may have different levels.
std::optional<double> difference_of(const TrialTable& a, const TrialTable& b,
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
  double sum = 0.0;
  int count = 0;
  for (const std::string& object : a.levels(kObjectFactor)) {
    if (!place_of(b.levels(kObjectFactor), object)) continue;
    for (const std::string& block : a.levels(kTrialFactor)) {
      const auto tb = place_of(b.levels(kTrialFactor), block);
      if (!tb) continue;
      const auto before =
          a.value(*pa, condition(a, object), *place_of(a.levels(kTrialFactor), block), outcome);
      const auto after = b.value(*pb, condition(b, object), *tb, outcome);
      if (!before || !after) continue;
      sum += *after - *before;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

PairedT paired_test(const TrialTable& a, const TrialTable& b, const std::string& haptic,
                    const std::string& rotation, Outcome outcome) {
  std::vector<double> differences;
  for (const std::string& participant : a.participants()) {
    const auto value = difference_of(a, b, participant, haptic, rotation, outcome);
    if (value) differences.push_back(*value);
  }
  return paired_t(differences, std::vector<double>(differences.size(), 0.0));
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
  for (std::size_t first = 0; first < tables.size(); ++first) {
    for (std::size_t second = first + 1; second < tables.size(); ++second) {
      if (are_compared(tables, first, second)) put_differences(tables, first, second, all);
    }
  }
  return all;
}

}  // namespace palpate
