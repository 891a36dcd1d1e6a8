#include "engine/trials/compare/compared_measures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/trials/trials_file.h"

namespace palpate {
namespace {

constexpr double kMilli = 1e3;
constexpr std::string_view kStatusColumn = "status";

constexpr std::array<ComparedMeasure, 18> kComparedMeasures = {{
    {"contact angle", "mean_contact_angle_deg", "deg", "deg", 1.0, Better::kLower},
    {"penetration", "mean_penetration_m", "m", "mm", kMilli, Better::kLower},
    {"total time", "total_time_s", "s", "s", 1.0, Better::kLower},
    {"losses of contact", "losses_of_contact", "", "", 1.0, Better::kLower},
    {"losses of 0.1 s", "losses_100ms", "", "", 1.0, Better::kLower},
    {"timeouts", kStatusColumn, "1", "%", 100.0, Better::kLower},
    {"ghost force", "mean_ghost_force_N", "N", "N", 1.0, Better::kLower},
    {"missing force", "mean_missing_force_N", "N", "N", 1.0, Better::kNearerToZero},
    {"port work", "port_work_J", "J", "mJ", kMilli, Better::kLower},
    {"work lost", "work_lost_J", "J", "mJ", kMilli, Better::kNearerToZero},
    {"work along the wall", "wall_work_J", "J", "mJ", kMilli, Better::kLower},
    {"work of one contact", "largest_contact_work_J", "J", "mJ", kMilli, Better::kLower},
    {"empty turns", "empty_turns", "", "", 1.0, Better::kLower},
    {"mean drift", "mean_drift_m", "m", "mm", kMilli, Better::kLower},
    {"worst drift", "worst_drift_m", "m", "mm", kMilli, Better::kLower},
    {"governed ticks", "governor_share", "1", "%", 100.0, Better::kLower},
    {"energy of turning", "turning_energy_J", "J", "mJ", kMilli, Better::kLower},
    {kTravelMeasure, "device_travel_m", "m", "mm", kMilli, Better::kLower},
}};

}  // namespace

std::span<const ComparedMeasure> compared_measures() {
  return kComparedMeasures;
}

std::optional<double> compared_value(const ComparedMeasure& measure, const TrialRow& row) {
  if (measure.column == kStatusColumn) return row.status == TrialStatus::kTimeout ? 1.0 : 0.0;
  if (row.status != TrialStatus::kDone) return std::nullopt;
  const auto& names = measure_names();
  const auto place = std::find(names.begin(), names.end(), measure.column) - names.begin();
  const std::optional<double>& value = row.measures[static_cast<std::size_t>(place)];
  if (!value || measure.better == Better::kLower) return value;
  return std::abs(*value);
}

}  // namespace palpate
