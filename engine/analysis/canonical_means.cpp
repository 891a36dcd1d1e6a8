#include "engine/analysis/canonical_means.h"

#include <map>

namespace palpate {

const std::optional<double>& value_of(const CanonicalRow& row, CanonicalMeasure measure) {
  return measure == CanonicalMeasure::kAlongOverInto ? row.along_over_into : row.share_within_30deg;
}

std::vector<CanonicalMean> canonical_means(const std::vector<CanonicalRow>& rows,
                                           CanonicalMeasure measure, CanonicalMotion motion,
                                           bool rotates) {
  std::map<double, std::vector<double>> by_angle;
  for (const CanonicalRow& row : rows) {
    if (row.cell.motion != motion || row.cell.rotates != rotates) continue;
    std::vector<double>& values = by_angle[row.cell.angle_deg];
    if (const auto& value = value_of(row, measure)) values.push_back(*value);
  }
  std::vector<CanonicalMean> means;
  for (const auto& [angle_deg, values] : by_angle) {
    means.push_back({{angle_deg, motion, rotates}, mean_interval(values)});
  }
  return means;
}

}  // namespace palpate
