#include "engine/trials/sweep/sweep_run.h"

#include <utility>

#include "engine/trials/deal/participant_run.h"
#include "engine/trials/deal/run_identity.h"
#include "engine/trials/key_hash.h"
#include "engine/trials/sweep/sweep_rows.h"
#include "engine/trials/sweep/sweep_scenes.h"
#include "engine/trials/trials_file.h"

namespace palpate {
namespace {

// The hash of a scene's geometry covers all scales.
RunIdentity identity_of_sweep(const Sweep& sweep, const SweepScenes& scenes, std::size_t points) {
  RunIdentity identity = identity_of(sweep.plan, scenes.begin()->second);
  identity.kind = RunKind::kSweep;
  identity.plan_name = sweep.name;
  identity.plan = sweep.hash;
  identity.units = static_cast<int>(points);
  for (auto scale = std::next(scenes.begin()); scale != scenes.end(); ++scale) {
    for (std::size_t i = 0; i < identity.scenes.size(); ++i) {
      std::uint64_t& geometry = identity.scenes[i].geometry;
      geometry = KeyHash().add(geometry).add(scale->second[i].geometry_hash).value();
    }
  }
  return identity;
}

Result<std::optional<UnitRun>> run_point(const Sweep& sweep, int number, const SweepPoint& point,
                                         const SweepScenes& scenes, const TrialFunctions& functions,
                                         UnitTrials& trials) {
  const ExperimentPlan plan = plan_at(sweep, point);
  const TrialFunctions with_device = with_device_of(plan, functions);
  UnitRun run;
  std::string table = trials_columns() + "\n";
  for (int participant = 1; participant <= plan.participants; ++participant) {
    const auto done = run_participant(plan, scenes.at(*point.values[kScale]), with_device,
                                      participant, "", trials);
    if (!done) return done.error();
    if (!*done) return std::optional<UnitRun>();
    table += (*done)->rows;
    run.ticks += (*done)->ticks;
    run.loop_ns += (*done)->loop_ns;
  }
  const auto rows = parse_trials(table, kTrialsFile);
  if (!rows) return rows.error();
  CsvLines lines("");
  lines.clear();
  for (const SweepRow& row : sweep_rows(number, point, *rows, plan.trial.limit_s))
    add_sweep_row(lines, row);
  run.rows = lines.text();
  return std::optional<UnitRun>(std::move(run));
}

// All arguments but the identity must outlive the result.
DealtRun dealt_sweep(const Sweep& sweep, const std::vector<SweepPoint>& points,
                     const SweepScenes& scenes, const TrialFunctions& functions) {
  const RunIdentity identity = identity_of_sweep(sweep, scenes, points.size());
  const auto point_of = [&points](int number) -> const SweepPoint& {
    return points[static_cast<std::size_t>(number) - 1];
  };
  DealtRun run;
  run.units = identity.dealt_units(sweep_columns());
  run.identity_json = identity.json();
  run.result_names = result_names(identity.kind);
  run.trials = [&sweep, point_of](int number) {
    return static_cast<std::uint64_t>(point_of(number).participants) *
           sweep.plan.trials_per_participant();
  };
  run.compute = [&, point_of](int number, UnitTrials& trials) {
    return run_point(sweep, number, point_of(number), scenes, functions, trials);
  };
  return run;
}

}  // namespace

Result<SweepOutcome> run_sweep(const Sweep& sweep, const DealtSettings& settings,
                               const TrialFunctions& functions,
                               const std::function<void(const RunProgress&)>& progress,
                               const StopFlag* stop) {
  const std::vector<SweepPoint> points = sweep_points(sweep);
  const auto scenes = load_sweep_scenes(sweep, points, functions);
  if (!scenes) return scenes.error();
  auto done = run_dealt(dealt_sweep(sweep, points, *scenes, functions), settings, progress, stop);
  if (!done) return done.error();
  return SweepOutcome{std::move(*done), scene_warnings(sweep.plan, scenes->begin()->second)};
}

}  // namespace palpate
