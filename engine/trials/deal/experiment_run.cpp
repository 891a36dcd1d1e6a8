#include "engine/trials/deal/experiment_run.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/trials/deal/participant_run.h"
#include "engine/trials/deal/run_identity.h"
#include "engine/trials/deal/traces_folder.h"
#include "engine/trials/trials_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

bool has_traces(const ExperimentPlan& plan, const std::string& traces_folder, int participant) {
  const auto trials = planned_trials(plan, participant);
  return std::all_of(trials.begin(), trials.end(), [&](const PlannedTrial& trial) {
    std::error_code failed;
    return fs::exists(fs::path(traces_folder) / trace_name(plan, participant, trial), failed);
  });
}

// plan, scenes and functions must outlive the result.
DealtRun dealt_experiment(const ExperimentPlan& plan, const std::vector<ExperimentScene>& scenes,
                          const TrialFunctions& functions, const ExperimentRunSettings& settings) {
  const RunIdentity identity = identity_of(plan, scenes);
  const std::string traces =
      settings.writes_traces ? traces_folder_of(settings.out_folder) : std::string();
  DealtRun run;
  run.units = identity.dealt_units(trials_columns(identity.columns()));
  run.identity_json = identity.json();
  run.result_names = result_names(identity.kind);
  run.trials = [&plan](int) { return plan.trials_per_participant(); };
  run.compute = [&, traces](int participant, UnitTrials& trials) {
    return run_participant(plan, scenes, functions, participant, traces, trials);
  };
  if (!traces.empty()) {
    run.has_other_files = [&plan, traces](int participant) {
      return has_traces(plan, traces, participant);
    };
  }
  return run;
}

}  // namespace

Result<ExperimentRunOutcome> run_experiment(const ExperimentPlan& plan,
                                            const ExperimentRunSettings& settings,
                                            const TrialFunctions& functions,
                                            const std::function<void(const RunProgress&)>& progress,
                                            const StopFlag* stop) {
  const auto scenes = load_experiment_scenes(plan, functions);
  if (!scenes) return scenes.error();
  if (auto error = check_persons(plan, scenes->front().setup)) return *error;
  const std::string& folder = settings.out_folder;
  auto done = run_dealt(dealt_experiment(plan, *scenes, functions, settings),
                        {folder, settings.shard, settings.jobs}, progress, stop);
  if (!done) return done.error();
  ExperimentRunOutcome outcome{std::move(*done), std::nullopt, scene_warnings(plan, *scenes)};
  if (settings.shard || !outcome.not_done.empty()) return outcome;
  auto merged = merge_experiment({folder}, folder);
  if (!merged) return merged.error();
  outcome.merged = *merged;
  return outcome;
}

}  // namespace palpate
