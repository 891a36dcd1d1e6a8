#pragma once

// Runs whose units are dealt to shards and jobs: the participants of an experiment, the points of a
// sweep.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/report/output_lock.h"
#include "engine/session/stop_flag.h"
#include "engine/trials/deal/unit_part.h"
#include "engine/trials/deal/unit_trials.h"
#include "geometry/base/result.h"

namespace palpate {

inline constexpr int kMostShards = 10'000;
inline constexpr int kMostJobs = 1024;

// Shard i of n has the units i, i + n, i + 2 n and so on.
struct Shard {
  int number = 1;  // 1 to count
  int count = 1;
};
std::vector<int> units_of(const Shard& shard, int units);

// Passed to the caller while trials run.
struct RunProgress {
  double share = 0.0;  // of the trials of the units that were not complete, 0 to 1
  double found = 0.0;  // the part of `share` that an earlier process has finished
};

// The result of a unit.
struct UnitRun {
  std::string rows;          // lines of the results, which depend on the run and the unit only
  std::uint64_t ticks = 0;   // of the trials that were computed
  std::int64_t loop_ns = 0;  // computing time of the haptic loop in these ticks
};

// What is dealt. All functions must be thread-safe for different units.
struct DealtRun {
  DealtUnits units;
  std::string identity_json;              // RunIdentity::json()
  std::vector<std::string> result_names;  // of the files that a merge writes into the folder
  std::function<std::uint64_t(int unit)> trials;
  // Computes a unit: UnitTrials::next() and add() must be called for each trial; if add() returns
  // false, the unit ends without a result.
  std::function<Result<std::optional<UnitRun>>(int unit, UnitTrials& trials)> compute;
  // Optional: whether a unit has all its other files, such as traces. A unit without them is
  // computed again.
  std::function<bool(int unit)> has_other_files = {};
};

struct DealtSettings {
  std::string out_folder;
  std::optional<Shard> shard;  // no value: all units
  int jobs = 1;                // threads; each computes one unit at a time
};

// The numbers of the units, in ascending order.
struct DealtOutcome {
  std::vector<int> computed;
  std::vector<int> kept;      // their parts existed before
  std::vector<int> not_done;  // a stop left them out

  std::uint64_t kept_trials = 0;  // of units that were not complete
  std::uint64_t trials_done = 0;  // of the units that are not done
  // Of the folder and its subfolder `parts`: the caller may write the results there.
  std::vector<OutputLock> locks;
};

// Computes the units for which the folder does not contain a part of this run yet. Each trial is
// kept in the journal of its unit (trial_journal.h) as soon as it ends. After the last trial of a
// unit, its part is written, whole or not at all. A killed run can therefore be started again, and
// goes on where it ended. The file run.log in the folder records the times of day and the computing
// times.
//
// Parts and traces of another run in the folder are removed if the results of that run are there
// too. Otherwise they are an error: they would be lost.
//
// Other processes are kept out of the folder, but for other shards of the same run.
//
// progress: called on the calling thread. stop: may be null; if it is set, running units end after
// their present trial and leave no part. Errors: those of DealtRun::compute, a folder in use, and
// errors of writing. After an error, all finished trials are kept.
Result<DealtOutcome> run_dealt(const DealtRun& run, const DealtSettings& settings,
                               const std::function<void(const RunProgress&)>& progress = {},
                               const StopFlag* stop = nullptr);

}  // namespace palpate
