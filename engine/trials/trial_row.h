#pragma once

// One row of trials.csv: the conditions of a trial and what was measured in it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine/trials/levels.h"
#include "palpate/record.h"

namespace palpate {

// The measures of a trial, in the order of their columns (trials_file.h). The measures of the
// faults, one for each of kFaultNames, begin at kFirstFaultMeasure. The measures after
// kMissedDeadlines are only in files of plans with strategies (strategy_measures.h).
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
  kTurningEnergy,
  kDeviceTravel,
  kMeasureCount
};
// How many measures a file without strategies has: the first ones.
inline constexpr std::size_t kPlainMeasureCount = kWallWork;

// What only trials of people have (experiment live), and those of a script in a person's place.
struct LiveColumns {
  int pilot = 0;                        // 1: a trial that `experiment analyse` leaves out
  std::optional<LiveInput> input;       // no value in any member: not in the file
  std::optional<PointerMotion> motion;  // none for a board or a script
  std::optional<CutReason> reason;      // only of trials that were aborted or skipped
  std::optional<int> returns_shown;     // how often the ring showed where to return to
  std::optional<int> clutches;
  std::optional<int> pictures;  // drawn in the trial
  std::optional<double> longest_picture_s;
  std::optional<double> css_px_per_mm;
};

// Its columns are in trials_file.h.
struct TrialRow {
  std::string following;    // a name of kFollowingLevels; empty for a person
  std::string participant;  // "1", "2", ... for simulated operators
  int block = 0;            // 0: practice
  int trial = 0;            // place within the block, 1 for the first
  std::string haptic;       // a name of kHapticLevels; empty: strategy is set
  std::string rotation;     // a name of kRotationLevels; empty: strategy is set
  std::string object;
  int attempt = 1;
  TrialStatus status = TrialStatus::kDone;
  // No value: undefined in this trial (for example a mean over contact without any contact), or not
  // in the file.
  std::array<std::optional<double>, kMeasureCount> measures;
  // The name of a Strategy, in trials of a plan with strategies; otherwise empty.
  std::string strategy = {};
  // The levels of the plan's other settings (plan.h); a file of people may leave them out.
  std::string view{kViewNames.front()};
  std::string align{kAlignmentNames.front()};
  double start_orientation_deg = 0.0;
  double scale = 1.0;
  std::optional<LiveColumns> live = {};
};

}  // namespace palpate
