#pragma once

// One row of trials.csv: the conditions of a trial and what was measured in it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/record.h"

namespace palpate {

// How a trial ended.
enum class TrialStatus : std::uint8_t {
  kDone,     // with a contact within the red sphere
  kTimeout,  // at the time limit
  kFault     // by a fault of a tick
};
inline constexpr std::array<std::string_view, 3> kTrialStatusNames = {"done", "timeout", "fault"};

// A measure of a trial: its column in trials.csv.
struct TrialMeasure {
  std::string_view name;
  std::string_view unit;  // "1": dimensionless
  std::string_view meaning;
  std::string_view paper;  // the paper's name of the measure; empty: the paper does not have it
};

// The indices of the measures in trial_measures(). The measures of the faults, one for each of
// kFaultNames, begin at kFirstFaultMeasure. The measures after kMissedDeadlines are only in files
// of plans with strategies (strategy_measures.h).
enum MeasureIndex : std::size_t {
  kTotalTime,
  kContactTime,
  kLosses,
  kLosses100ms,
  kLossesPerSecond,
  kLosses100msPerSecond,
  kPenetration,
  kPenetrationDm,
  kContactAngle,
  kShareWithin30deg,
  kTrackedShare,
  kRecoveries,
  kDevicePath,
  kProxyPath,
  kPortWork,
  kWorkLost,
  kGhostForce,
  kMissingForce,
  kFirstFaultMeasure,
  kMissedDeadlines = kFirstFaultMeasure + kFaultCount,
  kWallWork,
  kLargestContactWork,
  kEmptyTurns,
  kMeanDrift,
  kWorstDrift,
  kGovernorShare,
  kMeasureCount
};
// How many measures a file without strategies has: the first ones.
inline constexpr std::size_t kPlainMeasureCount = kWallWork;

// All measures, in the order of the columns.
const std::array<TrialMeasure, kMeasureCount>& trial_measures();

struct TrialRow {
  std::string following;    // of a simulated operator (kFollowingNames); empty for a person
  std::string participant;  // "1", "2", ... for simulated operators
  int block = 0;            // 0: practice
  int trial = 0;            // place within the block, 1 for the first
  std::string haptic;       // NoH, UaH or H; empty: strategy is set
  std::string rotation;     // NoR or R; empty: strategy is set
  std::string object;
  int attempt = 1;
  TrialStatus status = TrialStatus::kDone;
  // No value: undefined in this trial (for example a mean over contact without any contact), or not
  // in the file.
  std::array<std::optional<double>, kMeasureCount> measures;
  // The name of a Strategy, in trials of a plan with strategies; otherwise empty.
  std::string strategy = {};
  // The levels of the plan's other settings (plan.h); a file of people may leave them out.
  std::string view = "turning";
  std::string align = "nearest";
  double start_orientation_deg = 0.0;
  double scale = 1.0;
};

}  // namespace palpate
