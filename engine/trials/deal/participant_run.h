#pragma once

// All trials of one simulated participant.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/trials/deal/dealt_run.h"
#include "engine/trials/deal/unit_trials.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"
#include "engine/trials/trial_row.h"
#include "geometry/base/result.h"

namespace palpate {

// The trials of a participant, in the order in which they run: by variant, following, block and the
// order within the block.
struct PlannedTrial {
  PlanVariant variant;
  Following following;
  int block;
  int trial;  // place in the block, 1 for the first
  PlanCondition condition;
};
std::vector<PlannedTrial> planned_trials(const ExperimentPlan& plan, int participant);

// What run_trial() needs for a trial of a simulated participant: its conditions, and the person in
// its block, in which practice makes the hand faster and steadier (ExperimentPlan).
TrialConditions conditions_of(const ExperimentPlan& plan, int participant,
                              const PlannedTrial& trial);
OperatorParameters person_in_block(OperatorParameters person, const ExperimentPlan& plan,
                                   int block);
// The row of its first attempt.
TrialRow row_of(const ExperimentPlan& plan, int participant, const PlannedTrial& trial,
                const TrialOutcome& outcome);

// The path of the trace of a trial below the folder of the traces:
// "delayed/participant-3/block-1-trial-07-UaH-R-O2.csv", or with the name of a strategy in place of
// "UaH-R"; if the plan has several variants, the name ends with the variant:
// "...-O2-still-45deg-x2.csv".
std::string trace_name(const ExperimentPlan& plan, int participant, const PlannedTrial& trial);

// Whether a file of this name, without its folder, may be a trace.
bool is_trace_name(std::string_view file_name);

// Runs the trials; the rows are lines of trials.csv. The result depends on plan, scenes and
// participant only. traces_folder: the folder for the traces of the trials (TraceWriter); missing
// folders are created; empty: no traces. trials: a finished trial is not computed again, unless its
// trace is missing. No value: `trials` has ended the unit. Thread-safe for different participants.
// Errors: those of TrialFunctions::run and of UnitTrials::add(), and errors of writing a trace.
Result<std::optional<UnitRun>> run_participant(const ExperimentPlan& plan,
                                               const std::vector<ExperimentScene>& scenes,
                                               const TrialFunctions& functions, int participant,
                                               const std::string& traces_folder,
                                               UnitTrials& trials);

}  // namespace palpate
