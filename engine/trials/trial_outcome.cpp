#include "engine/trials/trial_outcome.h"

#include <array>

namespace palpate {
namespace {

constexpr std::array<OutcomeText, kOutcomeCount> kOutcomeTexts = {
    {{"total time", "s", "total_time_s"},
     {"losses of contact", "", "losses_of_contact"},
     {"mean penetration", "dm", "mean_penetration_dm"},
     {"losses of contact per second", "1/s", "losses_per_s"},
     {"losses of contact of 100 ms or more", "", "losses_100ms"},
     {"mean contact angle", "deg", "mean_contact_angle_deg"},
     {"total time, timeouts as the limit", "s", "total_time_s"}}};

}  // namespace

const OutcomeText& outcome_text(Outcome outcome) {
  return kOutcomeTexts[static_cast<std::size_t>(outcome)];
}

std::optional<double> outcome_of(const TrialRow& row, Outcome outcome, double limit_s) {
  if (row.status == TrialStatus::kTimeout && outcome == Outcome::kTimeToLimit) return limit_s;
  if (row.status != TrialStatus::kDone) return std::nullopt;
  const auto& measures = row.measures;
  switch (outcome) {
    case Outcome::kTime:
    case Outcome::kTimeToLimit:
      return measures[kTotalTime];
    case Outcome::kLosses:
      return measures[kLosses];
    case Outcome::kPenetration:
      if (!measures[kPenetrationDm] && measures[kPenetration])
        return 10.0 * *measures[kPenetration];
      return measures[kPenetrationDm];
    case Outcome::kLossesPerSecond:
      if (!measures[kLossesPerSecond] && measures[kLosses] &&
          measures[kTotalTime].value_or(0.0) > 0.0)
        return *measures[kLosses] / *measures[kTotalTime];
      return measures[kLossesPerSecond];
    case Outcome::kLosses100ms:
      return measures[kLosses100ms];
    case Outcome::kContactAngle:
      return measures[kContactAngle];
  }
  return std::nullopt;
}

}  // namespace palpate
