#pragma once

// Runs the canonical protocol: all participants of a plan, or those of a shard.

#include <functional>

#include "engine/session/stop_flag.h"
#include "engine/trials/canonical/canonical_plan.h"
#include "engine/trials/deal/dealt_run.h"
#include "geometry/base/result.h"

namespace palpate {

// run_dealt() with participants as units. The bytes of all results depend only on the plan and its
// operator file, and not on shards, jobs or the number of starts. merge_canonical() makes the
// results when all parts exist.
//
// The noise of the hand has the seed KeyHash("canonical noise", seed of the plan, participant,
// angle_deg, motion, rotation).
//
// Errors: those of run_dealt() and run_canonical_trial(). An error of the
// setting of a device names the key of the plan, and occurs before anything is written.
Result<DealtOutcome> run_canonical(const CanonicalPlan& plan, const DealtSettings& settings,
                                   const std::function<void(const RunProgress&)>& progress = {},
                                   const StopFlag* stop = nullptr);

}  // namespace palpate
